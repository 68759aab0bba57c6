"""--add-hydrogens adds the hydrogens of the force field to caps, rings and D-amino acids."""

import numpy as np
import pytest
from openmm import app
from openmmchaintree.command.energymodel import EnergyModel
from openmmchaintree.command.hydrogens import addHydrogens
from openmmchaintree.structures.structure import readStructure
from peptides import energyOf, linesOf, makePeptides, withHydrogens
from scenes import pdbLine, writePDB

FILES = ("amber14/protein.ff14SB.xml", "implicit/gbn2.xml")


@pytest.fixture(scope="module")
def model():
    return EnergyModel(FILES, 300, hydrogensAreAdded=True)


@pytest.fixture
def addTo(model, tmp_path):
    """A function that adds hydrogens to a structure; it returns its Topology and positions, and U."""

    def add(lines):
        structure = readStructure(writePDB(tmp_path / "bare.pdb", lines))
        whole, _ = addHydrogens(structure, 7, 1)
        return whole.topology, whole.positions, energyOf(model.makeSystem(whole)[0], whole.positions)

    return add


def hydrogensOn(topology):
    """Return the number of hydrogens of each residue."""
    return [sum(atom.element is app.element.hydrogen for atom in residue.atoms()) for residue in topology.residues()]


@pytest.mark.parametrize(
    "names",
    [
        {},
        {("NME", "C"): "CH3"},
        {("ACE", "C"): "CY", ("ACE", "CH3"): "CAY", ("ACE", "O"): "OY", ("NME", "N"): "NT", ("NME", "C"): "CAT"},
    ],
    ids=["PDB", "AMBER", "CHARMM"],
)
def test_caps(addTo, names):
    """As many as Modeller alone adds."""
    topology, positions = makePeptides(("ACE", "ALA", "PRO", "NME"))
    lines = linesOf(
        topology,
        positions,
        lambda atom: (names.get((atom.residue.name, atom.name), atom.name), atom.residue.name, atom.residue.index + 1),
    )
    whole, places, energy = addTo(lines)
    assert hydrogensOn(whole) == hydrogensOn(withHydrogens(topology, positions)[0]) == [3, 5, 7, 4]
    assert energy == pytest.approx(energyOf(app.ForceField(*FILES).createSystem(whole), places), abs=1e-3)


@pytest.mark.parametrize("name", ["NH2", "NHE"])
def test_amides(addTo, name):
    """The other oxygen of the end stands where the nitrogen of the cap is."""
    topology, positions = makePeptides(("ALA", "GLY"))
    oxygen = next(atom for atom in topology.atoms() if atom.name == "OXT")
    oxygen.element = app.element.nitrogen
    lines = linesOf(
        topology,
        positions,
        lambda atom: ("N", name, 3) if atom is oxygen else (atom.name, atom.residue.name, atom.residue.index + 1),
    )
    assert hydrogensOn(addTo(lines)[0]) == [7, 3, 2]


def test_ring(addTo):
    """Of glycine and glycine: neither is an end."""
    lines = []
    for number in (1, 2):
        for place, name in enumerate(("N", "CA", "C")):
            angle = np.pi / 3 * (place + 3 * number)
            x, y = 1.42 * np.cos(angle), 1.42 * np.sin(angle)
            lines.append(pdbLine(len(lines) + 1, name, "GLY", "A", number, x, y, 0.0))
        lines.append(pdbLine(len(lines) + 1, "O", "GLY", "A", number, 1.87 * x, 1.87 * y, 0.0))
    assert hydrogensOn(addTo(lines)[0]) == [3, 3]


def _chirality(topology, positions):
    """Return for each Cα and each Cβ of a threonine on which side its neighbours lie."""
    signs = []
    for residue in topology.residues():
        places = {atom.name: positions[atom.index] for atom in residue.atoms()}
        for center, others in (("CA", ("N", "C", "CB")), ("CB", ("CA", "OG1", "CG2"))):
            if all(name in places for name in (center, *others)):
                vectors = [places[other] - places[center] for other in others]
                signs.append(np.sign(np.linalg.det(vectors)))
    return signs


def test_mirroredAminoAcids(addTo):
    """They have the force field, and GBn2's radii, of the residues whose mirror images they are."""
    names = ("DAL", "DAR", "DTH", "DHI", "DSG", "DPR", "DCY")
    usual = ("ALA", "ARG", "THR", "HIS", "ASN", "PRO", "CYS")
    topology, positions = makePeptides(("ACE", *names, "NME"))
    whole, places, energy = addTo(linesOf(topology, positions))
    assert [residue.name for residue in whole.residues()] == ["ACE", *names, "NME"]
    expected = withHydrogens(*makePeptides(("ACE", *usual, "NME")))[0]
    assert hydrogensOn(whole) == hydrogensOn(expected)
    assert _chirality(whole, places) == _chirality(topology, positions)
    for residue, name in zip(whole.residues(), ("ACE", *usual, "NME"), strict=True):
        residue.name = name
    assert energy == pytest.approx(energyOf(app.ForceField(*FILES).createSystem(whole), places), abs=1e-3)


def test_mapsAreNotMirrored(tmp_path):
    """A force field with CMAP has it for L-amino acids alone: a note says so."""
    model = EnergyModel(("amber19/protein.ff19SB.xml",), 300)
    for names, isNoted in ((("ACE", "DAL", "NME"), True), (("ACE", "ALA", "NME"), False)):
        structure = readStructure(writePDB(tmp_path / "bare.pdb", linesOf(*makePeptides(names))))
        _, notes = model.makeSystem(addHydrogens(structure, 7, 1)[0])
        assert any("(CMAP) take for L-amino acids (1): A:DAL 2" in str(note) for note in notes) == isNoted
