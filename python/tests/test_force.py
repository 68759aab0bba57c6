"""The face of StericExclusionForce in Python: types, arrays, exceptions, threads."""

import copy
import sys
import threading
import warnings

import numpy as np
import openmm
import pytest
from openmm import unit
from openmmchaintree import MinimumDistance, StericExclusionForce, TraversalStatistics
from openmmchaintree.command.allpairs import HardSpheres
from scenes import makeContext, positionsOf


def test_clashesAreThoseOfAllPairs(villinRun):
    force, _, context = villinRun
    force.setOverlapTolerance(0.0)
    force.updateParametersInContext(context)
    pairs, overlaps = force.getClashes(context)
    expected = HardSpheres(force).overlaps(positionsOf(context))
    assert len(expected.pairs) > 10
    assert np.array_equal(pairs, expected.pairs)
    assert overlaps == pytest.approx(expected.overlaps, abs=1e-12)
    assert force.hasClash(context)


def test_arraysArePlainNumPy(villinRun):
    force, _, context = villinRun
    pairs, distances = force.getNeighborPairs(context, 5 * unit.angstrom)
    assert type(pairs) is np.ndarray and type(distances) is np.ndarray
    assert pairs.dtype == np.int32 and pairs.shape == (len(distances), 2)
    assert pairs.flags.c_contiguous and pairs.flags.writeable
    assert distances.dtype == np.float64 and distances.max() <= 0.5
    positions = positionsOf(context)
    assert distances == pytest.approx(np.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=1))


def test_emptyArraysKeepTheirShape(villinRun):
    force, _, context = villinRun
    pairs, distances = force.getNeighborPairs(context, 0.01)
    assert pairs.shape == (0, 2) and pairs.dtype == np.int32
    assert distances.shape == (0,)


def test_minimumDistance(villinRun):
    force, _, context = villinRun
    positions = positionsOf(context)
    first, second = np.arange(0, 50), np.arange(300, 400)
    nearest = force.getMinimumDistance(context, first, second)
    assert isinstance(nearest, MinimumDistance)
    table = np.linalg.norm(positions[first, None] - positions[None, second], axis=2)
    row, column = np.unravel_index(table.argmin(), table.shape)
    assert nearest == (pytest.approx(table.min()), first[row], second[column])


def test_clashesWithProbe(villinRun):
    force, _, context = villinRun
    positions = positionsOf(context)
    radii = np.array([force.getParticleParameters(i)[0].value_in_unit(unit.nanometer) for i in range(len(positions))])
    probe = positions[100] + [0.1, 0, 0]
    particles, overlaps = force.getClashesWith(context, probe * unit.nanometer, 1 * unit.angstrom)
    expected = radii + 0.1 - np.linalg.norm(positions - probe, axis=1)
    assert np.array_equal(particles, np.flatnonzero(expected > 0.04))
    assert overlaps == pytest.approx(expected[particles])


def test_proposalIsWhatAcceptingSets(villinRun):
    force, _, context = villinRun
    before = positionsOf(context)
    clashFree = force.proposeTorsions(context, np.array([5]), np.array([0.01]))
    assert isinstance(clashFree, bool)
    proposed = force.getProposedPositions(context)
    assert proposed.shape == before.shape and proposed.dtype == np.float64
    assert np.array_equal(positionsOf(context), before)
    pairs, distancesBefore, distancesAfter = force.getChangedNeighborPairs(context, 0.5)
    for positions, distances in ((before, distancesBefore), (proposed, distancesAfter)):
        assert distances == pytest.approx(np.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=1))
    force.acceptProposal(context)
    assert np.array_equal(positionsOf(context), proposed)
    assert not np.array_equal(before, proposed)


def test_rigidMotion(villinRun):
    force, _, context = villinRun
    before = positionsOf(context)
    assert force.proposeRigidMotion(context, 7, [0, 0, 0], [1, 2, 3] * unit.angstrom)
    force.acceptProposal(context)
    assert positionsOf(context) - before == pytest.approx(np.tile([0.1, 0.2, 0.3], (len(before), 1)))


def test_acceptWithoutProposalIsAnOpenMMException(villinRun):
    force, _, context = villinRun
    force.proposeTorsions(context, [0], [0.1])
    force.rejectProposal(context)
    with pytest.raises(openmm.OpenMMException, match="no open proposal"):
        force.acceptProposal(context)


def test_traversalStatistics(villinRun):
    force, _, context = villinRun
    force.hasClash(context)
    statistics = force.getTraversalStatistics(context)
    assert isinstance(statistics, TraversalStatistics)
    assert statistics.queries >= 1 and statistics.particleTests > 0
    force.resetTraversalStatistics(context)
    assert force.getTraversalStatistics(context) == (0, 0, 0, 0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda force, context: force.getNeighborPairs(context, -1), "cutoff"),
        (lambda force, context: force.getNeighborPairs(context, float("nan")), "cutoff"),
        (lambda force, context: force.addParticle(-1), "radius"),
        (lambda force, context: force.addParticle(float("nan")), "radius"),
        (lambda force, context: force.setOverlapTolerance(-0.1), "tolerance"),
        (lambda force, context: force.proposeTorsions(context, [10000], [0.1]), "10000"),
        (lambda force, context: force.proposeTorsions(context, [0, 1], [0.1]), "1"),
        (lambda force, context: force.proposeTorsions(context, [0, 0], [0.1, 0.1]), "torsion 0"),
        (lambda force, context: force.getParticleParameters(10000), "range"),
    ],
)
def test_badArgumentIsAnOpenMMException(villinRun, call, message):
    force, _, context = villinRun
    with pytest.raises(openmm.OpenMMException, match=message):
        call(force, context)


def test_getForceCanBeCast(villinRun):
    _, _, context = villinRun
    lost = context.getSystem().getForce(0)
    assert StericExclusionForce.isinstance(lost)
    assert StericExclusionForce.cast(lost).getNumTorsions() == 138


def test_castOfAnotherForceIsRefused():
    force = openmm.CMMotionRemover()
    assert not StericExclusionForce.isinstance(force)
    with pytest.raises(openmm.OpenMMException, match="not a StericExclusionForce"):
        StericExclusionForce.cast(force)


def test_interpreterIsFreeDuringLongCalls():
    count = 1000
    force = StericExclusionForce()
    system = openmm.System()
    for _ in range(count):
        system.addParticle(1.0)
        force.addParticle(0.001)
    system.addForce(force)
    context = openmm.Context(system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(np.random.default_rng(1).uniform(0, 1, (count, 3)))
    begin = threading.Lock()
    hasRun = []

    def waitAndRun():
        with begin:
            hasRun.append(True)

    begin.acquire()
    thread = threading.Thread(target=waitAndRun)
    thread.start()
    interval = sys.getswitchinterval()
    try:
        # From now on a thread gets the interpreter only from one that gives it away.
        sys.setswitchinterval(1000)
        begin.release()
        for _ in range(10000):  # however late the system lets the other thread run
            pairs, _ = force.getNeighborPairs(context, 2)
            if hasRun:
                break
    finally:
        sys.setswitchinterval(interval)
    assert hasRun
    thread.join()
    assert len(pairs) == count * (count - 1) // 2


def test_anglesWithoutTheIntegrator(villinRun, villin):
    force, _, _ = villinRun
    force = copy.copy(force)
    context = makeContext(villin, force, openmm.VerletIntegrator(0.001))
    angles = force.getTorsionAngles(context)
    assert angles.dtype == np.float64 and angles.shape == (138,)
    assert force.setTorsionAngles(context, np.degrees(-angles) * unit.degrees) is None
    assert force.getTorsionAngles(context) == pytest.approx(-angles, abs=1e-9)
    assert force.getNumToleratedClashes(context) == 0
    force.proposeTorsions(context, [0], [0.1])
    assert force.getNumToleratedClashes(context) > 0


def test_repr(villinRun):
    force, _, _ = villinRun
    bonds, exclusions = f"{force.getNumBonds():,}", f"{force.getNumExclusions():,}"
    assert repr(force) == (
        f"<StericExclusionForce: 582 particles, {bonds} bonds, 138 torsions, {exclusions} exclusions, "
        "overlapTolerance 0.04 nm>"
    )
    assert "," in exclusions
    system = openmm.System()
    system.addForce(StericExclusionForce())
    assert repr(StericExclusionForce.cast(system.getForce(0))) == (
        "<StericExclusionForce: 0 particles, 0 bonds, 0 torsions, 0 exclusions, overlapTolerance 0.04 nm>"
    )


def makePeriodicSystem(method):
    system = openmm.System()
    force, nonbonded = StericExclusionForce(), openmm.NonbondedForce()
    for _ in range(2):
        system.addParticle(1)
        force.addParticle(0.1)
        nonbonded.addParticle(0, 0.1, 0)
    nonbonded.setNonbondedMethod(method)
    nonbonded.setCutoffDistance(0.5)
    system.addForce(nonbonded)
    system.addForce(force)
    return system


def makeBareContext(system):
    return openmm.Context(system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatformByName("Reference"))


@pytest.mark.parametrize("method", [openmm.NonbondedForce.CutoffPeriodic, openmm.NonbondedForce.PME])
def test_periodicForcesAreWarnedOf(method):
    with pytest.warns(UserWarning, match="force 0, NonbondedForce.*spheres ignore periodic images") as caught:
        makeBareContext(makePeriodicSystem(method))
    assert len(caught) == 1
    assert caught[0].filename == __file__


def test_warningsCanBeErrors():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(openmm.OpenMMException, match="spheres ignore periodic images"):
            makeBareContext(makePeriodicSystem(openmm.NonbondedForce.CutoffPeriodic))


@pytest.mark.parametrize("method", [openmm.NonbondedForce.NoCutoff, openmm.NonbondedForce.CutoffNonPeriodic])
def test_noWarningWithoutPeriodicForces(method):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        makeBareContext(makePeriodicSystem(method))


def test_docstringsTellUnitsAndShapes():
    assert "in nm" in StericExclusionForce.addParticle.__doc__
    assert "shape (n, 2)" in StericExclusionForce.getNeighborPairs.__doc__
    assert "setUsesPeriodicBoundaryConditions(true), every pair" in StericExclusionForce.__doc__
