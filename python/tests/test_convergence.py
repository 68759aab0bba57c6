"""What `sample` says about the means of a run, compared with its files and with series that are known."""

import csv
import json

import numpy as np
import pytest
from commands import assertRefused
from openmm import app
from openmmchaintree.command.convergence import estimateGroups
from openmmchaintree.command.ladderweights import weighLadder
from openmmchaintree.command.outputs.indexfile import readIndex
from openmmchaintree.command.series import Group, Series
from openmmchaintree.statistics.estimates import estimate, estimateAngle
from openmmchaintree.torsions import Torsion
from scenes import readDCD, writeSmallStructures
from scipy.signal import lfilter
from test_replicas import IN_FORCE_FIELD


@pytest.fixture
def runHere(runCommandHere, tmp_path):
    writeSmallStructures(tmp_path)
    return lambda *arguments: runCommandHere("sample", *arguments)


def dihedral(frames, particles):
    first, second, third, fourth = (frames[:, particle].astype(float) for particle in particles)
    before, axis, after = second - first, third - second, fourth - third
    normals = np.cross(before, axis), np.cross(axis, after)
    sine = (before * normals[1]).sum(1) * np.linalg.norm(axis, axis=1)
    return np.arctan2(sine, (normals[0] * normals[1]).sum(1))


# ---- Runs ----


def test_aSingleRun(runHere, tmp_path):
    result = runHere("run.pdb", "--trials", 40000, "--frames", 100, "--seed", 3, "--json", "a.json")
    assert result.returncode == 0, result.stderr
    (found,) = json.loads((tmp_path / "a.json").read_text())["estimates"]
    lines = (tmp_path / "run.csv").read_text().splitlines()
    assert lines[0].startswith('#"Trial","Radius of Gyration (nm)"') and len(lines) == 102
    table = np.genfromtxt(lines[1:], delimiter=",")
    left = found["equilibration"]["frames"]
    assert found["equilibration"]["trials"] == 400 * left and found["values"] == 100 - left
    by = {entry["name"]: entry for entry in found["observables"]}
    expected = estimate([table[1 + left :, 1]])
    radius = by["radiusOfGyration"]
    assert radius["mean"] == pytest.approx(table[1 + left :, 1].mean()) and radius["unit"] == "nm"
    assert radius["standardError"] == pytest.approx(expected.standardError)
    assert radius["autocorrelationTime"] == pytest.approx(400 * expected.autocorrelationTime)
    assert "potentialEnergy" not in by
    # The torsion of the last φ, from the trajectory and the topology that others read.
    topology = app.PDBFile(str(tmp_path / "run-topology.pdb")).topology
    names = {(atom.residue.index, atom.name): atom.index for atom in topology.atoms()}
    frames = readDCD(tmp_path / "run.dcd")[1 + left :]
    (entry,) = [entry for entry in found["torsions"] if entry["kind"] == "phi"]
    angles = dihedral(frames, [names[0, "C"], names[1, "N"], names[1, "CA"], names[1, "C"]])
    expected = estimateAngle([angles])
    assert entry["count"] == 1 and entry["slowest"].startswith("phi of ")
    assert entry["effectiveSampleSize"] == pytest.approx(expected.effectiveSampleSize, rel=1e-3)
    assert f"means over {found['values']} frames" in result.stdout and "φ: A:GLY 2" in result.stdout
    assert found["verdict"] is None or f"do not quote these means: {found['verdict']}" in result.stdout


def test_tooShort(runHere, tmp_path):
    result = runHere("run.pdb", "--trials", 300, "--frames", 3, "--json", "a.json", "--seed", 1)
    (found,) = json.loads((tmp_path / "a.json").read_text())["estimates"]
    assert found["verdict"].startswith("too short: 3 values (")
    assert f"do not quote these means: {found['verdict']}" in result.stdout
    alone = runHere("run.pdb", "--trials", 1, "--frames", 1, "-o", "b", "--json", "b.json")
    assert alone.returncode == 0, alone.stderr
    assert json.loads((tmp_path / "b.json").read_text())["estimates"][0]["observables"][0]["standardError"] is None


def test_independentReplicas(runHere, tmp_path):
    options = ("--replicas", 3, "--trials", 20000, "--frames", 50, "--seed", 3)
    result = runHere("run.pdb", *options, "--json", "a.json")
    assert result.returncode == 0, result.stderr
    (found,) = json.loads((tmp_path / "a.json").read_text())["estimates"]
    index = readIndex(tmp_path / "run-index.csv")
    left = found["equilibration"]["frames"]
    chains = [index["rmsd"][(index["replica"] == one) & (index["frame"] > left)] for one in range(3)]
    (entry,) = [entry for entry in found["observables"] if entry["name"] == "rmsd"]
    assert found["chains"] == 3 and found["values"] == 3 * (50 - left)
    assert entry["rhat"] == pytest.approx(estimate(chains).rhat)
    assert index["acceptance"][-1] == pytest.approx(_acceptanceOf(tmp_path / "a.json", 2))
    assert " of 3 replicas" in result.stdout


def _acceptanceOf(path, replica):
    summary = json.loads(path.read_text())
    return 100 * summary["ends"][replica]["accepted"] / summary["trials"]


def test_ladder(runHere, tmp_path):
    ladder = ("--temperatures", "300:400:3", "--trials-per-exchange", 200, "--trials", 8000, "--frames", 40)
    for files in ("temperature", "replica"):
        names = ("--trajectories", files, "-o", files, "--json", f"{files}.json")
        result = runHere(*IN_FORCE_FIELD, *ladder, *names)
        assert result.returncode == 0, result.stderr
    summary = json.loads((tmp_path / "temperature.json").read_text())
    found = summary["estimates"]
    # The torsions of a temperature are the same, whatever trajectory holds them.
    assert found == json.loads((tmp_path / "replica.json").read_text())["estimates"]
    assert [one["temperature"] for one in found] == [one["temperature"] for one in summary["temperatures"]]
    index = readIndex(tmp_path / "replica-index.csv")
    for one in found:
        rows = (index["temperature"] == one["temperature"]) & (index["frame"] > one["equilibration"]["frames"])
        energy = one["observables"][0]
        assert energy["name"] == "potentialEnergy" and one["chains"] == 1
        assert energy["mean"] == pytest.approx(index["potentialEnergy"][rows].mean())
    cold = summary["atLowestTemperature"]
    with open(tmp_path / "replica-weights.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == cold["samples"] > 3 and sum(float(row["weight"]) for row in rows) == pytest.approx(1)
    places = {place: number for number, place in enumerate(zip(index["frame"], index["replica"], strict=True))}
    rows = [(places[int(row["frame"]), int(row["replica"])], row) for row in rows]
    assert all(index["temperature"][place] == float(row["temperature"]) for place, row in rows)
    mean = sum(float(row["weight"]) * index["potentialEnergy"][place] for place, row in rows)
    assert cold["observables"][0]["mean"] == pytest.approx(mean)
    assert "means at 300.0 K" in result.stdout and "all temperatures" in result.stdout


def test_untilEnoughSamples(runHere, tmp_path):
    """A run ends when it has enough, and where it ends does not depend on an interruption."""
    options = ("run.pdb", "--trials-per-frame", 50, "--trials-per-round", 500, "--seed", 1)
    result = runHere(*options, "--until-ess", 150, "-o", "whole", "--json", "whole.json")
    assert result.returncode == 0 and "ended by --until-ess 150; --resume continues" in result.stdout
    whole = json.loads((tmp_path / "whole.json").read_text())
    (found,) = whole["estimates"]
    assert found["leastSampleSize"] >= 150 and found["largestRhat"] <= 1.05 and found["verdict"] is None
    assert whole["endedBy"] == "--until-ess 150"
    cut = runHere(*options, "--until-ess", 40, "-o", "cut", "--json", "cut.json")
    assert cut.returncode == 0 and json.loads((tmp_path / "cut.json").read_text())["trials"] < whole["trials"]
    resumed = runHere("--resume", "cut.checkpoint", "--until-ess", 150)
    assert resumed.returncode == 0, resumed.stderr
    assert json.loads((tmp_path / "cut.json").read_text())["estimates"] == whole["estimates"]
    assert (tmp_path / "cut.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()
    # Trials that do not suffice end it, too.
    short = runHere("run.pdb", "--until-ess", 1000, "--trials", 500, "-o", "short", "--seed", 1)
    assert short.returncode == 0 and "ended by" not in short.stdout


@pytest.mark.parametrize("least", ["0", "-3", "many", "1e9"])
def test_wrongSampleSize(runHere, tmp_path, least):
    assertRefused(runHere("run.pdb", "--until-ess", least), tmp_path, ["dipeptide.pdb", "run.pdb"], "--until-ess")


# ---- Known series ----


def autoregressive(time, length, seed=1):
    ratio = time / (1 + time)
    return lfilter([np.sqrt(1 - ratio**2)], [1, -ratio], np.random.default_rng(seed).normal(size=length))


def torsionsOf(kinds):
    """Return a Torsion of each kind, of residues ALA 1, ALA 2, …"""
    topology = app.Topology()
    chain = topology.addChain("A")
    residues = [topology.addResidue("ALA", chain) for _ in kinds]
    atoms = [[topology.addAtom(name, None, residue).index for name in ("N", "CA", "C", "O")] for residue in residues]
    return [Torsion(tuple(four), kind, residue) for four, kind, residue in zip(atoms, kinds, residues, strict=True)]


def estimatesOf(measured, angles, kinds, chains=1):
    length = len(angles) // chains
    rows = list(np.arange(chains * length).reshape(chains, length))
    split = {name: list(values.reshape(chains, length)) for name, values in measured.items()}
    group = Group(None, rows, split, list(angles.reshape(chains, length, -1)))
    return estimateGroups(Series([group], 100, 2), torsionsOf(kinds), 1e-3)[0]


def test_theSlowestTorsionIsNamed():
    angles = 0.5 * np.array([autoregressive(time, 4000, seed) for seed, time in enumerate((1, 60, 3, 1))]).T
    found = estimatesOf({"rmsd": 1 + 0.1 * autoregressive(2, 4000, 9)}, angles, ["phi", "phi", "psi", "rotor"])
    phi, psi, rotor = found["torsions"]
    assert (phi["kind"], phi["count"], phi["slowest"]) == ("phi", 2, "phi of A:ALA 2")
    assert phi["autocorrelationTime"] == pytest.approx(100 * 60, rel=0.5)
    assert psi["slowest"] == "psi of A:ALA 3" and rotor["slowest"] == "rotor CA–C of A:ALA 4"
    assert psi["mean"] == pytest.approx(0, abs=5) and psi["verdict"] is None
    assert found["leastSampleSize"] == phi["effectiveSampleSize"] < 60
    assert found["equilibration"]["trials"] == 50 * found["equilibration"]["frames"]


def test_verdicts():
    moving = 0.5 * autoregressive(1, 3000, 1)
    steady = {"rmsd": 1 + 0.1 * autoregressive(2, 3000, 2)}
    fine = estimatesOf(steady, moving[:, None], ["psi"])
    assert fine["verdict"] is None and fine["leastSampleSize"] > 300 and fine["largestRhat"] < 1.05
    # An end-to-end distance between ends that nothing moves is no failure, a torsion that should turn is one.
    still = np.full(3000, 0.3)
    assert estimatesOf({**steady, "endToEndDistance": still}, moving[:, None], ["psi"])["verdict"] is None
    stuck = estimatesOf(steady, np.array([moving, still + 1e-5 * moving]).T, ["psi", "chi1"])
    assert stuck["verdict"] == "too short: chi1 of A:ALA 2 has not turned" and stuck["leastSampleSize"] == 0
    # Replicas that stay in different states have a small R-hat each, and a large one together.
    apart = estimatesOf(steady, (moving + 2 * (np.arange(3000) >= 1500))[:, None], ["psi"], chains=2)
    assert apart["largestRhat"] > 1.5 and "psi of A:ALA 1" in apart["verdict"]
    drifting = estimatesOf({"rmsd": np.linspace(0, 1, 3000)}, moving[:, None], ["psi"])
    assert drifting["verdict"].startswith("too short: effective sample size ") and "(rmsd)" in drifting["verdict"]
    broken = steady["rmsd"].copy()
    broken[7] = np.nan
    assert "1 values are not numbers (rmsd)" in estimatesOf({"rmsd": broken}, moving[:, None], ["psi"])["verdict"]
    assert estimatesOf({}, np.empty((3000, 0)), [])["verdict"] == "nothing varies"


def test_weightsOfALadder():
    """Oscillators, whose mean energy at 300 K is known, with correlated samples at four temperatures."""
    temperatures, shape = np.geomspace(300, 450, 4), 20
    random = np.random.default_rng(1)
    groups = []
    for number, kelvin in enumerate(temperatures):
        energies = np.repeat(random.gamma(shape, 8.31446261815324e-3 * kelvin, size=300), 3)
        rows = 4 * np.arange(900) + number
        groups.append(Group(kelvin, [rows], {"potentialEnergy": [energies]}, [np.empty((900, 0))]))
    series = Series(groups, 100, 1)
    summary, rows, weights = weighLadder(series, estimateGroups(series, [], 1e-3))
    assert weights.sum() == pytest.approx(1) and len(rows) == len(weights) == summary["samples"]
    assert 500 < summary["samples"] < 2000  # some of every three that are the same
    (energy,) = summary["observables"]
    assert abs(energy["mean"] - 8.31446261815324e-3 * 300 * shape) < 4 * energy["standardError"]
