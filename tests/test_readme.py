"""The examples of README.md work."""

import re
from pathlib import Path

import openmm
import openmm.app
from openmm import unit
from openmmchaintree import TorsionMonteCarloIntegrator
from openmmchaintree.structures.structure import readStructure

README = Path(__file__).parents[1] / "README.md"


def test_theExamplesInPythonRun(tmp_path, monkeypatch):
    example, choice = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    villin = readStructure()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("OPENMM_DEFAULT_PLATFORM", "CPU")  # the quickest that every machine has
    with open("protein.pdb", "w") as file:
        openmm.app.PDBFile.writeFile(villin.topology, villin.positions * unit.nanometer, file)
    variables = {}
    exec(example, variables)

    assert Path("protein.dcd").stat().st_size > 0
    integrator = variables["integrator"]
    statistics = [integrator.getMoveStatistics(move) for move in range(integrator.getNumMoves())]
    attempted, clashed, rejected, accepted = map(sum, zip(*statistics, strict=True))
    takenBack = integrator.getOuterStatistics().trialsTakenBack
    assert attempted + takenBack == 40000
    assert min(clashed, rejected, accepted) > 0

    exec(choice, variables)
    start, end = villin.positions, _sample(variables["system"], variables["force"], villin.positions)
    hasMoved = abs(end - start).max(axis=1) > 0
    residues = [int(atom.residue.id) for atom in villin.topology.atoms()]
    assert {residue for residue, moved in zip(residues, hasMoved, strict=True) if moved} >= set(range(1, 20))
    assert not any(moved for residue, moved in zip(residues, hasMoved, strict=True) if residue > 20)


def _sample(system, force, positions):
    """Sample with the masses of a System and nothing but the force; return the last positions."""
    bare = openmm.System()
    for particle in range(system.getNumParticles()):
        bare.addParticle(system.getParticleMass(particle))
    bare.addForce(force)
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.addTorsionMove(1, 0.2)
    context = openmm.Context(bare, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(positions)
    integrator.step(10)
    return context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)
