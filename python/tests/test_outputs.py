"""No output is lost, and none is half-written: what the command does with files that it cannot or must not write."""

import csv
import io
import json
import os
import resource
import stat
import subprocess
import threading
from contextlib import contextmanager

import commands
import numpy as np
import pytest
from commands import assertRefused, filesIn
from openmm import app
from openmmchaintree.command import replicasample
from openmmchaintree.command.outputs import output, outputfiles
from openmmchaintree.command.outputs.dcdfile import DCDFile
from openmmchaintree.command.outputs.output import Output, OutputError
from openmmchaintree.command.outputs.outputfiles import Writing
from openmmchaintree.command.replicarun import ReplicaRun
from openmmchaintree.errors import InputError
from scenes import GLYCINES, readDCD, writePDB

FULL = "/dev/full"  # a disk that is full, to every write
NO_SPACE = "No space left on device"

STRUCTURE = "run.pdb"
FILES_OF_A_RUN = [f"run{end}" for end in ("-settings.toml", "-topology.pdb", ".checkpoint", ".csv", ".dcd", ".png")]

needsFullDevice = pytest.mark.skipif(not os.path.exists(FULL), reason=f"there is no {FULL}")


def runWithLargestFile(size, *arguments, folder):
    """Run the command where no file may be larger than `size` bytes, as on a full disk."""
    return subprocess.run(
        [*commands.COMMAND, *map(str, arguments)],
        cwd=folder,
        capture_output=True,
        text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)),
    )


@contextmanager
def largestFile(size):
    """Let no file of this process be larger than `size` bytes."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)


@pytest.fixture
def runHere(runCommandHere, tmp_path):
    """A function that runs the command within this process on two glycines, in tmp_path."""
    writePDB(tmp_path / STRUCTURE, GLYCINES)
    return lambda command, *arguments: runCommandHere(command, STRUCTURE, *arguments)


def oneLine(text):
    assert len(text.splitlines()) == 1, text
    return text.strip()


# ---- Files that are there ----


def test_sampleOverwritesNothing(runHere, tmp_path):
    arguments = ["sample", "--trials", 10, "--frames", 2, "--json", "a.json"]
    files = ["a.json", *FILES_OF_A_RUN]
    for name in files:
        (tmp_path / name).write_text("mine")
        result = runHere(*arguments)
        assertRefused(result, tmp_path, sorted([name, STRUCTURE]), f"{name}: exists; --overwrite replaces it")
        assert (tmp_path / name).read_text() == "mine"
        (tmp_path / name).unlink()
    for name in files:
        (tmp_path / name).write_text("mine")
    result = runHere(*arguments)
    assert result.returncode == 2
    assert "run.dcd, run.csv, run.checkpoint, and 4 more: exist; --overwrite replaces them" in oneLine(result.stderr)
    result = runHere(*arguments, "--overwrite")
    assert result.returncode == 0 and result.stderr == ""
    assert filesIn(tmp_path) == sorted([*files, STRUCTURE])
    assert all(b"mine" not in (tmp_path / name).read_bytes() for name in files)
    assert len(readDCD(tmp_path / "run.dcd")) == 3


def test_clashesOverwritesNothing(runHere, tmp_path):
    arguments = ["clashes", "--json", "a.json", "--csv", "a.csv", "--picture", "a.png"]
    files = ["a.csv", "a.json", "a.png"]
    for name in files:
        (tmp_path / name).write_text("mine")
        result = runHere(*arguments)
        assertRefused(result, tmp_path, sorted([name, STRUCTURE]), f"{name}: exists; --overwrite replaces it")
        assert (tmp_path / name).read_text() == "mine"
        if name != files[-1]:
            (tmp_path / name).unlink()
    assert runHere(*arguments, "--overwrite").returncode == 0
    assert filesIn(tmp_path) == sorted([*files, STRUCTURE]) and b"mine" not in (tmp_path / "a.png").read_bytes()


def test_inputsAreNotReplacedEither(runHere, tmp_path):
    before = (tmp_path / STRUCTURE).read_bytes()
    (tmp_path / "link.json").symlink_to(STRUCTURE)
    os.link(tmp_path / STRUCTURE, tmp_path / "hard.json")
    for name in ("link.json", "hard.json", STRUCTURE):
        result = runHere("sample", "--json", name, "--overwrite")
        assert result.returncode == 2 and f"{name}: would overwrite a file that is read" in oneLine(result.stderr)
    assert (tmp_path / STRUCTURE).read_bytes() == before


def test_whatComesIntoBeingMeanwhileStays(tmp_path):
    output = Output(str(tmp_path / "a.json"))
    output.check()
    assert filesIn(tmp_path) == []
    (tmp_path / "a.json").write_text("mine")
    for write in (lambda: output.write("ours"), output.open):
        with pytest.raises(OutputError, match=r"a\.json: was made in the meantime, and was not overwritten"):
            write()
    assert (tmp_path / "a.json").read_text() == "mine" and filesIn(tmp_path) == ["a.json"]


def test_linksAndRightsAreKept(tmp_path):
    (tmp_path / "a.json").write_text("old")
    (tmp_path / "a.json").chmod(0o640)
    (tmp_path / "link.json").symlink_to("a.json")
    (tmp_path / "new.json").symlink_to("b.json")
    for name in ("link.json", "new.json"):
        Output(str(tmp_path / name), overwrite=True).write("new")
    assert (tmp_path / "link.json").is_symlink() and (tmp_path / "new.json").is_symlink()
    assert (tmp_path / "a.json").read_text() == (tmp_path / "b.json").read_text() == "new"
    assert stat.S_IMODE((tmp_path / "a.json").stat().st_mode) == 0o640


def test_whatSomebodyWritesIsLeftAlone(tmp_path):
    """A file that is open for writing is not opened once more, nor is it emptied."""
    path = tmp_path / "a.csv"
    with Output(str(path)).open() as file:
        file.write(b"theirs")
        other = Output(str(path), True)
        for attempt in (other.check, other.open, other.openThere):
            with pytest.raises(OutputError, match="a.csv: another run is writing it"):
                attempt()
    assert path.read_bytes() == b"theirs"
    other.check()
    other.open().close()
    assert path.read_bytes() == b""


def test_onlyWhatARunHasMadeIsRemoved(tmp_path):
    path = tmp_path / "a.json"
    output = Output(str(path), True)
    path.write_text("theirs")
    output.remove()
    assert path.read_text() == "theirs"
    output.write("ours")
    Output(str(path), True).write("theirs")
    output.remove()
    assert path.read_text() == "theirs"
    output.write("ours")
    output.remove()
    assert filesIn(tmp_path) == []


@pytest.mark.parametrize("options", [[], ["--replicas", 2]])
@pytest.mark.parametrize("moment", ["run", "report"])
def test_aRunOnTheSameFiles(runHere, tmp_path, monkeypatch, moment, options):
    """Whenever another run with --overwrite comes: it is refused, and all files stay those of the first one."""
    arguments = ["sample", "--trials", 300, "--frames", 3, "--overwrite", "--json", "a.json"]
    refusals = []

    def tryAnother(*given, **named):
        if not refusals:
            refusals.append(None)
            refusals[0] = commands.run(arguments[0], STRUCTURE, *arguments[1:], *options, "--seed", 2, folder=tmp_path)
        return honest(*given, **named)

    owner, name = {"run": (ReplicaRun, "run"), "report": (replicasample, "writeReports")}[moment]
    honest = getattr(owner, name)
    monkeypatch.setattr(owner, name, tryAnother)
    assert runHere(*arguments, "--seed", 1).returncode == 0
    assert refusals[0].returncode == 2 and "another run is writing it" in oneLine(refusals[0].stderr)
    assert not any("replica" in name for name in filesIn(tmp_path))
    assert json.loads((tmp_path / "a.json").read_text())["seed"] == 1
    assert "seed = 1\n" in (tmp_path / "run-settings.toml").read_text() and len(readDCD(tmp_path / "run.dcd")) == 4


def test_reportsOfOneRun(tmp_path):
    """Files that are written together get their names together, and none if one is interrupted."""
    first, second = [[Output(str(tmp_path / name), True) for name in ("a.json", "a.csv")] for _ in range(2)]
    with Writing() as writing:
        writing.write(first[0], lambda output: output.write("first"))
        with Writing() as other:
            for output in second:
                other.write(output, lambda output: output.write("second"))
        writing.write(first[1], lambda output: output.write("first"))
    assert {path.read_text() for path in tmp_path.iterdir()} == {"first"} and filesIn(tmp_path) == ["a.csv", "a.json"]
    with pytest.raises(KeyboardInterrupt), Writing() as writing:
        writing.write(second[0], lambda output: output.write("third"))
        raise KeyboardInterrupt
    assert {path.read_text() for path in tmp_path.iterdir()} == {"first"} and filesIn(tmp_path) == ["a.csv", "a.json"]


def test_manyOutputs(tmp_path):
    """Each is looked at once, not once for each other one; two names of one file are found all the same."""
    names = {number: str(tmp_path / f"{number}.dcd") for number in range(20000)}
    with pytest.raises(InputError, match="again.dcd: is named for two outputs"):
        (tmp_path / "19999.dcd").touch()
        (tmp_path / "again.dcd").symlink_to("19999.dcd")
        outputfiles.checkOutputs({**names, "again": str(tmp_path / "again.dcd")}, [], True)


def test_aNameThatIsNoText(runHere, tmp_path):
    """Settings cannot hold it, JSON can."""
    name = os.fsdecode(b"m\xe9in.pdb")
    (tmp_path / STRUCTURE).rename(tmp_path / name)
    result = commands.run("sample", name, "--replicas", 1, folder=tmp_path)
    words = "structure 'm\\udce9in.pdb': settings cannot hold it, since it is not text in utf-8"
    assertRefused(result, tmp_path, [name], words)
    result = commands.run("clashes", name, "--json", "a.json", folder=tmp_path)
    assert result.returncode == 0, result.stderr
    assert json.loads((tmp_path / "a.json").read_text())["structure"] == name


def test_aPipeIsWrittenTo(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    read = []
    reader = threading.Thread(target=lambda: read.append((tmp_path / "pipe").read_text()))
    reader.start()
    output = Output(str(tmp_path / "pipe"))
    output.check()
    output.write("content")
    reader.join()
    assert read == ["content"] and stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)


# ---- Standard output ----


def test_jsonOnStandardOutput(runHere, tmp_path):
    result = runHere("sample", "--trials", 10, "--json", "-")
    assert result.returncode == 0
    assert json.loads(result.stdout)["atoms"] == 8
    names = "run-topology.pdb, run-settings.toml, run.csv, run.checkpoint, run.dcd, run.png"
    assert f"wrote {names}; 11 frames" in result.stderr
    assert filesIn(tmp_path) == sorted([*FILES_OF_A_RUN, STRUCTURE])
    result = runHere("clashes", "--json", "-")
    assert result.returncode == 0
    assert json.loads(result.stdout)["atoms"] == 8
    assert "0 clashes" in result.stderr and "wrote" not in result.stderr


def test_csvOnStandardOutput(runHere, tmp_path):
    result = runHere("clashes", "--csv", "-", "--json", "a.json")
    assert csv.DictReader(io.StringIO(result.stdout)).fieldnames[0] == "frame"
    assert "0 clashes" in result.stderr and "wrote a.json" in result.stderr
    assert filesIn(tmp_path) == ["a.json", STRUCTURE]


def test_onlyOneOnStandardOutput(runHere, tmp_path):
    result = runHere("clashes", "--csv", "-", "--json", "-")
    assertRefused(result, tmp_path, [STRUCTURE], "standard output (-): is named for two outputs")


def test_aFileNamedLikeStandardOutput(runHere, tmp_path):
    result = runHere("clashes", "--json", "./-")
    assert result.returncode == 0 and "0 clashes" in result.stdout
    assert filesIn(tmp_path) == ["-", STRUCTURE]


@needsFullDevice
@pytest.mark.parametrize("options", [[], ["--json", "-"]])
def test_standardOutputIsFull(tmp_path, options):
    writePDB(tmp_path / STRUCTURE, GLYCINES)
    command = [*commands.COMMAND, "clashes", STRUCTURE, *options]
    with open(FULL, "w") as full:
        result = subprocess.run(command, cwd=tmp_path, stdout=full, stderr=subprocess.PIPE, text=True)
    assert result.returncode == 2
    assert result.stderr.splitlines()[-1] == f"openmm-chaintree: standard output: {NO_SPACE}"
    assert "Traceback" not in result.stderr and "Exception" not in result.stderr


# ---- A disk that is full ----


@needsFullDevice
@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("run.dcd", "is not a regular file, and a run reads what it wrote"),
        ("run.csv", "is not a regular file"),
        ("run.checkpoint", "is not a regular file"),
        ("run-topology.pdb", f"cannot be written ({NO_SPACE})\n"),
    ],
)
def test_noRoomForTheTrajectory(runHere, tmp_path, name, words):
    (tmp_path / name).symlink_to(FULL)
    result = runHere("sample", "--trials", 100)
    assertRefused(result, tmp_path, sorted([name, STRUCTURE]), f"openmm-chaintree: {name}: {words}")
    assert (tmp_path / name).is_symlink()


@needsFullDevice
@pytest.mark.parametrize("name", ["run.png", "a.json"])
def test_noRoomForOneFileOfARun(runHere, tmp_path, name):
    """The others are written, and what was sampled is told."""
    (tmp_path / name).symlink_to(FULL)
    result = runHere("sample", "--trials", 100, "--frames", 3, "--json", "a.json")
    assert result.returncode == 2
    assert oneLine(result.stderr) == f"openmm-chaintree: {name}: cannot be written ({NO_SPACE})"
    others = {*FILES_OF_A_RUN, "a.json"} - {name}
    wrote = result.stdout.splitlines()[-1]
    assert "attempted" in result.stdout and name not in wrote and all(other in wrote for other in others)
    assert filesIn(tmp_path) == sorted([*others, name, STRUCTURE])
    assert len(readDCD(tmp_path / "run.dcd")) == 4


@needsFullDevice
@pytest.mark.parametrize("name", ["a.json", "a.csv", "a.png"])
def test_noRoomForOneFileOfASearch(runHere, tmp_path, name):
    (tmp_path / name).symlink_to(FULL)
    result = runHere("clashes", "--json", "a.json", "--csv", "a.csv", "--picture", "a.png")
    assert result.returncode == 2
    assert oneLine(result.stderr) == f"openmm-chaintree: {name}: cannot be written ({NO_SPACE})"
    others = [other for other in ("a.csv", "a.json", "a.png") if other != name]
    assert "0 clashes" in result.stdout and f"wrote {', '.join(sorted(others))}" in result.stdout
    assert all((tmp_path / other).stat().st_size > 0 for other in others)


def test_theDiskFillsWhileSampling(runHere, tmp_path):
    """The trajectory is partial and has whole frames; with free space, the run can be resumed."""
    writePDB(tmp_path / STRUCTURE, GLYCINES)
    options = ("--trials", 2000, "--json", "a.json", "--seed", 1)
    result = runWithLargestFile(10000, "sample", STRUCTURE, *options, folder=tmp_path)
    assert result.returncode == 2
    partial = "run.dcd: cannot be written (File too large); run.dcd is partial: it holds the first 81 of 201 frames"
    continues = "--resume run.checkpoint continues the run from its last checkpoint"
    assert oneLine(result.stderr) == f"openmm-chaintree: {partial}; {continues}"
    names = ["run-settings.toml", "run-topology.pdb", "run.checkpoint", "run.csv", "run.dcd", STRUCTURE]
    assert filesIn(tmp_path) == sorted(names) and len(readDCD(tmp_path / "run.dcd")) == 81
    assert runHere("sample", "--resume", "run.checkpoint").returncode == 0
    assert runHere("sample", *options[:3], "b.json", "--seed", 1, "-o", "whole").returncode == 0
    assert np.array_equal(readDCD(tmp_path / "run.dcd"), readDCD(tmp_path / "whole.dcd"))


def test_noRoomForAnything(tmp_path):
    writePDB(tmp_path / STRUCTURE, GLYCINES)
    result = runWithLargestFile(100, "sample", STRUCTURE, folder=tmp_path)
    assertRefused(result, tmp_path, [STRUCTURE], "run-topology.pdb: cannot be written (File too large)")
    files = ["--json", "a.json", "--csv", "a.csv", "--picture", "a.png"]
    result = runWithLargestFile(20, "clashes", STRUCTURE, *files, folder=tmp_path)
    assert result.returncode == 2 and filesIn(tmp_path) == [STRUCTURE]
    assert oneLine(result.stderr).count("cannot be written (File too large)") == 3
    assert "0 clashes" in result.stdout and "wrote" not in result.stdout


def test_noRoomForTheFirstFrame(tmp_path):
    topology = app.PDBFile(str(writePDB(tmp_path / "glycines.pdb", GLYCINES))).topology
    output = Output(str(tmp_path / "a.dcd"))
    with largestFile(300), pytest.raises(OutputError, match=r"^[^;]*a\.dcd: cannot be written \(File too large\)$"):
        DCDFile(output, topology, np.zeros((8, 3)), 1, 2)
    assert filesIn(tmp_path) == ["glycines.pdb"]


def test_whatWasThereStaysIfThereIsNoRoom(tmp_path):
    (tmp_path / "a.json").write_text("old")
    with largestFile(20), pytest.raises(OutputError, match=r"a\.json: cannot be written \(File too large\)"):
        Output(str(tmp_path / "a.json"), overwrite=True).write("new" * 100)
    assert (tmp_path / "a.json").read_text() == "old" and filesIn(tmp_path) == ["a.json"]


@pytest.mark.parametrize("items", [[], [{"a": [1, "b\nc"], "ü": None}], [1, [], {}]])
def test_pieces(tmp_path, items):
    """What is yielded piece by piece is what would be written at once."""
    Output(str(tmp_path / "a.json")).write(outputfiles.asJSONWith({"x": 1.5, "y": [2]}, "items", iter(items)))
    assert (tmp_path / "a.json").read_text("utf-8") == outputfiles.asJSON({"x": 1.5, "y": [2], "items": items})


# ---- Ctrl-C ----


@pytest.mark.parametrize("overwrite", [False, True])
@pytest.mark.parametrize("moment", ["write", "replace"])
def test_interruptWhileAFileIsWritten(tmp_path, monkeypatch, overwrite, moment):
    if overwrite:
        (tmp_path / "a.json").write_text("old")

    def interrupted(*arguments):
        raise KeyboardInterrupt

    def pieces():
        yield "new" * 10000
        if moment == "write":
            interrupted()

    if moment == "replace":
        monkeypatch.setattr(output.Path, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        Output(str(tmp_path / "a.json"), overwrite).write(pieces())
    assert filesIn(tmp_path) == (["a.json"] if overwrite else [])
    assert not overwrite or (tmp_path / "a.json").read_text() == "old"


class _InterruptedFile(io.FileIO):
    """Is interrupted after writing a given number of bytes."""

    bytesLeft = 0

    def write(self, data):
        if self.bytesLeft < len(data):
            super().write(data[: self.bytesLeft])
            raise KeyboardInterrupt
        self.bytesLeft -= len(data)
        return super().write(data)


@pytest.mark.parametrize("bytesLeft", [0, 100, 276, 300, 700, 850])
def test_interruptWithinAFrame(tmp_path, monkeypatch, bytesLeft):
    topology = app.PDBFile(str(writePDB(tmp_path / "glycines.pdb", GLYCINES))).topology
    monkeypatch.setattr(_InterruptedFile, "bytesLeft", bytesLeft)
    monkeypatch.setattr(output.io, "FileIO", _InterruptedFile)
    positions = np.random.default_rng(1).random((5, 8, 3))
    with pytest.raises(KeyboardInterrupt):
        with DCDFile(Output(str(tmp_path / "a.dcd")), topology, positions[0], 1, 10) as trajectory:
            for frame in positions[1:]:
                trajectory.write(frame)
    count = max(0, (bytesLeft - 276) // 120)
    assert filesIn(tmp_path) == (["a.dcd"] if count > 0 else []) + ["glycines.pdb"]
    if count > 0:
        assert readDCD(tmp_path / "a.dcd") == pytest.approx(positions[:count], abs=1e-6)


def test_moreTrialsThanADCDFileCanCount(tmp_path):
    topology = app.PDBFile(str(writePDB(tmp_path / "glycines.pdb", GLYCINES))).topology
    interval = 10**12
    with DCDFile(Output(str(tmp_path / "a.dcd")), topology, np.zeros((8, 3)), interval, 2) as trajectory:
        trajectory.write(np.ones((8, 3)))
    assert len(readDCD(tmp_path / "a.dcd")) == 2 and trajectory.interval == interval
