"""Means of correlated series with their errors, and a verdict on them."""

from typing import NamedTuple

import numpy as np

from .pymbarimport import timeseries
from .rhat import splitRhat

# With 50 independent values, the standard error itself is known to 10 %; the run is 100 autocorrelation times long.
LEAST_SAMPLE = 50

# Above this R-hat, halves of the run, or replicas, differ by more than chance would let them.
LARGEST_RHAT = 1.05

_FEWEST_VALUES = 4
_ROUNDING = 1e-12


class Estimate(NamedTuple):
    """The mean of one observable over one chain, or several independent ones, of the same distribution.

    mean, standardError : float, in the unit of the series; None if they are not defined
    autocorrelationTime : float, the integrated one, τ = Σ C(t), t > 0, in steps of the series
    effectiveSampleSize : float, length / (1 + 2 τ); 0 for a constant
    rhat : float, of halves of all chains, see `splitRhat`
    length : int, the number of values
    verdict : str, why the mean should not be quoted; None if it may
    """

    mean: float | None
    standardError: float | None
    autocorrelationTime: float | None
    effectiveSampleSize: float | None
    rhat: float | None
    length: int
    verdict: str | None


def estimate(chains, resolution=0.0):
    """Return the Estimate of the mean of some chains, 1-D arrays whose start was left out.

    resolution : float, differences that are rounding, not motion
    """
    chains = [np.asarray(chain, float) for chain in chains]
    values = np.concatenate(chains)
    mean = float(values.mean()) if np.isfinite(values).all() and len(values) else None
    verdict = _refusal(chains, mean)
    if verdict is not None:
        return Estimate(mean, None, None, None, None, len(values), verdict)
    if np.ptp(values) <= max(resolution, _ROUNDING * np.abs(values).max()):
        return _constant(mean, len(values))
    inefficiency = _inefficiency(chains)
    sample = len(values) / inefficiency
    return _judged(mean, float(values.std() / np.sqrt(sample)), inefficiency, splitRhat(chains), len(values))


def estimateAngle(chains, resolution=0.0):
    """Return the Estimate of the circular mean of angles, rad, from their sines and cosines about that mean.

    The slower one of sine and cosine gives autocorrelation time and R-hat. Without a preferred direction, there is no
    mean. Parameters as for `estimate`.
    """
    chains = [np.asarray(chain, float) for chain in chains]
    values = np.concatenate(chains)
    resultant = np.exp(1j * values).mean() if np.isfinite(values).all() and len(values) else None
    mean = None if resultant is None else float(np.angle(resultant))
    verdict = _refusal(chains, mean)
    if verdict is not None:
        return Estimate(mean, None, None, None, None, len(values), verdict)
    sines, cosines = ([function(chain - mean) for chain in chains] for function in (np.sin, np.cos))
    resolution = max(resolution, _ROUNDING)
    moving = [
        part for part, least in ((sines, resolution), (cosines, resolution**2)) if np.ptp(np.concatenate(part)) > least
    ]
    if not moving:
        return _constant(mean, len(values))
    inefficiency = max(map(_inefficiency, moving))
    rhat = max((value for value in map(splitRhat, moving) if value is not None), default=None)
    error = float(np.concatenate(sines).std() * np.sqrt(inefficiency / len(values)) / max(abs(resultant), 1e-300))
    return _judged(*((mean, error) if error < 1 else (None, None)), inefficiency, rhat, len(values))


def _refusal(chains, mean):
    """Return why chains with this mean, None with values that are no numbers, say nothing else; None if they do."""
    count = sum(map(len, chains))
    if count and mean is None:
        return f"{sum(np.count_nonzero(~np.isfinite(chain)) for chain in chains):,} values are not numbers"
    if min(map(len, chains), default=0) < _FEWEST_VALUES:
        return f"too short: {count} values"
    return None


def _constant(mean, count):
    return Estimate(mean, 0.0, None, 0.0, None, count, "constant")


def _inefficiency(chains):
    """Return the statistical inefficiency, 1 + 2 τ. Several chains share one mean, so chains that differ raise it."""
    pymbar = timeseries()
    if len(chains) == 1:
        return float(pymbar.statistical_inefficiency(chains[0]))
    return float(pymbar.statistical_inefficiency_multiple(chains))


def _judged(mean, error, inefficiency, rhat, count):
    sample = count / inefficiency
    verdict = None
    if sample < LEAST_SAMPLE:
        verdict = f"too short: effective sample size {sample:.0f}"
    elif rhat is not None and rhat > LARGEST_RHAT:
        verdict = f"not converged: R-hat {rhat:.2f}"
    return Estimate(mean, error, (inefficiency - 1) / 2, sample, rhat, count, verdict)
