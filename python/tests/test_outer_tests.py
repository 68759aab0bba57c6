"""Outer tests in Python: settings and statistics, and runs that are killed within a block of trials."""

import copy
import pickle
import subprocess
import sys
import time
import warnings

import numpy as np
import openmm
import pytest
from openmm import app, unit
from openmmchaintree import OuterStatistics, TorsionMonteCarloIntegrator, createStericExclusionForce
from scenes import makeSystem, positionsOf

REFERENCE = openmm.Platform.getPlatformByName("Reference")


def makeSpring():
    """A Force that only OpenMM can evaluate."""
    force = openmm.CustomCentroidBondForce(2, "20*same(distance(g1,g2))^2")
    force.addTabulatedFunction("same", openmm.Continuous1DFunction([0, 30], 0, 30))
    force.addGroup([0, 1, 2, 3])
    force.addGroup([570, 571, 572])
    force.addBond([0, 1], [])
    return force


def makeIntegrator(trialsPerOuterTest, seed=1):
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(seed)
    integrator.setTrialsPerOuterTest(trialsPerOuterTest)
    integrator.addTorsionMove(1, 0.1)
    return integrator


@pytest.fixture(scope="module")
def pulled(villin):
    """The System of villin, with spheres and a spring between its ends."""
    system = makeSystem(villin, createStericExclusionForce(villin.topology, villin.positions))
    system.addForce(makeSpring())
    return system


def test_statistics(villin, pulled):
    integrator = makeIntegrator(trialsPerOuterTest=25)
    context = openmm.Context(pulled, integrator, REFERENCE)
    context.setPositions(villin.positions)
    assert integrator.getOuterStatistics() == (0, 0, 0, 0, 0)
    integrator.step(10)
    tests = integrator.getOuterStatistics()
    assert isinstance(tests, OuterStatistics)
    assert tests.attempted == 40 and 0 < tests.accepted < 40
    assert tests.trialsTakenBack == 25 * (tests.attempted - tests.accepted)
    assert integrator.getMoveStatistics(0).attempted == 1000 - tests.trialsTakenBack
    assert tests.standardDeviation > abs(tests.meanDifference) / 40 > 0
    assert all(stage.computed == 0 for stage in integrator.getStageStatistics())
    integrator.resetMoveStatistics()
    assert integrator.getOuterStatistics().attempted == 0


@pytest.mark.parametrize("trialsPerOuterTest, isSlow", [(1, False), (400, True)])
def test_slowChains(villin, pulled, trialsPerOuterTest, isSlow):
    """Where outer tests keep hardly anything, a warning says so, once."""
    integrator = makeIntegrator(trialsPerOuterTest)
    context = openmm.Context(pulled, integrator, REFERENCE)
    context.setPositions(villin.positions)
    integrator.setTrialsPerStep(400)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        integrator.step(230)
    assert ["chains move slowly" in str(warning.message) for warning in caught] == [True] * isSlow


def test_withoutForeignForces(villin):
    integrator = makeIntegrator(trialsPerOuterTest=25)
    system = makeSystem(villin, createStericExclusionForce(villin.topology, villin.positions))
    context = openmm.Context(system, integrator, REFERENCE)
    context.setPositions(villin.positions)
    integrator.renewStandIns(context)
    integrator.step(1)
    assert integrator.getOuterStatistics().attempted == 0


def test_settings():
    integrator = TorsionMonteCarloIntegrator(300)
    assert integrator.getTrialsPerOuterTest() == 0
    assert integrator.getStandInCutoffs() == (0.55 * unit.nanometer, 0.8 * unit.nanometer)
    assert integrator.getStandInGridWidth() == 0.08
    integrator.setTrialsPerOuterTest(400)
    integrator.setStandInCutoffs(bornCutoff=7 * unit.angstrom, pairCutoff=1)
    integrator.setStandInGridWidth(0.125)
    for each in (integrator, copy.copy(integrator), copy.deepcopy(integrator), pickle.loads(pickle.dumps(integrator))):
        assert each.getTrialsPerOuterTest() == 400
        born, pair = (cutoff.value_in_unit(unit.nanometer) for cutoff in each.getStandInCutoffs())
        assert born == pytest.approx(0.7, rel=1e-14) and pair == 1
        assert each.getStandInGridWidth() == 0.125
    for call, bad, message in (
        (integrator.setTrialsPerOuterTest, (-1,), "at least 0, but is -1"),
        (integrator.setStandInCutoffs, (0, 1), "bornCutoff of stand-ins must be a finite number above 0"),
        (integrator.setStandInCutoffs, (1, float("inf")), "pairCutoff of stand-ins must be a finite number above 0"),
        (integrator.setStandInGridWidth, (float("nan"),), "grid width of stand-ins must be a finite number above 0"),
    ):
        with pytest.raises(openmm.OpenMMException, match=message):
            call(*bad)
    with pytest.raises(TypeError):
        integrator.setStandInCutoffs(1 * unit.kelvin, 1)
    with pytest.raises(TypeError):
        integrator.setTrialsPerOuterTest(2.5)


def test_renewStandInsOfAnotherContext(villin, pulled):
    context = openmm.Context(pulled, makeIntegrator(10), REFERENCE)
    with pytest.raises(openmm.OpenMMException, match="not bound to this Context"):
        makeIntegrator(10).renewStandIns(context)


# Saves a checkpoint after each step, of which another process may see only whole ones.
SAVING_PROCESS = """
import os, sys
import openmm, openmmchaintree
systemPath, integratorPath, positionsPath, checkpointPath, numSteps = sys.argv[1:]
system, integrator = (openmm.XmlSerializer.deserialize(open(path).read()) for path in (systemPath, integratorPath))
context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
if os.path.exists(checkpointPath):
    context.loadCheckpoint(open(checkpointPath, "rb").read())
else:
    context.setState(openmm.XmlSerializer.deserialize(open(positionsPath).read()))
while numSteps == "endless" or context.getStepCount() < int(numSteps):
    with open(checkpointPath + ".new", "wb") as file:
        file.write(context.createCheckpoint())
    os.replace(checkpointPath + ".new", checkpointPath)
    integrator.step(1)
print(context.getStepCount())
with open(checkpointPath, "wb") as file:
    file.write(context.createCheckpoint())
"""


@pytest.fixture(scope="module")
def solvated(villin):
    """The System of villin in generalized Born solvent, for which trials have a stand-in."""
    system = app.ForceField("amber14-all.xml", "implicit/gbn2.xml").createSystem(villin.topology)
    system.addForce(createStericExclusionForce(villin.topology, villin.positions))
    return system


@pytest.mark.parametrize("kind", ["pulled", "solvated"])
def test_killedWithinABlock(villin, kind, tmp_path, request):
    system = request.getfixturevalue(kind)
    paths = [str(tmp_path / name) for name in ("system", "integrator", "positions")]
    integrator = makeIntegrator(trialsPerOuterTest=300 if kind == "pulled" else 30)
    integrator.setTrialsPerStep(1000 if kind == "pulled" else 100)
    context = openmm.Context(system, integrator, REFERENCE)
    context.setPositions(villin.positions)
    for path, thing in zip(paths, (system, integrator, context.getState(positions=True)), strict=True):
        with open(path, "w") as file:
            file.write(openmm.XmlSerializer.serialize(thing))
    killed, whole = (str(tmp_path / name) for name in ("killed", "whole"))
    command = [sys.executable, "-c", SAVING_PROCESS, *paths]
    with subprocess.Popen([*command, killed, "endless"]) as process:
        while not (tmp_path / "killed").exists():
            assert process.poll() is None
            time.sleep(0.01)
        process.kill()
    assert process.returncode != 0
    context.loadCheckpoint((tmp_path / "killed").read_bytes())
    numSteps = str(context.getStepCount() + 3)
    for checkpoint in (killed, whole):
        result = subprocess.run([*command, checkpoint, numSteps], check=True, capture_output=True, text=True)
        assert result.stdout.split() == [numSteps]
    assert (tmp_path / "killed").read_bytes() == (tmp_path / "whole").read_bytes()
    context.loadCheckpoint((tmp_path / "whole").read_bytes())
    tests = integrator.getOuterStatistics()
    assert tests.attempted == 4 * int(numSteps) and tests.accepted > 0
    assert not np.array_equal(positionsOf(context), villin.positions)
