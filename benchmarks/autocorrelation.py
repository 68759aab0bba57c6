"""How far apart samples of a chain are independent."""

import numpy as np

_WINDOW = 5  # times the result: as far as the sum goes (Sokal, 1997)


def statisticalInefficiency(values, mean=None):
    """Return of each column how many samples are worth an independent one: 1 + 2 Σ ρ, at least 1.

    The autocorrelation ρ is summed over a window of some times the sum itself, since beyond it there is only noise. A
    chain that is not much longer than that tells too little.

    Parameters
    ----------
    values : (n, k) float64 array, columns of a chain
    mean : (k,) float64 array, if it is known better than from these
    """
    values = np.asarray(values, dtype=np.float64)
    deviations = values - (values.mean(axis=0) if mean is None else mean)
    count = len(deviations)
    covariances = _laggedProducts(deviations)
    scale = np.maximum(covariances[0], np.finfo(np.float64).tiny)
    totals = 2 * np.cumsum(covariances / scale, axis=0) - 1
    isEnough = np.arange(count)[:, np.newaxis] >= _WINDOW * totals / 2
    isEnough[-1] = True
    ends = np.argmax(isEnough, axis=0)
    return np.maximum(1.0, totals[ends, np.arange(totals.shape[1])])


def leastInefficiency(chains, variances, lag):
    """Return of each column how many samples are worth an independent one, at least, from chains that may be short.

    The chains begin with states of the ensemble. Their mean square change and the variances of the ensemble are the
    autocorrelation ρ up to some lag L. Where moves are drawn with detailed balance, and samples are an even number of
    steps apart, ρ is a sum of exponentials with positive weights: it falls the slower the longer the lag, and beyond L
    is at least ρ(L)^(t/L). So is known what is at least left of 1 + 2 Σ ρ.

    Parameters
    ----------
    chains : sequence of (n, k) float64 arrays
    variances : (k,) float64 array
    lag : int, samples, less than n
    """
    scale = np.maximum(variances, np.finfo(np.float64).tiny)
    changes = np.mean([_meanSquareChanges(chain, lag) for chain in chains], axis=0)
    correlations = 1 - changes / (2 * scale)
    seen = 1 + 2 * correlations[1:lag].sum(axis=0)
    last = np.clip(correlations[lag], 0, 1 - 1e-9)
    return np.maximum(1.0, seen + 2 * last / (1 - last ** (1 / lag)))


def _meanSquareChanges(chain, lag):
    """Return the mean square change of each column of a chain over 0 to lag samples: (lag + 1, k)."""
    deviations = chain - chain.mean(axis=0)
    count, squares = len(deviations), deviations**2
    lags = np.arange(lag + 1)
    # The squares of all pairs' first samples, and of their second ones.
    upTo = np.concatenate([np.zeros_like(squares[:1]), np.cumsum(squares, axis=0)])
    ofEnds = upTo[count - lags] + upTo[-1] - upTo[lags]
    return ofEnds / (count - lags)[:, np.newaxis] - 2 * _laggedProducts(deviations)[: lag + 1]


def _laggedProducts(columns):
    """Return the mean of the products of samples of each column at lags 0, 1, 2, …"""
    count = len(columns)
    transformed = np.fft.rfft(columns, 2 * count, axis=0)
    sums = np.fft.irfft(np.abs(transformed) ** 2, 2 * count, axis=0)[:count]
    return sums / np.arange(count, 0, -1)[:, np.newaxis]
