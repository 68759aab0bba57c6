"""Native energies of real systems against OpenMM's Reference platform, and their changes against sums in long double.

Changes in trials are compared with sums over all pairs. Trajectories have the same bits on each instruction set, and
after resuming from a checkpoint.
"""

import hashlib
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import openmm
import pytest
from realsystems import METHODS, PairSum, Reference, Run, makeSystem

# What U may be off from OpenMM's: kJ/mol, and relative to the Forces' energies.
ABSOLUTE, RELATIVE = 5e-3, 1e-6
# The same for the change in a trial, kJ/mol.
CHANGE = 1e-3

# A temperature at which each trial without a clash is accepted.
HOT = 1e30

AMBER, AMBER19 = "amber14-all.xml", "amber19-all.xml"


# Where atoms overlap, forces are so large that coordinates in single precision matter: nm, of leaves some nm wide.
ROUNDING = 1e-7


def assertAgreement(run, reference, allowance=0):
    """Check U, which the run holds."""
    positions = run.positions
    energies = reference.energies(positions)
    error = run.energy - energies.sum()
    assert abs(error) <= min(ABSOLUTE, RELATIVE * np.abs(energies).sum()) + allowance


def runAndCompare(system, positions, accepted, allowance=0, **choice):
    """Compare U at the start, and after `trials` accepted trials."""
    run, reference = Run(system, positions, **choice), Reference(system)
    assertAgreement(run, reference, allowance)
    while run.accepted < accepted:
        run.run(2000)
        assert run.accepted > 0
    # The current energy is the sum of changes in trials, so their errors would have accumulated.
    assertAgreement(run, reference, allowance)
    # A recomputed energy differs only by rounding: there is no drift.
    fresh = Run(system, run.positions)
    assert abs(run.energy - fresh.energy) <= ABSOLUTE


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "name, forceField, accepted",
    [
        ("alanine dipeptide", AMBER, 10000),
        ("villin", AMBER, 10000),
        ("villin", AMBER19, 10000),
        ("1ubi_h", AMBER, 2000),
        ("bpti_h", AMBER, 2000),
        ("5dfr_h", AMBER, 1000),
        ("1bna", AMBER, 1000),
    ],
)
def test_energy_is_that_of_the_reference_platform(name, forceField, accepted, method):
    system, _, positions = makeSystem(name, forceField, method)
    runAndCompare(system, positions, accepted)


def test_energy_of_a_tetramer_is_that_of_the_reference_platform():
    """Its hydrogens are as they were added, so some atoms overlap."""
    for method in ("no cutoff", "switch"):
        system, _, positions = makeSystem("4hhb", AMBER, method)
        run, reference = Run(system, positions), Reference(system)
        assertAgreement(run, reference, ROUNDING * reference.gradient(positions))
        run.run(300)
        assert run.accepted > 20
        assertAgreement(run, reference, ROUNDING * reference.gradient(run.positions))


def test_energy_without_spheres_is_that_of_the_reference_platform():
    system, _, positions = makeSystem("villin", AMBER, "reaction field", steric=False)
    runAndCompare(system, positions, 3000)


def toRyckaertBellemans(system):
    """Replace each torsion that can be written so by a polynomial of its cosine, as OPLS has them."""
    polynomials = openmm.RBTorsionForce()
    polynomials.setName("RBTorsionForce")
    for index in range(system.getNumForces()):
        force = system.getForce(index)
        if isinstance(force, openmm.PeriodicTorsionForce):
            for torsion in range(force.getNumTorsions()):
                *particles, periodicity, phase, k = force.getTorsionParameters(torsion)
                cosine = np.cos(phase._value)
                if periodicity <= 5 and abs(abs(cosine) - 1) < 1e-6:
                    chebyshev = np.zeros(periodicity + 1)
                    chebyshev[periodicity] = np.sign(cosine) * (-1) ** periodicity
                    terms = np.zeros(6)
                    terms[: periodicity + 1] = np.polynomial.chebyshev.cheb2poly(chebyshev) * k._value
                    terms[0] += k._value
                    polynomials.addTorsion(*particles, *terms)
                    force.setTorsionParameters(torsion, *particles, periodicity, phase, 0)
    system.addForce(polynomials)
    return polynomials.getNumTorsions()


def test_energy_of_polynomial_torsions():
    system, _, positions = makeSystem("villin")
    before = Reference(system).energy(positions)
    assert toRyckaertBellemans(system) > 1000
    assert abs(Reference(system).energy(positions) - before) < 1e-2  # their phases are rounded to seven digits
    runAndCompare(system, positions, 3000)


# ---- Changes in trials ----


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", ["alanine dipeptide", "villin"])
def test_changes_are_those_of_all_pairs(name, method):
    system, _, positions = makeSystem(name, AMBER, method)
    nonbonded = next(force for force in system.getForces() if isinstance(force, openmm.NonbondedForce))
    pairs = PairSum(nonbonded)
    terms = openmm.XmlSerializer.clone(system)
    for index in reversed(range(terms.getNumForces())):
        if isinstance(terms.getForce(index), openmm.NonbondedForce):
            terms.removeForce(index)
    terms = Reference(terms)
    run = Run(system, positions, temperature=HOT, moves=((1, 0.02, 1), (1, 0.3, 1), (1, 0.01, 2)))
    run.integrator.setTrialsPerStep(1)

    def expected():
        positions = run.positions
        return pairs.energy(positions) + terms.energy(positions)

    energy, exact = run.energy, expected()
    assert abs(energy - exact) < ABSOLUTE
    compared = 0
    while compared < 25:
        before = run.accepted
        run.integrator.step(1)
        if run.accepted > before:
            newEnergy, newExact = run.energy, expected()
            assert newEnergy != energy
            # Beyond 1e5 kJ/mol, a float is no longer so exact.
            if max(abs(newExact), abs(exact)) < 1e5:
                assert abs((newEnergy - energy) - (newExact - exact)) < CHANGE
                compared += 1
            energy, exact = newEnergy, newExact


# ---- Same bits ----


def trace(arguments, **environment):
    """Return what this file prints, run as a program, and its exit status."""
    ran = subprocess.run(
        [sys.executable, __file__, *map(str, arguments)],
        env=dict(os.environ, **environment),
        stdout=subprocess.PIPE,
        text=True,
        cwd=Path(__file__).parent,
    )
    return ran.stdout, ran.returncode


def printBits(run):
    """Print what tells positions and U from others by their bits."""
    print(hashlib.sha256(run.positions.tobytes()).hexdigest(), run.energy.hex(), run.accepted)


def followTrajectory(method, name="villin"):
    system, _, positions = makeSystem(name, AMBER, method)
    run = Run(system, positions)
    for _ in range(4):
        run.run(2500)
        printBits(run)


@pytest.mark.parametrize("method", ["no cutoff", "switch"])
def test_trajectories_have_the_same_bits_on_each_instruction_set(method):
    outputs = [trace(["follow", method], CHAINTREE_SIMD=name) for name in ("avx512", "avx2", "portable")]
    assert all(status == 0 for _, status in outputs)
    assert len(set(outputs[0][0].split("\n"))) == 5  # it moved
    assert outputs[0] == outputs[1] == outputs[2]


def runInParts(course, file):
    """Run trials, with a checkpoint in the middle; be killed after it; or continue from it."""
    system, _, positions = makeSystem("villin", AMBER, "reaction field")
    run = Run(system, positions)
    if course == "resume":
        run.context.setPositions(positions + 0.1)
        run.context.loadCheckpoint(Path(file).read_bytes())
    else:
        run.run(5000)
        Path(file).write_bytes(run.context.createCheckpoint())
    printBits(run)
    run.run(500)
    if course == "die":
        sys.stdout.flush()
        os.kill(os.getpid(), signal.SIGKILL)
    run.run(4500)
    printBits(run)


@pytest.mark.skipif(os.name != "posix", reason="there is no SIGKILL")
def test_a_run_that_was_killed_goes_on_from_its_checkpoint(tmp_path):
    whole, status = trace(["whole", tmp_path / "whole.chk"])
    assert status == 0 and len(whole.split()) == 6
    died, status = trace(["die", tmp_path / "checkpoint.chk"])
    assert status == -signal.SIGKILL and whole.startswith(died)
    resumed, status = trace(["resume", tmp_path / "checkpoint.chk"])
    assert status == 0 and resumed == whole


if __name__ == "__main__":
    if sys.argv[1] == "follow":
        followTrajectory(sys.argv[2])
    else:
        runInParts(*sys.argv[1:])
