"""The copies of a structure in its crystal, by the operations of the space group."""

from itertools import product
from typing import NamedTuple

import gemmi
import numpy as np

from ..errors import InputError
from ..images import leastWidth
from ..notes import Note
from .filebonds import bondsWithCopies

# Narrower cells (nm) hold no molecule: programs write 1 Å, or zeros, where there is no crystal.
_LEAST_WIDTH = 0.25

# The largest relative deviation of a cell from the symmetry of its space group, and of SCALE from CRYST1.
_DEVIATION = 0.01

# Each atom of an ordered crystal takes more room than this (nm³).
_LEAST_VOLUME = 0.003

_OMITTED = "copies by non-crystallographic symmetry (MTRIX, _struct_ncs_oper) that the file leaves out do not count"


class Copy(NamedTuple):
    """A copy of all atoms: atom i is at rotation @ x_i + translation, in nm.

    operator : str, in fractions of the cell, such as "-x+1,y+1/2,-z"; inverse : str, that of the inverse operation
    """

    operator: str
    inverse: str
    rotation: np.ndarray
    translation: np.ndarray


class Crystal:
    """The cell and the space group of a structure file.

    Attributes
    ----------
    path : str or Path, of the file
    spaceGroup : str
    occupancies : (n,) float64 array, of all atoms
    bondsWithCopies : list of (int, int)
        pairs of an atom and an atom of a copy that the file lists as bonded, the lower index first
    notes : list of Note
    """

    def __init__(self, path, models):
        """Take the crystal of Models.

        Raises
        ------
        InputError
            if the file has no cell or no known space group, or these contradict each other or the atoms
        """
        self.path = path
        cell = models.file.cell
        self._orth, self._frac = np.array(cell.orth.mat.tolist()), np.array(cell.frac.mat.tolist())
        self._origin = np.array(cell.frac.vec.tolist())
        if not cell.is_crystal() or not leastWidth(0.1 * self._orth.T) > _LEAST_WIDTH:
            raise InputError(f"{path}: there is no cell of a crystal (CRYST1, _cell), which its symmetry needs")
        name = models.file.spacegroup_hm
        group = models.file.find_spacegroup()
        if group is None:
            reason = f"the space group {name!r} is not known" if name.strip() else "there is no space group"
            raise InputError(f"{path}: {reason} (CRYST1, _symmetry), which the symmetry of a crystal needs")
        if any(not np.array_equal(box, models.boxes[0]) for box in models.boxes):
            raise InputError(f"{path}: its models have different cells, which a crystal does not have")
        self.spaceGroup = group.xhm()
        self._operations = list(group.operations())
        self._checkCell(path, cell)
        room = cell.volume * 1e-3 / len(self._operations)
        if room < _LEAST_VOLUME * len(models.atoms):
            atoms = f"{len(models.atoms):,} atoms, {len(self._operations)} times"
            raise InputError(f"{path}: the cell of {cell.volume * 1e-3:.3g} nm³ has no room for {atoms}")
        self.occupancies = np.array([atom.occ for atom in models.atoms], dtype=np.float64)
        self.bondsWithCopies = bondsWithCopies(models)
        isIncomplete = any(not operation.given for operation in models.file.ncs)
        self.notes = [Note(_OMITTED)] if isIncomplete else []

    def _checkCell(self, path, cell):
        metric = self._orth.T @ self._orth
        scale = _DEVIATION * metric.max()
        expected = gemmi.UnitCell(*cell.parameters).metric_tensor().as_mat33().tolist()
        if np.abs(metric - np.array(expected)).max() > scale:
            raise InputError(f"{path}: the cell (CRYST1) contradicts the axes that SCALE gives")
        for rotation in (np.array(operation.float_seitz())[:3, :3] for operation in self._operations):
            if np.abs(rotation.T @ metric @ rotation - metric).max() > scale:
                raise InputError(f"{path}: the cell does not have the symmetry of the space group {self.spaceGroup}")

    def copiesNear(self, positions, reach):
        """Yield each Copy that may have atoms within a reach (nm) of positions, an (n, 3) array in nm.

        Of an operation and its inverse only one comes. The positions themselves are not among them.
        """
        fractions = 10 * positions @ self._frac.T + self._origin
        # A step of 1 along an axis is at least as long as the distance of the cell's faces.
        margins = 10 * reach * np.linalg.norm(self._frac, axis=1)
        low, high = fractions.min(axis=0) - margins, fractions.max(axis=0) + margins
        for operation in self._operations:
            seitz = np.array(operation.float_seitz())
            images = fractions @ seitz[:3, :3].T + seitz[:3, 3]
            lowest, highest = np.ceil(low - images.max(axis=0)), np.floor(high - images.min(axis=0))
            for shift in product(*map(range, lowest.astype(int).tolist(), (highest + 1).astype(int).tolist())):
                moved = operation.translated([gemmi.Op.DEN * steps for steps in shift])
                operator, inverse = moved.triplet(), moved.inverse().triplet()
                if operator <= inverse and operator != "x,y,z":
                    yield Copy(operator, inverse, *self._inSpace(moved))

    def _inSpace(self, operation):
        """Return the rotation and the translation (nm) of an operation on fractions."""
        seitz = np.array(operation.float_seitz())
        rotation = self._orth @ seitz[:3, :3] @ self._frac
        translation = self._orth @ (seitz[:3, :3] @ self._origin + seitz[:3, 3] - self._origin)
        return rotation, 0.1 * translation
