"""The script solvent.py, as a user runs it. No test looks at how long anything takes."""

import numpy as np
import openmm
import pytest
import solvent
from commands import assertRefused
from energy import rows, solventrows
from energy.proteins import REACTION_FIELD, Evaluator, readSampled
from energy.solventgoals import judge
from energy.solventrows import BLOCKS, CUTOFFS, KT, OUTER_TEST, combineOuter, replaceNonbonded
from energy.solventtables import makeTables, outerShare
from energy.tables import combineRuns
from openmmchaintree import OuterStatistics
from racing.report import readCSV


@pytest.fixture
def runHere(runScriptHere):
    """A function that runs the script where no structures lie ready."""
    return lambda *arguments: runScriptHere(solvent.main, *arguments)


def test_everythingQuickly(runHere, tmp_path):
    result = runHere("--quick", "--csv", "a.csv", "--markdown", "a.md", "--picture", "a.png")
    assert result.returncode == 0, result.stdout + result.stderr
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    _, entries = readCSV(tmp_path / "a.csv")
    assert {entry["group"] for entry in entries} == set(solvent.GROUPS)
    for entry in entries:
        assert 0 <= entry["quartile1"] <= entry["microseconds"] <= entry["quartile3"]
        if "energyError" in entry:
            assert entry["energyError"] < 0.05
    standIns = [entry for entry in entries if entry["group"] == "standins"]
    assert [(e["bornCutoff"], e["pairCutoff"], e["block"]) for e in standIns] == [
        (*cutoffs, block) for cutoffs in CUTOFFS for block in BLOCKS
    ]
    for entry in standIns:
        assert entry["outer"]["tests"] == 400 // entry["block"] >= entry["outer"]["kept"]
    (foreign,) = (entry for entry in entries if entry["contestant"] == rows.FOREIGN)
    assert foreign["trials"] == foreign["attempted"] == 10

    tables = (tmp_path / "a.md").read_text(encoding="utf-8").split("\n**")[1:]
    assert len(tables) == 6
    for table in tables:
        lines = [line for line in table.splitlines() if line.startswith("|")]
        assert len(lines) >= 3 and len({line.count("|") for line in lines}) == 1
    assert "OpenMM's Reference platform: reached (" in result.stdout

    result = runHere("--read", "a.csv", "--markdown", "b.md", "--picture", "b.png")
    assert result.returncode == 0
    for kind in ("md", "png"):
        assert (tmp_path / f"a.{kind}").read_bytes() == (tmp_path / f"b.{kind}").read_bytes()


def test_badArguments(runHere, tmp_path):
    assertRefused(runHere("a.pdb"), tmp_path, [], "a.pdb")
    assertRefused(runHere("--rows", "growth"), tmp_path, [], "growth")


def test_anExpressionHasTheEnergyOfANonbondedForce():
    protein = readSampled()
    systems = [protein.makeSystem(REACTION_FIELD, sterics=False) for _ in range(2)]
    replaceNonbonded(systems[1])
    assert not any(isinstance(force, openmm.NonbondedForce) for force in systems[1].getForces())
    expected, found = (Evaluator(system, "Reference").energy(protein.positions) for system in systems)
    assert found == pytest.approx(expected, abs=1e-6)


def test_outerTestsOfTurnsAreCombined():
    differences = np.random.default_rng(1).normal(1.0, 2.0, size=(3, 20))
    parts = [OuterStatistics(20, 5, 0, float(of.mean()), float(of.std(ddof=1))) for of in differences]
    combined = combineOuter(parts)
    assert combined == {"tests": 60, "kept": 15, "deviation": pytest.approx(float(differences.std(ddof=1)))}


def makeEntry(group, contestant, microseconds, **values):
    entry = {"group": group, "chain": "villin", "particles": 582, "method": "GBn2", "moves": "", "asked": 1}
    return {**entry, "contestant": contestant, "microseconds": microseconds, **values}


def makeEntries(microseconds=30.0, kept=90, error=1e-3):
    outer = {"tests": 100, "kept": kept, "deviation": KT}
    stages = {"near pairs": {"computed": 50, "refused": 10}}
    counts = {"attempted": 100, "clashed": 20, "accepted": 0.4, "stages": stages}
    return [
        makeEntry(solventrows.SOLVENT, "ours", microseconds, outer=outer, **counts),
        makeEntry(solventrows.SOLVENT, rows.FOREIGN, 60000.0),
        makeEntry(solventrows.WHOLE, OUTER_TEST, 240.0, energy=-1000.0, energyError=error),
        makeEntry(solventrows.WHOLE, rows.ONE_ENERGY, 60000.0, energy=-1000.0, energyError=0.1),
    ]


def test_goals():
    lines, isWrong = judge(makeEntries())
    assert not isWrong and "NOT REACHED" not in "".join(lines)
    assert "goal: villin, whole trial: 35 µs: reached (30.0)" in lines
    assert "goal: villin, outer tests: up to a sixth of the time: reached (2 %)" in lines
    lines, isWrong = judge(makeEntries(70.0, 70, 7e-3))
    assert not isWrong and len([line for line in lines if "NOT REACHED" in line]) == 4
    assert judge(makeEntries(error=0.2))[1]
    assert judge(makeEntries(error=float("nan")))[1]


def test_countsAreThoseOfAllRuns():
    table = makeTables(makeEntries() + makeEntries(40.0, 70))[0]
    (line,) = table.rows
    assert line[table.columns.index("ours")] == "35.0 (30.0–40.0)"
    assert line[table.columns.index("outer tests kept")] == "0.80 of 200"
    assert line[table.columns.index("difference, kT")] == "1.00"
    combined = combineRuns(makeEntries())
    assert outerShare(combined[0], combined[1:]) == pytest.approx(240 / (400 * 30))
