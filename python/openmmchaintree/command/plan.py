"""The parts of a structure that move in a sampling run, and the fixed parts."""

from typing import NamedTuple

import numpy as np

from ..bonds import DISULFIDES, LOOPS, BondGraph, defaultClosures
from ..errors import InputError
from ..graphs import neighborLists, ringBonds
from ..links import Links
from ..naming import describeResidue
from ..notes import Note, listFirst
from ..residues import polymerBackbone
from ..selection import selectAtoms
from ..sterics import notesOnAlphaCarbons, notesOnTorsions
from ..torsions import (
    BETWEEN_FIXED,
    DISULFIDE_RING,
    KINDS_WITH_ENERGIES,
    METAL_RING,
    bondsThatStay,
    ofAtoms,
    searchTorsions,
    withoutThoseBetween,
)
from ..unbonded import unbondedNeighbors

# Without energies: torsions of proteins and nucleic acids, except δ, which is in a ring, and ω and rotors.
DEFAULT_KINDS = ("phi", "psi", "chi", "alpha", "beta", "gamma", "epsilon", "zeta")


# Remedies for omitted torsions.
_OPTIONS = {
    DISULFIDE_RING: f"which can be cut (--cut-disulfides) or closed (--close {DISULFIDES})",
    METAL_RING: "which can be cut (--cut-metals)",
    BETWEEN_FIXED: f"where only side chains turn, unless loops are closed (--close {LOOPS})",
}
_LOOPS_ARE_CLOSED = {BETWEEN_FIXED: "where only side chains turn, since loops of one or two residues cannot be closed"}


class Choice(NamedTuple):
    """The user's options that define what moves.

    kinds : kinds of torsions, as in `findTorsions`; None: all that rotate if energies are sampled, else DEFAULT_KINDS
    move, fix : str or None, selections in MDTraj's language: atoms whose torsions rotate, atoms that never move
    rigidBodies : bool, whether whole molecules move, too
    cutDisulfides, cutMetals : bool
    allowUnbonded : bool, whether moves may separate atoms at covalent distance that are not bonded
    close : "disulfides", "loops" or both, bonds kept by closed moves; None: disulfides if energies are sampled and
        disulfides are not cut, else none
    hasEnergies : bool, whether energies are sampled
    unknownRadius : float or None, nm, for atoms of elements without a known radius
    periodic : bool, whether pairs count in all images of the structure's box
    isFlexible : bool, whether bond lengths and angles change
    areDisordered : bool, whether moves suit disordered chains
    """

    kinds: tuple[str, ...] | None = None
    move: str | None = None
    fix: str | None = None
    rigidBodies: bool = False
    cutDisulfides: bool = False
    cutMetals: bool = False
    allowUnbonded: bool = False
    close: tuple[str, ...] | None = None
    hasEnergies: bool = False
    unknownRadius: float | None = None
    periodic: bool = False
    isFlexible: bool = False
    areDisordered: bool = False

    def withDefaults(self):
        """Return a Choice with defaults in place of None."""
        kinds, close = self.kinds, self.close
        if kinds is None:
            kinds = KINDS_WITH_ENERGIES if self.hasEnergies else DEFAULT_KINDS
        if close is None:
            close = defaultClosures(self.hasEnergies, self.cutDisulfides)
        return self._replace(kinds=kinds, close=close)


class Plan:
    """The moving and the fixed parts of a Structure: torsions and whole molecules.

    A molecule that does not move as a whole is rooted at one of its links: the link with fixed atoms, else the link
    with the largest part of the backbone, else the link with its first atom.

    Attributes
    ----------
    structure : Structure
    choice : Choice
    graph : BondGraph
        the bonds
    torsions : list of Torsion
    stays : (n,) bool array
        the atoms that never move
    fixed : (n,) bool array
        atoms that get mass 0: all that never move, except the first atoms of a chain, which cost less as part of it
    inMovingMolecules : (n,) bool array
        the atoms of molecules with moving atoms
    molecules : (n,) int array
        the number of the molecule of each atom
    isTurning, isRigidBody : (molecules,) bool arrays
        molecules with torsions; molecules that move as a whole
    rigidBodies : list of int
        an atom of each molecule that moves as a whole
    fixedAtoms : int array
        the atoms selected by --fix
    idleMolecules : int array
        molecules with torsions that --move did not select
    moleculesAtGaps : int array
        molecules that end at a gap in a chain
    cutDisulfides, cutMetals : list of (str, str)
        pairs of residues between which disulfides, and bonds of metals, were cut
    closed : list of (str, str)
        pairs of residues whose bonds are kept by closed moves
    rigid : str or None
        a description of rigid parts, if energies are sampled and bond lengths and angles keep their values
    notes : list of Note
        on bonds, and on omitted torsions and the reasons
    """

    def __init__(self, structure, choice):
        """Decide what moves.

        Raises
        ------
        InputError
            if a selection is wrong, or nothing can move
        """
        topology = structure.topology
        isCloseChosen = choice.close is not None
        choice = choice.withDefaults()
        self.structure = structure
        self.choice = choice
        moved = selectByOption(topology, "--move", choice.move)
        self.fixedAtoms = selectByOption(topology, "--fix", choice.fix)
        self.graph = graph = BondGraph(
            topology, structure.positions, choice.cutDisulfides, choice.cutMetals, choice.close, self.fixedAtoms
        )
        every = searchTorsions(graph, topology, choice.kinds)
        chosen = every if choice.move is None else ofAtoms(every, moved)
        search = withoutThoseBetween(chosen, graph, self.fixedAtoms)
        self.torsions = search.torsions
        self._remedies = {**_OPTIONS, **(_LOOPS_ARE_CLOSED if LOOPS in choice.close else {})}
        leftOut = notesOnTorsions(search.leftOut, self._remedies)
        self.notes = [*structure.notes, *notesOnAlphaCarbons(graph), *leftOut]
        links = Links(graph, self.torsions)
        self.molecules = links.moleculeOfAtom
        self.isTurning = self._moleculesWith(self.torsions)
        self.idleMolecules = np.flatnonzero(self._moleculesWith(every.torsions) & ~self._moleculesWith(chosen.torsions))
        ends = [residue for gap in graph.gaps for residue in (gap.residue1, gap.residue2)]
        self.moleculesAtGaps = np.unique(self.molecules[[next(residue.atoms()).index for residue in ends]])
        self.isRigidBody = self._chooseRigidBodies(moved)
        if not self.isTurning.any() and not self.isRigidBody.any():
            raise InputError(self._whyNothingMoves(every, chosen, search))

        backbones = [atoms for atoms in map(polymerBackbone, topology.residues()) if atoms]
        isRoot = np.zeros(links.count, dtype=bool)
        roots, isLarge = links.roots(self.fixedAtoms, backbones)
        isRoot[roots] = True
        self.stays = isRoot[links.ofAtom] & ~self.isRigidBody[self.molecules]
        isHeld = isLarge
        if choice.isFlexible:  # rigid parts that nobody fixes move atom by atom
            isHeld = np.zeros_like(isLarge)
            isHeld[self.molecules[self.fixedAtoms]] = True
        self.fixed = self.stays & (isHeld | ~self.isTurning)[self.molecules]
        self.inMovingMolecules = (self.isTurning | self.isRigidBody)[self.molecules]
        _, firstAtoms = np.unique(self.molecules, return_index=True)
        self.rigidBodies = firstAtoms[self.isRigidBody].tolist()
        self.cutDisulfides = self._describeCuts(choice.cutDisulfides, graph.disulfides, "disulfide to cut")
        self.cutMetals = self._describeCuts(choice.cutMetals, graph.metalBonds, "bond of a metal to cut")
        closing = [closure[1:3] for closure in graph.closures]
        mayClose = choice.close if isCloseChosen else closing
        self.closed = self._describeCuts(mayClose, closing, f"bond to close ({', '.join(choice.close)})")
        hasRigidParts = choice.hasEnergies and not choice.isFlexible
        self.rigid = _describeRigidParts(graph, self.torsions, self.fixedAtoms) if hasRigidParts else None
        self._checkUnbonded()

    def _moleculesWith(self, torsions):
        has = np.zeros(self.molecules.max() + 1, dtype=bool)
        has[self.molecules[[torsion.particles[1] for torsion in torsions]]] = True
        return has

    def _chooseRigidBodies(self, moved):
        """Choose the molecules that move as a whole, as an array of bool.

        Without --move, single atoms and fragments next to a gap in a chain, which would separate, stay in place.
        """
        isRigidBody = np.zeros(len(self.isTurning), dtype=bool)
        if self.choice.rigidBodies:
            if self.choice.move is not None:
                isRigidBody[self.molecules[moved]] = True
            else:
                isRigidBody[np.bincount(self.molecules) > 1] = True
                isRigidBody[self.moleculesAtGaps] = False
            isRigidBody[self.molecules[self.fixedAtoms]] = False
        return isRigidBody

    def _whyNothingMoves(self, every, chosen, search):
        if chosen.torsions:
            notes = "; ".join(map(str, notesOnTorsions(search.leftOut, self._remedies)))
            return f"--fix {self.choice.fix!r} leaves nothing that moves" + (f": {notes}" if notes else "")
        if every.torsions:
            return f"--move {self.choice.move!r}: none of these atoms has a torsion ({', '.join(self.choice.kinds)})"
        notes = notesOnAlphaCarbons(self.graph)
        if notes:
            return str(notes[0])
        reasons = listFirst(dict.fromkeys(torsion.reason for torsion in search.leftOut), "; ")
        ends = f": {reasons}" if reasons else ""
        if self.choice.kinds == DEFAULT_KINDS:
            ends += "; --torsions rotatable also turns bonds of other molecules"
        return f"there is no torsion of a protein or nucleic acid ({', '.join(self.choice.kinds)}) to sample{ends}"

    def _describeCuts(self, areCut, bonds, name):
        if not areCut:
            return []
        if not bonds:
            self.notes.append(Note(f"there is no {name}"))
        atoms = self.graph.atoms
        return [tuple(describeResidue(atoms[atom].residue) for atom in sorted(pair)) for pair in sorted(bonds)]

    def _checkUnbonded(self):
        """Refuse a structure in which a missing bond would let parts of a molecule separate."""
        axes = [torsion.particles[1:3] for torsion in self.torsions]
        found = unbondedNeighbors(self.graph, axes, np.flatnonzero(self.stays), self.structure.alternates)
        if not found:
            return
        note = Note("unbonded atoms at the distance of a bond, which trials move apart", map(str, found))
        if not self.choice.allowUnbonded:
            raise InputError(f"{note}: give these bonds (CONECT, LINK, _struct_conn), or use --allow-unbonded")
        self.notes.append(note)


def selectByOption(topology, option, selection):
    """Return the indices of selected atoms, none without a selection; errors name the option."""
    if selection is None:
        return np.empty(0, dtype=int)
    try:
        return selectAtoms(topology, selection)
    except ValueError as error:
        raise InputError(f"{option}: {error}") from error


def _describeRigidParts(graph, torsions, fixed):
    """Return a line on the rigid parts of a BondGraph under a list of Torsion; some atoms may be fixed."""
    parts = ["bond lengths and angles"]
    residueOf = [atom.residue for atom in graph.atoms]
    within = [bond for bond in graph.bonds if residueOf[bond[0]] is residueOf[bond[1]]]
    inRings = ringBonds(neighborLists(len(residueOf), within))
    if inRings:
        parts.append(f"rings ({', '.join(sorted({residueOf[bond[0]].name for bond in inRings}))})")
    across = ringBonds(graph.neighbors) - inRings
    if across:
        parts.append(str(Note("bonds in rings of several residues", map(graph.describePair, sorted(across)))))
    if graph.closures:
        bonds = [[describeResidue(graph.atoms[atom].residue) for atom in closure[1:3]] for closure in graph.closures]
        # A window in one ring keeps the others, so it may exclude torsions next to its closure.
        beside = ", and some beside them" if len(bonds) > 1 else ""
        parts.append(str(Note(f"turns about bonds that closed moves keep{beside}", map(" – ".join, bonds))))
    stiff = bondsThatStay(graph, torsions, fixed)
    if stiff:
        parts.append(str(Note("bonds in no ring", map(graph.describePair, stiff))))
    return "; ".join(parts)
