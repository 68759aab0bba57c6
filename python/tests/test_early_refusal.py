"""Trials that a force field all but forbids are refused before their energy is known, and no others."""

import openmm
import pytest
from openmm import app
from openmmchaintree import TorsionMonteCarloIntegrator, createStericExclusionForce
from scenes import realStructurePath


def makeSampler(topology, positions, *files):
    """Return an integrator with a tiny move and a large one, and its Context."""
    system = app.ForceField(*files).createSystem(topology)
    system.addForce(createStericExclusionForce(topology, positions))
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(1)
    integrator.addTorsionMove(1, 1e-7)
    integrator.addTorsionMove(1, 3)
    integrator.setTrialsPerStep(400)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(positions)
    assert integrator.getStericModeInContext(context) == integrator.Off
    return integrator, context


def assertNoneIsRefusedWhereItStands(integrator):
    """As it stands, nothing is refused, though spheres clash and charges that are alike are near each other."""
    integrator.step(2)
    tiny, large = (integrator.getMoveStatistics(move) for move in range(2))
    assert tiny.attempted > 100 and tiny.clashed == 0
    assert large.clashed > 0


def test_protein(villin):
    integrator, _ = makeSampler(villin.topology, villin.positions, "amber14/protein.ff14SB.xml")
    assertNoneIsRefusedWhereItStands(integrator)


@pytest.mark.parametrize("name", ["1bna.pdb"])
def test_nucleicAcid(name):
    """Its phosphates repel each other by more than 60 kT far outside contact."""
    pdb = app.PDBFile(str(realStructurePath(name)))
    modeller = app.Modeller(pdb.topology, pdb.positions)
    modeller.deleteWater()
    forceField = app.ForceField("amber14/DNA.OL15.xml")
    modeller.addHydrogens(forceField, platform=openmm.Platform.getPlatformByName("Reference"))
    integrator, _ = makeSampler(modeller.topology, modeller.positions, "amber14/DNA.OL15.xml")
    assertNoneIsRefusedWhereItStands(integrator)
