"""The benchmark flexible.py. No test looks at how long anything takes."""

import flexible
import numpy as np
import pytest
from flexibletables import CONSTRAINED, RIGID, UNCONSTRAINED, nameOfShare


def test_everythingQuickly(runQuickly):
    _, entries, tables = runQuickly(flexible.main)
    shares = [nameOfShare(share) for share in (0.3, 0.5, 0.7)]
    assert [entry["contestant"] for entry in entries] == [RIGID, *shares, UNCONSTRAINED, CONSTRAINED]
    for entry in entries:
        assert entry["travel"].keys() == {"1"} and 0 < entry["travel"]["1"] < 100
    assert len(tables) == 1


def test_travelOfTurnsAndSteps():
    # A turn and a shift of everything are no travel; a step of one of four atoms leaves 3/4 of its square.
    random = np.random.default_rng(1)
    atoms = random.normal(size=(4, 3))
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    assert flexible.travel([atoms, atoms @ turn.T + 1], 1) < 1e-4
    stepped = atoms + np.array([[0.01, 0, 0], *3 * [[0, 0, 0]]])
    assert 0 < flexible.travel([atoms, stepped], 1) <= 100 * 0.01**2 * 3 / 16 + 1e-4
    steady = [atoms, stepped, atoms, stepped]
    assert flexible.travel(steady, 2) == pytest.approx(0, abs=1e-4)
