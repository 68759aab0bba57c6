"""Several Contexts in several threads of Python."""

import copy
from concurrent.futures import ThreadPoolExecutor
from threading import Event

import numpy as np
import openmm
import pytest
from openmm import app
from openmmchaintree import StericExclusionForce, TorsionMonteCarloIntegrator, createStericExclusionForce
from scenes import DIPEPTIDE, makeSystem, positionsOf, writePDB


def reference():
    return openmm.Platform.getPlatformByName("Reference")


def sample(villin, system, seed):
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(seed)
    integrator.addTorsionMove(1, 0.3)
    context = openmm.Context(system, integrator, reference())
    context.setPositions(villin.positions)
    force = StericExclusionForce.cast(system.getForce(0))
    clashes = []
    for _ in range(5):
        integrator.step(2)
        clashes.append(len(force.getClashes(context)[0]))
    return positionsOf(context), clashes, integrator.getMoveStatistics(0)


def test_sameAsAlone(villin):
    system = makeSystem(villin, createStericExclusionForce(villin.topology, villin.positions))
    alone = [sample(villin, system, seed) for seed in range(1, 5)]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda seed: sample(villin, system, seed), range(1, 5)))
    for expected, found in zip(alone, together, strict=True):
        assert np.array_equal(expected[0], found[0])
        assert expected[1:] == found[1:]


def test_exceptionsStayInTheirThread(villin):
    force = createStericExclusionForce(villin.topology, villin.positions)
    system = makeSystem(villin, force)
    contexts = [openmm.Context(system, openmm.VerletIntegrator(0), reference()) for _ in range(4)]

    def propose(i):
        contexts[i].setPositions(villin.positions)
        for n in range(100):
            force.proposeTorsions(contexts[i], [1000 if i == 2 and n == 50 else n], [0.1])
        return i

    with ThreadPoolExecutor(4) as pool:
        futures = [pool.submit(propose, i) for i in range(4)]
    assert [futures[i].result() for i in (0, 1, 3)] == [0, 1, 3]
    with pytest.raises(openmm.OpenMMException, match="names torsion 1000"):
        futures[2].result()


def test_oneContext(villin):
    """All calls on one Context from several threads: each waits for the others, or says why it cannot."""
    system = makeSystem(villin, createStericExclusionForce(villin.topology, villin.positions))
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.addTorsionMove(1, 0.3)
    context = openmm.Context(system, integrator, reference())
    context.setPositions(villin.positions)
    integrator.step(1)
    force = StericExclusionForce.cast(system.getForce(0))
    checkpoint, state = context.createCheckpoint(), context.getState(positions=True, integratorParameters=True)
    calls = [
        lambda: integrator.step(2),
        lambda: integrator.step(1),
        lambda: force.getClashes(context),
        lambda: force.proposeTorsions(context, [3], [0.1]),
        lambda: force.acceptProposal(context),
        lambda: context.getState(positions=True, energy=True, integratorParameters=True),
        lambda: integrator.getEnergyPlan(context) and integrator.getPotentialEnergy(context),
        lambda: integrator.getMoveStatistics(0) and integrator.getStageStatistics(),
        lambda: integrator.setTorsionAngles(context, integrator.getTorsionAngles(context)),
        lambda: context.loadCheckpoint(checkpoint),
        lambda: context.setState(state),
        lambda: context.createCheckpoint(),
        lambda: context.setPositions(villin.positions),
        lambda: integrator.removeMove(integrator.addTorsionMove(1, 0.1)),
    ]
    refusals = set()

    def repeat(call):
        for _ in range(30):
            try:
                call()
            except openmm.OpenMMException as error:
                refusals.add(str(error).split(";")[0])

    with ThreadPoolExecutor(len(calls)) as pool:
        list(pool.map(repeat, calls))
    assert refusals <= {
        "another thread is using this Context, in a step or another call of openmm-chaintree",
        "StericExclusionForce: there is no open proposal",
        # OpenMM sets the time of a State before it calls the integrator, and a step may come in between.
        "TorsionMonteCarloIntegrator: the State is damaged: its time or step count was changed (or another thread used "
        "the Context while it was saved or loaded)",
    }
    context.loadCheckpoint(checkpoint)
    integrator.step(1)


def test_waiting(villin):
    """A thread that asks for what has no open end waits for a step, and finds it done."""
    system = makeSystem(villin, createStericExclusionForce(villin.topology, villin.positions))
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.addTorsionMove(1, 0.3)
    integrator.setTrialsPerStep(2000)
    context = openmm.Context(system, integrator, reference())
    context.setPositions(villin.positions)
    with ThreadPoolExecutor(4) as pool:
        for steps in [pool.submit(integrator.step, 2) for _ in range(4)]:
            while not steps.done():
                assert integrator.getMoveStatistics(0).attempted % 2000 == 0
            steps.result()
    assert integrator.getMoveStatistics(0).attempted == 16_000
    assert context.getStepCount() == 8


@pytest.mark.skipif(not hasattr(openmm, "PythonForce"), reason="this OpenMM has no PythonForce")
def test_callsFromWithinAStep(villin):
    """A Force in Python that asks for the state in the midst of a trial is told that it cannot."""
    system = makeSystem(villin, createStericExclusionForce(villin.topology, villin.positions))
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.addTorsionMove(1, 0.3)
    answers = []

    def compute(state):
        if answers:
            with pytest.raises(openmm.OpenMMException, match="from within a step or another call on the same Context"):
                answers[0]()
        return 0.0, np.zeros((system.getNumParticles(), 3))

    python = openmm.PythonForce(compute)
    python.setForceGroup(1)
    system.addForce(python)
    context = openmm.Context(system, integrator, reference())
    context.setPositions(villin.positions)
    force = StericExclusionForce.cast(system.getForce(0))
    for call in (
        lambda: force.getClashes(context),
        lambda: integrator.step(1),
        lambda: integrator.getMoveStatistics(0),
        lambda: context.createCheckpoint(),
    ):
        answers[:] = [call]
        integrator.step(1)


def test_solventIsCheckedInSeveralThreads(tmp_path):
    """Each load of a checkpoint makes the next step compare the energy with OpenMM's, of a copy of the Forces.

    Meanwhile others write and read XML, as copies of integrators do. OpenMM's numbers in XML share memory among all
    threads, and Python's lock alone keeps them apart; steps and States continue without that lock.
    """
    pdb = app.PDBFile(str(writePDB(tmp_path / "dipeptide.pdb", DIPEPTIDE)))
    system = app.ForceField("amber14/protein.ff14SB.xml", "implicit/gbn2.xml").createSystem(pdb.topology)
    system.addForce(createStericExclusionForce(pdb.topology, pdb.positions))

    def sampleAndLoad(seed):
        integrator = TorsionMonteCarloIntegrator(300)
        integrator.setRandomNumberSeed(seed)
        integrator.addTorsionMove(1, 0.3)
        integrator.setTrialsPerStep(5)
        context = openmm.Context(system, integrator, reference())
        context.setPositions(pdb.positions)
        for _ in range(10):
            integrator.step(1)
            context.getState(integratorParameters=True)
            context.loadCheckpoint(context.createCheckpoint())
        return positionsOf(context)

    def copyUntil(stop):
        integrator = TorsionMonteCarloIntegrator(300)
        for size in np.linspace(0.1, 1, 100):
            integrator.addTorsionMove(size / 3, size)
        sizes = [integrator.getTorsionMoveParameters(move) for move in range(integrator.getNumMoves())]
        while not stop.is_set():
            integrator = copy.copy(integrator)
            assert [integrator.getTorsionMoveParameters(move) for move in range(integrator.getNumMoves())] == sizes

    alone = [sampleAndLoad(seed) for seed in (1, 2)]
    stop = Event()
    with ThreadPoolExecutor(5) as pool:
        copies = pool.submit(copyUntil, stop)
        together = list(pool.map(sampleAndLoad, (1, 2, 1, 2)))
        stop.set()
        copies.result()
    assert all(np.array_equal(alone[number % 2], positions) for number, positions in enumerate(together))
