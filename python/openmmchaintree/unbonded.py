"""A last check for missing bonds: atoms a bond's length apart that no bond joins, and that torsions move apart."""

import numpy as np

from .covalent import WIDE, bondedPairs, isMetal, longestBonds, shortestBonds
from .links import rigidLinks
from .naming import nameAtom

# In residues without a template, missing bonds are suspected up to this factor times the sum of covalent radii: atoms
# two bonds apart are farther from each other.
_WIDEST = 1.45


class NearPair:
    """Two atoms of different links at covalent distance that are not bonded.

    atom1, atom2 : openmm.app.Atom; distance : float, nm
    """

    def __init__(self, atom1, atom2, distance):
        self.atom1 = atom1
        self.atom2 = atom2
        self.distance = distance

    def __str__(self):
        return f"{nameAtom(self.atom1)} – {nameAtom(self.atom2)}, {self.distance:.3f} nm"


def unbondedNeighbors(graph, axes, fixed=(), alternates=None):
    """Find atoms of different links that are at covalent distance and not bonded, the nearest pair first.

    Metals are skipped, since atoms around them need not be bound, and so are hydrogens that have a bond, and atoms with
    a common neighbor. In residues without a template, distances slightly too long for a bond count, too. Distances too
    short for a bond count only within a residue: elsewhere such atoms clash.

    Parameters
    ----------
    graph : BondGraph, with positions
    axes : iterable of (int, int)
        the bonds that turn
    fixed : sequence of int
        atoms that never move
    alternates : list of str, optional
        for each atom the label of its conformer, empty if the atom has one conformer; atoms of different labels never
        occur together

    Returns
    -------
    list of NearPair
    """
    pairs = _pairsAsBonds(graph)
    link = rigidLinks(graph, axes)
    if len(fixed) > 0:
        link[np.asarray(fixed)] = -1
    isBonded = np.array([len(others) > 0 for others in graph.neighbors], dtype=bool)
    isPassed = isMetal(graph.numbers) | ((graph.numbers == 1) & isBonded)
    first, second = pairs.T
    pairs = pairs[(link[first] != link[second]) & ~isPassed[first] & ~isPassed[second]]
    known = {(min(bond), max(bond)) for bond in [*graph.cut, *(closure[1:3] for closure in graph.closures)]}
    found = []
    for atom1, atom2 in pairs.tolist():
        neighbors1, neighbors2 = graph.neighbors[atom1], graph.neighbors[atom2]
        if atom2 in neighbors1 or (atom1, atom2) in known or not set(neighbors1).isdisjoint(neighbors2):
            continue
        if alternates and alternates[atom1] and alternates[atom2] and alternates[atom1] != alternates[atom2]:
            continue
        distance = float(np.linalg.norm(graph.positions[atom1] - graph.positions[atom2]))
        found.append(NearPair(graph.atoms[atom1], graph.atoms[atom2], distance))
    return sorted(found, key=lambda pair: pair.distance)


def _pairsAsBonds(graph):
    """Return the pairs of atoms that may be bonded according to their distances, as an (m, 2) array."""
    pairs = bondedPairs(graph.positions, graph.numbers, _WIDEST)
    first, second = pairs.T
    numbers = graph.numbers[first], graph.numbers[second]
    lengths = np.linalg.norm(graph.positions[first] - graph.positions[second], axis=1)
    areKnown = graph.hasTemplate[first] & graph.hasTemplate[second]
    areOfOne = graph.residueOf[first] == graph.residueOf[second]
    isUsual = lengths <= longestBonds(*numbers)
    isWide = ~areKnown & (areOfOne | (lengths <= longestBonds(*numbers, WIDE)))
    isWhole = areOfOne | (shortestBonds(*numbers) <= lengths)
    return pairs[isWhole & (isUsual | isWide)]
