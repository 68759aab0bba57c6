"""Energies of trials in Python: the plan, what is held of them, counts, and how they are saved."""

import copy
import io
import pickle

import openmm
import pytest
from openmm import app, unit
from openmmchaintree import (
    EnergyPlan,
    PlannedEnergy,
    StageStatistics,
    StericExclusionForce,
    TorsionMonteCarloIntegrator,
    createStericExclusionForce,
)
from scenes import positionsOf

REFERENCE = openmm.Platform.getPlatformByName("Reference")


def makeIntegrator(seed=1):
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(seed)
    integrator.addTorsionMove(1, 0.3)
    integrator.addTorsionMove(1, 0.02, count=3)
    return integrator


@pytest.fixture(scope="module")
def amber(villin):
    """The System of villin in AMBER14 with a cutoff, without and with spheres of radius 0."""

    def make(withSpheres=True):
        system = app.ForceField("amber14-all.xml").createSystem(
            villin.topology, nonbondedMethod=app.CutoffNonPeriodic, nonbondedCutoff=1 * unit.nanometer
        )
        force = createStericExclusionForce(villin.topology, villin.positions)
        if not withSpheres:
            for particle in range(force.getNumParticles()):
                force.setParticleParameters(particle, 0)
        system.addForce(force)
        return system

    return make


def openmmEnergy(system, positions):
    """OpenMM's energy on the Reference platform, without the spheres."""
    bare = openmm.XmlSerializer.clone(system)
    for index in reversed(range(bare.getNumForces())):
        if StericExclusionForce.isinstance(bare.getForce(index)):
            bare.removeForce(index)
    context = openmm.Context(bare, openmm.VerletIntegrator(0.001), REFERENCE)
    context.setPositions(positions)
    return context.getState(energy=True).getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)


@pytest.mark.parametrize("withSpheres", [True, False])
def test_heldEnergy(amber, villin, withSpheres):
    system = amber(withSpheres)
    integrator = makeIntegrator()
    context = openmm.Context(system, integrator, REFERENCE)
    context.setPositions(villin.positions)
    for _ in range(3):
        energy = integrator.getPotentialEnergy(context)
        assert type(energy) is float
        expected = openmmEnergy(system, positionsOf(context))
        assert energy == pytest.approx(expected, rel=1e-6, abs=5e-3)
        integrator.step(10)
    accepted = sum(integrator.getMoveStatistics(move).accepted for move in range(2))
    assert accepted > 100


def test_plan(amber):
    integrator = makeIntegrator()
    context = openmm.Context(amber(), integrator, REFERENCE)
    plan = integrator.getEnergyPlan(context)
    assert isinstance(plan, EnergyPlan) and all(isinstance(entry, PlannedEnergy) for entry in plan)
    assert [entry.force for entry in plan] == list(range(context.getSystem().getNumForces()))
    assert {entry.name: entry.kind for entry in plan} == {
        "HarmonicBondForce": "constant",
        "HarmonicAngleForce": "constant",
        "PeriodicTorsionForce": "native",
        "NonbondedForce": "native",
        "CMMotionRemover": "not sampled",
        "StericExclusionForce": "not sampled",
    }
    lines = str(plan).splitlines()
    assert len(lines) == len(plan)
    for line, entry in zip(lines, plan, strict=True):
        assert line.split()[:3] == [str(entry.force), entry.name, entry.kind.split()[0]]
        assert line.endswith(f"  {entry.reason}") and entry.reason
    assert len({line.index(f"  {entry.reason}") for line, entry in zip(lines, plan, strict=True)}) == 1
    integrator.setNativeEnergies(False)
    assert {entry.kind for entry in integrator.getEnergyPlan(context)} == {"foreign", "not sampled"}
    assert str(EnergyPlan()) == ""


def test_stageStatistics(amber, villin):
    integrator = makeIntegrator()
    with pytest.raises(openmm.OpenMMException, match="not bound"):
        integrator.getStageStatistics()
    context = openmm.Context(amber(), integrator, REFERENCE)
    context.setPositions(villin.positions)
    integrator.step(5)
    stages = integrator.getStageStatistics()
    assert all(isinstance(stage, StageStatistics) for stage in stages)
    counts = {stage.stage: (stage.computed, stage.refused) for stage in stages}
    assert list(counts) == [
        "bonded terms",
        "near pairs",
        "soft spheres",
        "other pairs",
        "computed values",
        "foreign forces",
    ]
    assert counts["soft spheres"] == counts["foreign forces"] == (0, 0)
    assert counts["bonded terms"][0] - counts["bonded terms"][1] == counts["near pairs"][0] > 0
    refused = sum(integrator.getMoveStatistics(move).rejectedByEnergy for move in range(2))
    assert sum(stage.refused for stage in stages) == refused > 0
    integrator.resetMoveStatistics()
    assert {stage[1:] for stage in integrator.getStageStatistics()} == {(0, 0)}


def test_nativeEnergiesAreKept():
    integrator = makeIntegrator()
    assert integrator.getNativeEnergies() is True
    integrator.setNativeEnergies(False)
    for duplicate in (copy.copy(integrator), pickle.loads(pickle.dumps(integrator))):
        assert duplicate.getNativeEnergies() is False
    integrator.setNativeEnergies(native=True)
    assert copy.deepcopy(integrator).getNativeEnergies() is True
    with pytest.raises(TypeError):
        integrator.setNativeEnergies("no")


def test_otherContext(amber, villin):
    integrator = makeIntegrator()
    other = openmm.Context(amber(), makeIntegrator(), REFERENCE)
    openmm.Context(amber(), integrator, REFERENCE)
    for ask in (integrator.getEnergyPlan, integrator.getPotentialEnergy):
        with pytest.raises(openmm.OpenMMException, match="not bound to this Context"):
            ask(other)


def test_resumedSimulation(amber, villin):
    """A Simulation and one resumed from its files have the same positions and the same energy."""
    system = amber()

    def start(seed):
        integrator = makeIntegrator(seed)
        simulation = app.Simulation(villin.topology, system, integrator, REFERENCE)
        return simulation, integrator

    simulation, integrator = start(1)
    simulation.context.setPositions(villin.positions)
    simulation.step(5)
    checkpoint, state = io.BytesIO(), io.StringIO()
    simulation.saveCheckpoint(checkpoint)
    simulation.saveState(state)
    simulation.step(5)
    checkpoint.seek(0)
    state.seek(0)
    for load in ("loadCheckpoint", "loadState"):
        resumed, resumedIntegrator = start(2)
        getattr(resumed, load)(checkpoint if load == "loadCheckpoint" else state)
        resumed.step(5)
        assert (positionsOf(resumed.context) == positionsOf(simulation.context)).all()
        expected = integrator.getPotentialEnergy(simulation.context)
        assert resumedIntegrator.getPotentialEnergy(resumed.context) == expected
