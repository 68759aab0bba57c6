"""Which molecules of a Topology show their hydrogens."""

import numpy as np

from .graphs import connectedParts

_H, _C, _N, _O, _S = 1, 6, 7, 8, 16


class ShownHydrogens:
    """Which molecules of a BondGraph show their hydrogens.

    areShown : (n,) bool array, whether the molecule of each atom shows its hydrogens
    arePolarShown : (n,) bool array, whether it shows at least the hydrogens of N, O and S
    """

    def __init__(self, graph):
        bonds = np.array(graph.bonds, dtype=int).reshape(-1, 2)
        bonds = np.concatenate([bonds, bonds[:, ::-1]])
        self._molecule = connectedParts(len(graph.atoms), bonds)
        self._residue = graph.residueOf
        self._isHydrogen = graph.numbers == _H
        bearing = np.zeros(len(graph.atoms), dtype=bool)
        bearing[bonds[self._isHydrogen[bonds[:, 1]], 0]] = True
        isCarbon, isPolar = graph.numbers == _C, np.isin(graph.numbers, (_N, _O, _S))
        hasFew = np.bincount(bonds[:, 0], minlength=len(graph.atoms)) < 3
        withAny = self._countResidues(self._isHydrogen) > 0
        onCarbon = self._countResidues(isCarbon & bearing)
        areShown = withAny & (onCarbon >= self._countResidues(isCarbon & hasFew, without=isCarbon & bearing))
        onPolar = self._countResidues(isPolar & bearing)
        arePolarShown = areShown | (withAny & (2 * onPolar >= self._countResidues(isPolar)))
        self.areShown, self.arePolarShown = areShown[self._molecule], arePolarShown[self._molecule]

    def _countResidues(self, chosen, without=None):
        """Return for each molecule the number of residues with a chosen atom and without any atom of `without`."""
        keys = self._molecule * (self._residue.max(initial=0) + 1) + self._residue
        found = np.unique(keys[chosen] if without is None else np.setdiff1d(keys[chosen], keys[without]))
        return np.bincount(found // (self._residue.max(initial=0) + 1), minlength=self._molecule.max(initial=-1) + 1)
