"""The all-pairs check must find what it is there to find."""

import numpy as np
import pytest
from openmmchaintree import StericExclusionForce
from openmmchaintree.command.allpairs import HardSpheres, compare


def spheres(*radii, roles=None, exclusions=()):
    force = StericExclusionForce()
    for i, radius in enumerate(radii):
        force.addParticle(radius, roles[i] if roles else force.NoHydrogenBond)
    for pair in exclusions:
        force.addExclusion(*pair)
    return HardSpheres(force)


def line(*x):
    return np.array([[value, 0.0, 0.0] for value in x])


def test_overlapBeyondTolerance():
    found = spheres(0.1, 0.1, 0.1).overlaps(line(0, 0.159, 0.32))
    assert found.pairs.tolist() == [[0, 1]]
    assert found.overlaps == pytest.approx([0.041]) and found.tolerances == pytest.approx([0.04])


def test_hydrogenBondAllowance():
    donor, acceptor = StericExclusionForce.Donor, StericExclusionForce.Acceptor
    positions = line(0, 0.11)
    assert len(spheres(0.1, 0.1, roles=[donor, acceptor]).overlaps(positions).pairs) == 0
    assert len(spheres(0.1, 0.1, roles=[donor, donor]).overlaps(positions).pairs) == 1
    assert len(spheres(0.1, 0.1, roles=[acceptor, acceptor]).overlaps(positions).pairs) == 1
    assert len(spheres(0.1, 0.1, roles=[donor, acceptor]).overlaps(line(0, 0.099)).pairs) == 1


def test_exclusionsAndRadiusZero():
    assert len(spheres(0.1, 0.1, exclusions=[(1, 0)]).overlaps(line(0, 0)).pairs) == 0
    assert len(spheres(0.1, 0.0).overlaps(line(0, 0)).pairs) == 0


def test_manyPairsInBlocks():
    """More particles than fit a block of rows, against a loop over pairs."""
    random = np.random.default_rng(3)
    positions = random.uniform(0, 2, (600, 3))
    found = spheres(*[0.1] * 600).overlaps(positions)
    table = np.linalg.norm(positions[:, None] - positions[None], axis=2)
    expected = [[i, j] for i in range(600) for j in range(i + 1, 600) if 0.2 - table[i, j] > 0.04]
    assert len(expected) > 100
    assert found.pairs.tolist() == expected


def test_comparison():
    system = spheres(0.1, 0.1, 0.1)
    start = system.overlaps(line(0, 0.15, 1.0))  # 0 and 1 clash from the start, by 0.05
    same = compare(start, start)
    assert len(same.tolerated.pairs) == 1 and len(same.beyond.pairs) == 0
    worse = compare(start, system.overlaps(line(0, 0.15 - 1e-6, 1.0)))
    assert len(worse.tolerated.pairs) == 0
    assert worse.beyond.pairs.tolist() == [[0, 1]] and worse.beyondLimits == pytest.approx([0.05])
    better = compare(start, system.overlaps(line(0, 0.155, 1.0)))
    assert better.tolerated.pairs.tolist() == [[0, 1]]
    other = compare(start, system.overlaps(line(0, 0.2, 0.35)))
    assert other.beyond.pairs.tolist() == [[1, 2]] and other.beyondLimits == pytest.approx([0.04])
