"""Bonds from templates, the file's links, polymer links and distances: no molecule is in more parts than it is."""

import numpy as np
import pytest
from openmm import app
from openmmchaintree import InputError, findClashes
from openmmchaintree.bonds import BondGraph
from openmmchaintree.command.plan import Choice, Plan
from openmmchaintree.graphs import connectedParts
from openmmchaintree.structures.structure import readStructure
from scenes import GLYCINES, bondNames, pdbLine, realStructurePath, writePDB

_LINK = "LINK         O   GLY A   1                 C1  XYZ B   1     1555 {:>6}  1.50"
_CELL = "CRYST1   50.000   50.000   50.000  90.00  90.00  90.00 P 1"


def read(path, *lines):
    return readStructure(writePDB(path / "bonds.pdb", lines))


def partsOf(topology):
    graph = BondGraph(topology)
    return max(connectedParts(len(graph.atoms), graph.bonds)) + 1


def renumbered(lines, *numbers):
    """GLYCINES with other residue numbers."""
    return [line[:22] + f"{numbers[int(line[22:26]) - 1]:>4}" + line[26:] for line in lines]


# ---- Along the chain ----


@pytest.mark.parametrize("numbers", [(1, 2), (1, 9), (9, 1), (-1, 1)])
def test_numberingMayJump(tmp_path, numbers):
    assert partsOf(read(tmp_path, *renumbered(GLYCINES, *numbers)).topology) == 1


def test_gapsBeforeAJump(tmp_path):
    """0.3 nm is a bond between consecutive residues, if a bad one, and none where the numbers jump."""
    stretched = [line[:30] + f"{float(line[30:38]) + 1.7:8.3f}" + line[38:] for line in GLYCINES[4:]]
    for numbers, parts in (((1, 2), 1), ((1, 7), 2)):
        structure = read(tmp_path, *renumbered([*GLYCINES[:4], *stretched], *numbers))
        assert partsOf(structure.topology) == parts
        assert [note.kind for note in structure.notes] == ["gaps in the chain"] * (parts - 1)


def test_selenomethionineInTheChain():
    """Its bonds to the neighbours are in the file, its own are in the dictionary."""
    structure = readStructure(realStructurePath("hard/1A8O.cif.gz"))
    assert partsOf(structure.topology) == 1
    names = bondNames(structure.topology)
    for number in ("151", "185", "214", "215"):
        assert (f"{number} CE", f"{number} SE") in names and (f"{number} CA", f"{number} N") in names


@pytest.mark.parametrize("name", ["MSE", "XXX"])
def test_unknownResidueInTheChain(tmp_path, name):
    """By the dictionary, or, if that does not know it, by distance; hydrogens to the nearest atom alone."""
    added = [
        pdbLine(20, "H1", name, "A", 1, -0.5, 0.87, 0, element="H"),
        pdbLine(21, "XH", name, "A", 1, -0.5, -0.87, 0, element="H"),
    ]
    lines = [line.replace("GLY A   1", f"{name} A   1") for line in GLYCINES]
    structure = read(tmp_path, *lines[:4], *added, *lines[4:])
    assert partsOf(structure.topology) == 1
    hydrogens = [bond for bond in bondNames(structure.topology) if "1 H1" in bond or "1 XH" in bond]
    assert hydrogens == [("1 H1", "1 N"), ("1 N", "1 XH")]


def test_namesOfOtherPrograms(tmp_path):
    lines = [line.replace(" O   GLY A   2", " OT1 GLY A   2") for line in GLYCINES]
    last = pdbLine(9, "OT2", "GLY", "A", 2, 6.0, 3.85, 0)
    hydrogen = pdbLine(10, "HN", "GLY", "A", 2, 3.9, 0.8, 0)
    assert ("2 C", "2 OT2") in bondNames(read(tmp_path, *lines, last, hydrogen).topology)
    assert partsOf(read(tmp_path, *lines, last, hydrogen).topology) == 1


def test_macrocycle():
    structure = readStructure(realStructurePath("hard/2n0n_M1.pdb.gz"))
    assert partsOf(structure.topology) == 1


# ---- Bonds of files ----


def test_glycans():
    """The same glycoprotein: bonds to sugars are in _struct_conn and in CONECT."""
    fromPDB, fromMmCIF = (readStructure(realStructurePath(f"hard/1igy.{kind}.gz")) for kind in ("pdb", "cif"))
    assert partsOf(fromPDB.topology) == partsOf(fromMmCIF.topology) == 1
    for structure in (fromPDB, fromMmCIF):
        asparagines = [bond for bond in structure.topology.bonds() if {atom.name for atom in bond} == {"ND2", "C1"}]
        assert len(asparagines) == 2


_LIGAND = [
    pdbLine(9, "C1", "XYZ", "B", 1, 3.0, 9.0, 0, record="HETATM"),
    pdbLine(10, "C2", "XYZ", "B", 1, 4.5, 9.0, 0, record="HETATM"),
]


def test_linksOfTheFile(tmp_path):
    near = [line[:38] + f"{3.85:8.3f}" + line[46:] for line in _LIGAND]  # 2.3 Å from the oxygen: too far to be bonded
    assert partsOf(read(tmp_path, *GLYCINES, *near).topology) == 2
    assert partsOf(read(tmp_path, _LINK.format("1555"), *GLYCINES, *near).topology) == 1
    conect = "CONECT    4    9"
    assert partsOf(read(tmp_path, *GLYCINES, *near, conect).topology) == 1
    assert partsOf(read(tmp_path, _CELL, _LINK.format("1655"), *GLYCINES, *near).topology) == 2  # to a mate


def test_bondOfTheFileThatCannotBe(tmp_path):
    structure = read(tmp_path, *GLYCINES, *_LIGAND, "CONECT    4    9")
    assert partsOf(structure.topology) == 2
    (note,) = structure.notes
    assert note.kind == "bonds of the file that are too long, and left out"
    assert note.items == ["A:GLY 1 O – B:XYZ 1 C1, 0.686 nm"]


# ---- By distance ----


def at(x, y):
    """The ligand with C1 at (x, y)."""
    return [line[:30] + f"{float(line[30:38]) + x - 3.0:8.3f}{y:8.3f}" + line[46:] for line in _LIGAND]


def test_boundLigand(tmp_path):
    """As a glycan without its LINK: 1.45 Å from the last carbon of the chain, at an angle of bonds."""
    structure = read(tmp_path, *GLYCINES, *at(6.2, 3.95))
    assert partsOf(structure.topology) == 1
    assert [note.kind for note in structure.notes] == ["other bonds found by distance"]


@pytest.mark.parametrize("place", [(5.3, 1.3), (5.71, 2.21)])
def test_clashIsNoBond(tmp_path, place):
    """Between the carbon and its oxygen."""
    assert partsOf(read(tmp_path, *GLYCINES, *at(*place)).topology) == 2


def test_disulfideByDistance(tmp_path):
    sulfurs = [
        pdbLine(20, "CB", "CYS", "B", 1, 30.0, 0, 0), pdbLine(21, "SG", "CYS", "B", 1, 31.8, 0, 0),
        pdbLine(22, "SG", "CYS", "B", 5, 31.8, 2.3, 0), pdbLine(23, "CB", "CYS", "B", 5, 30.0, 2.3, 0),
    ]  # fmt: skip
    assert ("1 SG", "5 SG") in bondNames(read(tmp_path, *GLYCINES, *sulfurs).topology)
    reduced = [*sulfurs, pdbLine(24, "HG", "CYS", "B", 5, 32.4, 3.5, 0)]
    assert ("1 SG", "5 SG") not in bondNames(read(tmp_path, *GLYCINES, *reduced).topology)


def test_metals(tmp_path):
    """Zinc is bound by what is near, sodium and what lies farther are not; water binds nothing."""
    zinc = pdbLine(20, "ZN", "ZN", "A", 9, 0.0, 3.9, 0.0, record="HETATM", element="ZN")
    water = pdbLine(21, "O", "HOH", "A", 10, -1.5, 5.2, 0.0, record="HETATM")
    structure = read(tmp_path, *GLYCINES, zinc, water)
    assert ("1 O", "9 ZN") in bondNames(structure.topology)
    assert structure.topology.getNumAtoms() == 9
    assert [note.kind for note in structure.notes] == ["bonds of metals found by distance"]
    graph = BondGraph(structure.topology, structure.positions, cutMetals=True)
    assert graph.cut == graph.metalBonds == [(3, 8)] and max(connectedParts(len(graph.atoms), graph.bonds)) == 1
    for other in (zinc.replace("ZN", "NA"), zinc[:38] + f"{7.9:8.3f}" + zinc[46:]):
        structure = read(tmp_path, *GLYCINES, other)
        assert structure.topology.getNumAtoms() == 8
        assert [note.kind for note in structure.notes] == ["ions left out, since nothing binds them"]


def test_hemeIsBoundToHistidine():
    structure = readStructure(realStructurePath("4hhb.pdb"))
    irons = [bond for bond in structure.topology.bonds() if {atom.name for atom in bond} == {"FE", "NE2"}]
    assert len(irons) == 4
    assert partsOf(structure.topology) == 4


def test_heavyWater():
    structure = readStructure(realStructurePath("hard/5PTI.cif.gz"))
    assert {atom.residue.name for atom in structure.topology.atoms()}.isdisjoint({"DOD", "HOH"})
    assert partsOf(structure.topology) == 2  # the protein and a phosphate


def test_aResidueThatHoldsEverything(tmp_path):
    """Programs that know no residues: a chain of 3,000 carbons under one number."""
    count = 3000
    topology = app.Topology()
    residue = topology.addResidue("UNL", topology.addChain())
    for number in range(count):
        topology.addAtom(f"C{number}", app.Element.getBySymbol("C"), residue)
    positions = np.column_stack([0.125 * np.arange(count), 0.04 * (np.arange(count) % 2) * 2, np.zeros(count)])
    graph = BondGraph(topology, positions)
    assert graph.bonds == [(number, number + 1) for number in range(count - 1)]


def test_metalOfWhichTheFileTellsTooLittle(tmp_path):
    """A zinc with a LINK to one nitrogen, as near to an oxygen."""
    zinc = pdbLine(20, "ZN", "ZN", "A", 9, 0.4, 4.2, 0.0, record="HETATM", element="ZN")
    link = "LINK         N   GLY A   2                ZN    ZN A   9     1555   1555  3.90"
    names = bondNames(read(tmp_path, link, *GLYCINES, zinc).topology)
    assert {("1 O", "9 ZN"), ("2 N", "9 ZN")} <= set(names)


def test_linksThatOrderAndNumbersDoNotTell(tmp_path):
    """Residues of one number in any order: the near ends are linked, not those of neighbours in the file."""
    third = [
        pdbLine(9, "N", "GLY", "A", 3, 6.1, 3.9, 0), pdbLine(10, "CA", "GLY", "A", 3, 7.55, 4.0, 0),
        pdbLine(11, "C", "GLY", "A", 3, 8.1, 5.4, 0), pdbLine(12, "O", "GLY", "A", 3, 7.4, 6.4, 0),
    ]  # fmt: skip
    expected = bondNames(read(tmp_path, *GLYCINES, *third).topology)
    mixed = read(tmp_path, *GLYCINES[4:], *third, *GLYCINES[:4])
    assert bondNames(mixed.topology) == expected and ("1 C", "2 N") in expected and ("2 C", "3 N") in expected


def test_ringThatTheNameDoesNotTell(tmp_path):
    """Glutamate whose nitrogen is at CD, as in pyroglutamate: its template has no such bond, other names have none."""
    lines = [line.replace("GLY A   1", "GLU A   1") for line in GLYCINES[:4]]
    lines += [
        pdbLine(20, "CB", "GLU", "A", 1, 1.75, -0.75, 1.3), pdbLine(21, "CG", "GLU", "A", 1, 0.55, -0.55, 2.2),
        pdbLine(22, "CD", "GLU", "A", 1, -0.5, -0.1, 1.25), pdbLine(23, "OE1", "GLU", "A", 1, -1.7, 0.1, 1.5),
    ]  # fmt: skip
    structure = read(tmp_path, *lines, *GLYCINES[4:])
    assert ("1 CD", "1 N") not in bondNames(structure.topology)
    with pytest.raises(InputError, match="A:GLU 1 N – A:GLU 1 CD, 0.135 nm: give these bonds"):
        Plan(structure, Choice())
    others = [line.replace("GLU", "XLU") for line in lines]
    assert ("1 CD", "1 N") in bondNames(read(tmp_path, *others, *GLYCINES[4:]).topology)


# ---- Distances that are too short or too long for the chemistry ----


def pair(path, elements, distance, residues=("LIG", "LIG"), names=None):
    """Return whether the second atoms of two molecules such as ethane, at a distance (Å), are bonded."""
    lines, names = [], names or [f"{element}2" for element in elements]
    for number, (element, residue, name) in enumerate(zip(elements, residues, names, strict=True)):
        side = 1 - 2 * number
        x = 30 - side * distance / 2
        place = {"record": "HETATM", "element": element}
        lines.append(pdbLine(40 + number, "C1", residue, "XY"[number], 1, x - 0.6 * side, 1.4, 0, record="HETATM"))
        lines.append(pdbLine(50 + number, name, residue, "XY"[number], 1, x, 0, 0, **place))
    structure = read(path, *GLYCINES, *lines)
    return tuple(sorted(f"1 {name}" for name in names)) in bondNames(structure.topology)


@pytest.mark.parametrize(
    ("elements", "short", "long"),
    [("CC", 1.1, 1.4), ("CN", 1.05, 1.3), ("CO", 1.0, 1.3), ("CS", 1.3, 1.7), ("SS", 1.5, 2.0), ("PO", 1.2, 1.6)],
)
def test_tooShortForABond(tmp_path, elements, short, long):
    assert not pair(tmp_path, elements, 0.9) and not pair(tmp_path, elements, short)
    assert pair(tmp_path, elements, long)


@pytest.mark.parametrize("elements", ["OO", "NO", "NN", ("CL", "O"), "FF", ("N", "BR")])
@pytest.mark.parametrize("distance", [1.0, 1.25, 1.45])
def test_electronegativeAtomsClash(tmp_path, elements, distance):
    assert not pair(tmp_path, elements, distance)


@pytest.mark.parametrize("distance", [1.3, 2.05, 2.3, 2.7, 2.9])
def test_methionineMakesNoDisulfide(tmp_path, distance):
    """Not even one that lacks CE."""
    for names in (["SD", "SG"], ["SG", "SD"], ["SD", "SD"]):
        residues = [{"SD": "MET", "SG": "CYS"}[name] for name in names]
        assert not pair(tmp_path, "SS", distance, residues, names)
    assert pair(tmp_path, "SS", distance, ("CYS", "CYS"), ["SG", "SG"]) == (distance > 1.6)


def test_oneDisulfideOfEachSulfur(tmp_path):
    """Three cysteines: the nearest two are bonded."""
    lines = [
        pdbLine(40 + 2 * n + m, name, "CYS", "XYZ"[n], n, x, y, 0)
        for n, (x, side) in enumerate([(30.0, -1), (32.05, 1), (29.0, -1)])
        for m, (name, y) in enumerate([("CB", 1.8 * side - (2 if n == 2 else 0)), ("SG", 2 * -(n == 2))])
    ]
    names = bondNames(read(tmp_path, *GLYCINES, *lines).topology)
    assert ("0 SG", "1 SG") in names and ("0 SG", "2 SG") not in names and ("1 SG", "2 SG") not in names


def test_shortContactsClash(tmp_path):
    """A ligand on a protein, at 0.09 nm, is sampled from a clash."""
    ligand = [
        pdbLine(9, "C1", "XYZ", "B", 1, 3.7, 3.3, 0.75, record="HETATM"),
        pdbLine(10, "C2", "XYZ", "B", 1, 3.3, 4.4, 1.7, record="HETATM"),
    ]
    structure = read(tmp_path, *GLYCINES, *ligand)
    assert partsOf(structure.topology) == 2
    (frame,) = findClashes(tmp_path / "bonds.pdb")
    assert len(frame.clashes) > 0
    Plan(structure, Choice(rigidBodies=True))


def stretchedLigand(length):
    """A zigzag of six carbons whose third bond has a length (Å)."""
    steps = [1.53, 1.53, length, 1.53, 1.53]
    x, lines = 20.0, []
    for number, step in enumerate([*steps, 0]):
        place = (x, 0.85 * (number % 2), 0.0)
        lines.append(pdbLine(60 + number, f"C{number + 1}", "LIG", "L", 1, *place, record="HETATM"))
        x += (step**2 - 0.85**2) ** 0.5 if step else 0
    return lines


@pytest.mark.parametrize("length", [1.6, 1.65, 1.7, 1.75, 1.8, 1.85, 1.9])
def test_stretchedBonds(tmp_path, length):
    """Those of residues without a template are found; neither the others nor angles become bonds."""
    structure = read(tmp_path, *GLYCINES, *stretchedLigand(length))
    bonds = [bond for bond in bondNames(structure.topology) if bond[0].startswith("1 C") and "1 CA" not in bond]
    expected = {(f"1 C{n}", f"1 C{n + 1}") for n in range(1, 6)}
    assert expected <= set(bonds) and structure.topology.getNumBonds() == 12


@pytest.mark.parametrize("length", [1.94, 2.1])
def test_partsOfAResidueThatAreTooFarApart(tmp_path, length):
    structure = read(tmp_path, *GLYCINES, *stretchedLigand(length))
    assert structure.topology.getNumBonds() == 11


def test_hydrogensThatProgramsNameDifferently(tmp_path):
    """HT1 is mostly a hydrogen of the first nitrogen; here it is one of the methyl group at the chain's end."""
    lines = [line.replace("GLY A   2", "SER A   2") for line in GLYCINES]
    cap = [
        pdbLine(30, "NT", "SER", "A", 2, 6.1, 3.9, 0), pdbLine(31, "CAT", "SER", "A", 2, 7.55, 4.0, 0),
        pdbLine(32, "HT1", "SER", "A", 2, 8.0, 3.0, 0, element="H"),
    ]  # fmt: skip
    names = bondNames(read(tmp_path, *lines, *cap).topology)
    assert ("2 CAT", "2 HT1") in names and ("2 HT1", "2 N") not in names
