"""The lengths of bonds, compared with those at the start: torsions and rigid motions change none."""

from typing import NamedTuple

import numpy as np

# A bond's length may change by so much (nm), and by the rounding of coordinates (in units of the last place).
_LARGEST_CHANGE = 1e-9
_ROUNDINGS = 8


class BondVerdict(NamedTuple):
    """What became of the lengths of bonds.

    largestChange : float, nm; changed : (n, 2) int array, the bonds that changed by more than rounding explains;
    changes : (n,) float64 array, nm, by how much
    """

    largestChange: float
    changed: np.ndarray
    changes: np.ndarray


class BondLengths:
    """The lengths of the bonds, and of the closures, of a StericExclusionForce at the start."""

    def __init__(self, force, positions):
        """Positions are those of the start, a float64 array of shape (n, 3) in nm."""
        bonds = [force.getBondParticles(i) for i in range(force.getNumBonds())]
        bonds += [force.getClosureParticles(i)[1:3] for i in range(force.getNumClosures())]
        self._bonds = np.array(bonds, dtype=int).reshape(-1, 2)
        self._lengths = self._measure(positions)

    def compare(self, positions):
        """Return the BondVerdict on positions that come later."""
        changes = np.abs(self._measure(positions) - self._lengths)
        rounding = _ROUNDINGS * np.spacing(np.abs(positions).max(initial=0))
        hasChanged = ~(changes <= _LARGEST_CHANGE + rounding)
        return BondVerdict(float(changes.max(initial=0)), self._bonds[hasChanged], changes[hasChanged])

    def _measure(self, positions):
        first, second = self._bonds.T
        return np.linalg.norm(positions[first] - positions[second], axis=1)
