"""Measure what trials in implicit solvent cost, and how near what they see is to U; see docs/benchmark.md.

PYTHONPATH=build/package python benchmarks/solvent.py --markdown solvent.md --picture solvent.png
"""

import sys

import numpy as np
from energies import describeTrials
from energytables import FOREIGN, ONE_ENERGY, findWrong
from measure import CPU, OURS, Row, hasCPU, makeParser, medianTime, run, timed
from proteins import (
    IMPLICIT_SOLVENT,
    NO_CUTOFF,
    SIDE_CHAINS,
    TRIALS_PER_OUTER_TEST,
    positionsOf,
    prepare,
)
from solventtables import BLOCKS, CUTOFFS, NO_SOLVENT, OUTER_TEST, makeTables

GROUPS = {
    "solvent": "whole trials by Simulation.step, ours and with OpenMM's energies",
    "whole": "one whole energy",
    "standins": "whole trials by cutoffs of the stand-in and trials of an outer test",
}

_FILES = ("1ubi_h.pdb", "5dfr_h.pdb")
_RUNS, _WARM_TRIALS = 3, 200000
_SOLVENT_TRIALS, _STAND_IN_TRIALS, _QUICK_TRIALS = 40000, 20000, 400

_TURN = 2000  # trials
_OPENMM_TURNS = 3
_FOREIGN_TRIALS = 10  # of a turn; each asks OpenMM
_PROBED = 40  # outer tests of a turn
_TINY = 1e-6  # degrees, the angle of a trial that changes next to nothing


class _Sampler:
    """A Simulation whose trials are timed in turns."""

    def __init__(self, simulation, trials=TRIALS_PER_OUTER_TEST):
        """Take a Simulation, and the number of trials of its steps."""
        self.simulation, self.integrator, self._trialsPerStep = simulation, simulation.integrator, trials
        self.times = []
        self.integrator.setTrialsPerStep(1)
        simulation.step(1)
        self.integrator.setTrialsPerStep(trials)
        self.integrator.resetMoveStatistics()

    def run(self, trials):
        """Time about `trials` trials."""
        steps = max(1, trials // self._trialsPerStep)
        self.times.append(timed(self.simulation.step, steps)[1] / (steps * self._trialsPerStep))


def _solventRow(name, protein):
    """Return the Row of whole trials in implicit solvent, in turns with OpenMM's energies of them."""

    def measure(course, seed):
        trials, one = course.trials or _SOLVENT_TRIALS, protein()
        system = one.makeSystem(IMPLICIT_SOLVENT)
        samplers = {
            OURS: _Sampler(one.makeSimulation(system, seed)),
            NO_SOLVENT: _Sampler(one.makeSimulation(one.makeSystem(NO_CUTOFF), seed)),
            FOREIGN: _Sampler(one.makeSimulation(system, seed, native=False), _FOREIGN_TRIALS),
        }
        turns = max(1, trials // _TURN)
        openMMTurns = {round(k * turns / _OPENMM_TURNS) for k in range(_OPENMM_TURNS)}
        for turn in range(turns):
            for contestant, sampler in samplers.items():
                if contestant != FOREIGN:
                    sampler.run(min(_TURN, trials))
                elif turn in openMMTurns:
                    sampler.run(_FOREIGN_TRIALS)
        common = _describe(name, one)
        entries = [{**common, "contestant": key, **medianTime(one.times)} for key, one in samplers.items()]
        ours = samplers[OURS].integrator
        entries[0].update(describeTrials(ours), outer=_combineOuter([ours.getOuterStatistics()]))
        return entries

    return Row("solvent", name, measure)


def _describe(name, protein, moves="the example's"):
    return {"chain": name, "method": IMPLICIT_SOLVENT.name, "moves": moves, "particles": len(protein.positions)}


def _wholeRow(name, protein):
    """Return the Row of one whole energy: an outer test, with all that it keeps, in turns with an energy of OpenMM's.

    A step with a test after each trial that turns next to nothing is compared with a step with a single test.
    """

    def measure(course, seed):
        tests, one = min(_PROBED, course.trials or _PROBED), protein()
        system = one.makeSystem(IMPLICIT_SOLVENT)
        simulation = one.makeSimulation(system, seed, moves=((1.0, _TINY, SIDE_CHAINS),))
        integrator = simulation.integrator
        integrator.setTrialsPerStep(tests)
        simulation.step(1)
        evaluate = one.evaluator(IMPLICIT_SOLVENT, CPU if hasCPU() else "Reference")
        evaluate(one.positions)  # not timed: it prepares what the next ones need
        ours, others = [], []
        for _ in range(_OPENMM_TURNS):
            spent = []
            for size in (1, tests):
                integrator.setTrialsPerOuterTest(size)
                simulation.step(1)
                spent.append(timed(simulation.step, 1)[1])
            ours.append((spent[0] - spent[1]) / max(1, tests - 1))
            others.append(timed(evaluate, one.positions)[1])
        positions = positionsOf(simulation.context)
        energy = one.evaluator(IMPLICIT_SOLVENT, "Reference")(positions)
        found = integrator.getPotentialEnergy(simulation.context), evaluate(positions)
        return [
            {**_describe(name, one), "contestant": key, **medianTime(times), "energy": energy, "energyError": error}
            for key, times, error in zip(
                (OUTER_TEST, ONE_ENERGY), (ours, others), (abs(value - energy) for value in found), strict=True
            )
        ]

    return Row("whole", name, measure)


def _standInRow(name, protein):
    """Return the Row of whole trials by cutoffs of the stand-in and trials of an outer test, in turns."""

    def measure(course, seed):
        trials, one = course.trials or _STAND_IN_TRIALS, protein()
        system, samplers = one.makeSystem(IMPLICIT_SOLVENT), {}
        for cutoffs in CUTOFFS:
            simulation = one.makeSimulation(system, seed)
            simulation.integrator.setStandInCutoffs(*cutoffs)
            samplers[cutoffs] = _Sampler(simulation)
        parts = {(cutoffs, block): ([], []) for cutoffs in CUTOFFS for block in BLOCKS}
        for _ in range(max(1, trials // _TURN)):
            for (cutoffs, block), (times, tests) in parts.items():
                sampler = samplers[cutoffs]
                sampler.integrator.setTrialsPerOuterTest(block)
                sampler.integrator.resetMoveStatistics()
                sampler.run(min(_TURN, trials))
                times.append(sampler.times[-1])
                tests.append(sampler.integrator.getOuterStatistics())
        return [
            {
                **_describe(name, one),
                "contestant": f"{born} / {pairs} nm, m = {block}",
                **{"bornCutoff": born, "pairCutoff": pairs, "block": block},
                **medianTime(times),
                "outer": _combineOuter(tests),
            }
            for ((born, pairs), block), (times, tests) in parts.items()
        ]

    return Row("standins", name, measure)


def _combineOuter(parts):
    """Return what several OuterStatistics say together; the differences' standard deviation is in kJ/mol."""
    tests = np.array([part.attempted for part in parts])
    means = np.array([part.meanDifference for part in parts])
    squares = np.sum((tests - 1) * np.array([part.standardDeviation for part in parts]) ** 2)
    count = int(tests.sum())
    squares += np.sum(tests * (means - np.sum(tests * means) / max(1, count)) ** 2)
    kept, deviation = sum(part.accepted for part in parts), float(np.sqrt(squares / max(1, count - 1)))
    return {"tests": count, "kept": kept, "deviation": deviation}


def _plan(options):
    proteins, skipped = prepare(options, _FILES, _QUICK_TRIALS, IMPLICIT_SOLVENT)
    makers = {"solvent": _solventRow, "whole": _wholeRow, "standins": _standInRow}
    return [makers[group](*one) for group in options.rows for one in proteins.items()], skipped


def main(arguments=None):
    """Run the script; return its exit status."""
    about = (
        "Measure what trials of proteins in AMBER14 with GBn2 cost, outer tests included, in turns with OpenMM's CPU "
        "platform with one thread; and how near stand-ins are to the energy."
    )
    parser = makeParser("solvent.py", about, GROUPS, _RUNS, _FILES, _WARM_TRIALS)
    return run(parser, arguments, _plan, makeTables, "solventpicture", findWrong)


if __name__ == "__main__":
    sys.exit(main())
