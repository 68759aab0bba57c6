"""Removing the clashes of a start: spheres grow from small ones, and overlaps may only shrink."""

import openmm
from openmm import unit

from ..errors import InputError
from ..graphs import connectedParts
from ..naming import nameAtom
from ..notes import listFirst
from ..openmmchaintree import TorsionMonteCarloIntegrator

_SCALES = (0.4, 0.6, 0.75, 0.85, 0.93, 1.0)  # of radii
_FEWEST_TRIALS = 200  # between looks at clashes, else one for each torsion
_LOOKS = 300  # at each scale


def removeClashes(force, system, topology, positions, addMoves, temperature, seed, mayStay=None):
    """Sample until nothing clashes that can be moved apart.

    Spheres are hard. A pair that clashes has its overlap as limit, which shrinks with the overlap.

    Parameters
    ----------
    force : StericExclusionForce
        of the System
    system : openmm.System
        with the energies under which to move
    topology : openmm.app.Topology
    positions : (n, 3) array
        nm
    addMoves : callable
        adds moves to an integrator
    temperature : float
        K
    seed : int
    mayStay : callable, optional
        whether positions (nm) without clashes are a start; default: all are

    Returns
    -------
    (n, 3) float64 array
        nm

    Raises
    ------
    InputError
        if clashes stay; it names the first ones
    """
    pieces = rigidPieces(force, system)
    radii = [force.getParticleParameters(i) for i in range(force.getNumParticles())]
    integrator = TorsionMonteCarloIntegrator(temperature)
    integrator.setRandomNumberSeed(seed)
    integrator.setStericMode(TorsionMonteCarloIntegrator.Hard)
    integrator.setTrialsPerStep(max(_FEWEST_TRIALS, force.getNumTorsions()))
    addMoves(integrator)
    try:
        _setRadii(force, radii, _SCALES[0])
        context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
        context.setPositions(positions)
        for scale in _SCALES:
            _setRadii(force, radii, scale)
            force.updateParametersInContext(context)
            left = _relax(force, context, integrator, pieces, mayStay)
    finally:
        _setRadii(force, radii, 1)
    if len(left):
        atoms = list(topology.atoms())
        pairs = [" – ".join(str(nameAtom(atoms[atom])) for atom in pair) for pair in left]
        raise InputError(f"{len(left):,} clashes of the start cannot be removed ({listFirst(pairs, '; ')})")
    return _positionsOf(context)


def movingClashes(force, context, pieces):
    """Return the clashes, an (m, 2) int array, whose particles lie in different rigid pieces."""
    pairs, _ = force.getClashes(context)
    return pairs[pieces[pairs[:, 0]] != pieces[pairs[:, 1]]]


def rigidPieces(force, system):
    """Return for each particle the number of its rigid piece, as an int array: fixed particles are one piece."""
    axes = {frozenset(force.getTorsionParticles(i)[1:3]) for i in range(force.getNumTorsions())}
    bonds = [force.getBondParticles(i) for i in range(force.getNumBonds())]
    bonds = [bond for bond in bonds if frozenset(bond) not in axes]
    fixed = [i for i in range(system.getNumParticles()) if system.getParticleMass(i).value_in_unit(unit.dalton) == 0]
    return connectedParts(system.getNumParticles(), [*bonds, *((fixed[0], other) for other in fixed[1:])])


def _relax(force, context, integrator, pieces, mayStay):
    """Sample until nothing clashes, or for a limited number of trials; return the clashes that stay."""
    for _ in range(_LOOKS):
        left = movingClashes(force, context, pieces)
        if len(left) == 0 and (mayStay is None or mayStay(_positionsOf(context))):
            break
        force.restartLimits(context)
        integrator.step(1)
    return left


def _positionsOf(context):
    return context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)


def _setRadii(force, parameters, scale):
    for particle, (radius, role) in enumerate(parameters):
        force.setParticleParameters(particle, scale * radius, role)
