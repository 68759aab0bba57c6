"""The command ensemble with --loop: its files, and options that contradict each other."""

import csv
import json

import mdtraj
import numpy as np
import openmm
import pytest
from openmm import app
from openmm.unit import kilojoule_per_mole
from openmmchaintree.command.cli import main
from openmmchaintree.structures.structure import readStructure

_VILLIN = app.__path__[0] + "/data/test.pdb"


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path / "test-ensemble"


def run(capsys, *arguments):
    status = main(["ensemble", *map(str, arguments)])
    return status, *capsys.readouterr()


def test_files_of_a_loop(folder, capsys):
    arguments = (_VILLIN, "--loop", "22-25", "--model", "coil", "--conformers", 3, "--seed", 5, "--trials", 200)
    status, printed, errors = run(capsys, *arguments, "--json", "all.json")
    assert (
        status == 0 and errors == "" and "closed loops without clashes" in printed and "Wrote 3 conformers" in printed
    )
    names = ["test-topology.pdb", "test.csv", "test.dcd", "test.json"]
    assert sorted(path.name for path in folder.iterdir()) == names
    trajectory = mdtraj.load(folder / "test.dcd", top=folder / "test-topology.pdb")
    structure = readStructure(_VILLIN)
    moved = np.ptp(np.concatenate((trajectory.xyz, structure.positions[np.newaxis])), axis=0).max(axis=1) > 1e-4
    numbers = {int(atom.residue.id) for atom in structure.topology.atoms() if moved[atom.index]}
    assert numbers == {22, 23, 24, 25}
    with open(folder / "test.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    names = ("N", "CA", "C", "O")
    loop = [a.index for a in structure.topology.atoms() if 22 <= int(a.residue.id) <= 25 and a.name in names]
    distances = np.sqrt(((trajectory.xyz - structure.positions)[:, loop] ** 2).sum(axis=2).mean(axis=1))
    assert [float(row["RMSD (nm)"]) for row in rows] == pytest.approx(distances, abs=1e-5)
    summary = json.loads((folder / "test.json").read_text(encoding="utf-8"))
    assert summary == json.loads((folder.parent / "all.json").read_text(encoding="utf-8"))
    assert summary["isComplete"] and summary["effectiveSampleSize"] >= 3 and summary["grown"] >= 3
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    status, _, errors = run(capsys, *arguments)
    assert status == 2 and "exists; --overwrite replaces it" in errors
    assert run(capsys, *arguments, "--overwrite")[0] == 0
    assert before == {path.name: path.read_bytes() for path in folder.iterdir()}


def test_too_few_conformers(capsys):
    status, printed, _ = run(
        capsys, _VILLIN, "--loop", "22-25", "--model", "coil", "--conformers", 9, "--max-grown", 4, "--seed", 1
    )
    assert status == 3 and "grow more with --max-grown" in printed


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--loop", "22-25"], "--loop needs --model coil or --forcefield"),
        (["--loop", "22-25", "--model", "coil", "--missing"], "--missing cannot be used with --loop"),
        (["--loop", "22-25", "--model", "coil", "--domains", "1-5"], "--domains cannot be used with --loop"),
        (["--loop", "22-25", "--model", "coil", "--resume"], "--resume cannot be used with --loop"),
        (["--loop", "22-25", "--model", "coil", "--prepare"], "--prepare needs --forcefield"),
        (["--loop", "22-25", "--model", "coil", "--forcefield", "x.xml"], "cannot be used together"),
        (["--loop", "22-25", "--forcefield", "no.xml"], "--forcefield no.xml"),
        (["--loop", "22-99", "--model", "coil"], "22-99: there is no residue 99"),
        (["--max-grown", "5"], "--max-grown needs --loop"),
        (["--forcefield", "amber14-all.xml"], "--forcefield needs --loop"),
    ],
)
def test_wrong_options(folder, capsys, arguments, message):
    status, _, errors = run(capsys, _VILLIN, *arguments)
    assert status == 2 and message in errors and errors.count("\n") == 1 and not folder.exists()


def test_sequences_have_no_loops(capsys, tmp_path):
    (tmp_path / "x.fasta").write_text(">a\nAAAAAAAA\n")
    assert "--loop needs a structure" in run(capsys, "x.fasta", "--loop", "2-5", "--model", "coil")[2]


def test_annealing(folder, capsys):
    options = ("--loop", "22-25", "--conformers", 1, "--seed", 5, "--trials", 400, "--temperature", 300)
    status, printed, _ = run(capsys, _VILLIN, *options, "--forcefield", "amber14-all.xml", "implicit/gbn2.xml")
    assert status == 0 and "Lowest energy" in printed
    summary = json.loads((folder / "test.json").read_text(encoding="utf-8"))
    structure = readStructure(_VILLIN)
    trajectory = mdtraj.load(folder / "test.dcd", top=folder / "test-topology.pdb")
    system = app.ForceField("amber14-all.xml", "implicit/gbn2.xml").createSystem(structure.topology)
    context = openmm.Context(system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(trajectory.xyz[0])
    energy = context.getState(energy=True).getPotentialEnergy().value_in_unit(kilojoule_per_mole)
    assert summary["lowestEnergy"] == pytest.approx(energy, abs=2)  # the trajectory has single precision
    assert summary["givenDistance"] < 0.3 and summary["grown"] == 1
    fixed = [atom.index for atom in structure.topology.atoms() if not 22 <= int(atom.residue.id) <= 25]
    assert trajectory.xyz[0, fixed] == pytest.approx(structure.positions[fixed], abs=1e-5)
