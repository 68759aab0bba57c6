"""Periodic boxes, and molecules that are split over them, made whole along their bonds."""

import numpy as np
from openmm import unit

from .graphs import connectedParts, growTrees, neighborLists

# A narrower box (nm) means that there is none: some programs write 1 Å, or zeros.
_LEAST_WIDTH = 0.5


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
