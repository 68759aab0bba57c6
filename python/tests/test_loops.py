"""Loops: grown and closed, their weights against moves, and loops that cannot be sampled."""

import math
import warnings

import numpy as np
import openmm
import pytest
from openmm import app
from openmm.unit import nanometer
from openmmchaintree import (
    InputError,
    LoopGrowth,
    TorsionDensity,
    TorsionMonteCarloIntegrator,
    createStericExclusionForce,
    sampleLoop,
)
from openmmchaintree.ensembles.basins import findBasins
from openmmchaintree.ensembles.looprun import LoopRun, drawByWeight, effectiveSize
from openmmchaintree.loopnames import findLoop
from openmmchaintree.statistics.estimates import estimate
from openmmchaintree.structures.structure import readStructure
from peptides import makePeptides
from scenes import realStructurePath

_VILLIN = readStructure(app.__path__[0] + "/data/test.pdb")


def _atomsOf(topology, first, last):
    return np.array([atom.index for atom in topology.atoms() if first <= int(atom.residue.id) <= last])


def _peptide(count, loop, radius):
    """Return positions, System, force and growth of a loop (first, last residue) of alanines, drawn uniformly."""
    topology, positions = makePeptides(("ACE", *["ALA"] * count, "NME"))
    moving = _atomsOf(topology, *loop)
    isFixed = np.isin(np.arange(len(positions)), moving, invert=True)
    radii = np.full(len(positions), radius)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        force = createStericExclusionForce(topology, positions, radii=radii, fixed=isFixed, closures="loops")
    system = openmm.System()
    for fixed in isFixed:
        system.addParticle(0 if fixed else 1)
    pairs = [(index, index + 1) for index in range(0, force.getNumTorsions(), 2)]
    uniform = TorsionDensity.fromTable(np.ones((1, 1)))
    return positions, system, force, LoopGrowth(system, force, positions, pairs, [uniform] * len(pairs))


def test_grown_loops_are_closed_free_of_clashes_and_reproducible():
    ensemble = sampleLoop(_VILLIN.topology, _VILLIN.positions, "18-25", conformers=6, seed=3, trials=500, maxGrown=8)
    again = sampleLoop(_VILLIN.topology, _VILLIN.positions, "18-25", conformers=6, seed=3, trials=500, maxGrown=8)
    assert np.array_equal(ensemble.positions, again.positions)
    assert ensemble.grown == 8 and not ensemble.isComplete and ensemble.effectiveSampleSize <= 8
    moving = _atomsOf(_VILLIN.topology, 18, 25)
    fixed = np.setdiff1d(np.arange(len(_VILLIN.positions)), moving)
    bonds = np.array([[atom.index for atom in bond] for bond in _VILLIN.topology.bonds()])
    angles = [(i, j) for i, j in _pairsTwoBondsApart(bonds)]
    force = createStericExclusionForce(_VILLIN.topology, _VILLIN.positions)
    system = openmm.System()
    for _ in _VILLIN.positions:
        system.addParticle(1)
    system.addForce(force)
    integrator = openmm.VerletIntegrator(0.001)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    for positions in ensemble.positions:
        assert np.array_equal(positions[fixed], _VILLIN.positions[fixed])
        for pairs in (bonds, angles):
            first, second = np.array(pairs).T
            before = np.linalg.norm(_VILLIN.positions[first] - _VILLIN.positions[second], axis=1)
            assert np.abs(np.linalg.norm(positions[first] - positions[second], axis=1) - before).max() < 1e-9
        context.setPositions(positions)
        assert not np.isin(force.getClashes(context)[0], moving).any()
    assert len({positions[moving].tobytes() for positions in ensemble.positions}) == 6


def _pairsTwoBondsApart(bonds):
    neighbors = {}
    for i, j in bonds.tolist():
        neighbors.setdefault(i, []).append(j)
        neighbors.setdefault(j, []).append(i)
    return sorted({(i, j) for near in neighbors.values() for i in near for j in near if i < j})


@pytest.mark.parametrize("count, loop, radius", [(6, (2, 5), 0.1), (7, (2, 6), 0.16)])
def test_weighted_means_are_those_of_closed_moves(count, loop, radius):
    positions, system, force, growth = _peptide(count, loop, radius)
    grown = [growth.grow(seed, 4, 6, 1) for seed in range(1, 1001)]
    weights = np.array([math.exp(one.logWeight) for one in grown])
    assert effectiveSize(np.log(weights[weights > 0])) > 100
    system.addForce(force)
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(1)
    integrator.addClosedMove(1, 1.5, None, 0.6)
    integrator.setTrialsPerStep(20)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    angles = []
    for one in grown:
        context.setPositions(one.positions)
        angles.append(force.getTorsionAngles(context))
    context.setPositions(positions)
    sampled = []
    for _ in range(6000):
        integrator.step(1)
        sampled.append(force.getTorsionAngles(context))
    ratios = []
    for function in (np.cos, np.sin):
        values, series = function(angles), function(sampled)
        means = weights @ values / weights.sum()
        errors = np.sqrt(weights**2 @ (values - means) ** 2) / weights.sum()
        for k, (mean, error) in enumerate(zip(means, errors, strict=True)):
            moved = estimate([series[500:, k]])
            ratios.append((mean - moved.mean) / math.hypot(error, moved.standardError))
    assert np.abs(ratios).max() < 4 and np.sqrt(np.mean(np.square(ratios))) < 1.5


def test_the_mean_weight_does_not_depend_on_the_size_of_the_population():
    _, _, _, growth = _peptide(7, (2, 6), 0.13)
    means, errors = [], []
    for population, backboneDraws, count in ((1, 3, 6000), (30, 12, 300)):
        weights = np.exp([growth.grow(seed, population, backboneDraws, 1).logWeight for seed in range(1, count)])
        means.append(weights.mean())
        errors.append(weights.std() / math.sqrt(count))
    assert abs(means[0] - means[1]) < 4 * math.hypot(*errors)
    assert max(errors[0] / means[0], errors[1] / means[1]) < 0.25


def test_moves_keep_the_ensemble_of_weighted_loops():
    run = LoopRun(_VILLIN.topology, _VILLIN.positions, "22-25", "coil", 298.0, 4)
    while len(run.loops) < 300:
        run.grow()
    assert run.scene.growth.getNumDrawnTorsions() == run.scene.force.getNumTorsions()
    weights = np.exp(np.array(run.logWeights) - max(run.logWeights))
    weights /= weights.sum()
    drawn = drawByWeight(run.logWeights, 400, np.random.default_rng(1))
    before, after = np.array(run.loops), np.array([run._relax(loop, 500)[0][run.scene.moving] for loop in drawn])
    means = np.einsum("i,ijk->jk", weights, before)
    errors = np.sqrt(np.einsum("i,ijk->jk", weights**2, (before - means) ** 2) + after.var(axis=0) / len(after))
    ratios = ((after.mean(axis=0) - means) / np.maximum(errors, 1e-9))[errors > 1e-6]
    assert np.abs(ratios).max() < 4


def test_weights_and_basins():
    assert effectiveSize([]) == 0 and effectiveSize([-1000.0] * 7) == pytest.approx(7)
    drawn = drawByWeight(np.log([1, 2, 1, 4]), 8000, np.random.default_rng(1))
    assert np.bincount(drawn) == pytest.approx([1000, 2000, 1000, 4000], abs=1)
    backbones = np.zeros((4, 2, 3))
    backbones[1, :, 0] = 0.099
    backbones[2, :, 1] = 0.101
    backbones[3, :, 1] = 0.15
    assert findBasins(backbones).tolist() == [0, 0, 1, 1]


# ---- Loops that cannot be sampled ----


@pytest.mark.parametrize(
    "name, message",
    [
        ("", "is no loop"),
        ("63", "is no loop"),
        ("A:63:74", "is no loop"),
        ("63-74,80-90", "is no loop"),
        ("B:20-26", "there is no chain B; there are A"),
        ("20-99", "there is no residue 99"),
        ("20A-26", "there is no residue 20A"),
        ("20-21", "at least 3 residues"),
        ("26-20", "at least 3 residues"),
        ("1-10", "reaches an end"),
        ("30-36", "reaches an end"),
    ],
)
def test_wrong_names(name, message):
    topology, positions = makePeptides(["ALA"] * 36)
    for chain in topology.chains():
        chain.id = "A"
    with pytest.raises(InputError, match=message):
        findLoop(topology, positions, name)


def test_chains_gaps_bonds_and_insertion_codes():
    topology, positions = makePeptides(["ALA"] * 12, ["ALA"] * 12)
    first, second = topology.chains()
    first.id, second.id = "A", "B"
    for chain in (first, second):
        for number, residue in enumerate(chain.residues(), 1):
            residue.id = str(number)
    with pytest.raises(InputError, match="several chains.*A:3-8"):
        findLoop(topology, positions, "3-8")
    assert [residue.id for residue in findLoop(topology, positions, "B:3-8")] == list("345678")
    residues = list(first.residues())
    residues[4].insertionCode, residues[4].id = "A", "4"
    assert findLoop(topology, positions, "A:4A-8")[0] is residues[4]
    torn = positions.copy()
    torn[[atom.index for residue in residues[6:] for atom in residue.atoms()]] += 1
    with pytest.raises(InputError, match="gap in the chain between A:ALA 6 and A:ALA 7"):
        findLoop(topology, torn, "A:4-9")
    with pytest.raises(InputError, match="gap in the chain"):
        findLoop(topology, torn, "A:7-10")
    atoms = {(atom.residue.chain.id, atom.residue.id, atom.name): atom for atom in topology.atoms()}
    topology.addBond(atoms["A", "6", "CB"], atoms["B", "6", "CB"])
    with pytest.raises(InputError, match="A:ALA 6 CB is bonded to B:ALA 6 CB"):
        findLoop(topology, positions, "A:4-9")
    findLoop(topology, positions, "A:7-10")


def test_disulfides():
    structure = readStructure(str(realStructurePath("bpti_h.pdb")))
    with pytest.raises(InputError, match="CYS.* 14 SG is bonded to .*CYS.* 38 SG"):
        sampleLoop(structure.topology, structure.positions, "10-18")


def test_prolines():
    found = sampleLoop(_VILLIN.topology, _VILLIN.positions, "20-23", conformers=3, seed=1, maxGrown=2, trials=0)
    assert found.grown == 2  # with proline 21: no residue is drawn before the loop is closed
    topology, positions = makePeptides(["ALA", *["PRO"] * 6, "ALA"])
    with pytest.raises(InputError, match="no three residues whose phi and psi both turn"):
        sampleLoop(topology, positions * nanometer, "3-6")


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"model": "amber"}, "'amber' is no model of loops"),
        ({"conformers": 0}, "must be above 0"),
        ({"trials": -1}, "not below 0"),
        ({"temperature": 0}, "temperature must be above 0"),
    ],
)
def test_wrong_arguments(arguments, message):
    with pytest.raises(InputError, match=message):
        sampleLoop(_VILLIN.topology, _VILLIN.positions, "20-24", **arguments)


def test_growth_names_wrong_sets():
    positions, system, force, _ = _peptide(6, (2, 5), 0.1)
    pair, single = (TorsionDensity.fromTable(np.ones((1,) * count)) for count in (2, 1))
    for sets, densities, message in [
        ([(0, 1)], [single], "set 0 has 2 torsions, but its density is of 1"),
        ([(0, 1), (1, 2)], [pair, pair], "torsion 1 is in more than one set"),
        ([(0, 99)], [pair], "torsion"),
        ([(0, 1)], [pair, pair], "a density for each"),
        ([(0, 1), (2, 3)], [pair, pair], "no three residues"),
        ([(0, 2)], [pair], "contradicts"),
    ]:
        with pytest.raises(openmm.OpenMMException, match=message):
            LoopGrowth(system, force, positions, sets, densities)
    topology, straight = makePeptides(["ALA"] * 3)
    free = openmm.System()
    for _ in straight:
        free.addParticle(1)
    with pytest.raises(openmm.OpenMMException, match="one closure"):
        LoopGrowth(free, createStericExclusionForce(topology), straight, [], [])
    with pytest.raises(openmm.OpenMMException, match="positions"):
        LoopGrowth(system, force, positions[1:], [(0, 1)], [pair])
