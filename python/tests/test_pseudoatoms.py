"""Atoms that are none are left out by name, and told; they are in nobody's way."""

import pytest
from openmm import app
from openmmchaintree import InputError, createStericExclusionForce
from openmmchaintree.solute import selectSolute
from openmmchaintree.structures.structure import readModels, readStructure
from scenes import GLYCINES, pdbLine, writePDB


def read(path, *lines):
    return readStructure(writePDB(path / "file.pdb", [*GLYCINES, *lines]))


def hetero(number, name, residue, place, element=""):
    return pdbLine(number, name, residue, "X", number, *place, record="HETATM", element="C")[:76] + f"{element:>2}"


@pytest.mark.parametrize(
    ("residue", "atoms"),
    [
        ("DUM", [("N", "N"), ("O", "O")]), ("DUM", [("DUM", "")]), ("MEM", [("THKN", "X"), ("CNTR", ""), ("NORM", "")]),
        ("EMB", [("THKN", ""), ("CNTR", ""), ("NORM", "")]), ("VRT", [("ORIG", "O"), ("X", ""), ("Y", "Y")]),
        ("XXX", [("C1", "C"), ("C2", "C")]),
    ],
)  # fmt: skip
def test_marks(tmp_path, residue, atoms):
    """Of one number, and as near to the chain as if they were bonded."""
    lines = [
        hetero(30, name, residue, (1.95, 1.42, 1.4 + 1.5 * step), element) for step, (name, element) in enumerate(atoms)
    ]
    structure = read(tmp_path, *lines)
    assert structure.topology.getNumAtoms() == 8 and structure.topology.getNumBonds() == 7
    (note,) = structure.notes
    assert note.kind.startswith("dummy atoms left out") and note.items == [f"X:{residue} 30"]


def test_aResidueWithTheNameOfAMark(tmp_path):
    """A residue of a chain, and a ligand, stay."""
    lines = [line.replace("GLY A   2", "XXX A   2") for line in GLYCINES]
    assert readStructure(writePDB(tmp_path / "chain.pdb", lines)).topology.getNumAtoms() == 8
    ligand = [hetero(30, "C1", "MEM", (20, 0, 0), "C"), hetero(30, "C2", "MEM", (21.5, 0, 0), "C")]
    assert read(tmp_path, *ligand).topology.getNumAtoms() == 10


@pytest.mark.parametrize(
    ("name", "element"),
    [("MN1", ""), ("MN2", "MN"), ("MCB1", ""), ("LPA", ""), ("LP1", ""), ("EP1", ""), ("QA", ""), ("VCA", ""),
     ("OVL1", "O"), ("DUM", "")],
)  # fmt: skip
def test_sites(tmp_path, name, element):
    line = pdbLine(9, name, "GLY", "A", 2, 6.0, 1.67, 0.1, element="C")[:76] + f"{element:>2}"
    structure = read(tmp_path, line)
    assert structure.topology.getNumAtoms() == 8
    (note,) = structure.notes
    assert note.kind.startswith("atoms without an element") and note.items == [f"{name} of A:GLY 2"]


def test_drudeParticles(tmp_path):
    """DCA at CA is one; DA, and DO2' alone, are deuterium."""
    drudes = [line[:12] + f" D{line[13:16].strip():<2}" + line[16:76] for line in GLYCINES]
    structure = read(tmp_path, *(line[:6] + f"{20 + n:5}" + line[11:] for n, line in enumerate(drudes)))
    assert structure.topology.getNumAtoms() == 8
    deuterium = pdbLine(9, "DA2", "GLY", "A", 1, 1.8, -0.5, 0.9, element="D")
    assert [atom.element.symbol for atom in read(tmp_path, deuterium).topology.atoms()].count("H") == 1


@pytest.mark.parametrize("name", ["M", "MW", "EPW", "LP1", "IW", "OM"])
def test_sitesOfWater(tmp_path, name):
    water = [
        pdbLine(20, "OW", "SOL", "W", 9, 30, 0, 0), pdbLine(21, "HW1", "SOL", "W", 9, 30.9, 0, 0),
        pdbLine(22, "HW2", "SOL", "W", 9, 29.8, 0.9, 0), pdbLine(23, name, "SOL", "W", 9, 30.1, 0.1, 0)[:76],
    ]  # fmt: skip
    path = writePDB(tmp_path / "water.pdb", [*GLYCINES, *water])
    models = readModels(path)
    for isKept, count in ((False, 8), (True, 11)):
        assert len(selectSolute(path, models.topology, models.positions[0], water=isKept).atoms) == count


@pytest.mark.parametrize("name", ["SOLV", "SPCE", "TIP3", "T4E", "SWM4", "H2O", "FB4"])
def test_namesOfWater(tmp_path, name):
    line = f"ATOM     20  OW  {name:<4} {9:>4}      30.000   0.000   0.000"
    structure = read(tmp_path, line, line.replace("OW ", "HW1").replace("30.000", "30.960"))
    assert structure.topology.getNumAtoms() == 8


def test_aLipidWithTheNameOfWater(tmp_path):
    """OPC is a model of water in AMBER, and a lipid in the Protein Data Bank."""
    lines = [hetero(30, "C1", "OPC", (20, 0, 0), "C"), hetero(30, "O1", "OPC", (21.4, 0, 0), "O")]
    assert read(tmp_path, *lines).topology.getNumAtoms() == 10


def test_unknownAtomsAreNamed(tmp_path):
    lines = [pdbLine(20 + n, f"X{n}", "GLY", "A", 2, 6 + n, 0, 3, element="C")[:76] for n in range(5)]
    with pytest.raises(
        InputError, match=r"not known \(5\): X0 of A:GLY 2; X1 of A:GLY 2; X2 of A:GLY 2; and 2 more: gi"
    ):
        read(tmp_path, *lines)


def test_theHelperModelsNoMarks(tmp_path):
    """Neither bonds nor radii: the Topology is a user's."""
    lines = [*GLYCINES, *(hetero(30, name, "DUM", (1.95, 1.42, 1.4), name) for name in "NO")]
    pdb = app.PDBFile(str(writePDB(tmp_path / "marked.pdb", lines)))
    force = createStericExclusionForce(pdb.topology, pdb.positions)
    radii = [force.getParticleParameters(i)[0]._value for i in range(force.getNumParticles())]
    assert radii[8:] == [0, 0] and min(radii[:8]) > 0 and force.getNumBonds() == 7
