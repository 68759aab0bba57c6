"""Side chains with a few states, as in the program Reduce: hydrogens of histidines, and flips of Asn, Gln and His.

Source: Reduce 4.16 (FlipMemo.cpp); J. M. Word et al., J. Mol. Biol. 285, 1735-1747 (1999).
"""

from typing import NamedTuple

import numpy as np

from ..residues import aminoAcid
from .contactatoms import HYDROGEN
from .hydrogens import planarPlace, turnedPlace

# What a flip has to gain (0.5 in Reduce's units, dots per square ångström and ångström).
_PENALTY = 0.8
_LENGTH, _AROMATIC_LENGTH, _TRIGONAL = 0.086, 0.093, 120.0

# The atom before O and N, these two, and the hydrogens of N on the side of O and on the other.
_AMIDES = {"ASN": ("CG", "OD1", "ND2", "HD21", "HD22"), "GLN": ("CD", "OE1", "NE2", "HE22", "HE21")}
_RING = ("ND1", "CD2", "CE1", "NE2", "HD1", "HD2", "HE1", "HE2")
# The atoms at whose places those of the ring are when it is flipped, and the neighbors of those that bear hydrogens.
_FLIPPED_RING = (1, 0, 3, 2)
_NEIGHBORS = ((None, 2), (3, None), (0, 3), (2, 1))  # None is CG


class Choice(NamedTuple):
    """A side chain with a few states.

    scored : list of int, the atoms whose dots count; hydrogens : list of int, those that may be absent
    moved : list of int, atoms whose places the states give; places : (states, moved, 3) array, nm
    absent : list of list of int, the hydrogens that are absent, by state; penalties : list of float, by state
    """

    scored: list[int]
    hydrogens: list[int]
    moved: list[int]
    places: np.ndarray
    absent: list[list[int]]
    penalties: list[float]


def histidineChoice(atoms, pair):
    """Return the Choice of a histidine between its hydrogens on ND1 and NE2, a pair of particles."""
    scored = [*atoms.parents[list(pair)].tolist(), *pair]
    return Choice(scored, list(pair), [], np.zeros((2, 0, 3)), [[pair[0]], [pair[1]]], [0.0, 0.0])


def flipChoices(topology, atoms, positions):
    """Return the Choice of each Asn, Gln and His that can be flipped, by residue index; flipped states come last.

    Side chains with a bond to another residue or a metal are left out.
    """
    found = {}
    for residue in topology.residues():
        amino = aminoAcid(residue.name)
        index = {atom.name: atom.index for atom in residue.atoms()}
        names = _AMIDES.get(amino, ("CG", *_RING) if amino == "HIS" else ())
        if not names or not all(name in index for name in names):
            continue
        particles = [index[name] for name in names]
        if amino == "HIS":
            if all(_countBonds(atoms, particle) == 2 for particle in particles[1:5]):
                found[residue.index] = _ringChoice(particles[0], particles[1:], positions)
        elif all(_countBonds(atoms, particle) == 1 for particle in particles[1:3]):
            found[residue.index] = _amideChoice(particles, positions)
    return found


def _countBonds(atoms, particle):
    """Return the number of heavy atoms bonded to an atom."""
    starts, ends = atoms.bonds
    bonded = ends[starts[particle] : starts[particle + 1]]
    return int((atoms.flags[bonded] & HYDROGEN == 0).sum())


def _amideChoice(particles, positions):
    before, oxygen, nitrogen, near, far = particles
    moved = [oxygen, nitrogen, near, far]
    points = [positions[particle][None] for particle in (oxygen, before, nitrogen)]  # N, C and O after the flip
    hydrogens = [turnedPlace(*points, _LENGTH, _TRIGONAL, dihedral)[0] for dihedral in (0.0, 180.0)]
    flipped = np.array([positions[nitrogen], positions[oxygen], *hydrogens])
    return Choice(moved, [], moved, np.array([positions[moved], flipped]), [[], []], [0.0, _PENALTY])


def _ringChoice(before, ring, positions):
    heavy = positions[[ring[place] for place in _FLIPPED_RING]]
    hydrogens = []
    for number, pair in enumerate(_NEIGHBORS):
        neighbors = [positions[before] if place is None else heavy[place] for place in pair]
        length = _LENGTH if number in (0, 3) else _AROMATIC_LENGTH
        hydrogens.append((number, planarPlace(heavy[number][None], *(point[None] for point in neighbors), length)[0]))
    # The hydrogens in the order of the ring: of ND1, CD2, CE1 and NE2.
    flipped = np.array([*heavy, *(place for _, place in hydrogens)])
    own = positions[ring]
    first, last = ring[4], ring[7]
    absent = [[first], [last], [first], [last]]
    return Choice(ring, [first, last], ring, np.array([own, own, flipped, flipped]), absent, [0, 0, _PENALTY, _PENALTY])
