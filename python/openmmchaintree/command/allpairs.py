"""Overlaps of all pairs of particles, by a k-d tree: the simple test with which the command checks its result.

It shares only the definition of a clash with the plugin's engine.
"""

from typing import NamedTuple

import numpy as np

from ..images import nearestImage, pairsOfImages
from ..plainspheres import PlainSpheres

# Up to this number of particles, comparing all pairs takes less time than importing SciPy.
_FEW = 1500

# The engine may decide either way within this distance (nm) of a limit.
SIGMA = 1e-9


class Overlaps(NamedTuple):
    """Pairs that overlap by more than their tolerance.

    pairs : (n, 2) int array, sorted, lower index first; overlaps, tolerances : (n,) float64 arrays, nm
    """

    pairs: np.ndarray
    overlaps: np.ndarray
    tolerances: np.ndarray


class HardSpheres(PlainSpheres):
    """The particles of a StericExclusionForce, and the overlaps of all their pairs."""

    def __init__(self, force, box=None):
        """Read a force; with a periodic box, a (3, 3) array in nm with a vector a row, pairs count in all images."""
        super().__init__(force)
        self._box = box

    def overlaps(self, positions):
        """Return the Overlaps beyond tolerance at positions, a float64 array of shape (n, 3) in nm.

        O(n log n) in time and O(n) in memory where particles do not crowd.

        Raises
        ------
        ValueError
            if a coordinate is not a finite number
        """
        pairs = self._nearPairs(positions)
        overlaps = self._overlaps(positions, pairs)
        tolerances = self.tolerances(*pairs.T)
        isBeyond = overlaps > tolerances
        isBeyond[isBeyond] = ~self.areExcluded(pairs[isBeyond])
        pairs, overlaps, tolerances = (array[isBeyond] for array in (pairs, overlaps, tolerances))
        order = np.argsort(self.keys(pairs))
        return Overlaps(pairs[order], overlaps[order], tolerances[order])

    def _nearPairs(self, positions):
        """Return the pairs closer than the largest spheres, which may overlap; the lower index comes first."""
        # A margin for the tree's rounding of distances.
        reach = self.reach + 1e-9 * (abs(self.reach) + np.abs(positions).max(initial=0))
        points = positions[self.modelled]
        if self._box is None:
            return self.modelled[_nearPairs(points, max(reach, 0))]
        return self.modelled[pairsOfImages(points, self._box, reach, _nearPairs)]

    def _overlaps(self, positions, pairs):
        first, second = pairs.T
        vectors = positions[first] - positions[second]
        if self._box is not None:
            vectors = nearestImage(vectors, self._box)
        squares = sum(vectors[:, k] ** 2 for k in range(3))
        return self.radii[first] + self.radii[second] - np.sqrt(squares)


def _nearPairs(positions, distance):
    """Return the pairs of points within a distance of each other, as an (m, 2) array, the lower index first."""
    if not np.isfinite(positions).all():
        raise ValueError("a coordinate is not a finite number")
    if len(positions) <= _FEW:
        first, second = np.triu_indices(len(positions), 1)
        squares = sum((positions[first, k] - positions[second, k]) ** 2 for k in range(3))
        return np.column_stack([first, second])[squares <= distance**2]
    from scipy.spatial import cKDTree

    return cKDTree(positions).query_pairs(distance, output_type="ndarray")


class Verdict(NamedTuple):
    """The result of `compare`: Overlaps not above their initial values; Overlaps beyond their limits; these limits."""

    tolerated: Overlaps
    beyond: Overlaps
    beyondLimits: np.ndarray


def compare(start, end):
    """Compare overlaps at the end with the start; a pair's limit is its tolerance, or its overlap at the start."""
    limits = {tuple(pair): overlap for pair, overlap in zip(start.pairs.tolist(), start.overlaps, strict=True)}
    endLimits = np.array(
        [limits.get(tuple(pair), tolerance) for pair, tolerance in zip(end.pairs.tolist(), end.tolerances, strict=True)]
    )
    # The engine adds SIGMA to the start's overlap, and within SIGMA of a limit either verdict is right.
    isBeyond = end.overlaps > endLimits.reshape(-1) + 2 * SIGMA
    return Verdict(_select(end, ~isBeyond), _select(end, isBeyond), endLimits[isBeyond])


def _select(overlaps, mask):
    return Overlaps(*(field[mask] for field in overlaps))
