"""Ctrl-C and SIGTERM end the command soon: what there is by then is written, and told."""

import json
import signal
import subprocess

import commands
import pytest
from commands import COMMAND, filesIn
from scenes import GLYCINES, readDCD, writeLongTrajectory, writePDB

BEGUN = r"[1-9]\d{5,}/"  # a progress bar of many trials


def runUntil(number, pattern, *arguments, folder):
    status, output, shown = commands.runOnATerminal(*arguments, folder=folder, interruptAt=pattern, number=number)
    assert status == 128 + number
    assert "Traceback" not in shown + output and "openmm-chaintree:" not in shown and "interrupted" in output
    return output


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_sample(tmp_path, number):
    """Of these frames none comes in a lifetime; the checkpoint has the state."""
    writePDB(tmp_path / "run.pdb", GLYCINES)
    arguments = ("run.pdb", "--trials", 10**12, "--frames", 3, "--json", "a.json")
    runUntil(number, BEGUN, "sample", *arguments, folder=tmp_path)
    summary = json.loads((tmp_path / "a.json").read_text())
    assert summary["interrupted"] and summary["frames"] == 1 == len(readDCD(tmp_path / "run.dcd"))
    assert 0 < summary["trials"] == sum(move["attempted"] for move in summary["moves"])


@pytest.mark.parametrize("options", [["--replicas", 3], ["--replicas", 3, "--trials-per-round", 10**11, "--frames", 3]])
def test_replicas(tmp_path, options):
    """Frames that not all replicas have reached are dropped, and sampled again by the resumed run."""
    writePDB(tmp_path / "run.pdb", GLYCINES)
    arguments = ("run.pdb", "--trials", 10**12, "--frames", 10**8, *options, "--workers", 2, "--json", "a.json")
    pattern = r"0/3000000000000" if len(options) > 2 else BEGUN
    output = runUntil(signal.SIGTERM, pattern, "sample", *arguments, folder=tmp_path)
    assert "--resume continues" in output
    summary = json.loads((tmp_path / "a.json").read_text())
    assert summary["interrupted"] and (summary["trials"] > 0) == (len(options) == 2)
    assert all(len(readDCD(tmp_path / f"run-replica-{replica}.dcd")) == summary["frames"] for replica in range(3))
    assert len((tmp_path / "run-index.csv").read_text().splitlines()) == 1 + 3 * summary["frames"]
    assert len(filesIn(tmp_path)) == (9 if summary["frames"] == 1 else 10)


def test_chunks(tmp_path, villin):
    arguments = ("clashes", *writeLongTrajectory(tmp_path, villin), "--workers", 2, "--json", "a.json")
    runUntil(signal.SIGTERM, r"[1-9]\d*/50001", *arguments, folder=tmp_path)
    summary = json.loads((tmp_path / "a.json").read_text())
    assert summary["interrupted"] and 0 < len(summary["frames"]) < 50001


def test_beforeAnything(tmp_path):
    """While a structure is read, from a pipe that nobody writes."""
    command = [*COMMAND, "sample", "/dev/stdin"]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, cwd=tmp_path, **pipes) as process:
        while signal.SIGTERM not in _caught(process.pid):
            assert process.poll() is None
        process.send_signal(signal.SIGTERM)
        output, errors = process.communicate()
    assert (process.returncode, output, errors) == (143, b"", b"") and filesIn(tmp_path) == []


def _caught(pid):
    """Return the signals that a process has handlers for."""
    with open(f"/proc/{pid}/status") as file:
        mask = next(int(line.split()[1], 16) for line in file if line.startswith("SigCgt"))
    return [number for number in range(1, 64) if mask >> number - 1 & 1]
