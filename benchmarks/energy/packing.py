"""Copies of a protein side by side, linked to one chain: what grows and stays as dense as a protein."""

import itertools

import numpy as np
from racing.scene import Link, Scene

from .forcefield import ForceFieldTerms, TermSet

_GAP = 0.3  # nm between the nearest atoms of neighbours
_STEP = 0.02  # nm
_CHUNK = 256  # atoms that are compared with all others at once


class PackedCopies:
    """Copies of a SampledProtein, shifted only, each against its neighbours in a lattice; it stands for one.

    The first residue of a copy is one rigid part with the last of the copy before it, at whatever distance: so a pivot
    moves all that follows.

    positions : (n, 3) float64 array, nm
    """

    def __init__(self, protein, count):
        """Pack so many copies, a power of two."""
        self._protein = protein
        self._shifts = _placeCopies(protein.positions, count)
        self.positions = np.concatenate([protein.positions + shift for shift in self._shifts])

    def makeScene(self):
        """Make the Scene of all copies."""
        one = self._protein.makeScene()
        roots = [number for number, link in enumerate(one.links) if link.parent < 0]
        if roots != [0]:
            raise ValueError("only a protein of one chain can be packed")
        last = max(number for number, link in enumerate(one.links) if number > 0 and not link.isSideChain)
        atoms, spheres, particleLinks, links, exclusions = len(one.spheres), [], [], [one.links[0]], []
        numbers = np.zeros(len(one.links), dtype=int)  # of the links of a copy
        for copy, shift in enumerate(self._shifts):
            numbers = np.array([numbers[last], *range(len(links), len(links) + len(one.links) - 1)])
            for link in one.links[1:]:
                near, far = link.near + copy * atoms, link.far + copy * atoms
                links.append(Link(int(numbers[link.parent]), near, far, link.isSideChain))
            spheres.append(one.spheres + [*shift, 0.0])
            particleLinks.append(numbers[one.particleLinks])
            exclusions.append(one.exclusions + copy * atoms)
        return Scene(np.concatenate(spheres), np.concatenate(particleLinks), links, np.concatenate(exclusions))

    def readTerms(self, method):
        """Return the ForceFieldTerms of all copies."""
        one = self._protein.readTerms(method)
        count, atoms = len(self._shifts), len(one.particles)

        def repeat(particles):
            return np.concatenate([particles + copy * atoms for copy in range(count)])

        return ForceFieldTerms(
            one.cutoff,
            one.switching,
            one.dielectric,
            np.tile(one.particles, (count, 1)),
            repeat(one.exclusions),
            [
                TermSet(kind, repeat(particles), np.tile(parameters, (count, 1)))
                for kind, particles, parameters in one.termSets
            ],
        )


def _placeCopies(positions, count):
    """Return the shift of each copy, along a path through a lattice in which neighbours follow each other."""
    sides = [1, 1, 1]
    while np.prod(sides) < count:
        sides[sides.index(min(sides))] *= 2
    axes = []
    for axis, side in enumerate(sides):
        shift = np.zeros(3)
        if side > 1:
            shift[axis] = _leastShift(positions, axis, axes)
        axes.append(shift)
    places = []
    for z in range(sides[2]):
        rows = range(sides[1]) if z % 2 == 0 else reversed(range(sides[1]))
        for y in rows:
            columns = range(sides[0]) if len(places) // sides[0] % 2 == 0 else reversed(range(sides[0]))
            places += [x * axes[0] + y * axes[1] + z * axes[2] for x in columns]
    return places


def _leastShift(positions, axis, others):
    """Return how far a copy has to go along an axis to come near none, also none that is shifted by the others."""
    distance = 0.0
    neighbors = [
        sum((k * other for k, other in zip(ks, others, strict=True)), np.zeros(3))
        for ks in itertools.product((-1, 0, 1), repeat=len(others))
    ]
    direction = np.eye(3)[axis]
    while any(_isNear(positions, positions + distance * direction + neighbor) for neighbor in neighbors):
        distance += _STEP
    return distance


def _isNear(positions1, positions2):
    inside = np.all((positions1 > positions2.min(axis=0) - _GAP) & (positions1 < positions2.max(axis=0) + _GAP), axis=1)
    near = positions1[inside]
    for first in range(0, len(near), _CHUNK):
        differences = near[first : first + _CHUNK, None] - positions2[None]
        if np.any(np.einsum("ijk,ijk->ij", differences, differences) < _GAP**2):
            return True
    return False
