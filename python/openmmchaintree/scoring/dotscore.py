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


def scorePlaces(atoms, atom, places, others, positions, hiding, hidingPlaces, onlyBumps=False, weights=None):
    """Return the scores of places of an atom, a (k,) array.

    Parameters
    ----------
    atoms : ContactAtoms
    atom : int
    places : (k, 3) array, nm
    others : (m,) int array
        the atoms that it may touch, at positions
    positions : (n, 3) array, nm
    hiding : (h,) int array
        the atoms that are bonded to it, inside which no dot counts
    hidingPlaces : (k, h, 3) array, nm
    onlyBumps : bool
        whether hydrogen bonds cost, too
    weights : (m,) array, optional
        what counts for dots in each of the others
    """
    own = atoms.flags[atom]
    flags = atoms.flags[others]
    isBond = ((own & DONOR > 0) & (flags & ACCEPTOR > 0)) | ((own & ACCEPTOR > 0) & (flags & DONOR > 0))
    areCharged = (own & (POSITIVE | NEGATIVE) > 0) & (flags & (POSITIVE | NEGATIVE) > 0)
    opposite = ((own & POSITIVE > 0) & (flags & NEGATIVE > 0)) | ((own & NEGATIVE > 0) & (flags & POSITIVE > 0))
    isBond &= ~areCharged | opposite
    radius = float(atoms.radii[atom])
    vectors = places[:, None] - positions[others]
    distances = np.sqrt((vectors**2).sum(axis=2))
    touches = (distances < radius + atoms.radii[others]) & (isBond | (flags & DUMMY == 0)) & (others != atom)
    isUsed = touches.any(axis=0)
    if not isUsed.any():
        return np.zeros(len(places))
    others, isBond, areCharged = others[isUsed], isBond[isUsed], areCharged[isUsed]
    dots = dotSphere(radius)
    # |place + dot - other|^2 for each place, dot and other.
    squares = (distances[:, isUsed] ** 2)[:, None] + radius**2 + 2 * (dots @ vectors[:, isUsed].transpose(0, 2, 1))
    gaps = np.sqrt(np.maximum(squares, 0)) - atoms.radii[others]
    gaps[np.broadcast_to(~touches[:, None, isUsed], gaps.shape)] = np.inf
    nearest = gaps.argmin(axis=2)
    least = np.take_along_axis(gaps, nearest[..., None], axis=2)[..., 0]
    rows, columns = np.nonzero(least < 0)
    nearest, least = nearest[rows, columns], least[rows, columns]
    if len(hiding):
        reached = places[rows] + dots[columns]
        hidden = ((reached[:, None] - hidingPlaces[rows]) ** 2).sum(axis=2) < atoms.radii[hiding] ** 2
        least[hidden.any(axis=1)] = 0
    allowed = np.where(areCharged, _CHARGED_BOND, _HYDROGEN_BOND)[nearest]
    bonded = isBond[nearest]
    values = _BUMP * least
    values[bonded & (least >= -allowed)] *= -_BOND / _BUMP if not onlyBumps else 1
    tooDeep = bonded & (least < -allowed)
    values[tooDeep] = _BUMP * (least + allowed)[tooDeep]
    if weights is not None:
        values *= weights[isUsed][nearest]
    return np.bincount(rows, weights=values, minlength=len(places))
