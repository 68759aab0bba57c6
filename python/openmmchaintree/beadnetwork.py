"""The bonds of beads in a System: bonds about which chains turn, rigid parts, and bonds that close rings."""

from collections import Counter
from itertools import pairwise

import numpy as np

from .covalent import WIDE, longestBonds
from .graphs import connectedParts, growTrees, neighborLists
from .pseudoatoms import atomicNumbers
from .systemreading import customBondsOf, fixedParticles, harmonicCustomBondsOf

# Bonds of beads are longer (nm): those of atoms are shorter, apart from a few between heavy elements.
_LONGEST_BOND_OF_ATOMS = 0.25


class BeadNetwork:
    """The bonds of beads: of particles whose bonds are all longer than covalent bonds.

    Parts in which bonds hold all beads relative to each other are rigid, such as the elastic network of a domain: from
    three beads bonded to each other, a part grows by beads that have three bonds to it. Fixed beads are one part.

    Attributes
    ----------
    beads : set of int
    bonds : list of (int, int), lower index first
        bonds whose length is kept, without those of `loose`
    joints : list of (int, int)
        the bonds between parts: each turns about its first bead, which is nearer to a fixed bead, else to the first
    parts : list of list of int
        the rigid parts of beads that can move, sorted
    springs : list of (int, int)
        the bonds of HarmonicBondForces among `bonds`
    loose : list of (int, int)
        bonds whose length is not kept, since they would close a ring of joints, or since they join two chains of beads
        and are not in the Topology: only their energies hold them
    """

    def __init__(self, topology, system, bonds, positions=None):
        """Find the beads of a System.

        bonds : its bonds, as `bondsOf` returns them
        positions : (n, 3) array, nm, for lengths that the System does not name
        """
        atoms = list(topology.atoms())
        self._numbers = atomicNumbers(atoms)
        self._chainOf = [atom.residue.chain.index for atom in atoms]
        self._listed = {tuple(sorted((bond[0].index, bond[1].index))) for bond in topology.bonds()}
        self._count = len(self._numbers)
        self._positions = positions
        springs, lengths = self._lengths(system, bonds)
        self.beads, known = self._beadsOf(lengths)
        fixed = self.beads.intersection(fixedParticles(system).tolist())
        held = {pair for pair in harmonicCustomBondsOf(system) if self.beads.issuperset(pair)}
        self.parts = _rigidParts(known | held)
        self._divide(known, held, fixed)
        self.springs = [pair for pair in self.bonds if pair in springs]

    def _lengths(self, system, bonds):
        """Return the harmonic bonds, and the length (nm) of each bond, None if it is unknown."""
        springs, lengths = set(), {}
        for first, second, length, isHarmonic in bonds:
            pair = min(first, second), max(first, second)
            lengths[pair] = min(length, lengths.get(pair, length))
            if isHarmonic:
                springs.add(pair)
        bonded = {particle for pair in self._listed.union(lengths) for particle in pair}
        for pair in self._listed:
            lengths.setdefault(pair, self._distance(pair))
        for pair in customBondsOf(system):
            if not bonded.issuperset(pair):
                lengths[min(pair), max(pair)] = self._distance(pair, np.inf)  # atoms have other bonds
        return springs, lengths

    def _distance(self, pair, unknown=None):
        if self._positions is None:
            return unknown
        return float(np.linalg.norm(self._positions[pair[0]] - self._positions[pair[1]]))

    def _beadsOf(self, lengths):
        """Return the beads and the bonds between them, as sets."""
        pairs = np.array(list(lengths), dtype=int).reshape(-1, 2)
        numbers = self._numbers[pairs].T
        longest = np.maximum(longestBonds(*numbers, WIDE), _LONGEST_BOND_OF_ATOMS)
        unknown = np.where((numbers == 0).all(axis=0), np.inf, 0.0)  # without elements: of beads
        given = np.array([np.nan if length is None else length for length in lengths.values()], dtype=float)
        areLong = np.where(np.isnan(given), unknown, given) > longest
        beads = set(pairs[areLong].ravel().tolist()).difference(pairs[~areLong].ravel().tolist())
        return beads, {tuple(pair) for pair in pairs[areLong].tolist() if beads.issuperset(pair)}

    def _divide(self, known, held, fixed):
        """Divide the bonds into those within parts, joints between parts, and bonds that close rings of joints."""
        partOf = connectedParts(self._count, [pair for part in [*self.parts, sorted(fixed)] for pair in pairwise(part)])
        within = [pair for pair in known | held if partOf[pair[0]] == partOf[pair[1]]]
        between = known.difference(within)
        ofChains = {bead for pair in known if self._areOneChain(pair) for bead in pair}
        kept = [pair for pair in between if self._areOneChain(pair) or not ofChains.issuperset(pair)]
        inOrder = sorted(kept, key=lambda pair: (pair[1] - pair[0], pair))
        ends = partOf[np.array(inOrder, dtype=int).reshape(-1, 2)]
        turning = {inOrder[index] for index in _spanningForest(ends.tolist())}
        self.loose = sorted(between - turning)
        self.bonds = sorted([*within, *turning])
        self.parts = [part for part in self.parts if fixed.isdisjoint(part)]
        trees = growTrees(neighborLists(self._count, self.bonds), [*sorted(fixed), *range(self._count)])
        self.joints = sorted(
            (parent, bead) for bead, parent in trees if (min(bead, parent), max(bead, parent)) in turning
        )

    def _areOneChain(self, pair):
        return self._chainOf[pair[0]] == self._chainOf[pair[1]] or pair in self._listed


def _rigidParts(bonds):
    """Return the parts that bonds make rigid, sorted lists of at least four beads that have no bead in common."""
    neighbors = {}
    for first, second in bonds:
        neighbors.setdefault(first, set()).add(second)
        neighbors.setdefault(second, set()).add(first)
    partOf, unions = {}, []
    for first, second in sorted(bonds):
        for third in sorted(neighbors[first] & neighbors[second]):
            seed = (first, second, third)
            if None not in (known := {partOf.get(bead) for bead in seed}) and len(known) == 1:
                continue
            part = sorted(_growPart(seed, neighbors))
            if len(part) > len(seed):
                unions += pairwise(part)
                partOf.update(dict.fromkeys(part, len(unions)))
    beads = sorted({bead for pair in unions for bead in pair})
    place = {bead: index for index, bead in enumerate(beads)}
    labels = connectedParts(len(beads), [(place[first], place[second]) for first, second in unions])
    parts = {}
    for bead, label in zip(beads, labels.tolist(), strict=True):
        parts.setdefault(label, []).append(bead)
    return list(parts.values())


def _growPart(seed, neighbors):
    """Return a set of beads: the seed, and repeatedly each bead that has three bonds to the set."""
    part, pending, counts = set(seed), list(seed), Counter()
    while pending:
        for bead in neighbors[pending.pop()] - part:
            counts[bead] += 1
            if counts[bead] == 3:
                part.add(bead)
                pending.append(bead)
    return part


def _spanningForest(edges):
    """Return the indices of the edges of a spanning forest, the first that close no ring."""
    root = {}

    def find(node):
        while root.setdefault(node, node) != node:
            root[node] = root[root[node]]
            node = root[node]
        return node

    chosen = []
    for index, (first, second) in enumerate(edges):
        first, second = find(first), find(second)
        if first != second:
            root[first] = second
            chosen.append(index)
    return chosen
