"""Alternates: one conformer of each residue, that of highest occupancy, never a mixture."""

import numpy as np
import pytest
from openmmchaintree.command.sampling import Sampling
from openmmchaintree.structures.structure import readStructure
from scenes import GLYCINES, pdbLine, realStructurePath, writePDB


def serine(altloc, occupancy, x, first=1, name="SER", number=3):
    """A residue after the two glycines, moved by x, with all its atoms labelled."""
    atoms = [("N", 6.0, 3.9, 0.0), ("CA", 7.45, 3.9, 0.0), ("C", 7.95, 5.32, 0.0), ("O", 7.2, 6.28, 0.0)]
    atoms += [("CB", 8.0, 3.1, 1.2)] + ([("OG", 7.5, 3.6, 2.4)] if name == "SER" else [])
    return [
        pdbLine(first + i, atom, name, "A", number, x0 + x, y, z, altloc=altloc, occupancy=occupancy)
        for i, (atom, x0, y, z) in enumerate(atoms)
    ]


def read(path, *lines):
    return readStructure(writePDB(path / "alternates.pdb", lines))


def placesOf(structure, number):
    atoms = [atom for atom in structure.topology.atoms() if atom.residue.id == str(number)]
    places = {atom.name: structure.positions[atom.index, 0] for atom in atoms}
    return places, [structure.alternates[atom.index] for atom in atoms]


@pytest.mark.parametrize(("occupancies", "taken"), [((0.4, 0.6), "B"), ((0.6, 0.4), "A"), ((0.5, 0.5), "A")])
def test_highestOccupancyIsTaken(tmp_path, occupancies, taken):
    conformers = zip(serine("A", occupancies[0], 0.0), serine("B", occupancies[1], 0.5), strict=True)
    structure = read(tmp_path, *GLYCINES, *(line for pair in conformers for line in pair))
    places, labels = placesOf(structure, 3)
    assert labels == [taken] * 6
    assert places["CA"] == pytest.approx(0.745 + (0.05 if taken == "B" else 0))
    (note,) = structure.notes
    assert note.items == [f"A:SER 3 conformer {taken}"]


def test_atomsWithoutLabelAreKept(tmp_path):
    backbone = [line[:16] + " " + line[17:] for line in serine("A", 1.0, 0.0)[:4]]
    structure = read(tmp_path, *GLYCINES, *backbone, *serine("A", 0.3, 0.0)[4:], *serine("B", 0.7, 0.5)[4:])
    places, labels = placesOf(structure, 3)
    assert labels == ["", "", "", "", "B", "B"]
    assert places["CB"] == pytest.approx(0.85) and places["CA"] == pytest.approx(0.745)


def test_microheterogeneity(tmp_path):
    """Two residues at one place in the chain: one of them, whole."""
    for order in (1, -1):
        parts = [serine("A", 0.3, 0.0), serine("B", 0.7, 0.2, name="ALA")][::order]
        structure = read(tmp_path, *GLYCINES, *parts[0], *parts[1])
        names = [(residue.id, residue.name) for residue in structure.topology.residues()]
        assert names == [("1", "GLY"), ("2", "GLY"), ("3", "ALA")]
        places, _ = placesOf(structure, 3)
        assert "OG" not in places and places["CA"] == pytest.approx(0.765)


def test_deuteriumInPlaceOfHydrogen(tmp_path):
    lines = [*serine("", 1.0, 0.0)]
    lines += [
        pdbLine(20, "H", "SER", "A", 3, 5.6, 3.0, 0.0, altloc="A", occupancy=0.3),
        pdbLine(21, "D", "SER", "A", 3, 5.6, 3.0, 0.1, altloc="B", occupancy=0.7),
    ]
    structure = read(tmp_path, *GLYCINES, *lines)
    places, _ = placesOf(structure, 3)
    assert "D" in places and "H" not in places
    (deuterium,) = [atom for atom in structure.topology.atoms() if atom.name == "D"]
    assert deuterium.element.symbol == "H"


def test_independentAlternates(tmp_path):
    """A and B of the side chain, C and D of another atom: one of each."""
    lines = [line[:16] + " " + line[17:] for line in serine("", 1.0, 0.0)[:3]]
    lines += [line for altloc, share in (("A", 0.2), ("B", 0.8)) for line in serine(altloc, share, 0.0)[4:]]
    lines += [line for altloc, share in (("C", 0.9), ("D", 0.1)) for line in serine(altloc, share, 0.0)[3:4]]
    places, labels = placesOf(read(tmp_path, *GLYCINES, *lines), 3)
    assert sorted(labels) == ["", "", "", "B", "B", "C"] and sorted(places) == sorted(["N", "CA", "C", "O", "CB", "OG"])


@pytest.mark.parametrize(("name", "residue", "kept"), [("edge_altloc.cif", "22", "PRO"), ("3JQH.cif.gz", "1", "PRO")])
def test_realMicroheterogeneity(name, residue, kept):
    structure = readStructure(realStructurePath(f"hard/{name}"))
    (found,) = [other for other in structure.topology.residues() if other.id == residue]
    assert found.name == kept
    labels = {structure.alternates[atom.index] for atom in found.atoms()}
    assert len(labels) == 1 and labels != {""}
    if name.startswith("3JQH"):
        positions = structure.positions
        sampling = Sampling(structure, 1)
        sampling.integrator.step(1)
        assert np.array_equal(positions, structure.positions)


def test_firstConformerWithoutALabel(tmp_path):
    """As some programs write it: the same atoms without a label, and again as B."""
    lines = [*serine("", 0.7, 0.0), *serine("B", 0.3, 0.5)[4:]]
    places, labels = placesOf(read(tmp_path, *GLYCINES, *lines), 3)
    assert labels == [""] * 6 and places["CB"] == pytest.approx(0.8)
    lines = [*serine("", 0.3, 0.0), *serine("B", 0.7, 0.5)[4:]]
    places, labels = placesOf(read(tmp_path, *GLYCINES, *lines), 3)
    assert labels == ["", "", "", "", "B", "B"] and places["CB"] == pytest.approx(0.85)


def test_conformersInBlocks(tmp_path):
    """All residues as A, then all as B."""
    blocks = [line for altloc, share in (("A", 0.4), ("B", 0.6)) for number in (3, 4) for line in
              serine(altloc, share, 6.0 * (number - 3) + (0.2 if altloc == "B" else 0.0), number=number)]  # fmt: skip
    structure = read(tmp_path, *GLYCINES, *blocks)
    assert [residue.id for residue in structure.topology.residues()] == ["1", "2", "3", "4"]
    assert structure.alternates == [""] * 8 + ["B"] * 12


def test_whatHasNoLabelGoesWithItsResidue(tmp_path):
    """Two names at one place, of which one has labels on some of its atoms only."""
    bare = [line[:16] + " " + line[17:] for line in serine("A", 0.6, 0.0)[2:]]
    lines = [*serine("A", 0.6, 0.0)[:2], *bare, *serine("B", 0.4, 0.2, name="ALA")]
    structure = read(tmp_path, *GLYCINES, *lines)
    assert [residue.name for residue in structure.topology.residues()] == ["GLY", "GLY", "SER"]
    assert placesOf(structure, 3)[1] == ["A", "A", "", "", "", ""]
