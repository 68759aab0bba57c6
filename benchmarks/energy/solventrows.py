"""What is measured of implicit solvent: whole trials, one whole energy, stand-ins by cutoffs; and of expressions."""

from typing import NamedTuple

import numpy as np
import openmm
from openmm import unit
from racing.course import Course, measure, summarizeTimes
from racing.platforms import CPU, whyNot
from racing.races import ALL_CHAINS, OURS

from .proteins import (
    BACKBONE,
    ENDS,
    IMPLICIT_SOLVENT,
    NO_CUTOFF,
    REACTION_FIELD,
    SIDE_CHAINS,
    TEMPERATURE,
    TRIALS_PER_OUTER_TEST,
    Evaluator,
    positionsOf,
)
from .rows import FOREIGN, ONE_ENERGY, Prepared, describeTrials

# Groups of rows.
SOLVENT, WHOLE, STAND_INS, SIZES, EXPRESSIONS = "solvent", "whole", "standins", "sizes", "expressions"

# Contestants.
OUTER_TEST = f"{OURS}, an outer test"
EXPRESSION = f"{OURS}, CustomNonbondedForce"
NO_SOLVENT = f"{OURS}, without solvent"

CUTOFFS = ((0.45, 0.7), (0.55, 0.7), (0.55, 0.8), (0.65, 0.9), (1.0, 1.2))  # of Born sums and of pairs, nm
BLOCKS = (50, 100, 400)  # trials of an outer test

# µs are those of so many trials a run.
SOLVENT_TRIALS, STAND_IN_TRIALS, SIZE_TRIALS, EXPRESSION_TRIALS = 40000, 20000, 24000, 40000

KT = 8.314462618e-3 * TEMPERATURE  # kJ/mol

_TURN = 2000  # trials of a contestant's turn
_OPENMM_TURNS = 3
_FOREIGN_TRIALS = 10  # of a turn; each asks OpenMM
_PROBED = 40  # outer tests of a turn
_LONG = 4000  # trials of an outer test that is hardly ever made
_TINY = 1e-6  # degrees: what a trial turns that changes next to nothing

_MOVES = {"χ, up to 10°": ((1.0, 10, SIDE_CHAINS),), "pivot, up to 1°": ((1.0, 1, BACKBONE),)}
_LOCAL_MOVES = {"χ, up to 10°": ((1.0, 10, SIDE_CHAINS),), "end of a chain, up to 10°": ((1.0, 10, ENDS),)}


class Sampler:
    """A Simulation whose trials are timed in turns, and what became of them."""

    def __init__(self, simulation, trials=TRIALS_PER_OUTER_TEST):
        """Take a Simulation, and the number of trials of its steps."""
        self.simulation = simulation
        self.integrator = simulation.integrator
        self._trialsPerStep = trials
        self.times = []
        self.trials = 0
        self.integrator.setTrialsPerStep(1)
        simulation.step(1)
        self.integrator.setTrialsPerStep(trials)
        self.integrator.resetMoveStatistics()

    def run(self, trials):
        """Time about so many trials."""
        steps = max(1, trials // self._trialsPerStep)
        self.times.append(measure(self.simulation.step, steps)[1] / (steps * self._trialsPerStep))
        self.trials += steps * self._trialsPerStep

    def describe(self):
        """Return what an entry says of times and trials."""
        return {"trials": self.trials, **summarizeTimes(self.times), **describeTrials(self.integrator)}


def describeOuter(statistics):
    """Return what an entry says of outer tests; the difference's standard deviation is in kJ/mol."""
    return {
        "tests": statistics.attempted,
        "kept": statistics.accepted,
        "deviation": statistics.standardDeviation,
    }


def describeStandIn(cutoffs, block):
    """Return what an entry says of a stand-in: cutoffs of Born sums and of pairs, nm, and trials of an outer test."""
    return {
        "contestant": f"{cutoffs[0]} / {cutoffs[1]} nm, m = {block}",
        "bornCutoff": cutoffs[0],
        "pairCutoff": cutoffs[1],
        "block": block,
    }


def describeCommon(row, trials, seed, moves="the example's"):
    """Return what an entry says of a row."""
    return {
        "group": row.group,
        "chain": row.name,
        "method": row.method.name,
        "moves": moves,
        "particles": len(row.prepared.protein.positions),
        "seed": seed,
        "asked": trials,
    }


def _turns(trials):
    """Return how many turns a run has, and in which of them OpenMM has one."""
    turns = max(1, trials // _TURN)
    return turns, {round(k * turns / _OPENMM_TURNS) for k in range(_OPENMM_TURNS)}


class SolventRow(NamedTuple):
    """Whole trials in implicit solvent with the moves of the example, in turns with OpenMM's energies of them."""

    name: str
    prepared: Prepared
    trials: int = SOLVENT_TRIALS
    method = IMPLICIT_SOLVENT
    group: str = SOLVENT
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return self.name

    def run(self, course: Course, seed: int):
        """Return an entry for each contestant."""
        trials, protein = course.trials or self.trials, self.prepared.protein
        samplers = {
            OURS: Sampler(protein.makeSimulation(self.method, seed)),
            NO_SOLVENT: Sampler(protein.makeSimulation(NO_CUTOFF, seed)),
            FOREIGN: Sampler(protein.makeSimulation(self.method, seed, native=False), _FOREIGN_TRIALS),
        }
        turns, openMMTurns = _turns(trials)
        for turn in range(turns):
            for name, sampler in samplers.items():
                if name != FOREIGN:
                    sampler.run(min(_TURN, trials))
                elif turn in openMMTurns:
                    sampler.run(_FOREIGN_TRIALS)
        common = describeCommon(self, trials, seed)
        entries = [{**common, "contestant": name, **sampler.describe()} for name, sampler in samplers.items()]
        entries[0]["outer"] = describeOuter(samplers[OURS].integrator.getOuterStatistics())
        return entries


class WholeEnergyRow(NamedTuple):
    """One whole energy: what an outer test costs us, with all that it keeps, in turns with an energy of OpenMM's.

    A test of one trial that turns next to nothing is compared with one of many such trials, so that the trials are no
    part of it.
    """

    name: str
    prepared: Prepared
    trials: int = _OPENMM_TURNS * _PROBED
    method = IMPLICIT_SOLVENT
    group: str = WHOLE
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return self.name

    def run(self, course: Course, seed: int):
        """Return an entry for each contestant."""
        tests = min(_PROBED, course.trials or _PROBED)
        protein = self.prepared.protein
        simulation = protein.makeSimulation(self.method, seed, moves=((1.0, _TINY, SIDE_CHAINS),))
        integrator = simulation.integrator
        integrator.setTrialsPerStep(tests)
        simulation.step(1)
        evaluators = [self.prepared.evaluator(self.method, CPU)] if whyNot(CPU) is None else []
        for evaluator in evaluators:
            evaluator.energy(protein.positions)  # not timed: it prepares what the next ones need
        ours, others = [], []
        for _ in range(_OPENMM_TURNS):
            spent = []
            for size in (1, tests):
                integrator.setTrialsPerOuterTest(size)
                simulation.step(1)
                spent.append(measure(simulation.step, 1)[1])
            ours.append((spent[0] - spent[1]) / max(1, tests - 1))
            others += [measure(evaluator.energy, protein.positions)[1] for evaluator in evaluators]
        positions = positionsOf(simulation.context)
        energy = self.prepared.evaluator(self.method, "Reference").energy(positions)
        found = {OUTER_TEST: (ours, integrator.getPotentialEnergy(simulation.context))}
        if evaluators:
            found[ONE_ENERGY] = others, evaluators[0].energy(positions)
        common = describeCommon(self, _OPENMM_TURNS * tests, seed)
        return [
            {
                **common,
                "contestant": name,
                "trials": len(times),
                **summarizeTimes(times),
                "energy": energy,
                "energyError": abs(value - energy),
            }
            for name, (times, value) in found.items()
        ]


class StandInRow(NamedTuple):
    """Whole trials by cutoffs of the stand-in and trials of an outer test, in turns."""

    name: str
    prepared: Prepared
    trials: int = STAND_IN_TRIALS
    method = IMPLICIT_SOLVENT
    group: str = STAND_INS
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return self.name

    def run(self, course: Course, seed: int):
        """Return an entry for each pair of cutoffs and each number of trials."""
        trials, protein = course.trials or self.trials, self.prepared.protein
        samplers = {}
        for cutoffs in CUTOFFS:
            simulation = protein.makeSimulation(self.method, seed)
            simulation.integrator.setStandInCutoffs(*cutoffs)
            samplers[cutoffs] = Sampler(simulation)
        parts = {(cutoffs, block): ([], []) for cutoffs in CUTOFFS for block in BLOCKS}
        for _ in range(max(1, trials // _TURN)):
            for (cutoffs, block), (times, tests) in parts.items():
                sampler = samplers[cutoffs]
                sampler.integrator.setTrialsPerOuterTest(block)
                sampler.integrator.resetMoveStatistics()
                sampler.run(min(_TURN, trials))
                times.append(sampler.times[-1])
                tests.append(sampler.integrator.getOuterStatistics())
        entries = []
        for (cutoffs, block), (times, tests) in parts.items():
            entries.append(
                {
                    **describeCommon(self, trials, seed),
                    **describeStandIn(cutoffs, block),
                    "trials": len(times) * min(_TURN, trials),
                    **summarizeTimes(times),
                    "outer": combineOuter(tests),
                }
            )
        return entries


def combineOuter(parts):
    """Return what describeOuter would return of several OuterStatistics taken together."""
    tests = np.array([part.attempted for part in parts])
    means = np.array([part.meanDifference for part in parts])
    squares = np.sum((tests - 1) * np.array([part.standardDeviation for part in parts]) ** 2)
    count = int(tests.sum())
    squares += np.sum(tests * (means - np.sum(tests * means) / count) ** 2)
    return {
        "tests": count,
        "kept": sum(part.accepted for part in parts),
        "deviation": float(np.sqrt(squares / max(1, count - 1))),
    }


class SizeRow(NamedTuple):
    """Trials that move few atoms, in solvent: what they cost apart from outer tests, as proteins grow."""

    name: str
    prepared: Prepared
    moves: str
    trials: int = SIZE_TRIALS
    method = IMPLICIT_SOLVENT
    group: str = SIZES
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return f"{self.name}, {self.moves}"

    def run(self, course: Course, seed: int):
        """Return an entry for the trials, and one for the outer test."""
        trials, protein = course.trials or self.trials, self.prepared.protein
        long = min(_LONG, trials)
        sampler = Sampler(protein.makeSimulation(self.method, seed, moves=_LOCAL_MOVES[self.moves]), long)
        inner, outer = [], []
        for _ in range(max(1, trials // (2 * long))):
            for block in (long, TRIALS_PER_OUTER_TEST):
                sampler.integrator.setTrialsPerOuterTest(min(block, long))
                sampler.run(long)
            one, several = sampler.times[-2:]
            tests = max(2, long // TRIALS_PER_OUTER_TEST)
            outer.append(max(0.0, (several - one) * long / (tests - 1)))
            inner.append(one - outer[-1] / long)
        common = describeCommon(self, trials, seed, self.moves)
        return [
            {**common, "contestant": OURS, **sampler.describe(), **summarizeTimes(inner)},
            {**common, "contestant": OUTER_TEST, "trials": len(outer), **summarizeTimes(outer)},
        ]


class ExpressionRow(NamedTuple):
    """Trials with Lennard-Jones and a reaction field by NonbondedForce, and as a CustomNonbondedForce, in turns."""

    name: str
    prepared: Prepared
    moves: str
    trials: int = EXPRESSION_TRIALS
    method = REACTION_FIELD
    group: str = EXPRESSIONS
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return f"{self.name}, {self.moves}"

    def run(self, course: Course, seed: int):
        """Return an entry for each contestant."""
        trials, protein = course.trials or self.trials, self.prepared.protein
        systems = {name: protein.makeSystem(self.method) for name in (OURS, EXPRESSION)}
        replaceNonbonded(systems[EXPRESSION])
        samplers = {
            name: Sampler(protein.makeSimulationOf(system, seed, moves=_MOVES[self.moves]))
            for name, system in systems.items()
        }
        for _ in range(max(1, trials // _TURN)):
            for sampler in samplers.values():
                sampler.run(min(_TURN, trials))
        plain = Evaluator(protein.makeSystem(self.method, sterics=False), "Reference")
        entries = []
        for name, sampler in samplers.items():
            energy = plain.energy(positionsOf(sampler.simulation.context))
            entries.append(
                {
                    **describeCommon(self, trials, seed, self.moves),
                    "contestant": name,
                    **sampler.describe(),
                    "energy": energy,
                    "energyError": abs(sampler.integrator.getPotentialEnergy(sampler.simulation.context) - energy),
                }
            )
        return entries


EXPRESSION_MOVES, SIZE_MOVES = tuple(_MOVES), tuple(_LOCAL_MOVES)


def replaceNonbonded(system):
    """Put a CustomNonbondedForce with the same energy in the place of the NonbondedForce with a reaction field.

    Exceptions that are not excluded become a CustomBondForce.
    """
    number, nonbonded = next(
        (number, force) for number, force in enumerate(system.getForces()) if isinstance(force, openmm.NonbondedForce)
    )
    cutoff = nonbonded.getCutoffDistance().value_in_unit(unit.nanometer)
    dielectric = nonbonded.getReactionFieldDielectric()
    pairs = openmm.CustomNonbondedForce(
        "4*sqrt(epsilon1*epsilon2)*((s/r)^12 - (s/r)^6) + coulomb*charge1*charge2*(1/r + k*r^2 - c);"
        f"s = 0.5*(sigma1 + sigma2); coulomb = {_COULOMB!r};"
        f"k = {(dielectric - 1) / (2 * dielectric + 1) / cutoff**3!r}; "
        f"c = {3 * dielectric / (2 * dielectric + 1) / cutoff!r}"
    )
    for parameter in ("charge", "sigma", "epsilon"):
        pairs.addPerParticleParameter(parameter)
    for particle in range(nonbonded.getNumParticles()):
        pairs.addParticle(nonbonded.getParticleParameters(particle))
    bonds = openmm.CustomBondForce(f"4*epsilon*((sigma/r)^12 - (sigma/r)^6) + {_COULOMB!r}*product/r")
    for parameter in ("product", "sigma", "epsilon"):
        bonds.addPerBondParameter(parameter)
    for exception in range(nonbonded.getNumExceptions()):
        particle1, particle2, *parameters = nonbonded.getExceptionParameters(exception)
        pairs.addExclusion(particle1, particle2)
        if parameters[0]._value != 0 or parameters[2]._value != 0:
            bonds.addBond(particle1, particle2, parameters)
    pairs.setNonbondedMethod(openmm.CustomNonbondedForce.CutoffNonPeriodic)
    pairs.setCutoffDistance(cutoff)
    system.removeForce(number)
    system.addForce(pairs)
    system.addForce(bonds)


_COULOMB = 138.93545764438198  # kJ nm / (mol e^2), as OpenMM has it
