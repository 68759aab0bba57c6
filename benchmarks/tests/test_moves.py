"""The benchmark moves.py. No test looks at how long anything takes."""

import mdtraj
import moves
import numpy as np
import pytest
from autocorrelation import leastInefficiency, statisticalInefficiency
from movetables import DEFAULTS, PIVOTS


def test_everythingQuickly(runQuickly):
    _, entries, tables = runQuickly(moves.main)
    singles = [entry for entry in entries if entry["group"] == "moves"]
    assert len({entry["moves"] for entry in singles}) == len(singles) == 3
    for entry in singles:
        assert entry["accepted"] + entry["clashed"] <= entry["attempted"] <= 800
        assert -1 <= entry["autocorrelation"] <= 1 and entry["lag"] == 400 and entry["shift"] >= 0
    stationary = [entry for entry in entries if entry["group"] == "stationary"]
    assert [entry["moves"] for entry in stationary] == [PIVOTS, DEFAULTS]
    for entry in stationary:
        assert entry["rate"].keys() == {"phi", "psi", "chi1", "slow", "slowest", "rmsd", "rmsdWithoutEnds"}
        assert all(rate * 3200 * entry["microseconds"] < 1.000001e6 for rate in entry["rate"].values())
    assert len(tables) == 2


def test_whatIsSlowIsSeen():
    kinds = np.array(["phi", "psi", "psi", "chi1"])
    cosines, sines = [1, 2, 3, 40], [5, 1, 1, 1]
    ofNucleotides = moves.summarize(np.array([7.0, 8, 3, 5, 2, 4]), np.array(["alpha", "chi"]))
    assert ofNucleotides.keys() == {"backbone", "bases", "slow", "slowest", "rmsd", "rmsdWithoutEnds"}
    found = moves.summarize(np.array([7.0, 8, *cosines, *sines]), kinds)
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
    heavy, inside = moves.heavyAtoms(topology)
    assert heavy.tolist() == list(range(0, 86, 2))
    assert inside.tolist() == list(range(0, 40, 2)) + list(range(50, 76, 2))


def test_autocorrelationOfAngles():
    # What stays is 1, white noise 0, what turns by half a radian a sample is the cosine of the lag's.
    random = np.random.default_rng(1)
    noise, steady = random.uniform(-np.pi, np.pi, (20000, 1)), np.arange(1000)[:, np.newaxis] * 0.5
    assert moves.autocorrelation(np.ones((5, 2)), 1) == 1
    assert abs(moves.autocorrelation(noise, 3)) < 5 / np.sqrt(20000)
    both = np.hstack([steady, np.ones((1000, 1))])
    assert moves.autocorrelation(both, 4) == pytest.approx((1 + np.cos(2)) / 2)


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
    # One exponential is known from any lag, though chains are no longer than one independent sample.
    chains = [slow[:, i, np.newaxis] for i in range(400)]
    for lag in (10, 100):
        assert leastInefficiency(chains, np.ones(1), lag)[0] == pytest.approx(1.995 / 0.005, rel=0.1)
    # Of two, the slower is seen the better the longer the lag; what is said stays below the truth.
    both = [(one[:, np.newaxis] + other[:, np.newaxis]) / np.sqrt(2) for one, other in zip(fast.T, slow.T, strict=True)]
    least = [leastInefficiency(both, np.ones(1), lag)[0] for lag in (1, 20, 80)]
    assert 19 < least[0] < least[1] < least[2] < 1.05 * (19 + 399) / 2
    assert leastInefficiency([random.normal(size=(5000, 1))], np.ones(1), 3)[0] < 5
    assert np.isfinite(leastInefficiency([np.ones((10, 1))], np.ones(1), 3)[0])


def test_independentSamplesOfKnownChains():
    random = np.random.default_rng(2)
    for a in (0.0, 0.5, 0.9):
        chains = 3 + 7 * decay(random, a, 20, 40000)
        assert statisticalInefficiency(chains).mean() == pytest.approx((1 + a) / (1 - a), rel=0.05)
    # What is anticorrelated is worth no more than independent samples.
    assert statisticalInefficiency(decay(random, -0.9, 1, 1000))[0] == 1
    assert np.all(np.isfinite(statisticalInefficiency(np.ones((10, 2)))))
    # A chain that stays far from the mean has not begun to be sampled.
    assert statisticalInefficiency(10 + decay(random, 0.0, 1, 1000), np.zeros(1))[0] > 100
