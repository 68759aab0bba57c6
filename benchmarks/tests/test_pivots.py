"""The benchmark pivots.py. No test looks at how long anything takes."""

import numpy as np
import pivots
import pytest


def test_everythingQuickly(runQuickly):
    _, entries, tables = runQuickly(pivots.main, "--trials", 400, picture=False)
    assert len(entries) == 5 and all(0 < entry["accepted"] <= 1 for entry in entries)
    assert len(tables) == 1


@pytest.mark.parametrize("count", [27, 300])
def test_compactWalks(count):
    walk = pivots.compactWalk(count, 0.4, np.random.default_rng(1))
    assert np.linalg.norm(np.diff(walk, axis=0), axis=1) == pytest.approx(0.4)
    assert len({tuple(site) for site in np.rint(walk / 0.4).astype(int)}) == count
    assert walk.max() < 0.4 * (int(np.ceil(count ** (1 / 3) - 1e-9)) - 0.5)


def test_chains():
    x = pivots.stairs(50, 0.4)
    distances = np.linalg.norm(x[:, None] - x, axis=2) + np.eye(50)
    assert np.linalg.norm(np.diff(x, axis=0), axis=1) == pytest.approx(0.4)
    assert distances.min() > 0.39
    force = pivots.makeForce(50, 0.1)
    assert force.getNumBallJoints() == 49 and force.getNumExclusions() == 49
