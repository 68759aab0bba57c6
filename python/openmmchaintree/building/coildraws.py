"""Drawing torsions of residues from the densities of random coils, to build chains."""

import numpy as np

from ..coil import readCoilTables, tableOf
from ..densities import ENDS_ALIKE, rotamersOf, rotamerTables
from ..residues import isMirrored

_COMMON = "ALA"  # whose φ and ψ residues have that are in no table


class CoilDraws:
    """Draws φ and ψ of a residue, or its χ, in rad."""

    def __init__(self, seed, tables=None):
        """Draw by a seed; tables : as for `createCoilForce`."""
        self._tables = readCoilTables(tables)
        self._random = np.random.default_rng(seed)

    def backbone(self, name, nextName=None):
        """Return φ and ψ of a residue, given the next residue's name or None."""
        counts = self._tables[tableOf(name, nextName, self._tables) or _COMMON]
        bins = len(counts)
        chosen = np.array(divmod(self._random.choice(counts.size, p=counts.ravel() / counts.sum()), bins))
        phi, psi = (chosen + self._random.random(2)) * 2 * np.pi / bins - np.pi
        return (-phi, -psi) if isMirrored(name) else (phi, psi)

    def sideChain(self, name):
        """Return χ1, χ2, … of a residue; an empty array if there are no rotamers of it."""
        known = rotamersOf(name)
        if known is None:
            return np.empty(0)
        counts, means, deviations = rotamerTables()[known]
        chosen = self._random.choice(len(counts), p=counts / counts.sum())
        chis = means[chosen] + deviations[chosen] * self._random.normal(size=means.shape[1])
        if known in ENDS_ALIKE:
            chis[-1] += self._random.choice([0, 180])
        return np.radians(-chis if isMirrored(name) else chis)
