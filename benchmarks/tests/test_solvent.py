"""The benchmark solvent.py. No test looks at how long anything takes."""

import numpy as np
import pytest
import solvent
from openmmchaintree import OuterStatistics
from solventtables import BLOCKS, CUTOFFS


def test_everythingQuickly(runQuickly):
    _, entries, tables = runQuickly(solvent.main)
    assert {entry["group"] for entry in entries} == set(solvent.GROUPS)
    for entry in entries:
        assert entry.get("energyError", 0) < 0.05
    standIns = [entry for entry in entries if entry["group"] == "standins"]
    assert [(e["bornCutoff"], e["pairCutoff"], e["block"]) for e in standIns] == [
        (*cutoffs, block) for cutoffs in CUTOFFS for block in BLOCKS
    ]
    for entry in standIns:
        assert entry["outer"]["tests"] == 400 // entry["block"] >= entry["outer"]["kept"]
    assert len(tables) == 4


def test_outerTestsOfTurnsAreCombined():
    differences = np.random.default_rng(1).normal(1.0, 2.0, size=(3, 20))
    parts = [OuterStatistics(20, 5, 0, float(of.mean()), float(of.std(ddof=1))) for of in differences]
    expected = {"tests": 60, "kept": 15, "deviation": pytest.approx(float(differences.std(ddof=1)))}
    assert solvent._combineOuter(parts) == expected
