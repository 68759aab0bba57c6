"""The elements of atoms, by residue and column, whatever programs write."""

import gemmi
import pytest
from openmmchaintree.structures.elements import findElements
from openmmchaintree.structures.structure import readModels
from scenes import GLYCINES, pdbLine, writePDB


def elementsOf(residue, *atoms):
    """Return the elements of the atoms of a residue beside a glycine, each given as its columns and its element."""
    kinds = [(residue, column, given) for column, given in atoms]
    others = {("GLY", f" {name:<3}", name[0]) for name in ("N", "CA", "C", "O")}
    found = findElements({*kinds, *others})
    return [found[kind].capitalize() for kind in kinds]


@pytest.mark.parametrize("given", ["CA", "C", "", "N", "1+", "ca"])
def test_alphaCarbon(given):
    for residue in ("ALA", "HIE", "MSE", "NALA"):
        assert elementsOf(residue, (" CA ", given), (" N  ", "N"), (" C  ", "C")) == ["C", "N", "C"]


@pytest.mark.parametrize(
    ("residue", "column", "given", "element"),
    [
        ("CA", "CA  ", "CA", "Ca"), ("CA", " CA ", "", "Ca"), ("CA", "CA  ", "C", "Ca"), ("CAL", "CAL ", "", "Ca"),
        ("CD", "CD  ", "", "Cd"), ("CE", " CE ", "", "Ce"), ("HG", "HG  ", "H", "Hg"), ("ZN", "ZN  ", "Z", "Zn"),
        ("SOD", "SOD ", "", "Na"), ("NA+", "NA+ ", "", "Na"), ("CLA", "CLA ", "C", "Cl"), ("POT", " POT", "", "K"),
        ("FE2", "FE  ", "FE", "Fe"), ("3CO", "CO  ", "CO", "Co"), ("IOD", " I  ", "I", "I"), ("OS", "OS  ", "", "Os"),
    ],
)  # fmt: skip
def test_ions(residue, column, given, element):
    assert elementsOf(residue, (column, given)) == [element]


@pytest.mark.parametrize("given", [True, False])
def test_metalsInLargerResidues(given):
    """Names of nitrogens are those of sodium and niobium; that of iron is one of fluorine, cut off."""
    heme = [("FE  ", "FE"), (" NA ", "N"), (" NB ", "N"), (" CHA", "C"), (" HHA", "H")]
    found = elementsOf("HEM", *((column, symbol if given else "") for column, symbol in heme))
    assert found == ["Fe", "N", "N", "C", "H"]
    assert elementsOf("HEM", ("FE  ", "F"), (" NA ", "NA")) == ["Fe", "N"]
    assert elementsOf("CLA", ("MG  ", ""), (" NA ", ""), (" CMA", "")) == ["Mg", "N", "C"]
    assert elementsOf("MSE", ("SE  ", "S"), (" CE ", "CE"), ("SE  ", "")) == ["Se", "C", "Se"]
    assert elementsOf("CMH", (" SG ", "S"), ("HG  ", "HG"), (" CM ", "C")) == ["S", "Hg", "C"]
    assert elementsOf("CYS", (" SG ", "SG"), (" HG ", "HG"), ("HG  ", "")) == ["S", "H", "H"]


def test_namesOfFourLetters():
    atoms = [("CME1", ""), ("HG11", ""), ("CL12", ""), ("NE21", ""), ("CDX1", ""), ("OS12", "")]
    assert elementsOf("LIG", *atoms) == ["C", "H", "Cl", "N", "C", "O"]


def test_unknownResidues():
    """In columns as they should be, two letters are a metal in the first of them, and not in the second."""
    assert elementsOf("LIG", (" CA ", "CA"), (" CD ", ""), ("CD  ", ""), (" NE ", "NE")) == ["C", "C", "Cd", "N"]
    assert elementsOf("XAA", ("CA  ", "CA"), ("N   ", "N"), ("C   ", "C")) == ["C", "N", "C"]


def test_theFileIsBelievedElsewhere():
    assert elementsOf("LIG", (" X1 ", "C"), (" A2 ", "N"), ("PT1 ", "PT"), (" CO ", "CO")) == ["C", "N", "Pt", "Co"]


@pytest.mark.parametrize("kind", ["pdb", "cif"])
def test_files(tmp_path, kind):
    """Two atoms with possible elements in the file, and one with an impossible element."""
    calcium = pdbLine(9, "CA", "CA", "A", 3, 30, 0, 0, record="HETATM", element="CA")
    lines = [line[:77].rstrip() + "CA" if "CA  GLY A   2" in line else line for line in [*GLYCINES, calcium]]
    path = writePDB(tmp_path / "calcium.pdb", lines)
    if kind == "cif":
        structure = gemmi.read_structure(str(path))
        structure.setup_entities()
        path = tmp_path / "calcium.cif"
        structure.make_mmcif_document().write_file(str(path))
        assert path.read_text().count(" CA ") >= 2
    symbols = [atom.element.symbol for atom in readModels(path).topology.atoms()]
    assert symbols == ["N", "C", "C", "O", "N", "C", "C", "O", "Ca"]
