"""What many tests start from."""

import openmmchaintree
import pytest
from commands import callMain
from openmm import app, unit
from openmmchaintree.command.cli import main
from openmmchaintree.structures.structure import readStructure
from scenes import makeContext, realStructurePath


@pytest.fixture(scope="session")
def villin():
    """The villin headpiece of OpenMM's package: a Structure."""
    return readStructure()


@pytest.fixture(scope="session")
def structure(villin, tmp_path_factory):
    """A PDB file of villin."""
    path = tmp_path_factory.mktemp("villin") / "villin.pdb"
    with open(path, "w") as file:
        app.PDBFile.writeFile(villin.topology, villin.positions * unit.nanometer, file)
    return path


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


@pytest.fixture
def runCommandHere(tmp_path, monkeypatch, capsys):
    """A function that runs the command within this process, in tmp_path: quicker where it stops early."""

    def run(*arguments):
        monkeypatch.chdir(tmp_path)
        return callMain(main, arguments, capsys)

    return run
