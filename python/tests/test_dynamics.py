"""The force beside OpenMM's own force fields and integrators."""

import numpy as np
import openmm
import pytest
from openmm import app, unit
from openmmchaintree import TorsionMonteCarloIntegrator, createStericExclusionForce
from openmmchaintree.command.allpairs import HardSpheres, compare
from scenes import makeContext, makeSystem, positionsOf

_ENERGY = unit.kilojoule_per_mole
_FORCE = unit.kilojoule_per_mole / unit.nanometer


def platform(name):
    return openmm.Platform.getPlatformByName(name)


def energyOf(context, groups=-1):
    return context.getState(energy=True, groups=groups).getPotentialEnergy().value_in_unit(_ENERGY)


def stericContext(structure, tolerance, integrator, platformName="Reference"):
    """A Context in which the steric force has clashes to push apart."""
    force = createStericExclusionForce(structure.topology, structure.positions)
    force.setOverlapTolerance(tolerance)
    context = openmm.Context(makeSystem(structure, force), integrator, platform(platformName))
    context.setPositions(structure.positions)
    return force, context


def amberSystem(villin):
    """Villin in AMBER14 with implicit solvent, its steric force in a separate group."""
    forceField = app.ForceField("amber14-all.xml", "implicit/obc2.xml")
    system = forceField.createSystem(villin.topology, nonbondedMethod=app.NoCutoff)
    force = createStericExclusionForce(villin.topology, villin.positions)
    system.addForce(force)
    return system, force


def test_energyIsThatOfAllPairs(villin):
    force, context = stericContext(villin, 0.01, openmm.VerletIntegrator(0.001))
    clashes = HardSpheres(force).overlaps(villin.positions)
    expected = 0.5 * 1e5 * ((clashes.overlaps - clashes.tolerances) ** 2).sum()
    assert len(clashes.pairs) > 10
    assert energyOf(context) == pytest.approx(expected, rel=1e-9)


def test_forcesAreTheGradient(villin):
    _, context = stericContext(villin, 0.01, openmm.VerletIntegrator(0.001))
    forces = context.getState(forces=True).getForces(asNumpy=True).value_in_unit(_FORCE)
    direction = forces / np.linalg.norm(forces)
    step = 1e-7
    energies = []
    for sign in (1, -1):
        context.setPositions(villin.positions + sign * step * direction)
        energies.append(energyOf(context))
    assert (energies[0] - energies[1]) / (2 * step) == pytest.approx(-np.linalg.norm(forces), rel=1e-5)


@pytest.mark.parametrize("name", ["CPU", "OpenCL"])
def test_otherPlatformsAgree(villin, name):
    if name not in {openmm.Platform.getPlatform(i).getName() for i in range(openmm.Platform.getNumPlatforms())}:
        pytest.skip(f"OpenMM has no platform {name} here")
    results = []
    for each in ("Reference", name):
        force, context = stericContext(villin, 0.0, openmm.VerletIntegrator(0.001), each)
        forces = context.getState(forces=True).getForces(asNumpy=True).value_in_unit(_FORCE)
        results.append((energyOf(context), forces, force.getClashes(context)[0]))
    assert results[1][0] == pytest.approx(results[0][0], rel=1e-4)
    # In single precision a position is rounded by about 1e-7 nm, which the force constant turns to 0.01 kJ/mol/nm.
    assert results[1][1] == pytest.approx(results[0][1], rel=1e-3, abs=0.1)
    assert len(results[0][2]) > 10


def test_verletConservesEnergy(villin):
    _, context = stericContext(villin, 0.0, openmm.VerletIntegrator(0.0001))
    context.setVelocitiesToTemperature(10, 1)

    def totalEnergy():
        state = context.getState(energy=True)
        return (state.getPotentialEnergy() + state.getKineticEnergy()).value_in_unit(_ENERGY)

    start, potential = totalEnergy(), energyOf(context)
    context.getIntegrator().step(200)
    assert abs(totalEnergy() - start) < 1e-3 * start
    assert energyOf(context) != pytest.approx(potential, rel=0.05)


def test_minimizerRemovesClashes(villin):
    _, context = stericContext(villin, 0.03, openmm.VerletIntegrator(0.001))
    before = energyOf(context)
    openmm.LocalEnergyMinimizer.minimize(context, tolerance=0.1)
    assert energyOf(context) < 1e-3 * before


def test_langevinBesideAmber(villin):
    system, force = amberSystem(villin)
    integrator = openmm.LangevinMiddleIntegrator(300, 1, 0.0005)
    integrator.setRandomNumberSeed(1)
    context = openmm.Context(system, integrator, platform("CPU"), {"Threads": "1"})
    context.setPositions(villin.positions)
    openmm.LocalEnergyMinimizer.minimize(context, maxIterations=20)
    context.setVelocitiesToTemperature(300, 1)
    integrator.step(20)
    assert np.isfinite(energyOf(context))
    clashes = HardSpheres(force).overlaps(positionsOf(context))
    expected = 0.5 * 1e5 * ((clashes.overlaps - clashes.tolerances) ** 2).sum()
    assert energyOf(context, {31}) == pytest.approx(expected, rel=1e-4, abs=1e-3)


def metropolis(villin, temperature):
    """Run 40 trials beside AMBER; return the force, the Context and the statistics."""
    system, force = amberSystem(villin)
    integrator = TorsionMonteCarloIntegrator(temperature)
    integrator.setStericMode(integrator.Hard)
    integrator.setRandomNumberSeed(5)
    integrator.addTorsionMove(1, 0.2)
    integrator.setTrialsPerStep(40)
    context = openmm.Context(system, integrator, platform("CPU"), {"Threads": "1"})
    context.setPositions(villin.positions)
    integrator.step(1)
    return force, context, integrator.getMoveStatistics(0)


def test_metropolisBesideAmber(villin):
    force, context, (attempted, clashed, rejected, accepted) = metropolis(villin, 300)
    assert attempted == 40 == clashed + rejected + accepted
    assert clashed > 0 and rejected > 0 and accepted > 0
    spheres = HardSpheres(force)
    verdict = compare(spheres.overlaps(villin.positions), spheres.overlaps(positionsOf(context)))
    assert len(verdict.beyond.pairs) == 0


def test_heatAcceptsAllThatIsFreeOfClashes(villin):
    *_, hot = metropolis(villin, 1e9)
    assert hot.rejectedByEnergy == 0 and hot.accepted > 0
    _, context, cold = metropolis(villin, 1)
    takenBack = context.getIntegrator().getOuterStatistics().trialsTakenBack
    assert cold.rejectedByEnergy + takenBack > 0 and cold.accepted < hot.accepted


def test_twoForcesUnderTheIntegratorAreRefused(villin):
    system, _ = amberSystem(villin)
    system.addForce(createStericExclusionForce(villin.topology, villin.positions))
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.addTorsionMove(1, 0.1)
    with pytest.raises(openmm.OpenMMException, match="StericExclusionForce"):
        openmm.Context(system, integrator, platform("Reference"))


def test_stepWithoutMovesIsRefused(villin):
    integrator = TorsionMonteCarloIntegrator(300)
    context = makeContext(villin, createStericExclusionForce(villin.topology, villin.positions), integrator)
    with pytest.raises(openmm.OpenMMException, match="move"):
        integrator.step(1)
    assert np.array_equal(positionsOf(context), villin.positions)
