"""The script moves.py, as a user runs it. No test looks at how long anything takes."""

import moves
import numpy as np
import pytest
from commands import assertRefused
from energy.moverows import PIVOTS, autocorrelation, summarize
from energy.movetables import combine
from racing.report import readCSV


@pytest.fixture
def runHere(runScriptHere):
    """A function that runs the script where no structures lie ready."""
    return lambda *arguments: runScriptHere(moves.main, *arguments)


def test_everythingQuickly(runHere, tmp_path):
    result = runHere("--quick", "--csv", "a.csv", "--markdown", "a.md")
    assert result.returncode == 0, result.stdout + result.stderr
    _, entries = readCSV(tmp_path / "a.csv")
    singles = [entry for entry in entries if entry["group"] == "moves"]
    assert len(singles) == 3 and len({entry["moves"] for entry in singles}) == 3
    for entry in singles:
        assert 0 < entry["attempted"] <= entry["trials"] == 800
        assert entry["accepted"] + entry["clashed"] + entry["rejected"] <= entry["attempted"]
        assert (
            -1 <= entry["autocorrelation"] <= 1
            and entry["lag"] == 400
            and entry["shift"] >= 0
            and entry["quartile1"] <= entry["microseconds"] <= entry["quartile3"]
        )
    mixtures = [entry for entry in entries if entry["group"] == "mixtures"]
    assert [entry["moves"] for entry in mixtures][0] == PIVOTS and len(mixtures) == 3
    for entry in mixtures:
        assert entry["apart"].keys() == {"phi", "psi", "chi1", "slow", "rmsd"}
        for key, apart in entry["apart"].items():
            assert apart >= 400 and entry["rate"][key] * apart * entry["microseconds"] == pytest.approx(1e6)
    coils = [entry for entry in entries if entry["group"] == "coils"]
    assert len(coils) == 3 and all(entry["rate"]["rg"] > 0 and entry["rg"] > 0.5 for entry in coils)
    tables = (tmp_path / "a.md").read_text(encoding="utf-8").split("\n**")[1:]
    assert len(tables) == 3
    for table in tables:
        lines = [line for line in table.splitlines() if line.startswith("|")]
        assert len(lines) == 5 and len({line.count("|") for line in lines}) == 1
    result = runHere("--read", "a.csv", "--markdown", "b.md")
    assert result.returncode == 0
    assert (tmp_path / "a.md").read_bytes() == (tmp_path / "b.md").read_bytes()


def test_badArguments(runHere, tmp_path):
    assertRefused(runHere("a.pdb"), tmp_path, [], "a.pdb")
    assertRefused(runHere("--rows", "growth"), tmp_path, [], "growth")


def test_runsAreCombined():
    common = {"chain": "a", "moves": "m", "group": "moves"}
    runs = [
        {**common, "attempted": 2, "microseconds": 1.0, "rate": {"phi": 1.0}},
        {**common, "attempted": 3, "microseconds": 3.0, "rate": {"phi": 5.0}},
        {**common, "moves": "other", "attempted": 1, "microseconds": 9.0},
    ]
    first, second = combine(runs)
    assert (first["attempted"], first["microseconds"], first["rate"]) == (5, 2.0, {"phi": 3.0})
    assert second == runs[2]


def test_whatIsSlowIsSeen():
    kinds = np.array(["phi", "psi", "psi", "chi1"])
    cosines, sines = [1, 2, 3, 40], [5, 1, 1, 1]
    assert summarize(np.array([7.0, 3, 5, 2, 4]), np.array(["alpha", "chi"])).keys() == {
        "backbone",
        "bases",
        "slow",
        "rmsd",
    }
    found = summarize(np.array([7.0, *cosines, *sines]), kinds)
    assert found["rmsd"] == 7 and (found["phi"], found["psi"], found["chi1"]) == (5, 2.5, 40)
    assert 5 < found["slow"] <= 40


def test_autocorrelationOfAngles():
    # What stays is 1, white noise 0, what turns by half a radian a sample is the cosine of the lag's.
    random = np.random.default_rng(1)
    noise, steady = random.uniform(-np.pi, np.pi, (20000, 1)), np.arange(1000)[:, np.newaxis] * 0.5
    assert autocorrelation(np.ones((5, 2)), 1) == 1
    assert abs(autocorrelation(noise, 3)) < 5 / np.sqrt(20000)
    assert autocorrelation(steady, 4) == pytest.approx(np.cos(2))
    assert autocorrelation(np.hstack([steady, np.ones((1000, 1))]), 4) == pytest.approx((1 + np.cos(2)) / 2)
