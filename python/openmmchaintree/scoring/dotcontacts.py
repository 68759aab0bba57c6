"""Contacts as the program Probe counts them: by dots on the surface of each atom.

A dot belongs to the atom that is nearest to it, measured from that atom's surface, and not bonded. Dots inside an atom
that is bonded, directly or by a few bonds, do not count. So a pair clashes only where no third atom lies between.

Source: Probe 2.26 (probe.c, dots.c); J. M. Word et al., J. Mol. Biol. 285, 1711-1733 (1999).
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from .contactatoms import ABSENT, ACCEPTOR, AROMATIC, DONOR, DUMMY, HYDROGEN, NEGATIVE, POSITIVE, WATER

# Lengths in nm. A pair clashes if a dot lies this deep in the other atom.
CLASH = 0.04
# A hydrogen bond may overlap this far; the second is between charges.
_HYDROGEN_BOND, _CHARGED_BOND = 0.06, 0.08
_PROBE = 0.025
_DENSITY = 1600.0  # dots per square nm
# Pairs that so many bonds join cannot clash; the second is for pairs without a hydrogen.
_MOST_BONDS, _MOST_HEAVY_BONDS = 4, 3
_SAME_PLACE = 1e-7  # square nm

# Hydrogens that water without hydrogens points at each acceptor around it, to donate hydrogen bonds and nothing else.
_DUMMY_RADIUS, _WATER_BOND, _BEST_OVERLAP = 0.105, 0.1, 0.06


class Contacts(NamedTuple):
    """The pairs of atoms that clash.

    pairs : (m, 2) int array, the lower index first, sorted
    overlaps : (m,) float64 array, nm: how deep a dot of one atom lies in the other, at most
    """

    pairs: np.ndarray
    overlaps: np.ndarray


def findContacts(atoms, positions):
    """Return the Contacts of ContactAtoms at positions, (n, 3) in nm. Water clashes only with other molecules.

    Cost: 10 ms, and 0.1 ms for each pair that overlaps far enough to clash.
    """
    count = len(positions)
    found = _DeepDots(*_withWaterHydrogens(atoms, positions)).find()
    deepest: dict[tuple[int, int], float] = {}
    for source, target, gap in found:
        if target < count:
            pair = (source, target) if source < target else (target, source)
            deepest[pair] = min(deepest.get(pair, 0.0), gap)
    pairs = sorted(deepest)
    overlaps = np.array([-deepest[pair] for pair in pairs])
    return Contacts(np.array(pairs, dtype=int).reshape(-1, 2), overlaps)


@cache
def dotSphere(radius):
    """Return the dots on a sphere around the origin: an (n, 3) array, nm, 16 dots per square ångström.

    They lie on circles of latitude, every other of which is shifted, and are tilted by 2.5 degrees.
    """
    most = int(4 * np.pi * _DENSITY * radius**2)
    equator = int(np.sqrt(most * np.pi))
    meridian = equator // 2
    found = []
    for row in range(meridian + 1):
        latitude = np.pi * row / meridian
        number = max(int(equator * np.sin(latitude)), 1)
        angles = (2 * np.pi * np.arange(number) + (0.2 if row % 2 == 0 else 0.0)) / number
        ring = np.sin(latitude) * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(number)])
        ring[:, 2] = np.cos(latitude)
        found.append(ring)
    points = radius * np.concatenate(found)[:most]
    cosine, sine = np.cos(np.radians(2.5)), np.sin(np.radians(2.5))
    return points @ np.array([[1, 0, 0], [0, cosine, sine], [0, -sine, cosine]])


def _withWaterHydrogens(atoms, positions):
    """Return ContactAtoms and positions with the dummies of water molecules without hydrogens at their end."""
    isWater = atoms.flags & WATER > 0
    oxygens = np.flatnonzero(isWater & (atoms.flags & ACCEPTOR > 0))
    withHydrogen = set(atoms.residues[isWater & (atoms.flags & HYDROGEN > 0)].tolist())
    places, residues = [], []
    if len(oxygens):
        accepting = np.flatnonzero(atoms.flags & ACCEPTOR > 0)
        tree = cKDTree(positions[accepting])
        for oxygen in oxygens.tolist():
            if atoms.residues[oxygen] in withHydrogen:
                continue
            near = accepting[tree.query_ball_point(positions[oxygen], atoms.radii[oxygen] + 0.21 + 2 * _PROBE)]
            for place in _pointAt(atoms, positions, oxygen, near):
                places.append(place)
                residues.append(atoms.residues[oxygen])
    if not places:
        return atoms, positions
    new = len(places)
    starts, others = atoms.bonds
    extended = atoms._replace(
        radii=np.append(atoms.radii, np.full(new, _DUMMY_RADIUS)),
        covalent=np.append(atoms.covalent, np.full(new, 0.03)),
        flags=np.append(atoms.flags, np.full(new, WATER | DONOR | HYDROGEN | DUMMY)),
        residues=np.append(atoms.residues, residues),
        parents=np.append(atoms.parents, np.full(new, -1)),
        bonds=(np.append(starts, np.full(new, starts[-1])), others),
    )
    return extended, np.concatenate([positions, places])


def _pointAt(atoms, positions, oxygen, near):
    """Return the places of dummies of a water's oxygen: one for each acceptor, and for the nearest of a ring."""
    vectors = positions[near] - positions[oxygen]
    distances = np.linalg.norm(vectors, axis=1)
    gaps = distances - atoms.radii[near] - 2 * _WATER_BOND
    touches = distances <= atoms.radii[oxygen] + atoms.radii[near] + 2 * _PROBE
    chosen: dict[tuple, int] = {}
    for index in np.flatnonzero(touches & (distances**2 > _SAME_PLACE)):
        atom = near[index]
        key = ("ring", atoms.residues[atom]) if atoms.flags[atom] & AROMATIC else ("atom", atom)
        if key not in chosen or gaps[index] < gaps[chosen[key]]:
            chosen[key] = index
    for index in chosen.values():
        length = _WATER_BOND + np.clip(gaps[index] + _BEST_OVERLAP, -_WATER_BOND, 0)
        yield positions[oxygen] + length / distances[index] * vectors[index]


class _DeepDots:
    """The dots of atoms that lie deep enough in another atom for a clash."""

    def __init__(self, atoms, positions):
        self._atoms, self._positions = atoms, positions
        self._tree = cKDTree(positions)
        self._bonded = _excluded(atoms)
        self._isMarked = np.zeros(len(positions), dtype=bool)

    def find(self):
        """Yield the two atoms and the least gap (nm) of each clash, seen from the first atom."""
        sources, targets, allowed = self._candidates()
        radii = self._atoms.radii
        for radius in np.unique(radii[sources]):
            own = np.flatnonzero(radii[sources] == radius)
            yield from self._clashesOf(sources[own], targets[own], allowed[own], float(radius))

    def _candidates(self):
        """Return pairs whose dots can lie deep enough, both ways, and what each may overlap beside that (nm)."""
        atoms, positions = self._atoms, self._positions
        pairs = self._tree.query_pairs(2 * atoms.radii.max(initial=0) - CLASH, output_type="ndarray")
        first, second = pairs.T
        isBond, allowed = self._hydrogenBonds(first, second)
        distances = np.sqrt(((positions[first] - positions[second]) ** 2).sum(axis=1))
        overlaps = atoms.radii[first] + atoms.radii[second] - distances
        flags = atoms.flags[first] | atoms.flags[second]
        chosen = (overlaps >= CLASH + allowed) & (flags & (DUMMY | ABSENT) == 0) & (distances**2 > _SAME_PLACE)
        chosen &= (atoms.radii[first] > 0) & (atoms.radii[second] > 0)
        pairs, allowed = pairs[chosen], allowed[chosen]
        pairs, allowed = np.concatenate([pairs, pairs[:, ::-1]]), np.concatenate([allowed, allowed])
        isCounted = atoms.flags[pairs[:, 0]] & WATER == 0
        pairs, allowed = pairs[isCounted], allowed[isCounted]
        if not len(pairs):  # which a sparse matrix cannot be indexed by
            return pairs[:, 0], pairs[:, 1], allowed
        areFree = np.asarray(self._bonded[pairs[:, 0], pairs[:, 1]]).ravel() == 0
        return pairs[areFree, 0], pairs[areFree, 1], allowed[areFree]

    def _clashesOf(self, sources, targets, allowed, radius):
        """Yield the clashes of pairs whose first atoms have one radius."""
        atoms, positions = self._atoms, self._positions
        sphere = dotSphere(radius)
        vectors = positions[sources] - positions[targets]
        squares = (vectors**2).sum(axis=1)[:, None] + radius**2 + 2 * vectors @ sphere.T
        limits = np.maximum(atoms.radii[targets] - CLASH - allowed, 0)
        # A little farther, for rounding.
        isDeep = squares <= (limits[:, None] + 1e-9) ** 2
        rows, dots = np.nonzero(isDeep)
        places = positions[sources[rows]] + sphere[dots]
        nearest = {}
        for row in np.unique(rows).tolist():
            source, target = int(sources[row]), int(targets[row])
            if source not in nearest:
                nearest[source] = self._around(source)
            own = rows == row
            gap = self._leastGap(places[own], target, *nearest[source])
            if gap is None or gap + allowed[row] > -CLASH:
                continue
            if allowed[row] and (
                self._hasBond(source, target, allowed[row]) or self._hasBond(target, source, allowed[row])
            ):
                continue
            yield source, target, gap + allowed[row]

    def _around(self, source):
        """Return the atoms whose spheres dots of an atom may touch, and those that bonds join to it."""
        atoms, positions = self._atoms, self._positions
        reach = atoms.radii[source] + atoms.radii.max()
        near = np.array(self._tree.query_ball_point(positions[source], reach), dtype=int)
        squares = ((positions[near] - positions[source]) ** 2).sum(axis=1)
        isNear = (squares > _SAME_PLACE) & (squares <= (atoms.radii[near] + atoms.radii[source]) ** 2)
        near = near[isNear & (atoms.radii[near] > 0)]
        areBonded = areIn(near, rowOf(self._bonded, source), self._isMarked)
        others = near[~areBonded & (atoms.flags[near] & ABSENT == 0)]
        isBond, _ = self._hydrogenBonds(source, others)
        return others[isBond | (atoms.flags[others] & DUMMY == 0)], near[areBonded]

    def _leastGap(self, places, target, others, hiding):
        """Return the least gap (nm) of dots that lie nearest to a target and in no bonded atom, or None."""
        gaps = self._gapsOf(places, others)
        own = others.tolist().index(target)
        counts = gaps.argmin(axis=1) == own
        if counts.any():
            inside = ((places[counts, None] - self._positions[hiding]) ** 2).sum(axis=2)
            counts[counts] = ~(inside <= self._atoms.radii[hiding] ** 2).any(axis=1)
        return float(gaps[counts, own].min()) if counts.any() else None

    def _hasBond(self, source, target, allowed):
        """Whether some dots of an atom make a hydrogen bond with a target, so that the pair does not clash."""
        others, hiding = self._around(source)
        places = self._positions[source] + dotSphere(float(self._atoms.radii[source]))
        gaps = self._gapsOf(places, others)
        own = others.tolist().index(target)
        counts = (gaps.argmin(axis=1) == own) & (gaps[:, own] >= -allowed) & (gaps[:, own] <= 0)
        inside = ((places[counts, None] - self._positions[hiding]) ** 2).sum(axis=2)
        return bool((~(inside <= self._atoms.radii[hiding] ** 2).any(axis=1)).any())

    def _gapsOf(self, places, others):
        distances = np.sqrt(((places[:, None] - self._positions[others]) ** 2).sum(axis=2))
        return distances - self._atoms.radii[others]

    def _hydrogenBonds(self, first, second):
        """Return which pairs may be hydrogen bonds, and how far these may overlap (nm), 0 for others."""
        own, others = self._atoms.flags[first], self._atoms.flags[second]
        fits = ((own & DONOR > 0) & (others & ACCEPTOR > 0)) | ((own & ACCEPTOR > 0) & (others & DONOR > 0))
        areCharged = (own & (POSITIVE | NEGATIVE) > 0) & (others & (POSITIVE | NEGATIVE) > 0)
        opposite = ((own & POSITIVE > 0) & (others & NEGATIVE > 0)) | ((own & NEGATIVE > 0) & (others & POSITIVE > 0))
        isBond = fits & (~areCharged | opposite)
        return isBond, np.where(isBond, np.where(areCharged, _CHARGED_BOND, _HYDROGEN_BOND), 0.0)


def bondedWithin(atoms, most):
    """Return which atoms at most some bonds join to each, as an (n, n) CSR matrix; an atom may be joined to itself."""
    starts, ends = atoms.bonds
    count = len(atoms.radii)
    one = sparse.csr_matrix((np.ones(len(ends), dtype=np.int32), ends, starts), shape=(count, count))
    total = power = one
    for _ in range(most - 1):
        power = power @ one
        total = total + power
    return total


def rowOf(matrix, row):
    """Return the columns of a row of a CSR matrix that have an entry."""
    return matrix.indices[matrix.indptr[row] : matrix.indptr[row + 1]]


def areIn(numbers, chosen, isMarked):
    """Return which numbers are among the chosen ones; isMarked : an array of False for all numbers, for the search."""
    isMarked[chosen] = True
    found = isMarked[numbers]
    isMarked[chosen] = False
    return found


def _excluded(atoms):
    """Return which pairs cannot clash since bonds join them: four, or three where neither atom is a hydrogen."""
    joined = bondedWithin(atoms, _MOST_BONDS).tocoo()
    near = bondedWithin(atoms, _MOST_HEAVY_BONDS)
    isHydrogen = atoms.flags & HYDROGEN > 0
    kept = isHydrogen[joined.row] | isHydrogen[joined.col]
    far = sparse.csr_matrix((joined.data[kept], (joined.row[kept], joined.col[kept])), shape=joined.shape)
    return near + far
