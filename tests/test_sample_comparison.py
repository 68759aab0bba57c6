"""The statistics of examples/validation/dynamics.py, on samples whose distribution is known."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "examples" / "validation"))

from geometry import Geometry, basins, thirds
from molecules import makeMolecule, namedTorsions
from samples import Samples, compareMeans, compareWidths, effectiveSize, totalVariation

CHAINS, FRAMES, MEMORY = 4, 8000, 0.9


def correlated(random, count=1):
    """Return chains of a stationary autoregressive process of variance 1, (chains x frames, count)."""
    values = np.empty((FRAMES, CHAINS, count))
    values[0] = random.normal(size=(CHAINS, count))
    for before, now in zip(values, values[1:], strict=False):
        now[:] = MEMORY * before + np.sqrt(1 - MEMORY**2) * random.normal(size=(CHAINS, count))
    return values.swapaxes(0, 1).reshape(-1, count)


def samplesOf(frames=FRAMES):
    positions = np.zeros((CHAINS, frames, 1, 3), dtype=np.float32)
    return Samples("none", "none", 300, positions, np.zeros((CHAINS, frames, 1)), np.array(["Force"]), 0.0)


def blocksOf(values):
    return samplesOf().inBlocks(values).mean(axis=1)


def test_errorsOfCorrelatedSamples():
    """The variance of the mean is that of n (1 − a) / (1 + a) independent samples, and p-values are uniform."""
    random = np.random.default_rng(1)
    columns = correlated(random, 200)
    found = [
        compareMeans(blocksOf(first), blocksOf(second)) for first, second in zip(columns.T, columns.T[1:], strict=False)
    ]
    expected = np.sqrt((1 + MEMORY) / (1 - MEMORY) / (CHAINS * FRAMES))
    assert np.mean([estimate.first[1] for estimate in found]) == pytest.approx(expected, rel=0.05)
    assert np.std([estimate.errors for estimate in found]) == pytest.approx(1, abs=0.2)
    assert np.mean([estimate.pValue < 0.1 for estimate in found]) == pytest.approx(0.1, abs=0.07)


def test_widths():
    random = np.random.default_rng(2)
    first, second = correlated(random)[:, 0], 1.1 * correlated(random)[:, 0]
    found = compareWidths(*(blocksOf(of**2) for of in (first, second)))
    assert found.first[0] == pytest.approx(1, abs=5 * found.first[1]) and found.errors > 4
    assert found.difference == pytest.approx(0.1, abs=0.03) and found.pValue < 1e-3


def test_effectiveSize():
    share = 0.3
    assert effectiveSize(share, np.sqrt(share * (1 - share) / 500)) == pytest.approx(500)
    assert effectiveSize(0, 0) == 0


def test_totalVariation():
    """Samples of one distribution are as far apart as expected; others are farther."""
    random = np.random.default_rng(3)
    beyond = 0
    for _ in range(20):
        first, second = (histograms(correlated(random)[:, 0]) for _ in range(2))
        seen, expected, quantile = totalVariation(first, second)
        assert 0.3 * expected < seen < 3 * expected
        beyond += seen > quantile
    assert beyond <= 4
    seen, _, quantile = totalVariation(first, histograms(correlated(random)[:, 0] + 0.3))
    assert seen > 2 * quantile


def histograms(values):
    cells = np.clip(np.floor(4 * values) + 10, 0, 19).astype(int)
    return np.array([np.bincount(of, minlength=20) / len(of) for of in samplesOf().inBlocks(cells)])


def test_samplesAreSaved(tmp_path):
    samples = samplesOf(100)
    samples.save(tmp_path / "samples.npz")
    loaded = Samples.load(tmp_path / "samples.npz")
    assert loaded.molecule == "none" and loaded.temperature == 300 and list(loaded.forces) == ["Force"]
    assert loaded.positions.shape == samples.positions.shape


def test_basins():
    phi, psi = np.array([-60, -60, -60, -150, 60, -90]), np.array([-50, 140, -170, 150, 40, 49.9])
    found = basins(phi, psi)
    assert [next(name for name in found if found[name][i]) for i in range(6)] == [
        *("alpha", "PPII", "PPII", "beta", "left", "alpha")
    ]
    assert (sum(of.astype(int) for of in found.values()) == 1).all()
    assert [name for angle in (-60, 60, 179) for name, of in thirds(np.array([angle])).items() if of[0]] == [
        *("g-", "g+", "trans")
    ]


def test_coordinatesOfAMolecule():
    """Bonds and angles of each kind have the parameters of one term; torsions have the values of IUPAC."""
    topology, system, positions = makeMolecule("trialanine")
    measured = Geometry(topology, system).measure(positions[np.newaxis].astype(np.float32))
    assert sum(of.shape[1] for of in measured.lengths.values()) == len(list(topology.bonds()))
    assert measured.lengths["C-O"].shape == (1, 4) and 0.12 < measured.lengths["C-O"].mean() < 0.127
    assert all(of.std() < 0.01 for of in measured.lengths.values())
    assert all(of.std() < 8 for of in measured.angles.values())
    assert list(measured.planes) == [1, 2, 3]
    phi, psi = (float(of[0]) for of in measured.planes[2])  # of a helix
    assert -90 < phi < -45 and -65 < psi < -20


def test_torsionsOfANucleotide():
    names = [name for _, name in namedTorsions(makeMolecule("dinucleotide")[0])]
    first, second = "gamma delta epsilon zeta chi", "alpha beta gamma delta chi"
    assert names == f"{first} {second}".split()
