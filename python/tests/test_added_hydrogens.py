"""Hydrogens that --add-hydrogens adds to caps, rings and D-amino acids: those that the force field wants."""

import json

import numpy as np
import openmm
import pytest
from openmm import app, unit
from peptides import linesOf, makePeptides, withHydrogens
from scenes import pdbLine, writePDB

FILES = ("amber14/protein.ff14SB.xml", "implicit/gbn2.xml")


@pytest.fixture
def sampleWithHydrogens(runCommandHere, tmp_path):
    """A function that adds hydrogens to a structure and samples; it returns the PDBFile written, and U at the start."""

    def sample(lines, *options):
        structure = writePDB(tmp_path / "bare.pdb", lines)
        options = ("--add-hydrogens", "--forcefield", *FILES, "--trials", 10, "--frames", 1, "--seed", 1, *options)
        result = runCommandHere("sample", structure, *options, "--json", "summary.json")
        assert result.returncode == 0, result.stderr
        summary = json.loads((tmp_path / "summary.json").read_text())
        return app.PDBFile(str(tmp_path / "bare-topology.pdb")), summary["energy"]["potentialEnergy"]["first"]

    return sample


def hydrogensOn(topology):
    """Return the number of hydrogens of each residue."""
    return [sum(atom.element is app.element.hydrogen for atom in residue.atoms()) for residue in topology.residues()]


def energyByOpenMM(topology, positions):
    system = app.ForceField(*FILES).createSystem(topology)
    context = openmm.Context(system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(positions)
    return context.getState(energy=True).getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)


@pytest.mark.parametrize(
    "names",
    [
        {},
        {("NME", "C"): "CH3"},
        {("ACE", "C"): "CY", ("ACE", "CH3"): "CAY", ("ACE", "O"): "OY", ("NME", "N"): "NT", ("NME", "C"): "CAT"},
    ],
    ids=["PDB", "AMBER", "CHARMM"],
)
def test_caps(sampleWithHydrogens, names):
    """As many as Modeller alone adds."""
    topology, positions = makePeptides(("ACE", "ALA", "PRO", "NME"))
    lines = linesOf(
        topology,
        positions,
        lambda atom: (names.get((atom.residue.name, atom.name), atom.name), atom.residue.name, atom.residue.index + 1),
    )
    pdb, energy = sampleWithHydrogens(lines)
    assert hydrogensOn(pdb.topology) == hydrogensOn(withHydrogens(topology, positions)[0]) == [3, 5, 7, 4]
    assert energy == pytest.approx(energyByOpenMM(pdb.topology, pdb.positions), abs=0.5)


@pytest.mark.parametrize("name", ["NH2", "NHE"])
def test_amides(sampleWithHydrogens, name):
    """The other oxygen of the end stands where the nitrogen of the cap is."""
    topology, positions = makePeptides(("ALA", "GLY"))
    oxygen = next(atom for atom in topology.atoms() if atom.name == "OXT")
    oxygen.element = app.element.nitrogen
    lines = linesOf(
        topology,
        positions,
        lambda atom: ("N", name, 3) if atom is oxygen else (atom.name, atom.residue.name, atom.residue.index + 1),
    )
    pdb, _ = sampleWithHydrogens(lines)
    assert hydrogensOn(pdb.topology) == [7, 3, 2]


def test_ring(sampleWithHydrogens):
    """Of glycine and glycine: neither is an end."""
    lines = []
    for number in (1, 2):
        for place, name in enumerate(("N", "CA", "C")):
            angle = np.pi / 3 * (place + 3 * number)
            x, y = 1.42 * np.cos(angle), 1.42 * np.sin(angle)
            lines.append(pdbLine(len(lines) + 1, name, "GLY", "A", number, x, y, 0.0))
        lines.append(pdbLine(len(lines) + 1, "O", "GLY", "A", number, 1.87 * x, 1.87 * y, 0.0))
    pdb, _ = sampleWithHydrogens(lines, "--rigid-bodies")
    assert hydrogensOn(pdb.topology) == [3, 3]


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


def test_mirroredAminoAcids(sampleWithHydrogens):
    """They have the force field, and GBn2's radii, of the residues whose mirror images they are."""
    names = ("DAL", "DAR", "DTH", "DHI", "DSG", "DPR", "DCY")
    usual = ("ALA", "ARG", "THR", "HIS", "ASN", "PRO", "CYS")
    topology, positions = makePeptides(("ACE", *names, "NME"))
    pdb, energy = sampleWithHydrogens(linesOf(topology, positions))
    residues = list(pdb.topology.residues())
    # A nucleotide is called DCY in OpenMM's tables.
    assert [residue.name for residue in residues[1:-2]] == list(names[:-1])
    expected = withHydrogens(*makePeptides(("ACE", *usual, "NME")))[0]
    assert hydrogensOn(pdb.topology) == hydrogensOn(expected)
    places = np.array(pdb.positions.value_in_unit(unit.nanometer))
    assert _chirality(pdb.topology, places) == _chirality(topology, positions)
    for residue, name in zip(residues, ("ACE", *usual, "NME"), strict=True):
        residue.name = name
    pdb.topology.createStandardBonds()  # for what DCY is not
    assert energy == pytest.approx(energyByOpenMM(pdb.topology, pdb.positions), abs=0.5)


def test_mapsAreNotMirrored(runCommandHere, tmp_path):
    """A force field with CMAP has it for L-amino acids alone: a note says so."""
    for names, isNoted in ((("ACE", "DAL", "NME"), True), (("ACE", "ALA", "NME"), False)):
        writePDB(tmp_path / "bare.pdb", linesOf(*makePeptides(names)))
        options = ("--add-hydrogens", "--forcefield", "amber19/protein.ff19SB.xml", "--trials", 10, "--overwrite")
        result = runCommandHere("sample", "bare.pdb", *options)
        assert result.returncode == 0, result.stderr
        assert ("(CMAP) take for L-amino acids (1): A:DAL 2" in result.stdout) == isNoted
