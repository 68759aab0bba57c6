"""What one replica does for a while, as a function of what it is given."""

import copy
import hashlib
from threading import Event, Lock
from time import perf_counter
from typing import NamedTuple

import numpy as np
import openmm
from openmm import unit

# So often can a run of hard spheres be interrupted, whatever the number of trials between frames.
_TRIALS_PER_STEP = 10000

# With energies, where trials take longer, and a step may end by a look at the whole energy.
_TRIALS_PER_STEP_WITH_ENERGY = 400


def splitTrials(trials, hasEnergies):
    """Yield the numbers of trials of the steps that a number of trials is made of."""
    usual = _TRIALS_PER_STEP
    if hasEnergies:  # no step is shorter, unless all trials are fewer
        usual = -(-trials // max(1, trials // _TRIALS_PER_STEP_WITH_ENERGY))
    for done in range(0, trials, usual):
        yield min(usual, trials - done)


class Model(NamedTuple):
    """What all replicas of a run have in common. It can be pickled.

    system : openmm.System
    integrator : TorsionMonteCarloIntegrator, with all moves
    positions : (n, 3) float64 array, nm, the start
    platform : str; properties : dict of str
    hasEnergies : bool, whether there is more than hard spheres
    key : str, the same for Models that are the same
    """

    system: openmm.System
    integrator: openmm.Integrator
    positions: np.ndarray
    platform: str
    properties: dict[str, str]
    hasEnergies: bool
    key: str


def makeModel(system, integrator, positions, platform, properties, hasEnergies):
    """Return a Model. Of the integrator a copy is taken, without its seed and temperature."""
    integrator = copy.copy(integrator)
    integrator.setRandomNumberSeed(1)
    integrator.setTemperature(300)
    digest = hashlib.sha256(np.ascontiguousarray(positions, dtype="<f8").tobytes())
    for thing in (system, integrator):
        digest.update(openmm.XmlSerializer.serialize(thing).encode())
    digest.update(repr((platform, sorted(properties.items()))).encode())
    return Model(system, integrator, positions, platform, properties, hasEnergies, digest.hexdigest())


class Stop(NamedTuple):
    """Trials without a pause, and whether a frame is kept after them."""

    trials: int
    keepsFrame: bool


class Segment(NamedTuple):
    """What a replica is to do in one round.

    replica, round : int, from 0
    seed : int, of the replica's random numbers
    temperature : float, K
    checkpoint : bytes, where the replica is; None at the start
    stops : tuple of Stop
    """

    replica: int
    round: int
    seed: int
    temperature: float
    checkpoint: bytes | None
    stops: tuple[Stop, ...]


class KeptFrame(NamedTuple):
    """Positions, a float64 array of shape (n, 3) in nm, and U in kJ/mol, None of hard spheres alone."""

    positions: np.ndarray
    energy: float | None


class SegmentResult(NamedTuple):
    """What became of a Segment.

    replica, round : int
    checkpoint : bytes
    energy : float, U at the end in kJ/mol; None of hard spheres alone
    frames : list of KeptFrame
    counts : (moves, 4) int array, of the trials of each move, as in MoveStatistics, in this segment
    outerTests : (3,) int array: outer tests attempted and accepted, and trials taken back, in this segment
    seconds : float, that it took; secondsInSteps : float, that the integrator took of it
    """

    replica: int
    round: int
    checkpoint: bytes
    energy: float | None
    frames: list[KeptFrame]
    counts: np.ndarray
    outerTests: np.ndarray
    seconds: float
    secondsInSteps: float


class Stopped(Exception):
    """What a Segment raises that was to stop."""


class Workplace:
    """Runs Segments of one Model, in any thread.

    The same Segment gives the same result wherever it runs, but for the times that it took. A Workplace keeps the
    Context of each replica that it has met: one that has not been elsewhere since goes on at once, without a look at
    its checkpoint. Loading one would make all that is known of energies anew, and take as long as thousands of trials.
    """

    def __init__(self, model, most=None):
        """Take a Model, and how many Contexts are kept at most; None: all. Those that ran last are kept."""
        self.model = model
        self._most = most
        self._replicas = {}  # the one that ran last comes last
        self._lock = Lock()
        self._isStopped = Event()

    def stop(self):
        """Have Segments that run, and all others, raise Stopped after their next step."""
        self._isStopped.set()

    def run(self, segment):
        """Run a Segment; return a SegmentResult. No other Segment of the same replica may run at that time."""
        with self._lock:
            replica = self._replicas.pop(segment.replica, None)
        if replica is None or segment.checkpoint is None:
            replica = _Replica(self.model, segment.seed, self._isStopped)
        result = replica.run(segment)
        with self._lock:
            self._replicas[segment.replica] = replica
            while self._most is not None and len(self._replicas) > self._most:
                del self._replicas[next(iter(self._replicas))]
        return result


_workplaces: dict[str, Workplace] = {}

# A process of a cluster meets any replica now and then, and must not keep them all.
_MOST_CONTEXTS = 32


def runSegment(model, segment):
    """Run a Segment of a Model in the one Workplace of this process, which is of the last Model that was met."""
    if model.key not in _workplaces:
        _workplaces.clear()
    return _workplaces.setdefault(model.key, Workplace(model, _MOST_CONTEXTS)).run(segment)


class _Replica:
    """The Context of one replica."""

    def __init__(self, model, seed, isStopped):
        """Stand at the start. An Event says when to stop."""
        self._isStopped = isStopped
        self._hasEnergies = model.hasEnergies
        self._integrator = copy.copy(model.integrator)
        self._integrator.setRandomNumberSeed(seed)
        platform = openmm.Platform.getPlatformByName(model.platform)
        self._context = openmm.Context(model.system, self._integrator, platform, model.properties)
        self._context.setPositions(model.positions)
        self._checkpoint = None  # where it stands

    def run(self, segment):
        """Run a Segment of this replica."""
        begun = perf_counter()
        if segment.checkpoint != self._checkpoint:
            self._context.loadCheckpoint(segment.checkpoint)
        self._checkpoint = b""  # none, until the end
        self._integrator.setTemperature(segment.temperature * unit.kelvin)
        counts, outerTests = self._counts(), self._outerTests()
        frames, secondsInSteps = [], 0.0
        for stop in segment.stops:
            start = perf_counter()
            for trials in splitTrials(stop.trials, self._hasEnergies):
                if self._isStopped.is_set():
                    raise Stopped
                self._integrator.setTrialsPerStep(trials)
                self._integrator.step(1)
            secondsInSteps += perf_counter() - start
            if stop.keepsFrame:
                frames.append(KeptFrame(self._positions(), self._energy()))
        energy = self._energy()  # before the checkpoint, after which all is computed anew
        self._checkpoint = self._context.createCheckpoint()
        return SegmentResult(
            segment.replica,
            segment.round,
            self._checkpoint,
            energy,
            frames,
            self._counts() - counts,
            self._outerTests() - outerTests,
            perf_counter() - begun,
            secondsInSteps,
        )

    def _counts(self):
        return np.array([self._integrator.getMoveStatistics(move) for move in range(self._integrator.getNumMoves())])

    def _outerTests(self):
        statistics = self._integrator.getOuterStatistics()
        return np.array([statistics.attempted, statistics.accepted, statistics.trialsTakenBack])

    def _positions(self):
        return self._context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)

    def _energy(self):
        return self._integrator.getPotentialEnergy(self._context) if self._hasEnergies else None
