"""The particles of a StericExclusionForce as plain arrays, for comparing pairs without the engine."""

from functools import cached_property

import numpy as np
from openmm import unit


class PlainSpheres:
    """The data that decide whether two particles clash: radii, tolerances and exclusions.

    radii : (n,) float64 array, nm; modelled : int array, the particles with a radius
    reach : float, nm, the largest distance at which two particles may clash
    """

    def __init__(self, force):
        """Read a StericExclusionForce."""
        parameters = [force.getParticleParameters(i) for i in range(force.getNumParticles())]
        self.radii = np.array([radius.value_in_unit(unit.nanometer) for radius, _ in parameters], dtype=np.float64)
        self.modelled = np.flatnonzero(self.radii > 0)
        roles = np.array([role for _, role in parameters], dtype=int)
        self._donors = (roles & force.Donor) != 0
        self._acceptors = (roles & force.Acceptor) != 0
        self._tolerance = force.getOverlapTolerance().value_in_unit(unit.nanometer)
        self._allowance = force.getHydrogenBondAllowance().value_in_unit(unit.nanometer)
        self.reach = 2 * self.radii.max(initial=0) - self._tolerance
        self._force = force

    def tolerances(self, first, second):
        """Return the overlap (nm) that each of some pairs may have."""
        bonded = (self._donors[first] & self._acceptors[second]) | (self._acceptors[first] & self._donors[second])
        return self._tolerance + np.where(bonded, self._allowance, 0.0)

    def areExcluded(self, pairs):
        """Return whether each of some pairs, an (m, 2) int array, is excluded."""
        return np.isin(self.keys(pairs), self._excluded)

    def keys(self, pairs):
        """Return a number for each pair, in the order of sorted pairs."""
        return pairs.min(axis=1) * len(self.radii) + pairs.max(axis=1)

    @cached_property
    def _excluded(self):
        exclusions = (self._force.getExclusionParticles(i) for i in range(self._force.getNumExclusions()))
        return self.keys(np.array([*exclusions], dtype=np.int64).reshape(-1, 2))
