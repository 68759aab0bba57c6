"""The score that the program Reduce gives to places of hydrogens, by dots on the atoms that turn.

A dot that lies in another atom costs, one that lies in the partner of a hydrogen bond gains, by how deep it lies.

Source: Reduce 4.16 (AtomPositions.cpp); J. M. Word et al., J. Mol. Biol. 285, 1735-1747 (1999).
"""

import numpy as np

from .contactatoms import ACCEPTOR, DONOR, DUMMY, NEGATIVE, POSITIVE
from .dotcontacts import dotSphere

# How far hydrogen bonds may overlap (nm); the second is between charges.
_HYDROGEN_BOND, _CHARGED_BOND = 0.06, 0.08
# What a dot counts per depth in nm.
_BUMP, _BOND = 5.0, 2.0


def scorePlaces(atoms, atom, places, others, positions, hiding, moving, onlyBumps=False, weights=None):
    """Return the scores of orientations of a group, as one of its atoms contributes to them: a (k,) array.

    Parameters
    ----------
    atoms : ContactAtoms
    atom : int
    places : (k, 3) array, or (1, 3) for an atom that stays, nm
    others : (m,) int array
        the atoms that it may touch, at positions
    positions : (n, 3) array, nm
    hiding : (h,) int array
        the atoms that bonds join to it, inside which no dot counts, at positions
    moving : list of (radius, (k, 3) array), nm
        more such atoms, at their places in each orientation
    onlyBumps : bool
        whether hydrogen bonds cost, too
    weights : (m,) array, optional
        what counts for dots in each of the others
    """
    radius = float(atoms.radii[atom])
    count = max([len(places), *(len(points) for _, points in moving)])
    isBond, areCharged = _hydrogenBonds(atoms.flags[atom], atoms.flags[others])
    vectors = places[:, None] - positions[others]
    apart = (vectors**2).sum(axis=2)
    touches = (apart < (radius + atoms.radii[others]) ** 2) & (isBond | (atoms.flags[others] & DUMMY == 0))
    touches &= others != atom
    isUsed = touches.any(axis=0)
    if not isUsed.any():
        return np.zeros(count)
    others, isBond, areCharged, touches = others[isUsed], isBond[isUsed], areCharged[isUsed], touches[:, isUsed]
    dots = dotSphere(radius)
    # |place + dot - other|^2 for each place, dot and other.
    squares = apart[:, None, isUsed] + radius**2 + 2 * (dots @ vectors[:, isUsed].transpose(0, 2, 1))
    rows, columns, targets = np.nonzero((squares < atoms.radii[others] ** 2) & touches[:, None])
    gaps = np.sqrt(np.maximum(squares[rows, columns, targets], 0)) - atoms.radii[others[targets]]
    # Of each dot the atom in which it lies deepest.
    order = np.lexsort((gaps, rows * len(dots) + columns))
    keys = (rows * len(dots) + columns)[order]
    order = order[np.diff(keys, prepend=-1) > 0]
    rows, columns, targets, gaps = rows[order], columns[order], targets[order], gaps[order]
    reached = places[rows] + dots[columns]
    hidden = (((reached[:, None] - positions[hiding]) ** 2).sum(axis=2) < atoms.radii[hiding] ** 2).any(axis=1)
    rows, targets, gaps, reached = rows[~hidden], targets[~hidden], gaps[~hidden], reached[~hidden]
    values = _values(gaps, isBond[targets], areCharged[targets], onlyBumps)
    if weights is not None:
        values *= weights[isUsed][targets]
    if len(places) < count:  # all dots, in each orientation
        isFree = np.ones((count, len(values)), dtype=bool)
        for other, points in moving:
            isFree &= ((reached - points[:, None]) ** 2).sum(axis=2) >= other**2
        return isFree @ values
    for other, points in moving:
        values[((reached - points[rows]) ** 2).sum(axis=1) < other**2] = 0
    return np.bincount(rows, weights=values, minlength=count)


def _hydrogenBonds(own, flags):
    """Return which atoms may be hydrogen bonded to one, by their flags, and which of both are charged."""
    isBond = ((own & DONOR > 0) & (flags & ACCEPTOR > 0)) | ((own & ACCEPTOR > 0) & (flags & DONOR > 0))
    areCharged = (own & (POSITIVE | NEGATIVE) > 0) & (flags & (POSITIVE | NEGATIVE) > 0)
    opposite = ((own & POSITIVE > 0) & (flags & NEGATIVE > 0)) | ((own & NEGATIVE > 0) & (flags & POSITIVE > 0))
    return isBond & (~areCharged | opposite), areCharged


def _values(gaps, areBonds, areCharged, onlyBumps):
    """Return what dots count by their gaps (nm)."""
    values = _BUMP * gaps
    allowed = np.where(areCharged, _CHARGED_BOND, _HYDROGEN_BOND)
    tooDeep = areBonds & (gaps < -allowed)
    values[tooDeep] = _BUMP * (gaps + allowed)[tooDeep]
    if not onlyBumps:
        good = areBonds & ~tooDeep
        values[good] = -_BOND * gaps[good]
    return values
