"""What one calls from Python, our own calls among it, as contestants on recorded trials of single torsions."""

import importlib
from typing import NamedTuple

import numpy as np
import openmm

from .platforms import CPU, makeContext
from .recording import makeForce


class Turned(NamedTuple):
    """A trial: the indices of the particles that it moves and of those that it does not, and where it moves them."""

    moved: np.ndarray
    fixed: np.ndarray
    positions: np.ndarray


class Rival:
    """A contestant: holds the particles of a Recording, tests its trials and takes them over.

    It moves the shorter side of a torsion, so that the particles are where they should be up to a motion of them all.
    Subclasses have a `name`, the `requirement` without which they cannot run, and say in `_clashes` of a Turned whether
    it clashes.
    """

    # Whether verdicts are right up to rounding in double precision.
    isExact = True

    def __init__(self, recording):
        """Take over the first state of a Recording."""
        self._radii = recording.radii
        self._positions = recording.positions.copy()
        self._torsions = recording.torsions
        self._turned = None

    def test(self, trial):
        """Return whether a Trial makes a clash."""
        self._turned = self._turn(trial)
        return self._clashes(self._turned)

    def accept(self):
        """Take over the trial that was tested last."""
        self._positions[self._turned.moved] = self._turned.positions

    def _turn(self, trial):
        near, far, first, last = self._torsions[trial.torsion]
        count = len(self._positions)
        moved, fixed = np.arange(first, last), np.concatenate([np.arange(first), np.arange(last, count)])
        angle = trial.angle
        if len(moved) > len(fixed):
            moved, fixed, angle = fixed, moved, -angle
        origin = self._positions[near]
        rotation = _rotation(self._positions[far] - origin, angle)
        return Turned(moved, fixed, (self._positions[moved] - origin) @ rotation.T + origin)


class ScipyTrees(Rival):
    """A tree of the particles that move, and one of the others."""

    name = "SciPy"
    requirement = "scipy"

    def __init__(self, recording):
        """Take over the first state of a Recording."""
        super().__init__(recording)
        self._Tree = importlib.import_module("scipy.spatial").cKDTree
        self._cutoff = 2 * self._radii.max()
        # The last is there for the search to end at.
        self._excluded = np.append(np.unique(self._codes(*recording.exclusions.T)), np.iinfo(int).max)

    def _clashes(self, turned):
        moved, fixed = self._makeTree(turned.positions), self._makeTree(self._positions[turned.fixed])
        near = moved.sparse_distance_matrix(fixed, self._cutoff, output_type="ndarray")
        i, j = turned.moved[near["i"]], turned.fixed[near["j"]]
        overlap = near["v"] < self._radii[i] + self._radii[j]
        codes = self._codes(i[overlap], j[overlap])
        return bool((self._excluded[np.searchsorted(self._excluded, codes)] != codes).any())

    def _makeTree(self, positions):
        # A tree for a single question need not be a good one.
        return self._Tree(positions, balanced_tree=False, compact_nodes=False)

    def _codes(self, i, j):
        """Return a number for each pair of particles."""
        return np.minimum(i, j) * len(self._radii) + np.maximum(i, j)


class FclManagers(Rival):
    """A manager of the spheres that move, and one of the others."""

    name = "FCL"
    requirement = "fcl"

    def __init__(self, recording):
        """Take over the first state of a Recording."""
        super().__init__(recording)
        self._fcl = importlib.import_module("fcl")
        # Each sphere has a geometry of its own, since by that alone a contact tells which it is.
        spheres = [self._fcl.Sphere(radius) for radius in self._radii.tolist()]
        self._objects = [
            self._fcl.CollisionObject(sphere, self._fcl.Transform(position))
            for sphere, position in zip(spheres, self._positions, strict=True)
        ]
        self._excluded = {frozenset((id(spheres[i]), id(spheres[j]))) for i, j in recording.exclusions.tolist()}
        self._request = self._fcl.CollisionRequest(num_max_contacts=1, enable_contact=True)

    def _clashes(self, turned):
        self._place(turned.moved, turned.positions)
        found = []
        self._manage(turned.moved).collide(self._manage(turned.fixed), found, self._judge)
        if found:
            self._place(turned.moved, self._positions[turned.moved])
        return bool(found)

    def _place(self, particles, positions):
        for particle, position in zip(particles.tolist(), positions, strict=True):
            self._objects[particle].setTranslation(position)

    def _manage(self, particles):
        manager = self._fcl.DynamicAABBTreeCollisionManager()
        manager.registerObjects([self._objects[particle] for particle in particles.tolist()])
        manager.setup()
        return manager

    def _judge(self, object1, object2, found):
        """Called for objects whose boxes overlap; True ends the search."""
        result = self._fcl.CollisionResult()
        self._fcl.collide(object1, object2, self._request, result)
        if result.is_collision:
            contact = result.contacts[0]
            if frozenset((id(contact.o1), id(contact.o2))) not in self._excluded:
                found.append(contact)
        return bool(found)


class OpenMMForce(Rival):
    """A CustomNonbondedForce that counts clashes, on OpenMM's CPU platform with one thread."""

    name = "OpenMM CPU"
    requirement = CPU
    isExact = False  # that platform computes in single precision

    def __init__(self, recording):
        """Take over the first state of a Recording."""
        super().__init__(recording)
        force = openmm.CustomNonbondedForce("step(radius1 + radius2 - r)")
        force.addPerParticleParameter("radius")
        force.setNonbondedMethod(force.CutoffNonPeriodic)
        force.setCutoffDistance(2 * self._radii.max())
        for radius in self._radii.tolist():
            force.addParticle([radius])
        for pair in {(min(pair), max(pair)) for pair in recording.exclusions.tolist()}:
            force.addExclusion(*pair)
        self._context = makeContext(CPU, len(self._radii), force)

    def _clashes(self, turned):
        positions = self._positions.copy()
        positions[turned.moved] = turned.positions
        self._context.setPositions(positions)
        count = self._context.getState(energy=True).getPotentialEnergy()
        return count.value_in_unit(count.unit) > 0.5


class OurCalls:
    """The calls of a StericExclusionForce by which one writes a Monte Carlo of one's own, on the Reference platform."""

    name = "ours from Python"
    isExact = True

    def __init__(self, recording):
        """Take over the first state of a Recording."""
        self._force = makeForce(recording)
        self._context = makeContext("Reference", len(recording.radii), self._force)
        self._context.setPositions(recording.positions)

    def test(self, trial):
        """Return whether a Trial makes a clash; one that does is taken back."""
        isFree = self._force.proposeTorsions(self._context, [trial.torsion], [trial.angle])
        if not isFree:
            self._force.rejectProposal(self._context)
        return not isFree

    def accept(self):
        """Take over the trial that was tested last."""
        self._force.acceptProposal(self._context)


RIVALS = (ScipyTrees, FclManagers, OpenMMForce)


def _rotation(axis, angle):
    """Return the matrix of a rotation about an axis."""
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)
