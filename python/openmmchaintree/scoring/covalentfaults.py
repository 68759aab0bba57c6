"""Faults of covalent geometry that turning bonds cannot mend: broken bonds, and rings that a bond passes through."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ..bondsearch import BondSearch
from ..covalent import longestBonds, shortestBonds
from ..graphs import neighborLists

# The most atoms of a ring that is looked at.
_MOST_OF_RING = 7
# A bond passes through a ring only if their middles are this near, nm.
_NEAR = 0.3


class BrokenBond(NamedTuple):
    """A bond that is too long or too short. particle1, particle2 : int; length : float, nm"""

    particle1: int
    particle2: int
    length: float


class PiercedRing(NamedTuple):
    """A ring, and a bond that passes through it. ring : tuple of int, in order; particle1, particle2 : int"""

    ring: tuple[int, ...]
    particle1: int
    particle2: int


class CovalentFaults(NamedTuple):
    """brokenBonds : list of BrokenBond; piercedRings : list of PiercedRing"""

    brokenBonds: list[BrokenBond]
    piercedRings: list[PiercedRing]


def covalentFaults(topology, positions):
    """Return the CovalentFaults of a Topology at given positions, (n, 3) in nm.

    Bonds follow from residue templates, and from distances where these say nothing. They are broken where they are
    longer than 1.15 times the sum of covalent radii, or shorter than 0.75 times it (0.8 between residues). Bonds of
    hydrogens and metals are left out, as are rings of more than seven atoms.

    Raises
    ------
    InputError
        if lengths of bonds show that coordinates are in another unit
    """
    search = BondSearch(topology, positions)
    bonds = np.array(search.bonds, dtype=int).reshape(-1, 2)
    bonds = bonds[(search.numbers[bonds] > 1).all(axis=1)]
    metals = {tuple(sorted(pair)) for pair in search.metalBonds}
    bonds = bonds[[tuple(pair) not in metals for pair in bonds.tolist()]] if metals else bonds
    lengths = np.linalg.norm(positions[bonds[:, 0]] - positions[bonds[:, 1]], axis=1)
    numbers = search.numbers[bonds]
    areOfTwo = search.residueOf[bonds[:, 0]] != search.residueOf[bonds[:, 1]]
    isBroken = lengths > longestBonds(numbers[:, 0], numbers[:, 1])
    isBroken |= lengths < shortestBonds(numbers[:, 0], numbers[:, 1], areOfTwo)
    broken = [
        BrokenBond(*pair, length)
        for pair, length in zip(bonds[isBroken].tolist(), lengths[isBroken].tolist(), strict=True)
    ]
    return CovalentFaults(broken, _piercedRings(_ringsOf(search, bonds[~areOfTwo]), bonds, positions))


def _ringsOf(search, bonds):
    """Return the rings within residues, as tuples of atoms in order; bonds are those within residues."""
    byResidue: dict[int, list[tuple[int, int]]] = {}
    for first, second in bonds.tolist():
        byResidue.setdefault(int(search.residueOf[first]), []).append((first, second))
    known: dict[tuple, list[tuple[int, ...]]] = {}
    rings = []
    for own in byResidue.values():
        least = min(first for first, _ in own)
        key = tuple((first - least, second - least) for first, second in own)
        if key not in known:
            known[key] = _smallRings(key)
        rings += [tuple(least + atom for atom in ring) for ring in known[key]]
    return rings


def _smallRings(bonds):
    """Return the smallest ring of each bond, each ring once."""
    neighbors = neighborLists(1 + max(map(max, bonds)), bonds)
    found: dict[frozenset[int], tuple[int, ...]] = {}
    for first, second in bonds:
        paths = [(first,)]
        ring = None
        for _ in range(_MOST_OF_RING - 1):
            paths = [
                (*path, atom)
                for path in paths
                for atom in neighbors[path[-1]]
                if atom not in path and (path[-1], atom) != (first, second)
            ]
            ring = next((path for path in paths if path[-1] == second), None)
            if ring is not None:
                found.setdefault(frozenset(ring), ring)
                break
    return list(found.values())


def _piercedRings(rings, bonds, positions):
    """Return the PiercedRing of each ring and bond that passes through it."""
    if not rings or not len(bonds):
        return []
    middles = 0.5 * (positions[bonds[:, 0]] + positions[bonds[:, 1]])
    tree = cKDTree(middles)
    centers = np.array([positions[list(ring)].mean(axis=0) for ring in rings])
    found = []
    for ring, center, near in zip(rings, centers, tree.query_ball_point(centers, _NEAR), strict=True):
        corners = positions[list(ring)]
        for number in sorted(near):
            pair = bonds[number].tolist()
            if set(pair).isdisjoint(ring) and _passes(positions[pair[0]], positions[pair[1]], center, corners):
                found.append(PiercedRing(ring, *pair))
    return found


def _passes(begin, end, center, corners):
    """Whether a line from begin to end passes through one of the triangles of a ring's middle and its sides."""
    edge1, edge2 = corners - center, np.roll(corners, -1, axis=0) - center
    along = end - begin
    across = np.cross(along, edge2)
    determinants = (edge1 * across).sum(axis=1)
    safe = np.where(np.abs(determinants) > 1e-15, determinants, np.inf)
    toBegin = begin - center
    first = across @ toBegin / safe
    turned = np.cross(toBegin, edge1)
    second = turned @ along / safe
    share = (edge2 * turned).sum(axis=1) / safe
    return bool(((first >= 0) & (second >= 0) & (first + second <= 1) & (share >= 0) & (share <= 1)).any())
