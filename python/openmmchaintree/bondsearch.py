"""Finding the bonds of a Topology: its own, by residue templates, and by distance."""

from collections import defaultdict
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from openmm.app import Residue

from .covalent import (
    areAnglesOfBonds,
    bindsMetals,
    bondedPairs,
    bondsBetweenParts,
    canBond,
    isLooseMetal,
    isMetal,
    longestBonds,
    nearPairs,
    shortestBonds,
)
from .graphs import connectedParts, neighborLists
from .images import boxOf, makeWhole, nearestImage
from .naming import describeResidue, nameAtom
from .notes import Note, found
from .pseudoatoms import atomicNumbers
from .residues import CAPS, aminoAcid, isAlphaCarbonOnly, isNucleotide, isWater
from .templates import isStandard, standardName, templateBonds
from .units import checkBondLengths

GAPS = "gaps in the chain"  # the kind of a Note

# A bond between residues of a polymer that is longer than this (nm) spans missing residues.
LONGEST_LINK = 0.4

# Up to this distance (nm) residues are linked whatever their numbers.
_LONGEST_CERTAIN_LINK = 0.2

# Bonded atoms farther apart than this (nm) are on two sides of a periodic box.
LONGEST_BOND = 0.8

_COINCIDING = 0.001

_LONGEST_DISULFIDE = 0.3

# Atoms farther apart than LONGEST_LINK are bonded across the periodic box only up to this distance (nm).
_LONGEST_ACROSS_THE_BOX = 0.25

# The atoms that join a residue to the next one: peptides, nucleic acids.
LINKS = (("C", "N"), ("O3'", "P"))

# The backbone atoms that these are bonded to.
_BACKBONE = {"C": "CA", "N": "CA", "O3'": "C3'", "P": "O5'"}

# If a bond of the template is this factor longer than bonds are, the residue's name means something else. For bonds of
# hydrogens the factor is 1: hydrogens are then bonded to near atoms.
_LOOSE_FIT = 1.5

_HYDROGEN, _SULFUR = 1, 16


class Gap(NamedTuple):
    """Two residues, next to each other in a chain, that are not bonded."""

    residue1: Residue
    residue2: Residue
    reason: str


class BondSearch:
    """Finds the bonds of a Topology.

    Residues whose atoms are not connected by the Topology's bonds get the bonds of their template, and atoms that are
    still loose are bonded by distance. Neighbors in a chain are linked if their ends are near. The last bonds follow
    from distances: links elsewhere, as of cyclic peptides; disulfides; bonds of metals; and bonds of residues that are
    neither amino acids nor nucleotides, also within such a residue if it has no template. Water has no other bonds.
    Atoms nearer than bonds are long clash.

    Attributes
    ----------
    atoms : list of openmm.app.Atom
    bonds : list of (int, int)
        lower index first, sorted
    disulfides, metalBonds : list of (int, int)
        the bonds between residues that join two sulfurs, or that a metal has
    gaps : list of Gap
    positions : (n, 3) float64 array or None
        nm, with molecules made whole that are split over the periodic box
    overlong : list of (int, int)
        bonds longer than 0.8 nm, as of a molecule split over a periodic box
    coinciding : list of (int, int)
        bonds whose atoms are at the same place
    hasBox : bool
        whether the Topology has a periodic box
    numbers : (n,) int array
        atomic numbers, 0 for extra particles, pseudo-atoms and beads
    residueOf : (n,) int array
        the index of the residue of each atom
    hasTemplate : (n,) bool array
        whether the residue of each atom has a template, so that its bonds are known
    notes : list of Note
    """

    def __init__(self, topology, positions=None, others=(), beads=()):
        """Find the bonds; by distance only with positions, an (n, 3) float64 array in nm. O(n log n).

        others : iterable of (int, int), bonds that the Topology lacks, lower index first
        beads : set of int, atoms whose element counts for nothing; `others` has all bonds between them

        Raises
        ------
        InputError
            if bonds are ten times too long or too short
        """
        self.atoms = list(topology.atoms())
        self._residues = list(topology.residues())
        self._chains = [list(chain.residues()) for chain in topology.chains()]
        self.residueOf = np.array([atom.residue.index for atom in self.atoms], dtype=int)
        self.numbers = atomicNumbers(self.atoms)
        self._beads = beads
        self.numbers[list(beads)] = 0
        self._box = boxOf(topology) if positions is not None else None
        self.hasBox = self._box is not None
        self.positions = positions
        self.gaps = []
        self.disulfides = []
        self.metalBonds = []
        self.notes = []
        self._bonds = dict.fromkeys(others)
        self._tooLong = []
        self._byDistance = []
        self._isFitted = np.array([isStandard(standardName(residue.name)) for residue in self._residues])
        self._addOwnBonds(topology)
        self._completeResidues()
        self._linkResidues()
        if positions is not None:
            if self._box is not None:
                self.positions = makeWhole(self.positions, list(self._bonds), self._box)
            self._bondNearAtoms()
            self._linkFarResidues()
        self._findGaps()
        self.bonds = sorted(self._bonds)
        self.hasTemplate = self._isFitted[self.residueOf]
        self._classify()
        self._noteWhatWasFound()

    # ---- Bonds of the Topology ----

    def _addOwnBonds(self, topology):
        for bond in topology.bonds():
            pair = _sorted(bond[0].index, bond[1].index)
            if pair in self._bonds:  # files may list a bond more than once
                continue
            if pair[0] in self._beads and pair[1] in self._beads:
                continue
            if self.residueOf[pair[0]] != self.residueOf[pair[1]] and self._distance(pair) > LONGEST_LINK:
                if self._isLink(pair):
                    atoms = [self.atoms[atom] for atom in pair]
                    names = f"{atoms[0].name} and {atoms[1].name}, bonded in the Topology,"
                    self._addGap(*(atom.residue for atom in atoms), f"{names} are {self._distance(pair):.2f} nm apart")
                    continue
                if (self.numbers[list(pair)] > 0).all():  # beads may be far apart
                    self._tooLong.append(pair)
                    continue
            self._bonds[pair] = None

    def _addGap(self, residue1, residue2, reason):
        self.gaps.append(Gap(*sorted((residue1, residue2), key=lambda residue: residue.index), reason))

    # ---- Within residues ----

    def _completeResidues(self):
        known, templates = {}, []
        for residue in self._looseResidues():
            names = tuple(atom.name for atom in residue.atoms())
            if (residue.name, names) not in known:
                known[residue.name, names] = templateBonds(residue.name, names)
            first = next(residue.atoms()).index
            bonds = [_sorted(first + atom1, first + atom2) for atom1, atom2 in known[residue.name, names]]
            templates.append((residue, bonds))
        misfits = self._takeTemplates(templates)
        if self.positions is None:
            return
        self._checkLengths()
        loose = self._looseResidues()
        bonds = defaultdict(list)
        for pair in self._bondsWithin().tolist() if loose else ():
            bonds[self.residueOf[pair[0]]].append(pair)
        for residue in loose:
            self._bondWithin(residue, bonds[residue.index])
        # The template may be that of another residue. But if distances show no bonds either, the residue is split.
        stillLoose = set(self._looseResidues()) if misfits else ()
        for residue, bonds in misfits:
            if residue in stillLoose:
                self._bonds.update(dict.fromkeys(bonds))

    def _takeTemplates(self, templates):
        """Add the possible bonds of templates; return the others, as pairs of a residue and its bonds."""
        pairs = np.array([pair for _, bonds in templates for pair in bonds], dtype=int).reshape(-1, 2)
        fits = np.ones(len(pairs), dtype=bool)
        if self.positions is not None:
            longest = longestBonds(self.numbers[pairs[:, 0]], self.numbers[pairs[:, 1]])
            hasHydrogen = (self.numbers[pairs] == _HYDROGEN).any(axis=1)
            fits = self._distances(pairs[:, 0], pairs[:, 1]) <= np.where(hasHydrogen, 1.0, _LOOSE_FIT) * longest
        misfits, start = [], 0
        for residue, bonds in templates:
            isFit = fits[start : start + len(bonds)]
            start += len(bonds)
            misfit = [] if isFit.all() else bonds
            if misfit and isStandard(residue.name):  # names of hydrogens differ between programs
                others = (pair for pair, isOne in zip(bonds, isFit, strict=True) if not isOne)
                misfit = [pair for pair in others if self._hasHydrogen(pair)]
            self._bonds.update(dict.fromkeys(pair for pair in bonds if pair not in misfit))
            if misfit:
                misfits.append((residue, misfit))
            elif bonds:
                self._isFitted[residue.index] = True
        return misfits

    def _hasHydrogen(self, pair):
        return _HYDROGEN in self.numbers[list(pair)]

    def _checkLengths(self):
        """Raise an InputError if the lengths of known bonds show that positions are in a wrong unit."""
        pairs = self._bondsWithin()
        pairs = pairs[(self.numbers[pairs] > 0).all(axis=1)]  # those of beads have any length
        checkBondLengths(np.linalg.norm(self.positions[pairs[:, 0]] - self.positions[pairs[:, 1]], axis=1))

    def _looseResidues(self):
        """Return the residues whose atoms, without extra particles, their bonds do not connect."""
        atoms = np.flatnonzero(self.numbers > 0)
        part = connectedParts(len(self.atoms), self._bondsWithin())[atoms]
        first = np.full(len(self._residues), -1)
        first[self.residueOf[atoms][::-1]] = part[::-1]
        loose = np.unique(self.residueOf[atoms][part != first[self.residueOf[atoms]]])
        return [self._residues[residue] for residue in loose]

    def _bondsWithin(self):
        """Return the bonds within residues, as an (m, 2) array."""
        pairs = np.array(list(self._bonds), dtype=int).reshape(-1, 2)
        return pairs[self.residueOf[pairs[:, 0]] == self.residueOf[pairs[:, 1]]]

    def _bondWithin(self, residue, known):
        """Bond the parts of a residue that its bonds do not connect, by distance."""
        atoms = np.array([atom.index for atom in residue.atoms() if self.numbers[atom.index] > 0])
        place = {atom: number for number, atom in enumerate(atoms.tolist())}
        positions = self.positions[atoms]
        if self._box is not None:
            positions = positions[0] + nearestImage(positions - positions[0], self._box)
        bonds = [(place[first], place[second]) for first, second in known]
        for first, second in bondsBetweenParts(positions, self.numbers[atoms], bonds):
            self._bonds[_sorted(*atoms[[first, second]].tolist())] = None

    # ---- Along chains ----

    def _linkResidues(self):
        for residue1, residue2 in self._unlinkedNeighbors():
            if isWater(residue1) or isWater(residue2):
                continue
            # If OpenMM knows both residues and did not link them, only positions can prove a link.
            if self.positions is None and (
                not _areConsecutive(residue1, residue2) or all(map(isStandard, (residue1.name, residue2.name)))
            ):
                continue
            for ends in self._facingEnds(residue1, residue2):
                if self._distance(ends) <= _LONGEST_CERTAIN_LINK:
                    self._bonds[_sorted(*ends)] = None

    def _linkFarResidues(self):
        """Link consecutive residues at a distance longer than links are, if neither end has another link."""
        linked = self._linkedAtoms()
        for residue1, residue2 in self._unlinkedNeighbors():
            for ends in self._facingEnds(residue1, residue2) if _areConsecutive(residue1, residue2) else ():
                if self._distance(ends) <= LONGEST_LINK and linked.isdisjoint(ends):
                    self._bonds[_sorted(*ends)] = None

    def _linkedAtoms(self):
        return {atom for pair in self._links() for atom in pair}

    def _links(self):
        """Return the bonds that link residues of polymers."""
        return [pair for pair in self._bonds if not self._areOneResidue(pair) and self._isLink(pair)]

    def _findGaps(self):
        """Note polymer residues that follow each other in a chain and are not linked."""
        known = {(gap.residue1.index, gap.residue2.index) for gap in self.gaps}
        linked = self._linkedAtoms()
        for residue1, residue2 in self._unlinkedNeighbors():
            if not _areOnePolymer(residue1, residue2) or (residue1.index, residue2.index) in known:
                continue
            if isAlphaCarbonOnly(residue1) or isAlphaCarbonOnly(residue2):
                continue
            if any(atom.index in self._beads for residue in (residue1, residue2) for atom in residue.atoms()):
                continue
            ends = next(iter(self._facingEnds(residue1, residue2)), ())
            if any(end in linked for end in ends):  # with a residue elsewhere in the file
                continue
            reason = "the Topology has no bond between them"
            if self.positions is not None and ends:
                names = " and ".join(self.atoms[end].name for end in ends)
                reason = f"{names} are {self._distance(ends):.2f} nm apart"
            self._addGap(residue1, residue2, reason)

    def _unlinkedNeighbors(self):
        """Return the pairs of residues that follow each other in a chain and are not linked."""
        linked = {_sorted(*self.residueOf[list(pair)].tolist()) for pair in self._links()}
        pairs = (pair for chain in self._chains for pair in pairwise(chain))
        return [pair for pair in pairs if (pair[0].index, pair[1].index) not in linked]

    def _facingEnds(self, residue1, residue2):
        """Return the atoms that can link two residues, as a list of at most one pair."""
        for name1, name2 in LINKS:
            ends = _atomNamed(name1, residue1), _atomNamed(name2, residue2)
            if None not in ends and self._isEndOfPolymer(ends[0], name1) and self._isEndOfPolymer(ends[1], name2):
                return [ends]
        return []

    def _isEndOfPolymer(self, atom, name):
        """Whether an atom named as the end of a link is one: it is bonded to a polymer's backbone."""
        residue = self.atoms[atom].residue
        if residue.name in CAPS:
            return True
        before = _atomNamed(_BACKBONE[name], residue)
        if before is None:
            return _isPolymer(residue)
        return _sorted(atom, before) in self._bonds

    def _isLink(self, pair):
        name1, name2 = (self.atoms[atom].name for atom in pair)
        return (name1, name2) in LINKS or (name2, name1) in LINKS

    # ---- By distance between residues ----

    def _bondNearAtoms(self):
        positions, numbers, residueOf = self.positions, self.numbers, self.residueOf
        hasOther = np.zeros(len(self.atoms), dtype=bool)  # bonds to another residue
        neighbors = neighborLists(len(self.atoms), self._bonds)
        pairs = np.array(list(self._bonds), dtype=int).reshape(-1, 2)
        hasOther[pairs[residueOf[pairs[:, 0]] != residueOf[pairs[:, 1]]]] = True
        bound = np.array([not isWater(residue) for residue in self._residues])[residueOf]
        sulfurs = np.flatnonzero((numbers == _SULFUR) & bound & ~hasOther)
        nearSulfurs = sulfurs[nearPairs(positions[sulfurs], _LONGEST_DISULFIDE)]
        near = np.concatenate([bondedPairs(positions, numbers), nearSulfurs])
        first, second = near.T
        lengths = np.linalg.norm(positions[first] - positions[second], axis=1)
        shortest = shortestBonds(numbers[first], numbers[second], residueOf[first] != residueOf[second])
        order = np.argsort(lengths, kind="stable")
        for first, second in near[order[(lengths >= shortest)[order]]].tolist():
            pair = _sorted(first, second)
            if pair in self._bonds or not (bound[first] and bound[second]):
                continue
            if any(numbers[atom] == _HYDROGEN and neighbors[atom] for atom in pair):
                continue
            if self._isBond(pair, hasOther, neighbors):
                self._bonds[pair] = None
                self._byDistance.append(pair)
                if not isMetal(numbers[list(pair)]).any():
                    neighbors[first].append(second)
                    neighbors[second].append(first)

    def _isBond(self, pair, hasOther, neighbors):
        """Whether two near atoms are bonded, by their elements, residues and other bonds."""
        numbers = self.numbers[list(pair)]
        metals = isMetal(numbers)
        if metals.any():
            return not metals.all() and bool(bindsMetals(numbers[~metals]).all()) and not isLooseMetal(numbers).any()
        if self._areOneResidue(pair):
            if self._isFitted[self.residueOf[pair[0]]]:
                return False
            return set(neighbors[pair[0]]).isdisjoint(neighbors[pair[1]]) and self._lieAsBonds(pair, neighbors)
        if self._isLink(pair):
            return not hasOther[list(pair)].any()
        if (numbers == _SULFUR).all():
            return all(self._isThiol(atom, neighbors[atom]) for atom in pair)
        residues = [self.atoms[atom].residue for atom in pair]
        if all(map(_isPolymer, residues)) or not canBond(numbers, [len(neighbors[atom]) for atom in pair]):
            return False
        # Clashing atoms can be as near, but rarely at the angles of bonds. Single atoms are ions, or marks of programs.
        return all(len(residue) > 1 for residue in residues) and self._lieAsBonds(pair, neighbors)

    def _isThiol(self, atom, neighbors):
        """Whether a sulfur can form a disulfide: it has at most one bond, and none to a hydrogen."""
        if aminoAcid(self.atoms[atom].residue.name) is not None and self.atoms[atom].name != "SG":
            return False  # of methionine, which may lack an atom
        return len(neighbors) < 2 and not any(self.numbers[other] == _HYDROGEN for other in neighbors)

    def _lieAsBonds(self, pair, neighbors):
        return all(areAnglesOfBonds(self.positions, atom, other, neighbors[atom]) for atom, other in (pair, pair[::-1]))

    # ---- Results ----

    def _classify(self):
        pairs = np.array(self.bonds, dtype=int).reshape(-1, 2)
        numbers = self.numbers[pairs]
        areOther = self.residueOf[pairs[:, 0]] != self.residueOf[pairs[:, 1]]
        areSulfurs = areOther & (numbers == _SULFUR).all(axis=1)
        areMetals = areOther & isMetal(numbers).any(axis=1)
        self.disulfides = [tuple(pair) for pair in pairs[areSulfurs].tolist()]
        self.metalBonds = [tuple(pair) for pair in pairs[areMetals].tolist()]
        if self.positions is None:
            self.overlong = self.coinciding = []
            return
        lengths = np.linalg.norm(self.positions[pairs[:, 0]] - self.positions[pairs[:, 1]], axis=1)
        self.coinciding = [tuple(pair) for pair in pairs[lengths < _COINCIDING].tolist()]
        areLong = (lengths > LONGEST_BOND) & (numbers > 0).all(axis=1)
        self.overlong = [tuple(pair) for pair in pairs[areLong].tolist()]

    def _noteWhatWasFound(self):
        gaps = [
            f"between {describeResidue(gap.residue1)} and {describeResidue(gap.residue2)}, {gap.reason}"
            for gap in self.gaps
        ]
        disulfides, metals = set(self.disulfides), set(self.metalBonds)
        others = [pair for pair in self._byDistance if pair not in disulfides and pair not in metals]
        self.notes = found(
            [
                Note(GAPS, gaps),
                Note(
                    "disulfides found by distance", map(self.describePair, sorted(disulfides & set(self._byDistance)))
                ),
                Note(
                    "bonds of metals found by distance", map(self.describePair, sorted(metals & set(self._byDistance)))
                ),
                Note("other bonds found by distance", map(self.describePair, others)),
                Note("bonds of the file that are too long, and left out", map(self.describePair, self._tooLong)),
            ]
        )

    def describePair(self, pair):
        """Return two atoms and their distance in words."""
        names = " – ".join(str(nameAtom(self.atoms[atom])) for atom in pair)
        return f"{names}, {self._distance(pair):.3f} nm"

    def _areOneResidue(self, pair):
        return self.residueOf[pair[0]] == self.residueOf[pair[1]]

    def _distance(self, pair):
        return float(self._distances(*pair))

    def _distances(self, atoms1, atoms2):
        """Return distances (nm) between atoms; to the nearest image if only that image can be bonded."""
        if self.positions is None:
            return np.zeros(np.shape(atoms1))
        vectors = self.positions[atoms2] - self.positions[atoms1]
        distances = np.linalg.norm(vectors, axis=-1)
        if self._box is None:
            return distances
        images = np.linalg.norm(nearestImage(vectors, self._box), axis=-1)
        return np.where((distances > LONGEST_LINK) & (images <= _LONGEST_ACROSS_THE_BOX), images, distances)


def _atomNamed(name, residue):
    return next((atom.index for atom in residue.atoms() if atom.name == name), None)


def _isPolymer(residue):
    return aminoAcid(residue.name) is not None or isNucleotide(residue.name)


def _areOnePolymer(residue1, residue2):
    names = residue1.name, residue2.name
    return all(map(aminoAcid, names)) or all(map(isNucleotide, names))


def _areConsecutive(residue1, residue2):
    try:
        difference = int(residue2.id) - int(residue1.id)
    except ValueError:
        return True
    return difference == 1 or (difference == 0 and residue1.insertionCode != residue2.insertionCode)


def _sorted(first, second):
    return (first, second) if first < second else (second, first)
