"""Angles of torsions, for arrays of points."""

import numpy as np


def dihedral(points):
    """Return the dihedral (rad) of four points, a (4, 3) array, or of many, (n, 4, 3); (−π, π], as IUPAC defines it."""
    a, b, c, d = np.moveaxis(np.asarray(points), -2, 0)
    axis = (c - b) / np.linalg.norm(c - b, axis=-1, keepdims=True)
    first, last = a - b, d - c
    first = first - (first * axis).sum(axis=-1, keepdims=True) * axis
    last = last - (last * axis).sum(axis=-1, keepdims=True) * axis
    return np.arctan2((np.cross(axis, first) * last).sum(axis=-1), (first * last).sum(axis=-1))


def turnBetween(first, second):
    """Return the size of the smallest turn (rad) between angles."""
    return np.abs((np.asarray(second) - first + np.pi) % (2 * np.pi) - np.pi)
