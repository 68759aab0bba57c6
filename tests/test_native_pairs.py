"""Energies of pairs by expressions, of real force fields and of models that users write, against OpenMM's Reference
platform.
"""

import numpy as np
import openmm
import pytest
from openmm import unit
from openmmchaintree import StericExclusionForce
from realsystems import METHODS, Run, makeSystem
from test_native_energies import runAndCompare

CHARMM = "charmm36.xml"


def kinds(system, positions):
    run = Run(system, positions)
    return {entry.name: entry.kind for entry in run.integrator.getEnergyPlan(run.context)}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name, accepted", [("villin", 2000), ("1ubi_h", 500)])
def test_energy_of_charmm_is_that_of_the_reference_platform(name, accepted, method):
    """Its Lennard-Jones pairs are an expression with tables of types."""
    system, _, positions = makeSystem(name, CHARMM, method)
    assert "foreign" not in kinds(system, positions).values()
    assert kinds(system, positions)["LennardJones"] == "native"
    runAndCompare(system, positions, accepted)


# ---- Beads ----

SHORT_RANGE = """
    select(step(r-2^(1/6)*sigma), lambda*(pair-cut), pair-lambda*cut+(1-lambda)*epsilon);
    pair=4*epsilon*((sigma/r)^12-(sigma/r)^6); cut=4*epsilon*((sigma/2)^12-(sigma/2)^6);
    sigma=(sigma1+sigma2)/2; lambda=(lambda1+lambda2)/2; epsilon=0.8368
"""
# kJ/mol, where energies of pairs cancel.
ROUNDING = 1e-4

SCREENED = "charge1*charge2*138.935458/water*(exp(-r/length)/r-exp(-4/length)/4)"


def makeBeads(count, seed):
    """Return a chain of beads of one residue each: hydropathy of short range, and screened charges."""
    random = np.random.default_rng(seed)
    system, steric, bonds = openmm.System(), StericExclusionForce(), openmm.HarmonicBondForce()
    pairs = openmm.CustomNonbondedForce(SHORT_RANGE)
    charges = openmm.CustomNonbondedForce(SCREENED)
    for name in ("sigma", "lambda"):
        pairs.addPerParticleParameter(name)
    charges.addPerParticleParameter("charge")
    charges.addGlobalParameter("water", 74.2)
    charges.addGlobalParameter("length", 0.8)
    positions = [np.zeros(3)]
    for bead in range(count):
        system.addParticle(100)
        steric.addParticle(0.1)
        pairs.addParticle([random.uniform(0.45, 0.68), random.uniform(0, 1)])
        charges.addParticle([random.choice([-1, 0, 0, 1])])
        if bead > 0:
            steric.addBond(bead - 1, bead)
            bonds.addBond(bead - 1, bead, 0.38, 8000)
            pairs.addExclusion(bead - 1, bead)
            charges.addExclusion(bead, bead - 1)
            # A zigzag that is drawn out, with some disorder.
            step = np.array([0.3, 0.2 * (-1) ** bead, 0]) + random.normal(0, 0.05, 3)
            positions.append(positions[-1] + 0.38 * step / np.linalg.norm(step))
        if bead > 2:
            steric.addTorsion(bead - 3, bead - 2, bead - 1, bead)
    for force, cutoff in ((pairs, 2.0), (charges, 4.0)):
        force.setNonbondedMethod(openmm.CustomNonbondedForce.CutoffNonPeriodic)
        force.setCutoffDistance(cutoff)
    for force in (bonds, pairs, charges, steric):
        system.addForce(force)
    return system, np.array(positions)


@pytest.mark.parametrize("count", [4, 60, 250])
def test_energy_of_beads_is_that_of_the_reference_platform(count):
    system, positions = makeBeads(count, seed=count)
    runAndCompare(system, positions, 300 if count == 4 else 5000, ROUNDING)


def test_energy_of_groups_that_interact_is_that_of_the_reference_platform():
    """Groups that overlap: some pairs count twice."""
    system, positions = makeBeads(60, seed=1)
    pairs = next(force for force in system.getForces() if isinstance(force, openmm.CustomNonbondedForce))
    pairs.addInteractionGroup(range(0, 60, 2), range(50))
    pairs.addInteractionGroup(range(20, 35), range(20, 35))
    runAndCompare(system, positions, 5000, ROUNDING)


def test_energy_follows_global_parameters():
    system, positions = makeBeads(40, seed=2)
    run = Run(system, positions)
    run.run(2000)
    for length in (0.4, 2.0):
        run.context.setParameter("length", length)
        before = run.energy
        run.run(2000)
        copy = openmm.XmlSerializer.clone(system)
        copy.removeForce(3)
        context = openmm.Context(copy, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatform("Reference"))
        context.setParameter("length", length)
        context.setPositions(run.positions)
        expected = context.getState(energy=True).getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)
        assert run.energy != before
        assert abs(run.energy - expected) < 5e-3
