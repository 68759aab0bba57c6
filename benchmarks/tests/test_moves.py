"""The script moves.py, as a user runs it. No test looks at how long anything takes."""

import mdtraj
import moves
import numpy as np
import pytest
from commands import assertRefused
from energy.autocorrelation import leastInefficiency, statisticalInefficiency
from energy.chain import heavyAtoms
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
        assert entry["apart"].keys() == {"phi", "psi", "chi1", "slow", "slowest", "rmsd", "rmsdWithoutEnds"}
        for key, apart in entry["apart"].items():
            assert apart >= 400 and entry["rate"][key] * apart * entry["microseconds"] == pytest.approx(1e6)
    pivots, ours = [entry for entry in entries if entry["group"] == "stationary"]
    assert pivots["moves"] == PIVOTS and pivots["apart"].keys() == ours["apart"].keys() == mixtures[0]["apart"].keys()
    assert pivots["lag"] > 0 and 0 <= ours["kept"] <= 1
    coils = [entry for entry in entries if entry["group"] == "coils"]
    assert len(coils) == 3 and all(entry["rate"]["rg"] > 0 and entry["rg"] > 0.5 for entry in coils)
    tables = (tmp_path / "a.md").read_text(encoding="utf-8").split("\n**")[1:]
    assert len(tables) == 4
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
    assert summarize(np.array([7.0, 8, 3, 5, 2, 4]), np.array(["alpha", "chi"])).keys() == {
        "backbone",
        "bases",
        "slow",
        "slowest",
        "rmsd",
        "rmsdWithoutEnds",
    }
    found = summarize(np.array([7.0, 8, *cosines, *sines]), kinds)
    assert (found["rmsd"], found["rmsdWithoutEnds"]) == (7, 8)
    assert (found["phi"], found["psi"], found["chi1"]) == (5, 2.5, 40)
    assert 5 < found["slow"] <= found["slowest"] == 40


def test_endsHangLoose():
    # Five residues at either end of a chain of 21 or more; a shorter chain has none.
    topology = mdtraj.Topology()
    for count in (20, 23):
        chain = topology.add_chain()
        for _ in range(count):
            residue = topology.add_residue("GLY", chain)
            topology.add_atom("CA", mdtraj.element.carbon, residue)
            topology.add_atom("HA2", mdtraj.element.hydrogen, residue)
    heavy, inside = heavyAtoms(topology)
    assert heavy.tolist() == list(range(0, 86, 2))
    assert inside.tolist() == list(range(0, 40, 2)) + list(range(50, 76, 2))


def test_autocorrelationOfAngles():
    # What stays is 1, white noise 0, what turns by half a radian a sample is the cosine of the lag's.
    random = np.random.default_rng(1)
    noise, steady = random.uniform(-np.pi, np.pi, (20000, 1)), np.arange(1000)[:, np.newaxis] * 0.5
    assert autocorrelation(np.ones((5, 2)), 1) == 1
    assert abs(autocorrelation(noise, 3)) < 5 / np.sqrt(20000)
    assert autocorrelation(steady, 4) == pytest.approx(np.cos(2))
    assert autocorrelation(np.hstack([steady, np.ones((1000, 1))]), 4) == pytest.approx((1 + np.cos(2)) / 2)


def decay(random, a, count, length):
    """Return chains of a stationary autoregressive process of variance 1, whose autocorrelation is a^lag."""
    values = np.empty((length, count))
    values[0] = random.normal(size=count)
    for i in range(1, length):
        values[i] = a * values[i - 1] + np.sqrt(1 - a**2) * random.normal(size=count)
    return values


def test_shortChainsTellHowSlowTheyAreAtLeast():
    random = np.random.default_rng(1)
    fast, slow = decay(random, 0.9, 400, 400), decay(random, 0.995, 400, 400)
    # One exponential is known from any lag, though chains are as long as a sample is worth.
    chains = [slow[:, i, np.newaxis] for i in range(400)]
    for lag in (10, 100):
        assert leastInefficiency(chains, np.ones(1), lag)[0] == pytest.approx(1.995 / 0.005, rel=0.1)
    # Of two, the slower is seen the better the longer the lag; what is said stays below the truth.
    both = [(one[:, np.newaxis] + other[:, np.newaxis]) / np.sqrt(2) for one, other in zip(fast.T, slow.T, strict=True)]
    truth = (19 + 399) / 2
    least = [leastInefficiency(both, np.ones(1), lag)[0] for lag in (1, 20, 80)]
    assert 19 < least[0] < least[1] < least[2] < 1.05 * truth
    # The other estimate needs long chains.
    long = decay(random, 0.9, 20, 40000)
    assert statisticalInefficiency(long).mean() == pytest.approx(19, rel=0.05)
    # What has come apart wholly tells nothing, and what does not move is no error.
    assert leastInefficiency([random.normal(size=(5000, 1))], np.ones(1), 3)[0] < 5
    assert np.isfinite(leastInefficiency([np.ones((10, 1))], np.ones(1), 3)[0])
