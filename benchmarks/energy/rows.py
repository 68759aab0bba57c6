"""What is measured of energies: the work of a trial, whole trials, growth with the number of atoms."""

import copy
import json
from functools import cached_property
from typing import NamedTuple

import numpy as np
from racing.course import Course, measure, summarizeTimes
from racing.platforms import CPU, whyNot
from racing.races import ALL_CHAINS, INSTRUCTION_SETS, OURS, Moves

from .proteins import REACTION_FIELD, TEMPERATURE, Evaluator, Method, choosePlatform

# Groups of rows.
WORK, TRIALS, GROWTH = "work", "trials", "growth"

# Contestants.
STAGES = f"{OURS}-stages"
ONE_ENERGY, TWO_ENERGIES = "OpenMM CPU, one energy", "OpenMM CPU, two energies"
FOREIGN = "OpenMM CPU, energies of free trials"

SIDE_CHAIN = Moves("sidechain-step", 10.0)
WINDOW = Moves("biased", 1.0, 8)
PIVOT = Moves("gaussian", 1.0)
SMALL_PIVOT = Moves("gaussian", 0.1)  # which long chains allow, too
MOVE_NAMES = {
    str(SIDE_CHAIN): "χ, 10°",
    str(WINDOW): "open window of 8, 1°",
    str(PIVOT): "pivot, 1°",
    str(SMALL_PIVOT): "pivot, 0.1°",
}

WORK_TRIALS, WHOLE_TRIALS = 3000, 100000
_BLOCK = 500
_RECORDED = 12  # trials whose energies OpenMM evaluates
_RECORDED_OF_LARGE = 3
_LARGE = 4000  # atoms
_OPENMM_STEPS = 3  # of 100 trials, where each trial takes OpenMM an energy
_OTHERS_TRIALS = 30
_STEP = 100  # trials
_STEPS = 20  # of a turn


class Prepared:
    """A protein when it is asked for, and what of it is made once: files for the program, OpenMM's Contexts."""

    def __init__(self, read):
        """Take a function that returns the SampledProtein, or what stands for one."""
        self._read = read
        self._files = {}
        self._evaluators = {}

    @cached_property
    def protein(self):
        """What the function returns."""
        return self._read()

    def options(self, course, method):
        """Return the program's options of a Method."""
        folder = course.folder
        if not self._files:
            self._files["--chain"] = folder / f"energy-scene-{id(self)}"
            self.protein.makeScene().write(self._files["--chain"])
        if method.name not in self._files:
            self._files[method.name] = folder / f"energy-{id(self)}-{len(self._files)}"
            self.protein.readTerms(method).write(self._files[method.name])
        return {"--chain": self._files["--chain"], "--energy": self._files[method.name]}

    def evaluator(self, method, platformName):
        """Return the Evaluator of a Method on a platform."""
        key = method.name, platformName
        if key not in self._evaluators:
            system = self.protein.makeSystem(method, sterics=False)
            self._evaluators[key] = Evaluator(system, platformName)
        return self._evaluators[key]


class WorkRow(NamedTuple):
    """The energy work of trials without a clash: by the library's paths, and by OpenMM on the same trials."""

    name: str
    prepared: Prepared
    method: Method
    moves: Moves
    trials: int = WORK_TRIALS
    group: str = WORK
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return f"{self.name}, {self.method.name}, {MOVE_NAMES[str(self.moves)]}"

    def run(self, course: Course, seed: int):
        """Return an entry for each contestant.

        Raises
        ------
        ProgramError
            if contestants compute other energies
        """
        contestants = [*(f"{OURS}-{name}" for name in INSTRUCTION_SETS), STAGES]
        size = len(self.prepared.protein.positions)
        recorded = _RECORDED if size < _LARGE else _RECORDED_OF_LARGE
        lines = _runProgram(self, course, seed, contestants, course.recordFile(), recorded)
        record = _readRecord(course.recordFile())
        errors = _errorsOf(record, self.prepared.evaluator(self.method, "Reference"))
        entries = [{**line, **(errors(record) if line["contestant"] != STAGES else {})} for line in lines]
        if whyNot(CPU) is None:
            entries += _runOpenMM(self, lines[0], record, errors)
        return entries


class GrowthRow(NamedTuple):
    """The energy work of trials without a clash in copies of a protein that are linked to one chain."""

    name: str
    prepared: Prepared
    moves: Moves
    trials: int = WORK_TRIALS
    method: Method = REACTION_FIELD
    group: str = GROWTH
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return f"{self.name}, {self.moves}"

    def run(self, course: Course, seed: int):
        """Return an entry for each contestant."""
        return _runProgram(self, course, seed, [OURS, STAGES], None, 0)


class WholeRow(NamedTuple):
    """Whole trials by Simulation.step, with the moves of the example; and two energies a trial, as others do it."""

    name: str
    prepared: Prepared
    method: Method = REACTION_FIELD
    trials: int = WHOLE_TRIALS
    group: str = TRIALS
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return f"{self.name}, {self.method.name}"

    def run(self, course: Course, seed: int):
        """Return an entry for each contestant."""
        trials = course.trials or self.trials
        simulations = {
            name: self.prepared.protein.makeSimulation(self.method, seed, isNative)
            for name, isNative in ((OURS, True), (FOREIGN, False))
        }
        steps = {OURS: max(1, min(_STEPS, trials // _STEP)), FOREIGN: 1}
        times = {name: [] for name in (*simulations, TWO_ENERGIES)}
        others = _TwoEnergies(self.prepared.protein, self.method, seed)
        for simulation in simulations.values():
            simulation.step(1)
            simulation.integrator.resetMoveStatistics()
        turns = max(1, trials // (_STEP * steps[OURS]))
        foreignTurns = {round(k * turns / _OPENMM_STEPS) for k in range(_OPENMM_STEPS)}
        for turn in range(turns):
            for name, simulation in simulations.items():
                if name == OURS or turn in foreignTurns:
                    count = steps[name] * _STEP
                    times[name].append(measure(simulation.step, steps[name])[1] / count)
            if turn in foreignTurns:
                times[TWO_ENERGIES] += others.run(_OTHERS_TRIALS // _OPENMM_STEPS)
        entries = []
        for name, ofOne in times.items():
            entry = {
                "group": self.group,
                "chain": self.name,
                "method": self.method.name,
                "moves": "the example's",
                "particles": len(self.prepared.protein.positions),
                "seed": seed,
                "asked": trials,
                "trials": len(ofOne) * (steps[name] * _STEP if name in steps else 1),
                "contestant": name,
                **summarizeTimes(ofOne),
            }
            if name in simulations:
                entry.update(describeTrials(simulations[name].integrator))
            entries.append(entry)
        return entries


def describeTrials(integrator):
    """Return what became of the trials: how many clashed, and how many each stage refused."""
    moves = [integrator.getMoveStatistics(move) for move in range(integrator.getNumMoves())]
    attempted = sum(move.attempted for move in moves)
    return {
        "attempted": attempted,
        "clashed": sum(move.clashed for move in moves),
        "accepted": sum(move.accepted for move in moves) / max(1, attempted),
        "stages": {
            stage.stage: {"computed": stage.computed, "refused": stage.refused}
            for stage in integrator.getStageStatistics()
        },
    }


class _TwoEnergies:
    """Trials as a Monte Carlo move makes them that knows nothing of what it changes: an energy before, one after."""

    def __init__(self, protein, method, seed):
        self._evaluator = Evaluator(protein.makeSystem(method, sterics=False), *_nameOf(choosePlatform()))
        self._positions = protein.positions
        self._random = np.random.default_rng(seed)
        self._moved = _movedBy(protein)

    def run(self, trials):
        """Return the microseconds of each of some trials."""
        return [measure(self._try)[1] for _ in range(trials)]

    def _try(self):
        before = self._evaluator.energy(self._positions)
        (near, far), atoms = self._moved[self._random.integers(len(self._moved))]
        angle = np.radians(self._random.uniform(-1, 1))
        trial = _turned(self._positions, near, far, atoms, angle)
        change = self._evaluator.energy(trial) - before
        if change < 0 or self._random.random() < np.exp(-change / (8.314462618e-3 * TEMPERATURE)):
            self._positions = trial


def _nameOf(platform):
    return (platform[0].getName(),)


def _movedBy(protein):
    """Return the axis of each torsion, and the atoms that it turns."""
    scene = protein.makeScene()
    children = [[] for _ in scene.links]
    for number, link in enumerate(scene.links):
        if link.parent >= 0:
            children[link.parent].append(number)
    moved = []
    for number, link in enumerate(scene.links):
        if link.parent >= 0:
            behind = [number]
            for other in behind:
                behind += children[other]
            moved.append(((link.near, link.far), np.flatnonzero(np.isin(scene.particleLinks, behind))))
    return moved


def _turned(positions, near, far, atoms, angle):
    """Return positions with some atoms turned about the line between two of them."""
    axis = positions[far] - positions[near]
    axis = axis / np.linalg.norm(axis)
    arms = positions[atoms] - positions[near]
    along = np.outer(arms @ axis, axis)
    turned = copy.copy(positions)
    turned[atoms] = positions[near] + along + np.cos(angle) * (arms - along) + np.sin(angle) * np.cross(axis, arms)
    return turned


# ---- The program ----


def _runProgram(row, course, seed, contestants, record, recorded):
    """Let the program run a row; return an entry for each contestant that has its own instructions here."""
    trials = course.trials or row.trials
    options = {
        "--measure": "energy",
        **row.prepared.options(course, row.method),
        **row.moves.options(),
        "--seed": seed,
        "--trials": trials,
        "--block": min(_BLOCK, trials),
        "--temperature": TEMPERATURE,
        "--contestants": ",".join(contestants),
        "--record": record,
        "--recorded": recorded,
    }
    common = {"group": row.group, "chain": row.name, "method": row.method.name, "moves": str(row.moves)}
    lines = [{**line, **common, "asked": trials} for line in course.program.race(options)]
    return [line for line in lines if line["contestant"].removeprefix(f"{OURS}-") in (line["isa"], OURS, "stages")]


class _Recorded(NamedTuple):
    """A trial: positions before and in it, (n, 3) float64 arrays in nm; U before it and its change, kJ/mol."""

    before: np.ndarray
    after: np.ndarray
    energy: float
    change: float


def _readRecord(path):
    """Return the trials that the program wrote, particles in the order of the source."""
    first, *lines = [json.loads(line) for line in path.read_text(encoding="ascii").splitlines()]
    order = np.argsort(first["names"])
    trials, state, energy = [], None, 0.0
    for line in lines:
        if "state" in line:
            state, energy = np.array(line["state"]).reshape(-1, 3)[order], line["energy"]
        else:
            trials.append(_Recorded(state, np.array(line["trial"]).reshape(-1, 3)[order], energy, line["change"]))
    return trials


def _errorsOf(record, reference):
    """Return a function that compares energies of the trials with those of the Reference platform."""
    known = {}

    def evaluate(positions):
        if id(positions) not in known:
            known[id(positions)] = reference.energy(positions)
        return known[id(positions)]

    def compare(trials):
        energies = [trial.energy - evaluate(own.before) for trial, own in zip(trials, record, strict=True)]
        changes = [
            trial.change - (evaluate(own.after) - evaluate(own.before))
            for trial, own in zip(trials, record, strict=True)
        ]
        return {
            "energy": evaluate(record[0].before),
            "energyError": max(map(abs, energies)),
            "changeError": {"largest": max(map(abs, changes)), "rms": float(np.sqrt(np.mean(np.square(changes))))},
        }

    return compare


def _runOpenMM(row, line, record, compare):
    """Return an entry for one energy, and one for two energies a trial."""
    evaluator = row.prepared.evaluator(row.method, CPU)
    one, two, found = [], [], []
    evaluator.energy(record[0].after)  # not timed: lists of neighbours are made
    for trial in record:
        before, timeBefore = measure(evaluator.energy, trial.before)
        after, timeAfter = measure(evaluator.energy, trial.after)
        one.append(timeAfter)
        two.append(timeBefore + timeAfter)
        found.append(trial._replace(energy=before, change=after - before))
    common = {
        key: line[key]
        for key in ("group", "chain", "method", "moves", "particles", "torsions", "seed", "asked", "trials")
    }
    return [
        {**common, "contestant": ONE_ENERGY, **summarizeTimes(one), **compare(found)},
        {**common, "contestant": TWO_ENERGIES, **summarizeTimes(two)},
    ]
