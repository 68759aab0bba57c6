"""Bonds by distance: covalent radii, metals, and pairs of atoms near each other.

Radii and metals are in the table `tables/elements.csv`, with its source.
"""

from functools import cache

import numpy as np

from .contexts import contextOf
from .datatables import readTable
from .graphs import connectedParts, neighborLists
from .openmmchaintree import StericExclusionForce

# A bond's length is at most this factor times the sum of covalent radii. Hydrogens are often placed carelessly. WIDE is
# for residues whose bonds only distances can show.
_STRETCH, _STRETCH_OF_HYDROGENS = 1.15, 1.3
WIDE = 1.31

# A bond's length is at least this factor times that sum: triple bonds reach 0.77, double bonds of metals 0.72, and
# bonds between residues 0.85; disulfides of models may be squeezed.
_SHRINK, _SHRINK_OF_METALS, _SHRINK_BETWEEN_RESIDUES = 0.75, 0.7, 0.8

# Atoms nearer than this (nm) are at the same place, and not bonded.
_SHORTEST = 0.05

# The range of angles between two bonds of an atom, wide enough for strained and poorly resolved structures.
_ANGLES = np.radians((75.0, 165.0))

# The engine is asked for pairs up to this factor farther apart, so that its rounding loses none.
_ROOM_FOR_ROUNDING = 1 + 1e-6

# Elements that bind metals in proteins and their ligands: N, O, F, P, S, Cl, Se, Br, I.
_DONORS = np.array([7, 8, 9, 15, 16, 17, 34, 35, 53])

# Alkali ions, which water surrounds everywhere: they are bound only if the file says so.
_LOOSE_METALS = np.array([3, 11, 19, 37, 55])

_HYDROGEN, _SULFUR = 1, 16

# The largest number of bonds of an atom, by atomic number: H, C, N, O, F, Cl, Br, I.
_MOST_BONDS = {1: 1, 6: 4, 7: 4, 8: 2, 9: 1, 17: 1, 35: 1, 53: 1}

# N, O and halogens: two of these are never bonded to each other between residues.
_ELECTRONEGATIVE = np.array([7, 8, 9, 17, 35, 53])


def longestBonds(numbers1, numbers2, stretch=_STRETCH):
    """Return the largest length (nm) of a bond between atoms of given atomic numbers, 0 if one of these is 0.

    stretch : the factor by which it may exceed the sum of covalent radii, if neither atom is a hydrogen
    """
    radii = _radii()
    isKnown = (np.asarray(numbers1) > 0) & (np.asarray(numbers2) > 0)
    hasHydrogen = (np.asarray(numbers1) == 1) | (np.asarray(numbers2) == 1)
    stretch = np.where(hasHydrogen, _STRETCH_OF_HYDROGENS, stretch)
    return np.where(isKnown, stretch * (radii[numbers1] + radii[numbers2]), 0.0)


def shortestBonds(numbers1, numbers2, areOfTwoResidues=False):
    """Return the least length (nm) of a bond between atoms of given atomic numbers: nearer atoms clash."""
    radii, metals = _radii(), _metals()
    hasHydrogen = (np.asarray(numbers1) == 1) | (np.asarray(numbers2) == 1)
    areSulfurs = (np.asarray(numbers1) == _SULFUR) & (np.asarray(numbers2) == _SULFUR)
    shrink = np.where(areOfTwoResidues & ~areSulfurs, _SHRINK_BETWEEN_RESIDUES, _SHRINK)
    shrink = np.where(metals[numbers1] | metals[numbers2], _SHRINK_OF_METALS, shrink)
    return np.where(hasHydrogen, _SHORTEST, shrink * (radii[numbers1] + radii[numbers2]))


def canBond(numbers, bondCounts):
    """Return whether atoms of two residues can be bonded: both may have another bond, and one is not electronegative.

    numbers, bondCounts : the two atomic numbers, and the numbers of bonds that the atoms have already
    """
    if np.isin(numbers, _ELECTRONEGATIVE).all():
        return False
    most = [_MOST_BONDS.get(int(number), np.inf) for number in numbers]
    return all(count < limit for count, limit in zip(bondCounts, most, strict=True))


def isMetal(numbers):
    """Return whether elements of given atomic numbers are metals."""
    return _metals()[numbers]


def bindsMetals(numbers):
    """Return whether elements of given atomic numbers bind metals by an electron pair."""
    return np.isin(numbers, _DONORS)


def isLooseMetal(numbers):
    """Return whether elements of given atomic numbers are alkali metals."""
    return np.isin(numbers, _LOOSE_METALS)


def nearPairs(positions, distance):
    """Return the pairs of points within a distance of each other, as an (m, 2) array, sorted.

    positions : (n, 3) array, nm

    Raises
    ------
    ValueError
        if a coordinate is not a finite number
    """
    if not np.isfinite(positions).all():
        raise ValueError("a coordinate is not a finite number")
    if len(positions) < 2 or distance <= 0:
        return np.empty((0, 2), dtype=int)
    force = StericExclusionForce()
    for _ in positions:
        force.addParticle(distance)  # any radius above 0: neighbors do not depend on it
    context = contextOf(force)
    context.setPositions(positions)
    first, second = force.getNeighborPairs(context, _ROOM_FOR_ROUNDING * distance)[0].astype(int).T
    squares = sum((positions[first, k] - positions[second, k]) ** 2 for k in range(3))
    return np.column_stack([first, second])[squares <= distance**2]


def bondedPairs(positions, numbers, stretch=_STRETCH):
    """Return the pairs of atoms at most a bond's length apart, as an (m, 2) array, sorted.

    positions : (n, 3) array, nm; numbers : (n,) int array, atomic numbers; stretch : as for `longestBonds`

    Pairs of two hydrogens, and atoms at the same place, are left out.
    """
    pairs = nearPairs(positions, 2 * max(stretch, _STRETCH) * _radii()[numbers].max(initial=0.0))
    first, second = pairs.T
    distances = np.linalg.norm(positions[first] - positions[second], axis=1)
    hydrogens = (numbers[first] == 1) & (numbers[second] == 1)
    longest = longestBonds(numbers[first], numbers[second], stretch)
    return pairs[(_SHORTEST <= distances) & (distances <= longest) & ~hydrogens]


def bondsBetweenParts(positions, numbers, bonds):
    """Return bonds by distance between the parts of a residue that its bonds do not connect, the likeliest first.

    positions : (n, 3) array, nm; numbers : (n,) int array, atomic numbers; bonds : list of (int, int)
    """
    part = connectedParts(len(numbers), bonds)
    near = bondedPairs(positions, numbers, WIDE)
    near = near[part[near[:, 0]] != part[near[:, 1]]]
    lengths = np.linalg.norm(positions[near[:, 0]] - positions[near[:, 1]], axis=1)
    ends = numbers[near[:, 0]], numbers[near[:, 1]]
    isLong = lengths > longestBonds(*ends)
    isWhole = lengths >= shortestBonds(*ends)
    neighbors = neighborLists(len(numbers), bonds)
    found = []
    for number in np.lexsort((lengths, isLong)):
        first, second = near[number].tolist()
        if not isWhole[number]:
            continue
        # A hydrogen has one bond, to the nearest atom.
        if any(numbers[atom] == _HYDROGEN and neighbors[atom] for atom in (first, second)):
            continue
        # A pair longer than bonds are is no bond if it spans an angle, or lies on top of another bond.
        if isLong[number] and not (
            set(neighbors[first]).isdisjoint(neighbors[second])
            and areAnglesOfBonds(positions, first, second, neighbors[first])
            and areAnglesOfBonds(positions, second, first, neighbors[second])
        ):
            continue
        neighbors[first].append(second)
        neighbors[second].append(first)
        found.append((first, second))
    return found


def areAnglesOfBonds(positions, atom, other, neighbors):
    """Return whether a bond from an atom to another would make usual angles with the atom's bonds to its neighbors."""
    axis = positions[other] - positions[atom]
    vectors = positions[neighbors] - positions[atom]
    cosines = vectors @ axis / (np.linalg.norm(vectors, axis=1) * np.linalg.norm(axis))
    angles = np.arccos(np.clip(cosines, -1, 1))
    return bool(((_ANGLES[0] <= angles) & (angles <= _ANGLES[1])).all())


@cache
def _radii():
    """Return the covalent radii (nm) by atomic number."""
    # In single precision, as gemmi has them: which atoms are bonded must not change by a rounding.
    return np.array([0.0] + [0.1 * float(np.float32(radius)) for _, radius, _ in readTable("elements.csv")])


@cache
def _metals():
    return np.array([False] + [isMetal == "1" for _, _, isMetal in readTable("elements.csv")])
