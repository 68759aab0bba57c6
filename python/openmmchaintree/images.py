"""Molecules that the images of a periodic box tear apart, made whole along their bonds."""

import numpy as np

from .components import connectedParts

# Narrower boxes (nm) stand for none: some programs write 1 Å, or zeros.
_LEAST_WIDTH = 0.5


def isBox(vectors):
    """Whether vectors, a (3, 3) array in nm with one a row, span a box that a molecule can be split over."""
    return leastWidth(vectors) >= _LEAST_WIDTH


def leastWidth(box):
    """Return how far apart opposite faces of a box are at least, in nm; 0 if its vectors span none.

    box : (3, 3) array, nm, a vector a row
    """
    if not np.isfinite(box).all():
        return 0.0
    try:
        return 1 / np.linalg.norm(np.linalg.inv(box), axis=0).max()
    except np.linalg.LinAlgError:
        return 0.0


def nearestImage(vectors, box):
    """Return vectors less the whole numbers of box vectors by which they are longer than need be.

    vectors : (..., 3) array, nm; box : (3, 3) array, nm, a vector a row; exact for vectors up to half the box
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
    """Shift atoms by box vectors so that all bonds are as short as they can be.

    The lowest-numbered atom of a molecule stays where it is. O(n) where bonds are many.

    Parameters
    ----------
    positions : (n, 3) float64 array, nm
    bonds : (m, 2) int array
    box : (3, 3) float64 array, nm

    Returns
    -------
    (n, 3) float64 array
        the positions given, if nothing is torn apart
    """
    bonds = np.asarray(bonds, dtype=int).reshape(-1, 2)
    vectors = positions[bonds[:, 1]] - positions[bonds[:, 0]]
    turns = np.rint(vectors @ np.linalg.inv(box)).astype(int)
    isTorn = turns.any(axis=1)
    if not isTorn.any():
        return positions
    # Parts within which nothing is torn move as one, so only the bonds between them are walked along.
    part = connectedParts(len(positions), bonds[~isTorn])
    shifts = _shiftsOfParts(part.max() + 1, part[bonds[isTorn]], turns[isTorn])
    # Parts are numbered by their lowest atoms, and a walk begins at the lowest part: that one stays.
    return positions + shifts[part] @ box


def _shiftsOfParts(count, pairs, turns):
    """Return the (count, 3) numbers of box vectors to add to each part, so that bonds between them close."""
    neighbors = [[] for _ in range(count)]
    for (first, second), turn in zip(pairs.tolist(), turns, strict=True):
        neighbors[first].append((second, -turn))
        neighbors[second].append((first, turn))
    shifts = np.zeros((count, 3), dtype=int)
    isPlaced = np.zeros(count, dtype=bool)
    for start in range(count):
        if isPlaced[start]:
            continue
        isPlaced[start] = True
        pending = [start]
        while pending:
            part = pending.pop()
            for other, turn in neighbors[part]:
                if not isPlaced[other]:
                    isPlaced[other] = True
                    shifts[other] = shifts[part] + turn
                    pending.append(other)
    return shifts
