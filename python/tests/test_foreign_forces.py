"""Forces that only OpenMM can evaluate, in the group of all others: counted, as the plan says; and ones that change."""

import re

import numpy as np
import openmm
import pytest
from openmm import app
from openmmchaintree import TorsionMonteCarloIntegrator, createStericExclusionForce
from scenes import makeSystem

CPU = openmm.Platform.getPlatformByName("CPU")


def makeIntegrator(trialsPerStep=50):
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(1)
    integrator.setTrialsPerStep(trialsPerStep)
    integrator.addTorsionMove(1, 0.02)
    return integrator


def makeContext(system, integrator, positions):
    context = openmm.Context(system, integrator, CPU, {"Threads": "1"})
    context.setPositions(positions)
    return context


def readPlan(integrator, context):
    return {entry.name: entry for entry in integrator.getEnergyPlan(context)}


def energyByOpenMM(context):
    """Return the energy of all Forces except the spheres, which have a separate group."""
    (spheres,) = (each for each in context.getSystem().getForces() if each.getName() == "StericExclusionForce")
    groups = set(range(32)) - {spheres.getForceGroup()}
    return context.getState(energy=True, groups=groups).getPotentialEnergy()._value


def addPeriodicRestraints(system, villin):
    restraint = openmm.CustomExternalForce("k*periodicdistance(x, y, z, x0, y0, z0)^2")
    restraint.addGlobalParameter("k", 100)
    for coordinate in "xyz":
        restraint.addPerParticleParameter(coordinate + "0")
    for atom in villin.topology.atoms():
        if atom.name == "CA":
            restraint.addParticle(atom.index, villin.positions[atom.index])
    system.addForce(restraint)


@pytest.mark.skipif(not hasattr(openmm, "PythonForce"), reason="this OpenMM has no PythonForce")
@pytest.mark.parametrize("height, interval", [(0.5, 50), (1e4, 1)])
def test_countedEvaluations(villin, height, interval):
    """The plan predicts the number of calls of the Python energy."""
    count = 0

    def compute(state):
        nonlocal count
        count += 1
        x = state.getPositions(asNumpy=True)._value
        return height * np.sin(50 * x[-1, 0]), np.zeros(x.shape)

    system = app.ForceField("amber14-all.xml", "implicit/gbn2.xml").createSystem(villin.topology)
    system.addForce(openmm.PythonForce(compute))
    system.addForce(createStericExclusionForce(villin.topology, villin.positions))
    integrator = makeIntegrator()
    integrator.setStericMode(integrator.Hard)  # so that each outer test keeps its trials, and they are counted
    context = makeContext(system, integrator, villin.positions)
    while "measured" in (reason := readPlan(integrator, context)["PythonForce"].reason) or count == 0:
        assert "OpenMM evaluates it at each outer test, every " in reason
        integrator.step(1)
    integrator.resetMoveStatistics()
    count = 0
    integrator.step(10)
    plan, tests = readPlan(integrator, context), integrator.getOuterStatistics()
    solvent = "openmm-chaintree evaluates it at each outer test, every 50 trials; trials use a stand-in"
    assert plan["CustomGBForce"].reason == solvent
    assert tests.attempted == 10
    if interval == 1:
        assert plan["PythonForce"].reason.startswith("OpenMM evaluates it in each trial: ")
        assert count == 10 + integrator.getStageStatistics()[-1].computed
    else:
        assert plan["PythonForce"].reason.startswith("OpenMM evaluates it at each outer test, every 50 trials: ")
        assert count == 10 + tests.attempted


def test_periodicRestraints(villin):
    """The restraints of OpenMM's cookbook, beside implicit solvent, cost neither stand-ins nor outer tests."""
    system = app.ForceField("amber14-all.xml", "implicit/gbn2.xml").createSystem(villin.topology)
    addPeriodicRestraints(system, villin)
    system.addForce(createStericExclusionForce(villin.topology, villin.positions))
    integrator = makeIntegrator()
    context = makeContext(system, integrator, villin.positions)
    integrator.step(3)
    assert integrator.getOuterStatistics().attempted == 3 * 5
    assert integrator.getStageStatistics()[-1].computed == 0
    reason = readPlan(integrator, context)["CustomExternalForce"].reason
    assert re.match("OpenMM evaluates it at each outer test, every 12 trials while its spread is measured: ", reason)
    assert integrator.getPotentialEnergy(context) == pytest.approx(energyByOpenMM(context), abs=0.1)


def test_wholeNonbondedForce(villin):
    """It changes too much to be left to an outer test."""
    system = app.ForceField("amber14-all.xml").createSystem(villin.topology)
    (force,) = (force for force in system.getForces() if isinstance(force, openmm.NonbondedForce))
    force.setNonbondedMethod(force.CutoffPeriodic)
    system.setDefaultPeriodicBoxVectors((9, 0, 0), (0, 9, 0), (0, 0, 9))
    system.addForce(createStericExclusionForce(villin.topology, villin.positions))
    integrator = makeIntegrator(240)
    integrator.addTorsionMove(1, np.pi)
    context = makeContext(system, integrator, villin.positions)
    integrator.step(1)
    reason = readPlan(integrator, context)["NonbondedForce"].reason
    assert reason == "OpenMM evaluates it in each trial: its cutoff is periodic"
    assert integrator.getOuterStatistics().attempted == 20
    integrator.setTrialsPerStep(20)
    integrator.step(1)
    assert integrator.getOuterStatistics().attempted == 20
    assert integrator.getStageStatistics()[-1].computed > 0


def test_metadynamics(villin):
    """Hills are a tabulated function that changes in the Context."""
    system = makeSystem(villin, createStericExclusionForce(villin.topology, villin.positions))
    distance = openmm.CustomCentroidBondForce(2, "distance(g1,g2)")
    distance.addGroup([0, 1, 2, 3])
    distance.addGroup([570, 571, 572])
    distance.addBond([0, 1], [])
    variable = app.BiasVariable(distance, 0, 10, 0.5)
    bias = app.Metadynamics(system, [variable], 300, 5, 2, 2)
    integrator = makeIntegrator()
    simulation = app.Simulation(villin.topology, system, integrator, CPU)
    simulation.context.setPositions(villin.positions)
    energies = []
    for _ in range(5):
        bias.step(simulation, 2)
        energies.append(integrator.getPotentialEnergy(simulation.context))
        assert energies[-1] == pytest.approx(energyByOpenMM(simulation.context), abs=1e-6)
    assert energies[-1] > energies[0] > 0
