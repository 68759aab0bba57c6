"""What distances tell of bonds: covalent radii, metals, and atoms near each other.

The radii are those of Cordero et al., Dalton Trans. 2832–2838 (2008), which the package gemmi holds.
"""

from functools import cache

import gemmi
import numpy as np

# Bonds are up to so much longer than the sum of covalent radii. Hydrogens are often placed carelessly.
_STRETCH, _STRETCH_OF_HYDROGENS = 1.15, 1.3

# Atoms nearer than this (nm) are at one place, and not bonded.
_SHORTEST = 0.05

# The angles at which bonds meet, with room for what is strained or coarsely resolved.
_ANGLES = np.radians((75.0, 165.0))

# Of so many atoms all pairs are looked at sooner than SciPy is imported.
_FEW = 1500

# What metals are bound by, in proteins and their ligands: N, O, F, P, S, Cl, Se, Br, I.
_DONORS = np.array([7, 8, 9, 15, 16, 17, 34, 35, 53])

# Ions that water surrounds wherever they are: they are bound only if the file says so.
_LOOSE_METALS = np.array([3, 11, 19, 37, 55])


def longestBonds(numbers1, numbers2):
    """Return the largest length (nm) of a bond between atoms of given atomic numbers, 0 with a number of 0."""
    radii = _radii()
    isKnown = (np.asarray(numbers1) > 0) & (np.asarray(numbers2) > 0)
    hasHydrogen = (np.asarray(numbers1) == 1) | (np.asarray(numbers2) == 1)
    stretch = np.where(hasHydrogen, _STRETCH_OF_HYDROGENS, _STRETCH)
    return np.where(isKnown, stretch * (radii[numbers1] + radii[numbers2]), 0.0)


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

    positions : (n, 3) array; O(n log n) for points that are spread

    Raises
    ------
    ValueError
        if a coordinate is not a finite number
    """
    if not np.isfinite(positions).all():
        raise ValueError("a coordinate is not a finite number")
    if len(positions) <= _FEW:
        first, second = np.triu_indices(len(positions), 1)
        squares = sum((positions[first, k] - positions[second, k]) ** 2 for k in range(3))
        return np.column_stack([first, second])[squares <= distance**2]
    from scipy.spatial import cKDTree

    pairs = cKDTree(positions).query_pairs(distance, output_type="ndarray")
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def bondedPairs(positions, numbers):
    """Return the pairs of atoms that are as near as if they were bonded, as an (m, 2) array, sorted.

    positions : (n, 3) array, nm; numbers : (n,) int array, atomic numbers

    Pairs of two hydrogens are left out.
    """
    pairs = nearPairs(positions, 2 * _STRETCH * _radii()[numbers].max(initial=0.0))
    first, second = pairs.T
    distances = np.linalg.norm(positions[first] - positions[second], axis=1)
    hydrogens = (numbers[first] == 1) & (numbers[second] == 1)
    longest = longestBonds(numbers[first], numbers[second])
    return pairs[(_SHORTEST <= distances) & (distances <= longest) & ~hydrogens]


def areAnglesOfBonds(positions, atom, other, neighbors):
    """Return whether a bond from an atom to another would meet the bonds to its neighbors at the angles of bonds."""
    axis = positions[other] - positions[atom]
    vectors = positions[neighbors] - positions[atom]
    cosines = vectors @ axis / (np.linalg.norm(vectors, axis=1) * np.linalg.norm(axis))
    angles = np.arccos(np.clip(cosines, -1, 1))
    return bool(((_ANGLES[0] <= angles) & (angles <= _ANGLES[1])).all())


@cache
def _radii():
    """Return the covalent radii (nm) by atomic number."""
    return np.array([0.0] + [0.1 * gemmi.Element(number).covalent_r for number in range(1, 119)])


@cache
def _metals():
    return np.array([False] + [gemmi.Element(number).is_metal for number in range(1, 119)])
