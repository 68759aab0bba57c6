"""Tails and linkers of a protein: built onto a Structure, or a whole chain from its sequence."""

from typing import NamedTuple

import numpy as np
from openmm import app

from ..errors import InputError
from ..graphs import connectedParts, neighborLists
from ..naming import describeResidue
from ..notes import Note, found
from ..residues import isNucleotide, isPolymer
from ..structures.sequencegaps import SequenceGap, addressOf, findMissingResidues, lacksBackbone
from ..structures.structure import Structure
from .chainassembly import ChainAssembly
from .chainbuilder import amideHydrogen, axesOf, backboneBefore, backboneBehind, buildBackward, buildForward
from .chainends import ChainEnd
from .closing import FEWEST, closeGap

_REACH = 0.38  # nm that one residue spans
_HYDROGENS = 0.5  # to a heavy atom, above which a model has its hydrogens


class Built(NamedTuple):
    """A Structure with built residues.

    structure : Structure; parts : list of lists of Residue, the built ones of each tail or linker
    isBuilt : (n,) bool array, for each atom whether it is new
    isMoved : (n,) bool array, for each atom whether it belongs to a domain that moves with its linker
    """

    structure: Structure
    parts: list
    isBuilt: np.ndarray
    isMoved: np.ndarray


def buildFromSequence(names, draws, hydrogens):
    """Return a Built chain of residue names, numbered from 1."""
    residues, _ = buildForward(names, draws, hydrogens)
    topology = app.Topology()
    chain, previous = topology.addChain("A"), None
    for number, built in enumerate(residues, 1):
        residue = topology.addResidue(built.name, chain, str(number))
        atoms = [
            topology.addAtom(name, app.Element.getBySymbol(element), residue)
            for name, element in zip(built.names, built.elements, strict=True)
        ]
        for first, second in built.bonds:
            topology.addBond(atoms[first], atoms[second])
        byName = {atom.name: atom for atom in atoms}
        if previous is not None:
            topology.addBond(previous["C"], byName["N"])
        previous = byName
    positions = np.concatenate([built.positions for built in residues])
    structure = Structure("sequence", topology, positions, [""] * len(positions))
    every = np.ones(len(positions), dtype=bool)
    return Built(structure, [list(topology.residues())], every, ~every)


def buildOnto(structure, sequences, draws, hydrogens, movesDomains, closesGaps=False):
    """Build missing residues onto a Structure: at the ends of chains, and between domains that then move.

    Parameters
    ----------
    structure : Structure
        with its file
    sequences : list of lists of residue names, or None
        of the chains; default: those of the file
    draws : CoilDraws
    hydrogens : bool, or None
        whether the new residues have hydrogens; default: where the chain has them
    movesDomains : bool
        whether gaps become linkers, with which all domains of a chain move but its largest
    closesGaps : bool
        whether residues are built in gaps whose sides stay

    Returns
    -------
    Built
    list of Note

    Raises
    ------
    InputError
        if a residue cannot be built, or nothing is missing that can be
    """
    if structure.file is None:
        raise InputError("the residues that are missing are known only from a structure file with its sequence")
    gaps, notes = findMissingResidues(structure.file, structure.model, sequences)
    work = _Work(structure, draws, hydrogens)
    gaps = [work.withStubs(gap) for gap in gaps if work.canBuild(gap)]
    ends = [gap for gap in gaps if gap.before is None or gap.after is None]
    inner = [gap for gap in gaps if gap not in ends]
    for gap in ends:
        work.buildTail(gap)
    if movesDomains:
        for chain in dict.fromkeys(gap.before[0] for gap in inner):
            work.buildLinkers([gap for gap in inner if gap.before[0] == chain])
    for gap in [] if movesDomains else inner:
        if not (closesGaps and work.closeGap(gap)):
            work.open.append(work.describe(gap))
    notes += work.notes()
    if not work.hasBuilt:
        remedy = ": gaps become linkers with ensemble --move-domains (moveDomains=True)" if inner else ""
        reasons = "".join(f"; {note}" for note in notes)
        raise InputError(f"no residue is missing at the ends of chains{remedy}{reasons}")
    return work.finish(), notes


class _Work:
    """Builds onto one Structure."""

    def __init__(self, structure, draws, hydrogens):
        self._structure, self._draws, self._hydrogens = structure, draws, hydrogens
        topology = structure.topology
        self._atoms = list(topology.atoms())
        self._bonds = [(bond[0].index, bond[1].index) for bond in topology.bonds()]
        neighbors = neighborLists(len(self._atoms), self._bonds)
        self._neighbors = [[self._atoms[i] for i in ofAtom] for ofAtom in neighbors]
        self._positions = structure.positions.copy()
        self._residues = {}
        for residue in filter(isPolymer, topology.residues()):
            self._residues.setdefault(addressOf(residue), residue)
        self._assembly = ChainAssembly(structure)
        self._moved = np.zeros(len(self._atoms), dtype=bool)
        self._hydrogenated = []  # residues whose N needs a hydrogen, with the last residue built before it
        self.hasBuilt = False
        self.open, self._strange, self._stubs = [], [], []
        self._tails, self._linkers, self._closed, self._taken = [], [], [], []

    def describe(self, gap):
        """Return a gap in words."""
        ends = [describeResidue(self._residues[end]) for end in (gap.before, gap.after) if end is not None]
        names = " ".join(gap.names[:3]) + (" …" if len(gap.names) > 3 else "")
        side = "before" if gap.before is None else "behind" if gap.after is None else "between"
        return f"{len(gap.names)} residues ({names}) {side} {' and '.join(ends)}"

    def canBuild(self, gap):
        """Whether the residues are amino acids, or caps at an end, beside residues of the model."""
        ends = [self._residues.get(end) for end in (gap.before, gap.after) if end is not None]
        if None in ends:
            return False
        names = [*gap.names, *(residue.name for residue in ends)]
        if any(map(isNucleotide, names)):
            self._strange.append(self.describe(gap))
            return False
        return True

    def withStubs(self, gap):
        """Return a gap with the residues beside it that lack N, CA or C, which are left out."""
        before, after, names = gap
        while before is not None and lacksBackbone(self._residues[before]):
            before, names = self._leaveOut(before, -1), [self._residues[before].name, *names]
        while after is not None and lacksBackbone(self._residues[after]):
            after, names = self._leaveOut(after, 1), [*names, self._residues[after].name]
        return SequenceGap(before, after, names)

    def _leaveOut(self, end, step):
        """Leave out the residue at an end of a gap, and return the end of the gap then."""
        residue = self._residues[end]
        chain = list(filter(isPolymer, residue.chain.residues()))
        place = chain.index(residue) + step
        if not 0 <= place < len(chain):
            raise InputError(f"{describeResidue(residue)} lacks N, CA or C, and is alone beside missing residues")
        self._assembly.remove(residue.atoms())
        self._stubs.append(describeResidue(residue))
        return addressOf(chain[place])

    def _hasHydrogens(self, residue):
        if self._hydrogens is not None:
            return self._hydrogens
        elements = [atom.element.symbol for atom in residue.chain.atoms() if atom.element is not None]
        count = elements.count("H")
        return count > _HYDROGENS * (len(elements) - count)

    def _endOf(self, residue):
        return ChainEnd(residue, self._neighbors, self._positions)

    def buildTail(self, gap):
        """Build residues before the first or behind the last residue of a chain."""
        self.hasBuilt = True
        if gap.before is None:
            residue = self._residues[gap.after]
            end = self._endOf(residue)
            hydrogens = self._hasHydrogens(residue)
            built, _ = buildBackward(gap.names, self._draws, hydrogens, end.jointForPrevious(), residue.name)
            self._join(end, built, hydrogens)
            self._assembly.insertBefore(residue, built, False)
        else:
            residue = self._residues[gap.before]
            end = self._endOf(residue)
            self._remove(residue, end.surplusBeforeNext())
            built, _ = buildForward(gap.names, self._draws, self._hasHydrogens(residue), end.jointForNext())
            self._assembly.insertBehind(residue, built)
        self._tails.append(self.describe(gap))

    def closeGap(self, gap):
        """Build the residues of a gap whose sides stay, if there are enough; return whether it was closed."""
        before, after = (self._residues[end] for end in (gap.before, gap.after))
        left, right = self._endOf(before), self._endOf(after)
        jointBefore, jointAfter = left.jointForNext(), right.jointForPrevious()
        distance = np.linalg.norm(jointBefore.c - jointAfter.n)
        if len(gap.names) < FEWEST or distance > _REACH * (len(gap.names) + 1):
            return False
        hydrogens = self._hasHydrogens(before)
        beside = {atom.index for residue in (before, after) for atom in residue.atoms()}
        others = [atom.index for atom in self._atoms if atom.index not in beside]
        near = self._positions[others]
        near = near[np.linalg.norm(near - jointBefore.c, axis=1) < _REACH * (len(gap.names) + 2)]
        built = closeGap(gap.names, self._draws, hydrogens, jointBefore, jointAfter, after.name, near)
        self._remove(before, left.surplusBeforeNext())
        self._join(right, built, hydrogens)
        self._assembly.insertBefore(after, built, True)
        self._closed.append(self.describe(gap))
        self.hasBuilt = True
        return True

    def buildLinkers(self, gaps):
        """Build the linkers of one chain outwards from its largest domain; the other domains move with them."""
        self.hasBuilt = True
        domains = self._domainsOf(gaps)
        largest = max(range(len(domains)), key=lambda number: len(domains[number]))
        self._fixed = domains[largest][0]
        for number in range(largest, len(gaps)):
            self._buildLinker(gaps[number], domains[number + 1], True)
        for number in range(largest - 1, -1, -1):
            self._buildLinker(gaps[number], domains[number], False)

    def _domainsOf(self, gaps):
        """Return the domains of a chain: lists of residues between its gaps."""
        domains, starts = [[]], {self._residues[gap.after] for gap in gaps}
        for residue in filter(isPolymer, self._residues[gaps[0].before].chain.residues()):
            if residue in starts:
                domains.append([])
            domains[-1].append(residue)
        return domains

    def _buildLinker(self, gap, domain, isForward):
        """Build residues of a gap, and put the domain behind it, or before it, to their other end."""
        before, after = (self._residues[end] for end in (gap.before, gap.after))
        left, right = self._endOf(before), self._endOf(after)
        hydrogens = self._hasHydrogens(before)
        left1, right1 = left.jointForNext(), right.jointForPrevious()
        left1 = left1 if left1.torsion is not None else left1._replace(torsion=self._draws.backbone(before.name)[1])
        right1 = right1 if right1.torsion is not None else right1._replace(torsion=self._draws.backbone(after.name)[0])
        if isForward:
            built, joint = buildForward(gap.names, self._draws, hydrogens, left1, after.name)
            self._move(domain, right.backbone, backboneBehind(joint, right1.torsion))
        else:
            built, joint = buildBackward(gap.names, self._draws, hydrogens, right1, after.name, True)
            reverse = backboneBefore(joint, left1.torsion)[::-1]
            self._move(domain, left.backbone[::-1], reverse)
        self._remove(before, left.surplusBeforeNext())
        self._join(self._endOf(after), built, hydrogens)
        self._assembly.insertBefore(after, built, True)
        self._linkers.append(
            f"{self.describe(gap)}: {describeResidue(domain[0])} … {describeResidue(domain[-1])} moves"
        )

    def _move(self, domain, own, target):
        """Move a domain, with all that is bonded to it, so that three atoms come to their targets."""
        parts = connectedParts(len(self._atoms), self._bonds)
        inDomain = np.isin(parts, [parts[atom.index] for residue in domain for atom in residue.atoms()])
        if any(inDomain[atom.index] for atom in self._fixed.atoms()):
            raise InputError(
                f"{describeResidue(domain[0])} … {describeResidue(domain[-1])} cannot move: a bond holds it to the "
                "part of its chain that stays"
            )
        arms = self._positions[inDomain] - own[0]
        self._positions[inDomain] = target[0] + arms @ axesOf(*own) @ axesOf(*target).T
        self._moved |= inDomain

    def _join(self, end, built, hydrogens):
        """Remove the hydrogens of a free end, and add the one that N has behind the built residues."""
        surplus, needsHydrogen = end.surplusBehindPrevious()
        self._remove(end.residue, surplus)
        if surplus and needsHydrogen and hydrogens:
            n, ca, _ = end.backbone
            self._assembly.addHydrogen(end.residue, "H", "N", amideHydrogen(built[-1].at("C"), n, ca))

    def _remove(self, residue, atoms):
        self._assembly.remove(atoms)
        if atoms:
            self._taken.append(f"{describeResidue(residue)} {', '.join(atom.name for atom in atoms)}")

    def notes(self):
        """Return the Notes on what was built, and what was not."""
        return found(
            [
                Note("tails built", self._tails),
                Note("linkers built, with domains that move", self._linkers),
                Note("gaps closed", self._closed),
                Note("residues without N, CA or C, left out and built again", self._stubs),
                Note("atoms of free ends left out beside built residues", self._taken),
                Note("gaps that stay open, since both sides stay in place", self.open),
                Note("missing nucleotides that are not built", self._strange),
            ]
        )

    def finish(self):
        """Return the Built."""
        structure, sources, parts = self._assembly.finish(self._positions)
        isBuilt = sources < 0
        return Built(structure, parts, isBuilt, ~isBuilt & self._moved[sources])
