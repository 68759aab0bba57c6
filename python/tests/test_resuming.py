"""Runs of replicas that are killed, interrupted or fail, and are resumed, write what one run writes."""

import io
import json
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

import pytest
from commands import COMMAND, assertRefused, filesIn
from openmmchaintree.command import replicarun, savedrun
from openmmchaintree.command.outputs import outputfiles, replicafiles
from openmmchaintree.command.outputs.replicafiles import ReplicaFiles
from openmmchaintree.errors import InputError
from openmmchaintree.replicas import checkpointfile
from scenes import GLYCINES, readDCD, writePDB, writeSmallStructures
from test_outputs import largestFile
from test_replicas import PROTEIN, contents

OPTIONS = ("run.pdb", "--replicas", 2, "--workers", 2, "--trials", 600000, "--frames", 29, "--seed", 3)
OPTIONS += ("--checkpoint-interval", 0)
IN_FORCE_FIELD = (
    "dipeptide.pdb",
    "--temperatures",
    "300:500:3",
    "--forcefield",
    PROTEIN,
    "--trials-per-exchange",
    800,
    "--seed",
    3,
)


@pytest.fixture
def runHere(runCommandHere, tmp_path):
    writeSmallStructures(tmp_path)
    return lambda *arguments: runCommandHere("sample", *arguments)


def counted(folder, name):
    """What a summary counts; times are left out."""
    summary = json.loads((folder / name).read_text())
    return {key: value for key, value in summary.items() if "econd" not in key and key not in ("busy", "files")}


def killAndResume(folder, options, kills, seed):
    """Run in a folder, kill the run at random times, resume it, and return how often a kill worked."""
    chance, cuts, hasBegun = random.Random(seed), 0, False
    while True:
        arguments = ["--resume", "cut.checkpoint"] if hasBegun else [*options, "-o", "cut", "--json", "cut.json"]
        command = [*COMMAND, "sample", *map(str, arguments)]
        process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if kills > 0:
            waitForChange(process, folder / "cut.checkpoint")
            time.sleep(chance.uniform(0, 0.2))
            cuts += process.poll() is None
            process.kill()
            kills -= 1
        _, errors = process.communicate()
        hasBegun = True
        if process.returncode != -signal.SIGKILL:
            assert process.returncode == 0, errors
            return cuts


def waitForChange(process, path):
    """Wait until a file has come or changed, or the process has ended."""
    before = path.stat().st_mtime_ns if path.exists() else None
    while process.poll() is None and not (path.exists() and path.stat().st_mtime_ns != before):
        time.sleep(0.001)


def test_killedAtRandomTimes(runHere, tmp_path, kills=2, seed=1):
    """By SIGKILL, at any moment: nothing is lost or counted twice."""
    assert runHere(*OPTIONS, "-o", "whole", "--json", "whole.json").returncode == 0
    assert killAndResume(tmp_path, OPTIONS, kills, seed) > kills / 2
    assert contents(tmp_path, "cut") == contents(tmp_path, "whole")
    assert counted(tmp_path, "cut.json") == counted(tmp_path, "whole.json")
    for replica in range(2):
        assert len(readDCD(tmp_path / f"cut-replica-{replica}.dcd")) == 30
    assert not list(tmp_path.glob("*.part"))


@pytest.mark.parametrize(
    "options",
    [
        ("--frames", 300, "--trials", 300000),
        ("--forcefield", PROTEIN, "--trials", 16000, "--frames", 16, "--steric", "hard"),
    ],
)
def test_aSingleRunKilledAtRandomTimes(runHere, tmp_path, options, kills=1, seed=2):
    options = ("dipeptide.pdb", *options, "--seed", 3, "--checkpoint-interval", 0)
    assert runHere(*options, "-o", "whole", "--json", "whole.json").returncode == 0
    assert killAndResume(tmp_path, options, kills, seed) > kills / 2
    assertSameRun(tmp_path)
    assert not list(tmp_path.glob("*.part"))


def assertSameRun(folder):
    """Whether all results of the single runs "cut" and "whole" have the same bits."""
    cut, whole = ((folder / f"{name}.dcd").read_bytes()[276:] for name in ("cut", "whole"))
    assert cut == whole
    for ending in (".csv", "-topology.pdb", ".png"):
        assert (folder / f"cut{ending}").read_bytes() == (folder / f"whole{ending}").read_bytes(), ending
    assert counted(folder, "cut.json") == counted(folder, "whole.json")


class Killed(BaseException):
    """What nobody handles."""


def killAfter(monkeypatch, owner, name, calls, before):
    """Raise Killed at a given call of a function, before or after the call."""
    honest = getattr(owner, name)

    def counting(*arguments, **named):
        nonlocal calls
        calls -= 1
        if calls == 0 and before:
            raise Killed
        result = honest(*arguments, **named)
        if calls == 0:
            raise Killed
        return result

    monkeypatch.setattr(owner, name, counting)


@pytest.mark.parametrize(
    ("owner", "name", "calls", "before"),
    [
        (ReplicaFiles, "add", 5, False),
        (replicafiles.IndexFile, "write", 4, False),
        (ReplicaFiles, "sync", 3, False),
        (checkpointfile.os, "replace", 4, True),  # from Python 3.11 on the first two are of other files
        (checkpointfile.zipfile.ZipFile, "writestr", 7, False),
        (replicarun, "writeCheckpoint", 3, False),
    ],
)
def test_killedAtEachMoment(runHere, tmp_path, monkeypatch, owner, name, calls, before):
    """Replicas that exchange, killed where files and the checkpoint do not agree yet."""
    options = (*IN_FORCE_FIELD, "--trials", 2400, "--frames", 5, "--checkpoint-interval", 0, "--workers", 1)
    if not WHOLE:
        assert runHere(*options, "-o", "whole", "--json", "whole.json").returncode == 0
        WHOLE["contents"], WHOLE["counts"] = contents(tmp_path, "whole"), counted(tmp_path, "whole.json")
    with monkeypatch.context() as patches, pytest.raises(Killed):
        killAfter(patches, owner, name, calls, before)
        runHere(*options, "-o", "cut", "--json", "cut.json")
    assert not (tmp_path / "cut.json").exists()
    result = runHere("--resume", "cut.checkpoint", "--workers", 2)
    assert result.returncode == 0, result.stderr
    assert contents(tmp_path, "cut") == WHOLE["contents"]
    assert counted(tmp_path, "cut.json") == {**WHOLE["counts"], "workers": 2}
    assert not (tmp_path / "cut.checkpoint.part").exists()


WHOLE = {}


IN_SOLVENT = ("--forcefield", "amber14-all.xml", "implicit/gbn2.xml")


@pytest.mark.parametrize(
    "options",
    [
        IN_SOLVENT,
        (*IN_SOLVENT, "--flexible"),
        (*IN_SOLVENT, "--disordered"),
        (*IN_SOLVENT, "--periodic", "--nonbonded-cutoff", 0.9),
        ("--forcefield", PROTEIN, "--no-native-energies"),
        ("--periodic", "--rigid-bodies"),
    ],
)
def test_aSingleRunOfAnyKind(runHere, tmp_path, monkeypatch, options):
    """Killed after frames that its last checkpoint does not count, one of them torn."""
    options = ("boxed.pdb", *options, "--trials", 1600, "--frames", 8, "--seed", 3, "--trials-per-round", 400)
    text = (tmp_path / "dipeptide.pdb").read_text()
    (tmp_path / "boxed.pdb").write_text("CRYST1   30.000   31.000   32.000  90.00  90.00  90.00 P 1\n" + text)
    assert runHere(*options, "-o", "whole", "--json", "whole.json").returncode == 0
    with monkeypatch.context() as patches, pytest.raises(Killed):
        killAfter(patches, ReplicaFiles, "add", 5, False)
        runHere(*options, "-o", "cut", "--json", "cut.json", "--checkpoint-interval", 0)
    with open(tmp_path / "cut.dcd", "ab") as file:
        file.write(b"torn")
    result = runHere("--resume", "cut.checkpoint")
    assert result.returncode == 0 and "resumed after 800 trials" in result.stdout, result.stderr
    assertSameRun(tmp_path)


def test_interruptedOnce(tmp_path):
    """After Ctrl-C the run reports what it has, and can be resumed."""
    writePDB(tmp_path / "run.pdb", GLYCINES)
    command = [*COMMAND, "sample", "run.pdb", "--replicas", "2", "--trials", "100000000", "--seed", "1"]
    command += ["--frames", "10000", "--json", "a.json"]
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while not (tmp_path / "run-index.csv").exists() or (tmp_path / "run-index.csv").stat().st_size < 300:
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate()
    assert process.returncode == 130 and errors == ""
    assert "interrupted: the files hold the frames before the interrupt, and --resume continues" in output
    summary = json.loads((tmp_path / "a.json").read_text())
    assert summary["interrupted"] and 0 < summary["trials"] < 100000000 and summary["trials"] % 10000 == 0
    assert summary["frames"] == 1 + summary["trials"] // 10000
    for replica in range(2):
        assert len(readDCD(tmp_path / f"run-replica-{replica}.dcd")) == summary["frames"]
    assert len((tmp_path / "run-index.csv").read_text().splitlines()) == 1 + 2 * summary["frames"]


@pytest.fixture(scope="module")
def finishedRun(tmp_path_factory):
    """A folder with a run that has come to its end."""
    folder = tmp_path_factory.mktemp("finished")
    writePDB(folder / "run.pdb", GLYCINES)
    command = [*COMMAND, "sample", "run.pdb", "--replicas", "2", "--trials", "30", "--frames", "3", "--json", "a.json"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return folder


@pytest.fixture
def finished(finishedRun, tmp_path):
    """A copy of that folder, which is the present one to the command."""
    shutil.copytree(finishedRun, tmp_path, dirs_exist_ok=True)


def test_aFinishedRunReportsAgain(finished, runHere, tmp_path):
    before, files = contents(tmp_path, "run"), filesIn(tmp_path)
    counts = counted(tmp_path, "a.json")
    (tmp_path / "run.png").unlink()
    result = runHere("--resume", "run.checkpoint")
    assert result.returncode == 0 and "resumed after 30 trials of each" in result.stdout
    assert contents(tmp_path, "run") == before and filesIn(tmp_path) == files
    assert counted(tmp_path, "a.json") == counts
    (tmp_path / "b.json").write_text("mine")
    result = runHere("--resume", "run.checkpoint", "--json", "b.json")
    assertRefused(result, tmp_path, sorted([*files, "b.json"]), "b.json: exists; --overwrite replaces it")
    assert (tmp_path / "b.json").read_text() == "mine"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--frames", 4], "run.checkpoint: a resumed run keeps its settings, also --frames"),
        (["--seed", 2], "also --seed"),
        (["-o", "other"], "also --output"),
        (["other.pdb"], "also structure"),
        (["--config", "run-settings.toml"], "--config and --resume cannot be used together"),
    ],
)
def test_otherSettings(finished, runHere, tmp_path, options, words):
    writePDB(tmp_path / "other.pdb", GLYCINES)
    files = filesIn(tmp_path)
    assertRefused(runHere("--resume", "run.checkpoint", *options), tmp_path, files, words)


def test_killedBetweenReports(runHere, tmp_path, monkeypatch):
    """What was written at the end is the run's, whatever came after it; what anybody else has written is not."""
    arguments = ("run.pdb", "--replicas", 1, "--trials", 30, "--frames", 3, "--json", "a.json", "--notes", "a.txt")
    with monkeypatch.context() as patches, pytest.raises(Killed):
        killAfter(patches, outputfiles.Writing, "write", 2, False)
        runHere(*arguments)
    assert (tmp_path / "run.png").exists() and not (tmp_path / "a.json").exists()
    (tmp_path / "a.json").write_text("mine")
    result = runHere("--resume", "run.checkpoint")
    assert result.stderr == "openmm-chaintree: a.json: exists; --overwrite replaces it\n"
    assert (tmp_path / "a.json").read_text() == "mine"
    (tmp_path / "a.json").unlink()
    result = runHere("--resume", "run.checkpoint")
    assert result.returncode == 0, result.stderr
    (tmp_path / "run.png").write_text("redrawn")
    files = filesIn(tmp_path)
    assertRefused(runHere("--resume", "run.checkpoint"), tmp_path, files, "run.png: exists; --overwrite replaces it")
    assert (tmp_path / "run.png").read_text() == "redrawn"


def test_twoAtATime(runHere, tmp_path, monkeypatch):
    """A run that is being written is left alone by all others."""
    arguments = ("run.pdb", "--replicas", 2, "--workers", 1, "--trials", 60000, "--frames", 30, "--seed", 1)
    assert runHere(*arguments, "-o", "whole").returncode == 0
    refusals = []

    def tryOthers(*options):
        if not refusals:
            for others in (["--resume", "run.checkpoint"], [*arguments, "--overwrite"], ["run.pdb", "--overwrite"]):
                command = [*COMMAND, "sample", *map(str, others)]
                refusals.append(subprocess.run(command, cwd=tmp_path, capture_output=True, text=True))
        return honest(*options)

    honest = ReplicaFiles.add
    monkeypatch.setattr(ReplicaFiles, "add", tryOthers)
    (tmp_path / "run.dcd").symlink_to("run-replica-0.dcd")
    assert runHere(*arguments, "--checkpoint-interval", 0).returncode == 0
    for refusal, name in zip(refusals, ("run-index.csv", "run-index.csv", "run.dcd"), strict=True):
        assert (refusal.returncode, refusal.stdout) == (2, "")
        assert refusal.stderr == f"openmm-chaintree: {name}: another run is writing it\n"
    assert contents(tmp_path, "run") == contents(tmp_path, "whole")


@pytest.mark.parametrize(("option", "name"), [("--resume", "run.checkpoint"), ("--config", "run-settings.toml")])
def test_fromAnotherFolder(finished, runHere, tmp_path, option, name):
    """Names in a file mean what they mean beside the command, which one line says where they mean nothing."""
    (tmp_path / "inner").mkdir()
    shutil.copy(tmp_path / name, tmp_path / "inner")
    (tmp_path / "run.pdb").unlink()
    words = f"run.pdb: there is no such file; names in inner/{name} are relative to where the command runs"
    assertRefused(runHere(option, f"inner/{name}"), tmp_path, filesIn(tmp_path), words)


# ---- More trials ----


@pytest.mark.parametrize(
    ("options", "trials", "frames"),
    [
        (("run.pdb", "--replicas", 2, "--trials-per-round", 250, "--seed", 3), (500, 2000), (4, 16)),
        (IN_FORCE_FIELD, (1600, 2400, 4800), (4, 6, 12)),
    ],
)
def test_moreTrials(runHere, tmp_path, monkeypatch, options, trials, frames):
    """A run that is extended, and killed meanwhile, equals a run of that length from the start."""
    options = (*options, "--workers", 1, "--checkpoint-interval", 0)
    whole = ("--trials", trials[-1], "--frames", frames[-1], "-o", "whole", "--json", "whole.json")
    assert runHere(*options, *whole).returncode == 0
    cut = ("--trials", trials[0], "--frames", frames[0], "-o", "cut", "--json", "cut.json")
    assert runHere(*options, *cut).returncode == 0
    for more in trials[1:]:
        with monkeypatch.context() as patches, pytest.raises(Killed):
            killAfter(patches, replicarun, "writeCheckpoint", 3, True)
            runHere("--resume", "cut.checkpoint", "--trials", more)
        result = runHere("--resume", "cut.checkpoint")
        assert result.returncode == 0, result.stderr
    assert contents(tmp_path, "cut") == contents(tmp_path, "whole")
    assert counted(tmp_path, "cut.json") == counted(tmp_path, "whole.json")
    settings = (tmp_path / "cut-settings.toml").read_text()
    assert settings.replace('"cut', '"whole') == (tmp_path / "whole-settings.toml").read_text()
    assert len(readDCD(next(tmp_path.glob("cut-*.dcd")))) == 1 + frames[-1]


@pytest.mark.parametrize(
    ("trials", "frames", "perRound", "more", "words"),
    [
        (30, 3, 10, 20, "run.checkpoint: the run has made 30 trials, and cannot end after 20"),
        (30, 3, 10, 45, "run.checkpoint: --trials has to be a multiple of the 10 between frames"),
        (30, 3, 20, 40, "cannot be continued to more trials, since its last round ended after fewer than 20 of them"),
        (30, 4, 10, 40, "cannot be continued to more trials, since its last frame came after fewer than 8 of them"),
    ],
)
def test_noMoreTrials(runHere, tmp_path, trials, frames, perRound, more, words):
    options = ("--replicas", 1, "--trials", trials, "--frames", frames, "--trials-per-round", perRound)
    assert runHere("run.pdb", *options).returncode == 0
    before = {path: (tmp_path / path).read_bytes() for path in filesIn(tmp_path)}
    assertRefused(runHere("--resume", "run.checkpoint", "--trials", more), tmp_path, sorted(before), words)
    assert before == {path: (tmp_path / path).read_bytes() for path in before}


def test_settingsOfTheUserStay(runHere, tmp_path):
    """A file of settings that is not as the run has written it."""
    options = ("--replicas", 1, "--trials", 30, "--frames", 3, "--trials-per-round", 10)
    assert runHere("run.pdb", *options).returncode == 0
    path = tmp_path / "run-settings.toml"
    path.write_text("# mine\n" + path.read_text())
    before = path.read_text()
    result = runHere("--resume", "run.checkpoint", "--trials", 60, "--workers", 1)
    assert result.returncode == 0 and "1 replica, 60 trials of each, by 1 worker in" in result.stdout
    assert path.read_text() == before and len(readDCD(tmp_path / "run-replica-0.dcd")) == 7


def spoil(path, what):
    data = bytearray(path.read_bytes())
    if what == "cut":
        del data[-10:]
    elif what == "flip":
        data[len(data) // 3] ^= 1
    elif what == "text":
        data = b"mine"
    elif what in ("version", "swap"):
        source = zipfile.ZipFile(io.BytesIO(data))
        with zipfile.ZipFile(path, "w") as archive:
            header = source.read("run.json")
            archive.writestr(
                "run.json", header.replace(b'"version": 3', b'"version": 9') if what == "version" else header
            )
            for name, other in (("0", "1"), ("1", "0")):
                archive.writestr(name, source.read(other))
        return
    elif what == "gone":
        return path.unlink()
    path.write_bytes(data)


@pytest.mark.parametrize(
    ("name", "what", "words"),
    [
        ("run.checkpoint", "gone", "run.checkpoint: there is no such file"),
        ("run.checkpoint", "cut", "run.checkpoint: is not a checkpoint of this command, or damaged"),
        ("run.checkpoint", "flip", "run.checkpoint: is not a checkpoint of this command, or damaged"),
        ("run.checkpoint", "text", "run.checkpoint: is not a checkpoint of this command, or damaged"),
        ("run.checkpoint", "version", "run.checkpoint: is of another version of openmm-chaintree"),
        ("run.checkpoint", "swap", "or damaged (the checkpoint of replica 0 is not what was written)"),
        ("run-replica-1.dcd", "gone", "run-replica-1.dcd: the file to continue is missing"),
        ("run-replica-1.dcd", "cut", "run-replica-1.dcd: is not the trajectory that the run has written"),
        ("run-replica-1.dcd", "text", "run-replica-1.dcd: is not the trajectory that the run has written"),
        ("run-index.csv", "gone", "run-index.csv: the file to continue is missing"),
        ("run-index.csv", "cut", "run-index.csv: is not the index that the run has written"),
        ("run-index.csv", "flip", "run-index.csv: is not the index that the run has written"),
    ],
)
def test_damagedFiles(finished, runHere, tmp_path, name, what, words):
    spoil(tmp_path / name, what)
    before = {path: (tmp_path / path).read_bytes() for path in filesIn(tmp_path)}
    assertRefused(runHere("--resume", "run.checkpoint"), tmp_path, sorted(before), words)
    assert before == {path: (tmp_path / path).read_bytes() for path in before}


def test_anyDamageIsNoticed(tmp_path):
    """A bit that is wrong changes nothing that counts, or is noticed."""
    path = tmp_path / "a.checkpoint"
    content = {"counts": list(range(100))}, [random.Random(1).randbytes(300), b"text " * 100]
    checkpointfile.writeCheckpoint(path, *content)
    whole, sound = path.read_bytes(), checkpointfile.readCheckpoint(path)
    assert sound[0]["counts"] == content[0]["counts"] and [sound[1][0], sound[1][1]] == content[1]
    noticed = 0
    for bit in range(0, 8 * len(whole), 7):
        data = bytearray(whole)
        data[bit // 8] ^= 1 << bit % 8
        path.write_bytes(data)
        try:
            assert checkpointfile.readCheckpoint(path) == sound
        except InputError:
            noticed += 1
    assert noticed > 0.8 * 8 * len(whole) / 7


def test_noRoomForACheckpoint(tmp_path):
    """The former one stays, and nothing else."""
    path = tmp_path / "a.checkpoint"
    checkpointfile.writeCheckpoint(path, {"counts": 1}, [b"former"])
    with largestFile(1000), pytest.raises(OSError):
        checkpointfile.writeCheckpoint(path, {"counts": 2}, [random.Random(1).randbytes(2000)])
    header, checkpoints = checkpointfile.readCheckpoint(path)
    assert header["counts"] == 1 and checkpoints == {0: b"former"} and filesIn(tmp_path) == ["a.checkpoint"]


@pytest.mark.parametrize("year", [1970, 2150])
def test_anyClock(tmp_path, monkeypatch, year):
    """The format of the file knows the years from 1980 to 2107."""
    monkeypatch.setattr(checkpointfile.zipfile.time, "localtime", lambda _: time.struct_time((year, *8 * [1])))
    checkpointfile.writeCheckpoint(tmp_path / "a.checkpoint", {"counts": 1}, [b"first"])
    assert checkpointfile.readCheckpoint(tmp_path / "a.checkpoint")[1] == {0: b"first"}


def test_filesOfTheUserBesideACheckpoint(runHere, tmp_path):
    """None is written, and no link followed."""
    (tmp_path / "mine.txt").write_text("mine")
    (tmp_path / "run.checkpoint.part").symlink_to("mine.txt")
    assert runHere("run.pdb", "--replicas", 2, "--trials", 30, "--frames", 3).returncode == 0
    assert (tmp_path / "mine.txt").read_text() == "mine" and (tmp_path / "run.checkpoint.part").is_symlink()


def test_whatAKillLeavesIsRemoved(finished, runHere, tmp_path):
    name = checkpointfile.readCheckpoint(tmp_path / "run.checkpoint")[0]["temporary"]
    files = filesIn(tmp_path)
    (tmp_path / "mine.txt").write_text("mine")
    (tmp_path / name).symlink_to("mine.txt")
    assert runHere("--resume", "run.checkpoint").returncode == 0
    assert (tmp_path / "mine.txt").read_text() == "mine" and filesIn(tmp_path) == sorted([*files, "mine.txt"])


@pytest.mark.parametrize("name", ["fsync", "replace"])
def test_theFirstCheckpointFails(runHere, tmp_path, monkeypatch, name):
    def fail(*arguments):
        raise OSError(28, "No space left on device")

    files = filesIn(tmp_path)
    honest, calls = getattr(checkpointfile.os, name), []

    def failOfCheckpoint(*arguments):
        calls.append(arguments)
        isOfCheckpoint = arguments[-1] == tmp_path / "run.checkpoint" if name == "replace" else len(calls) > 3
        return fail() if isOfCheckpoint else honest(*arguments)

    monkeypatch.setattr(checkpointfile.os, name, failOfCheckpoint)
    result = runHere("run.pdb", "--replicas", 2, "--trials", 30, "--frames", 3)
    monkeypatch.undo()
    assertRefused(result, tmp_path, files, "run.checkpoint: cannot be written (No space left on device)")


def test_anotherRunHasReplacedIt(finished, runHere, tmp_path, monkeypatch):
    """A run that was read is gone on with only if no other one has written since."""
    honest = savedrun.SavedRun.checkUnchanged

    def replaceFirst(saved):
        header, checkpoints = checkpointfile.readCheckpoint(tmp_path / "run.checkpoint")
        checkpointfile.writeCheckpoint(tmp_path / "run.checkpoint", {**header, "reports": []}, checkpoints.values())
        honest(saved)

    monkeypatch.setattr(savedrun.SavedRun, "checkUnchanged", replaceFirst)
    before = contents(tmp_path, "run")
    assertRefused(runHere("--resume", "run.checkpoint"), tmp_path, filesIn(tmp_path), "another run has written it")
    assert contents(tmp_path, "run") == before


def test_anotherStructure(finished, runHere, tmp_path):
    writePDB(tmp_path / "run.pdb", [line.replace("2.870", "2.880") for line in GLYCINES])
    files = filesIn(tmp_path)
    assertRefused(runHere("--resume", "run.checkpoint"), tmp_path, files, "run.checkpoint: is of a run from another")


def test_theDiskFills(runHere, tmp_path):
    """One line says how to continue, and with free space the run does."""
    options = ("run.pdb", "--replicas", 2, "--workers", 1, "--trials", 40000, "--frames", 400, "--seed", 1)
    with largestFile(20000):
        result = runHere(*options, "--checkpoint-interval", 0)
    assert result.returncode == 2 and len(result.stderr.splitlines()) == 1
    assert "cannot be written (File too large)" in result.stderr
    assert "--resume run.checkpoint continues the run from its last checkpoint" in result.stderr
    assert runHere("--resume", "run.checkpoint").returncode == 0
    assert runHere(*options, "-o", "whole").returncode == 0
    assert contents(tmp_path, "run") == contents(tmp_path, "whole")


if __name__ == "__main__":  # python test_resuming.py KILLS SEED: in a folder of its own, with many kills
    with tempfile.TemporaryDirectory() as folder:
        writePDB(Path(folder) / "run.pdb", GLYCINES)

        def runThere(*arguments):
            return subprocess.run([*COMMAND, "sample", *map(str, arguments)], cwd=folder, capture_output=True)

        test_killedAtRandomTimes(runThere, Path(folder), kills=int(sys.argv[1]), seed=int(sys.argv[2]))
    print(f"{sys.argv[1]} kills: the same bits")
