"""Native energies of real force fields, against OpenMM's own."""

import openmm
import openmmchaintree
import pytest
from openmm import app, unit

AMBER_KINDS = {
    "HarmonicBondForce": "constant",
    "HarmonicAngleForce": "constant",
    "PeriodicTorsionForce": "native",
    "NonbondedForce": "native",
    "CMMotionRemover": "not sampled",
    "StericExclusionForce": "not sampled",
}
AMBER19_KINDS = AMBER_KINDS | {"CMAPTorsionForce": "native"}
CHARMM_KINDS = AMBER19_KINDS | {
    "CustomTorsionForce": "constant",  # impropers
    "LennardJones": "native",  # a CustomNonbondedForce
    "LennardJones14": "native",
}
CUTOFF = {"nonbondedMethod": app.CutoffNonPeriodic, "nonbondedCutoff": 1.0}
SWITCH = CUTOFF | {"nonbondedCutoff": 1.2, "switchDistance": 1.0}


@pytest.mark.parametrize(
    "files, options, kinds, trials",
    [
        ("amber99sbildn.xml", {}, AMBER_KINDS, 200),
        ("amber14-all.xml", CUTOFF, AMBER_KINDS, 200),
        ("amber19-all.xml", SWITCH, AMBER19_KINDS, 200),
        ("charmm36.xml", SWITCH, CHARMM_KINDS, 20),
    ],
)
def testVillin(villin, files, options, kinds, trials):
    assertAgreement(villin, files, options, kinds, trials)


@pytest.mark.parametrize("name", ["5dfr_h.pdb", "1ubi_h.pdb"])
def testRealProteins(realStructure, name):
    assertAgreement(realStructure(name), "amber19-all.xml", SWITCH, AMBER19_KINDS, 200)


def assertAgreement(structure, files, options, kinds, trials):
    """Compare energies at the start, which the first step does Force by Force, and their sum after some trials."""
    system = app.ForceField(files).createSystem(structure.topology, **options)
    steric = openmmchaintree.createStericExclusionForce(structure.topology, structure.positions)
    system.addForce(steric)
    integrator = openmmchaintree.TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(1)
    integrator.addTorsionMove(1, 0.1)
    integrator.setTrialsPerStep(trials)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(structure.positions)
    plan = {entry.name: entry.kind for entry in integrator.getEnergyPlan(context)}
    assert plan == kinds
    integrator.step(1)
    assert integrator.getMoveStatistics(0).accepted > trials / 20
    groups = 0xFFFFFFFF & ~(1 << steric.getForceGroup())
    expected = context.getState(energy=True, groups=groups).getPotentialEnergy()
    expected = expected.value_in_unit(unit.kilojoule_per_mole)
    found = integrator.getPotentialEnergy(context)
    if unit.is_quantity(found):
        found = found.value_in_unit(unit.kilojoule_per_mole)
    assert abs(found - expected) <= 5e-3 + 1e-6 * abs(expected)
