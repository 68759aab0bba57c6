"""The check by a k-d tree finds the same as a comparison of all pairs, to the bit."""

import tracemalloc

import numpy as np
import pytest
from openmm import unit
from openmmchaintree import StericExclusionForce, createStericExclusionForce
from openmmchaintree.command.allpairs import HardSpheres, compare


def overlapsOfEveryPair(force, positions):
    """Return the pairs, overlaps and tolerances of HardSpheres.overlaps by tables of all pairs, block by block."""
    parameters = [force.getParticleParameters(i) for i in range(force.getNumParticles())]
    radii = np.array([radius.value_in_unit(unit.nanometer) for radius, _ in parameters])
    donors, acceptors = (np.array([bool(role & part) for _, role in parameters]) for part in (1, 2))
    tolerance = force.getOverlapTolerance().value_in_unit(unit.nanometer)
    allowance = force.getHydrogenBondAllowance().value_in_unit(unit.nanometer)
    excluded = {tuple(sorted(force.getExclusionParticles(i))) for i in range(force.getNumExclusions())}
    modelled = np.flatnonzero(radii > 0)
    found = []
    for start in range(0, len(modelled), 256):
        rows, columns = modelled[start : start + 256], modelled[start:]
        squares = sum((positions[rows, None, k] - positions[None, columns, k]) ** 2 for k in range(3))
        overlaps = radii[rows, None] + radii[None, columns] - np.sqrt(squares)
        mayBond = (donors[rows, None] & acceptors[None, columns]) | (acceptors[rows, None] & donors[None, columns])
        tolerances = tolerance + np.where(mayBond, allowance, 0.0)
        row, column = np.nonzero((overlaps > tolerances) & (rows[:, None] < columns[None, :]))
        for first, second, i, j in zip(rows[row].tolist(), columns[column].tolist(), row, column, strict=True):
            if (first, second) not in excluded:
                found.append((first, second, overlaps[i, j], tolerances[i, j]))
    found.sort()
    return [entry[:2] for entry in found], [entry[2] for entry in found], [entry[3] for entry in found]


def assertAgrees(force, positions):
    """Compare with every pair, and return how many were found."""
    found = HardSpheres(force).overlaps(positions)
    pairs, overlaps, tolerances = overlapsOfEveryPair(force, positions)
    assert [tuple(pair) for pair in found.pairs.tolist()] == pairs
    assert found.overlaps.tolist() == overlaps and found.tolerances.tolist() == tolerances
    return len(pairs)


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


@pytest.mark.parametrize("tolerance", [0.0, 0.04, 0.5])
@pytest.mark.parametrize("offset", [0.0, 1e4, -1e7])
def test_sameAsEveryPair(tolerance, offset):
    """Radii, roles and exclusions at random, particles in one place, one that is far larger than the others."""
    random = np.random.default_rng(3)
    force = StericExclusionForce()
    force.setOverlapTolerance(tolerance)
    for radius in [1.0, *random.choice([0.0, 0.05, 0.1, 0.2], 599).tolist()]:
        force.addParticle(radius, int(random.integers(4)))
    positions = random.uniform(0, 2, (600, 3)) + offset
    positions[300:310] = positions[300]
    near = HardSpheres(force).overlaps(positions).pairs
    for pair in near[::3].tolist():
        force.addExclusion(*pair[::-1])
    count = assertAgrees(force, positions)
    assert 20 < count < len(near)


def test_touchingSpheres():
    """The tree must not lose pairs to the rounding of its distances."""
    random = np.random.default_rng(5)
    directions = random.normal(size=(500, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    centres = 10.0 * np.arange(500)[:, None] * np.array([[1.0, 0.7, 0.3]])
    positions = np.concatenate([centres, centres + 0.16 * directions])
    force = StericExclusionForce()
    for _ in positions:
        force.addParticle(0.1)
    assert 50 < assertAgrees(force, positions) < 450


@pytest.mark.parametrize("name", ["villin", "1htb.pdb"])
def test_structureSameAsEveryPair(villin, realStructure, name):
    structure = villin if name == "villin" else realStructure(name)
    force = createStericExclusionForce(structure.topology, structure.positions, torsions=())
    assertAgrees(force, structure.positions)
    squeezed = 0.8 * structure.positions
    assert assertAgrees(force, squeezed) > structure.topology.getNumAtoms() / 2


@pytest.mark.parametrize("count", [0, 1, 2])
def test_fewParticles(count):
    assert HardSpheres(StericExclusionForce()).overlaps(np.zeros((0, 3))).pairs.shape == (0, 2)
    assert spheres(*[0.1] * count).overlaps(np.zeros((count, 3))).pairs.tolist() == [[0, 1]][: count // 2]
    assert spheres(*[0.0] * count).overlaps(np.zeros((count, 3))).pairs.shape == (0, 2)


def test_memoryIsInProportion():
    """A table of all pairs would take fifty gigabytes."""
    side = np.arange(43) * 0.15
    positions = np.stack(np.meshgrid(side, side, side), axis=-1).reshape(-1, 3)
    count = len(positions)
    system = spheres(*[0.1] * count)
    tracemalloc.start()
    found = system.overlaps(positions)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(found.pairs) > 2 * count
    assert peak < 2000 * count


def test_notANumber():
    with pytest.raises(ValueError, match="finite"):
        spheres(0.1, 0.1).overlaps(line(0, float("nan")))


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
