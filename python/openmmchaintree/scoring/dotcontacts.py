"""Contacts as the program Probe counts them: by dots on the surface of each atom.

A dot belongs to the atom that is nearest to it, measured from that atom's surface, and not bonded. Dots inside an atom
that is bonded, directly or by a few bonds, do not count. So a pair clashes only where no third atom lies between.

Source: Probe 2.26 (probe.c, dots.c); J. M. Word et al., J. Mol. Biol. 285, 1711-1733 (1999).
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from .contactatoms import ABSENT, ACCEPTOR, AROMATIC, DONOR, DUMMY, HYDROGEN, NEGATIVE, POSITIVE, WATER

# Lengths in nm. A pair clashes if a dot lies this deep in the other atom.
CLASH = 0.04
# A hydrogen bond may overlap this far; the second is between charges.
_HYDROGEN_BOND, _CHARGED_BOND = 0.06, 0.08
_PROBE = 0.025
_DENSITY = 1600.0  # dots per square nm
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

    Cost: some ten atoms around each of n, and a few hundred dots for each atom that may clash.
    """
    count = len(positions)
    dots = _Dots(*_withWaterHydrogens(atoms, positions))
    deepest: dict[tuple[int, int], float] = {}
    bonded = set()
    for source in dots.sources():
        for target, gap, isBond in dots.contactsOf(source):
            if target < count:
                pair = (source, target) if source < target else (target, source)
                if isBond:
                    bonded.add(pair)
                elif gap <= -CLASH:
                    deepest[pair] = min(deepest.get(pair, 0.0), gap)
    pairs = sorted(set(deepest) - bonded)
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


class _Dots:
    """The dots of atoms at given positions."""

    def __init__(self, atoms, positions):
        self._atoms, self._positions = atoms, positions
        self._tree = cKDTree(positions)
        self._reach = 2 * atoms.radii.max(initial=0) + 2 * _PROBE

    def sources(self):
        """Return the atoms whose dots can lie deep enough in another: those that overlap one and are not water."""
        atoms, positions = self._atoms, self._positions
        pairs = self._tree.query_pairs(2 * atoms.radii.max(initial=0) - CLASH, output_type="ndarray")
        first, second = pairs.T
        distances = np.linalg.norm(positions[first] - positions[second], axis=1)
        overlaps = atoms.radii[first] + atoms.radii[second] - distances
        chosen = (overlaps >= CLASH) & ((atoms.flags[first] | atoms.flags[second]) & (DUMMY | ABSENT) == 0)
        ends = np.concatenate([pairs[chosen], pairs[chosen][:, ::-1]])
        ends = ends[(atoms.flags[ends[:, 0]] & WATER == 0) & (atoms.radii[ends].min(axis=1, initial=1) > 0)]
        found = []
        order = np.argsort(ends[:, 0], kind="stable")
        starts = np.flatnonzero(np.diff(ends[order, 0], prepend=-1))
        for group in np.split(ends[order], starts[1:]):
            if len(group) and not set(group[:, 1].tolist()) <= self.bondedTo(int(group[0, 0])):
                found.append(int(group[0, 0]))
        return found

    def bondedTo(self, source, touching=None):
        """Return the atoms that a few bonds join to an atom: four, or three where neither is a hydrogen.

        Bonds lead through touching atoms only, if these are given.
        """
        starts, others = self._atoms.bonds
        isHydrogen = self._atoms.flags & HYDROGEN
        seen = {source: 0}
        shell = [source]
        for distance in range(1, _MOST_BONDS + 1):
            following = []
            for atom in shell:
                for other in others[starts[atom] : starts[atom + 1]].tolist():
                    if other not in seen and (touching is None or other in touching):
                        seen[other] = distance
                        following.append(other)
            shell = following
        del seen[source]
        if not isHydrogen[source]:
            seen = {atom: n for atom, n in seen.items() if n <= _MOST_HEAVY_BONDS or isHydrogen[atom]}
        return set(seen)

    def contactsOf(self, source):
        """Yield for each atom that dots of an atom lie in: its index, the least gap (nm), and whether they are bonded.

        The bond is a hydrogen bond. An atom comes twice if a hydrogen bond is too short.
        """
        atoms, positions = self._atoms, self._positions
        center = positions[source]
        near = np.array(self._tree.query_ball_point(center, self._reach), dtype=int)
        squares = ((positions[near] - center) ** 2).sum(axis=1)
        limits = atoms.radii[near] + atoms.radii[source] + 2 * _PROBE
        near = near[(squares > _SAME_PLACE) & (squares <= limits**2) & (atoms.radii[near] > 0)]
        bonded = self.bondedTo(source, set(near.tolist()))
        areBonded = np.fromiter((atom in bonded for atom in near.tolist()), dtype=bool, count=len(near))
        inside, near = near[areBonded], near[~areBonded]
        isBond, charged = self._hydrogenBonds(source, near)
        counts = (isBond | (atoms.flags[near] & DUMMY == 0)) & (atoms.flags[near] & ABSENT == 0)
        near, isBond, charged = near[counts], isBond[counts], charged[counts]
        if not len(near):
            return
        dots = center + dotSphere(float(atoms.radii[source]))
        gaps = np.sqrt(((dots[:, None] - positions[near]) ** 2).sum(axis=2)) - atoms.radii[near]
        nearest = gaps.argmin(axis=1)
        least = gaps[np.arange(len(dots)), nearest]
        kept = least <= 0
        hidden = ((dots[kept, None] - positions[inside]) ** 2).sum(axis=2) <= atoms.radii[inside] ** 2
        kept[kept] = ~hidden.any(axis=1)
        allowed = np.where(charged, _CHARGED_BOND, _HYDROGEN_BOND)
        for index in np.unique(nearest[kept]):
            own = least[kept & (nearest == index)]
            if not isBond[index]:
                yield int(near[index]), own.min(), False
                continue
            tooDeep = own < -allowed[index]
            if tooDeep.any():
                yield int(near[index]), own.min() + allowed[index], False
            if not tooDeep.all():
                yield int(near[index]), own.max(), True

    def _hydrogenBonds(self, source, near):
        """Return which atoms may be hydrogen bonded to one, and which of these by opposite charges."""
        own, others = self._atoms.flags[source], self._atoms.flags[near]
        fits = ((own & DONOR > 0) & (others & ACCEPTOR > 0)) | ((own & ACCEPTOR > 0) & (others & DONOR > 0))
        areCharged = (own & (POSITIVE | NEGATIVE) > 0) & (others & (POSITIVE | NEGATIVE) > 0)
        opposite = ((own & POSITIVE > 0) & (others & NEGATIVE > 0)) | ((own & NEGATIVE > 0) & (others & POSITIVE > 0))
        return fits & (~areCharged | opposite), areCharged & opposite
