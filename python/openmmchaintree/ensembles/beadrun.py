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
from ..sterics import createStericExclusionForce
from .chainshape import ChainShape, shapesOf
from .independentframes import IndependentRun

_DECIDING = ("radius of gyration", "end-to-end distance")  # of whose effective sample sizes the least counts
_TRIALS_PER_RESIDUE = 0.5  # between frames at first, less than one independent conformer needs


def sampleBeads(topology, system, positions, temperature, seed, conformers, maxTrials):
    """Sample a chain from these positions (nm) on, until there are enough conformers; return the Ensemble."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NoteWarning)
        force = createStericExclusionForce(topology, positions, system=system)
    if force.getNumBallJoints() == 0:
        raise InputError("nothing can move: the chain is a single residue, or a domain holds all of it")
    system.addForce(force)
    integrator = TorsionMonteCarloIntegrator(temperature)
    integrator.setRandomNumberSeed(seed)
    addDefaultMoves(integrator, topology, system)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(setBondLengths(force, positions, MEAN_BOND))
    masses = np.array([system.getParticleMass(i).value_in_unit(unit.dalton) for i in range(len(positions))])
    run = IndependentRun(
        context,
        integrator,
        max(10, int(_TRIALS_PER_RESIDUE * len(positions))),
        lambda found: (found - found.mean(axis=0)).astype(np.float32),
        lambda frames: shapesOf(frames, masses).byName(),
        _DECIDING,
    )
    found = run.sample(conformers, maxTrials)
    shapes = ChainShape(*found.values.values())
    return Ensemble(
        topology,
        found.frames,
        shapes,
        found.estimates,
        found.effectiveSampleSize,
        found.trials,
        found.isComplete,
        np.arange(len(positions)),
    )
