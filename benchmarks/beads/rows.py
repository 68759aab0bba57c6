"""What is measured of chains of beads."""

import time
from typing import NamedTuple

import numpy as np
import openmm
from energy.autocorrelation import statisticalInefficiency
from racing.course import Course, measure, summarizeTimes
from racing.platforms import CPU, whyNot
from racing.races import ALL_CHAINS, OURS

from .chains import REFERENCE, PivotRun, compactWalk, positionsOf, radiusOfGyration, stairs
from .disordered import BOND, TEMPERATURE, makeDynamicsSystem, makePairForces, makeSequence

PIVOTS, DISORDERED = "pivots", "disordered"  # groups of rows
COMPACT, COIL = "random compact", "coil"
LANGEVIN = "Langevin dynamics"  # the contestant

_SPACING, _RADIUS = 0.4, 0.1  # nm: the spheres of the race of torsions, in another unit
_TRIALS, _BLOCK = 20000, 2000  # in a step, after which positions reach the Context
_EQUILIBRATION = 30  # trials a bead of a coil

_HARD_RADIUS = 0.17  # nm: nearer to each other than 0.34 nm, all pairs have 30 kT at least
_MOVES = {
    "pivots": ((1, np.pi),),
    "pivots and small ones": ((0.7, np.pi), (0.3, 0.3)),
}
_TIMESTEP, _FRICTION = 0.01, 0.01  # ps, 1/ps
_LEFT_OUT = 10  # the first of so many parts of a run
_TRIALS_PER_SAMPLE, _STEPS_PER_SAMPLE = 100, 1000


class PivotRow(NamedTuple):
    """Whole trials of the integrator, hard spheres: a ball joint of all is turned by any rotation, or a small one.

    chain : COMPACT or COIL; angle : float, the largest, rad
    """

    chain: str
    particles: int
    angle: float
    group: str = PIVOTS
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return f"{self.chain}, {self.particles:,} beads, {np.degrees(self.angle):.0f}°"

    def run(self, course: Course, seed: int):
        """Return an entry."""
        trials = course.trials or _TRIALS
        run = PivotRun(self._begin(seed), _RADIUS, ((1, self.angle),), seed)
        run.run(1)  # which makes the scene
        size = radiusOfGyration(positionsOf(run.context))
        run.integrator.resetMoveStatistics()
        block = min(_BLOCK, trials)
        run.integrator.setTrialsPerStep(block)
        times = [measure(run.integrator.step, 1)[1] / block for _ in range(trials // block)]
        return [
            {
                "group": self.group,
                "chain": self.chain,
                "particles": self.particles,
                "angle": self.angle,
                "seed": seed,
                "trials": trials,
                "contestant": OURS,
                "accepted": run.accepted(),
                "rg": radiusOfGyration(positionsOf(run.context)),
                "startRg": size,
                **summarizeTimes(times),
            }
        ]

    def _begin(self, seed):
        """Return where a run begins."""
        if self.chain == COMPACT:
            return compactWalk(self.particles, _SPACING, np.random.default_rng(seed))
        run = PivotRun(stairs(self.particles, _SPACING), _RADIUS, ((1, np.pi),), seed)
        run.run(_EQUILIBRATION * self.particles)
        return positionsOf(run.context)


class DisorderedRow(NamedTuple):
    """Radii of gyration of a coarse-grained disordered protein: by pivots, and by Langevin dynamics on one thread.

    ourSeconds, dynamicsSeconds : float, processor time of each way
    """

    length: int
    ourSeconds: float
    dynamicsSeconds: float
    group: str = DISORDERED
    mostChains: int = 1

    def __str__(self) -> str:
        return f"disordered protein, {self.length} beads"

    def run(self, course: Course, seed: int):
        """Return an entry for each way to sample."""
        sequence = makeSequence(self.length)
        entries = []
        for name, moves in _MOVES.items():
            run = PivotRun(stairs(self.length, BOND), _HARD_RADIUS, moves, seed, makePairForces(sequence), TEMPERATURE)
            run.integrator.setTrialsPerStep(_TRIALS_PER_SAMPLE)
            found = _sample(run.context, run.integrator, self.ourSeconds, _TRIALS_PER_SAMPLE)
            entries.append({"contestant": name, "accepted": run.accepted(), **found})
        integrator = openmm.LangevinMiddleIntegrator(TEMPERATURE, _FRICTION, _TIMESTEP)
        integrator.setRandomNumberSeed(seed)
        platform, properties = (CPU, {"Threads": "1"}) if whyNot(CPU) is None else (REFERENCE, {})
        context = openmm.Context(
            makeDynamicsSystem(sequence), integrator, openmm.Platform.getPlatformByName(platform), properties
        )
        # It begins from where ours ended, so that it has nothing to forget.
        context.setPositions(positionsOf(run.context))
        openmm.LocalEnergyMinimizer.minimize(context, maxIterations=100)
        context.setVelocitiesToTemperature(TEMPERATURE, seed)
        found = _sample(context, integrator, self.dynamicsSeconds, _STEPS_PER_SAMPLE, _STEPS_PER_SAMPLE)
        entries.append({"contestant": LANGEVIN, "accepted": None, **found})
        common = {"group": self.group, "chain": str(self), "particles": self.length, "seed": seed}
        return [{**common, **entry} for entry in entries]


def _sample(context, integrator, seconds, perSample, steps=1):
    """Sample radii of gyration for so much processor time; return what an entry says of them."""
    radii, start = [], time.process_time()
    while len(radii) < 2 * _LEFT_OUT or time.process_time() - start < seconds:
        integrator.step(steps)
        radii.append(radiusOfGyration(positionsOf(context)))
    each = (time.process_time() - start) / len(radii)
    kept = np.array(radii[len(radii) // _LEFT_OUT :])
    apart = float(statisticalInefficiency(kept[:, np.newaxis])[0])
    return {
        "microseconds": 1e6 * each / perSample,
        "trials": perSample * len(radii),
        "seconds": each * len(radii),
        "apart": perSample * apart,
        "rate": 1 / (each * apart),
        "rg": float(kept.mean()),
        "rgError": float(kept.std() * np.sqrt(apart / len(kept))),
        "independent": len(kept) / apart,
    }
