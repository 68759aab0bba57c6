"""The script pivots.py, as a user runs it. No test looks at how long anything takes."""

import numpy as np
import pivots
import pytest
from beads.chains import compactWalk, makeForce, stairs
from beads.disordered import RESIDUES, makeSequence
from beads.rows import DISORDERED, LANGEVIN, PIVOTS
from beads.tables import makeTables
from racing.report import readCSV


def test_everythingQuickly(runScriptHere, tmp_path):
    result = runScriptHere(pivots.main, "--quick", "--trials", "400", "--csv", "a.csv", "--markdown", "a.md")
    assert result.returncode == 0, result.stdout + result.stderr
    _, entries = readCSV(tmp_path / "a.csv")
    ofPivots = [entry for entry in entries if entry["group"] == PIVOTS]
    assert len(ofPivots) == 5
    for entry in ofPivots:
        assert 0 < entry["accepted"] <= 1 and entry["microseconds"] > 0 and entry["trials"] == 400
    ofProtein = [entry for entry in entries if entry["group"] == DISORDERED]
    assert [entry["contestant"] for entry in ofProtein] == ["pivots", "pivots and small ones", LANGEVIN]
    for entry in ofProtein:
        assert 0.5 < entry["rg"] < 3
    tables = makeTables(entries)
    assert [len(table.rows) for table in tables] == [5, 3]
    assert (tmp_path / "a.md").read_text(encoding="utf-8").count("\n| random compact |") == 3


@pytest.mark.parametrize("count", [27, 300])
def test_compactWalks(count):
    walk = compactWalk(count, 0.4, np.random.default_rng(1))
    assert np.linalg.norm(np.diff(walk, axis=0), axis=1) == pytest.approx(0.4)
    assert len({tuple(site) for site in np.rint(walk / 0.4).astype(int)}) == count
    assert walk.max() < 0.4 * (int(np.ceil(count ** (1 / 3) - 1e-9)) - 0.5)


def test_chains():
    x = stairs(50, 0.4)
    distances = np.linalg.norm(x[:, None] - x, axis=2) + np.eye(50)
    assert np.linalg.norm(np.diff(x, axis=0), axis=1) == pytest.approx(0.4)
    assert distances.min() > 0.39
    force = makeForce(50, 0.1)
    assert force.getNumBallJoints() == 49 and force.getNumExclusions() == 49


def test_sequence():
    sequence = makeSequence(300)
    assert sequence == makeSequence(300) and set(sequence) <= set(RESIDUES)
