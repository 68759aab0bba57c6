"""The work of one replica in one round, as a pure function of its arguments."""

import copy
import hashlib
from threading import Event, Lock
from time import perf_counter
from typing import NamedTuple

import numpy as np
import openmm
from openmm import unit

# Hard spheres: trials between points at which a run can be interrupted, for any interval between frames.
_TRIALS_PER_STEP = 10000

# With energies: trials take longer, and a step may end with an outer test.
_TRIALS_PER_STEP_WITH_ENERGY = 400

# The same with atom moves, which need fewer outer tests.
_TRIALS_PER_FLEXIBLE_STEP = 2000


def splitTrials(trials, hasEnergies, isFlexible):
    """Divide a number of trials into steps; yield the number of trials of each step."""
    usual = _TRIALS_PER_STEP
    if hasEnergies:  # no step is shorter, unless all trials are fewer
        least = _TRIALS_PER_FLEXIBLE_STEP if isFlexible else _TRIALS_PER_STEP_WITH_ENERGY
        usual = -(-trials // max(1, trials // least))
    for done in range(0, trials, usual):
        yield min(usual, trials - done)


class Model(NamedTuple):
    """The data shared by all replicas of a run. It can be pickled.

    system : openmm.System
    integrator : TorsionMonteCarloIntegrator, with all moves
    positions : (n, 3) float64 array, nm, the start
    platform : str; properties : dict of str
    hasEnergies : bool, false for hard spheres alone
    key : str, equal for equal Models
    """

    system: openmm.System
    integrator: openmm.Integrator
    positions: np.ndarray
    platform: str
    properties: dict[str, str]
    hasEnergies: bool
    key: str


def makeModel(system, integrator, positions, platform, properties, hasEnergies):
    """Return a Model with a copy of the integrator, without its seed and temperature."""
    integrator = copy.copy(integrator)
    integrator.setRandomNumberSeed(1)
    integrator.setTemperature(300)
    digest = hashlib.sha256(np.ascontiguousarray(positions, dtype="<f8").tobytes())
    for thing in (system, integrator):
        digest.update(openmm.XmlSerializer.serialize(thing).encode())
    digest.update(repr((platform, sorted(properties.items()))).encode())
    return Model(system, integrator, positions, platform, properties, hasEnergies, digest.hexdigest())


class Stop(NamedTuple):
    """A number of trials, and whether a frame is recorded after them."""

    trials: int
    keepsFrame: bool


class Segment(NamedTuple):
    """The work of a replica in one round.

    replica, round : int, from 0
    seed : int, of the replica's random numbers
    temperature : float, K
    checkpoint : bytes, the replica's state; None at the start
    stops : tuple of Stop
    """

    replica: int
    round: int
    seed: int
    temperature: float
    checkpoint: bytes | None
    stops: tuple[Stop, ...]


class KeptFrame(NamedTuple):
    """A recorded conformation.

    positions : (n, 3) float64 array, nm
    energy : float, U in kJ/mol; None for hard spheres alone
    counts : (moves, 4) int array, outcomes of the replica's trials of each move since its start, as in MoveStatistics
    """

    positions: np.ndarray
    energy: float | None
    counts: np.ndarray


class SegmentResult(NamedTuple):
    """The result of a Segment.

    replica, round : int
    checkpoint : bytes
    energy : float, U at the end in kJ/mol; None for hard spheres alone
    frames : list of KeptFrame
    counts : (moves, 4) int array, outcomes of this segment's trials of each move, as in MoveStatistics
    outerTests : (3,) int array: this segment's outer tests attempted and accepted, and trials undone
    stages : (stages, 2) int array: this segment's trials that each stage has decided, and refused
    seconds : float, time of the segment; secondsInSteps : float, the integrator's part of it
    """

    replica: int
    round: int
    checkpoint: bytes
    energy: float | None
    frames: list[KeptFrame]
    counts: np.ndarray
    outerTests: np.ndarray
    stages: np.ndarray
    seconds: float
    secondsInSteps: float


class Stopped(Exception):
    """Raised by a Segment that was stopped."""


class Workplace:
    """Runs Segments of one Model, in any thread.

    Equal Segments give equal results anywhere, apart from times. A Workplace keeps the Context of each replica that it
    has run: a replica that has not run elsewhere since continues without loading its checkpoint. Loading would make the
    integrator compute all energies again, which takes as long as thousands of trials.

    noteTrials : function, called with the number of trials after each step
    """

    def __init__(self, model, most=None):
        """Take a Model, and the largest number of Contexts to keep, those used last; None: all."""
        self.model = model
        self._most = most
        self._replicas = {}  # in the order of their last use
        self._lock = Lock()
        self._isStopped = Event()
        self.noteTrials = lambda trials: None

    def stop(self):
        """Make running and later Segments raise Stopped after their next step."""
        self._isStopped.set()

    def run(self, segment):
        """Run a Segment; return a SegmentResult. No other Segment of the same replica may run at the same time."""
        with self._lock:
            replica = self._replicas.pop(segment.replica, None)
        if replica is None or segment.checkpoint is None:
            replica = _Replica(self.model, segment.seed, self._isStopped)
        result = replica.run(segment, self.noteTrials)
        with self._lock:
            self._replicas[segment.replica] = replica
            while self._most is not None and len(self._replicas) > self._most:
                del self._replicas[next(iter(self._replicas))]
        return result


_workplaces: dict[str, Workplace] = {}

# A process of a cluster runs all replicas in turn, and must not keep all their Contexts.
_MOST_CONTEXTS = 32


def runSegment(model, segment):
    """Run a Segment of a Model in this process's only Workplace, which belongs to the Model used last."""
    if model.key not in _workplaces:
        _workplaces.clear()
    return _workplaces.setdefault(model.key, Workplace(model, _MOST_CONTEXTS)).run(segment)


class _Replica:
    """The Context of one replica."""

    def __init__(self, model, seed, isStopped):
        """Begin at the start. The Event is set to stop."""
        self._isStopped = isStopped
        self._hasEnergies = model.hasEnergies
        self._integrator = copy.copy(model.integrator)
        self._integrator.setRandomNumberSeed(seed)
        platform = openmm.Platform.getPlatformByName(model.platform)
        self._context = openmm.Context(model.system, self._integrator, platform, model.properties)
        self._context.setPositions(model.positions)
        self._checkpoint = None  # the current state

    def run(self, segment, noteTrials):
        """Run a Segment of this replica."""
        begun = perf_counter()
        if segment.checkpoint != self._checkpoint:
            self._context.loadCheckpoint(segment.checkpoint)
        self._checkpoint = b""  # unknown until the end
        self._integrator.setTemperature(segment.temperature * unit.kelvin)
        counts, outerTests, stages = self._counts(), self._outerTests(), self._stages()
        frames, secondsInSteps = [], 0.0
        for stop in segment.stops:
            start = perf_counter()
            for trials in splitTrials(stop.trials, self._hasEnergies, self._integrator.displacesParticles()):
                if self._isStopped.is_set():
                    raise Stopped
                self._integrator.setTrialsPerStep(trials)
                self._integrator.step(1)
                noteTrials(trials)
            secondsInSteps += perf_counter() - start
            if stop.keepsFrame:
                frames.append(KeptFrame(self._positions(), self._energy(), self._counts()))
        energy = self._energy()  # before the checkpoint, after which all energies are computed again
        self._checkpoint = self._context.createCheckpoint()
        return SegmentResult(
            segment.replica,
            segment.round,
            self._checkpoint,
            energy,
            frames,
            self._counts() - counts,
            self._outerTests() - outerTests,
            self._stages() - stages,
            perf_counter() - begun,
            secondsInSteps,
        )

    def _counts(self):
        return np.array([self._integrator.getMoveStatistics(move) for move in range(self._integrator.getNumMoves())])

    def _outerTests(self):
        statistics = self._integrator.getOuterStatistics()
        return np.array([statistics.attempted, statistics.accepted, statistics.trialsTakenBack])

    def _stages(self):
        found = [(stage.computed, stage.refused) for stage in self._integrator.getStageStatistics()]
        return np.array(found, dtype=np.int64).reshape(-1, 2)

    def _positions(self):
        return self._context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)

    def _energy(self):
        return self._integrator.getPotentialEnergy(self._context) if self._hasEnergies else None
