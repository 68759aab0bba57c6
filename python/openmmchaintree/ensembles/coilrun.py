"""A run of flexible residues with all atoms, as random coils, until conformers are independent."""

import warnings
from functools import partial

import numpy as np
import openmm

from ..coil import coilDensities, createCoilForce
from ..densities import rotamerDensities
from ..ensemble import Ensemble
from ..errors import InputError
from ..graphs import neighborLists
from ..moveadder import MoveAdder
from ..movescene import MoveScene
from ..notes import NoteWarning
from ..openmmchaintree import TorsionMonteCarloIntegrator
from ..sterics import createStericExclusionForce
from ..torsions import findTorsions
from .avoidedregions import readRegion
from .biases import readBiases
from .coilshape import CoilShape
from .independentframes import IndependentRun
from .startclashes import removeClashes

_TRIALS_PER_RESIDUE = 2  # between frames at first, less than one independent conformer needs
_BACKBONE_STEP = 30  # degrees
_FLOOR = 0.02  # the share of rotamers that are drawn uniformly
_KINDS = ("phi", "psi", "chi")
_DRAWN, _TURNED, _SIDE_CHAINS = 0.5, 0.2, 0.3  # weights of moves


def sampleCoil(scene, temperature, seed, conformers, maxTrials, tables, avoid, bias):
    """Sample flexible residues, and what moves with them, until there are enough conformers; return the Ensemble.

    Parameters
    ----------
    scene : CoilScene
        other atoms stay in place
    temperature : float
        K
    tables
        as for `createCoilForce`
    avoid : iterable of str
        as `readRegion` reads them
    bias : iterable of str
        as `readBiases` reads them
    """
    topology, positions = scene.topology, scene.positions
    isMoving = scene.isFlexible | scene.isRigid
    system = openmm.System()
    for atom, moves in zip(topology.atoms(), isMoving, strict=True):
        system.addParticle(atom.element.mass if moves and atom.element is not None else float(moves))
    torsions = _torsionsOf(scene, isMoving)
    if not torsions:
        raise InputError("nothing can move: no torsion of flexible residues can turn")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NoteWarning)
        system.addForce(createStericExclusionForce(topology, torsions=torsions, system=system))
    kinds, tables = readBiases(_texts(bias), topology, tables)
    residues = {torsion.residue for torsion in torsions}
    turning = [atom.index for residue in residues for atom in residue.atoms()]
    system.addForce(createCoilForce(topology, temperature, selection=turning, tables=tables, kinds=kinds))
    regions = [readRegion(text) for text in _texts(avoid)]
    for region in regions:
        system.addForce(region.createForce(np.flatnonzero(isMoving)))
    force = system.getForce(0)

    def addMoves(integrator):
        _addMoves(integrator, topology, system, partial(coilDensities, tables=tables, kinds=kinds))

    def isOutside(places):
        return not any((region.holds(places) & isMoving).any() for region in regions)

    start = removeClashes(force, system, topology, positions, addMoves, temperature, seed, isOutside)
    if not isOutside(start):
        raise InputError(f"what moves cannot leave the region to avoid: {', '.join(map(str, regions))}")
    integrator = TorsionMonteCarloIntegrator(temperature)
    integrator.setRandomNumberSeed(seed)
    addMoves(integrator)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(start)
    shape = CoilShape(scene, start, isMoving)
    stride = max(10, int(_TRIALS_PER_RESIDUE * sum(map(len, scene.parts))))
    found = IndependentRun(context, integrator, stride, shape.frameOf, shape.valuesOf, shape.deciding).sample(
        conformers, maxTrials
    )
    estimates = {name: one for name, one in found.estimates.items() if name not in shape.hidden}
    return Ensemble(
        topology,
        shape.whole(found.frames),
        shape.chainShape(found.values),
        estimates,
        found.effectiveSampleSize,
        found.trials,
        found.isComplete,
        shape.trace,
    )


def _texts(given):
    return [given] if isinstance(given, str) else given


def _torsionsOf(scene, isMoving):
    """Return the Torsions that turn: about bonds of flexible atoms, or with only flexible atoms at one end.

    So what is rigid stays rigid.
    """
    found = findTorsions(scene.topology, kinds=_KINDS, fixed=~isMoving if not isMoving.all() else None).torsions
    bonds = [(bond[0].index, bond[1].index) for bond in scene.topology.bonds()]
    neighbors = neighborLists(len(isMoving), bonds)

    def canTurn(second, third):
        if scene.isFlexible[[second, third]].any():
            return True
        sides = (set(neighbors[second]) - {third}, set(neighbors[third]) - {second})
        return any(scene.isFlexible[list(side)].all() for side in sides)

    return [torsion for torsion in found if canTurn(*torsion.particles[1:3])]


def _addMoves(integrator, topology, system, findBackbones):
    """Add moves of loose chains: φ and ψ drawn from the density that is sampled, small turns, and rotamers."""
    scene = MoveScene(topology, system)
    adder = MoveAdder(integrator, set())
    backbones, sideChains = scene.torsions["peptide backbones"], scene.torsions["side chains"]
    adder.begin("φ/ψ", 1.0)
    drawn = adder.findDrawn(findBackbones, scene)
    adder.drawOrTurn("backbones, by residue", "by residue", _DRAWN, drawn, backbones)
    adder.turn("backbones where there is little room", _TURNED, _BACKBONE_STEP, backbones)
    adder.begin("χ", 1.0)
    drawn = adder.findDrawn(partial(rotamerDensities, floor=_FLOOR, parts=False), scene)
    adder.drawOrTurn("side chains from rotamer to rotamer", "rotamers", _SIDE_CHAINS, drawn, sideChains)
