"""Clashes with copies in a crystal, compared with gemmi, and between settings, cells and placements of one crystal."""

import csv
import json
import warnings
from collections import defaultdict

import gemmi
import numpy as np
import pytest
from openmmchaintree import InputError, StericExclusionForce, findClashes
from openmmchaintree.structures.clashsearch import ClashSearch
from openmmchaintree.symmetryclashes import SymmetryClashes
from scenes import GLYCINES, pdbLine, realStructurePath, writePDB

# In 12 space groups, among them hexagonal, tetragonal, monoclinic and triclinic cells.
_CRYSTALS = [
    "1htb.pdb", "loops/1ms9.pdb.gz", "hard/5ugo.pdb.gz", "loops/1f46.pdb.gz", "loops/1cs6.pdb.gz", "loops/1dts.pdb.gz",
    "loops/1bhe.pdb.gz", "loops/1exm.pdb.gz", "loops/1msc.pdb.gz", "folding/CLN025.pdb", "3ptb.pdb", "1shg.pdb",
    "1bna.pdb", "hard/5PTI.cif.gz", "loops/1onc.pdb.gz", "loops/1xif.pdb.gz", "loops/4i1b.pdb.gz", "loops/1oyc.pdb.gz",
    "1ctf.pdb", "hard/1A8O.cif.gz", "loops/1thw.pdb.gz", "loops/1t1d.pdb.gz", "loops/1cnv.pdb.gz", "loops/2ebn.pdb.gz",
    "loops/1m3s.pdb.gz", "2xhe.pdb",
]  # fmt: skip

# Space groups of all crystal systems, centrosymmetric and centred ones among them, in cells of about 1 nm.
_CELLS = {
    "P 1": (11, 12, 13, 80, 95, 110),
    "P -1": (13, 14, 15, 101, 84, 72),
    "P 1 21 1": (21.94, 4.866, 23.477, 90, 107.08, 90),
    "C 1 2 1": (24, 13, 14, 90, 125, 90),
    "I 1 2 1": (17, 16, 19, 90, 91, 90),
    "P 1 1 21": (14, 15, 16, 90, 90, 99),
    "P 21 2 21": (16, 17, 18, 90, 90, 90),
    "F d d 2": (34, 30, 19, 90, 90, 90),
    "I 41/a": (24, 24, 22, 90, 90, 90),
    "P 32 2 1": (19, 19, 24, 90, 90, 120),
    "H 3 2": (29, 29, 33, 90, 90, 120),
    "P 65 2 2": (24, 24, 30, 90, 90, 120),
    "P 21 3": (24, 24, 24, 90, 90, 90),
    "F 41 3 2": (54, 54, 54, 90, 90, 90),
}


def record(cell, name):
    lengths = "".join(f"{length:9.3f}" for length in cell[:3])
    return f"CRYST1{lengths}{''.join(f'{angle:7.2f}' for angle in cell[3:])} {name:<11}{1:4}"


_PLACES = np.array([[float(line[start : start + 8]) for start in (30, 38, 46)] for line in GLYCINES])


def movedTo(lines, places):
    """Return lines of atoms at other places (Å)."""
    return [
        f"{line[:30]}{''.join(f'{value:8.3f}' for value in place)}{line[54:]}"
        for line, place in zip(lines, places, strict=True)
    ]


def chlorides(seed, cell):
    """Return lines of atoms that form no bonds, at random in several cells."""
    places = np.random.default_rng(seed).uniform(-1.5, 1.5, (12, 3)) * cell[:3]
    return [
        pdbLine(number, "CL", "CL", "A", number, *place, element="CL", record="HETATM")
        for number, place in enumerate(places.tolist(), 1)
    ]


def search(path, **arguments):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        (frame,) = findClashes(path, **arguments)
    return frame.clashes


def overlapsOf(clashes):
    return sorted(clash.overlap for clash in clashes)


# ---- gemmi ----


def contactsByGemmi(searched, reach):
    """Return (first, second, distance in nm) of all contacts with copies, each of two equivalent ones once."""
    file = searched.models.file
    structure = gemmi.Structure()
    structure.cell, structure.spacegroup_hm = file.cell, file.spacegroup_hm
    chain = gemmi.Chain("A")
    places = 10 * positionsOf(searched)
    for number, place in enumerate(places):
        residue, atom = gemmi.Residue(), gemmi.Atom()
        residue.name, residue.seqid = "X", gemmi.SeqId(number, " ")
        atom.name, atom.element, atom.pos = "C", gemmi.Element("C"), gemmi.Position(*place)
        residue.add_atom(atom)
        chain.add_residue(residue)
    model = gemmi.Model(1)
    model.add_chain(chain)
    structure.add_model(model)
    structure.setup_cell_images()
    neighbors = gemmi.NeighborSearch(structure[0], structure.cell, 10 * reach + 0.5).populate()
    contacts = gemmi.ContactSearch(10 * reach)
    contacts.ignore, contacts.twice = gemmi.ContactSearch.Ignore.Nothing, True
    distances = defaultdict(list)
    for contact in contacts.find_contacts(neighbors):
        first, second = sorted(partner.residue.seqid.num for partner in (contact.partner1, contact.partner2))
        isDirect = abs(np.linalg.norm(places[first] - places[second]) - contact.dist) < 1e-5
        if contact.image_idx == 0 and isDirect and first != second:
            continue
        if not any(abs(contact.dist - distance) < 1e-6 for distance in distances[first, second]):
            distances[first, second].append(contact.dist)
    return sorted((*pair, 0.1 * distance) for pair, found in distances.items() for distance in found)


def positionsOf(searched):
    return searched.models.positions[0][searched.finder.atoms]


def contactsOf(searched, radius):
    """Return what `contactsByGemmi` does, found by the engine for spheres of a radius (nm)."""
    finder = searched.finder
    force = StericExclusionForce()
    force.setOverlapTolerance(0)
    force.setHydrogenBondAllowance(0)
    for _ in finder.atoms:
        force.addParticle(radius)
    names = [finder.names[atom] for atom in finder.atoms]
    copies = SymmetryClashes(force, finder._graph, finder._copies._topology, searched.crystal, finder.atoms, names)
    assert copies.notes == []
    pairs, overlaps, operators = copies.find(positionsOf(searched))
    assertOperators(searched, pairs, 2 * radius - overlaps, operators)
    distances = (2 * radius - overlaps).tolist()
    return sorted((*pair, distance) for pair, distance in zip(pairs.tolist(), distances, strict=True))


def assertOperators(searched, pairs, distances, operators):
    """Each operator, as gemmi reads it, puts the second atom at the distance."""
    cell, places = searched.models.file.cell, [gemmi.Position(*place) for place in 10 * positionsOf(searched)]
    for (first, second), distance, operator in zip(pairs.tolist(), distances, operators.tolist(), strict=True):
        fractions = gemmi.Op(operator).apply_to_xyz(cell.fractionalize(places[second]).tolist())
        copy = cell.orthogonalize(gemmi.Fractional(*fractions))
        assert places[first].dist(copy) == pytest.approx(10 * distance, abs=1e-4)


def assertSameContacts(found, expected):
    assert [contact[:2] for contact in found] == [contact[:2] for contact in expected]
    assert [contact[2] for contact in found] == pytest.approx([contact[2] for contact in expected], abs=1e-7)


@pytest.mark.parametrize("name", _CRYSTALS)
def test_contactsOfCrystals(name):
    """All contacts up to 0.4 nm, and then the clashes among them."""
    searched = ClashSearch(realStructurePath(name), symmetry=True)
    expected = contactsByGemmi(searched, 0.4)
    assert len(expected) > 50
    assertSameContacts(contactsOf(searched, 0.2), expected)
    assertSameContacts(clashesAmong(searched), clashesOf(searched, expected))


def clashesAmong(searched):
    (frame,) = searched.overlaps()
    areWithCopies = frame.operators != ""
    place = {atom: number for number, atom in enumerate(searched.finder.atoms.tolist())}
    pairs = [[place[atom] for atom in pair] for pair in frame.pairs[areWithCopies].tolist()]
    return sorted((*pair, overlap) for pair, overlap in zip(pairs, frame.overlaps[areWithCopies].tolist(), strict=True))


def clashesOf(searched, contacts):
    """Return the clashes among contacts, with overlaps instead of distances."""
    force, found = searched.finder.force, []
    for first, second, distance in contacts:
        (radius1, role1), (radius2, role2) = (force.getParticleParameters(atom) for atom in (first, second))
        canBond = (role1 & force.Donor and role2 & force.Acceptor) or (role1 & force.Acceptor and role2 & force.Donor)
        overlap = radius1._value + radius2._value - distance
        if radius1._value and radius2._value and overlap > (0.1 if canBond else 0.04):
            found.append((first, second, overlap))
    return sorted(found)


@pytest.mark.parametrize("name", _CELLS)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_contactsOfSpaceGroups(tmp_path, name, seed):
    path = writePDB(tmp_path / "crystal.pdb", [record(_CELLS[name], name), *chlorides(seed, _CELLS[name])])
    searched = ClashSearch(path, ions=True, symmetry=True)
    expected = contactsByGemmi(searched, 0.6)
    assert len(expected) > 20
    assertSameContacts(contactsOf(searched, 0.3), expected)


# ---- One crystal in several ways ----


def test_latticeAlone(tmp_path):
    """In P 1, copies are the images of the cell."""
    cell = (10, 11, 12, 80, 95, 110)
    path = writePDB(tmp_path / "crystal.pdb", [record(cell, "P 1"), *chlorides(6, cell)])
    found, images = (search(path, ions=True, **choice) for choice in ({"symmetry": True}, {"periodic": True}))
    assert len(found) == len(images) > len(search(path, ions=True)) + 3
    assert sorted(clash[:2] for clash in found) == sorted(clash[:2] for clash in images)
    assert overlapsOf(found) == pytest.approx(overlapsOf(images), abs=1e-6)


def inOtherSetting(path, basis, name):
    """Return the crystal of a file, with the axes that a change of basis gives, as a gemmi.Structure."""
    structure = gemmi.read_structure(str(path))
    old = gemmi.UnitCell(*structure.cell.parameters)
    structure.cell = old.changed_basis_forward(basis, False)
    structure.spacegroup_hm = name
    for atom in (atom for chain in structure[0] for residue in chain for atom in residue):
        fractions = basis.apply_to_xyz(old.fractionalize(atom.pos).tolist())
        atom.pos = structure.cell.orthogonalize(gemmi.Fractional(*fractions))
    return structure


def distancesIn(path):
    return sorted(distance for *_, distance in contactsOf(ClashSearch(path, ions=True, symmetry=True), 0.3))


@pytest.mark.parametrize(
    "name, basis, other",
    [
        ("P 21 2 21", "y,z,x", "P 2 21 21"),
        ("C 1 2 1", "x,y,z-x", "I 1 2 1"),
        ("P 1 1 21", "y,z,x", "P 1 21 1"),
        ("H 3 2", "-y+z,x+z,-x+y+z", "R 3 2:R"),
    ],
)
def test_settings(tmp_path, name, basis, other):
    """Axes chosen or named otherwise: the contacts of one crystal."""
    path = writePDB(tmp_path / "crystal.pdb", [record(_CELLS[name], name), *chlorides(4, _CELLS[name])])
    structure = inOtherSetting(path, gemmi.Op(basis), other)
    (tmp_path / "other.cif").write_text(structure.make_mmcif_document().as_string())
    expected = distancesIn(path)
    assert len(expected) > 20
    assert distancesIn(tmp_path / "other.cif") == pytest.approx(expected, abs=2e-4)


def test_axesTurnedBySCALE(tmp_path):
    """The axes of the cell lie anywhere in space (SCALE), and its origin, too."""
    cell, name = _CELLS["P 32 2 1"], "P 32 2 1"
    lines = chlorides(5, cell)
    expected = distancesIn(writePDB(tmp_path / "crystal.pdb", [record(cell, name), *lines]))
    rotation = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    rotation *= np.linalg.det(rotation)
    places = np.array([[float(line[start : start + 8]) for start in (30, 38, 46)] for line in lines])
    shift = np.array([3.0, -2.0, 1.0])
    scale = np.array(gemmi.UnitCell(*cell).frac.mat.tolist()) @ rotation.T
    scales = [
        f"SCALE{row + 1}    {values[0]:10.6f}{values[1]:10.6f}{values[2]:10.6f}     {-values @ shift:10.5f}"
        for row, values in enumerate(scale)
    ]
    lines = movedTo(lines, places @ rotation.T + shift)
    path = writePDB(tmp_path / "turned.pdb", [record(cell, name), *scales, *lines])
    assert gemmi.read_structure(str(path)).cell.explicit_matrices
    assert distancesIn(path) == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize("operator", ["x+2,y-1,z", "-x,y+1/2,-z", "-x+3,y-5/2,-z+1"])
def test_chainInAnotherCopy(tmp_path, operator):
    """Wherever the chains of an asymmetric unit are, the crystal is the same."""
    path = realStructurePath("loops/1f46.pdb.gz")
    structure = gemmi.read_structure(str(path))
    for atom in (atom for chain in structure[0] if chain.name == "B" for residue in chain for atom in residue):
        fractions = gemmi.Op(operator).apply_to_xyz(structure.cell.fractionalize(atom.pos).tolist())
        atom.pos = structure.cell.orthogonalize(gemmi.Fractional(*fractions))
    structure.write_pdb(str(tmp_path / "moved.pdb"))
    expected, found = (search(one, symmetry=True) for one in (path, tmp_path / "moved.pdb"))
    assert overlapsOf(found) == pytest.approx(overlapsOf(expected), abs=2e-4)


def test_models(tmp_path, runCommandHere):
    """Each model with its own copies."""
    cell = record((10, 11, 12, 90, 90, 90), "P 21 21 21")
    moved = movedTo(GLYCINES, _PLACES + [0.5, 0.0, 1.0])
    paths = [writePDB(tmp_path / f"{k}.pdb", [cell, *lines]) for k, lines in enumerate((GLYCINES, moved))]
    assert [notesOf(path) for path in paths] == [[], []]
    parts = [search(path, symmetry=True) for path in paths]
    both = ["MODEL        1", *GLYCINES, "ENDMDL", "MODEL        2", *moved, "ENDMDL"]
    frames = findClashes(writePDB(tmp_path / "both.pdb", [cell, *both]), symmetry=True)
    assert [frame.clashes for frame in frames] == parts and parts[0] != parts[1] and all(parts)
    for file, *workers in (("here.json",), ("there.json", "--workers", 2)):
        assert runCommandHere("clashes", "both.pdb", "--symmetry", "--json", file, *workers).returncode == 0
    assert (tmp_path / "here.json").read_text() == (tmp_path / "there.json").read_text()


# ---- Atoms on axes, bonds, and alternatives ----


def notesOf(path, **arguments):
    return [str(note) for note in ClashSearch(path, symmetry=True, **arguments).notes]


_AXIS = record((30, 30, 30, 90, 90, 90), "P 1 2 1")  # of two turns, along y through the origin


@pytest.mark.parametrize("offset", [0, 0.03, 0.3])
def test_waterOnAnAxis(tmp_path, offset):
    """An atom on an axis, or nearly so, is one atom."""
    water = pdbLine(9, "O", "HOH", "W", 1, offset, 5.0, 0.0)
    path = writePDB(tmp_path / "water.pdb", [_AXIS, *movedTo(GLYCINES, _PLACES + [8, 8, 8]), water])
    assert search(path, symmetry=True, water=True) == []
    beside = pdbLine(9, "O", "HOH", "W", 1, 0.8, 5.0, 0.0)
    path = writePDB(tmp_path / "beside.pdb", [_AXIS, *movedTo(GLYCINES, _PLACES + [8, 8, 8]), beside])
    (clash,) = search(path, symmetry=True, water=True)
    assert clash.particle1 == clash.particle2 == 8 and clash.operator == "-x,y,-z"


def sulfate(occupancy):
    """A sulfate with S on the axis."""
    places = [(0, 0, 0), (1.2, 0.8, 0.2), (-1.0, 0.9, 0.5), (0.3, -0.7, 1.3), (-0.4, -0.9, -1.1)]
    return [
        pdbLine(20 + number, name, "SO4", "S", 1, *place, record="HETATM", occupancy=occupancy)
        for number, (name, place) in enumerate(zip(("S", "O1", "O2", "O3", "O4"), places, strict=True))
    ]


@pytest.mark.parametrize("occupancy", [0.5, 1.0])
def test_moleculeOnAnAxis(tmp_path, occupancy):
    """Its atoms are within three bonds of their copies, since S is one atom."""
    path = writePDB(tmp_path / "sulfate.pdb", [_AXIS, *movedTo(GLYCINES, _PLACES + [8, 8, 8]), *sulfate(occupancy)])
    assert search(path, symmetry=True) == []


@pytest.mark.parametrize("occupancy, isClash", [(0.5, False), (0.45, False), (0.6, True), (1.0, True), (0.0, True)])
def test_alternatives(tmp_path, occupancy, isClash):
    """Two halves beside an axis are alternatives: one is there at a time."""
    lines = [f"{line[:54]}{occupancy:6.2f}{line[60:]}" for line in movedTo(GLYCINES, _PLACES + [1.0, 4, 0.5])]
    path = writePDB(tmp_path / "halves.pdb", [_AXIS, *lines])
    assert bool(search(path, symmetry=True)) == isClash
    words = "overlaps with copies that do not count, since both atoms have partial occupancy"
    assert any(words in note for note in notesOf(path)) != isClash


def cysteine(distance):
    """A cysteine with its sulfur at half a distance (Å) from the axis."""
    sulfur = np.array([0.5 * distance, 0, 0])
    beta = sulfur + 1.81 * np.array([np.cos(np.radians(76)), 0, np.sin(np.radians(76))])
    alpha = beta + [0.9, 1.1, 0.6]
    places = {"N": alpha + [0.2, 1.1, -0.9], "CA": alpha, "C": alpha + [0.9, -0.5, 1.1]}
    places |= {"O": places["C"] + [0.9, -0.8, 0.3], "CB": beta, "SG": sulfur}
    return [pdbLine(number, name, "CYS", "A", 1, *place) for number, (name, place) in enumerate(places.items(), 1)]


def test_disulfideAcrossAnAxis(tmp_path):
    path = writePDB(tmp_path / "cysteine.pdb", [_AXIS, *cysteine(2.05)])
    assert search(path, symmetry=True) == []
    assert notesOf(path) == ["bonds with copies in the crystal (1): A:CYS 1 SG – A:CYS 1 SG (-x,y,-z)"]
    path = writePDB(tmp_path / "cysteine.pdb", [_AXIS, *cysteine(1.2)])
    clashes = search(path, symmetry=True)
    assert [(clash.atom1.atom, clash.atom2.atom) for clash in clashes if clash.overlap > 0.2] == [("SG", "SG")]


@pytest.mark.parametrize(
    "name, bonded, count",
    [
        ("loops/2tgi.pdb.gz", {("SG", "SG")}, 1),
        ("loops/3cla.pdb.gz", {("OE1", "CO"), ("ND1", "CO"), ("CO", "OE1"), ("CO", "ND1")}, 4),
        ("hard/3JQH.cif.gz", {("N", "C")}, 1),
    ],
)
def test_bondsOfRealCrystals(name, bonded, count):
    """A disulfide, bonds of a metal, and a chain that continues in a copy."""
    searched = ClashSearch(realStructurePath(name), symmetry=True)
    (note,) = [note for note in searched.notes if note.kind == "bonds with copies in the crystal"]
    assert len(note.items) == count
    (frame,) = searched
    found = {(clash.atom1.atom, clash.atom2.atom) for clash in frame.clashes if clash.operator}
    assert bonded.isdisjoint(found)


def test_bondThatTheFileLists(tmp_path):
    """Potassium is bonded only if the file says so: here to an oxygen of a copy."""
    places = _PLACES + [2, 5, 3]
    place = places[3] * [-1, 1, -1] + [-1.3, 1.7, 0]
    ion = pdbLine(30, "K", "K", "K", 1, *place, element="K", record="HETATM")
    lines = [_AXIS, *movedTo(GLYCINES, places), ion]
    link = "LINK         K     K K   1                 O   GLY A   2     1555   2555  2.14"
    link = link.replace("GLY A   2", "GLY A   1")
    bare = search(writePDB(tmp_path / "bare.pdb", lines), symmetry=True, ions=True)
    bound = search(writePDB(tmp_path / "bound.pdb", [link, *lines]), symmetry=True, ions=True)
    pairs = [{(clash.atom1.atom, clash.atom2.atom) for clash in clashes} for clashes in (bare, bound)]
    assert ("O", "K") in pairs[0] - pairs[1]


# ---- Inputs ----


def refusal(path, **arguments):
    with pytest.raises(InputError) as caught:
        ClashSearch(path, symmetry=True, **arguments)
    assert "\n" not in str(caught.value)
    return str(caught.value).removeprefix(f"{path}: ")


_NO_CELL = "there is no cell of a crystal (CRYST1, _cell), which its symmetry needs"
_NO_GROUP = "there is no space group (CRYST1, _symmetry), which the symmetry of a crystal needs"
_ASYMMETRIC = "the cell does not have the symmetry of the space group"
_UNKNOWN = "the space group 'Q 17' is not known (CRYST1, _symmetry), which the symmetry of a crystal needs"


@pytest.mark.parametrize(
    "lines, words",
    [
        ([], _NO_CELL),
        (["CRYST1"], _NO_CELL),
        ([record((1, 1, 1, 90, 90, 90), "P 1")], _NO_CELL),
        ([record((0, 0, 0, 90, 90, 90), "P 1")], _NO_CELL),
        ([record((30, 30, 0, 90, 90, 90), "P 1")], _NO_CELL),
        ([record((30, 30, 30, 0, 0, 0), "P 1")], _NO_CELL),
        ([record((30, 30, 30, 150, 20, 100), "P 1")], _NO_CELL),
        ([record((30, 30, 30, 120, 120, 120), "P 1")], _NO_CELL),
        ([record((np.nan, 30, 30, 90, 90, 90), "P 1")], _NO_CELL),
        ([record((30, 31, 32, 90, 90, 90), "")], _NO_GROUP),
        ([record((30, 31, 32, 90, 90, 90), "Q 17")], _UNKNOWN),
        ([record((30, 31, 32, 90, 90, 90), "P 61")], f"{_ASYMMETRIC} P 61"),
        ([record((30, 31, 32, 90, 90, 99), "P 2 2 2")], f"{_ASYMMETRIC} P 2 2 2"),
        ([record((4, 4, 5, 90, 90, 90), "P 43")], "the cell of 0.08 nm³ has no room for 8 atoms, 4 times"),
    ],
)
def test_noCrystal(tmp_path, lines, words):
    assert refusal(writePDB(tmp_path / "crystal.pdb", [*lines, *GLYCINES])) == words


def test_contradictions(tmp_path):
    """In 1tml, SCALE says that the angle β is 90°."""
    rows = ("".join(f"{value:10.6f}" for value in row) for row in 0.03 * np.eye(3))
    scales = [f"SCALE{number}    {row}        0.00000" for number, row in enumerate(rows, 1)]
    path = writePDB(tmp_path / "crystal.pdb", [record((33, 33, 33, 90, 110, 90), "P 1 21 1"), *scales, *GLYCINES])
    assert refusal(path) == "the cell (CRYST1) contradicts the axes that SCALE gives"
    cells = [record((30, 31, width, 90, 90, 90), "P 1") for width in (30, 32)]
    models = [line for cell in cells for line in ("MODEL        1", cell, *GLYCINES, "ENDMDL")]
    path = writePDB(tmp_path / "models.pdb", models)
    assert refusal(path) == "its models have different cells, which a crystal does not have"


def test_moreThanTheAsymmetricUnit(tmp_path):
    """An assembly that copies make up: the file holds two of them."""
    both = [*movedTo(GLYCINES, _PLACES + [4, 4, 4]), *movedTo(GLYCINES, (_PLACES + [4, 4, 4]) * [-1, 1, -1])]
    both = [line[:21] + chain + line[22:] for line, chain in zip(both, "AAAAAAAABBBBBBBB", strict=True)]
    words = refusal(writePDB(tmp_path / "dimer.pdb", [_AXIS, *both]))
    assert words == (
        "atoms at the place of a copy of another atom (8): A:GLY 1 N – B:GLY 1 N (-x,y,-z); "
        "A:GLY 1 CA – B:GLY 1 CA (-x,y,-z); A:GLY 1 C – B:GLY 1 C (-x,y,-z); and 5 more: "
        "does the file hold more than the asymmetric unit?"
    )


@pytest.mark.parametrize("kind", ["pdb", "cif"])
def test_nonCrystallographicSymmetry(tmp_path, kind):
    """Its copies are not those of the crystal; a note names copies that the file leaves out."""
    path = writePDB(tmp_path / "crystal.pdb", [_AXIS, *GLYCINES])
    structure = gemmi.read_structure(str(path))
    for identifier, isGiven, shift in (("1", True, 0), ("2", False, 10)):
        operation = gemmi.NcsOp(gemmi.Transform(gemmi.Mat33(), gemmi.Vec3(shift, 0, 0)), identifier, isGiven)
        structure.ncs.append(operation)
    path = tmp_path / f"ncs.{kind}"
    path.write_text(structure.make_pdb_string() if kind == "pdb" else structure.make_mmcif_document().as_string())
    words = "copies by non-crystallographic symmetry (MTRIX, _struct_ncs_oper) that the file leaves out do not count"
    assert words in notesOf(path)
    assert search(path, symmetry=True) == search(tmp_path / "crystal.pdb", symmetry=True)


def test_choices(tmp_path):
    path = writePDB(tmp_path / "crystal.pdb", [_AXIS, *GLYCINES])
    assert refusal(path, periodic=True) == "symmetry copies include periodic images: choose one of them"
    words = "a.dcd: symmetry copies are made of the models of a structure, of no trajectory"
    assert refusal(path, trajectory="a.dcd") == words


# ---- The command ----


def test_command(runCommandHere, tmp_path):
    cell = record((10, 11, 12, 90, 90, 90), "P 21 21 21")
    path = writePDB(tmp_path / "crystal.pdb", [cell, *GLYCINES])
    clashes = search(path, symmetry=True)
    result = runCommandHere("clashes", path, "--symmetry", "--json", "a.json", "--csv", "a.csv", "--picture", "a.png")
    assert result.returncode == 0, result.stderr
    assert "copies in the crystal count (P 21 21 21): their operators are in brackets" in result.stdout
    worst = max(clashes, key=lambda clash: clash.overlap)
    assert f"{worst.overlap:.4f}  {worst.atom1}" in result.stdout
    assert f"{worst.atom2} ({worst.operator})" in result.stdout
    summary = json.loads((tmp_path / "a.json").read_text())
    assert summary["spaceGroup"] == "P 21 21 21" and summary["notes"] == []
    entries = summary["frames"][0]["clashes"]
    assert [(e["particle1"], e["particle2"], e["operator"]) for e in entries] == [(*c[:2], c[5]) for c in clashes]
    with open(tmp_path / "a.csv") as file:
        rows = list(csv.DictReader(file))
    assert [row["operator"] for row in rows] == [clash.operator for clash in clashes] and len(rows) > 5
    result = runCommandHere("clashes", path, "--symmetry", "--periodic")
    assert result.returncode == 2 and "not allowed with argument" in result.stderr
