"""Averages from samples of several temperatures, where they are known: energies of independent oscillators."""

import numpy as np
import pytest
from openmmchaintree.statistics.reweighting import reweight

_GAS_CONSTANT = 0.00831446261815324  # kJ/mol/K
_SHAPE = 20  # half the number of oscillators: their energies have a gamma distribution
_TEMPERATURES = np.geomspace(300, 450, 4)


def sample(seed, count=100):
    random = np.random.default_rng(seed)
    return [random.gamma(_SHAPE, _GAS_CONSTANT * kelvin, size=count) for kelvin in _TEMPERATURES]


def test_meansAndErrors():
    """The mean of U and of U² at the lowest temperature, in runs that give a scatter to compare the errors with."""
    exact = _GAS_CONSTANT * 300 * _SHAPE, (_GAS_CONSTANT * 300) ** 2 * _SHAPE * (_SHAPE + 1)
    pulls, alone = [], []
    for seed in range(1, 17):
        energies = sample(seed)
        values = np.concatenate(energies)
        found = reweight(energies, _TEMPERATURES, [values, values**2])
        pulls.append((found.means - exact) / found.errors)
        alone.append(energies[0].std() / np.sqrt(len(energies[0])) / found.errors[0])
        assert found.weights.sum() == pytest.approx(1)
        assert found.means[0] == pytest.approx(found.weights @ values)
    assert np.std(pulls, axis=0) == pytest.approx([1, 1], abs=0.5) and np.all(np.abs(np.mean(pulls, axis=0)) < 0.7)
    assert np.mean(alone) > 1.3  # what the other temperatures add
    assert 100 < found.sampleSize < 400


def test_anyTemperatureCanBeTheTarget():
    energies = sample(1)
    found = reweight(energies, _TEMPERATURES, [np.concatenate(energies)], target=3)
    assert found.means[0] == pytest.approx(_GAS_CONSTANT * 450 * _SHAPE, abs=4 * found.errors[0])


def test_hardlyAnySamples():
    assert reweight([np.ones(1), np.ones(0)], [300, 400], [np.ones(1)]) is None
    assert reweight([np.ones(0), np.ones(5)], [300, 400], [np.ones(5)]) is None
    assert reweight([np.ones(5), np.full(5, np.nan)], [300, 400], [np.ones(10)]) is None
    alike = reweight([np.ones(5), np.ones(5)], [300, 400], [np.arange(10.0)])
    assert alike.weights == pytest.approx(0.1) and alike.means[0] == pytest.approx(4.5)


def test_temperaturesThatDoNotOverlap():
    """Samples that the target never visits have no weight."""
    found = reweight([np.zeros(5), 1e5 + np.arange(5)], [300, 450], [np.arange(10.0)])
    assert found.weights == pytest.approx([0.2] * 5 + [0] * 5) and found.means[0] == pytest.approx(2)
