"""R-hat: whether parts of a simulation that should agree do agree."""

import numpy as np


def splitRhat(chains):
    """Return the rank-normalised split R-hat of Vehtari et al. (2021), https://doi.org/10.1214/20-BA1221.

    Each chain is split into halves, so one chain is enough. The result is the larger one of the values for location and
    for spread. It is near 1 if all halves agree, and inf if no half varies but the halves differ.

    Parameters
    ----------
    chains : list of 1-D arrays
        of at least 4 values, all finite; longer ones lose their first values

    Returns
    -------
    float or None
        None for a constant
    """
    length = min(map(len, chains)) // 2
    halves = np.array([half for chain in chains for half in (chain[-2 * length : -length], chain[-length:])])
    folded = np.abs(halves - np.median(halves))
    values = [_rhat(_normalScores(each)) for each in (halves, folded)]
    return max((value for value in values if value is not None), default=None)


def _normalScores(halves):
    from scipy.special import ndtri  # SciPy takes long to import
    from scipy.stats import rankdata

    ranks = rankdata(halves).reshape(halves.shape)
    return ndtri((ranks - 0.375) / (ranks.size + 0.25))


def _rhat(halves):
    if not np.ptp(halves, axis=1).any():
        return float("inf") if np.ptp(halves) else None
    length = halves.shape[1]
    within = halves.var(axis=1, ddof=1).mean()
    between = halves.mean(axis=1).var(ddof=1)
    return float(np.sqrt((length - 1) / length + between / within))
