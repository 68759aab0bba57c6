"""Ball joints and pivot moves as Python sees them."""

import copy
import warnings

import numpy as np
import openmm
import openmmchaintree as ct
import pytest
from openmm import app, unit


def beadChain(count):
    """Return a System of a straight chain of beads that turns freely at each bond, its force and its positions."""
    system, force = openmm.System(), ct.StericExclusionForce()
    for i in range(count):
        system.addParticle(1)
        force.addParticle(0.2)
        if i > 0:
            force.addBond(i - 1, i)
            force.addBallJoint(i - 1, i)
    force.createExclusionsFromBonds(1)
    system.addForce(force)
    return system, force, np.arange(count)[:, None] * [0.5, 0, 0]


def test_ballJointsAreKept():
    system, force, _ = beadChain(4)
    assert force.getNumBallJoints() == 3
    assert list(force.getBallJointParticles(2)) == [2, 3]
    assert "3 ball joints" in repr(force)
    assert list(copy.deepcopy(force).getBallJointParticles(1)) == [1, 2]
    assert system.getNumForces() == 1
    with pytest.raises(openmm.OpenMMException, match="Index out of range"):
        force.getBallJointParticles(3)


@pytest.mark.parametrize(
    "rotations", [np.array([[0, 0, np.pi / 2]]), [(0, 0, 90)] * unit.degrees, [[0, 0, 90 * unit.degrees]]]
)
def test_proposals(rotations):
    system, force, positions = beadChain(4)
    context = openmm.Context(system, openmm.VerletIntegrator(0.001))
    context.setPositions(positions)
    assert force.proposeBallRotations(context, [1], rotations)
    proposed = force.getProposedPositions(context)
    assert proposed == pytest.approx(np.array([[0, 0, 0], [0.5, 0, 0], [0.5, 0.5, 0], [0.5, 1, 0]]), abs=1e-12)
    assert not force.proposeBallRotations(context, ballJoints=[1], rotations=[[0, np.pi, 0]])
    with pytest.raises(TypeError, match="rotations must be an angle"):
        force.proposeBallRotations(context, [1], [[0, 0, 1]] * unit.nanometer)
    with pytest.raises(ValueError, match="rotations must have 3 components, not 2"):
        force.proposeBallRotations(context, [1], [[0, 1]])


def test_pivotMoves():
    integrator = ct.TorsionMonteCarloIntegrator(300)
    move = integrator.addPivotMove(weight=2, maxAngle=90 * unit.degrees, ballJoints=np.array([2, 0]))
    weight, maxAngle, joints = integrator.getPivotMoveParameters(move)
    assert (weight, maxAngle.value_in_unit(unit.radian), list(joints)) == (2, np.pi / 2, [2, 0])
    assert integrator.getMoveType(move) == integrator.PivotMove
    assert "pivot ±1.5708 rad" in integrator.getMoveDescription(move)
    integrator.setPivotMoveParameters(move, 1, np.pi)
    assert integrator.getPivotMoveParameters(move)[2] is None
    for bad in ([], np.array([], dtype=int)):
        with pytest.raises(openmm.OpenMMException, match="ballJoints is empty"):
            integrator.addPivotMove(1, 0.1, bad)
    system, force, positions = beadChain(20)
    context = openmm.Context(system, integrator)
    context.setPositions(positions)
    integrator.step(5)
    statistics = integrator.getMoveStatistics(move)
    assert statistics.attempted == 500
    assert 0 < statistics.clashed < 500
    end = context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)
    assert np.linalg.norm(np.diff(end, axis=0), axis=1) == pytest.approx(0.5, abs=1e-13)


def beadTopology(bonds, count):
    topology = app.Topology()
    chain = topology.addChain()
    atoms = [topology.addAtom("CA", app.element.carbon, topology.addResidue("ALA", chain)) for _ in range(count)]
    for i, j in bonds:
        topology.addBond(atoms[i], atoms[j])
    return topology


def test_ballJointsOfATopology():
    # A ring of three with two tails, one of which begins with the highest number; and a separate molecule.
    bonds = [(1, 2), (2, 3), (3, 1), (3, 6), (6, 0), (2, 4), (7, 5)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        force = ct.createStericExclusionForce(
            beadTopology(bonds, 8), radii=[0.2] * 8, torsions=(), ballJoints="bonds", bondCutoff=1
        )
    joints = [tuple(force.getBallJointParticles(i)) for i in range(force.getNumBallJoints())]
    assert joints == [(0, 6), (2, 4), (5, 7), (6, 3)]
    assert force.getNumTorsions() == 0
    assert force.getNumExclusions() == len(bonds)
    given = ct.createStericExclusionForce(beadTopology(bonds, 8), radii=[0.2] * 8, torsions=(), ballJoints=[(4, 2)])
    assert list(given.getBallJointParticles(0)) == [4, 2]
    with pytest.raises(ValueError, match='ballJoints must be "bonds" or pairs of atoms'):
        ct.createStericExclusionForce(beadTopology(bonds, 8), radii=[0.2] * 8, ballJoints="all")


def test_crankshaftMoves():
    integrator = ct.TorsionMonteCarloIntegrator(300)
    move = integrator.addCrankshaftMove(weight=2, maxAngle=90 * unit.degrees, ballJoints=np.array([2, 0, 1]), window=3)
    weight, maxAngle, joints, window = integrator.getCrankshaftMoveParameters(move)
    assert (weight, maxAngle, list(joints), window) == (2, np.pi / 2 * unit.radian, [2, 0, 1], 3)
    integrator.setCrankshaftMoveParameters(move, 1, maxAngle=0.1)
    assert integrator.getCrankshaftMoveParameters(move)[2:] == [None, 8]
    with pytest.raises(TypeError, match="maxAngle must be an angle"):
        integrator.addCrankshaftMove(1, 1 * unit.nanometer)
