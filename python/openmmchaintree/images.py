"""Periodic boxes, and molecules that are split over them, made whole along their bonds."""

from itertools import product

import numpy as np
import openmm
from openmm import unit

from .errors import InputError
from .graphs import connectedParts, growTrees, neighborLists

# A narrower box (nm) means that there is none: some programs write 1 Å, or zeros.
_LEAST_WIDTH = 0.5

# Components of box vectors (nm) that are only rounding.
_ROUNDING = 1e-6


def isBox(vectors):
    """Whether vectors, a (3, 3) array in nm with one vector a row, span a box that a molecule can be split over."""
    return leastWidth(vectors) >= _LEAST_WIDTH


def boxOf(topology):
    """Return the periodic box of a Topology as a (3, 3) float64 array in nm, a vector a row; None without one."""
    vectors = topology.getPeriodicBoxVectors()
    if vectors is None:
        return None
    box = np.array(vectors.value_in_unit(unit.nanometer), dtype=np.float64)
    return box if isBox(box) else None


def leastWidth(box):
    """Return the least distance between opposite faces of a box in nm; 0 if its vectors span none.

    box : (3, 3) array, nm, a vector a row
    """
    if not np.isfinite(box).all():
        return 0.0
    try:
        return 1 / np.linalg.norm(np.linalg.inv(box), axis=0).max()
    except np.linalg.LinAlgError:
        return 0.0


def nearestImage(vectors, box):
    """Return vectors shortened by whole numbers of box vectors.

    vectors : (..., 3) array, nm; box : (3, 3) array, nm, a vector a row. Results up to half the box long are the
    shortest possible.
    """
    return vectors - np.rint(vectors @ np.linalg.inv(box)) @ box


def reducedBox(box):
    """Return vectors of the same lattice in OpenMM's reduced form.

    box : (3, 3) float64 array, a vector a row, of which the first lies along x and the second in the plane of x and y
    """
    a, b, c = box
    c = c - b * np.rint(c[1] / b[1])
    c = c - a * np.rint(c[0] / a[0])
    b = b - a * np.rint(b[0] / a[0])
    return np.array([a, b, c])


def engineBox(box, source):
    """Return the vectors of a box, (3, 3) in nm or None, in OpenMM's reduced form.

    Raises
    ------
    InputError
        if there is no box, or its first vectors are not along x and in the plane of x and y; source names the input
    """
    if box is None or not isBox(box):
        raise InputError(f"{source}: there is no periodic box, which periodic images need")
    if np.abs(np.triu(box, 1)).max() > _ROUNDING or not (np.diag(box) > 0).all():
        raise InputError(f"{source}: the vectors of the periodic box must be along x, in the xy plane, and above it")
    return reducedBox(np.tril(np.asarray(box, dtype=np.float64)))


def vectorsOf(box):
    """Return a box as the three vectors that OpenMM takes; box : (3, 3) array, nm, a vector a row."""
    return [openmm.Vec3(*vector) for vector in np.asarray(box).tolist()]


def pairsOfImages(positions, box, reach, nearPairs):
    """Return the pairs of points of which some images are within a reach, an (m, 2) int array without repeats.

    positions : (n, 3) array, nm; box : (3, 3) array, nm, a vector a row, at least twice as wide as the reach (nm)
    nearPairs : a function of points and a reach that returns such pairs without images
    """
    reach, inverse = max(reach, 0), np.linalg.inv(box)
    margins = reach * np.linalg.norm(inverse, axis=0)
    fractions = positions @ inverse
    fractions -= np.floor(fractions)
    points, origins = [], []
    for turn in sorted(product((-1, 0, 1), repeat=3), key=np.any):  # the points themselves come first
        shifted = fractions + turn
        inside = np.flatnonzero(((-margins <= shifted) & (shifted <= 1 + margins)).all(axis=1))
        points.append(shifted[inside] @ box)
        origins.append(inside)
    origins = np.concatenate(origins)
    pairs = nearPairs(np.concatenate(points), reach)
    pairs = origins[pairs[(pairs < len(positions)).any(axis=1)]]
    return np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0)


def makeWhole(positions, bonds, box):
    """Shift atoms by box vectors so that all bonds become as short as possible.

    The lowest-numbered atom of each molecule keeps its position. O(n + bonds).

    Parameters
    ----------
    positions : (n, 3) float64 array, nm
    bonds : (m, 2) int array
    box : (3, 3) float64 array, nm

    Returns
    -------
    (n, 3) float64 array
        the same array if no molecule is split
    """
    bonds = np.asarray(bonds, dtype=int).reshape(-1, 2)
    vectors = positions[bonds[:, 1]] - positions[bonds[:, 0]]
    turns = np.rint(vectors @ np.linalg.inv(box)).astype(int)
    isTorn = turns.any(axis=1)
    if not isTorn.any():
        return positions
    # Parts without split bonds move as one, so only the bonds between them matter.
    part = connectedParts(len(positions), bonds[~isTorn])
    shifts = _shiftsOfParts(part.max() + 1, part[bonds[isTorn]], turns[isTorn])
    # Parts are numbered by their lowest atoms, and a walk begins at the lowest part, which keeps its position.
    return positions + shifts[part] @ box


def _shiftsOfParts(count, pairs, turns):
    """Return the (count, 3) numbers of box vectors to add to each part, so that bonds between parts are short."""
    turnOf = {}
    for (first, second), turn in zip(pairs.tolist(), turns, strict=True):
        turnOf.setdefault((first, second), -turn)
        turnOf.setdefault((second, first), turn)
    shifts = np.zeros((count, 3), dtype=int)
    for part, parent in growTrees(neighborLists(count, pairs.tolist()), range(count)):
        shifts[part] = shifts[parent] + turnOf[parent, part]
    return shifts
