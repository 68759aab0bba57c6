"""Hydrogens by the names of many conventions: a force field gives the energy that it gives with those of today."""

from collections import defaultdict

import numpy as np
import pytest
from openmm import app
from openmmchaintree import findTorsions
from openmmchaintree.command.energymodel import EnergyModel
from openmmchaintree.command.hydrogens import addHydrogens
from openmmchaintree.solute import subset
from openmmchaintree.structures.structure import readStructure, withoutAtoms
from peptides import energyOf, makePeptides, withHydrogens
from scenes import HEAVY_ATOMS, pdbLine, realStructurePath, writePDB

FILES = ("amber14/protein.ff14SB.xml", "implicit/gbn2.xml")
_ACIDS = sorted(HEAVY_ATOMS)


def _pairsFromOne(names):
    """HB2 and HB3 of a CH2 become HB1 and HB2."""
    isPair = len(names) == 2 and [name[-1] for name in names] == ["2", "3"]
    return [f"{name[:-1]}{int(name[-1]) - 1}" for name in names] if isPair else names


def _digitFirst(names):
    """HB2 and HB3 become 1HB and 2HB; HH11 and HH12 become 1HH1 and 2HH1."""
    return names if len(names) == 1 else [f"{number}{name[:-1]}" for number, name in enumerate(names, start=1)]


def _wrapped(names):
    """HH11 becomes 1HH1: names of four letters have their last one in the first column."""
    return [f"{name[-1]}{name[:-1]}" if len(name) == 4 else name for name in names]


class Convention:
    """How a program calls hydrogens, as far as it differs from today's PDB.

    rename : a function of the names of the hydrogens of one atom; others : by residue ("" all, "N" at the N-terminus),
    names of atoms; histidine : str; hasElements : bool, whether it writes the columns of elements
    """

    def __init__(self, rename, others, histidine="HIS", hasElements=True):
        self.rename = rename
        self.others = others
        self.histidine = histidine
        self.hasElements = hasElements


_IONS = {"H": "H1"}
_ILE = {"CD1": "CD", "HD11": "HD1", "HD12": "HD2", "HD13": "HD3"}
CONVENTIONS = {
    "PDB v3": Convention(list, {"N": _IONS}),
    "PDB v2": Convention(_digitFirst, {"N": {"H1": "1H"}}, hasElements=False),
    "AMBER": Convention(_wrapped, {"N": _IONS}, "HIE", hasElements=False),
    "CHARMM": Convention(
        _pairsFromOne,
        {
            "": {"H": "HN", "OXT": "OT2"},
            "N": {"H": "HT1", "H2": "HT2", "H3": "HT3"},
            "ILE": _ILE,
            "SER": {"HG": "HG1"},
            "CYS": {"HG": "HG1"},
        },
        "HSE",
        hasElements=False,
    ),
    "GROMACS": Convention(_pairsFromOne, {"": {"OXT": "O2"}, "N": _IONS, "ILE": _ILE}, "HISE"),
    "Rosetta": Convention(_digitFirst, {"N": {"H1": "1H"}}),
    "numbers": Convention(list, {}),
}


def _namesOf(residue, convention):
    """Return the names of the atoms of a residue by a convention, as a dictionary."""
    groups = defaultdict(list)
    for bond in residue.bonds():
        for atom, other in (bond, bond[::-1]):
            if other.element is app.element.hydrogen:
                groups[atom].append(other)
    isFirst = residue is next(residue.chain.residues()) and residue.name not in ("ACE", "NME")
    others = dict(convention.others.get("", {})) | convention.others.get(residue.name, {})
    others |= convention.others.get("N", {}) if isFirst else {}
    names = {atom: atom.name for atom in residue.atoms()}
    if residue.name not in ("ACE", "NME"):
        for hydrogens in groups.values():
            today = ["H1" if atom.name == "H" and isFirst else atom.name for atom in hydrogens]
            names.update(zip(hydrogens, convention.rename(today), strict=True))
        names = {atom: others.get(atom.name, name) for atom, name in names.items()}
    if convention is CONVENTIONS["numbers"]:
        hydrogens = [atom for atom in names if atom.element is app.element.hydrogen]
        names.update((atom, f"H{number}") for number, atom in enumerate(hydrogens, start=1))
    return names


def writeNamed(path, topology, positions, convention):
    """Write a structure with the names of a convention."""
    lines = []
    for residue in topology.residues():
        names = _namesOf(residue, convention)
        name = convention.histidine if residue.name == "HIS" else residue.name
        for atom in residue.atoms():
            place = 10 * positions[atom.index]
            line = pdbLine(atom.index + 1, names[atom], name[:3], residue.chain.id, residue.index + 1, *place)
            line = line[:17] + f"{name:<4}" + line[21:] if len(name) == 4 else line
            lines.append(line if convention.hasElements else line[:66])
    return writePDB(path, lines)


@pytest.fixture(scope="module")
def model():
    return EnergyModel(FILES, 300)


@pytest.fixture(scope="module")
def peptides():
    """A function that returns peptides of an amino acid, capped and with ends, and their U by OpenMM alone."""
    forceField = app.ForceField(*FILES)
    made = {}

    def make(name):
        if name not in made:
            topology, positions = withHydrogens(*makePeptides(("ACE", name, "NME"), (name, name)))
            positions = np.round(positions, 4)  # as in a PDB file
            made[name] = topology, positions, energyOf(forceField.createSystem(topology), positions)
        return made[name]

    return make


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("name", _ACIDS)
def test_namesDoNotChangeTheEnergy(model, peptides, tmp_path, name, convention):
    topology, positions, expected = peptides(name)
    structure = readStructure(writeNamed(tmp_path / "named.pdb", topology, positions, CONVENTIONS[convention]))
    system, _ = model.makeSystem(structure)
    assert energyOf(system, structure.positions) == pytest.approx(expected, abs=1e-3, rel=1e-9)


@pytest.mark.parametrize(
    "names", [("T", "T", "C"), ("THY", "THY", "CYT"), ("DT5", "DT", "DC3")], ids=["PDB v2", "CHARMM", "AMBER"]
)
def test_nucleotides(tmp_path, names):
    """GBn2 goes by the names of residues; hydrogens have their digit in front here, and * for a prime."""
    files = ("amber14/DNA.OL15.xml", "implicit/gbn2.xml")
    source = readStructure(realStructurePath("1bna.pdb"))
    chosen = list(next(source.topology.chains()).residues())[6:9]
    atoms = [atom for residue in chosen for atom in residue.atoms()]
    atoms = [atom for atom in atoms if atom.residue is not chosen[0] or atom.name not in ("P", "OP1", "OP2")]
    positions = source.positions[[atom.index for atom in atoms]]
    topology, positions = withHydrogens(subset(source.topology, atoms), positions)
    old, lines = {"H5'": "1H5*", "H5''": "2H5*", "H2'": "1H2*", "H2''": "2H2*"}, []
    for atom in topology.atoms():
        name = old.get(atom.name, atom.name.replace("'", "*"))
        place, residue = 10 * positions[atom.index], atom.residue
        lines.append(pdbLine(atom.index + 1, name, names[residue.index], "A", residue.index + 1, *place)[:66])
    structure = readStructure(writePDB(tmp_path / "old.pdb", lines))
    system, _ = EnergyModel(files, 300).makeSystem(structure)
    expected = energyOf(app.ForceField(*files).createSystem(topology), structure.positions)
    assert tuple(residue.name for residue in structure.topology.residues()) == names
    kinds = [[torsion.kind for torsion in findTorsions(one).torsions] for one in (topology, structure.topology)]
    assert kinds[0] == kinds[1] and "chi" in kinds[0]
    bare = withoutAtoms(structure, np.array([a.index for a in structure.topology.atoms() if a.element.symbol == "H"]))
    assert addHydrogens(bare, 7, 1)[0].topology.getNumAtoms() == topology.getNumAtoms()
    assert energyOf(system, structure.positions) == pytest.approx(expected, abs=1e-3)
