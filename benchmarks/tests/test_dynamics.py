"""The script dynamics.py, as a user runs it. No test looks at how long anything takes."""

import dynamics
import numpy as np
import pytest
from commands import assertRefused
from energy.dynamicsrows import LANGEVIN, Pair
from energy.dynamicstables import makeTables
from energy.proteins import IMPLICIT_SOLVENT, SIDE_CHAINS, Evaluator, positionsOf, readSampled
from racing.races import OURS
from racing.report import readCSV


@pytest.fixture
def runHere(runScriptHere):
    """A function that runs the script where no structures lie ready."""
    return lambda *arguments: runScriptHere(dynamics.main, *arguments)


def test_everythingQuickly(runHere, tmp_path):
    result = runHere("--quick", "--csv", "a.csv", "--markdown", "a.md", "--picture", "a.png")
    assert result.returncode == 0, result.stdout + result.stderr
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    _, entries = readCSV(tmp_path / "a.csv")
    assert [(entry["contestant"], entry["turn"]) for entry in entries] == [
        (name, turn) for turn in range(5) for name in (OURS, LANGEVIN)
    ]
    for name in (OURS, LANGEVIN):
        ofOne = [entry for entry in entries if entry["contestant"] == name]
        for before, after in zip(ofOne, ofOne[1:], strict=False):
            assert before["seconds"] < after["seconds"] and before["trials"] < after["trials"]
            assert before["turned"] <= after["turned"] <= 1
        assert ofOne[0]["rmsd"] < 1e-3 < ofOne[-1]["rmsd"]
    # Both begin in the same place, and the energies of that are of the same parts.
    assert entries[0]["energy"] == pytest.approx(entries[1]["energy"], abs=0.1)
    assert entries[0]["rg"] == entries[1]["rg"]

    lines = [line for line in (tmp_path / "a.md").read_text(encoding="utf-8").splitlines() if line.startswith("|")]
    assert len(lines) == 4 and len({line.count("|") for line in lines}) == 1
    assert f"| {entries[-2]['trials']:,} trials |" in lines[2]
    assert f"| {0.004 * entries[-1]['trials']:.3g} ps |" in lines[3]

    result = runHere("--read", "a.csv", "--markdown", "b.md", "--picture", "b.png")
    assert result.returncode == 0
    for kind in ("md", "png"):
        assert (tmp_path / f"a.{kind}").read_bytes() == (tmp_path / f"b.{kind}").read_bytes()
    assertRefused(runHere("--quick", "--csv", "a.csv"), tmp_path, ["a.csv", "a.md", "a.png", "b.md", "b.png"], "a.csv")


def test_badArguments(runHere, tmp_path):
    assertRefused(runHere("a.pdb"), tmp_path, [], "a.pdb")
    assertRefused(runHere("--minutes", "0"), tmp_path, [], "--minutes")


def test_whatIsSaidOfAStateIsTrueOfIt():
    pair = Pair(readSampled, 1)
    pair.begin(1)
    start, ours = pair.protein.positions, pair.runs[OURS]
    before = ours.describe()
    ours.advance(0.05)
    said, positions = ours.describe(), positionsOf(ours._simulation.context)

    # Bonds and angles stay as they are, so U changes by as much as what is said.
    evaluator = Evaluator(pair.protein.makeSystem(IMPLICIT_SOLVENT, sterics=False), "Reference")
    change = evaluator.energy(positions) - evaluator.energy(start)
    assert said["energy"] - before["energy"] == pytest.approx(change, abs=0.02)

    carbons = [atom.index for atom in pair.protein.topology.atoms() if atom.name == "CA"]
    first, second = (of[carbons] - of[carbons].mean(axis=0) for of in (start, positions))
    left, _, right = np.linalg.svd(first.T @ second)
    turn = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
    expected = np.sqrt(np.mean(np.sum((first @ turn - second) ** 2, axis=1)))
    assert said["rmsd"] == pytest.approx(expected, abs=1e-4)
    assert said["rg"] == pytest.approx(np.sqrt(np.var(positions, axis=0).sum()), rel=1e-4)


def test_sideChainsThatHaveTurnedAreNotForgotten():
    pair = Pair(readSampled, 1)
    pair.begin(1)
    run = pair.runs[OURS]
    integrator, context = run._simulation.integrator, run._simulation.context
    sideChains, start = pair.protein.torsionsOf(SIDE_CHAINS), integrator.getTorsionAngles(context)
    for turn, expected in ((0.9, 0), (2.0, 1), (0.0, 1), (2 * np.pi, 1)):  # the limit is 60°
        angles = start.copy()
        angles[sideChains[0]] += turn
        integrator.setTorsionAngles(context, angles)
        assert run.describe()["turned"] == pytest.approx(expected / len(sideChains))


def makeEntry(turn, energy):
    values = {"chain": "villin", "contestant": LANGEVIN, "microseconds": 5.0, "seconds": 60.0 * turn, "trials": turn}
    return {"group": "dynamics", **values, "turn": turn, "energy": energy, "rmsd": 0.1, "rg": 1.0, "turned": 0.25}


def test_meansAreOfTheSecondHalf():
    (table,) = makeTables([makeEntry(turn, energy) for turn, energy in enumerate((900.0, 800.0, 1.0, 3.0))])
    (line,) = table.rows
    assert line[table.columns.index("U but bonds and angles, kJ/mol")] == "2 (1)"
    assert line[table.columns.index("processor time, minutes")] == "3.00"
    assert makeTables([{**makeEntry(0, 1.0), "group": "solvent"}]) == []
