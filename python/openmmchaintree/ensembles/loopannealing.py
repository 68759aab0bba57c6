"""Anneals grown loops in a force field."""

import random
import warnings

import numpy as np
import openmm
from openmm import unit

from ..defaultmoves import addDefaultMoves
from ..loops import AnnealedLoops
from ..notes import NoteWarning
from ..openmmchaintree import TorsionMonteCarloIntegrator
from .basins import findBasins
from .loopgrower import LoopGrower
from .loopscene import makeLoopScene

_FALL = 0.8  # of the trials; the others quench
_QUENCH = 50  # by which the temperature is divided
_STAGES = 40  # of constant temperature


class LoopAnnealing:
    """A loop that grows, and a Context that anneals it."""

    def __init__(self, topology, positions, name, system, seed):
        self._topology, self._positions = topology, np.asarray(positions, dtype=np.float64)
        seed = seed or random.SystemRandom().randrange(1, 2**31 - 1)
        self._scene = makeLoopScene(topology, self._positions, name, None, None, system)
        self._grower = LoopGrower(self._scene.growth, name, np.random.default_rng(seed))
        self._scene.system.addForce(self._scene.force)
        self._integrator = TorsionMonteCarloIntegrator(300)
        self._integrator.setRandomNumberSeed(seed)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", NoteWarning)
            addDefaultMoves(self._integrator, topology, self._scene.system)
        platform = openmm.Platform.getPlatformByName("Reference")
        self._context = openmm.Context(self._scene.system, self._integrator, platform)

    def anneal(self, starts, temperature, hottest, trials):
        """Anneal the given positions, and as many grown loops as `starts`; temperatures in K. Return AnnealedLoops."""
        native = self.annealGiven(temperature, hottest, trials)
        temperatures = _schedule(temperature, hottest)
        found = [self._run(self._grower.next().positions, temperatures, trials) for _ in range(starts)]
        positions, energies = map(np.array, zip(*found, strict=True))
        return AnnealedLoops(
            self._topology,
            positions,
            energies,
            self._distances(positions),
            findBasins(positions[:, self._scene.backbone]),
            native,
            self._grower.grown,
            self._grower.runs,
        )

    def annealGiven(self, temperature, hottest, trials):
        """Anneal the given positions; return positions (nm), energy (kJ/mol) and distance (nm) as of AnnealedLoops."""
        positions, energy = self._run(self._positions, _schedule(temperature, hottest), trials)
        return positions, energy, float(self._distances(positions[np.newaxis])[0])

    def _run(self, positions, temperatures, trials):
        """Return the positions (nm) and the energy (kJ/mol) after annealing."""
        self._context.setPositions(positions)
        perStage = max(1, trials // len(temperatures))
        self._integrator.setTrialsPerStep(perStage)
        for kelvin in temperatures:
            self._integrator.setTemperature(kelvin)
            self._integrator.step(1)
        state = self._context.getState(positions=True)
        energy = self._integrator.getPotentialEnergy(self._context)
        return state.getPositions(asNumpy=True).value_in_unit(unit.nanometer), energy

    def _distances(self, positions):
        backbone = self._scene.backbone
        squares = np.sum((positions[:, backbone] - self._positions[backbone]) ** 2, axis=2)
        return np.sqrt(squares.mean(axis=1))


def _schedule(temperature, hottest):
    """Return the temperatures of all stages, K."""
    falling = round(_FALL * _STAGES)
    quench = np.geomspace(temperature, temperature / _QUENCH, _STAGES - falling)
    return np.concatenate((np.geomspace(hottest, temperature, falling), quench)).tolist()
