"""Molecules split over the periodic box are made whole along their bonds, or refused."""

import numpy as np
import openmm
import pytest
from mdtraj.formats import DCDTrajectoryFile, XTCTrajectoryFile
from openmm import app, unit
from openmmchaintree import InputError, findClashes
from openmmchaintree.command.sampling import Sampling
from openmmchaintree.images import isBox, leastWidth, makeWhole, nearestImage, reducedBox
from openmmchaintree.structures.clashsearch import ClashSearch
from openmmchaintree.structures.structure import readStructure
from scenes import GLYCINES, bondNames, realStructurePath, writeDCD, writePDB, writeXTC

_BOXES = [
    np.diag([5.1, 4.7, 6.3]),
    np.array([[6.0, 0, 0], [2.9, 5.2, 0], [-2.8, 2.0, 5.0]]),
]


def wrapped(positions, box, shift):
    """Shift positions, and wrap each atom into the box."""
    shifted = positions + shift
    return shifted - np.floor(shifted @ np.linalg.inv(box)) @ box


@pytest.mark.parametrize("box", _BOXES, ids=["rectangular", "triclinic"])
def test_wholeAgain(villin, box):
    bonds = np.array([[atom.index for atom in bond] for bond in villin.topology.bonds()])
    generator = np.random.default_rng(1)
    for _ in range(20):
        torn = wrapped(villin.positions, box, generator.uniform(-10, 10, 3))
        whole = makeWhole(torn, bonds, box)
        assert np.array_equal(whole[0], torn[0])
        assert whole - whole[0] == pytest.approx(villin.positions - villin.positions[0], abs=1e-12)


def test_nothingToDo(villin):
    bonds = [[atom.index for atom in bond] for bond in villin.topology.bonds()]
    assert makeWhole(villin.positions, bonds, _BOXES[0]) is villin.positions


@pytest.mark.parametrize("box", _BOXES, ids=["rectangular", "triclinic"])
def test_leastWidth(box):
    """What is shorter than half of it has no shorter image, in whatever direction; what is longer may have one."""
    directions = np.random.default_rng(2).normal(size=(20000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, np.newaxis]
    short, long = (factor * leastWidth(box) * directions for factor in (0.49, 0.51))
    assert np.array_equal(nearestImage(short, box), short)
    assert not np.array_equal(nearestImage(long, box), long)


def test_reducedBox():
    box = np.array([[4.0, 0, 0], [5.0, 4.0, 0], [9.0, -7.0, 5.0]])
    reduced = reducedBox(box)
    assert abs(reduced[1, 0]) <= 2 and abs(reduced[2, 0]) <= 2 and abs(reduced[2, 1]) <= 2
    turns = reduced @ np.linalg.inv(box)
    assert turns == pytest.approx(np.rint(turns), abs=1e-12) and abs(np.linalg.det(turns)) == pytest.approx(1)


def withBox(topology, box):
    copied = app.Modeller(topology, [openmm.Vec3(0, 0, 0)] * topology.getNumAtoms() * unit.nanometer)
    copied.delete([])  # a deepcopy has bonds between other atoms in OpenMM 8.4
    vectors = None if box is None else [openmm.Vec3(*vector) for vector in box] * unit.nanometer
    copied.topology.setPeriodicBoxVectors(vectors)
    return copied.topology


def write(path, villin, positions, box):
    topology = withBox(villin.topology, box)
    with open(path, "w") as file:
        (app.PDBxFile if path.suffix == ".cif" else app.PDBFile).writeFile(topology, positions * unit.nanometer, file)
    return path


@pytest.mark.parametrize(
    "vectors",
    [
        np.zeros((3, 3)),
        np.ones((3, 3)),
        np.full((3, 3), np.nan),
        np.diag([5, np.inf, 5]),
        np.diag([5, 5, 0.1]),
        [[5, 0, 0], [5, 1e-9, 0], [0, 0, 5]],
    ],
    ids=["zeros", "ones", "nan", "infinite", "flat", "skewed"],
)
def test_noBoxAtAll(villin, tmp_path, vectors):
    """Vectors that span no box stand for none."""
    vectors = np.array(vectors, dtype=np.float32)
    assert not isBox(vectors) and all(map(isBox, _BOXES))
    structure, path = tmp_path / "villin.pdb", tmp_path / "villin.xtc"
    write(structure, villin, villin.positions, None)
    with XTCTrajectoryFile(str(path), "w") as file:
        file.write(villin.positions[np.newaxis].astype(np.float32), box=vectors[np.newaxis])
    (expected,), (found,) = findClashes(structure), findClashes(structure, path)
    assert [clash[:4] for clash in found.clashes] == [clash[:4] for clash in expected.clashes]


@pytest.mark.parametrize("kind", ["pdb", "cif"])
@pytest.mark.parametrize("box", _BOXES, ids=["rectangular", "triclinic"])
def test_snapshot(tmp_path, villin, kind, box):
    torn = wrapped(villin.positions, reducedBox(box), [1.0, 2.0, 3.0])
    path = write(tmp_path / f"torn.{kind}", villin, torn, reducedBox(box))
    structure = readStructure(path)
    assert bondNames(structure.topology) == bondNames(villin.topology)
    moved = structure.positions - structure.positions[0]
    assert moved == pytest.approx(villin.positions - villin.positions[0], abs=1e-3)  # what PDB keeps of the box
    (note,) = [note for note in structure.notes if "periodic box" in note.kind]
    assert note.items == ["chain A"]
    (frame,) = findClashesQuietly(path)
    assert [clash[:2] for clash in frame.clashes] == [clash[:2] for clash in findClashesQuietly()[0].clashes]


def findClashesQuietly(*arguments):
    with pytest.warns(UserWarning):
        return findClashes(*(arguments or [app.__path__[0] + "/data/test.pdb"]))


def test_withoutABox(tmp_path, villin):
    torn = wrapped(villin.positions, _BOXES[0], [1.0, 2.0, 3.0])
    path = write(tmp_path / "torn.pdb", villin, torn, None)
    with pytest.raises(InputError, match="torn.pdb: bonded atoms are far apart .* nm.*if the file has the box$"):
        readStructure(path)


@pytest.mark.parametrize("writer", [writeDCD, writeXTC])
def test_trajectory(tmp_path, villin, writer):
    """Whole in the structure, split in the frames, each at another place."""
    box = reducedBox(_BOXES[1])
    structure = write(tmp_path / "whole.pdb", villin, villin.positions, box)
    shifts = [[1.0, 2.0, 3.0], [2.0, 1.0, 0.5], [0.3, 2.2, 1.9]]
    frames = [wrapped(villin.positions, box, shift) for shift in shifts]
    path = writer(tmp_path / "split", withBox(villin.topology, box), frames)
    with pytest.warns(UserWarning, match=r"^frames in which molecules were split .*\(\d\): frame"):
        found = findClashes(structure, path)
    expected = [clash[:2] for clash in findClashes(structure)[0].clashes]
    assert [[clash[:2] for clash in frame.clashes] for frame in found] == [expected] * 3
    bare = writer(tmp_path / "bare", villin.topology, frames[:1])
    with pytest.raises(InputError, match=r"frame 0 \(from 0\): bonded atoms are far apart"):
        findClashes(structure, bare)


def test_snapshotOfASimulation():
    """No peptide bond is a clash in any frame, though every frame is split otherwise."""
    with pytest.warns(UserWarning, match="frames in which molecules were split"):
        frames = findClashes(realStructurePath("hard/adk_oplsaa.pdb.gz"), realStructurePath("hard/adk_oplsaa.xtc"))
    assert len(frames) == 10
    for frame in frames:
        assert len(frame.clashes) < 20
        assert max(clash.overlap for clash in frame.clashes) < 0.07


# ---- Clashes with images ----

BOX = "the file has a periodic box, the images of which do not count (see --periodic)"


def twoGlycines(path, shift, box, *others):
    """Two chains, the second moved by a vector (Å), in a file with a box (Å)."""
    cell = "CRYST1" + "".join(f"{length:9.3f}" for length in box) + "  90.00  90.00  90.00 P 1           1"
    moved = []
    for line in GLYCINES:
        place = [float(line[start : start + 8]) + step for start, step in zip((30, 38, 46), shift, strict=True)]
        moved.append(line[:21] + "B" + line[22:30] + "".join(f"{value:8.3f}" for value in place) + line[54:])
    return writePDB(path / "images.pdb", [cell, *GLYCINES, *moved, *others])


def notesOnImages(path, *arguments):
    search = ClashSearch(path, *arguments)
    count = sum(len(frame.clashes) for frame in search)
    return count, [note for note in search.notes if "images" in note.kind]


@pytest.mark.parametrize("turns", [(0, 0, 1), (1, 0, 0), (-1, 1, 0), (0, -1, -1)])
def test_clashesWithImagesAreTold(tmp_path, turns):
    """There are as many clashes as with the image in the file."""
    box = np.array([40.0, 42.0, 45.0])
    near = np.array([0.3, 0.2, 2.4])
    expected, notes = notesOnImages(twoGlycines(tmp_path, near, box))
    assert expected > 0 and [str(note) for note in notes] == [BOX]
    count, (note,) = notesOnImages(twoGlycines(tmp_path, near + box * turns, box))
    assert count == 0 and note.kind == "clashes with periodic images, which do not count (see --periodic)"
    assert len(note.items) == expected and all(item.startswith("A:GLY") and " – B:GLY" in item for item in note.items)
    count, notes = notesOnImages(twoGlycines(tmp_path, near + box * turns, box + 20))
    assert count == 0 and [str(note) for note in notes] == [BOX]
    assert notesOnImages(twoGlycines(tmp_path, near + box * turns, (1, 1, 1))) == (0, [])


def test_sampleTellsOfImages(tmp_path):
    structure = readStructure(twoGlycines(tmp_path, (0.3, 0.2, 42.4), (40, 40, 40)))
    notes = [note for note in Sampling(structure, 1).notes if "images" in note.kind]
    assert [note.kind for note in notes] == ["clashes with periodic images, which do not count (see --periodic)"]


@pytest.mark.parametrize("isCellFirst", [True, False])
def test_boxOfEachModel(tmp_path, isCellFirst):
    """As GROMACS and others write trajectories in PDB files: each model has its CRYST1."""
    lines = []
    for number, width in enumerate((42, 30, 30.5, 42)):
        cell, *atoms = twoGlycines(tmp_path, (0.3, 0.2, 32.4), (30, 30, width)).read_text().split("\n")[:-2]
        beginning = [cell, f"MODEL     {number + 1:4}"]
        lines += [*(beginning if isCellFirst else beginning[::-1]), *atoms, "ENDMDL"]
    path = writePDB(tmp_path / "models.pdb", lines)
    counts = [len(frame.clashes) for frame in ClashSearch(path, periodic=True)]
    assert counts[0] == counts[3] == 0 and counts[1] > 0 and counts[2] > 0
    assert [len(frame.clashes) for frame in ClashSearch(path)] == [0] * 4
    assert [readStructure(path, model).box[2, 2] for model in range(4)] == pytest.approx([4.2, 3, 3.05, 4.2])


@pytest.mark.parametrize("kind", ["dcd", "xtc"])
def test_boxOfEachFrame(tmp_path, kind):
    path = twoGlycines(tmp_path, (0.3, 0.2, 32.4), (30, 30, 42))
    positions = readStructure(path).positions.astype(np.float32)
    with (DCDTrajectoryFile if kind == "dcd" else XTCTrajectoryFile)(str(tmp_path / f"frames.{kind}"), "w") as file:
        for width in (42, 30, 30.5, 42):
            if kind == "dcd":
                file.write(10 * positions, cell_lengths=[[30, 30, width]], cell_angles=[[90, 90, 90]])
            else:
                file.write(positions[np.newaxis], box=np.diag([3, 3, 0.1 * width])[np.newaxis].astype(np.float32))
    counts = [len(frame.clashes) for frame in ClashSearch(path, tmp_path / f"frames.{kind}", periodic=True)]
    assert counts[0] == counts[3] == 0 and counts[1] > 0 and counts[2] > 0


def test_bondsAcrossTheBoxAreNoClashes(tmp_path):
    """A chain that is bonded to its own image, as in a crystal of a polymer."""
    link = "LINK         C   GLY A   2                 N   GLY A   1     1555   1555  1.40"
    lines = [line[:38] + f"{0.3 * float(line[38:46]):8.3f}" + line[46:] for line in GLYCINES]
    path = writePDB(tmp_path / "polymer.pdb", ["CRYST1    6.750   30.000   30.000  90.00  90.00  90.00", link, *lines])
    notes = notesOnImages(path)[1]
    assert all("GLY 2 C – A:GLY 1 N" not in item for note in notes for item in note.items)


def test_firstFrameOfATrajectory(tmp_path):
    path = twoGlycines(tmp_path, (0.3, 0.2, 22.4), (40, 40, 40))
    structure = readStructure(path)
    frames = [structure.positions, structure.positions + 1]
    topology = withBox(structure.topology, 4 * np.eye(3))
    far = writeDCD(tmp_path / "far", topology, frames)
    assert [str(note) for note in notesOnImages(path, far)[1]] == [BOX]
    frames[0] = frames[0] + np.where(np.arange(16) < 8, 0, 2)[:, np.newaxis] * [0, 0, 1]
    near = writeDCD(tmp_path / "near", topology, frames)
    (note,) = notesOnImages(path, near)[1]
    assert note.kind == "clashes with periodic images, which do not count (see --periodic), in frame 0 (from 0)"


def test_axesThatCRYST1DoesNotTell():
    """The axes of 4hhb (SCALE) place images elsewhere than CRYST1 alone."""
    assert notesOnImages(realStructurePath("4hhb.pdb"))[1] == []
