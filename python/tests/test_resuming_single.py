"""Single runs are resumed and extended as runs of replicas are, and refuse what these refuse."""

import json
import os
import shutil
import signal
import subprocess
import time
import zlib

import commands
import pytest
from commands import COMMAND, assertRefused, filesIn
from openmmchaintree.command import replicarun
from openmmchaintree.command.outputs.replicafiles import ReplicaFiles
from openmmchaintree.replicas import checkpointfile
from scenes import GLYCINES, readDCD, writePDB, writeSmallStructures
from test_replicas import PROTEIN
from test_resuming import Killed, assertSameRun, counted, killAfter, spoil

HARD = ("run.pdb", "--trials", 40000, "--frames", 20, "--seed", 3)
SOFT = ("dipeptide.pdb", "--forcefield", PROTEIN, "--trials", 4000, "--frames", 20, "--seed", 3)


@pytest.fixture
def runHere(runCommandHere, tmp_path):
    writeSmallStructures(tmp_path)
    return lambda *arguments: runCommandHere("sample", *arguments)


@pytest.fixture(scope="module")
def finishedRun(tmp_path_factory):
    """A folder with a single run that has come to its end."""
    folder = tmp_path_factory.mktemp("single")
    writePDB(folder / "run.pdb", GLYCINES)
    options = ("--trials", 30, "--frames", 3, "--json", "a.json", "--trials-per-round", 10)
    assert commands.run("sample", "run.pdb", *options, folder=folder).returncode == 0
    return folder


@pytest.fixture
def resume(finishedRun, runCommandHere, tmp_path):
    """A function that resumes a copy of that run."""
    shutil.copytree(finishedRun, tmp_path, dirs_exist_ok=True)
    return lambda *arguments: runCommandHere("sample", "--resume", "run.checkpoint", *arguments)


def test_twice(resume, tmp_path):
    """A finished run makes its reports again, and changes nothing."""
    before = {name: (tmp_path / name).read_bytes() for name in filesIn(tmp_path)}
    (tmp_path / "run.png").unlink()
    for _ in range(2):
        result = resume()
        assert result.returncode == 0 and "resumed after 30 trials\n" in result.stdout, result.stderr
    assert {name: (tmp_path / name).read_bytes() for name in filesIn(tmp_path) if name != "run.checkpoint"} == {
        name: content for name, content in before.items() if name != "run.checkpoint"
    }


@pytest.mark.parametrize(
    ("name", "what", "words"),
    [
        ("run.checkpoint", "cut", "run.checkpoint: is not a checkpoint of this command, or damaged"),
        ("run.dcd", "gone", "run.dcd: the file to continue is missing"),
        ("run.dcd", "cut", "run.dcd: is not the trajectory that the run has written"),
        ("run.dcd", "text", "run.dcd: is not the trajectory that the run has written"),
        ("run.csv", "flip", "run.csv: is not the index that the run has written"),
        ("run.csv", "gone", "run.csv: the file to continue is missing"),
    ],
)
def test_damagedFiles(resume, tmp_path, name, what, words):
    spoil(tmp_path / name, what)
    before = {path: (tmp_path / path).read_bytes() for path in filesIn(tmp_path)}
    assertRefused(resume(), tmp_path, sorted(before), words)
    assert before == {path: (tmp_path / path).read_bytes() for path in before}


def test_anIndexOfAnotherVersion(runHere, tmp_path, monkeypatch, capsys):
    """The table of frames of 0.2 has fewer columns: nothing changes, not even frames after the checkpoint."""
    with monkeypatch.context() as patches, pytest.raises(Killed):
        killAfter(patches, replicarun, "writeCheckpoint", 3, True)
        runHere(*HARD, "-o", "run", "--checkpoint-interval", 0)
    capsys.readouterr()
    path = tmp_path / "run.checkpoint"
    header, checkpoints = checkpointfile.readCheckpoint(path)
    index = tmp_path / "run.csv"
    rows = [line.split(",") for line in index.read_bytes()[: header["index"][0]].decode().splitlines()]
    former = "".join(f"{frame},{row[0]},0,,,{row[1]}\n" for frame, row in enumerate(rows[1:]))
    former = f"frame,trials,replica,temperature,potentialEnergy,radiusOfGyration\n{former}".encode()
    index.write_bytes(former + b"1")
    del header["version"], header["digests"]
    header["index"] = [len(former), zlib.crc32(former)]
    checkpointfile.writeCheckpoint(path, header, checkpoints.values())
    before = {name: (tmp_path / name).read_bytes() for name in filesIn(tmp_path)}
    monkeypatch.chdir(tmp_path)
    result = runHere("--resume", "run.checkpoint")
    assertRefused(result, tmp_path, sorted(before), "run.csv: has the columns of another version of openmm-chaintree")
    assert before == {name: (tmp_path / name).read_bytes() for name in before}


def test_anotherStructure(resume, tmp_path):
    writePDB(tmp_path / "run.pdb", [line.replace("2.870", "2.880") for line in GLYCINES])
    assertRefused(resume(), tmp_path, filesIn(tmp_path), "run.checkpoint: is of a run from another structure")


@pytest.mark.parametrize("option", [("--replicas", 2), ("--seed", 5), ("--flexible",), ("--frames", 4)])
def test_otherSettings(resume, tmp_path, option):
    assertRefused(resume(*option), tmp_path, filesIn(tmp_path), option[0])


def test_fewerTrials(resume, tmp_path):
    words = "the run has made 30 trials, and cannot end after 20"
    assertRefused(resume("--trials", 20), tmp_path, filesIn(tmp_path), words)


def test_readOnlyFolder(resume, tmp_path):
    before = {path: (tmp_path / path).read_bytes() for path in filesIn(tmp_path)}
    tmp_path.chmod(0o500)
    try:
        if os.access(tmp_path, os.W_OK):
            pytest.skip("the superuser may write everywhere")
        assertRefused(resume(), tmp_path, sorted(before), "cannot be written (Permission denied)")
    finally:
        tmp_path.chmod(0o700)
    assert before == {path: (tmp_path / path).read_bytes() for path in before}


def test_whileItRuns(runHere, tmp_path, monkeypatch):
    assert runHere(*HARD, "-o", "whole", "--json", "whole.json").returncode == 0
    refusals = []

    def tryOthers(*options):
        if not refusals:
            for others in (["--resume", "cut.checkpoint"], [*HARD, "-o", "cut", "--overwrite"]):
                refusals.append(commands.run("sample", *others, folder=tmp_path))
        return honest(*options)

    honest = ReplicaFiles.add
    monkeypatch.setattr(ReplicaFiles, "add", tryOthers)
    assert runHere(*HARD, "-o", "cut", "--json", "cut.json", "--checkpoint-interval", 0).returncode == 0
    for refusal in refusals:
        assert (refusal.returncode, refusal.stdout) == (2, "")
        assert refusal.stderr == "openmm-chaintree: cut.dcd: another run is writing it\n"
    assertSameRun(tmp_path)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_signal(runHere, tmp_path, number):
    """The interrupted run reports its whole rounds; the resumed one equals one run."""
    options = ("run.pdb", "--trials", 3000000, "--frames", 300, "--seed", 3, "--json", "cut.json")
    command = [*COMMAND, "sample", *map(str, options), "-o", "cut"]
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while not (tmp_path / "cut.csv").exists() or (tmp_path / "cut.csv").stat().st_size < 300:
        time.sleep(0.005)
    process.send_signal(number)
    output, errors = process.communicate()
    assert process.returncode == 128 + number and errors == "", errors
    assert "interrupted: the files hold the frames before the interrupt, and --resume continues" in output
    summary = json.loads((tmp_path / "cut.json").read_text())
    assert summary["interrupted"] and 0 < summary["trials"] < 3000000 and summary["trials"] % 10000 == 0
    assert summary["frames"] == 1 + summary["trials"] // 10000 == len(readDCD(tmp_path / "cut.dcd"))
    assert runHere("--resume", "cut.checkpoint").returncode == 0
    assert runHere(*options[:-1], "whole.json", "-o", "whole").returncode == 0
    assertSameRun(tmp_path)


@pytest.mark.parametrize(("options", "trials"), [(HARD, (40000, 120000)), (SOFT, (4000, 8000, 20000))])
def test_moreTrials(runHere, tmp_path, monkeypatch, options, trials):
    """A run that is extended, and killed meanwhile, equals a run of that length from the start."""
    perFrame = ("--trials-per-frame", trials[0] // 20)
    options = options[:-6] + options[-2:]
    whole = ("--trials", trials[-1], "-o", "whole", "--json", "whole.json")
    assert runHere(*options, *perFrame, *whole).returncode == 0
    cut = ("--trials", trials[0], "-o", "cut", "--json", "cut.json", "--checkpoint-interval", 0)
    assert runHere(*options, *perFrame, *cut).returncode == 0
    for more in trials[1:]:
        with monkeypatch.context() as patches, pytest.raises(Killed):
            killAfter(patches, replicarun, "writeCheckpoint", 2, True)
            runHere("--resume", "cut.checkpoint", "--trials", f"{more:_}")
        result = runHere("--resume", "cut.checkpoint")
        assert result.returncode == 0, result.stderr
    assertSameRun(tmp_path)


def test_checkpointsOfVersion2(runHere, tmp_path, monkeypatch):
    """Which have neither the history of counts nor the stages of trials."""
    options = (*HARD, "--replicas", 2)
    with monkeypatch.context() as patches, pytest.raises(Killed):
        killAfter(patches, replicarun, "writeCheckpoint", 3, False)
        runHere(*options, "-o", "cut", "--json", "cut.json", "--checkpoint-interval", 0)
    path = tmp_path / "cut.checkpoint"
    header, checkpoints = checkpointfile.readCheckpoint(path)
    for name in ("history", "stages"):
        del header["state"][name]
    monkeypatch.setattr(checkpointfile, "_VERSION", 2)
    del header["version"], header["digests"]
    checkpointfile.writeCheckpoint(path, header, checkpoints.values())
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    result = runHere("--resume", "cut.checkpoint")
    assert result.returncode == 0, result.stderr
    assert runHere(*options, "-o", "whole", "--json", "whole.json").returncode == 0
    assert counted(tmp_path, "cut.json") == counted(tmp_path, "whole.json")
