"""Periodic images count: in the helper, in searches for clashes, and in sampling."""

import copy
import io
import json
import pickle
from itertools import product

import numpy as np
import openmm
import pytest
from commands import assertRefused, filesIn
from mdtraj.formats import DCDTrajectoryFile
from openmm import app, unit
from openmmchaintree import (
    ClashReporter,
    InputError,
    StericExclusionForce,
    TorsionMonteCarloIntegrator,
    createStericExclusionForce,
    findClashes,
)
from openmmchaintree.command.allpairs import HardSpheres
from openmmchaintree.images import engineBox, vectorsOf
from scenes import GLYCINES, makeSystem, positionsOf, readDCD, writeDCD, writePDB, writeXTC

_CUBE = 3.0 * np.eye(3)
_TRICLINIC = np.array([[4.0, 0, 0], [2.0, 3.5, 0], [-1.9, 1.7, 3.2]])


def nearestDistances(positions, box):
    """Return the least distances of all pairs (i < j) among many images."""
    first, second = np.triu_indices(len(positions), 1)
    vectors = positions[first] - positions[second]
    vectors -= np.rint(vectors @ np.linalg.inv(box)) @ box
    images = [vectors + np.array(turn) @ box for turn in product(range(-2, 3), repeat=3)]
    return first, second, np.min([np.linalg.norm(image, axis=1) for image in images], axis=0)


def beads(box, count=60, radius=0.2):
    """A Context of loose beads that clash in no image, its force, and its integrator."""
    force = StericExclusionForce()
    force.setUsesPeriodicBoundaryConditions(True)
    force.setOverlapTolerance(0)
    system = openmm.System()
    for _ in range(count):
        system.addParticle(1)
        force.addParticle(radius)
    system.addForce(force)
    system.setDefaultPeriodicBoxVectors(*vectorsOf(box))
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(3)
    integrator.addRigidBodyMove(1, 0.4, 1)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    grid = np.array(list(product(range(4), repeat=3))[:count]) / 4
    context.setPositions((grid + np.arange(count)[:, np.newaxis] % 3 - 1) @ box)
    return context, force, integrator


# ---- The force and the helper ----


def test_flag():
    force = StericExclusionForce()
    assert force.usesPeriodicBoundaryConditions() is False and "periodic" not in repr(force)
    force.setUsesPeriodicBoundaryConditions(True)
    assert repr(force).endswith(", periodic>")
    for other in (copy.copy(force), copy.deepcopy(force), pickle.loads(pickle.dumps(force))):
        assert other.usesPeriodicBoundaryConditions() is True


@pytest.mark.parametrize("method", ["NoCutoff", "CutoffNonPeriodic", "CutoffPeriodic", "PME"])
def test_helperFollowsTheSystem(villin, method):
    nonbonded = openmm.NonbondedForce()
    nonbonded.setNonbondedMethod(getattr(openmm.NonbondedForce, method))
    for _ in range(villin.topology.getNumAtoms()):
        nonbonded.addParticle(0, 0.3, 0)
    system = makeSystem(villin, nonbonded)
    force = createStericExclusionForce(villin.topology, villin.positions, system=system)
    assert force.usesPeriodicBoundaryConditions() is (method in ("CutoffPeriodic", "PME"))
    assert not createStericExclusionForce(villin.topology, villin.positions).usesPeriodicBoundaryConditions()


@pytest.mark.parametrize("box", [_CUBE, _TRICLINIC], ids=["cube", "triclinic"])
def test_neighborsAreThoseOfAllImages(box):
    context, force, _ = beads(box)
    generator = np.random.default_rng(1)
    for cutoff in (0.7, 1.5):
        positions = generator.uniform(-10, 10, (60, 3))
        context.setPositions(positions)
        pairs, distances = force.getNeighborPairs(context, cutoff)
        first, second, expected = nearestDistances(positions, box)
        near = expected <= cutoff
        assert np.array_equal(pairs, np.column_stack([first, second])[near])
        assert distances == pytest.approx(expected[near], abs=1e-9)
        assert force.getMinimumDistance(context, [0], range(1, 60)).distance == pytest.approx(
            expected[first == 0].min(), abs=1e-9
        )


@pytest.mark.parametrize("box", [_CUBE, _TRICLINIC], ids=["cube", "triclinic"])
def test_hardBeadsNeverOverlapInAnyImage(box):
    context, force, integrator = beads(box)
    moved = 0
    for _ in range(20):
        integrator.step(2)
        positions = positionsOf(context)
        assert nearestDistances(positions, box)[2].min() >= 0.4 - 1e-9
        moved = max(moved, np.abs(positions).max())
    statistics = integrator.getMoveStatistics(0)
    assert statistics.accepted > 100 and statistics.clashed > 100
    assert moved > 6


def test_allPairsWithoutTheEngine():
    """The check of the command finds the clashes of the engine, with few particles and with many."""
    for count, box in ((60, _TRICLINIC), (1700, 3 * _TRICLINIC)):
        force = StericExclusionForce()
        force.setUsesPeriodicBoundaryConditions(True)
        system = openmm.System()
        for i in range(count):
            system.addParticle(1)
            force.addParticle(0.3 if i % 5 else 0)
        force.addExclusion(1, 2)
        spheres = HardSpheres(force, box)
        system.addForce(force)
        system.setDefaultPeriodicBoxVectors(*vectorsOf(box))
        context = openmm.Context(system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatformByName("Reference"))
        positions = np.random.default_rng(4).uniform(-20, 20, (count, 3))
        positions[2] = positions[1] + 0.1
        context.setPositions(positions)
        pairs, overlaps = force.getClashes(context)
        found = spheres.overlaps(positions)
        assert len(pairs) > 10
        assert np.array_equal(found.pairs, pairs) and found.overlaps == pytest.approx(overlaps, abs=1e-9)


# ---- Clashes of files ----


def crystal(path, shift, box, cell=True):
    """Two chains, the second moved by a vector (Å), in a file with a box (Å)."""
    lines = ["CRYST1" + "".join(f"{length:9.3f}" for length in box) + "  90.00  90.00  90.00 P 1           1"]
    moved = []
    for line in GLYCINES:
        place = [float(line[start : start + 8]) + step for start, step in zip((30, 38, 46), shift, strict=True)]
        moved.append(line[:21] + "B" + line[22:30] + "".join(f"{value:8.3f}" for value in place) + line[54:])
    return writePDB(path, [*(lines if cell else ()), *GLYCINES, *moved])


_NEAR = np.array([0.3, 0.2, 2.4])
_BOX = np.array([20.0, 21.0, 22.0])


@pytest.mark.parametrize("turns", [(0, 0, 1), (1, 0, 0), (-1, 1, 0), (0, -3, -1)])
@pytest.mark.parametrize("kind", ["pdb", "cif"])
def test_clashesAcrossTheBox(tmp_path, turns, kind):
    """There are the clashes of the image that is in the file."""
    (expected,) = findClashes(crystal(tmp_path / "near.pdb", _NEAR, 4 * _BOX))
    path = crystal(tmp_path / "far.pdb", _NEAR + _BOX * turns, _BOX)
    if kind == "cif":
        pdb, path = app.PDBFile(str(path)), tmp_path / "far.cif"
        with open(path, "w") as file:
            app.PDBxFile.writeFile(pdb.topology, pdb.positions, file, keepIds=True)
    (found,) = findClashes(path, periodic=True)
    assert len(found.clashes) == len(expected.clashes) > 0
    for clash, other in zip(found.clashes, expected.clashes, strict=True):
        assert clash[:4] == other[:4] and clash.overlap == pytest.approx(other.overlap, abs=1e-4)
    with pytest.warns(UserWarning, match=r"images, which do not count \(see --periodic\)"):
        assert findClashes(path)[0].clashes == []


@pytest.mark.parametrize("writer", [writeDCD, writeXTC])
def test_boxesOfFrames(tmp_path, writer):
    """Each frame has its own box; a frame without one has that of the structure."""
    structure = crystal(tmp_path / "far.pdb", _NEAR + (0, 0, 22.0), _BOX)
    pdb = app.PDBFile(str(structure))
    positions = pdb.getPositions(asNumpy=True).value_in_unit(unit.nanometer)
    counts = []
    for width in (2.2, 3.2, None):
        vectors = None if width is None else vectorsOf(width * np.eye(3)) * unit.nanometer
        pdb.topology.setPeriodicBoxVectors(vectors)
        path = writer(tmp_path / f"frames{width}", pdb.topology, [positions, positions])
        counts.append([len(frame.clashes) for frame in findClashes(structure, path, periodic=True)])
    assert counts[0] == counts[2] == [counts[0][0]] * 2 and counts[0][0] > 0
    assert counts[1] == [0, 0]


def test_refusedBoxes(tmp_path):
    bare = crystal(tmp_path / "bare.pdb", _NEAR, _BOX, cell=False)
    with pytest.raises(InputError, match=r"bare.pdb: model 0 \(from 0\): there is no periodic box"):
        findClashes(bare, periodic=True)
    narrow = crystal(tmp_path / "narrow.pdb", _NEAR, (20, 6, 20))
    with pytest.raises(InputError, match=r"narrow.pdb: model 0 \(from 0\): the periodic box is 0.6 nm wide"):
        findClashes(narrow, periodic=True)
    with pytest.raises(InputError, match="must be along x"):
        engineBox(np.array([[3.0, 0.1, 0], [0, 3, 0], [0, 0, 3]]), "frame")
    assert np.array_equal(engineBox(np.array([[4.0, 0, 0], [3.0, 4, 0], [0, 0, 3]]), "frame")[1], [-1, 4, 0])


def test_reporterFollowsTheSystem(tmp_path):
    pdb = app.PDBFile(str(crystal(tmp_path / "far.pdb", _NEAR + (0, 0, 22.0), _BOX)))
    counts = []
    for method in (openmm.NonbondedForce.NoCutoff, openmm.NonbondedForce.CutoffPeriodic):
        system = openmm.System()
        nonbonded = openmm.NonbondedForce()
        nonbonded.setNonbondedMethod(method)
        for _ in pdb.topology.atoms():
            system.addParticle(0)
            nonbonded.addParticle(0, 0.1, 0)
        system.addForce(nonbonded)
        system.setDefaultPeriodicBoxVectors(*pdb.topology.getPeriodicBoxVectors())
        simulation = app.Simulation(pdb.topology, system, openmm.VerletIntegrator(0.001))
        simulation.context.setPositions(pdb.positions)
        text = io.StringIO()
        simulation.reporters.append(ClashReporter(text, 1))
        simulation.step(1)
        counts.append(int(text.getvalue().splitlines()[1].split(",")[2]))
    assert counts[0] == 0 < counts[1]


# ---- The command ----


def test_clashesCommand(tmp_path, runCommandHere):
    path = crystal(tmp_path / "far.pdb", _NEAR + (0, 0, 22.0), _BOX)
    for options, isFound in ((), False), (("--periodic",), True):
        result = runCommandHere("clashes", path, "--json", "all.json", "--overwrite", *options)
        assert result.returncode == 0, result.stderr
        summary = json.loads((tmp_path / "all.json").read_text())
        assert (len(summary["frames"][0]["clashes"]) > 0) is isFound
        assert ("which do not count (see --periodic)" in result.stdout) is not isFound
    bare = crystal(tmp_path / "bare.pdb", _NEAR, _BOX, cell=False)
    refused = runCommandHere("clashes", bare, "--periodic")
    assertRefused(refused, tmp_path, ["all.json", "bare.pdb", "far.pdb"], "there is no periodic box")


def test_clashesByWorkers(tmp_path, runCommandHere):
    path = crystal(tmp_path / "far.pdb", _NEAR + (0, 0, 22.0), _BOX)
    pdb = app.PDBFile(str(path))
    positions = pdb.getPositions(asNumpy=True).value_in_unit(unit.nanometer)
    frames = writeDCD(tmp_path / "frames", pdb.topology, [positions] * 5)
    result = runCommandHere("clashes", path, frames, "--periodic", "--workers", 2, "--json", "all.json")
    assert result.returncode == 0, result.stderr
    counts = [len(frame["clashes"]) for frame in json.loads((tmp_path / "all.json").read_text())["frames"]]
    assert len(counts) == 5 and min(counts) > 0


def test_sampleCommand(tmp_path, runCommandHere):
    """Chains in a small crystal never overlap images; the files tell its box."""
    path = crystal(tmp_path / "crystal.pdb", (0.0, 0.0, 5.0), (9.0, 8.5, 10.0))
    arguments = ("--rigid-bodies", "--trials", 4000, "--frames", 20, "--seed", 1, "--json", "s.json", "--overwrite")
    closest = []
    for options in ((), ("--periodic",)):
        result = runCommandHere("sample", path, "-o", "out", *arguments, *options)
        assert result.returncode == 0, result.stderr + result.stdout
        summary = json.loads((tmp_path / "s.json").read_text())
        assert summary["pairsBeyondLimit"] == [] and summary["changedBonds"] == []
        if not options:
            frames = readDCD(tmp_path / "out.dcd")
        else:
            with DCDTrajectoryFile(str(tmp_path / "out.dcd")) as file:
                coordinates, lengths, angles = file.read()
            frames = coordinates.astype(np.float64) / 10
            assert lengths == pytest.approx(np.tile([9.0, 8.5, 10.0], (21, 1)), abs=1e-4)
            assert angles == pytest.approx(90, abs=1e-4)
        topology = app.PDBFile(str(tmp_path / "out-topology.pdb")).topology
        vectors = topology.getPeriodicBoxVectors()
        assert (vectors is not None) is bool(options)
        least = [min(nearestBetween(frame, np.diag([0.9, 0.85, 1.0]))) for frame in frames]
        closest.append(min(least))
    assert closest[0] < 0.9 * closest[1]


def nearestBetween(positions, box):
    """Return the least distances between atoms of two chains in any image."""
    first, second, distances = nearestDistances(positions, box)
    return distances[(first < 8) & (second >= 8)]


def test_sampleInAForceField(tmp_path, runCommandHere):
    from openmmchaintree.command.energymodel import EnergyModel
    from openmmchaintree.command.plan import Choice
    from openmmchaintree.command.sampling import Sampling
    from openmmchaintree.structures.structure import readStructure

    refused = runCommandHere("sample", "--periodic", "--forcefield", "amber14-all.xml")
    assertRefused(refused, tmp_path, [], "--periodic needs --nonbonded-cutoff in a force field")
    structure = readStructure()
    structure = structure._replace(box=8.0 * np.eye(3))
    model = EnergyModel(["amber14-all.xml"], 300, 0.9)
    sampling = Sampling(structure, 1, Choice(periodic=True, hasEnergies=True), model)
    system = sampling.context.getSystem()
    (nonbonded,) = [force for force in system.getForces() if isinstance(force, openmm.NonbondedForce)]
    assert nonbonded.getNonbondedMethod() == openmm.NonbondedForce.CutoffPeriodic
    assert sampling.force.usesPeriodicBoundaryConditions()
    assert sampling.context.getState().getPeriodicBoxVectors(asNumpy=True)._value == pytest.approx(8 * np.eye(3))


def test_boxIsRefusedBySample(tmp_path, runCommandHere):
    bare = crystal(tmp_path / "bare.pdb", (0.0, 0.0, 5.0), _BOX, cell=False)
    refused = runCommandHere("sample", bare, "--periodic")
    assertRefused(refused, tmp_path, ["bare.pdb"], "bare.pdb: there is no periodic box")
    narrow = crystal(tmp_path / "narrow.pdb", (0.0, 0.0, 5.0), (20, 20, 6.5))
    refused = runCommandHere("sample", narrow, "--periodic")
    assertRefused(refused, tmp_path, filesIn(tmp_path), "the periodic box is 0.65 nm wide")
