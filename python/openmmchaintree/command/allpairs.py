"""Overlaps by comparing every pair of particles: the plain test that the command checks its result with.

It shares nothing with the plugin's engine but the definition of a clash.
"""

from typing import NamedTuple

import numpy as np

# The engine may decide either way within this distance (nm) of a limit.
SIGMA = 1e-9

_ROWS_AT_ONCE = 256


class Overlaps(NamedTuple):
    """Pairs that overlap by more than their tolerance.

    pairs : (n, 2) int array, sorted, lower index first; overlaps, tolerances : (n,) float64 arrays, nm
    """

    pairs: np.ndarray
    overlaps: np.ndarray
    tolerances: np.ndarray


class HardSpheres:
    """The particles of a StericExclusionForce as plain arrays."""

    def __init__(self, force):
        parameters = [force.getParticleParameters(i) for i in range(force.getNumParticles())]
        self._radii = np.array([radius.value_in_unit(radius.unit) for radius, _ in parameters])
        roles = np.array([role for _, role in parameters], dtype=int)
        self._donors = (roles & force.Donor) != 0
        self._acceptors = (roles & force.Acceptor) != 0
        self._tolerance = _plain(force.getOverlapTolerance())
        self._allowance = _plain(force.getHydrogenBondAllowance())
        exclusions = [force.getExclusionParticles(i) for i in range(force.getNumExclusions())]
        self._excluded = {(min(pair), max(pair)) for pair in exclusions}

    def overlaps(self, positions):
        """Return the Overlaps beyond tolerance at positions, a float64 array of shape (n, 3) in nm. O(n²)."""
        modelled = np.flatnonzero(self._radii > 0)
        found = []
        for start in range(0, len(modelled), _ROWS_AT_ONCE):
            rows = modelled[start : start + _ROWS_AT_ONCE]
            columns = modelled[start:]
            overlaps = self._overlapTable(positions, rows, columns)
            tolerances = self._toleranceTable(rows, columns)
            row, column = np.nonzero((overlaps > tolerances) & (rows[:, None] < columns[None, :]))
            for first, second, i, j in zip(rows[row], columns[column], row, column, strict=True):
                if (int(first), int(second)) not in self._excluded:
                    found.append((int(first), int(second), overlaps[i, j], tolerances[i, j]))
        found.sort()
        pairs = np.array([entry[:2] for entry in found], dtype=int).reshape(-1, 2)
        values = np.array([entry[2:] for entry in found], dtype=np.float64).reshape(-1, 2)
        return Overlaps(pairs, values[:, 0], values[:, 1])

    def _overlapTable(self, positions, rows, columns):
        squares = sum((positions[rows, None, k] - positions[None, columns, k]) ** 2 for k in range(3))
        return self._radii[rows, None] + self._radii[None, columns] - np.sqrt(squares)

    def _toleranceTable(self, rows, columns):
        bonded = (self._donors[rows, None] & self._acceptors[None, columns]) | (
            self._acceptors[rows, None] & self._donors[None, columns]
        )
        return self._tolerance + np.where(bonded, self._allowance, 0.0)


class Verdict(NamedTuple):
    """What `compare` says of a state: Overlaps within what the start had, and beyond their limit (with the limits)."""

    tolerated: Overlaps
    beyond: Overlaps
    beyondLimits: np.ndarray


def compare(start, end):
    """Judge the overlaps of an end state by those of the start: a pair's limit is its tolerance or its overlap then."""
    limits = {tuple(pair): overlap for pair, overlap in zip(start.pairs.tolist(), start.overlaps, strict=True)}
    endLimits = np.array(
        [limits.get(tuple(pair), tolerance) for pair, tolerance in zip(end.pairs.tolist(), end.tolerances, strict=True)]
    )
    # The start's overlap is a limit with a margin of SIGMA, and within SIGMA of a limit either verdict is right.
    isBeyond = end.overlaps > endLimits.reshape(-1) + 2 * SIGMA
    return Verdict(_select(end, ~isBeyond), _select(end, isBeyond), endLimits[isBeyond])


def _select(overlaps, mask):
    return Overlaps(*(field[mask] for field in overlaps))


def _plain(quantity):
    return quantity.value_in_unit(quantity.unit)
