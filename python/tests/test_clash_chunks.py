"""Clashes found in chunks: the same as those found frame by frame, whoever finds them, and of damaged files, too."""

import os
import signal
from concurrent.futures import Future

import numpy as np
import pytest
from commands import assertRefused, filesIn
from openmm import app, unit
from openmmchaintree.errors import InputError
from openmmchaintree.structures import clashchunks
from openmmchaintree.structures.clashchunks import ProcessChunks, describeFiles, searchChunk, searchInChunks
from openmmchaintree.structures.clashsearch import ClashSearch
from scenes import writeDCD, writeXTC

FRAMES = 7


@pytest.fixture(scope="module")
def folder(villin, tmp_path_factory):
    """A folder with villin.pdb, villin.dcd and villin.xtc: frames that shrink, and so clash more and more."""
    folder = tmp_path_factory.mktemp("chunks")
    with open(folder / "villin.pdb", "w") as file:
        app.PDBFile.writeFile(villin.topology, villin.positions * unit.nanometer, file)
    frames = [(1 - 0.02 * frame) * villin.positions for frame in range(FRAMES)]
    for write in (writeDCD, writeXTC):
        write(folder / "villin", villin.topology, frames)
    return folder


class Here:
    """Searches chunks at once, in another order than they are wanted in."""

    def __init__(self, count):
        self.count = count
        self.asked = []

    def submit(self, *arguments):
        self.asked.append((Asked(self), arguments))
        return self.asked[-1][0]


class Asked(Future):
    def __init__(self, workers):
        super().__init__()
        self._workers = workers

    def result(self):
        while self._workers.asked:
            future, arguments = self._workers.asked.pop()
            future.set_result(searchChunk(*arguments))
        return super().result()


def listFrames(search, frames):
    """Return all that was found as plain lists, and what was wrong."""
    found, damage = [], None
    try:
        for number, pairs, overlaps, score, operators in frames:
            operators = None if operators is None else operators.tolist()
            found.append((number, pairs.tolist(), overlaps.tolist(), score, operators))
    except InputError as error:
        damage = str(error)
    search.noteBoxes()
    search.close()
    return found, damage, [str(note) for note in search.notes]


def assertSame(structure, trajectory, frames, damage=None, count=3):
    search = ClashSearch(structure, trajectory)
    expected = listFrames(search, search.overlaps())
    assert len(expected[0]) == frames and (expected[1] is None if damage is None else damage in expected[1])
    search = ClashSearch(structure, trajectory)
    files = describeFiles(search.structure, search.trajectory, None, False, False)
    assert listFrames(search, searchInChunks(search, files, Here(count))) == expected
    return expected


@pytest.mark.parametrize("ending", [".dcd", ".xtc"])
def test_sameAsFrameByFrame(folder, monkeypatch, ending):
    monkeypatch.setattr(clashchunks, "_LONGEST_CHUNK", 2)
    found, _, _ = assertSame(folder / "villin.pdb", folder / f"villin{ending}", FRAMES, count=1)
    counts = [len(pairs) for _, pairs, *_ in found]
    assert counts[0] == 1 and counts == sorted(counts) and len({*counts}) > 4
    monkeypatch.setattr(clashchunks, "_LONGEST_CHUNK", 2)
    assertSame(folder / "villin.pdb", folder / f"villin{ending}", FRAMES)


def test_models(tmp_path, villin):
    with open(tmp_path / "models.pdb", "w") as file:
        app.PDBFile.writeHeader(villin.topology, file)
        for model in range(3):
            app.PDBFile.writeModel(villin.topology, (1 - 0.05 * model) * villin.positions * unit.nanometer, file, model)
        app.PDBFile.writeFooter(villin.topology, file)
    found, _, _ = assertSame(tmp_path / "models.pdb", None, 3)
    assert len({len(pairs) for _, pairs, *_ in found}) == 3


def test_cutOff(folder, tmp_path):
    path = tmp_path / "cut.dcd"
    path.write_bytes((folder / "villin.dcd").read_bytes()[: -3 * (4 * 582 + 8) - 100])
    assertSame(folder / "villin.pdb", path, FRAMES - 2, "frame 5 (from 0) is cut off")


def test_damagedInTheMiddle(folder, tmp_path):
    """What chunks after the damage hold does not count."""
    data = bytearray((folder / "villin.dcd").read_bytes())
    frame = 3 * (4 * 582 + 8)
    data[276 + 3 * frame + 4 : 276 + 3 * frame + 8] = np.float32(np.nan).tobytes()
    (tmp_path / "nan.dcd").write_bytes(data)
    assertSame(folder / "villin.pdb", tmp_path / "nan.dcd", 3, "frame 3 (from 0)")


def test_splitOverTheBox(folder, tmp_path, villin):
    """Frames that are made whole are told in the notes, by their numbers in the trajectory."""
    positions = villin.positions - villin.positions.min(axis=0)
    torn = np.where(positions > 1.5, positions - 6, positions)
    topology = app.PDBFile(str(folder / "villin.pdb")).topology
    topology.setUnitCellDimensions((6, 6, 6) * unit.nanometer)
    writeDCD(tmp_path / "torn", topology, [torn if frame in (2, 5) else positions for frame in range(FRAMES)])
    _, _, notes = assertSame(folder / "villin.pdb", tmp_path / "torn.dcd", FRAMES)
    assert any("frame 2 (from 0)" in note and "frame 5 (from 0)" in note for note in notes)


def test_otherFiles(folder):
    """A worker that sees other files than we do refuses."""
    search = ClashSearch(folder / "villin.pdb", folder / "villin.dcd")
    files = describeFiles(search.structure, search.trajectory, None, False, False)
    with pytest.raises(InputError, match="villin.dcd: a worker finds another file there, of"):
        searchChunk(files._replace(sizes=(files.sizes[0], 7)), 0, 1)
    with pytest.raises(InputError, match="gone.dcd: cannot be read by a worker"):
        searchChunk(files._replace(trajectory=str(folder / "gone.dcd")), 0, 1)
    search.close()


# ---- Processes ----


def test_processes(runCommandHere, folder):
    """The command's files and its output are the same with two processes, which end."""
    files = {}
    for workers in (1, 2):
        outputs = [folder / f"by{workers}{ending}" for ending in (".csv", ".json", ".png")]
        options = ["--csv", outputs[0], "--json", outputs[1], "--picture", outputs[2], "--workers", workers]
        result = runCommandHere("clashes", folder / "villin.pdb", folder / "villin.xtc", *options)
        assert result.returncode == 0 and result.stderr == ""
        shown = result.stdout.replace(f"by{workers}", "by")
        files[workers] = [shown, *(output.read_bytes() for output in outputs)]
    assert "7 frames" in files[1][0] and files[1] == files[2]


def test_aProcessIsKilled(runCommandHere, folder, tmp_path, monkeypatch):
    """One line, and no half-written output."""
    honest = ProcessChunks.submit

    def submit(workers, *arguments):
        future = honest(workers, *arguments)
        for pid in list(workers._pool._processes):
            os.kill(pid, signal.SIGKILL)
        return future

    monkeypatch.setattr(ProcessChunks, "submit", submit)
    monkeypatch.setattr(clashchunks, "_CHUNKS_AHEAD", 1)
    structure, trajectory = folder / "villin.pdb", folder / "villin.dcd"
    before = filesIn(tmp_path)
    result = runCommandHere("clashes", structure, trajectory, "--json", "a.json", "--workers", 2)
    assertRefused(result, tmp_path, before, "a process that looked for clashes was ended from outside")


def test_twoKindsOfWorkers(runCommandHere, folder, tmp_path):
    options = ("--workers", 2, "--scheduler", "tcp://127.0.0.1:1")
    result = runCommandHere("clashes", folder / "villin.pdb", folder / "villin.dcd", *options)
    assertRefused(result, tmp_path, [], "--workers and --scheduler cannot be used together")
