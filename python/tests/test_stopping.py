"""What ends a run before its last trial: a time, or a condition; and how numbers and times are written."""

import argparse
import json

import pytest
from commands import assertRefused, filesIn
from openmmchaintree.command import replicasample
from openmmchaintree.command.arguments import duration, positive
from openmmchaintree.command.stopping import Stopping
from scenes import readDCD, writeSmallStructures


@pytest.fixture
def runHere(runCommandHere, tmp_path):
    writeSmallStructures(tmp_path)
    return lambda *arguments: runCommandHere("sample", *arguments)


@pytest.mark.parametrize(
    ("text", "number"),
    [("7", 7), ("1e6", 1000000), ("2_000_000", 2000000), ("1.5e6", 1500000), ("1000000.0", 1000000), ("1E3", 1000)],
)
def test_wholeNumbers(text, number):
    assert positive(text) == number and isinstance(positive(text), int)


@pytest.mark.parametrize("text", ["", "1.5", "1e-3", "many", "nan", "inf", "-inf", "1e", "0x10", "1,000", "10 000"])
def test_noWholeNumbers(text):
    with pytest.raises(argparse.ArgumentTypeError, match="is not a whole number"):
        positive(text)


@pytest.mark.parametrize("text", ["0", "-1", "-1e6", "1e16", "1e999999999"])
def test_numbersOutOfRange(text):
    with pytest.raises(argparse.ArgumentTypeError, match="is not in the range 1 to 1000000000000000"):
        positive(text)


@pytest.mark.parametrize(
    ("text", "seconds"),
    [("90", 90), ("45s", 45), ("30min", 1800), ("1.5h", 5400), ("1h30min", 5400), (" 2 h 5 s ", 7205), ("1d", 86400)],
)
def test_durations(text, seconds):
    assert duration(text) == seconds


@pytest.mark.parametrize(
    "text", ["", "0", "0min", "-3", "5m", "1:30", "inf", "nan", "1e3", "h", "1h30", "11y", "9999d"]
)
def test_noDurations(text):
    with pytest.raises(argparse.ArgumentTypeError):
        duration(text)


@pytest.mark.parametrize("options", [(), ("--replicas", 2, "--workers", 1)])
def test_time(runHere, tmp_path, options):
    """A run without a limit on its trials, which is continued to a number of them."""
    result = runHere("run.pdb", *options, "--time", "0.2s", "--trials-per-frame", 100, "--seed", 1, "--json", "a.json")
    assert result.returncode == 0 and result.stderr == ""
    assert "ended by --time 0.2 s; --resume continues" in result.stdout
    summary = json.loads((tmp_path / "a.json").read_text())
    assert summary["endedBy"] == "--time 0.2 s" and not summary["interrupted"]
    made = summary["trials"]
    assert made > 0 and made % summary["trialsPerRound"] == 0 and summary["frames"] == 1 + made // 100
    result = runHere("--resume", "run.checkpoint", "--time", "0.1s", "--json", "b.json")
    later = json.loads((tmp_path / "b.json").read_text())
    assert result.returncode == 0 and later["endedBy"] == "--time 0.1 s" and later["trials"] > made
    trials = later["trials"] + later["trialsPerRound"]
    assert runHere("--resume", "run.checkpoint", "--trials", trials, "--time", "1h").returncode == 0
    limited = ("--trials", trials, "--trials-per-frame", 100, "--seed", 1, "-o", "b")
    assert runHere("run.pdb", *options, *limited).returncode == 0
    for one in sorted(tmp_path.glob("run*.dcd")):
        other = one.with_name(one.name.replace("run", "b")).read_bytes()
        assert one.read_bytes()[:180] == other[:180] and one.read_bytes()[276:] == other[276:]


def test_trialsEndARunBeforeItsTime(runHere, tmp_path):
    result = runHere("run.pdb", "--trials", "1e3", "--frames", 5, "--time", "1h", "--seed", 1, "--json", "a.json")
    assert result.returncode == 0 and "ended by" not in result.stdout
    assert json.loads((tmp_path / "a.json").read_text())["endedBy"] is None and len(readDCD(tmp_path / "run.dcd")) == 6
    assert runHere("run.pdb", "--trials", 1000, "--trials-per-frame", 200, "--seed", 1, "-o", "b").returncode == 0
    assert (tmp_path / "b.dcd").read_bytes()[276:] == (tmp_path / "run.dcd").read_bytes()[276:]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--time", "3s", "--frames", 5), "--frames needs --trials; without a limit on trials, use --trials-per-frame"),
        (("--frames", 5, "--trials-per-frame", 5), "--frames and --trials-per-frame cannot be used together"),
        (("--trials", 100, "--trials-per-frame", 7), "--trials has to be a multiple of --trials-per-frame"),
        (("--trials", "1e12", "--trials-per-frame", 1), "1,000,000,000,000 frames are more than the 1,000,000,000"),
    ],
)
def test_contradictions(runHere, tmp_path, options, words):
    assertRefused(runHere("run.pdb", *options), tmp_path, filesIn(tmp_path), words)


class HoldsFrom:
    """A condition that holds from a round on, and notes when it was asked."""

    option = "a condition"

    def __init__(self, round):
        self._round = round
        self.asked = []

    def holds(self, run):
        self.asked.append(run.state.round)
        return run.state.round >= self._round

    def describe(self):
        return f"asked {len(self.asked)} times"


@pytest.mark.parametrize("interval", [0, 60])
@pytest.mark.parametrize("options", [(), ("--replicas", 2, "--workers", 2)])
def test_condition(runHere, tmp_path, monkeypatch, options, interval):
    """It is asked after the same rounds whenever checkpoints are written, also by a resumed run."""
    conditions = []

    def stopping(seconds, _):
        conditions.append(HoldsFrom(30))
        return Stopping(seconds, conditions[-1:])

    monkeypatch.setattr(replicasample, "Stopping", stopping)
    options = (*options, "--trials", 4000, "--frames", 80, "--trials-per-round", 50, "--json", "a.json")
    result = runHere("run.pdb", *options, "--seed", 1, "--checkpoint-interval", interval)
    assert "ended by a condition; --resume continues" in result.stdout
    assert conditions[0].asked == [*range(1, 11), 12, 14, 16, 19, 22, 26, 31]
    assert json.loads((tmp_path / "a.json").read_text())["trials"] == 1550
    assert runHere("--resume", "run.checkpoint").returncode == 0
    assert conditions[1].asked == [31]


def test_roundsBetweenQuestions():
    """The share of asked rounds falls, and does not depend on where the run begins."""
    stopping, asked = Stopping(conditions=[HoldsFrom(0)]), [0]
    while asked[-1] < 10000:
        asked.append(stopping.nextRound(asked[-1]))
    assert asked[:11] == [*range(11)] and len(asked) < 60
    assert all(stopping.nextRound(round) == next(each for each in asked if each > round) for round in range(0, 9000, 7))
    assert Stopping().nextRound(5) is None
