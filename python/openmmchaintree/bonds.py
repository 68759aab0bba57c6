"""The bonds of a Topology as a graph: without chain gaps and, on request, without disulfides; and its rings."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from openmm.app import Residue

from .residues import aminoAcid, isNucleotide

# A bond between residues of a polymer that is longer than this (nm) spans missing residues.
LONGEST_LINK = 0.4

# Atoms of residues that the Topology gives no bonds are bonded if nearer than this (nm): to hydrogen, among elements up
# to neon, and to heavier ones. Atoms two bonds apart are farther.
_LONGEST_BONDS = (0.125, 0.19, 0.23)

# The atoms that join a residue to the next one: peptides, nucleic acids.
LINKS = (("C", "N"), ("O3'", "P"))


class Gap(NamedTuple):
    """Two residues, next to each other in a chain, that are not bonded."""

    residue1: Residue
    residue2: Residue
    reason: str


class BondGraph:
    """The atoms of a Topology and the bonds that keep them together.

    Attributes
    ----------
    atoms : list of openmm.app.Atom
    bonds : list of (int, int)
        the bonds that count: no gaps, no cut disulfides
    neighbors : list of list of int
        for each atom the atoms bonded to it by `bonds`
    gaps : list of Gap
    disulfides : list of (int, int)
        the bonds between sulfurs of different residues, cut or not
    """

    def __init__(self, topology, positions=None, cutDisulfides=False):
        """Read the bonds of a Topology.

        Parameters
        ----------
        topology : openmm.app.Topology
        positions : numpy array of shape (n, 3), optional
            nm; with them, bonds between residues are checked for gaps
        cutDisulfides : bool
            leave disulfide bonds out of `bonds`
        """
        self.atoms = list(topology.atoms())
        self.gaps = []
        self.disulfides = []
        self.bonds = []
        links = set()
        for pair in _distinctBonds(topology):
            atom1, atom2 = (self.atoms[index] for index in pair)
            if atom1.residue is not atom2.residue:
                if _isLink(atom1, atom2):
                    links.add(frozenset((atom1.residue.index, atom2.residue.index)))
                    if self._isGap(atom1, atom2, positions):
                        continue
                elif _isSulfur(atom1) and _isSulfur(atom2):
                    self.disulfides.append(pair)
                    if cutDisulfides:
                        continue
            self.bonds.append(pair)
        if positions is not None:
            self._bondNearAtoms(topology, positions)
        self._findUnbondedNeighbors(topology, links)
        self.neighbors = neighborLists(len(self.atoms), self.bonds)

    def _isGap(self, atom1, atom2, positions):
        if positions is None:
            return False
        distance = np.linalg.norm(positions[atom1.index] - positions[atom2.index])
        if distance <= LONGEST_LINK:
            return False
        residue1, residue2 = sorted((atom1.residue, atom2.residue), key=lambda residue: residue.index)
        reason = f"{atom1.name} and {atom2.name}, bonded in the Topology, are {distance:.2f} nm apart"
        self.gaps.append(Gap(residue1, residue2, reason))
        return True

    def _bondNearAtoms(self, topology, positions):
        """Bond atoms by distance in residues without any bond: unknown ones, heterogens without CONECT records."""
        bonded = {atom for bond in topology.bonds() for atom in bond}
        for chain in topology.chains():
            before = []
            for residue in chain.residues():
                atoms = list(residue.atoms())
                if len(atoms) < 2 or any(atom in bonded for atom in atoms):
                    before = []
                    continue
                for number, atom1 in enumerate(atoms):
                    for atom2 in before + atoms[:number]:
                        if _areNear(atom1, atom2, positions):
                            self.bonds.append((atom2.index, atom1.index))
                before = atoms

    def _findUnbondedNeighbors(self, topology, links):
        """Note polymer residues that follow each other in a chain without a bond in the Topology."""
        for chain in topology.chains():
            for residue1, residue2 in pairwise(chain.residues()):
                samePolymer = (aminoAcid(residue1.name) and aminoAcid(residue2.name)) or (
                    isNucleotide(residue1.name) and isNucleotide(residue2.name)
                )
                if samePolymer and frozenset((residue1.index, residue2.index)) not in links:
                    self.gaps.append(Gap(residue1, residue2, "the Topology has no bond between them"))

    def elementNumber(self, atom):
        """Return the atomic number of an atom, 0 for an extra particle."""
        element = self.atoms[atom].element
        return 0 if element is None else element.atomic_number

    def hydrogensOf(self, atom):
        """Return the hydrogens bonded to an atom."""
        return [other for other in self.neighbors[atom] if self.elementNumber(other) == 1]

    def heavyNeighborsOf(self, atom):
        """Return the atoms other than hydrogens bonded to an atom."""
        return [other for other in self.neighbors[atom] if self.elementNumber(other) > 1]


def _distinctBonds(topology):
    """Return the bonds of a Topology as pairs of indices, once each: mmCIF files may tell a bond more than once."""
    bonds = {}
    for atom1, atom2 in topology.bonds():
        bonds.setdefault(frozenset((atom1.index, atom2.index)), (atom1.index, atom2.index))
    return list(bonds.values())


def neighborLists(count, bonds):
    """Return, for each of count atoms, the list of atoms bonded to it."""
    neighbors = [[] for _ in range(count)]
    for atom1, atom2 in bonds:
        neighbors[atom1].append(atom2)
        neighbors[atom2].append(atom1)
    return neighbors


def ringBonds(neighbors):
    """Return the bonds that lie in a ring, as a set of (lower, higher) index.

    Depth-first: a tree edge is in no ring if nothing below it reaches above it. O(atoms + bonds).
    """
    count = len(neighbors)
    order = [-1] * count  # when an atom was first met
    reach = [0] * count  # the earliest atom that its subtree reaches by one ring-closing bond
    inRing = set()
    clock = 0
    for start in range(count):
        if order[start] >= 0:
            continue
        order[start] = reach[start] = clock
        clock += 1
        path = [(start, -1, iter(neighbors[start]))]
        while path:
            atom, parent, remaining = path[-1]
            for other in remaining:
                if order[other] < 0:
                    order[other] = reach[other] = clock
                    clock += 1
                    path.append((other, atom, iter(neighbors[other])))
                    break
                if other != parent:
                    reach[atom] = min(reach[atom], order[other])
                    inRing.add((min(atom, other), max(atom, other)))
            else:
                path.pop()
                if parent >= 0:
                    reach[parent] = min(reach[parent], reach[atom])
                    if reach[atom] <= order[parent]:
                        inRing.add((min(atom, parent), max(atom, parent)))
    return inRing


def molecules(neighbors):
    """Return the number of the molecule of each atom: connected atoms share one."""
    molecule = [-1] * len(neighbors)
    count = 0
    for start in range(len(neighbors)):
        if molecule[start] >= 0:
            continue
        molecule[start] = count
        pending = [start]
        while pending:
            for other in neighbors[pending.pop()]:
                if molecule[other] < 0:
                    molecule[other] = count
                    pending.append(other)
        count += 1
    return molecule


def _isLink(atom1, atom2):
    return (atom1.name, atom2.name) in LINKS or (atom2.name, atom1.name) in LINKS


def _isSulfur(atom):
    return atom.element is not None and atom.element.atomic_number == 16


def _areNear(atom1, atom2, positions):
    if atom1.element is None or atom2.element is None:
        return False
    numbers = sorted((atom1.element.atomic_number, atom2.element.atomic_number))
    if numbers == [1, 1]:
        return False
    longest = _LONGEST_BONDS[0 if numbers[0] == 1 else 1 if numbers[1] <= 10 else 2]
    return bool(np.linalg.norm(positions[atom1.index] - positions[atom2.index]) < longest)
