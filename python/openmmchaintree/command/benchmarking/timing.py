"""Times of what runs in Python."""

import time

import numpy as np


def measure(function, *arguments):
    """Return what a call returns, and the processor time it takes, of all threads, in microseconds."""
    start = time.process_time_ns()
    result = function(*arguments)
    return result, 1e-3 * (time.process_time_ns() - start)


def summarizeTimes(times):
    """Return the median and the quartiles of times as an entry has them."""
    first, median, third = np.quantile(times, [0.25, 0.5, 0.75]).tolist()
    return {"microseconds": median, "quartiles": [first, third]}
