"""Energies −kT ln p as maps of CMAPTorsionForces, smooth and periodic, from densities of one or two torsions."""

import numpy as np

_SUBDIVISION = 4  # points of a bin, in each direction, that give its mean
_ITERATIONS = 10


def smoothLogDensity(counts, floor):
    """Return ln p at the centers of bins, such that its spline has the mean density of the counts in each bin.

    p is relative to a uniform density. Between centers, ln p is a periodic cubic spline. Iterative scaling: where the
    mean of a bin is too high, ln p at its center is lowered by the logarithm of the ratio.

    Parameters
    ----------
    counts : array of one or two dimensions
        by bins of equal width, the first of which begins at −180 degrees
    floor : float
        the share of the density that is uniform, above 0
    """
    counts = np.asarray(counts, dtype=np.float64)
    target = (1 - floor) * counts / counts.mean() + floor
    fine = [_splineMatrix(count, _middles(count, _SUBDIVISION)) for count in counts.shape]
    found = np.log(target)
    for _ in range(_ITERATIONS):
        means = _meansOfBins(np.exp(_apply(fine, found)), counts.shape)
        found += np.log(target / means)
    return found


def mapOf(logDensity):
    """Return the spline of ln p at the nodes of a CMAPTorsionForce: from 0 on, twice as many as there are bins.

    The spline of these nodes is the same function, since every center of a bin is a node.
    """
    fine = [_splineMatrix(count, (np.arange(2 * count) + count - 1) / 2) for count in logDensity.shape]
    return _apply(fine, logDensity)


def binsOf(logDensity, division):
    """Return the mean density in bins that are `division` times narrower than those of ln p, from −180 degrees on."""
    shape = tuple(division * count for count in logDensity.shape)
    fine = [_splineMatrix(count, _middles(count, 4 * division)) for count in logDensity.shape]
    return _meansOfBins(np.exp(_apply(fine, logDensity)), shape)


def _middles(count, division):
    """Return the middles of parts of bins, where 0 is the center of the first bin and 1 that of the second."""
    return (np.arange(count * division) + 0.5) / division - 0.5


def _splineMatrix(count, places):
    """Return the (len(places), count) matrix that interpolates `count` values on a circle, at 0, 1, …, `count` − 1.

    The interpolation is that of the periodic cubic spline, as in CMAPTorsionForce.
    """
    # Coefficients of B-splines from values: a circulant system.
    row = np.zeros(count)
    for offset, weight in ((0, 4 / 6), (1, 1 / 6), (-1, 1 / 6)):
        row[offset % count] += weight
    collocation = np.array([np.roll(row, shift) for shift in range(count)])
    distances = (np.asarray(places)[:, np.newaxis] - np.arange(count) + count / 2) % count - count / 2
    distances = np.abs(distances)
    inner, outer = 2 / 3 - distances**2 + distances**3 / 2, np.maximum(2 - distances, 0) ** 3 / 6
    return np.where(distances < 1, inner, outer) @ np.linalg.inv(collocation)


def _apply(matrices, values):
    """Multiply each axis of an array by its matrix."""
    for axis, matrix in enumerate(matrices):
        values = np.moveaxis(np.tensordot(matrix, values, (1, axis)), 0, axis)
    return values


def _meansOfBins(values, shape):
    """Return the means of blocks of a fine array: one for each element of `shape`."""
    lengths = [length for count, whole in zip(shape, values.shape, strict=True) for length in (count, whole // count)]
    divided = values.reshape(lengths)
    return divided.mean(axis=tuple(range(1, divided.ndim, 2)))
