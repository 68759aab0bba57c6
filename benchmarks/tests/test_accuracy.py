"""The script accuracy.py, as a user runs it. No test looks at how long anything takes."""

import copy

import accuracy
import numpy as np
import pytest
from commands import assertRefused
from precision import softforce
from precision.goals import judgeGoals
from precision.softforce import exactForces, makeCrowd, measureForces
from racing import platforms
from racing.program import Program, ProgramError
from racing.report import readCSV
from racing.table import exponent

LITTLE = ("--quick",)


@pytest.fixture
def runHere(runScriptHere):
    """A function that runs the script."""
    return lambda *arguments: runScriptHere(accuracy.main, *arguments)


def ofGroup(entries, group):
    return [entry for entry in entries if entry["group"] == group]


# ---- Runs ----


def test_everythingQuickly(runHere, tmp_path):
    result = runHere(*LITTLE, "--csv", "a.csv", "--markdown", "a.md", "--picture", "a.png")
    assert result.returncode == 0, result.stdout + result.stderr
    assert "wrote a.csv, a.md, a.png" in result.stdout
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    machine, entries = readCSV(tmp_path / "a.csv")
    assert "portable" in machine["instruction sets of the engine"]
    for group in ("drift", "touch", "force"):
        assert {entry["particles"] for entry in ofGroup(entries, group)} == {100, 1000}
    for entry in entries:
        assert 0 < entry["quartile1"] <= entry["microseconds"] <= entry["quartile3"]
    # However long it takes, each path goes as far as it was asked to.
    paths = {}
    for entry in ofGroup(entries, "drift"):
        paths.setdefault((entry["contestant"], entry["particles"]), []).append(entry["turns"])
    assert all(turns == [1000, 10000] for turns in paths.values())

    tables = (tmp_path / "a.md").read_text(encoding="utf-8").split("\n**")[1:]
    assert len(tables) == 5
    for table in tables:
        rows = [line for line in table.splitlines() if line.startswith("|")]
        assert len(rows) >= 3 and len({row.count("|") for row in rows}) == 1
        assert f"\n{table[: table.index('*')]}" in result.stdout

    checkPositions(ofGroup(entries, "drift"))
    checkVerdicts(ofGroup(entries, "touch"))
    goals = [line for line in result.stdout.splitlines() if line.startswith("goal: ")]
    assert ": reached (" in goals[0] and ": not measured (" in goals[1] and "NOT REACHED" not in goals[3]

    result = runHere("--read", "a.csv", "--markdown", "b.md", "--picture", "b.png")
    assert result.returncode == 0
    for kind in ("md", "png"):
        assert (tmp_path / f"a.{kind}").read_bytes() == (tmp_path / f"b.{kind}").read_bytes()


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
        runHere("--quick", "--trials", 1000, "--csv", name, *arguments)
        drift = ofGroup(readCSV(tmp_path / name)[1], "drift")
        return [(entry["bits"], entry["ofTurns"]) for entry in drift]

    assert errors("a.csv") == errors("b.csv", "--seed", 1) != errors("c.csv", "--seed", 2)


def test_markdownOnStandardOutput(runHere):
    result = runHere(*LITTLE, "--markdown", "-")
    assert result.returncode == 0
    assert "\n| ours, portable | " in result.stdout and "wrote" not in result.stdout
    assert "\n- goal: no missed and no invented clash beyond 1e-09 nm" in result.stdout


def test_whatIsNotThereIsSkipped(runHere, monkeypatch):
    monkeypatch.setattr(platforms, "_platformNames", lambda: ["Reference"])
    result = runHere(*LITTLE)
    assert result.returncode == 0
    assert "skipped: forces on the CPU platform: OpenMM has no CPU platform here" in result.stdout

    monkeypatch.setattr(accuracy, "whyNoReference", lambda: "numbers are too short")
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
    result = runHere(*LITTLE, "--csv", "a.csv", "--picture", "a.png")
    assert result.returncode == 1
    assert "FAILED: drift: 1,000 spheres: not enough memory" in result.stdout
    assert {entry["group"] for entry in readCSV(tmp_path / "a.csv")[1]} == {"force"}
    assert not (tmp_path / "a.png").exists()
    assert "goal: the same bits with every instruction set: not measured" in result.stdout


def test_badArguments(runHere, tmp_path):
    assertRefused(runHere("a.pdb"), tmp_path, [], "a.pdb")
    assertRefused(runHere("--picture", "a.doc"), tmp_path, [], "a.doc: a picture's name ends in .png, .pdf, .svg")


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
        assert exponent({n: 1e-15 * n**power for n in (10**3, 10**4, 10**5, 10**6)}) == pytest.approx(power, abs=1e-9)


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


def test_errorsOfForces():
    entries = {entry["contestant"]: entry for entry in measureForces(500, 1)}
    for name in ("ours, Reference", "CustomNonbondedForce, Reference"):
        assert entries[name]["energyError"] < 1e-13
        assert 0 < entries[name]["forceError"]["rms"] <= entries[name]["forceError"]["largest"] < 1e-13
    if platforms.whyNot(platforms.CPU) is None:
        assert entries["ours, CPU"]["forceError"]["largest"] < 1e-13
        # It computes in single precision.
        assert 1e-8 < entries["CustomNonbondedForce, CPU"]["forceError"]["rms"] < 1e-4


def test_aWrongForceIsSeen(monkeypatch):
    honest = softforce.exactForces

    def wrong(crowd):
        energy, forces = honest(crowd)
        return 1.5 * energy, -forces

    monkeypatch.setattr(softforce, "exactForces", wrong)
    for entry in measureForces(50, 1):
        assert entry["energyError"] == pytest.approx(1 / 3)
        assert entry["forceError"]["rms"] == pytest.approx(2)
