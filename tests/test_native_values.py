"""Energies of CustomGBForces that are no generalized Born model, against OpenMM's Reference platform."""

import math

import openmm
import pytest
from realsystems import Reference, Run
from test_native_solvent import assertEnergy, makeSolvated

REASON = "openmm-chaintree evaluates all of it "


def findSolvent(system):
    return next(force for force in system.getForces() if isinstance(force, openmm.CustomGBForce))


def addOwnTerm(force):
    """Make a model that nobody knows of one that is known."""
    force.addEnergyTerm("0.05*charge^2*B^2", openmm.CustomGBForce.SingleParticle)


def makeScreened(system, solvent):
    """Screened charges as Debye and Hückel have them, weaker where there are neighbours."""
    force = openmm.CustomGBForce()
    force.addPerParticleParameter("q")
    force.addGlobalParameter("length", 0.8)
    force.addComputedValue("crowd", "exp(-(r/0.35)^2)", openmm.CustomGBForce.ParticlePair)
    force.addComputedValue("charge", "q/(1+0.02*crowd)", openmm.CustomGBForce.SingleParticle)
    force.addEnergyTerm("138.935456/78.5*charge1*charge2*exp(-r/length)/r", openmm.CustomGBForce.ParticlePair)
    force.addEnergyTerm("0.3*crowd", openmm.CustomGBForce.SingleParticle)
    for particle in range(solvent.getNumParticles()):
        force.addParticle([solvent.getParticleParameters(particle)[0]])
    return force


def makeGaussian(system, solvent):
    """Solvent exclusion by Gaussians, as in EEF1."""
    force = openmm.CustomGBForce()
    for name in ("radius", "volume", "free", "length"):
        force.addPerParticleParameter(name)
    force.addComputedValue(
        "covered",
        f"volume2/({2 * math.pi**1.5}*length1*r^2)*exp(-((r-radius1)/length1)^2)",
        openmm.CustomGBForce.ParticlePair,
    )
    force.addEnergyTerm("free*(1-covered)", openmm.CustomGBForce.SingleParticle)
    for particle in range(solvent.getNumParticles()):
        radius = solvent.getParticleParameters(particle)[1] + 0.0195
        free = -4 if particle % 7 == 0 else -0.5
        force.addParticle([radius, 0.015 + 0.001 * (particle % 5), free, 0.35 if particle % 3 else 0.6])
    return force


def replaceSolvent(system, make):
    solvent = findSolvent(system)
    force = make(system, solvent)
    nonbonded = next(force for force in system.getForces() if isinstance(force, openmm.NonbondedForce))
    for index in range(nonbonded.getNumExceptions()):
        force.addExclusion(*nonbonded.getExceptionParameters(index)[:2])
    if solvent.getNonbondedMethod() == openmm.CustomGBForce.CutoffNonPeriodic:
        force.setNonbondedMethod(openmm.CustomGBForce.CutoffNonPeriodic)
        force.setCutoffDistance(solvent.getCutoffDistance())
    for index in range(system.getNumForces()):
        if isinstance(system.getForce(index), openmm.CustomGBForce):
            system.removeForce(index)
            break
    system.addForce(force)
    return force


def checkValues(system, positions, trials, trialsPerTest):
    """Compare the Force's energy at the start and after some trials, and see that OpenMM is asked for none of it."""
    run, reference = Run(system, positions), Reference(system)
    run.integrator.setTrialsPerOuterTest(trialsPerTest)
    (entry,) = (entry for entry in run.integrator.getEnergyPlan(run.context) if entry.name == "CustomGBForce")
    assert entry.kind == "native" and entry.reason.startswith(REASON)
    assertEnergy(run, reference)
    run.run(trials)
    assert run.accepted > 0
    assertEnergy(run, reference)
    computed = {stage.stage: stage.computed for stage in run.integrator.getStageStatistics()}
    assert computed["foreign forces"] == 0
    assert (computed["computed values"] > 0) == (trialsPerTest == 0)
    assert (run.integrator.getOuterStatistics().attempted > 0) == (trialsPerTest > 0)


@pytest.mark.parametrize("method", ["no cutoff", "reaction field"])
@pytest.mark.parametrize("model", ["gbn2", "obc2"])
def test_model_with_a_term_of_its_own(model, method):
    system, _, positions = makeSolvated("villin", model, method)
    addOwnTerm(findSolvent(system))
    checkValues(system, positions, 200, 0)
    checkValues(system, positions, 200, 5)


@pytest.mark.parametrize("method", ["no cutoff", "reaction field"])
@pytest.mark.parametrize("make", [makeScreened, makeGaussian])
def test_other_models(make, method):
    system, _, positions = makeSolvated("villin", "gbn2", method)
    replaceSolvent(system, make)
    checkValues(system, positions, 200, 0)
    checkValues(system, positions, 200, 5)


@pytest.mark.parametrize("name", ["1ubi_h", "1bna"])
def test_large_molecules(name):
    system, _, positions = makeSolvated(name, "gbn2")
    addOwnTerm(findSolvent(system))
    reference = Reference(system)
    groups = {force.getName(): 1 << index for index, force in enumerate(system.getForces())}
    findSolvent(system).setForceGroup(3)
    run = Run(system, positions)
    run.integrator.setIntegrationForceGroups({3})
    expected = reference.energy(run.positions, groups["CustomGBForce"])
    assert run.energy == pytest.approx(expected, rel=1e-6, abs=5e-3)


def test_energy_follows_parameters():
    system, _, positions = makeSolvated("alanine dipeptide", "gbn2")
    force = replaceSolvent(system, makeScreened)
    run = Run(system, positions)
    run.run(1000)
    assertEnergy(run, Reference(system))
    force.setParticleParameters(5, [-0.9])
    force.updateParametersInContext(run.context)
    run.run(1000)
    assertEnergy(run, Reference(system))
    run.context.setParameter("length", 0.3)
    force.setGlobalParameterDefaultValue(0, 0.3)
    before = run.positions
    run.run(1000)
    assert (run.positions != before).any()
    assertEnergy(run, Reference(system))
