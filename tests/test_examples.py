"""The examples run with the expected results, and have no type errors."""

import csv
import os
import re
import subprocess
import sys
from pathlib import Path

import openmmchaintree
import pytest
from openmm import app, unit

PROJECT = Path(__file__).parents[1]
EXAMPLES = sorted((PROJECT / "examples").glob("*.py"))
DOCS = PROJECT / "docs"


def run(name, *arguments, folder, statuses=(0,)):
    """Run an example in a folder, on the fastest platform that every machine has; return its output."""
    command = [sys.executable, str(PROJECT / "examples" / name), *map(str, arguments)]
    environment = {**os.environ, "OPENMM_DEFAULT_PLATFORM": "CPU"}
    result = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert result.returncode in statuses, result.stderr
    return result.stdout


def test_sampleProtein(tmp_path):
    output = run("sample_protein.py", 1, folder=tmp_path)
    moves = re.findall(r"(\d+) trials, (\d+) clashed, (\d+) rejected by energy, (\d+) accepted", output)
    counts = [[int(count) for count in move] for move in moves]
    outer = re.search(r"^outer tests: (\d+) of (\d+) kept their trials, (\d+) were undone$", output, re.MULTILINE)
    assert int(outer[1]) <= int(outer[2])
    assert len(counts) == 3 and sum(move[0] for move in counts) == 400 - int(outer[3])
    assert all(move[0] == sum(move[1:]) for move in counts)
    assert sum(move[3] for move in counts) + int(outer[3]) > 10  # the only outer test may undo all trials
    kinds = re.findall(r"^ +\d  (\w+) +(constant|native|foreign|not sampled) +\w+", output, re.MULTILINE)
    plan = re.findall(r"^ +\d  \w+ .*$", output, re.MULTILINE)
    assert len(plan) == 7 and "\n".join(plan) in (DOCS / "sampling.md").read_text(encoding="utf-8")
    assert dict(kinds)["HarmonicBondForce"] == "constant"
    assert dict(kinds)["NonbondedForce"] == "native"
    assert dict(kinds)["CustomGBForce"] == "native"
    stages = re.findall(r"^([a-z ]+): computed for (\d+) trials, rejected (\d+)$", output, re.MULTILINE)
    assert sum(int(refused) for _, _, refused in stages) == sum(move[2] for move in counts)
    assert (tmp_path / "sampled.pdb").stat().st_size > 0 and (tmp_path / "sampled.dcd").stat().st_size > 0


def test_ownMonteCarlo(tmp_path):
    output = run("own_monte_carlo.py", folder=tmp_path)
    start, end = map(float, re.findall(r"the ends are (\S+) nm apart", output))
    assert start == pytest.approx(1.02, abs=0.01) and end == pytest.approx(3.0, abs=0.8)
    assert re.search(r"^20000 trials, \d+ clashed, \d+ accepted$", output, re.MULTILINE)
    assert int(re.search(r"clashes now: (\d+)", output)[1]) <= 1  # there is one at the start
    assert f"\n{output}" in (DOCS / "own-monte-carlo.md").read_text(encoding="utf-8")


def test_validateTrajectory(tmp_path):
    output = run("validate_trajectory.py", folder=tmp_path)
    assert "dynamics.pdb: 1.7 clashes in 1,000 atoms\n" in output
    frames = re.search(r"^20 frames: (\S+) to (\S+), median (\S+)$", output, re.MULTILINE)
    least, most, median = map(float, frames.groups())
    assert 0 < least <= median <= most < 60
    # The worst pairs, those of most frames first.
    pairs = re.findall(r"^A:\w+ \d+ and A:\w+ \d+: in (\d+) frames, by up to 0\.(\d+) nm$", output, re.MULTILINE)
    assert len(pairs) == 3 and sorted((int(count) for count, _ in pairs), reverse=True) == [int(n) for n, _ in pairs]
    assert all(40 < int(overlap) < 150 for _, overlap in pairs)
    bonds = re.search(r"^589 bonds: lengths change by (\S+) nm in the mean, (\S+) at most$", output, re.MULTILINE)
    assert 0.003 < float(bonds[1]) < float(bonds[2]) < 0.04


def test_watchClashes(tmp_path):
    output = run("watch_clashes.py", 50, folder=tmp_path)
    text = (tmp_path / "clashes.csv").read_text()
    assert output == text
    assert [line["step"] for line in csv.DictReader(text.splitlines())] == ["50"]


def test_noTypeErrors(tmp_path):
    pytest.importorskip("mypy")
    assert len(EXAMPLES) >= 4
    options = ["--strict", "--follow-imports", "silent", "--config-file", PROJECT / "pyproject.toml"]
    command = [sys.executable, "-m", "mypy", *options, *EXAMPLES]
    environment = {**os.environ, "MYPYPATH": str(Path(openmmchaintree.__file__).parents[1])}
    result = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True)
    assert result.returncode == 0, result.stdout


def test_peptideMoves(tmp_path):
    """A short run that notices only gross errors; people start longer ones."""
    output = run("validation/peptide_moves.py", "--draws", 40, "closed and hops", "local", "all", folder=tmp_path)
    accepted = re.findall(r"^(.+): 40 draws, ([0-9.]+) accepted", output, re.MULTILINE)
    assert [name for name, _ in accepted] == ["closed and hops", "local", "all"]
    assert all(float(share) > 0.05 for _, share in accepted)
    assert float(re.search(r"^least of \d+ p-values: (\S+),", output, re.MULTILINE)[1]) > 1e-6


def test_drawnMoves(tmp_path):
    output = run("validation/drawn_moves.py", "uniform", "--draws", 1000, folder=tmp_path)
    assert re.search(r"^least p-value of 59 densities, times their number: (\S+)$", output, re.MULTILINE)
    shares = [float(share) for share in re.findall(r"accepted ([0-9.]+)", output)]
    assert len(shares) == 59 and all(0.01 < share < 0.9 for share in shares)


def test_loops(tmp_path):
    villin = app.PDBFile(str(Path(app.__file__).parent / "data" / "test.pdb"))
    with open(tmp_path / "villin.pdb", "w") as file:
        app.PDBFile.writeFile(villin.topology, villin.positions, file)
    output = run("validation/loops.py", "growth", "villin.pdb", "22-25", "--seconds", 1, folder=tmp_path)
    assert float(re.search(r"median: ([0-9.]+) closed loops a second", output)[1]) > 1


def test_clashscores(tmp_path):
    """Stand-ins for the programs: the first leaves hydrogens as they are, and the second knows one clash."""
    villin = app.PDBFile(str(Path(app.__file__).parent / "data" / "test.pdb"))
    modeller = app.Modeller(villin.topology, villin.positions)
    modeller.deleteWater()
    with open(tmp_path / "villin.pdb", "w") as file:
        app.PDBFile.writeFile(modeller.topology, modeller.positions, file)
    line = ":1->2:bo: A  10 PHE  CE1 : A  32 LYS  HE2 :-0.46:-0.46:1:1:1:0:0:C:C:1:1:1:0:0"
    for name, command in (("reduce", 'cat "${@: -1}"'), ("probe", f"echo '{line}'")):
        (tmp_path / name).write_text(f"#!/bin/bash\n{command}\n")
        (tmp_path / name).chmod(0o755)
    programs = ("--reduce", tmp_path / "reduce", "--probe", tmp_path / "probe")
    output = run("validation/clashscores.py", *programs, "villin.pdb", folder=tmp_path)
    found = re.search(r"^villin.pdb +1 +(\S+) +\d+ +\S+ +\S+ +100.0$", output, re.MULTILINE)
    assert 1.7 < float(found[1]) < 1.8


def test_turnedVelocities(tmp_path):
    """A short run that shows that moves are made in one Context and in two; people start longer ones."""
    settings = ["AllBonds", "handed"]
    output = run("validation/turned_velocities.py", *settings, "--steps", 600, folder=tmp_path, statuses=(0, 1))
    shares = re.findall(r"^(\w+) .*; accepted ([0-9.]+); \d+ tests", output, re.MULTILINE)
    assert [setting for setting, _ in shares] == settings
    assert all(float(share) > 0.02 for _, share in shares)


def test_slab(tmp_path):
    """Both starts and samplers run; people start longer runs."""
    settings = ["--chains", 4, "--box", 9, 9, 30, "--sequence", "GSYRGFGSGYGG", "--seconds", 1, "--samples", 50]
    output = run("validation/slab.py", *settings, folder=tmp_path)
    runs = re.findall(r"^(\w+, \w+) +dense +([0-9.]+) mM, dilute +([0-9.]+) mM, Rg ([0-9.]+) nm", output, re.MULTILINE)
    assert [name for name, *_ in runs] == ["dense, moves", "dense, dynamics", "dilute, moves", "dilute, dynamics"]
    assert all(0.5 < float(size) < 1.5 for *_, size in runs)
    rows = re.findall(r"^ +[0-9.]+((?: +[0-9.]+){4})$", output, re.MULTILINE)
    profiles = [[float(value) for value in row.split()] for row in rows]
    # The mean concentration: four chains in 2,430 nm³.
    for column in zip(*profiles, strict=True):
        assert sum(column) / len(column) == pytest.approx(4 / 2430 / 0.602214e-3, rel=1e-2)


def test_faunus(tmp_path):
    """All contestants that are here have the same energy: Faunus need not be."""
    output = run("validation/faunus.py", "--trials", 400, "--relaxation", 500, folder=tmp_path)
    rows = re.findall(r"^(\S.*\S) +(-?[0-9.]+) +([0-9.]+) +([0-9.]+)$", output, re.MULTILINE)
    assert [name for name, *_ in rows] in (names := ["native", "OpenMM's CPU platform", "Faunus"], names[:2])
    for _, energy, microseconds, _ in rows:
        assert float(energy) == pytest.approx(float(rows[0][1]), abs=0.05) and float(microseconds) > 0


def test_dynamics(tmp_path):
    """Short runs: atom moves differ little from dynamics, torsions alone differ much; people start longer runs."""
    for seed, method in enumerate(("dynamics", "atoms", "torsions"), start=1):
        settings = [method, f"{method}.npz", "--frames", 40, "--chains", 2, "--seed", seed]
        run("validation/dynamics.py", "sample", "glycine", *settings, folder=tmp_path)
    outputs = [
        run("validation/dynamics.py", "compare", "dynamics.npz", f"{other}.npz", folder=tmp_path, statuses=statuses)
        for other, statuses in (("atoms", (0, 1)), ("torsions", (1,)))
    ]
    for output in outputs:
        assert re.search(r"^GLY 1, 18 x 18 bins .*: total variation 0\.\d+;", output, re.MULTILINE)
        assert re.search(r"^least p-value of 40, times their number: \S+$", output, re.MULTILINE)
    # Differences of the widths of six kinds of bonds and nine kinds of angles, in percent.
    widths = [[float(of) for of in re.findall(r"^  width .* (\S+)$", output, re.MULTILINE)] for output in outputs]
    assert [len(of) for of in widths] == [15, 15]
    assert max(map(abs, widths[0])) < 60 and max(widths[1]) < -40


def test_versusDynamics(tmp_path, monkeypatch):
    """Both methods run and are drawn; people start longer runs."""
    monkeypatch.syspath_prepend(PROJECT / "examples" / "validation")
    from peptide import cutPeptide

    topology, positions = cutPeptide()
    with open(tmp_path / "peptide.pdb", "w") as file:
        app.PDBFile.writeFile(topology, positions * unit.nanometer, file)
    program = "validation/versus_dynamics.py"
    for method in ("moves", "dynamics"):
        run(program, "run", method, "peptide.pdb", f"{method}.npz", "--seconds", 1, folder=tmp_path)
    output = run(program, "draw", "peptide.pdb", "moves.npz", "dynamics.npz", "both.png", folder=tmp_path)
    rows = [line.rsplit(maxsplit=2) for line in output.splitlines()]
    assert len(rows) == 7 and all(float(row[1]) >= 0 and float(row[2]) >= 0 for row in rows)
    assert (tmp_path / "both.png").stat().st_size > 0


def test_folding(tmp_path, monkeypatch):
    """A run from an extended start is extended, and compared with the native structure; people start longer runs."""
    monkeypatch.syspath_prepend(PROJECT / "examples" / "validation")
    from peptide import cutPeptide

    topology, positions = cutPeptide()
    with open(tmp_path / "native.pdb", "w") as file:
        app.PDBFile.writeFile(topology, positions * unit.nanometer, file)

    def fold(*arguments):
        return run("validation/folding.py", *arguments, folder=tmp_path)

    fold("start", "native.pdb", "extended.pdb", "--extended")
    settings = ["extended.pdb", "short", "--forcefield", "amber14-all.xml", "--temperatures", "300:400:2"]
    assert "2 replicas, 8,000 trials of each" in fold("run", *settings, "--trials", 8000, "--frames", 4)
    assert "2 replicas, 16,000 trials of each" in fold("run", *settings, "--trials", 16000)
    output = fold("report", "native.pdb", "short", "--threshold", 0.05, "--picture", "short.png")
    rows = [row.split() for row in re.findall(r"^ *[34]00\.0 .*$", output, re.MULTILINE)]
    assert [row[:2] for row in rows] == [["300.0", "5"], ["400.0", "5"]]
    assert all(0 <= float(row[2]) <= 1 and 0.3 < float(row[6]) < 0.8 for row in rows)
    assert float(rows[0][5]) < float(rows[1][5]) and 0 <= float(rows[0][7]) <= 1
    hours = float(re.search(r"^short: ([0-9.]+) CPU hours, \d+ round trips$", output, re.MULTILINE)[1])
    assert 0 <= hours < 0.1 and (tmp_path / "short.png").stat().st_size > 0
