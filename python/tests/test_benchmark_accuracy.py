"""The command openmm-chaintree benchmark --accuracy, as a user runs it. No test looks at how long anything takes."""

import copy
import csv
import json
from pathlib import Path

import numpy as np
import openmmchaintree
import pytest
from commands import assertRefused
from openmmchaintree.command.accuracy import plan, softforce
from openmmchaintree.command.accuracy.goals import growth, judgeGoals
from openmmchaintree.command.accuracy.softforce import exactForces, makeCrowd, measureForces
from openmmchaintree.command.benchmarking import platforms
from openmmchaintree.command.benchmarking.course import Course
from openmmchaintree.command.benchmarking.program import Program, ProgramError
from scenes import GLYCINES, writePDB

pytestmark = pytest.mark.skipif(
    not (Path(openmmchaintree._openmmchaintree.__file__).parent / "bin").exists(),
    reason="built with CHAINTREE_BUILD_BENCHMARKS=OFF",
)

LITTLE = ("--accuracy", "--quick", "--trials", 10000, "--seconds", 0.3)


@pytest.fixture
def runHere(runCommandHere):
    """A function that runs the command."""
    return lambda *arguments: runCommandHere("benchmark", *arguments)


def readSummary(path):
    return json.loads(path.read_text(encoding="utf-8"))


def ofGroup(summary, group):
    return [entry for entry in summary["entries"] if entry["group"] == group]


# ---- Runs ----


def test_everythingQuickly(runHere, tmp_path):
    files = ["--json", "a.json", "--csv", "a.csv", "--markdown", "a.md", "--picture", "a.png"]
    result = runHere(*LITTLE, *files)
    assert result.returncode == 0, result.stdout + result.stderr
    assert "wrote a.json, a.csv, a.md, a.png" in result.stdout
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    summary = readSummary(tmp_path / "a.json")
    assert summary["turns"] == 10000 and summary["failures"] == [] and not summary["interrupted"]
    assert "portable" in summary["instructionSets"]
    for group in ("drift", "touch", "force"):
        assert {entry["particles"] for entry in ofGroup(summary, group)} == {100, 1000}
    for entry in summary["entries"]:
        first, third = entry["quartiles"]
        assert 0 < first <= entry["microseconds"] <= third

    with open(tmp_path / "a.csv", newline="", encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    assert [float(line["microseconds"]) for line in lines] == [entry["microseconds"] for entry in summary["entries"]]
    assert float(lines[0]["ofTurns.bonds.rms"]) == summary["entries"][0]["ofTurns"]["bonds"]["rms"]
    tables = (tmp_path / "a.md").read_text(encoding="utf-8").split("\n**")[1:]
    assert len(tables) == 5
    for table in tables:
        rows = [line for line in table.splitlines() if line.startswith("|")]
        assert len(rows) >= 3 and len({row.count("|") for row in rows}) == 1
        assert f"\n{table[: table.index('*')]}" in result.stdout

    checkPositions(ofGroup(summary, "drift"))
    checkVerdicts(ofGroup(summary, "touch"))
    assert [goal["reached"] for goal in summary["goals"][:2]] == [True, None]
    assert summary["goals"][3]["reached"] in (True, None)


def checkPositions(entries):
    """Weak paths are seen to be weak, good ones to be good."""
    errors = {}
    for entry in entries:
        relative = entry["ofTurns"]["distances"]["largest"] / entry["size"]
        errors.setdefault(entry["contestant"], []).append(relative)
        assert ("ofAngles" in entry) == entry["contestant"].startswith(("ours", "shortcuts", "sequential"))
    for contestant in ("ours-portable", "shortcuts", "sequential", "multiplied", "cartesian"):
        assert 0 < max(errors[contestant]) < 1e-10
    assert max(errors["ours-portable"]) < 1e-13 < max(errors["cartesian"])
    for contestant in ("shortcuts-single", "sequential-single", "multiplied-single", "cartesian-single"):
        assert 1e-7 < max(errors[contestant]) < 0.1


def checkVerdicts(entries):
    wrong = {}
    for entry in entries:
        assert entry["clashes"] > 0 and entry["gaps"] > 0
        missed, invented = wrong.get(entry["contestant"], (0, 0))
        wrong[entry["contestant"]] = missed + entry["missed"], invented + entry["invented"]
    right = [
        "ours-portable",
        "ours-tree",
        "ours-boxes",
        "ours-clearances",
        "ours-whole",
        "volumes-double",
        "volumes-single-margin",
    ]
    assert all(wrong[contestant] == (0, 0) for contestant in right)
    assert wrong["volumes-single"][0] > 0 == wrong["volumes-single"][1]
    assert min(wrong["all-single"]) > 0 and min(wrong["lazygrid-single"]) > 0


def test_sameSeedSameErrors(runHere, tmp_path):
    def errors(name, *arguments):
        runHere("--accuracy", "--quick", "--trials", 1000, "--seconds", 60, "--json", name, *arguments)
        drift = ofGroup(readSummary(tmp_path / name), "drift")
        return [(entry["bits"], entry["ofTurns"]) for entry in drift]

    assert errors("a.json") == errors("b.json", "--seed", 1) != errors("c.json", "--seed", 2)


def test_markdownOnStandardOutput(runHere):
    result = runHere(*LITTLE, "--markdown", "-")
    assert result.returncode == 0
    assert "\n| ours, portable | " in result.stdout and "wrote" not in result.stdout
    assert "\ngoal: no missed and no invented clash beyond 1e-09 nm" in result.stdout


def test_whatIsNotThereIsSkipped(runHere, monkeypatch):
    monkeypatch.setattr(platforms, "_platformNames", lambda: ["Reference"])
    result = runHere(*LITTLE)
    assert result.returncode == 0
    assert "skipped: forces on the CPU platform: OpenMM has no CPU platform here" in result.stdout

    monkeypatch.setattr(plan, "whyNoReference", lambda: "numbers are too short")
    result = runHere(*LITTLE)
    assert result.returncode == 0
    assert "skipped: forces: numbers are too short" in result.stdout and "CustomNonbondedForce" not in result.stdout


# ---- What goes wrong is reported ----


def test_aMissedClashIsReported(runHere, monkeypatch):
    honest = Program.race

    def race(self, options, variables=None):
        lines = honest(self, options, variables)
        for line in lines:
            if line["contestant"] == "ours-boxes":
                line["missed"] = 1
        return lines

    monkeypatch.setattr(Program, "race", race)
    result = runHere(*LITTLE)
    assert result.returncode == 1
    assert "on any path of the engine: NOT REACHED (2 of " in result.stdout


def test_aFailingRowDoesNotEndTheOthers(runHere, tmp_path, monkeypatch):
    def fail(self, options, variables=None):
        raise ProgramError("not enough memory")

    monkeypatch.setattr(Program, "race", fail)
    result = runHere(*LITTLE, "--json", "a.json", "--picture", "a.png")
    assert result.returncode == 1
    assert "FAILED: drift: 1,000 spheres: not enough memory" in result.stdout
    assert {entry["group"] for entry in readSummary(tmp_path / "a.json")["entries"]} == {"force"}
    assert not (tmp_path / "a.png").exists()
    assert "goal: the same bits with every instruction set: not measured" in result.stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["a.pdb"], "--accuracy goes without structures"),
        (["--rows", "chains"], "--accuracy goes without --rows"),
        (["--contestants", "ours"], "--accuracy goes without --contestants"),
        (["--picture", "a.doc"], "a.doc: a picture's name ends in .png, .pdf, .svg"),
    ],
)
def test_badArguments(runHere, tmp_path, arguments, words):
    writePDB(tmp_path / "a.pdb", GLYCINES)
    assertRefused(runHere("--accuracy", *arguments), tmp_path, ["a.pdb"], words)


# ---- Goals ----


def makeDrift(turns, error, bits="a", contestant="ours-portable"):
    """An entry of a chain whose size is 100 nm, where errors are parts of that."""
    distances = {"largest": 100 * error, "rms": 50 * error}
    return {
        "group": "drift",
        "contestant": contestant,
        "particles": 100,
        "turns": turns,
        "size": 100.0,
        "bits": bits,
        "ofTurns": {"distances": {"largest": 1000 * error, "rms": 500 * error}},
        "ofAngles": {"distances": distances},
    }


PATHS = ("ours-portable", "sequential")
STEADY = [makeDrift(turns, 1e-15, contestant="sequential") for turns in (10**3, 10**4, 10**6)]


def makeTouch(missed=0, invented=0, contestant="ours-portable"):
    counts = {"clashes": 10, "missed": missed, "gaps": 10, "invented": invented}
    return {"group": "touch", "contestant": contestant, "particles": 100, **counts}


@pytest.mark.parametrize(
    ("entries", "reached"),
    [
        ([], [None] * 4),
        ([makeTouch()], [True, None, None, None]),
        ([makeTouch(), makeTouch(missed=1)], [False, None, None, None]),
        ([makeTouch(invented=1)], [False, None, None, None]),
        ([makeTouch(), makeTouch(missed=1, contestant="volumes-single")], [True, None, None, None]),
        ([makeDrift(1000, 1e-15), makeDrift(10**6, 1e-15), *STEADY], [None, True, True, None]),
        ([makeDrift(1000, 1e-15), makeDrift(10**4, 1e-15), *STEADY], [None, None, None, None]),
        ([makeDrift(10**6, 2e-12)], [None, False, None, None]),
        ([makeDrift(10**4, 1e-15), makeDrift(10**6, 1e-14), *STEADY], [None, True, False, None]),
        # Errors of both have grown: that is how the chain lies.
        (
            [makeDrift(n, error, contestant=path) for path in PATHS for n, error in ((10**4, 1e-15), (10**6, 1e-14))],
            [None, True, True, None],
        ),
        ([makeDrift(10**4, 1e-15), makeDrift(10**6, 1e-11, contestant="cartesian"), *STEADY], [None, None, None, None]),
        ([makeDrift(1000, 1e-15), makeDrift(1000, 1e-15, contestant="ours-avx2")], [None, None, None, True]),
        ([makeDrift(1000, 1e-15), makeDrift(1000, 1e-15, "b", "ours-avx2")], [None, None, None, False]),
    ],
)
def test_goals(entries, reached):
    assert [goal["reached"] for goal in judgeGoals(entries)] == reached


def test_growth():
    for power in (0.0, 0.5, 1.0):
        assert growth({n: 1e-15 * n**power for n in (10**3, 10**4, 10**5, 10**6)}) == pytest.approx(power, abs=1e-9)


# ---- The soft force ----


@pytest.mark.parametrize("size", [1, 7, 300])
def test_crowd(size):
    crowd = makeCrowd(size, seed=1)
    distances = np.linalg.norm(crowd.positions[:, None] - crowd.positions[None], axis=2)
    overlaps = np.triu(crowd.radii[:, None] + crowd.radii[None] - distances, k=1)
    overlapping = set(zip(*map(list, np.nonzero(overlaps > 0)), strict=True))
    listed = [(min(pair), max(pair)) for pair in crowd.pairs.tolist()]
    assert len(set(listed)) == len(listed)
    assert overlapping <= set(listed)
    assert size < 300 or len(overlapping) > 300


def test_exactForcesAreTheGradient():
    crowd = makeCrowd(60, seed=2)
    energy, forces = exactForces(crowd)
    assert energy > 0
    step = 1e-6
    for i in (0, 17, 59):
        for k in range(3):
            ends = []
            for sign in (1, -1):
                moved = copy.copy(crowd.positions)
                moved[i, k] += sign * step
                ends.append(exactForces(crowd._replace(positions=moved))[0])
            assert float(-(ends[0] - ends[1]) / (2 * step)) == pytest.approx(float(forces[i, k]), rel=1e-4, abs=1e-2)


def test_errorsOfForces(tmp_path):
    entries = {entry["contestant"]: entry for entry in measureForces(500, Course(None, 1, 1, 1.0, tmp_path))}
    for name in ("ours, Reference", "CustomNonbondedForce, Reference"):
        assert entries[name]["energyError"] < 1e-13
        assert 0 < entries[name]["forceError"]["rms"] <= entries[name]["forceError"]["largest"] < 1e-13
    if platforms.whyNot(platforms.CPU) is None:
        assert entries["ours, CPU"]["forceError"]["largest"] < 1e-13
        # It computes in single precision.
        assert 1e-8 < entries["CustomNonbondedForce, CPU"]["forceError"]["rms"] < 1e-4


def test_aWrongForceIsSeen(tmp_path, monkeypatch):
    honest = softforce.exactForces

    def wrong(crowd):
        energy, forces = honest(crowd)
        return 1.5 * energy, -forces

    monkeypatch.setattr(softforce, "exactForces", wrong)
    for entry in measureForces(50, Course(None, 1, 1, 1.0, tmp_path)):
        assert entry["energyError"] == pytest.approx(1 / 3)
        assert entry["forceError"]["rms"] == pytest.approx(2)
