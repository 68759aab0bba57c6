"""Where the initial relaxation of a run ends."""

import numpy as np

from .pymbarimport import timeseries

_CANDIDATES = 40  # places in a series at which equilibration may end
_LARGEST_SHARE = 0.5


def findEquilibration(series):
    """Return the number of initial values to leave out of some series of equal length, and whether that is enough.

    The number is the largest that the method of Chodera (2016), https://doi.org/10.1021/acs.jctc.5b00784, finds in one
    of the series: with it, the rest of that series holds most independent values. At most half is left out; a series
    that still drifts then is not equilibrated.

    series : list of 1-D arrays of finite values
    """
    pymbar = timeseries()
    length = min(map(len, series), default=0)
    if length < 4:
        return 0, True
    step = max(1, length // _CANDIDATES)
    found = max(int(pymbar.detect_equilibration(np.asarray(one, float), nskip=step)[0]) for one in series)
    most = int(_LARGEST_SHARE * length)
    return min(found, most), found <= most
