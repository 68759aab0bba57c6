"""README.md is short, and its blocks of code run."""

import re
import shutil
from pathlib import Path

import openmm
import openmm.app
import pytest
from openmm import unit
from openmmchaintree import TorsionMonteCarloIntegrator
from openmmchaintree.structures.structure import readStructure
from pages import PROJECT, blocksOf, commandsOf, runCommand

README = (PROJECT / "README.md").read_text(encoding="utf-8")
PACKAGE_FILE = Path(openmm.app.__file__).parent / "data" / "test.pdb"  # the villin headpiece in water
INSTALLED, TESTED, JOBS = re.findall(r"```sh\n(.*?)```", README, re.DOTALL)


def test_itIsShort():
    assert len(README.split()) <= 600


def test_theFirstTwoBlocksAreOneCommandEach():
    """.ci/run runs the second one, which runs this test; the first one ends with the command that runs below."""
    assert INSTALLED.count("\n") == TESTED.count("\n") == 1
    make, install, sample = INSTALLED.strip().split(" && ")
    environment = make.removeprefix("python3 -m venv ")
    assert install.startswith(f"{environment}/bin/pip install ") and sample.startswith(f"{environment}/bin/")
    assert "cmake" in TESTED and "ctest" in TESTED


def test_theFirstResultIsMade(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    command = INSTALLED.strip().split(" && ")[-1].split("/bin/")[1].split()
    output = runCommand([*command, "--trials", "2000"], capsys)
    assert "2,000 trials" in output and (tmp_path / "villin.png").exists()


JOB_COMMANDS = commandsOf(JOBS)


@pytest.mark.parametrize("words", JOB_COMMANDS, ids=range(1, len(JOB_COMMANDS) + 1))
def test_theJobRuns(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    shutil.copy(PACKAGE_FILE, tmp_path / "my.pdb")
    (tmp_path / "my.fasta").write_text(">short\nGSGSGS\n")
    with open(tmp_path / "model.pdb", "w") as file:
        villin = readStructure()
        openmm.app.PDBFile.writeFile(villin.topology, villin.positions * unit.nanometer, file)
    sample, ensemble = ["--trials", "400", "--frames", "1", "-o", "few"], ["--conformers", "20", "--workers", "1"]
    few = {"sample": sample, "ensemble": ensemble}.get(words[1], [])
    if "--temperatures" in words:  # Contexts of twelve replicas take long
        words[words.index("--temperatures") + 1] = "300:320:2"
    output = runCommand([*words, *few], capsys)
    written = {"sample": "few.png", "ensemble": "my-ensemble", "clashes": "1,000 atoms", "repair": "model-repaired.pdb"}
    assert written[words[1]] in output


def test_theExamplesInPythonRun(tmp_path, monkeypatch):
    (example,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    shown, choice = (text for name, text in blocksOf("get-started.md") if name in ("README.md", "python"))
    assert shown == example
    villin = readStructure()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("OPENMM_DEFAULT_PLATFORM", "CPU")  # the quickest that every machine has
    shutil.copy(PACKAGE_FILE, "protein.pdb")
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
