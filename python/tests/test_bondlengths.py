"""The check of bonds must see a bond that was stretched, and none that was only rounded."""

import numpy as np
import pytest
from openmmchaintree import StericExclusionForce
from openmmchaintree.command.geometry import BondLengths


def chain(count):
    force = StericExclusionForce()
    for _ in range(count):
        force.addParticle(0.1)
    for i in range(count - 1):
        force.addBond(i + 1, i)
    return force


def line(*x):
    return np.array([[value, 0.0, 0.0] for value in x])


def test_aStretchedBond():
    bonds = BondLengths(chain(3), line(0, 0.15, 0.3))
    verdict = bonds.compare(line(0, 0.15, 0.3 + 3e-9))
    assert verdict.changed.tolist() == [[2, 1]]
    assert verdict.changes == pytest.approx([3e-9]) and verdict.largestChange == pytest.approx(3e-9)
    shorter = bonds.compare(line(0, 0.1, 0.3 - 3e-9))
    assert shorter.changed.tolist() == [[1, 0], [2, 1]] and shorter.largestChange == pytest.approx(0.05)


def test_whatDoesNotCount():
    bonds = BondLengths(chain(3), line(0, 0.15, 0.3))
    moved = np.array([[1.0, 0.15, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.15 + 0.9e-9]])
    assert bonds.compare(moved).changed.tolist() == []
    assert 0 < bonds.compare(moved).largestChange < 1e-9
    assert BondLengths(chain(1), line(0)).compare(line(1)).largestChange == 0


def test_coordinatesSoLargeThatTheyAreRounded():
    bonds = BondLengths(chain(2), line(0, 0.15))
    far = 2.0**24
    rounded = line(far, far + 0.15)
    assert bonds.compare(rounded).largestChange > 1e-9
    assert bonds.compare(rounded).changed.tolist() == []
    assert bonds.compare(line(far, far + 0.15 + 1e-6)).changed.tolist() == [[1, 0]]


def test_notANumber():
    assert len(BondLengths(chain(2), line(0, 0.15)).compare(line(0, float("nan"))).changed) == 1
