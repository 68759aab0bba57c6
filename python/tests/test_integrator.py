"""The face of TorsionMonteCarloIntegrator in Python, and its life in OpenMM's application layer."""

import copy
import csv
import io

import numpy as np
import openmm
import pytest
from openmm import app, unit
from openmmchaintree import MoveStatistics, TorsionMonteCarloIntegrator, createStericExclusionForce
from openmmchaintree.command.geometry import dihedrals
from scenes import makeContext, makeSystem, positionsOf, readDCD


def test_moveStatistics(villinRun):
    _, integrator, context = villinRun
    integrator.setTrialsPerStep(500)
    integrator.step(2)
    statistics = integrator.getMoveStatistics(0)
    assert isinstance(statistics, MoveStatistics)
    assert statistics.attempted == 1000 == statistics.clashed + statistics.rejectedByEnergy + statistics.accepted
    assert statistics.rejectedByEnergy == 0
    assert 0 < statistics.accepted < 1000
    integrator.resetMoveStatistics()
    assert integrator.getMoveStatistics(0) == (0, 0, 0, 0)


def test_moveParameters():
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.addTorsionMove(0.5, 0.2, [4, 0], 2)
    integrator.addRigidBodyMove(2, 0.1, 0.3)
    assert integrator.getMoveType(0) == TorsionMonteCarloIntegrator.TorsionMove
    weight, angle, torsions, count = integrator.getTorsionMoveParameters(0)
    assert (weight, angle, torsions.tolist(), count) == (0.5, 0.2 * unit.radian, [4, 0], 2)
    assert integrator.getMoveType(1) == TorsionMonteCarloIntegrator.RigidBodyMove
    weight, translation, angle, molecules = integrator.getRigidBodyMoveParameters(1)
    assert (weight, translation, angle) == (2, 0.1 * unit.nanometer, 0.3 * unit.radian)
    assert molecules is None
    with pytest.raises(openmm.OpenMMException, match="move 0 is not a rigid body move"):
        integrator.getRigidBodyMoveParameters(0)


def test_movesAreSetAsTheyAreRead():
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.addTorsionMove(1, 0.1)
    integrator.addRigidBodyMove(1, 0.1, 0.1)
    integrator.addTorsionMove(1, 0.1, [3])
    for torsions in (None, [2, 1]):
        integrator.setTorsionMoveParameters(0, 2, 10 * unit.degrees, torsions, 2)
        weight, angle, found, count = integrator.getTorsionMoveParameters(0)
        assert (weight, count) == (2, 2)
        assert angle.value_in_unit(unit.degrees) == pytest.approx(10)
        assert found is None if torsions is None else found.tolist() == torsions
        integrator.setTorsionMoveParameters(0, *integrator.getTorsionMoveParameters(0))
    integrator.setRigidBodyMoveParameters(1, weight=0.5, maxTranslation=1 * unit.angstrom, maxAngle=0.2, molecules=[4])
    assert integrator.getRigidBodyMoveParameters(1)[3].tolist() == [4]
    integrator.setRigidBodyMoveParameters(1, *integrator.getRigidBodyMoveParameters(1))
    closed = integrator.addClosedMove(1, 10 * unit.degrees, hop=0.5)
    assert integrator.getMoveType(closed) == TorsionMonteCarloIntegrator.ClosedMove
    weight, angle, found, hop = integrator.getClosedMoveParameters(closed)
    assert (weight, found, hop) == (1, None, 0.5)
    assert angle.value_in_unit(unit.degrees) == pytest.approx(10)
    integrator.setClosedMoveParameters(closed, weight=2, maxAngle=0.1, torsions=[2, 1], hop=0)
    integrator.setClosedMoveParameters(closed, *integrator.getClosedMoveParameters(closed))
    weight, angle, found, hop = integrator.getClosedMoveParameters(closed)
    assert (weight, angle, found.tolist(), hop) == (2, 0.1 * unit.radian, [2, 1], 0)
    integrator.removeMove(closed)
    integrator.removeMove(0)
    assert integrator.getNumMoves() == 2
    assert integrator.getTorsionMoveParameters(1)[2].tolist() == [3]


def test_localMoves():
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.addLocalMove(0.5, 10 * unit.degrees, 4 / unit.angstrom**2, [4, 0], window=2)
    assert integrator.getMoveType(0) == TorsionMonteCarloIntegrator.LocalMove
    weight, sigma, stiffness, torsions, window = integrator.getLocalMoveParameters(0)
    assert (weight, torsions.tolist(), window) == (0.5, [4, 0], 2)
    assert sigma.value_in_unit(unit.degrees) == pytest.approx(10)
    assert stiffness.value_in_unit(unit.nanometer**-2) == pytest.approx(400)
    integrator.setLocalMoveParameters(0, weight=1, sigma=0.1, stiffness=50)
    assert integrator.getLocalMoveParameters(0)[3:] == [None, 8]
    integrator.setLocalMoveParameters(0, *integrator.getLocalMoveParameters(0))
    with pytest.raises(TypeError, match="stiffness must be an inverse square of a length"):
        integrator.addLocalMove(1, 0.1, 4 / unit.angstrom)
    with pytest.raises(openmm.OpenMMException, match="torsions is empty.*None means all of them"):
        integrator.addLocalMove(1, 0.1, 50, [])


def test_sizesAdaptInEquilibration(villinRun):
    _, integrator, context = villinRun
    integrator.setTorsionMoveParameters(0, 1, 180 * unit.degrees)
    integrator.setAdaptMoveSizes(True)
    integrator.step(200)
    integrator.setAdaptMoveSizes(False)
    assert integrator.getMoveStatistics(0).attempted == 0
    scale = integrator.getMoveScale(0)
    assert 0 < scale < 1
    assert f"scaled by {scale:.3g}" in integrator.getMoveDescription(0)
    integrator.setMoveScale(0, scale=1)
    assert integrator.getMoveScale(0) == 1


def test_noTorsionsAreNotAllTorsions():
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.addTorsionMove(1, 0.1, torsions=None)
    integrator.addRigidBodyMove(1, 0.1, 0.1, None)
    for empty in ([], (), np.array([], int)):
        with pytest.raises(openmm.OpenMMException, match="torsions is empty.*None means all of them"):
            integrator.addTorsionMove(1, 0.1, torsions=empty)
        with pytest.raises(openmm.OpenMMException, match="torsions is empty"):
            integrator.setTorsionMoveParameters(0, 1, 0.1, empty)
        with pytest.raises(openmm.OpenMMException, match="torsions is empty"):
            integrator.addClosedMove(1, 0.1, empty)
        with pytest.raises(openmm.OpenMMException, match="molecules is empty"):
            integrator.addRigidBodyMove(1, 0.1, 0.1, empty)
        with pytest.raises(openmm.OpenMMException, match="molecules is empty"):
            integrator.setRigidBodyMoveParameters(1, 1, 0.1, 0.1, empty)
    assert integrator.getNumMoves() == 2


def test_anglesInDegreesAreHintedAt():
    integrator = TorsionMonteCarloIntegrator(300)
    with pytest.raises(openmm.OpenMMException, match=r"but is 20 radians.*in Python 20\*unit.degrees"):
        integrator.addTorsionMove(1, 20)
    integrator.addTorsionMove(1, 20 * unit.degrees)
    integrator.addTorsionMove(1, 180 * unit.degrees)
    integrator.addRigidBodyMove(1, 0.1, 180 * unit.degrees)


def test_repr():
    integrator = TorsionMonteCarloIntegrator(300)
    assert repr(integrator) == "<TorsionMonteCarloIntegrator: 300 K, 100 trials a step, 0 moves>"
    integrator.addTorsionMove(1, 0.2)
    assert repr(integrator) == (
        "<TorsionMonteCarloIntegrator: 300 K, 100 trials a step, 1 move: torsion ±0.2 rad (weight 1, all torsions)>"
    )
    integrator.setTemperature(310.5)
    integrator.setTrialsPerStep(2000)
    integrator.addTorsionMove(0.5, 1, range(12), 3)
    integrator.addRigidBodyMove(0.1, 0.05, 0.1)
    integrator.addRigidBodyMove(0.1, 0.05, 0.1, [3])
    assert str(integrator) == (
        "<TorsionMonteCarloIntegrator: 310.5 K, 2,000 trials a step, 4 moves: "
        "torsion ±0.2 rad (weight 1, all torsions), 3 torsions ±1 rad (weight 0.5, 12 torsions to choose from), "
        "rigid body ±0.05 nm ±0.1 rad (weight 0.1, all molecules), "
        "rigid body ±0.05 nm ±0.1 rad (weight 0.1, 1 molecule to choose from)>"
    )
    integrator.addTorsionMove(1, 0.3)
    integrator.setStericMode(integrator.Soft)
    assert ": 310.5 K, 2,000 trials a step, soft spheres, 5 moves: torsion ±0.2 rad" in repr(integrator)
    assert repr(integrator).endswith(", ...>")


def test_sameSeedSameTrajectory(villin):
    def end(seed):
        integrator = TorsionMonteCarloIntegrator(300)
        integrator.setRandomNumberSeed(seed)
        integrator.addTorsionMove(1, 0.3, count=2)
        integrator.addRigidBodyMove(1, 0.1, 0.1)
        force = createStericExclusionForce(villin.topology, villin.positions)
        context = makeContext(villin, force, integrator)
        integrator.step(5)
        return positionsOf(context)

    assert np.array_equal(end(7), end(7))
    assert not np.array_equal(end(7), end(8))


def test_torsionAngles(villinRun):
    force, integrator, context = villinRun
    quadruples = np.array([force.getTorsionParticles(i) for i in range(force.getNumTorsions())])
    integrator.step(10)
    angles = integrator.getTorsionAngles(context)
    assert angles.dtype == np.float64 and angles.shape == (138,)
    assert np.array_equal(angles, force.getTorsionAngles(context))
    expected = dihedrals(positionsOf(context), quadruples)
    assert np.exp(1j * angles) == pytest.approx(np.exp(1j * expected), abs=1e-9)

    assert integrator.setTorsionAngles(context, np.degrees(angles[::-1]) * unit.degrees) is None
    expected = dihedrals(positionsOf(context), quadruples)
    assert np.exp(1j * angles[::-1]) == pytest.approx(np.exp(1j * expected), abs=1e-9)


def test_toleratedClashes(villinRun):
    force, integrator, context = villinRun
    assert integrator.getNumToleratedClashes(context) == 0 == force.getNumToleratedClashes(context)
    integrator.step(1)
    assert integrator.getNumToleratedClashes(context) == 1 == force.getNumToleratedClashes(context)


def test_refusedClash(villin):
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.addTorsionMove(1, 0.3)
    integrator.setInitialClashPolicy(integrator.Refuse)
    context = makeContext(villin, createStericExclusionForce(villin.topology, villin.positions), integrator)
    with pytest.raises(openmm.OpenMMException, match="149.*528"):
        integrator.step(1)
    assert np.array_equal(positionsOf(context), villin.positions)


def test_softSpheres(villin):
    """At a temperature of 0 the energy of the spheres can only fall, and clashes refuse nothing."""
    force = createStericExclusionForce(villin.topology, villin.positions)
    force.setOverlapTolerance(0.0)
    integrator = TorsionMonteCarloIntegrator(0)
    assert integrator.getStericMode() == TorsionMonteCarloIntegrator.Automatic
    integrator.setStericMode(TorsionMonteCarloIntegrator.Soft)
    integrator.addTorsionMove(1, 0.1)
    context = makeContext(villin, force, integrator)
    energies = [context.getState(energy=True).getPotentialEnergy()._value]
    for _ in range(5):
        integrator.step(1)
        energies.append(context.getState(energy=True).getPotentialEnergy()._value)
    assert energies[0] > energies[-1] > 0
    assert energies == sorted(energies, reverse=True)
    assert integrator.getMoveStatistics(0).clashed == 0
    assert integrator.getNumToleratedClashes(context) == 0

    integrator.setStericMode(TorsionMonteCarloIntegrator.Hard)
    clashes = len(force.getClashes(context)[0])
    integrator.step(1)
    assert integrator.getNumToleratedClashes(context) == clashes > 0
    force.restartLimits(context)
    assert integrator.getNumToleratedClashes(context) == 0
    with pytest.raises(openmm.OpenMMException, match="Automatic, Off, Hard or Soft"):
        integrator.setStericMode(4)


def test_simulationWithReporters(villin, tmp_path):
    integrator = TorsionMonteCarloIntegrator(300 * unit.kelvin)
    integrator.setRandomNumberSeed(3)
    integrator.addTorsionMove(1, 20 * unit.degrees)
    system = makeSystem(villin, createStericExclusionForce(villin.topology, villin.positions))
    platform = openmm.Platform.getPlatformByName("Reference")
    simulation = app.Simulation(villin.topology, system, integrator, platform)
    simulation.context.setPositions(villin.positions)
    log = io.StringIO()
    path = tmp_path / "trajectory.dcd"
    simulation.reporters.append(app.DCDReporter(str(path), 5))
    simulation.reporters.append(
        app.StateDataReporter(log, 5, step=True, potentialEnergy=True, temperature=True, speed=True)
    )
    simulation.step(25)
    del simulation.reporters[:]

    assert simulation.currentStep == 25
    assert integrator.getMoveStatistics(0).attempted == 2500
    frames = readDCD(path)
    assert frames.shape == (5, villin.topology.getNumAtoms(), 3)
    assert frames[-1] == pytest.approx(positionsOf(simulation.context), abs=1e-5)
    header, *rows = log.getvalue().splitlines()
    temperature = header.split(",").index('"Temperature (K)"')
    assert len(rows) == 5 and all(float(row.split(",")[temperature]) == 300 for row in rows)


def test_whatAStateDataReporterShows(villin):
    """No time passes, unless a step is given a length; that changes nothing else."""
    force = createStericExclusionForce(villin.topology, villin.positions)
    reports = []
    for stepSize in (0, 1 * unit.nanosecond):
        integrator = TorsionMonteCarloIntegrator(300 * unit.kelvin)
        integrator.setRandomNumberSeed(3)
        integrator.setStepSize(stepSize)
        integrator.addTorsionMove(1, 20 * unit.degrees)
        system = makeSystem(villin, copy.copy(force))
        simulation = app.Simulation(villin.topology, system, integrator, openmm.Platform.getPlatformByName("Reference"))
        simulation.context.setPositions(villin.positions)
        log = io.StringIO()
        columns = "step time kineticEnergy temperature progress remainingTime speed elapsedTime".split()
        options = dict.fromkeys(columns, True)
        simulation.reporters.append(app.StateDataReporter(log, 5, totalSteps=20, **options))
        simulation.step(20)
        reports.append([dict(zip(columns, row, strict=True)) for row in inOrder(log.getvalue())])
        reports[-1].append(positionsOf(simulation.context))
    for report, factor in zip(reports, (0, 1000), strict=True):
        for number, row in enumerate(report[:4], start=1):
            assert row["step"] == str(5 * number) and row["progress"] == f"{25 * number:.1f}%"
            assert float(row["time"]) == 5 * number * factor
            assert float(row["kineticEnergy"]) == 0 and float(row["temperature"]) == 300
            assert float(row["elapsedTime"]) >= 0 and row["remainingTime"] == ("--" if number == 1 else "0:00")
            if number > 1:
                assert (float(row["speed"]) > 0) == (factor > 0)
    assert np.array_equal(reports[0][-1], reports[1][-1])


def inOrder(text):
    """Return the rows of a StateDataReporter in the order of the columns of the test above."""
    names = ["Step", "Time (ps)", "Kinetic Energy (kJ/mole)", "Temperature (K)", "Progress (%)", "Time Remaining"]
    names += ["Speed (ns/day)", "Elapsed Time (s)"]
    header, *rows = csv.reader(text.lstrip("#").splitlines())
    return [[row[header.index(name)] for name in names] for row in rows]


def test_castFromCompoundIntegrator(villin):
    compound = openmm.CompoundIntegrator()
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.addTorsionMove(1, 0.1)
    compound.addIntegrator(integrator)
    compound.addIntegrator(openmm.VerletIntegrator(0.001))
    assert TorsionMonteCarloIntegrator.isinstance(compound.getIntegrator(0))
    assert not TorsionMonteCarloIntegrator.isinstance(compound.getIntegrator(1))
    assert TorsionMonteCarloIntegrator.cast(compound.getIntegrator(0)).getNumMoves() == 1


def test_integratorWithoutForceIsRefused(villin):
    system = openmm.System()
    system.addParticle(1.0)
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.addTorsionMove(1, 0.1)
    with pytest.raises(openmm.OpenMMException, match="StericExclusionForce"):
        openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
