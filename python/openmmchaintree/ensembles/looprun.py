"""Grows loops until their weights hold enough independent conformers, and samples from each."""

import math
import random

import numpy as np
import openmm
from openmm import unit

from ..loops import LoopEnsemble
from ..openmmchaintree import TorsionMonteCarloIntegrator
from .basins import findBasins
from .loopgrower import LoopGrower
from .loopscene import makeLoopScene

_FIRST_RUNS = 100  # before the first estimate
_CLOSED_STEP, _HOP, _CHI_STEP = math.radians(10), 0.3, math.radians(15)
_TRIALS_PER_STEP = 500


class LoopRun:
    """A loop that grows, and a Context that samples it."""

    def __init__(self, topology, positions, name, model, temperature, seed):
        self._topology, self._positions = topology, np.asarray(positions, dtype=np.float64)
        seed = seed or random.SystemRandom().randrange(1, 2**31 - 1)
        self._random = np.random.default_rng(seed)
        self.scene = makeLoopScene(topology, self._positions, name, model, temperature)
        self._kT = (unit.MOLAR_GAS_CONSTANT_R * temperature * unit.kelvin).value_in_unit(unit.kilojoule_per_mole)
        self._grower = LoopGrower(self.scene.growth, name, self._random)
        self._context, self._integrator = self._makeContext(temperature, seed)
        self.loops, self.logWeights, self.energies = [], [], []

    def _makeContext(self, temperature, seed):
        scene = self.scene
        scene.system.addForce(scene.force)
        integrator = TorsionMonteCarloIntegrator(temperature)
        integrator.setRandomNumberSeed(seed)
        integrator.addClosedMove(0.7, _CLOSED_STEP, None, _HOP)
        if scene.rotamers:
            integrator.addDrawnMove(0.15, scene.rotamers)
        if scene.chis:
            integrator.addTorsionMove(0.15, _CHI_STEP, scene.chis)
        integrator.setTrialsPerStep(_TRIALS_PER_STEP)
        context = openmm.Context(scene.system, integrator, openmm.Platform.getPlatformByName("Reference"))
        context.setPositions(self._positions)
        return context, integrator

    def grow(self):
        """Make a run of growth; add its loop, if one was left."""
        grown = self._grower.attempt()
        if grown is None:
            return
        self._context.setPositions(grown.positions)
        energy = self._integrator.getPotentialEnergy(self._context)
        self.loops.append(grown.positions[self.scene.moving])
        self.energies.append(energy)
        self.logWeights.append(grown.logWeight - grown.logDensity - energy / self._kT)

    def sample(self, conformers, trials, maxGrown):
        """Grow loops until there are enough, draw conformers from them, and sample each; return the LoopEnsemble."""
        wanted = _FIRST_RUNS
        while True:
            while self._grower.runs < wanted and len(self.loops) < maxGrown:
                self.grow()
            sample = effectiveSize(self.logWeights)
            isComplete = sample >= conformers
            if isComplete or len(self.loops) >= maxGrown:
                break
            wanted = self._grower.runs + max(_FIRST_RUNS, int(0.1 * self._grower.runs))
        parents = drawByWeight(self.logWeights, conformers, self._random)
        positions, energies = map(np.array, zip(*(self._relax(parent, trials) for parent in parents), strict=True))
        backbones = positions[:, self.scene.backbone]
        squares = np.sum((backbones - self._positions[self.scene.backbone]) ** 2, axis=2)
        return LoopEnsemble(
            self._topology,
            positions,
            energies,
            np.sqrt(squares.mean(axis=1)),
            findBasins(backbones),
            parents,
            sample,
            len(self.loops),
            self._grower.runs,
            isComplete,
        )

    def _relax(self, loop, trials):
        """Sample from a grown loop; return positions (nm) and the energy (kJ/mol)."""
        positions = self._positions.copy()
        positions[self.scene.moving] = self.loops[loop]
        if trials == 0:
            return positions, self.energies[loop]
        self._context.setPositions(positions)
        self._integrator.step(-(-trials // _TRIALS_PER_STEP))
        state = self._context.getState(positions=True)
        energy = self._integrator.getPotentialEnergy(self._context)
        return state.getPositions(asNumpy=True).value_in_unit(unit.nanometer), energy


def effectiveSize(logWeights):
    """Return (Σ w)² / Σ w² of logarithms of weights; 0 without any."""
    if not len(logWeights):
        return 0.0
    weights = np.exp(np.array(logWeights) - np.max(logWeights))
    return float(weights.sum() ** 2 / np.sum(weights**2))


def drawByWeight(logWeights, count, generator):
    """Return sorted indices drawn by weight, at equal distances of the summed weights."""
    weights = np.exp(np.array(logWeights) - np.max(logWeights))
    places = (np.arange(count) + generator.random()) / count * weights.sum()
    return np.minimum(np.searchsorted(np.cumsum(weights), places, side="right"), len(weights) - 1)
