"""Atom moves from Python, and sample --flexible."""

import json
import os
import subprocess
import sys

import numpy as np
import openmm
import openmmchaintree
import pytest
from commands import assertRefused
from openmm import app, unit
from openmmchaintree import TorsionMonteCarloIntegrator
from scenes import readDCD

PROTEIN = "amber14/protein.ff14SB.xml"  # a part of amber14-all.xml, quicker to read


@pytest.fixture
def runHere(runCommandHere):
    return lambda *arguments: runCommandHere("sample", *arguments)


def test_unitsAndDefaults():
    integrator = TorsionMonteCarloIntegrator(300)
    assert integrator.addAtomMove(1, 0.2 * unit.angstrom) == 0
    weight, size, particles, withHydrogens = integrator.getAtomMoveParameters(0)
    assert (weight, particles, withHydrogens) == (1, None, True)
    assert size.value_in_unit(unit.nanometer) == pytest.approx(0.02)
    assert integrator.getMoveType(0) == integrator.AtomMove
    assert integrator.getMoveDescription(0) == "atom with its hydrogens ±0.02 nm (weight 1, all particles)"
    integrator.setAtomMoveParameters(0, weight=2, maxDisplacement=0.01, particles=[3, 5], withHydrogens=False)
    weight, size, particles, withHydrogens = integrator.getAtomMoveParameters(0)
    assert particles.tolist() == [3, 5] and withHydrogens is False
    integrator.setAtomMoveParameters(0, *integrator.getAtomMoveParameters(0))
    with pytest.raises(TypeError, match="maxDisplacement must be a length"):
        integrator.addAtomMove(1, 2 * unit.degrees)
    with pytest.raises(openmm.OpenMMException, match="particles is empty.*None means all of them"):
        integrator.addAtomMove(1, 0.01, [])
    integrator.setMoveScales(0, [0.5])
    assert integrator.getMoveScales(0).tolist() == [0.5] and integrator.displacesParticles()


def makeVillin(villin, **arguments):
    system = app.ForceField(PROTEIN, "implicit/gbn2.xml").createSystem(villin.topology, **arguments)
    force = openmmchaintree.createStericExclusionForce(villin.topology, villin.positions, system=system)
    system.addForce(force)
    return system


def makeContext(villin, system, size=0.01):
    integrator = TorsionMonteCarloIntegrator(300)
    openmmchaintree.addDefaultMoves(integrator, villin.topology, system)
    integrator.addAtomMove(1.5, size)
    integrator.setRandomNumberSeed(5)
    integrator.setTrialsPerStep(400)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(villin.positions)
    return context, integrator


def test_protein(villin):
    """Each native Force is evaluated in trials, and the sums are OpenMM's energy, also after a checkpoint."""
    system = makeVillin(villin)
    context, integrator = makeContext(villin, system)
    kinds = {entry.name: entry.kind for entry in integrator.getEnergyPlan(context)}
    assert kinds["HarmonicBondForce"] == kinds["HarmonicAngleForce"] == "native"
    integrator.step(8)
    checkpoint = context.createCheckpoint()
    integrator.step(4)
    move = integrator.getNumMoves() - 1
    statistics = integrator.getMoveStatistics(move)
    assert 0.2 < statistics.accepted / statistics.attempted < 0.8
    held = integrator.getPotentialEnergy(context)
    whole = context.getState(energy=True).getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)
    assert held == pytest.approx(whole, rel=1e-6, abs=5e-3)
    ends = context.getState(positions=True).getPositions(asNumpy=True)
    again, other = makeContext(villin, system)
    again.loadCheckpoint(checkpoint)
    other.step(4)
    assert np.array_equal(again.getState(positions=True).getPositions(asNumpy=True), ends)


@pytest.mark.parametrize(("share", "tests"), [(0.0, 5), (0.5, 3), (1.0, 1)])
def test_outerTests(villin, share, tests):
    """Five atom moves count as one trial in the number of trials to an outer test of the stand-in."""
    system = makeVillin(villin)
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.addTorsionMove(1 - share, 0.02)
    integrator.addAtomMove(share, 0.01)
    assert integrator.getAtomMoveShare() == share
    integrator.setTrialsPerStep(2000)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(villin.positions)
    integrator.step(1)
    assert integrator.getOuterStatistics().attempted == tests
    often = [entry.reason for entry in integrator.getEnergyPlan(context) if "every" in entry.reason]
    assert often and all(f"every {(400, 667, 2000)[(5, 3, 1).index(tests)]} trials" in reason for reason in often)


def test_constraints(villin):
    """Constrained hydrogens stay at their distances; other constraints are refused in a sentence."""
    system = makeVillin(villin, constraints=app.HBonds)
    context, integrator = makeContext(villin, system)
    pairs = np.array([system.getConstraintParameters(i)[:2] for i in range(system.getNumConstraints())])
    before = villin.positions
    integrator.step(3)
    after = context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)

    def measure(positions):
        return np.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=1)

    assert np.abs(measure(after) - measure(before)).max() < 1e-12
    bonds = [(bond[0].index, bond[1].index) for bond in villin.topology.bonds()]
    assert any(np.linalg.norm(after[i] - after[j]) != np.linalg.norm(before[i] - before[j]) for i, j in bonds)
    system = makeVillin(villin, constraints=app.AllBonds)
    with pytest.raises(openmm.OpenMMException, match="build the System with constraints=None"):
        makeContext(villin, system)


_TRACE = """
import hashlib, sys
import numpy as np
from openmmchaintree.structures.structure import readStructure
sys.path.insert(0, {folder!r})
import test_flexible
villin = readStructure()
context, integrator = test_flexible.makeContext(villin, test_flexible.makeVillin(villin))
integrator.step(4)
positions = context.getState(positions=True).getPositions(asNumpy=True)._value
print(hashlib.sha256(np.ascontiguousarray(positions).tobytes()).hexdigest())
"""


def test_instructionSetsAgree():
    def trace(instructions):
        program = [sys.executable, "-c", _TRACE.format(folder=os.path.dirname(__file__))]
        environment = {**os.environ, "CHAINTREE_SIMD": instructions}
        return subprocess.run(program, env=environment, capture_output=True, text=True, check=True).stdout

    outputs = [trace(name) for name in ("avx512", "avx2", "portable")]
    assert len(outputs[0]) > 60 and len(set(outputs)) == 1


# ---- The command ----


def test_command(runHere, tmp_path):
    result = runHere(
        *("--forcefield", PROTEIN, "implicit/gbn2.xml", "--flexible", "--trials", 4000, "--frames", 4, "--seed", 1),
        *("--json", "summary.json"),
    )
    assert result.returncode == 0, result.stderr
    assert "at 300 K, no cutoff, flexible" in result.stdout
    assert "flexible: all atoms of what moves are also displaced" in result.stdout
    assert "rigid:" not in result.stdout and "change of a bond" not in result.stdout
    summary = json.loads((tmp_path / "summary.json").read_text())
    atoms = summary["moves"][-1]
    assert atoms["name"] == "atoms"
    undone = summary["energy"]["outerTests"]["trialsTakenBack"]
    assert undone < 2000 and atoms["attempted"] == pytest.approx((4000 - undone) / 2, abs=250)
    assert 0.15 < atoms["accepted"] / atoms["attempted"] < 0.6
    assert summary["largestBondChange"] is None and summary["changedBonds"] == []
    ends = summary["energy"]["potentialEnergy"]
    assert ends["lastByOpenMM"] == pytest.approx(ends["last"], rel=1e-6, abs=5e-3)
    assert {force["name"]: force["kind"] for force in summary["energy"]["forces"]}["HarmonicAngleForce"] == "native"
    frames = readDCD(tmp_path / "villin.dcd")
    topology = app.PDBFile(str(tmp_path / "villin-topology.pdb")).topology
    bonds = np.array([(bond[0].index, bond[1].index) for bond in topology.bonds()])
    lengths = np.linalg.norm(frames[:, bonds[:, 0]] - frames[:, bonds[:, 1]], axis=2)
    assert np.mean(np.abs(lengths[-1] - lengths[0]) > 1e-4) > 0.5

    # The settings repeat the run.

    result = runHere("--config", "villin-settings.toml", "-o", "again", "--json", "again.json")
    assert result.returncode == 0, result.stderr
    assert np.array_equal(readDCD(tmp_path / "again.dcd"), frames)


def test_replicas(runHere, tmp_path):
    """A run that is continued ends as one that was not interrupted."""
    options = ("--forcefield", PROTEIN, "--flexible", "--temperatures", "300:320:2", "--seed", 2)
    whole = runHere(*options, "--trials", 8000, "--frames", 2, "-o", "whole", "--json", "whole.json")
    assert whole.returncode == 0, whole.stderr
    assert "change of a bond" not in whole.stdout
    assert runHere(*options, "--trials", 4000, "--frames", 1, "-o", "part").returncode == 0
    resumed = runHere("--resume", "part.checkpoint", "--trials", 8000, "--json", "part.json")
    assert resumed.returncode == 0, resumed.stderr
    ends = [json.loads((tmp_path / name).read_text())["ends"] for name in ("whole.json", "part.json")]
    assert ends[0][0]["largestBondChange"] is None
    assert [end["potentialEnergy"] for end in ends[0]] == [end["potentialEnergy"] for end in ends[1]]


def test_fixedAtomsStay(runHere, tmp_path):
    fixed = "resSeq 20 to 30"
    result = runHere(
        *("--forcefield", PROTEIN, "--flexible", "--trials", 2000, "--frames", 1, "--seed", 1, "--fix", fixed)
    )
    assert result.returncode == 0, result.stderr
    frames = readDCD(tmp_path / "villin.dcd")
    topology = app.PDBFile(str(tmp_path / "villin-topology.pdb")).topology
    stays = np.array([20 <= int(atom.residue.id) <= 30 for atom in topology.atoms()])
    moved = np.any(frames[0] != frames[-1], axis=1)
    assert stays.any() and not moved[stays].any() and moved[~stays].mean() > 0.5


def test_needsAForceField(runHere, tmp_path):
    assertRefused(runHere("--flexible"), tmp_path, [], "--flexible", "--forcefield")
