"""Interrupted Simulations that continue from checkpoints and States of app.Simulation and its reporters."""

import subprocess
import sys

import numpy as np
import openmm
import pytest
from openmm import app
from openmmchaintree import StericExclusionForce, TorsionMonteCarloIntegrator, createStericExclusionForce
from scenes import makeSystem, positionsOf


def makeIntegrator(seed=0):
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(seed)
    integrator.setTrialsPerStep(5)
    integrator.addTorsionMove(1, 0.3)
    integrator.addTorsionMove(1, 0.2, count=3)
    return integrator


def makeSimulation(topology, system, seed=0):
    platform = openmm.Platform.getPlatformByName("Reference")
    return app.Simulation(topology, system, makeIntegrator(seed), platform)


def makeStericSystem(villin):
    return makeSystem(villin, createStericExclusionForce(villin.topology, villin.positions))


def makeSolvatedSystem(villin):
    forceField = app.ForceField("amber14-all.xml", "implicit/gbn2.xml")
    system = forceField.createSystem(villin.topology)
    system.addForce(createStericExclusionForce(villin.topology, villin.positions))
    return system


FRESH_PROCESS = """
import sys
import openmm, openmmchaintree
from openmm import app
systemPath, integratorPath, checkpointPath, steps, endPath = sys.argv[1:]
system, integrator = (openmm.XmlSerializer.deserialize(open(path).read()) for path in (systemPath, integratorPath))
platform = openmm.Platform.getPlatformByName("Reference")
simulation = app.Simulation(app.Topology(), system, integrator, platform)
simulation.loadCheckpoint(checkpointPath)
simulation.step(int(steps))
simulation.saveCheckpoint(endPath)
"""


@pytest.mark.parametrize("make", [makeStericSystem, makeSolvatedSystem])
def test_freshProcess(villin, make, tmp_path):
    paths = [str(tmp_path / name) for name in ("system", "integrator", "checkpoint", "end", "otherEnd")]
    simulation = makeSimulation(villin.topology, make(villin))
    simulation.context.setPositions(villin.positions)
    simulation.step(2)
    for path, thing in zip(paths, (simulation.system, simulation.integrator), strict=False):
        with open(path, "w") as file:
            file.write(openmm.XmlSerializer.serialize(thing))
    simulation.saveCheckpoint(paths[2])
    simulation.step(2)
    simulation.saveCheckpoint(paths[3])
    subprocess.run([sys.executable, "-c", FRESH_PROCESS, *paths[:3], "2", paths[4]], check=True)
    end, otherEnd = (open(path, "rb").read() for path in paths[3:])
    assert end == otherEnd


def test_checkpointReporter(villin, tmp_path):
    path = str(tmp_path / "checkpoint")
    simulation = makeSimulation(villin.topology, makeStericSystem(villin))
    simulation.context.setPositions(villin.positions)
    simulation.reporters.append(app.CheckpointReporter(path, 4))
    simulation.step(6)
    again = makeSimulation(villin.topology, makeStericSystem(villin))
    again.loadCheckpoint(path)
    assert again.currentStep == 4
    again.step(2)
    assert np.array_equal(positionsOf(again.context), positionsOf(simulation.context))


@pytest.mark.parametrize("viaReporter", [False, True])
def test_states(villin, tmp_path, viaReporter):
    path = str(tmp_path / "state.xml")
    simulation = makeSimulation(villin.topology, makeStericSystem(villin))
    simulation.context.setPositions(villin.positions)
    if viaReporter:
        simulation.reporters.append(app.CheckpointReporter(path, 50, writeState=True))
    simulation.step(50)
    if not viaReporter:
        simulation.saveState(path)
    tolerated = simulation.integrator.getNumToleratedClashes(simulation.context)
    assert tolerated > 0

    again = makeSimulation(villin.topology, makeStericSystem(villin))
    again.loadState(path)
    assert again.currentStep == 50
    assert again.integrator.getNumToleratedClashes(again.context) == tolerated
    assert np.array_equal(positionsOf(again.context), positionsOf(simulation.context))
    again.step(1)
    assert again.integrator.getNumToleratedClashes(again.context) == tolerated


@pytest.mark.parametrize("make", [makeStericSystem, makeSolvatedSystem])
def test_statesGoOnBitForBit(villin, make, tmp_path):
    path = str(tmp_path / "state.xml")
    simulation = makeSimulation(villin.topology, make(villin))
    simulation.context.setPositions(villin.positions)
    simulation.step(3)
    simulation.saveState(path)
    state = fullState(simulation.context)
    simulation.step(3)
    end = simulation.context.createCheckpoint()
    ends = []
    for kind in ("file", "text"):
        again = makeSimulation(villin.topology, make(villin))
        if kind == "file":
            again.loadState(path)
        else:
            again.context.setState(openmm.XmlSerializer.deserialize(state))
        assert again.currentStep == 3
        again.step(3)
        ends.append(again.context.createCheckpoint())
    assert ends == [end, end]


def fullState(context):
    state = context.getState(positions=True, velocities=True, parameters=True, integratorParameters=True)
    return openmm.XmlSerializer.serialize(state)


def test_otherMoves(villin):
    simulation = makeSimulation(villin.topology, makeStericSystem(villin))
    simulation.context.setPositions(villin.positions)
    checkpoint, state = simulation.context.createCheckpoint(), fullState(simulation.context)
    simulation.integrator.setTorsionMoveParameters(1, 1, 0.25, count=3)
    with pytest.raises(openmm.OpenMMException, match="of other moves: move 1 has maxAngle 0.2 in it, but 0.25 here"):
        simulation.context.loadCheckpoint(checkpoint)
    simulation.context.setState(openmm.XmlSerializer.deserialize(state))
    simulation.step(1)
    simulation.integrator.setTorsionMoveParameters(1, 1, 0.2, count=3)
    simulation.context.loadCheckpoint(checkpoint)


# ---- A refused reinitialize() ----


def guarded(context):
    """Yield each call that needs a Context that a refused reinitialize() left incomplete."""
    state = openmm.XmlSerializer.deserialize(fullState(context))
    checkpoint = context.createCheckpoint()
    yield lambda: context.loadCheckpoint(checkpoint)
    yield lambda: context.setState(state)
    yield lambda: context.getState(integratorParameters=True)
    yield lambda: context.getIntegrator().step(1)
    yield lambda: context.getIntegrator().getTorsionAngles(context)
    yield lambda: context.getIntegrator().getNumToleratedClashes(context)


def test_refusedReinitialize(villin):
    whole, refused = (makeSimulation(villin.topology, makeStericSystem(villin), seed=4) for _ in range(2))
    for simulation in (whole, refused):
        simulation.context.setPositions(villin.positions)
        simulation.step(2)
    context = refused.context
    calls = list(guarded(context))
    for _ in range(2):
        # The first to refuse is the barostat itself: the System has no box.
        refused.system.addForce(openmm.MonteCarloBarostat(1, 300))
        for _ in range(2):
            with pytest.raises(openmm.OpenMMException, match="barostat"):
                context.reinitialize(preserveState=True)
        refused.system.removeForce(1)
        context.reinitialize(preserveState=True)
    assert context.createCheckpoint() == whole.context.createCheckpoint()

    refused.system.addForce(openmm.MonteCarloBarostat(1, 300))
    with pytest.raises(openmm.OpenMMException, match="barostat"):
        context.reinitialize(preserveState=True)
    for call in calls:
        with pytest.raises(openmm.OpenMMException, match=r"reinitialize\(\) threw an exception"):
            call()
    force = StericExclusionForce.cast(refused.system.getForce(0))
    with pytest.raises(openmm.OpenMMException):
        force.addTorsion(0, 0, 0, 0)
        context.reinitialize(preserveState=True)
    for query in (force.hasClash, force.getClashes, force.getTorsionAngles, force.updateParametersInContext):
        with pytest.raises(openmm.OpenMMException, match=r"reinitialize\(\) threw an exception"):
            query(context)


def test_rescueFromRefusedReinitialize(villin):
    """A user who cannot correct the System continues in another one, from a checkpoint of the incomplete Context."""
    simulation = makeSimulation(villin.topology, makeStericSystem(villin))
    simulation.context.setPositions(villin.positions)
    simulation.step(2)
    checkpoint = simulation.context.createCheckpoint()
    simulation.system.addForce(openmm.MonteCarloBarostat(1, 300))
    with pytest.raises(openmm.OpenMMException, match="barostat"):
        simulation.context.reinitialize(preserveState=True)
    again = makeSimulation(villin.topology, makeStericSystem(villin))
    again.context.loadCheckpoint(simulation.context.createCheckpoint())
    assert again.context.createCheckpoint() == checkpoint


def test_otherStructure(villin, tmp_path):
    path = str(tmp_path / "checkpoint")
    simulation = makeSimulation(villin.topology, makeStericSystem(villin))
    simulation.context.setPositions(villin.positions)
    simulation.saveCheckpoint(path)
    force = createStericExclusionForce(villin.topology, villin.positions, torsions=("phi", "psi"))
    other = makeSimulation(villin.topology, makeSystem(villin, force))
    with pytest.raises(openmm.OpenMMException, match="the checkpoint is of another structure"):
        other.loadCheckpoint(path)


def test_reinitialize(villin):
    simulation = makeSimulation(villin.topology, makeStericSystem(villin))
    simulation.context.setPositions(villin.positions)
    simulation.step(1)
    before = positionsOf(simulation.context)
    statistics = simulation.integrator.getMoveStatistics(0)
    simulation.context.reinitialize(preserveState=True)
    assert np.array_equal(before, positionsOf(simulation.context))
    assert simulation.integrator.getMoveStatistics(0) == statistics
    simulation.step(1)
    assert simulation.integrator.getNumToleratedClashes(simulation.context) > 0
