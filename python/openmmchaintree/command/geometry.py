"""Dihedrals and lengths of bonds, computed from positions."""

from typing import NamedTuple

import numpy as np

# Allowed change of a bond's length: nm, plus the rounding of coordinates in units of the last place.
_LARGEST_CHANGE = 1e-9
_ROUNDINGS = 8


def dihedrals(positions, particles):
    """Return the IUPAC dihedrals, in (−π, π] rad, of m quadruples of particles.

    positions : (n, 3) float64 array, nm; particles : (m, 4) int array
    """
    first, second, third, fourth = (positions[particles[:, k]] for k in range(4))
    axis = third - second
    normal1 = np.cross(second - first, axis)
    normal2 = np.cross(axis, fourth - third)
    sine = np.einsum("ij,ij->i", np.linalg.norm(axis, axis=1)[:, None] * (second - first), normal2)
    return np.arctan2(sine, np.einsum("ij,ij->i", normal1, normal2))


class BondVerdict(NamedTuple):
    """The changes of bond lengths.

    largestChange : float, nm; changed : (n, 2) int array, bonds whose change exceeds rounding;
    changes : (n,) float64 array, nm, their changes
    """

    largestChange: float
    changed: np.ndarray
    changes: np.ndarray


class BondLengths:
    """The lengths of a StericExclusionForce's bonds and closures at the start, which no move changes."""

    def __init__(self, force, positions):
        """Take the force and its initial positions, a float64 array of shape (n, 3) in nm."""
        bonds = [force.getBondParticles(i) for i in range(force.getNumBonds())]
        bonds += [force.getClosureParticles(i)[1:3] for i in range(force.getNumClosures())]
        self._bonds = np.array(bonds, dtype=int).reshape(-1, 2)
        self._lengths = self._measure(positions)

    def compare(self, positions):
        """Return the BondVerdict for later positions."""
        changes = np.abs(self._measure(positions) - self._lengths)
        rounding = _ROUNDINGS * np.spacing(np.abs(positions).max(initial=0))
        hasChanged = ~(changes <= _LARGEST_CHANGE + rounding)
        return BondVerdict(float(changes.max(initial=0)), self._bonds[hasChanged], changes[hasChanged])

    def _measure(self, positions):
        first, second = self._bonds.T
        return np.linalg.norm(positions[first] - positions[second], axis=1)
