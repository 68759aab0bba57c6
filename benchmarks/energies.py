"""Measure what energies of trials cost and how exact they are, ours and OpenMM's; see docs/benchmark.md.

PYTHONPATH=build/package python benchmarks/energies.py --markdown energies.md --picture energies.png
"""

import json
import sys

import numpy as np
from energytables import FOREIGN, ONE_ENERGY, STAGES, TWO_ENERGIES, findWrong, makeTables
from forcefield import writeEnergy
from measure import CPU, OURS, Row, hasCPU, makeParser, medianTime, run, timed
from proteins import KT, NO_CUTOFF, REACTION_FIELD, TEMPERATURE, prepare
from race import Moves
from rivals import turnAbout

GROUPS = {
    "work": "the energy work of a trial: a χ, an open window of eight torsions, a pivot",
    "trials": "whole trials by Simulation.step",
}

# The last has no hydrogens and four chains; it takes part in the first group only.
_FILES = ("1ubi_h.pdb", "bpti_h.pdb", "5dfr_h.pdb", "4hhb.pdb")
_OF_WORK_ONLY = ("4hhb",)

_MOVES = {
    "χ, 10°": Moves("sidechain-step", 10.0),
    "open window of 8, 1°": Moves("biased", 1.0, 8),
    "pivot, 1°": Moves("gaussian", 1.0),
}
_SETS = ("avx512", "avx2", "portable")

_RUNS, _WARM_TRIALS = 3, 200000
_WORK_TRIALS, _WHOLE_TRIALS, _QUICK_TRIALS = 3000, 100000, 200
_BLOCK = 500
_STEP, _STEPS = 100, 20  # trials of a step, steps of a turn
_OPENMM_TURNS = 3  # of one step, where each trial takes an energy of OpenMM
_OTHERS_TRIALS = 10  # of a turn


# ---- The energy work of trials without a clash ----


def _workRow(name, protein, method, moves):
    """Return the Row of the energy work: by the library's paths, and by OpenMM on the first of the same trials."""

    def measure(course, seed):
        scene, energy = (course.folder / f"{name}-{words}" for words in ("scene", method.name.replace(" ", "-")))
        if not scene.exists():
            protein().makeScene().write(scene)
        if not energy.exists():
            writeEnergy(energy, protein().makeSystem(method, sterics=False))
        trials, record = course.trials or _WORK_TRIALS, course.folder / "record"
        options = {
            **{"--measure": "energy", "--chain": scene, "--energy": energy, **_MOVES[moves].options()},
            **{"--seed": seed, "--trials": trials, "--block": min(_BLOCK, trials), "--temperature": TEMPERATURE},
            "--contestants": ",".join([*(f"{OURS}-{name}" for name in _SETS), STAGES]),
            **{"--record": record, "--recorded": 12 if len(protein().positions) < 4000 else 3},
        }
        common = {"chain": name, "method": method.name, "moves": moves, "particles": len(protein().positions)}
        lines = course.program.run(options)
        lines = [line for line in lines if line["contestant"].removeprefix(f"{OURS}-") in (line["isa"], "stages")]
        keys = ("contestant", "isa", "microseconds", "mean", "free", "accepted", "terms", "near", "other")
        entries = [{**common, **{key: line[key] for key in keys}} for line in lines]
        recorded = _readRecord(record)
        exact = _exactOf(recorded, protein().evaluator(method, "Reference"))
        for entry in entries:
            if entry["contestant"] != STAGES:
                entry.update(_compare(exact, [trial[2:] for trial in recorded]))
        if hasCPU():
            entries += [{**common, **entry} for entry in _runOpenMM(recorded, exact, protein().evaluator(method, CPU))]
        return entries

    return Row("work", f"{name}, {method.name}, {moves}", measure)


def _readRecord(path):
    """Return the recorded trials: positions before and in the trial, nm, U before it and its change, kJ/mol."""
    first, *lines = [json.loads(line) for line in path.read_text(encoding="ascii").splitlines()]
    order = np.argsort(first["names"])
    trials = []
    for line in lines:
        if "state" in line:
            state, energy = np.array(line["state"]).reshape(-1, 3)[order], line["energy"]
        else:
            trials.append((state, np.array(line["trial"]).reshape(-1, 3)[order], energy, line["change"]))
    return trials


def _exactOf(recorded, evaluate):
    """Return U before each recorded trial and its change, as the Reference platform has them."""
    exact = []
    for before, after, *_ in recorded:
        energy = evaluate(before)
        exact.append((energy, evaluate(after) - energy))
    return exact


def _compare(exact, found):
    """Return the errors of energies and of their changes."""
    (energies, changes), (ours, ourChanges) = zip(*exact, strict=True), zip(*found, strict=True)
    wrong, wrongChanges = (np.abs(np.subtract(a, b)) for a, b in ((ours, energies), (ourChanges, changes)))
    change = {"largest": float(wrongChanges.max()), "rms": float(np.sqrt(np.mean(wrongChanges**2)))}
    return {"energy": energies[0], "energyError": float(wrong.max()), "changeError": change}


def _runOpenMM(recorded, exact, evaluate):
    """Return an entry for one energy of each recorded trial, and one for two."""
    evaluate(recorded[0][1])  # not timed: lists of neighbours are made
    one, two, found = [], [], []
    for before, after, *_ in recorded:
        energy, timeBefore = timed(evaluate, before)
        energyAfter, timeAfter = timed(evaluate, after)
        one.append(timeAfter)
        two.append(timeBefore + timeAfter)
        found.append((energy, energyAfter - energy))
    return [
        {"contestant": ONE_ENERGY, **medianTime(one), **_compare(exact, found)},
        {"contestant": TWO_ENERGIES, **medianTime(two)},
    ]


# ---- Whole trials ----


def _wholeRow(name, protein):
    """Return the Row of whole trials with the moves of the example; and of moves that take two energies a trial."""

    def measure(course, seed):
        trials, one = course.trials or _WHOLE_TRIALS, protein()
        system = one.makeSystem(REACTION_FIELD)
        ours, foreign = (one.makeSimulation(system, seed, native) for native in (True, False))
        for simulation in (ours, foreign):
            simulation.step(1)
            simulation.integrator.resetMoveStatistics()
        evaluate = one.evaluator(REACTION_FIELD, CPU if hasCPU() else "Reference")
        tryTwo = _TwoEnergies(one, evaluate, seed)
        steps = max(1, min(_STEPS, trials // _STEP))
        turns = max(1, trials // (_STEP * steps))
        openMMTurns = {round(k * turns / _OPENMM_TURNS) for k in range(_OPENMM_TURNS)}
        times = {OURS: [], FOREIGN: [], TWO_ENERGIES: []}
        for turn in range(turns):
            times[OURS].append(timed(ours.step, steps)[1] / (steps * _STEP))
            if turn in openMMTurns:
                times[FOREIGN].append(timed(foreign.step, 1)[1] / _STEP)
                times[TWO_ENERGIES] += [timed(tryTwo)[1] for _ in range(_OTHERS_TRIALS)]
        common = {"chain": name, "method": REACTION_FIELD.name, "moves": "the example's"}
        common["particles"] = len(one.positions)
        entries = [{**common, "contestant": name, **medianTime(ofOne)} for name, ofOne in times.items()]
        entries[0].update(describeTrials(ours.integrator))
        return entries

    return Row("trials", name, measure)


def describeTrials(integrator):
    """Return how many trials clashed, how many each stage refused, and how many were accepted."""
    moves = [integrator.getMoveStatistics(move) for move in range(integrator.getNumMoves())]
    stages = integrator.getStageStatistics()
    return {
        **{key: sum(getattr(move, key) for move in moves) for key in ("attempted", "clashed", "accepted")},
        "stages": {stage.stage: {"computed": stage.computed, "refused": stage.refused} for stage in stages},
    }


class _TwoEnergies:
    """A trial of a generic Monte Carlo move: an energy before it, and one after."""

    def __init__(self, protein, evaluate, seed):
        self._evaluate = evaluate
        self._positions = protein.positions
        self._random = np.random.default_rng(seed)
        self._moved = protein.makeScene().movedBy()

    def __call__(self):
        before = self._evaluate(self._positions)
        (near, far), atoms = self._moved[self._random.integers(len(self._moved))]
        x, angle = self._positions, np.radians(self._random.uniform(-1, 1))
        trial = x.copy()
        trial[atoms] = turnAbout(x[near], x[far], x[atoms], angle)
        change = self._evaluate(trial) - before
        if change < 0 or self._random.random() < np.exp(-change / KT):
            self._positions = trial


# ---- The script ----


def _plan(options):
    proteins, skipped = prepare(options, _FILES, _QUICK_TRIALS)
    rows = []
    if "work" in options.rows:
        methods = (REACTION_FIELD, NO_CUTOFF)
        rows += [_workRow(*one, method, moves) for one in proteins.items() for method in methods for moves in _MOVES]
    if "trials" in options.rows:
        rows += [_wholeRow(*one) for one in proteins.items() if one[0] not in _OF_WORK_ONLY]
    return rows, skipped if hasCPU() else [*skipped, "OpenMM's energies: there is no CPU platform here"]


def main(arguments=None):
    """Run the script; return its exit status."""
    about = (
        "Measure what the energies of trials of proteins in AMBER14 cost, by our library of energies with each "
        "instruction set and by OpenMM's CPU platform with one thread, on the same trials; and how far both are from "
        "OpenMM's Reference platform."
    )
    parser = makeParser("energies.py", about, GROUPS, _RUNS, _FILES, _WARM_TRIALS)
    return run(parser, arguments, _plan, makeTables, "energypicture", findWrong)


if __name__ == "__main__":
    sys.exit(main())
