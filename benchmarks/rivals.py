"""What one calls from Python, our own calls among it, on trials that the program has run."""

import importlib.util
import json
import math
from typing import NamedTuple

import numpy as np
import openmm
from measure import CPU, hasCPU, medianTime, timed
from openmm import app, unit
from openmmchaintree import StericExclusionForce, TorsionMonteCarloIntegrator
from program import ProgramError
from scene import makeContext

_BLOCK = 20  # trials of a contestant before the next one's turn
_STEP = 100  # trials of a step of a Simulation


class Trial(NamedTuple):
    """A turn of one torsion by an angle (rad), and whether it makes a clash."""

    torsion: int
    angle: float
    clash: bool


class Recording(NamedTuple):
    """A scene, and trials from its first state on; each one without a clash was accepted.

    positions : (n, 3) float64 array, nm; radii : (n,) float64 array, nm
    names : (n,) int array, the numbers of the particles in the source of the scene
    torsions : (m, 4) int array, rows of near, far, first, last: a torsion turns the particles first … last - 1 about
        the line from particle near to particle far
    exclusions : (k, 2) int array; trials : list of Trial
    """

    positions: np.ndarray
    radii: np.ndarray
    names: np.ndarray
    torsions: np.ndarray
    exclusions: np.ndarray
    trials: list[Trial]


def readRecording(path):
    """Read what the program wrote about trials of single torsions."""
    scene, *trials = [json.loads(line) for line in path.read_text(encoding="ascii").splitlines()]
    particles = np.array(scene["particles"], dtype=np.float64)
    return Recording(
        positions=np.ascontiguousarray(particles[:, :3]),
        radii=particles[:, 3].copy(),
        names=np.array(scene["names"], dtype=int),
        torsions=np.array(scene["torsions"], dtype=int),
        exclusions=np.array(scene["exclusions"], dtype=int).reshape(-1, 2),
        trials=[Trial(*trial["turns"][0], trial["clash"]) for trial in trials],
    )


def makeForce(recording):
    """Return the StericExclusionForce of a Recording, whose torsions are numbered as there."""
    force = StericExclusionForce()
    force.setOverlapTolerance(0)
    force.setHydrogenBondAllowance(0)
    for radius in recording.radii.tolist():
        force.addParticle(radius)
    # A particle belongs to the link of the last torsion, in the order of their first particles, that turns it.
    links = np.full(len(recording.radii), -1)
    torsions = recording.torsions
    for torsion in np.lexsort((-torsions[:, 3], torsions[:, 2])).tolist():
        links[slice(*torsions[torsion, 2:])] = torsion
    bonds = [tuple(torsion[:2]) for torsion in torsions.tolist()]
    for link in np.unique(links):
        members = np.flatnonzero(links == link).tolist()
        bonds = [*zip(members, members[1:], strict=False), *bonds]
    neighbors = [[] for _ in recording.radii]
    for one, other in bonds:
        force.addBond(one, other)
        neighbors[one].append(other)
        neighbors[other].append(one)
    for near, far, _, _ in torsions.tolist():
        before = next(particle for particle in neighbors[near] if particle != far)
        after = next(particle for particle in neighbors[far] if particle != near)
        force.addTorsion(before, near, far, after)
    for pair in recording.exclusions.tolist():
        force.addExclusion(*pair)
    return force


# ---- Contestants ----


class Rival:
    """A contestant that holds the particles of a Recording, tests its trials and accepts them.

    It moves the shorter side of a torsion. Subclasses say whether moved particles clash with the others.
    """

    name: str
    isExact = True  # whether verdicts are right up to rounding in double precision

    def __init__(self, recording):
        """Begin at the first state of a Recording."""
        self._radii, self._torsions = recording.radii, recording.torsions
        self._positions = recording.positions.copy()

    def test(self, trial):
        """Return whether a Trial makes a clash."""
        near, far, first, last = self._torsions[trial.torsion]
        count = len(self._positions)
        moved, fixed = np.arange(first, last), np.concatenate([np.arange(first), np.arange(last, count)])
        angle = trial.angle
        if len(moved) > len(fixed):
            moved, fixed, angle = fixed, moved, -angle
        self._moved = moved
        self._turned = turnAbout(self._positions[near], self._positions[far], self._positions[moved], angle)
        return self._clashes(moved, fixed, self._turned)

    def accept(self):
        """Accept the trial that was tested last."""
        self._positions[self._moved] = self._turned


class ScipyTrees(Rival):
    """A k-d tree of the particles that move, and one of the others."""

    name = "SciPy"

    def __init__(self, recording):
        """Begin at the first state of a Recording."""
        super().__init__(recording)
        self._Tree = importlib.import_module("scipy.spatial").cKDTree
        self._excluded = np.unique(self._codes(*recording.exclusions.T))

    def _clashes(self, moved, fixed, turned):
        # A tree for a single question need not be a good one.
        trees = [
            self._Tree(positions, balanced_tree=False, compact_nodes=False)
            for positions in (turned, self._positions[fixed])
        ]
        near = trees[0].sparse_distance_matrix(trees[1], 2 * self._radii.max(), output_type="ndarray")
        i, j = moved[near["i"]], fixed[near["j"]]
        overlap = near["v"] < self._radii[i] + self._radii[j]
        return not np.isin(self._codes(i[overlap], j[overlap]), self._excluded).all()

    def _codes(self, i, j):
        return np.minimum(i, j) * len(self._radii) + np.maximum(i, j)


class FclManagers(Rival):
    """A manager of the spheres that move, and one of the others."""

    name = "FCL"

    def __init__(self, recording):
        """Begin at the first state of a Recording."""
        super().__init__(recording)
        self._fcl = importlib.import_module("fcl")
        # A contact names no object but its geometry, so each sphere has one of its own.
        spheres = [self._fcl.Sphere(radius) for radius in self._radii.tolist()]
        self._objects = [
            self._fcl.CollisionObject(sphere, self._fcl.Transform(position))
            for sphere, position in zip(spheres, self._positions, strict=True)
        ]
        self._excluded = {frozenset((id(spheres[i]), id(spheres[j]))) for i, j in recording.exclusions.tolist()}
        self._request = self._fcl.CollisionRequest(num_max_contacts=1, enable_contact=True)

    def _clashes(self, moved, fixed, turned):
        self._place(moved, turned)
        found = []
        self._manage(moved).collide(self._manage(fixed), found, self._judge)
        if found:
            self._place(moved, self._positions[moved])
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
        """Compare objects whose boxes overlap; True ends the search."""
        result = self._fcl.CollisionResult()
        self._fcl.collide(object1, object2, self._request, result)
        if result.is_collision:
            contact = result.contacts[0]
            if frozenset((id(contact.o1), id(contact.o2))) not in self._excluded:
                found.append(contact)
        return bool(found)


class OpenMMForce(Rival):
    """A CustomNonbondedForce that counts clashes, on OpenMM's CPU platform with one thread, in single precision."""

    name = "OpenMM CPU"
    isExact = False

    def __init__(self, recording):
        """Begin at the first state of a Recording."""
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

    def _clashes(self, moved, fixed, turned):
        positions = self._positions.copy()
        positions[moved] = turned
        self._context.setPositions(positions)
        return self._context.getState(energy=True).getPotentialEnergy()._value > 0.5


class OurCalls:
    """The calls of a StericExclusionForce for one's own Monte Carlo, on the Reference platform."""

    name = "ours from Python"
    isExact = True

    def __init__(self, recording):
        """Begin at the first state of a Recording."""
        self._force = makeForce(recording)
        self._context = makeContext("Reference", len(recording.radii), self._force)
        self._context.setPositions(recording.positions)

    def test(self, trial):
        """Return whether a Trial makes a clash, and reject it if so."""
        isFree = self._force.proposeTorsions(self._context, [trial.torsion], [trial.angle])
        if not isFree:
            self._force.rejectProposal(self._context)
        return not isFree

    def accept(self):
        """Accept the trial that was tested last."""
        self._force.acceptProposal(self._context)


RIVALS = (ScipyTrees, FclManagers, OpenMMForce)


def isHere(rival):
    """Return whether what a rival needs is installed."""
    needed = {ScipyTrees: "scipy", FclManagers: "fcl"}.get(rival)
    return hasCPU() if needed is None else importlib.util.find_spec(needed) is not None


def turnAbout(near, far, positions, angle):
    """Return positions turned by an angle about the line from one place to another."""
    axis = (far - near) / np.linalg.norm(far - near)
    arms = positions - near
    along = np.outer(arms @ axis, axis)
    return near + along + np.cos(angle) * (arms - along) + np.sin(angle) * np.cross(axis, arms)


# ---- Races ----


def runFromPython(record, seed):
    """Return entries of our calls, of other packages, and of Simulation.step, whose trials are its own.

    The first block, whose trials the program has not timed either, does not count.
    """
    recording = readRecording(record)
    contestants = [rival(recording) for rival in (OurCalls, *filter(isHere, RIVALS))]
    times = {contestant.name: [] for contestant in contestants}
    for first in range(0, len(recording.trials), _BLOCK):
        block = recording.trials[first : first + _BLOCK]
        for contestant in contestants:
            verdicts, time = timed(_testAll, contestant, block)
            times[contestant.name].append(time / len(block))
            wrong = [k for k, trial in enumerate(block) if verdicts[k] != trial.clash]
            if wrong and contestant.isExact:
                word = "a clash" if verdicts[wrong[0]] else "free of clashes"
                raise ProgramError(f"{contestant.name} calls trial {first + wrong[0]} {word}, lazygrid does not")
    entries = [{"contestant": name, **medianTime(ofOne[1:] or ofOne)} for name, ofOne in times.items()]
    return [*entries, _runSteps(recording, seed)]


def _testAll(contestant, block):
    verdicts = []
    for trial in block:
        verdicts.append(contestant.test(trial))
        if not trial.clash:
            contestant.accept()
    return verdicts


def _runSteps(recording, seed):
    trials = max(_STEP, len(recording.trials))
    integrator = TorsionMonteCarloIntegrator(300 * unit.kelvin)
    integrator.setRandomNumberSeed(seed)
    integrator.setTrialsPerStep(_STEP)
    integrator.addTorsionMove(1.0, math.pi)
    system = openmm.System()
    for _ in recording.radii:
        system.addParticle(1.0)
    system.addForce(makeForce(recording))
    platform = openmm.Platform.getPlatformByName("Reference")
    simulation = app.Simulation(app.Topology(), system, integrator, platform)
    simulation.context.setPositions(recording.positions)
    simulation.step(1)
    times = [timed(simulation.step, 1)[1] / _STEP for _ in range(trials // _STEP)]
    attempted, *_, accepted = integrator.getMoveStatistics(0)
    return {"contestant": "Simulation.step", "accepted": accepted / attempted, **medianTime(times)}
