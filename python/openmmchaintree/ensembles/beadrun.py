"""A run of a chain of beads, until it has enough independent conformers."""

import warnings

import numpy as np
import openmm
from openmm import unit

from ..bondlengths import setBondLengths
from ..calvados import MEAN_BOND
from ..defaultmoves import addDefaultMoves
from ..ensemble import Ensemble
from ..errors import InputError
from ..notes import NoteWarning
from ..openmmchaintree import TorsionMonteCarloIntegrator
from ..statistics.equilibration import findEquilibration
from ..statistics.estimates import estimate
from ..sterics import createStericExclusionForce
from .chainshape import shapesOf

_DECIDING = ("radius of gyration", "end-to-end distance")  # of whose effective sample sizes the least counts
_FIRST_FRAMES = 200
_LARGEST_GROWTH = 2  # of the number of frames, from one estimate to the next
_MOST_FRAMES_PER_CONFORMER = 16  # beyond it every second frame is dropped
_TRIALS_PER_RESIDUE = 0.5  # between frames at first, less than one independent conformer needs
_MARGIN = 1.1  # of the frames that an estimate asks for


class BeadRun:
    """A Context that samples a chain, and its frames: every `stride` trials one, some of the first ones left out."""

    def __init__(self, topology, system, positions, temperature, seed):
        """Begin at these positions."""
        self._topology, self._count = topology, len(positions)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", NoteWarning)
            force = createStericExclusionForce(topology, positions, system=system)
        if force.getNumBallJoints() == 0:
            raise InputError("nothing can move: the chain is a single residue, or a domain holds all of it")
        system.addForce(force)
        integrator = TorsionMonteCarloIntegrator(temperature)
        integrator.setRandomNumberSeed(seed)
        addDefaultMoves(integrator, topology, system)
        self._stride = max(10, int(_TRIALS_PER_RESIDUE * self._count))
        integrator.setTrialsPerStep(self._stride)
        self._integrator = integrator
        self._context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
        self._context.setPositions(setBondLengths(force, positions, MEAN_BOND))
        masses = [system.getParticleMass(i).value_in_unit(unit.dalton) for i in range(self._count)]
        self._masses = np.array(masses)
        self._frames, self._trials = [], 0

    def sample(self, conformers, maxTrials):
        """Run until there are enough independent conformers, and return the Ensemble."""
        wanted = _FIRST_FRAMES
        while True:
            while len(self._frames) < wanted and self._trials < maxTrials:
                self._addFrame()
            shapes = shapesOf(np.array(self._frames), self._masses)
            start, isEquilibrated = findEquilibration([shapes.radiusOfGyration, shapes.endToEndDistance])
            estimates = {name: estimate([values[start:]]) for name, values in shapes.byName().items()}
            deciding = [estimates[name].effectiveSampleSize or 0.0 for name in _DECIDING]
            sample = min(deciding) if isEquilibrated else 0.0
            isComplete = sample >= conformers
            if isComplete or self._trials >= maxTrials:
                break
            if len(self._frames) > _MOST_FRAMES_PER_CONFORMER * max(conformers, _FIRST_FRAMES):
                self._thin()
            factor = _MARGIN * conformers / max(sample, 1e-9)
            wanted = int(len(self._frames) * min(max(factor, _MARGIN), _LARGEST_GROWTH)) + 1
        chosen = np.unique(np.linspace(start, len(self._frames) - 1, conformers).round().astype(int))
        positions = np.array([self._frames[i] for i in chosen])
        return Ensemble(self._topology, positions, shapes.of(chosen), estimates, sample, self._trials, isComplete)

    def _addFrame(self):
        self._integrator.step(1)
        self._trials += self._stride
        state = self._context.getState(positions=True)
        positions = state.getPositions(asNumpy=True).value_in_unit(unit.nanometer)
        self._frames.append((positions - positions.mean(axis=0)).astype(np.float32))

    def _thin(self):
        """Drop every second frame, and take half as many from now on."""
        self._frames = self._frames[1::2]
        self._stride *= 2
        self._integrator.setTrialsPerStep(self._stride)
