"""What many tests start from."""

import openmmchaintree
import pytest
from openmmchaintree.structure import readStructure
from scenes import makeContext, realStructurePath


@pytest.fixture(scope="session")
def villin():
    """The villin headpiece of OpenMM's package: a Structure."""
    return readStructure()


@pytest.fixture
def realStructure():
    """A function that reads one of the real structures; the test is skipped where they are not at hand."""
    return lambda name: readStructure(realStructurePath(name))


@pytest.fixture
def villinRun(villin):
    """A StericExclusionForce of villin, an integrator with one move, and their Context."""
    force = openmmchaintree.createStericExclusionForce(villin.topology, villin.positions)
    integrator = openmmchaintree.TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(1)
    integrator.addTorsionMove(1, 0.3)
    return force, integrator, makeContext(villin, force, integrator)
