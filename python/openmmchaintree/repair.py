"""Repair of clashes in one call."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from openmm import app

from .selection import AtomSelection
from .units import Array, Number, inUnit, positionsInNm

if TYPE_CHECKING:
    from .repairs.causes import RemainingClash
    from .repairs.changes import Changes
    from .scoring.protonation import Protonated


class Repair(NamedTuple):
    """A repaired structure, and what the repair did.

    positions : (n, 3) float64 array, nm, of all atoms that were given
    clashscoreBefore, clashscoreAfter : float, MolProbity's, with hydrogens placed for it
    clashesBefore, clashesAfter : int, of that score
    ownBefore, ownAfter : int, pairs of spheres that overlap beyond what the repair allows, and that it could move apart
    changes : Changes, shifts and rotamers
    remaining : list of RemainingClash
    defectsBefore, defects : list of str, broken bonds, twisted peptides and pierced rings
    mendedBonds : list of str, broken bonds that were mended before torsions turned
    disulfides : list of str, disulfides whose length was mended
    isClean : bool, whether the clashscore is at most `cleanBelow` and no ring is pierced
    protonated : Protonated, the result with the hydrogens of the score
    """

    positions: np.ndarray
    clashscoreBefore: float
    clashscoreAfter: float
    clashesBefore: int
    clashesAfter: int
    ownBefore: int
    ownAfter: int
    changes: "Changes"
    remaining: "list[RemainingClash]"
    defectsBefore: list[str]
    defects: list[str]
    mendedBonds: list[str]
    disulfides: list[str]
    isClean: bool
    protonated: "Protonated"


class RepairChoices(NamedTuple):
    """What a repair may move; see `repairStructure`."""

    fixed: AtomSelection | None = None
    move: AtomSelection | None = None
    interface: tuple[str, str] | None = None
    maxShift: float | None = None
    sideChainsOnly: bool = False
    turnsLigands: bool = False
    mendsBonds: bool = False
    cleanBelow: float = 2.0


def repairStructure(
    topology: app.Topology,
    positions: Array,
    fixed: AtomSelection | None = None,
    move: AtomSelection | None = None,
    interface: tuple[str, str] | None = None,
    maxShift: Number | None = None,
    sideChainsOnly: bool = False,
    turnsLigands: bool = False,
    mendsBonds: bool = False,
    cleanBelow: float = 2.0,
    seed: int = 1,
) -> Repair:
    """Remove the clashes of a model of proteins, nucleic acids and their complexes, with as little motion as possible.

    Bond lengths and angles stay as they are. Side chains near clashes turn first, then backbones near clashes that
    remain, and chains of complexes move by some hundredths of a nanometer. Springs hold all heavy atoms at their
    places; at the end they pull back what has room. Hydrogens count where the program Reduce would place them.
    A model of 2,500 atoms takes about 4 s of one core.

        pdb = app.PDBFile("model.pdb")
        repair = repairStructure(pdb.topology, pdb.positions)
        print(repair.clashscoreBefore, repair.clashscoreAfter, repair.changes.traceRms)

    Parameters
    ----------
    topology : openmm.app.Topology
        with or without hydrogens
    positions : array of shape (n, 3) or Quantity
        nm, of whole molecules
    fixed : str, array of int or bool, or callable, optional
        atoms that must not move, as in `selectAtoms`
    move : str, array of int or bool, or callable, optional
        the only atoms that may move
    interface : (str, str), optional
        the names of two chains: only residues near the other chain move, and chains as a whole
    maxShift : float or Quantity, optional
        nm, the largest shift of any backbone atom
    sideChainsOnly : bool
        let only side chains turn
    turnsLigands : bool
        let molecules that are bound to no protein or nucleic acid move and turn, too. By default they stay.
    mendsBonds : bool
        first give residues with broken bonds ideal bond lengths and angles, by OpenMM's minimizer; others keep theirs
    cleanBelow : float
        the largest clashscore of a structure that counts as clean
    seed : int
        the random number seed, above 0; the same seed gives the same result

    Returns
    -------
    Repair

    Raises
    ------
    InputError
        a ValueError, if there is no protein or nucleic acid, side chains are missing, nothing may move, or a number is
        out of range
    ImportError
        if SciPy is missing, which the extra `tools` has
    """
    from .errors import InputError
    from .extras import importExtra

    importExtra("scipy", "repairing structures")
    from .repairs.run import repairModel

    positions = positionsInNm(positions, topology.getNumAtoms())
    if maxShift is not None:
        maxShift = float(inUnit(maxShift, "nm", "maxShift"))
        if not maxShift > 0:
            raise InputError("maxShift must be above 0")
    if not 0 < seed < 2**31:
        raise InputError("the seed must be from 1 to 2147483647")
    choices = RepairChoices(fixed, move, interface, maxShift, sideChainsOnly, turnsLigands, mendsBonds, cleanBelow)
    return Repair(**repairModel(topology, positions, choices, int(seed)))
