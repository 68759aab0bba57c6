"""Atom moves beside the default moves: bond lengths and angles change, too."""

import openmm
from openmm import unit

from ..moveadder import NamedMove
from ..openmmchaintree import TorsionMonteCarloIntegrator

# The share of atom moves among all trials.
ATOM_SHARE = 0.5

LARGEST_SIZE = 0.03  # nm, more than the loosest atoms need
_USUAL_SCALE = 0.3  # at which adaptation begins, and which rare classes of atoms keep
_ADAPTING_TRIALS = 30000


def addAtomMove(integrator, moves):
    """Add an atom move to an integrator with a list of NamedMove; return the NamedMove."""
    weight = ATOM_SHARE / (1 - ATOM_SHARE) * sum(move.weight for move in moves)
    move = integrator.addAtomMove(weight, LARGEST_SIZE * unit.nanometer)
    integrator.setMoveScale(move, _USUAL_SCALE)
    return NamedMove("atoms", weight)


def findScales(integrator, system, positions, platform):
    """Return the scales to which an atom move adapts in trials from some positions, in a separate Context.

    integrator : TorsionMonteCarloIntegrator, whose temperature, seed and steric mode count
    platform : the platform and its properties, as openmm.Context takes them
    """
    sampler = TorsionMonteCarloIntegrator(integrator.getTemperature())
    sampler.setRandomNumberSeed(integrator.getRandomNumberSeed())
    sampler.setStericMode(integrator.getStericMode())
    addAtomMove(sampler, [NamedMove("", 1.0)])
    sampler.setAdaptMoveSizes(True)
    sampler.setTrialsPerStep(_ADAPTING_TRIALS)
    context = openmm.Context(system, sampler, *platform)
    context.setPositions(positions)
    sampler.step(1)
    return sampler.getMoveScales(0)
