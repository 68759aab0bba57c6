"""Ensembles of independent conformers, by the call and by the command."""

import csv
import json
import os
import signal
import subprocess
import sys
import time

import mdtraj
import numpy as np
import openmm
import pytest
from openmm import unit
from openmmchaintree import (
    InputError,
    TorsionMonteCarloIntegrator,
    addDefaultMoves,
    createCalvadosSystem,
    createStericExclusionForce,
    sampleEnsemble,
)
from openmmchaintree.command.cli import main
from openmmchaintree.ensembles.chainshape import scalingExponent, shapesOf
from openmmchaintree.ensembles.domains import readDomains
from openmmchaintree.structures.structure import readStructure

TAIL = "MDVFMKGLSKAKEGVVAAAEKTKQGVAEAAGKTKEG"


def test_averagesAreThoseOfALongRunByHand():
    ensemble = sampleEnsemble(TAIL, conformers=400, seed=5)
    assert ensemble.isComplete and ensemble.positions.shape == (400, len(TAIL), 3)
    topology, system, positions = createCalvadosSystem(TAIL)
    with pytest.warns(UserWarning, match="harmonic bonds"):
        system.addForce(createStericExclusionForce(topology, positions, system=system))
    integrator = TorsionMonteCarloIntegrator(298)
    integrator.setRandomNumberSeed(6)
    addDefaultMoves(integrator, topology, system)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(positions)
    masses = np.array([system.getParticleMass(i).value_in_unit(unit.dalton) for i in range(len(TAIL))])
    frames = []
    for _ in range(600):
        integrator.step(3)
        frames.append(context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer))
    shapes = shapesOf(np.array(frames)[50:], masses)
    for name, values in shapes.byName().items():
        one = ensemble.estimates[name]
        error = np.hypot(one.standardError, values.std() / np.sqrt(len(values) / 2))
        assert abs(one.mean - values.mean()) < 4 * error, name


def test_conformersAreIndependentAndReproducible():
    ensemble = sampleEnsemble(TAIL, conformers=300, seed=9)
    again = sampleEnsemble(TAIL, conformers=300, seed=9)
    assert np.array_equal(ensemble.positions, again.positions) and ensemble.trials == again.trials
    assert not np.array_equal(ensemble.positions, sampleEnsemble(TAIL, conformers=300, seed=10).positions)
    for values in ensemble.shapes[:2]:
        apart = values - values.mean()
        assert abs(np.mean(apart[1:] * apart[:-1]) / np.var(values)) < 4 / np.sqrt(300)
    bonds = np.linalg.norm(np.diff(ensemble.positions, axis=1), axis=2)
    assert bonds == pytest.approx(0.3825, abs=1e-5)


def test_shapesAreThoseOfMDTraj():
    random = np.random.default_rng(1)
    frames = random.normal(size=(7, 20, 3)) * [1, 2, 3]
    masses = random.uniform(50, 200, 20)
    topology = mdtraj.Topology()
    chain = topology.add_chain()
    for _ in range(20):
        topology.add_atom("CA", mdtraj.element.carbon, topology.add_residue("GLY", chain))
    trajectory = mdtraj.Trajectory(frames, topology)
    squares = np.sum((frames[:, :, np.newaxis] - frames[:, np.newaxis]) ** 2, axis=3)  # of all pairs
    expected = np.sqrt(np.einsum("i,j,fij->f", masses, masses, squares) / 2) / masses.sum()
    assert shapesOf(frames, masses).radiusOfGyration == pytest.approx(expected)
    equal = shapesOf(frames, np.ones(20))
    assert equal.radiusOfGyration == pytest.approx(mdtraj.compute_rg(trajectory), rel=1e-5)
    assert equal.endToEndDistance == pytest.approx(mdtraj.compute_distances(trajectory, [[0, 19]])[:, 0], rel=1e-5)
    assert equal.asphericity == pytest.approx(mdtraj.relative_shape_antisotropy(trajectory), rel=1e-4)


def test_theScalingExponentOfKnownChains():
    rod = np.arange(50.0)[:, np.newaxis] * [[1, 0, 0]]
    assert scalingExponent(rod[np.newaxis]) == pytest.approx(1)
    walks = np.random.default_rng(2).normal(size=(2000, 100, 3)).cumsum(axis=1)
    assert scalingExponent(walks) == pytest.approx(0.5, abs=0.01)
    assert scalingExponent(walks[:, :11]) is None


def test_aLimitEndsTheRun():
    ensemble = sampleEnsemble(TAIL, conformers=500, seed=1, maxTrials=4000)
    assert not ensemble.isComplete and ensemble.trials <= 4050 and 0 < len(ensemble.positions) <= 500


def test_errorsOfTheCall():
    for arguments in ({"conformers": 0}, {"maxTrials": 0}):
        with pytest.raises(InputError, match="must be above 0"):
            sampleEnsemble(TAIL, **arguments)
    with pytest.raises(InputError, match="nothing can move"):
        sampleEnsemble("A")
    with pytest.raises(InputError, match="several chains need a box"):
        sampleEnsemble([TAIL, TAIL])


def test_domainsStayRigid():
    source = readStructure()  # villin
    domains = readDomains("10-25", source.topology)
    ensemble = sampleEnsemble(source, "calvados3", conformers=20, seed=1, domains=domains)
    inside = ensemble.positions[:, domains[0]]
    distances = np.linalg.norm(inside[:, :, np.newaxis] - inside[:, np.newaxis], axis=3)
    assert np.ptp(distances, axis=0).max() < 1e-5 < np.ptp(ensemble.shapes.endToEndDistance)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1-5x", "'1-5x' is no range of residues"),
        ("", "'' is no range"),
        ("500-600", "500-600: there are no residues"),
        ("10-15,15-20", "residue 15 is in 10-15 and in 15-20"),
        ("Z:10-15", "Z:10-15: there are no residues"),
    ],
)
def test_errorsOfDomains(text, message):
    with pytest.raises(InputError, match=message):
        readDomains(text, readStructure().topology)


# ---- The command ----


def run(capsys, *arguments):
    status = main(["ensemble", *map(str, arguments)])
    return status, *capsys.readouterr()


@pytest.fixture
def fasta(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "two.fasta"
    path.write_text(f">one first\n{TAIL}\n>../evil/one\n{TAIL[:20]}\n{TAIL[20:30]}*\n", encoding="utf-8")
    return path


def test_theCommandWritesEachProtein(fasta, tmp_path, capsys):
    status, printed, errors = run(capsys, fasta, "--conformers", 40, "--seed", 3, "--pictures", 1, "--json", "all.json")
    folder = tmp_path / "two-ensemble"
    assert status == 0 and errors == "" and "2 of 2 proteins" in printed
    assert sorted(path.name for path in folder.iterdir()) == [
        "_evil_one-topology.pdb", "_evil_one.csv", "_evil_one.dcd", "_evil_one.json",
        "one-topology.pdb", "one.csv", "one.dcd", "one.json", "one.png", "summary.csv",
    ]  # fmt: skip
    trajectory = mdtraj.load(folder / "one.dcd", top=folder / "one-topology.pdb")
    ensemble = sampleEnsemble(TAIL, conformers=40, seed=3)
    assert trajectory.xyz == pytest.approx(ensemble.positions, abs=1e-5)
    with open(folder / "one.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["radius of gyration (nm)"]) for row in rows] == pytest.approx(
        ensemble.shapes.radiusOfGyration, abs=1e-6
    )
    summaries = json.loads((tmp_path / "all.json").read_text(encoding="utf-8"))["proteins"]
    assert [one["residues"] for one in summaries] == [36, 30]
    mean = ensemble.estimates["radius of gyration"].mean
    assert summaries[0]["estimates"]["radius of gyration"]["mean"] == pytest.approx(mean)


def test_aRunIsResumed(fasta, tmp_path, capsys):
    arguments = (fasta, "--conformers", 20, "--seed", 3, "--pictures", 0)
    folder = tmp_path / "two-ensemble"
    assert run(capsys, *arguments)[0] == 0
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert "exists; --resume keeps finished proteins" in run(capsys, *arguments)[2]
    (folder / "_evil_one.json").unlink()
    (folder / "_evil_one.dcd").write_bytes(b"torn")
    kept = (folder / "one.dcd").stat().st_mtime_ns
    assert run(capsys, *arguments, "--resume")[0] == 0
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    assert (folder / "one.dcd").stat().st_mtime_ns == kept
    others = (fasta, "--conformers", 21, "--seed", 3, "--resume")
    assert "one.json: was made with conformers 20, not 21" in run(capsys, *others)[2]
    (folder / "one.json").write_text("{", encoding="utf-8")
    assert "one.json: cannot be read as a protein's averages" in run(capsys, *arguments, "--resume")[2]


def test_aKilledRunIsResumed(fasta, tmp_path, capsys):
    fasta.write_text("".join(f">p{i}\n{TAIL}\n" for i in range(12)), encoding="utf-8")
    arguments = ["ensemble", str(fasta), "--conformers", "60", "--seed", "3", "--pictures", "0", "--workers", "2"]
    whole, killed = ["-o", "whole"], ["-o", "killed"]
    assert main([*arguments, *whole]) == 0
    process = subprocess.Popen([sys.executable, "-m", "openmmchaintree", *arguments, *killed], start_new_session=True)
    deadline = time.monotonic() + 120
    while not list((tmp_path / "killed").glob("*.json")) and time.monotonic() < deadline:
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    assert main([*arguments, *killed, "--resume"]) == 0
    for path in (tmp_path / "whole").iterdir():
        assert (tmp_path / "killed" / path.name).read_bytes() == path.read_bytes(), path.name


def test_errorsOfTheCommand(fasta, tmp_path, capsys):
    (tmp_path / "empty.fasta").write_text("", encoding="utf-8")
    (tmp_path / "binary.fa").write_bytes(bytes(range(256)))
    (tmp_path / "x.fasta").write_text(">a\nAXA\n>b\nAAAAAA\n", encoding="utf-8")
    for arguments, message in (
        (["missing.fasta"], "missing.fasta: No such file"),
        (["empty.fasta"], "empty.fasta: "),
        (["binary.fa"], "binary.fa: is no FASTA file"),
        ([fasta, "--domains", "1-5"], "--domains needs a structure"),
        ([fasta, "--resume"], "two-ensemble: is no folder"),
        (["x.fasta", "--conformers", "5"], "1 of 2 proteins failed; the first: a: calvados2 has no residue X"),
    ):
        status, _, errors = run(capsys, *arguments)
        assert status == 2 and message in errors, arguments
    assert (tmp_path / "x-ensemble" / "b.json").exists() and not (tmp_path / "two-ensemble").exists()
    status, printed, _ = run(capsys, fasta, "--conformers", 500, "--max-trials", 3000, "--pictures", 0)
    assert status == 3 and "are independent" in printed
