"""Energies in implicit solvent, as OpenMM's force field files make it, against OpenMM's Reference platform."""

from pathlib import Path

import openmm
import openmm.app
import pytest
from realsystems import Reference, Run, makeSystem
from test_native_energies import ABSOLUTE, AMBER, RELATIVE

SOLVENTS = Path(openmm.app.__file__).parent / "data" / "implicit"
MODELS = ["hct", "obc1", "obc2", "gbn", "gbn2"]

# The files of implicit solvents can leave out the surface energy in newer versions of OpenMM.
NO_SURFACE = {"sasaMethod": None} if "sasaMethod" in (SOLVENTS / "gbn2.xml").read_text(encoding="utf-8") else {}

# Arguments of createSystem that the files of implicit solvents read.
OPTIONS = {
    "salt": {"implicitSolventKappa": 1.3},
    "dielectrics": {"soluteDielectric": 2.5, "solventDielectric": 60.0},
    "no surface": NO_SURFACE,
    "all": {"implicitSolventKappa": 0.7, "soluteDielectric": 4.0, "solventDielectric": 40.0, **NO_SURFACE},
}

# kJ/mol: the parts of a nucleic acid's energy are some 1e5, and their sum a tenth of that.
HIGHLY_CHARGED = 2e-2


def makeSolvated(name, model, method="no cutoff", options=None, forceField=AMBER, **choice):
    return makeSystem(name, forceField, method, solvent=f"implicit/{model}.xml", options=options, **choice)


def assertEnergy(run, reference, absolute=ABSOLUTE):
    positions = run.positions
    energies = reference.energies(positions)
    error = run.energy - energies.sum()
    assert abs(error) <= absolute
    assert abs(error) <= RELATIVE * abs(energies).sum()


def checkSolvated(system, positions, trials, absolute=ABSOLUTE):
    """Compare U at the start and after some trials. They are still going downhill, so outer tests pass short blocks."""
    run, reference = Run(system, positions), Reference(system)
    run.integrator.setTrialsPerOuterTest(5)
    plan = run.integrator.getEnergyPlan(run.context)
    assert "foreign" not in {entry.kind for entry in plan}
    twoLevels = {entry.name for entry in plan if "outer test" in entry.reason}
    assert len(twoLevels) == 2 and "NonbondedForce" in twoLevels
    assertEnergy(run, reference, absolute)
    run.run(trials)
    assert run.accepted > 0
    assertEnergy(run, reference, absolute)


@pytest.mark.parametrize("method", ["no cutoff", "reaction field"])
@pytest.mark.parametrize("options", [None, *OPTIONS])
@pytest.mark.parametrize("model", MODELS)
def test_energy_of_each_model_is_that_of_the_reference_platform(model, options, method):
    system, _, positions = makeSolvated("alanine dipeptide", model, method, OPTIONS.get(options))
    checkSolvated(system, positions, 2000)


@pytest.mark.parametrize("method", ["no cutoff", "switch"])
@pytest.mark.parametrize("model", MODELS)
def test_energy_of_a_protein_is_that_of_the_reference_platform(model, method):
    options = OPTIONS["salt"] if method == "switch" else None
    system, _, positions = makeSolvated("villin", model, method, options)
    checkSolvated(system, positions, 4000)


@pytest.mark.parametrize("model", ["obc2", "gbn2"])
@pytest.mark.parametrize("name", ["1ubi_h", "bpti_h", "1bna"])
def test_energy_of_large_molecules_is_that_of_the_reference_platform(name, model):
    system, _, positions = makeSolvated(name, model)
    checkSolvated(system, positions, 1000, HIGHLY_CHARGED if name == "1bna" else ABSOLUTE)


@pytest.mark.parametrize("method", ["no cutoff", "reaction field"])
@pytest.mark.parametrize("name", ["alanine dipeptide", "villin"])
def test_energy_of_the_built_in_model_is_that_of_the_reference_platform(name, method):
    system, _, positions = makeSystem(name, "amber99sb.xml", method, solvent="amber99_obc.xml")
    assert any(isinstance(force, openmm.GBSAOBCForce) for force in system.getForces())
    checkSolvated(system, positions, 2000)


def test_energy_follows_the_charges_that_are_set():
    """Both Forces have to be told, as with OpenMM alone."""
    system, _, positions = makeSolvated("alanine dipeptide", "gbn2")
    run = Run(system, positions)
    run.run(1000)
    for force in system.getForces():
        if isinstance(force, openmm.NonbondedForce):
            _, sigma, epsilon = force.getParticleParameters(5)
            force.setParticleParameters(5, 0.1, sigma, epsilon)
            force.updateParametersInContext(run.context)
        if isinstance(force, openmm.CustomGBForce):
            force.setParticleParameters(5, [0.1, *force.getParticleParameters(5)[1:]])
            force.updateParametersInContext(run.context)
    before = run.positions
    run.run(1000)
    assert (run.positions != before).any()
    assertEnergy(run, Reference(system))


def test_particles_at_one_place_have_no_energy():
    """By OpenMM. Two that differ are at the same place only by mistake, and no fault of a Force was found."""
    system, _, positions = makeSolvated("alanine dipeptide", "gbn2")
    positions[21] = positions[0]
    run = Run(system, positions)
    with pytest.raises(openmm.OpenMMException, match=r"is not a number: that of force \d \(CustomGBForce\) by OpenMM"):
        run.run(1)
