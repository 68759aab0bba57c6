"""Means of correlated series: chains whose autocorrelation times are known, and chains that tell nothing."""

import numpy as np
import pytest
from openmmchaintree.statistics.equilibration import findEquilibration
from openmmchaintree.statistics.estimates import LEAST_SAMPLE, estimate, estimateAngle
from openmmchaintree.statistics.rhat import splitRhat
from scipy.signal import lfilter


def autoregressive(time, shape, seed=1):
    """Return AR(1) chains of mean 0, variance 1 and this integrated autocorrelation time, along the last axis."""
    ratio = time / (1 + time)  # τ = Σ φ^t = φ / (1 − φ)
    random = np.random.default_rng(seed)
    noise = random.normal(size=shape) * np.sqrt(1 - ratio**2)
    start = random.normal(size=(*shape[:-1], 1))
    return lfilter([1], [1, -ratio], noise, zi=ratio * start)[0]


def twoState(flips, length, seed=1):
    """Return a chain of 0 and 1 that changes with this probability; C(t) = (1 − 2 p)^t, so τ = (1 − 2 p) / 2 p."""
    return np.cumsum(np.random.default_rng(seed).random(length) < flips) % 2


# ---- Known autocorrelation times ----


@pytest.mark.parametrize("time", [0, 2, 10, 50])
def test_timeAndErrorOfAR1(time):
    chains = autoregressive(time, (60, 5000))
    found = [estimate([chain]) for chain in chains]
    assert np.mean([one.autocorrelationTime for one in found]) == pytest.approx(time, rel=0.08, abs=0.1)
    assert found[0].effectiveSampleSize == pytest.approx(5000 / (1 + 2 * found[0].autocorrelationTime))
    # The errors are those of the means, which scatter about 0.
    pulls = [one.mean / one.standardError for one in found]
    assert np.std(pulls) == pytest.approx(1, abs=0.25) and abs(np.mean(pulls)) < 0.4
    assert [one.verdict for one in found if one.effectiveSampleSize < LEAST_SAMPLE] == [
        f"too short: effective sample size {one.effectiveSampleSize:.0f}"
        for one in found
        if one.effectiveSampleSize < LEAST_SAMPLE
    ]


def test_independentChainsShareTheirMean():
    chains = autoregressive(5, (4, 3000))
    together = estimate(list(chains))
    assert together.length == 12000 and together.verdict is None and together.rhat < 1.02
    assert together.autocorrelationTime == pytest.approx(5, rel=0.2)
    assert together.mean == pytest.approx(chains.mean())
    chains[0] += 3
    apart = estimate(list(chains))
    assert apart.effectiveSampleSize < 0.1 * together.effectiveSampleSize and apart.rhat > 1.3


def test_twoStates():
    found = estimate([twoState(0.02, 40000)])
    assert found.autocorrelationTime == pytest.approx(0.96 / 0.04, rel=0.15) and found.verdict is None
    assert abs(found.mean - 0.5) < 4 * found.standardError


def test_oneChangeInTheMiddleIsNoConvergence():
    found = estimate([np.repeat([0.0, 1.0], 500)])
    assert found.effectiveSampleSize < 5 and found.rhat == np.inf
    assert found.verdict.startswith("too short: effective sample size ")


def test_drift():
    drifting = autoregressive(2, (2000,)) + np.linspace(0, 20, 2000)
    found = estimate([drifting])
    assert found.effectiveSampleSize < 10 and found.rhat > 1.5
    left, isEnough = findEquilibration([drifting])
    assert left == 1000 and not isEnough


def test_halvesThatDifferMoreThanTheirErrors():
    """Enough values that follow each other quickly, about two means."""
    random = np.random.default_rng(1)
    found = estimate([random.normal(size=1000), random.normal(size=1000) + 0.8])
    assert found.rhat > 1.05 and found.verdict is not None


# ---- Angles ----


def test_anglesDoNotKnowWhereTheyAreCut():
    angles = 0.3 * autoregressive(5, (4000,))
    plain, turned = estimateAngle([angles]), estimateAngle([np.angle(np.exp(1j * (angles + 3.1)))])
    assert turned.mean == pytest.approx(plain.mean + 3.1) and turned.standardError == pytest.approx(plain.standardError)
    assert turned.autocorrelationTime == pytest.approx(plain.autocorrelationTime)
    assert plain.autocorrelationTime == pytest.approx(5, rel=0.3)
    assert plain.standardError == pytest.approx(estimate([angles]).standardError, rel=0.3)


def test_slowHopsBetweenOppositeAnglesAreSeen():
    angles = np.pi * twoState(0.02, 20000) + 0.1 * autoregressive(0, (20000,))
    found = estimateAngle([angles])
    assert found.autocorrelationTime == pytest.approx(0.96 / 0.04, rel=0.3)
    exact = estimateAngle([np.pi * twoState(0.02, 20000)])
    assert exact.autocorrelationTime == pytest.approx(found.autocorrelationTime, rel=0.1)


def test_noDirectionNoMean():
    found = estimateAngle([np.random.default_rng(1).uniform(-np.pi, np.pi, 500)])
    assert found.mean is None and found.effectiveSampleSize > 300


def test_roundingIsNoMotion():
    noise = 1e-5 * np.random.default_rng(1).normal(size=500)
    for estimating in (estimate, estimateAngle):
        found = estimating([1 + noise], resolution=1e-3)
        assert (found.effectiveSampleSize, found.verdict) == (0, "constant")
        assert found.mean == pytest.approx(1, abs=1e-5)


# ---- Chains that tell nothing ----


@pytest.mark.parametrize("estimating", [estimate, estimateAngle])
@pytest.mark.parametrize(
    ("chains", "verdict"),
    [
        ([[]], "too short: 0 values"),
        ([[1.0, 2.0]], "too short: 2 values"),
        ([[1.0] * 50, [1.0]], "too short: 51 values"),
        ([[1.0] * 50], "constant"),
        ([[0.0] * 50], "constant"),
        ([[1.0] * 20 + [np.nan, np.inf]], "2 values are not numbers"),
    ],
)
def test_nothingFollows(estimating, chains, verdict):
    found = estimating(chains)
    assert found.verdict == verdict and not found.effectiveSampleSize and found.rhat is None
    assert (found.mean is None) == (not len(chains[0]) or "not numbers" in verdict)


# ---- Equilibration ----


def test_relaxationIsLeftOut():
    series = autoregressive(3, (2000,))
    assert findEquilibration([series])[0] < 600
    relaxing = series + 30 * np.exp(-np.arange(2000) / 60)
    left, isEnough = findEquilibration([series, relaxing])
    assert 150 < left < 900 and isEnough
    assert abs(estimate([relaxing[left:]]).mean) < 4 * estimate([relaxing[left:]]).standardError


def test_fewFramesAndConstants():
    assert findEquilibration([]) == (0, True)
    assert findEquilibration([np.arange(3.0)]) == (0, True)
    assert findEquilibration([np.ones(100)]) == (0, True)


# ---- R-hat ----


@pytest.mark.parametrize("kind", ["alike", "shifted", "wider", "ties", "odd"])
def test_rhatIsArviZs(kind):
    arviz = pytest.importorskip("arviz_stats.base").array_stats
    chains = autoregressive(3, (4, 201 if kind == "odd" else 200))
    if kind == "shifted":
        chains[1] += 0.5
    elif kind == "wider":
        chains[2] *= 2
    elif kind == "ties":
        chains = np.round(chains)
    expected = float(arviz.rhat(chains[:, -200:], method="rank"))
    assert splitRhat(list(chains)) == pytest.approx(expected, rel=1e-12)


def test_rhatOfConstants():
    assert splitRhat([np.ones(10)]) is None
    assert splitRhat([np.zeros(10), np.ones(10)]) == np.inf


def test_pymbarSaysNothing(capfd):
    estimate([autoregressive(1, (100,))])
    assert capfd.readouterr() == ("", "")
