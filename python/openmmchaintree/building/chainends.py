"""The ends of segments of a chain, where missing residues are built on."""

import numpy as np

from ..errors import InputError
from ..naming import describeResidue
from ..residues import PEPTIDE_BACKBONE
from ..templates import atomAliases, standardName
from .chainbuilder import Joint, dihedralOf


class ChainEnd:
    """An amino acid beside missing residues.

    Raises
    ------
    InputError
        if it lacks N, CA or C
    """

    def __init__(self, residue, neighbors, positions):
        """Take a residue of a Topology, the lists of bonded atoms by the index of each atom, and positions (nm)."""
        aliases = atomAliases(standardName(residue.name))
        self.residue = residue
        self._atoms = {aliases.get(atom.name, atom.name): atom for atom in residue.atoms()}
        self._positions = positions
        lacking = [name for name in PEPTIDE_BACKBONE if name not in self._atoms]
        if lacking:
            raise InputError(
                f"{describeResidue(residue)} lacks {', '.join(lacking)}, so nothing can be built beside it: complete "
                "or remove the residue first"
            )
        self._oxygens = [atom for atom in neighbors[self._atoms["C"].index] if _isElement(atom, "O")]
        self._oxygens.sort(key=lambda atom: aliases.get(atom.name, atom.name) != "O")
        beside = neighbors[self._atoms["N"].index]
        self._hydrogensOfN = [atom for atom in beside if _isElement(atom, "H")]
        own = {self._atoms["CA"], *self._hydrogensOfN}
        self._ring = next((atom for atom in beside if atom.residue is residue and atom not in own), None)

    def _at(self, name):
        return self._positions[self._atoms[name].index]

    @property
    def backbone(self):
        """The places of N, CA and C."""
        return tuple(self._at(name) for name in PEPTIDE_BACKBONE)

    def jointForNext(self):
        """Return the Joint for a residue behind: ψ is that of the oxygen."""
        n, ca, c = self.backbone
        if not self._oxygens:
            return Joint(n, ca, c, None)
        return Joint(n, ca, c, dihedralOf(n, ca, c, self._positions[self._oxygens[0].index]) + np.pi)

    def jointForPrevious(self):
        """Return the Joint for a residue before: φ is that of the hydrogen of N, or of the ring of proline."""
        n, ca, c = self.backbone
        opposite = self._ring or (None if self._isAmine() else next(iter(self._hydrogensOfN), None))
        if opposite is None:
            return Joint(n, ca, c, None)
        return Joint(n, ca, c, dihedralOf(c, ca, n, self._positions[opposite.index]) + np.pi)

    def _isAmine(self):
        """Whether N has the hydrogens of a free end, of which a peptide bond leaves one, or none in proline."""
        return len(self._hydrogensOfN) > (0 if self._ring else 1)

    def surplusBeforeNext(self):
        """Return the atoms that a residue behind replaces."""
        return [*self._oxygens[1:], *(self._atoms[name] for name in ("HXT",) if name in self._atoms)]

    def surplusBehindPrevious(self):
        """Return the atoms that a residue before replaces, and whether N then lacks a hydrogen."""
        return (self._hydrogensOfN, self._ring is None) if self._isAmine() else ([], False)


def _isElement(atom, symbol):
    return atom.element is not None and atom.element.symbol == symbol
