"""Several Contexts in several threads of Python."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import openmm
import pytest
from openmmchaintree import StericExclusionForce, TorsionMonteCarloIntegrator, createStericExclusionForce
from scenes import makeSystem, positionsOf


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
