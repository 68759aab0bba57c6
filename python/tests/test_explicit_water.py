"""A peptide in a periodic box of water with PME: its torsions turn, and water stays as it is."""

import random

import numpy as np
import openmm
import pytest
from openmm import app, unit
from openmmchaintree import TorsionMonteCarloIntegrator, addDefaultMoves, createStericExclusionForce
from peptides import makePeptides
from scenes import positionsOf

_STERIC_GROUP = 31


@pytest.fixture(scope="module", params=["tip3p", "tip4pew"])
def solvated(request):
    """Return a Topology, positions, the number of atoms of the solute, and its System, as users of OpenMM build it."""
    topology, positions = makePeptides(("ACE", "LYS", "ASP", "PHE", "NME"))
    forceField = app.ForceField("amber14/protein.ff14SB.xml", f"amber14/{request.param}.xml")
    modeller = app.Modeller(topology, positions * unit.nanometer)
    modeller.addHydrogens(forceField)
    count = modeller.topology.getNumAtoms()
    random.seed(1)  # places the ions
    model = "tip4pew" if request.param == "tip4pew" else "tip3p"
    modeller.addSolvent(forceField, model, padding=0.7 * unit.nanometer, ionicStrength=0.2 * unit.molar)
    system = forceField.createSystem(
        modeller.topology, nonbondedMethod=app.PME, nonbondedCutoff=0.9 * unit.nanometer, constraints=app.HBonds
    )
    return modeller.topology, modeller.positions, count, system


def relax(system, positions):
    integrator = openmm.LangevinMiddleIntegrator(300, 10, 0.001)
    integrator.setRandomNumberSeed(1)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("CPU"), {"Threads": "1"})
    context.setPositions(positions)
    context.computeVirtualSites()
    openmm.LocalEnergyMinimizer.minimize(context, maxIterations=50)
    integrator.step(100)
    return positionsOf(context)


def test_peptideInWater(solvated):
    topology, positions, count, system = solvated
    positions = relax(system, positions)
    sampled = openmm.XmlSerializer.clone(system)
    force = createStericExclusionForce(topology, positions, system=sampled, forceGroup=_STERIC_GROUP)
    assert force.usesPeriodicBoundaryConditions()
    sampled.addForce(force)
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(2)
    moves = addDefaultMoves(integrator, topology, sampled)
    (rigid,) = [move.move for move in moves if integrator.getMoveType(move.move) == integrator.RigidBodyMove]
    assert integrator.getRigidBodyMoveParameters(rigid)[3].tolist() == [0]
    integrator.setTrialsPerStep(400)
    context = openmm.Context(sampled, integrator, openmm.Platform.getPlatformByName("CPU"), {"Threads": "1"})
    context.setPositions(positions)
    before = np.array(integrator.getTorsionAngles(context))
    for _ in range(20):
        integrator.step(1)
        present = positionsOf(context)
        assert np.array_equal(present[count:], positions[count:].astype(present.dtype))
        assert abs(integrator.getPotentialEnergy(context) - wholeEnergy(context)) < 0.5

    # The solute has moved, its early refusals included, and OpenMM has evaluated nothing in a trial.

    assert np.sum(np.abs(np.array(integrator.getTorsionAngles(context)) - before) > 0.05) > 10
    statistics = [integrator.getMoveStatistics(move) for move in range(integrator.getNumMoves())]
    assert sum(one.accepted for one in statistics) > 300 and sum(one.clashed for one in statistics) > 300
    stages = {stage.stage: stage.computed for stage in integrator.getStageStatistics()}
    assert stages["foreign forces"] == 0 and stages["near pairs"] > 1000
    tests = integrator.getOuterStatistics()
    assert 20 <= tests.attempted < 400 and tests.accepted > 0.5 * tests.attempted  # of 8,000 trials
    plan = integrator.getEnergyPlan(context)
    assert {entry.kind for entry in plan} == {"native", "constant", "not sampled"}
    assert any("evaluates its reciprocal space at each outer test, every" in entry.reason for entry in plan)

    # The same by a Context that knows nothing of this package.

    reference = openmm.Context(system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatformByName("Reference"))
    reference.setPositions(positionsOf(context))
    expected = reference.getState(energy=True).getPotentialEnergy().value_in_unit(unit.kilojoules_per_mole)
    assert integrator.getPotentialEnergy(context) == pytest.approx(expected, abs=0.5)


def wholeEnergy(context):
    groups = set(range(32)) - {_STERIC_GROUP}
    return context.getState(energy=True, groups=groups).getPotentialEnergy().value_in_unit(unit.kilojoules_per_mole)
