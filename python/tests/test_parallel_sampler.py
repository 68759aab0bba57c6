"""OpenMM's replica exchange with replicas side by side, and our integrator as a move of openmmtools."""

import pickle
import random

import numpy as np
import openmm
import pytest
from openmm import app, unit
from openmmchaintree import (
    ParallelReplicaExchangeSampler,
    StericExclusionForce,
    TorsionMonteCarloIntegrator,
    createStericExclusionForce,
    replicaexchange,
)
from scenes import DIPEPTIDE, writePDB

KELVINS = (300.0, 400.0, 550.0)
STATES = [{"temperature": kelvin * unit.kelvin} for kelvin in KELVINS]

needsSampler = pytest.mark.skipif(
    not hasattr(app, "ReplicaExchangeSampler"), reason="this OpenMM has no ReplicaExchangeSampler"
)


@pytest.fixture
def dipeptide(tmp_path):
    """Topology, System and positions."""
    pdb = app.PDBFile(str(writePDB(tmp_path / "dipeptide.pdb", DIPEPTIDE)))
    system = app.ForceField("amber14/protein.ff14SB.xml").createSystem(pdb.topology)
    system.addForce(createStericExclusionForce(pdb.topology, pdb.positions))
    return pdb.topology, system, pdb.positions


def torsionIntegrator():
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setStericMode(integrator.Hard)
    integrator.addTorsionMove(1, 0.5)
    integrator.setTrialsPerStep(50)
    return integrator


def makeSampler(dipeptide, integrator=None, platform=("Reference",), **options):
    topology, system, positions = dipeptide
    platform = (openmm.Platform.getPlatformByName(platform[0]), *platform[1:])
    simulation = app.Simulation(topology, system, integrator or torsionIntegrator(), *platform)
    simulation.context.setPositions(positions)
    return ParallelReplicaExchangeSampler(STATES, simulation, 2, **options)


def places(sampler):
    return [state.getPositions(asNumpy=True).value_in_unit(unit.nanometer) for state in sampler.replicaConformation]


def test_olderVersionsOfOpenMM(dipeptide, monkeypatch):
    monkeypatch.setattr(replicaexchange, "_Base", object)
    with pytest.raises(RuntimeError, match=r"^ParallelReplicaExchangeSampler needs OpenMM 8\.6 or newer, and this is"):
        makeSampler(dipeptide)


@needsSampler
@pytest.mark.parametrize(
    ("make", "platform"),
    [
        (torsionIntegrator, ("Reference",)),
        # On Reference all Contexts share the random numbers of dynamics.
        (lambda: openmm.LangevinMiddleIntegrator(300, 1, 0.002), ("CPU", {"Threads": "1"})),
    ],
)
def test_sameWhateverTheWorkers(dipeptide, tmp_path, make, platform):
    found = []
    for workers in (1, 3):
        random.seed(4)
        sampler = makeSampler(dipeptide, make(), platform, workers=workers, seed=7)
        report = tmp_path / str(workers)
        sampler.reporters.append(app.ReplicaExchangeReporter(str(report), 1, sampler, energy=True))
        sampler.simulate(6)
        assert sampler.currentIteration == 6 and sampler.simulation.currentStep == 12
        found.append((places(sampler), (report / "log.csv").read_text(), (report / "energy.csv").read_text()))
    for first, second in zip(found[0][0], found[1][0], strict=True):
        assert np.array_equal(first, second)
    assert found[0][1:] == found[1][1:]
    assert len({*found[0][1].splitlines()}) == 7
    assert all(not np.array_equal(found[0][0][0], other) for other in found[0][0][1:])


@needsSampler
def test_energiesAreThoseThatAreSampled(dipeptide):
    """A clash at the start, which is tolerated, has no energy, where OpenMM's own class counts it."""
    topology, system, positions = dipeptide
    force = StericExclusionForce.cast(system.getForce(system.getNumForces() - 1))
    for particle in range(force.getNumParticles()):
        radius, role = force.getParticleParameters(particle)
        force.setParticleParameters(particle, 1.4 * radius, role)
    sampler = makeSampler(dipeptide)
    context = sampler.simulation.context
    assert force.hasClash(context)
    sampler.simulate(1)
    others = set(range(32)) - {force.getForceGroup()}
    for row, state in zip(sampler.replicaStateEnergy, sampler.replicaConformation, strict=True):
        context.setPositions(state.getPositions())
        energy = context.getState(energy=True, groups=others).getPotentialEnergy()
        whole = context.getState(energy=True).getPotentialEnergy()
        assert (whole - energy).value_in_unit(unit.kilojoule_per_mole) > 1
        for value in row:
            assert (value - energy).value_in_unit(unit.kilojoule_per_mole) == pytest.approx(0, abs=1e-3)


@needsSampler
def test_statesAreSampled(dipeptide, monkeypatch):
    """Hot replicas have more energy than cold ones, and two hot ones go different ways."""
    monkeypatch.setattr(f"{__name__}.STATES", [{"temperature": kelvin * unit.kelvin} for kelvin in (5000, 5000, 20)])
    sampler = makeSampler(dipeptide, seed=1)
    sampler.exchangeReplicas = lambda: None
    energies = []
    for _ in range(300):
        sampler.simulate(1)
        energies.append([row[0].value_in_unit(unit.kilojoule_per_mole) for row in sampler.replicaStateEnergy])
    assert energies[0][0] != energies[0][1]
    hot, alsoHot, cold = np.mean(energies[5:], axis=0)
    assert min(hot, alsoHot) > cold + 8


@needsSampler
def test_parametersAndSharedGroups(dipeptide):
    """States that differ in a parameter: the spheres' energy is left out, for which they need a group of their own."""
    topology, system, positions = dipeptide
    scaled = openmm.CustomExternalForce("lambda * z")
    scaled.addGlobalParameter("lambda", 0)
    scaled.addParticle(0)
    system.addForce(scaled)
    platform = openmm.Platform.getPlatformByName("Reference")
    simulation = app.Simulation(topology, system, torsionIntegrator(), platform)
    simulation.context.setPositions(positions)
    sampler = ParallelReplicaExchangeSampler([{"lambda": value} for value in (0.0, 50.0)], simulation, 1)
    sampler.simulate(2)
    steric = StericExclusionForce.cast(system.getForce(system.getNumForces() - 2))
    for row, state in zip(sampler.replicaStateEnergy, sampler.replicaConformation, strict=True):
        z = state.getPositions()[0].z
        assert (row[1] - row[0]).value_in_unit(unit.kilojoule_per_mole) == pytest.approx(50 * z, abs=1e-9)
    steric.setForceGroup(0)
    with pytest.raises(ValueError, match="force group 0: .* StericExclusionForce needs a separate one"):
        ParallelReplicaExchangeSampler([{"lambda": value} for value in (0.0, 50.0)], simulation, 1)


@needsSampler
@pytest.mark.parametrize("mode", ["Hard", "Off"])
def test_resuming(dipeptide, tmp_path, mode):
    """With OpenMM's own reporter: replicas continue from their States, with their random numbers."""
    ends = []

    def make(seed):
        integrator = torsionIntegrator()
        integrator.setStericMode(getattr(integrator, mode))
        return makeSampler(dipeptide, integrator, seed=seed)

    for isCut in (False, True):
        folder = tmp_path / str(isCut)
        options = {"checkpoints": True, "trajectoryPerState": True, "trajectoryPerReplica": True}
        sampler = make(3)
        sampler.exchangeReplicas = lambda: None  # the reporter comes before the exchange, which a resumed run repeats
        sampler.reporters.append(app.ReplicaExchangeReporter(str(folder), 1, sampler, **options))
        sampler.simulate(2)
        if isCut:
            del sampler.reporters[:]
            sampler = make(9)
            sampler.exchangeReplicas = lambda: None
            sampler.reporters.append(app.ReplicaExchangeReporter(str(folder), 1, sampler, resume=True, **options))
        sampler.simulate(2)
        assert sampler.currentIteration == 4
        ends.append(places(sampler))
    for first, second in zip(*ends, strict=True):
        assert np.array_equal(first, second)


# ---- openmmtools ----


@pytest.fixture
def move(dipeptide):
    """A TorsionMonteCarloMove, and openmmtools' states of the System, hot and cold, and of its positions."""
    pytest.importorskip("openmmtools")
    from openmmchaintree.openmmtoolsmove import TorsionMonteCarloMove
    from openmmtools import cache, states

    cache.global_context_cache.empty()
    cache.global_context_cache.platform = openmm.Platform.getPlatformByName("Reference")
    _, system, positions = dipeptide
    hot, cold = (states.ThermodynamicState(system, kelvin * unit.kelvin) for kelvin in (1000, 100))
    return TorsionMonteCarloMove(torsionIntegrator(), n_steps=4), hot, cold, states.SamplerState(positions)


def test_moveOfOpenmmtools(move):
    move, hot, cold, state = move
    before = state.positions.value_in_unit(unit.nanometer).copy()
    accepted = []
    for thermodynamicState in (hot, cold):
        counts = sum(statistics.accepted for statistics in move.statistics)
        for _ in range(5):
            move.apply(thermodynamicState, state)
        accepted.append(sum(statistics.accepted for statistics in move.statistics) - counts)
    assert np.abs(state.positions.value_in_unit(unit.nanometer) - before).max() > 0.01
    assert accepted[0] > 1.2 * accepted[1] > 0
    assert sum(statistics.attempted for statistics in move.statistics) == 2 * 5 * 4 * 50
    copied = pickle.loads(pickle.dumps(move))
    assert isinstance(copied.integrator, TorsionMonteCarloIntegrator) and copied.statistics == move.statistics
    copied.apply(cold, state)


def test_velocitiesOfOpenmmtools(move, dipeptide):
    """Velocities turn, and keep their kinetic energy and the momentum of 0 that a CMMotionRemover makes them have."""
    move, hot, _, state = move
    masses = np.array([dipeptide[1].getParticleMass(atom)._value for atom in range(len(state.positions))])[:, None]
    velocities = np.random.default_rng(1).normal(size=state.positions.shape)
    velocities -= (masses * velocities).sum(axis=0) / masses.sum()
    state.velocities = velocities * unit.nanometer / unit.picosecond
    move.apply(hot, state)
    turned = state.velocities.value_in_unit(unit.nanometer / unit.picosecond)
    assert np.abs(turned - velocities).max() > 0.1
    assert np.allclose((masses * turned).sum(axis=0), 0, atol=1e-9)
    assert np.isclose((masses * turned**2).sum(), (masses * velocities**2).sum(), rtol=1e-12)


def test_constraintsToOpenmmtools(move, dipeptide):
    """A constraint that velocities do not keep is an error, if there are velocities."""
    from openmmtools import states

    move, _, _, state = move
    _, system, positions = dipeptide
    force = StericExclusionForce.cast(system.getForce(system.getNumForces() - 1))
    first, _, other, _ = force.getTorsionParticles(0)
    places = positions.value_in_unit(unit.nanometer)
    system.addConstraint(first, other, openmm.unit.norm(places[first] - places[other]))
    thermodynamicState = states.ThermodynamicState(system, 300 * unit.kelvin)
    move.apply(thermodynamicState, state)
    state.velocities = np.ones(state.positions.shape) * unit.nanometer / unit.picosecond
    with pytest.raises(openmm.OpenMMException, match=f"between particles {first} and {other} lies across torsion 0"):
        move.apply(thermodynamicState, state)


def test_parallelTempering(move, tmp_path):
    """The sampler of openmmtools runs, and writes our move into its file."""
    from openmmtools import multistate

    move, _, cold, state = move
    sampler = multistate.ParallelTemperingSampler(mcmc_moves=move, number_of_iterations=3)
    reporter = multistate.MultiStateReporter(str(tmp_path / "tempering.nc"), checkpoint_interval=1)
    sampler.create(
        cold, state, reporter, min_temperature=300 * unit.kelvin, max_temperature=500 * unit.kelvin, n_temperatures=3
    )
    sampler.run()
    assert sampler.iteration == 3
    reporter.close()
    again = multistate.ParallelTemperingSampler.from_storage(str(tmp_path / "tempering.nc"))
    again.extend(1)
    assert again.iteration == 4


def test_clashesToOpenmmtools(move, dipeptide):
    move, hot, _, state = move
    positions = state.positions.value_in_unit(unit.nanometer)
    positions[0] = positions[-1] + 0.01
    state.positions = positions * unit.nanometer
    with pytest.raises(ValueError, match="TorsionMonteCarloMove: [0-9]+ pairs of atoms clash"):
        move.apply(hot, state)
    move.integrator.setStericMode(move.integrator.Soft)
    move.apply(hot, state)


def test_movesNeedOurIntegrator(move):
    with pytest.raises(TypeError, match="takes a TorsionMonteCarloIntegrator, not VerletIntegrator"):
        type(move[0])(openmm.VerletIntegrator(0.001))


def test_noSpheresToOpenmmtools(move, dipeptide):
    """Without spheres the force must have no energy in the Contexts of openmmtools, where no trials are made."""
    from openmmtools import states

    move, hot, _, state = move
    move.integrator.setStericMode(move.integrator.Automatic)
    with pytest.raises(ValueError, match=r"call setForceConstant\(0\)"):
        move.apply(hot, state)
    _, system, _ = dipeptide
    StericExclusionForce.cast(system.getForce(system.getNumForces() - 1)).setForceConstant(0)
    move.apply(states.ThermodynamicState(system, 300 * unit.kelvin), state)
