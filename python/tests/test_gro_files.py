"""gro files as structures: the same molecules, bonds, clashes and boxes as in PDB."""

import gzip
import os

import numpy as np
import pytest
from foreignfiles import writeGro
from openmm import app, unit
from openmmchaintree import InputError, findClashes
from openmmchaintree.structures.structure import readModels, readStructure, villinPath
from scenes import GLYCINES, writePDB


@pytest.fixture(scope="module")
def whole():
    """Villin in water as OpenMM reads it."""
    pdb = app.PDBFile(str(villinPath()))
    return pdb.topology, pdb.getPositions(asNumpy=True).value_in_unit(unit.nanometer)


def test_villinInWater(tmp_path, whole, villin):
    """Its protein, whose chain and bonds are those of the PDB file, without water."""
    topology, positions = whole
    box = topology.getUnitCellDimensions().value_in_unit(unit.nanometer)
    path = writeGro(tmp_path / "villin.gro", list(topology.atoms()), positions, box, decimals=6)
    structure = readStructure(path)
    assert structure.name == "villin" and structure.topology.getNumAtoms() == villin.topology.getNumAtoms()
    ours, theirs = list(structure.topology.atoms()), list(topology.atoms())[:582]
    assert [(atom.name, atom.element, atom.residue.name, atom.residue.id) for atom in ours] == [
        (atom.name, atom.element, atom.residue.name, atom.residue.id) for atom in theirs
    ]
    assert {frozenset(atom.index for atom in bond) for bond in structure.topology.bonds()} == {
        frozenset(atom.index for atom in bond) for bond in villin.topology.bonds()
    }
    assert np.abs(structure.positions - villin.positions).max() < 1e-6
    assert np.diag(structure.box) == pytest.approx(box, abs=1e-5)
    models = readModels(path)
    assert models.topology.getNumAtoms() == topology.getNumAtoms()
    assert [atom.element for atom in models.topology.atoms()] == [atom.element for atom in topology.atoms()]
    (tmp_path / "villin.gro.gz").write_bytes(gzip.compress(path.read_bytes()))
    assert np.array_equal(readStructure(tmp_path / "villin.gro.gz").positions, structure.positions)


def atomsOf(path):
    return list(app.PDBFile(str(path)).topology.atoms())


@pytest.fixture
def glycines(tmp_path):
    """A function that writes some frames of two glycines (nm), and another residue behind them, as gro."""
    atoms = atomsOf(writePDB(tmp_path / "glycines.pdb", GLYCINES))
    positions = np.array([[float(line[k : k + 8]) for k in (30, 38, 46)] for line in GLYCINES]) / 10

    def write(*frames, name="a.gro", box=(3, 3, 3), **options):
        parts = []
        for frame in frames or (positions,):
            parts.append(writeGro(tmp_path / name, atoms, frame, box, **options).read_text())
        (tmp_path / name).write_text("".join(parts))
        return tmp_path / name

    write.positions = positions
    return write


@pytest.mark.filterwarnings("ignore:the file has a periodic box")
def test_frames(glycines, tmp_path):
    """Each frame is a model, and clashes are those of the same models in PDB."""
    first = glycines.positions
    folded = first.copy()
    folded[7] = first[0] + 0.1
    path = glycines(first, folded, first)
    lines = []
    for number, frame in enumerate((first, folded, first)):
        atoms = [
            f"{line[:30]}{''.join(f'{x:8.3f}' for x in xyz)}{line[54:]}"
            for line, xyz in zip(GLYCINES, 10 * frame, strict=True)
        ]
        lines += [f"MODEL     {number + 1:4}", *atoms, "ENDMDL"]
    expected = findClashes(writePDB(tmp_path / "models.pdb", lines))
    found = findClashes(path)
    assert [len(frame.clashes) for frame in found] == [len(frame.clashes) for frame in expected] == [0, 4, 0]
    for ours, theirs in zip(found[1].clashes, expected[1].clashes, strict=True):
        assert (ours.particle1, ours.particle2) == (theirs.particle1, theirs.particle2)
        assert ours.overlap == pytest.approx(theirs.overlap, abs=2e-3)  # the digits of gro
    assert np.abs(readStructure(path, 1).positions - folded).max() < 1e-3
    with pytest.raises(InputError, match="there is no model 3"):
        readStructure(path, 3)


def test_obliqueBox(glycines):
    """Two numbers after the diagonal are those of the second vector, in GROMACS's order."""
    path = glycines()
    lines = path.read_text().split("\n")
    lines[-2] = "3.0 2.8 2.6 0.0 0.0 0.5 0.0 0.25 0.75"
    path.write_text("\n".join(lines))
    assert readStructure(path).box == pytest.approx(np.array([[3, 0, 0], [0.5, 2.8, 0], [0.25, 0.75, 2.6]]), abs=1e-9)
    lines[-2] = "0 0 0"
    path.write_text("\n".join(lines))
    assert readStructure(path).box is None


def test_chains(tmp_path):
    """The format has none: another begins after a last oxygen, or where numbers do not follow each other."""
    lines = []
    for number, (residue, names) in enumerate(
        [
            ("GLY", "N CA C O"),
            ("GLY", "N CA C OC1 OC2"),
            ("GLY", "N CA C O"),
            ("GLY", "N CA C O"),
            ("SOL", "OW HW1 HW2"),
        ]
    ):
        for k, name in enumerate(names.split()):
            shown = [99998, 99999, 0, 7, 8][number]
            lines.append(f"{shown:5d}{residue:<5}{name:>5}{k:5d}{0.4 * number:8.3f}{0.15 * k:8.3f}{0.0:8.3f}")
    path = tmp_path / "chains.gro"
    path.write_text("\n".join(["chains", f"{len(lines)}", *lines, "0 0 0", ""]))
    chains = list(readModels(path).topology.chains())
    assert [[residue.id for residue in chain.residues()] for chain in chains] == [
        ["99998", "99999"],
        ["0"],
        ["7"],
        ["8"],
    ]
    assert next(chains[3].residues()).name == "HOH"


def test_damaged(glycines, tmp_path):
    """One sentence that names the file and the line; frames before the damage are searched."""
    whole = glycines().read_text().split("\n")
    path = tmp_path / "b.gro"

    def change(line, text):
        return "\n".join([*whole[:line], text, *whole[line + 1 :]])

    for text, words in {
        "": "line 2 is not a number of atoms",
        "title\n": "line 2 is not a number of atoms; is it a gro file?",
        "title\n0\n1 1 1\n": "line 2 is not a number of atoms",
        "\n".join(GLYCINES): "line 2 is not a number of atoms",
        "\n".join(whole[:6]): "is cut off: line 2 tells of 8 atoms and a box",
        change(1, "9"): "is cut off: line 2 tells of 9 atoms",
        change(1, "7"): "line 10 is not a box",
        change(4, whole[4][:30]): "line 5 has no position of three numbers",
        change(4, whole[4][:20] + "   nan     nan     nan  "): "line 5 has no position of three numbers",
        change(4, "     " + whole[4][5:]): "line 5 has no number and name of a residue",
        change(10, "a b c"): "line 11 is not a box",
    }.items():
        path.write_text(text)
        with pytest.raises(InputError, match="b.gro: ") as caught:
            readStructure(path)
        assert words in str(caught.value) and "\n" not in str(caught.value)
    path.write_bytes(bytes(range(256)) * 10)
    with pytest.raises(InputError, match="b.gro: line 2 is not a number of atoms"):
        readStructure(path)
    glycines(glycines.positions, glycines.positions)
    os.truncate(tmp_path / "a.gro", int(0.9 * (tmp_path / "a.gro").stat().st_size))
    with pytest.raises(InputError, match="a.gro: is cut off: line 13 tells of 8 atoms") as caught:
        findClashes(tmp_path / "a.gro")
    assert len(caught.value.frames) == 1
