"""How many independent radii of gyration a second moves give of a loose chain of hard spheres."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import openmm
from openmm import app, unit
from openmmchaintree import TorsionMonteCarloIntegrator, addDefaultMoves
from racing.course import Course, measure, summarizeTimes
from racing.races import ALL_CHAINS, OURS

from .autocorrelation import statisticalInefficiency
from .moverows import Move, bend, turn
from .proteins import BACKBONE, TEMPERATURE, positionsOf
from .rows import Prepared

COILS = "coils"  # the group of rows

COIL_TRIALS = 600000
_STEP = 200  # trials
_UNFOLDING = 200000  # trials that a folded protein is loose after
_LEAST = 4  # steps

LOCAL = "local moves alone"
COIL_MOVES = {
    LOCAL: bend(15, 300),
    "backbone drawn anew, alone": turn(BACKBONE, 180),
    "addDefaultMoves, disordered": Move(
        "", lambda i, weight, protein, system: addDefaultMoves(i, protein.topology, system, disordered=True)
    ),
}


class CoilRow(NamedTuple):
    """A protein without energy, unfolded, by moves."""

    name: str
    prepared: Prepared
    moves: Sequence[str] = tuple(COIL_MOVES)
    trials: int = COIL_TRIALS
    group: str = COILS
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return self.name

    def run(self, course: Course, seed: int):
        """Return an entry for each of the moves."""
        trials, protein = course.trials or self.trials, self.prepared.protein
        system = openmm.System()
        for atom in protein.topology.atoms():
            system.addParticle(atom.element.mass)
        system.addForce(protein.makeForce())
        start = _Chain(protein, system, protein.positions, turn(BACKBONE, 180), seed)
        start.run(min(trials, _UNFOLDING))
        entries = []
        for name in self.moves:
            chain = _Chain(protein, system, start.positions(), COIL_MOVES[name], seed)
            times, radii = chain.run(trials)
            summary = summarizeTimes(times)
            apart = _STEP * float(statisticalInefficiency(radii[:, np.newaxis])[0])
            entries.append(
                {
                    "group": self.group,
                    "chain": self.name,
                    "method": "hard spheres",
                    "particles": len(protein.positions),
                    "seed": seed,
                    "asked": trials,
                    "contestant": OURS,
                    "moves": name,
                    "trials": len(times) * _STEP,
                    **summary,
                    "rg": float(radii.mean()),
                    "apart": {"rg": apart},
                    "rate": {"rg": 1e6 / (summary["microseconds"] * apart)},
                }
            )
        return entries


class _Chain:
    """A Simulation of hard spheres by one Move."""

    def __init__(self, protein, system, positions, move, seed):
        integrator = TorsionMonteCarloIntegrator(TEMPERATURE * unit.kelvin)
        integrator.setRandomNumberSeed(seed)
        integrator.setTrialsPerStep(_STEP)
        move.add(integrator, 1.0, protein, system)
        reference = openmm.Platform.getPlatformByName("Reference")
        self._simulation = app.Simulation(protein.topology, system, integrator, reference)
        self._simulation.context.setPositions(positions)

    def run(self, trials):
        """Return the times of steps, µs a trial, and the radii of gyration after them, nm."""
        times, radii = [], []
        for _ in range(max(_LEAST, trials // _STEP)):
            _, microseconds = measure(self._simulation.step, 1)
            times.append(microseconds / _STEP)
            radii.append(float(np.sqrt(self.positions().var(axis=0).sum())))
        return times, np.array(radii)

    def positions(self):
        """Return the present positions, nm."""
        return positionsOf(self._simulation.context)
