"""Sampling at constant pressure: by volume moves, and beside OpenMM's barostats."""

from itertools import product

import numpy as np
import openmm
import pytest
from openmm import app, unit
from openmmchaintree import StericExclusionForce, TorsionMonteCarloIntegrator

_BAR = 0.0602214076  # kJ/mol/nm^3
_THERMAL = 0.00831446261815324 * 300

_PLATFORM = openmm.Platform.getPlatformByName("Reference")


class Fluid:
    """Single particles on a lattice in a cube."""

    def __init__(self, side, width, radius):
        self.system = openmm.System()
        self.force = StericExclusionForce()
        self.force.setUsesPeriodicBoundaryConditions(True)
        self.force.setOverlapTolerance(0)
        for _ in range(side**3):
            self.system.addParticle(20)
            self.force.addParticle(radius)
        self.system.addForce(self.force)
        self.system.setDefaultPeriodicBoxVectors(*(width * np.eye(3)))
        self.positions = np.array(list(product(range(side), repeat=3))) * width / side

    def addLennardJones(self, cutoff):
        nonbonded = openmm.NonbondedForce()
        nonbonded.setNonbondedMethod(openmm.NonbondedForce.CutoffPeriodic)
        nonbonded.setCutoffDistance(cutoff)
        nonbonded.setUseSwitchingFunction(True)
        nonbonded.setSwitchingDistance(0.8 * cutoff)
        for _ in range(self.system.getNumParticles()):
            nonbonded.addParticle(0, 0.3, 1)
        self.system.addForce(nonbonded)

    def makeContext(self, integrator, platform=_PLATFORM):
        context = openmm.Context(self.system, integrator, platform)
        context.setPositions(self.positions)
        return context


def meanVolume(context, integrator, count, steps):
    """Return the mean volume (nm^3) of `count` states, some steps apart, and its standard error."""
    volumes = []
    for _ in range(count):
        integrator.step(steps)
        volumes.append(context.getState().getPeriodicBoxVolume().value_in_unit(unit.nanometer**3))
    blocks = np.reshape(volumes, (10, -1)).mean(1)
    return blocks.mean(), blocks.std(ddof=1) / np.sqrt(10)


def test_parameters():
    integrator = TorsionMonteCarloIntegrator(300)
    move = integrator.addVolumeMove(weight=2, pressure=1 * unit.megapascal, maxChange=0.02)
    weight, pressure, maxChange = integrator.getVolumeMoveParameters(move)
    assert (weight, maxChange) == (2, 0.02) and pressure.value_in_unit(unit.bar) == pytest.approx(10)
    assert pressure.unit == unit.bar
    integrator.setVolumeMoveParameters(move, 1, pressure=3, maxChange=0.5)
    assert integrator.getMoveDescription(move) == "volume at 3 bar ±0.5 (weight 1)"
    with pytest.raises(TypeError, match="pressure must be a pressure"):
        integrator.addVolumeMove(1, 1 * unit.nanometer, 0.1)


def test_hardSpheres():
    """Hard spheres at the pressure of Carnahan and Starling's equation (1969) have its density."""
    share, diameter = 0.25, 0.3
    count = 5**3
    volume = count * np.pi / 6 * diameter**3 / share
    factor = (1 + share + share**2 - share**3) / (1 - share) ** 3
    fluid = Fluid(5, np.cbrt(volume), diameter / 2)
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(2)
    integrator.setTrialsPerStep(count)
    integrator.addRigidBodyMove(1, 0.1, 0)
    integrator.addVolumeMove(3 / count, factor * count / volume * _THERMAL / _BAR, 0.02)
    context = fluid.makeContext(integrator)
    integrator.step(1000)
    mean, error = meanVolume(context, integrator, 1000, 4)
    assert mean == pytest.approx(volume, rel=0.02) and error < 0.01 * volume
    assert not fluid.force.hasClash(context)


def test_densityOfDynamics():
    """Volume moves, and OpenMM's barostat in Langevin dynamics, give a fluid one density."""
    pressure = 1200
    fluid = Fluid(5, 1.9, 0)
    fluid.addLennardJones(0.75)
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(2)
    integrator.addRigidBodyMove(1, 0.15, 0)
    integrator.addVolumeMove(0.01, pressure, 0.06)
    context = fluid.makeContext(integrator)
    integrator.step(500)
    found, error = meanVolume(context, integrator, 500, 4)
    fluid.system.addForce(openmm.MonteCarloBarostat(pressure, 300, 5))
    langevin = openmm.LangevinMiddleIntegrator(300, 2, 0.01)
    context = fluid.makeContext(langevin)
    context.setVelocitiesToTemperature(300, 1)
    langevin.step(500)
    expected, otherError = meanVolume(context, langevin, 200, 20)
    assert abs(found - expected) < 4 * np.hypot(error, otherError)
    assert max(error, otherError) < 0.015 * expected


BAROSTATS = {
    "isotropic": lambda: openmm.MonteCarloBarostat(900, 300, 1),
    "anisotropic": lambda: openmm.MonteCarloAnisotropicBarostat(openmm.Vec3(900, 500, 1200), 300, True, False, True, 1),
    "membrane": lambda: openmm.MonteCarloMembraneBarostat(
        900, 10, 300, openmm.MonteCarloMembraneBarostat.XYIsotropic, openmm.MonteCarloMembraneBarostat.ZFree, 1
    ),
    "flexible": lambda: openmm.MonteCarloFlexibleBarostat(900, 300, 1),
}


@pytest.mark.parametrize("mode", ["Off", "Soft"])
@pytest.mark.parametrize("name", BAROSTATS)
def test_barostatsInTurns(name, mode):
    """Boxes that a barostat has changed are those of trials, in which energies are OpenMM's."""
    fluid = Fluid(5, 1.9, 0.14)
    fluid.force.setForceConstant(1000)
    fluid.addLennardJones(0.7)
    fluid.system.addForce(BAROSTATS[name]())
    compound = openmm.CompoundIntegrator()
    sampler = TorsionMonteCarloIntegrator(300)
    sampler.setStericMode(getattr(sampler, mode))
    sampler.addRigidBodyMove(1, 0.15, 0)
    compound.addIntegrator(sampler)
    compound.addIntegrator(openmm.LangevinMiddleIntegrator(300, 2, 0.005))
    context = fluid.makeContext(compound, openmm.Platform.getPlatformByName("CPU"))
    context.setVelocitiesToTemperature(300, 1)
    boxes = set()
    for _ in range(10):
        for current in (1, 0):
            compound.setCurrentIntegrator(current)
            compound.step(5)
            state = context.getState(getEnergy=True)
            energy = state.getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)
            assert sampler.getPotentialEnergy(context) == pytest.approx(energy, abs=0.05)
            boxes.add(str(state.getPeriodicBoxVectors()))
    assert len(boxes) > 15  # it also acts in steps of trials
    assert sampler.getMoveStatistics(0).accepted > 100
    sampler.setStericMode(sampler.Hard)
    with pytest.raises(openmm.OpenMMException, match="which ignores hard spheres"):
        compound.step(1)


def test_dynamicsInTurns():
    """Volume moves take turns with dynamics at constant volume, and leave its velocities alone."""
    fluid = Fluid(5, 1.9, 0)
    fluid.addLennardJones(0.7)
    compound = openmm.CompoundIntegrator()
    sampler = TorsionMonteCarloIntegrator(300)
    sampler.addVolumeMove(1, 900, 0.03)
    sampler.setTrialsPerStep(20)
    compound.addIntegrator(openmm.LangevinMiddleIntegrator(300, 2, 0.005))
    compound.addIntegrator(sampler)
    context = fluid.makeContext(compound)
    context.setVelocitiesToTemperature(300, 1)
    for _ in range(5):
        compound.setCurrentIntegrator(0)
        compound.step(10)
        before = context.getState(getVelocities=True)
        compound.setCurrentIntegrator(1)
        compound.step(1)
        after = context.getState(getVelocities=True, getEnergy=True)
        assert np.array_equal(before.getVelocities(asNumpy=True), after.getVelocities(asNumpy=True))
        assert after.getPeriodicBoxVolume() != before.getPeriodicBoxVolume()
        energy = after.getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)
        assert sampler.getPotentialEnergy(context) == pytest.approx(energy, abs=0.05)


def test_reporters(tmp_path):
    """Reporters and States see the box of each step."""
    fluid = Fluid(3, 2.4, 0.1)
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.addRigidBodyMove(1, 0.2, 0)
    integrator.addVolumeMove(1, 100, 0.3)
    topology = app.Topology()
    topology.setPeriodicBoxVectors(2.4 * np.eye(3))
    residue = topology.addResidue("AR", topology.addChain())
    for _ in range(27):
        topology.addAtom("Ar", app.Element.getBySymbol("Ar"), residue)
    simulation = app.Simulation(topology, fluid.system, integrator, _PLATFORM)
    simulation.context.setPositions(fluid.positions)
    log = tmp_path / "log.csv"
    simulation.reporters.append(app.StateDataReporter(str(log), 1, volume=True))
    volumes = []
    for _ in range(5):
        simulation.step(1)
        volumes.append(simulation.context.getState().getPeriodicBoxVolume()._value)
    written = np.loadtxt(log, skiprows=1)
    assert written == pytest.approx(np.array(volumes)) and len(set(volumes)) == 5
