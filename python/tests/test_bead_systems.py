"""Systems of CALVADOS, COCOMO and Mpipi are sampled as their authors build them; bonds and rigid parts of beads."""

import warnings

import numpy as np
import openmm
import pytest
from beadmodels import MODELS, calvados2
from openmm import app, unit
from openmmchaintree import (
    TorsionMonteCarloIntegrator,
    addDefaultMoves,
    createStericExclusionForce,
    createTopology,
    setBondLengths,
)
from scenes import makeSystem, positionsOf

_BOX = (20.0, 20.0, 20.0)
_DOMAIN = range(9, 27)


def create(topology, positions=None, **options):
    """Return the force and the texts of warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        force = createStericExclusionForce(topology, positions, **options)
    return force, [str(warning.message) for warning in caught]


def jointsOf(force):
    return [tuple(force.getBallJointParticles(i)) for i in range(force.getNumBallJoints())]


def bondsOf(force):
    return {tuple(sorted(force.getBondParticles(i))) for i in range(force.getNumBonds())}


def sample(topology, system, positions, steps):
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(1)
    moves = addDefaultMoves(integrator, topology, system)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(positions)
    integrator.step(steps)
    return integrator, context, moves


# ---- The Systems as they are ----


@pytest.mark.parametrize("domain", [(), _DOMAIN], ids=["disordered", "domain"])
@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("name", MODELS)
def test_aSystemAsItsAuthorsBuildIt(name, count, domain):
    topology, system, positions = MODELS[name](count, _BOX, domain)
    length = len(positions) // count
    force, texts = create(topology, positions, system=system)
    rigid = [text for text in texts if text.startswith("rigid parts of chains of beads")]
    assert len(texts) == 1 + bool(domain) and len(rigid) == bool(domain)
    joints = [(i, i + 1) for i in range(length - 1) if not {i, i + 1} <= set(domain)]
    assert jointsOf(force) == [(c * length + i, c * length + j) for c in range(count) for i, j in joints]
    assert force.getNumTorsions() == 0 and force.usesPeriodicBoundaryConditions()
    radii = [force.getParticleParameters(i)[0] for i in range(force.getNumParticles())]
    assert max(radii) == 0 * unit.nanometer

    energies = [force for force in system.getForces() if not isinstance(force, openmm.CMMotionRemover)]
    system.addForce(force)
    integrator, context, moves = sample(topology, system, positions, 30)
    kinds = {integrator.getMoveType(one.move) for one in moves}
    assert kinds >= {integrator.PivotMove, integrator.CrankshaftMove}
    assert (integrator.RigidBodyMove in kinds) is (count > 1)
    assert all(integrator.getMoveStatistics(one.move).accepted > 0 for one in moves)
    plan = integrator.getEnergyPlan(context)
    assert integrator.getStericModeInContext(context) == integrator.Off
    assert all(plan[i].kind in ("native", "constant") for i in range(len(energies)))
    ofOpenMM = context.getState(energy=True).getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)
    assert integrator.getPotentialEnergy(context) == pytest.approx(ofOpenMM, rel=1e-6, abs=5e-3)
    # Bonds and domains keep their shape, and everything else has moved.
    sampled = positionsOf(context)
    for first in range(0, count * length, length):
        chain, start = sampled[first : first + length], positions[first : first + length]
        bonds = [np.linalg.norm(np.diff(x, axis=0), axis=1) for x in (chain, start)]
        assert bonds[0] == pytest.approx(bonds[1], abs=1e-9)
        core = [np.linalg.norm(x[_DOMAIN.start] - x[_DOMAIN.stop - 1]) for x in (chain, start)]
        assert (core[0] == pytest.approx(core[1], abs=1e-9)) == bool(domain)
        assert np.linalg.norm(chain[0] - chain[-1]) != pytest.approx(np.linalg.norm(start[0] - start[-1]), abs=1e-3)


def test_aTopologyWithoutElements():
    topology, system, positions = calvados2(2, _BOX)
    bare = createTopology(system, elements=[None] * system.getNumParticles())
    forces = [create(one, system=system)[0] for one in (topology, bare)]
    assert jointsOf(forces[0]) == jointsOf(forces[1]) and bondsOf(forces[0]) == bondsOf(forces[1])
    given, texts = create(topology, system=system, torsions=(), ballJoints="bonds", radii=np.full(len(positions), 0.2))
    assert jointsOf(given) == jointsOf(forces[0])
    assert given.getParticleParameters(0)[0] == 0.2 * unit.nanometer


def test_torsionsOfBeadsOnRequest():
    topology, system, positions = calvados2(1, _BOX)
    force, _ = create(topology, positions, system=system, torsions="all")
    assert force.getNumTorsions() == len(positions) - 3
    assert jointsOf(force) == [(0, 1), (len(positions) - 2, len(positions) - 1)]
    force, _ = create(topology, positions, system=system, torsions="all", ballJoints=())
    assert force.getNumBallJoints() == 0


# ---- The length of bonds ----


def test_bondLength():
    topology, system, positions = calvados2(2, _BOX)
    force, (text,) = create(topology, positions, system=system)
    assert text.startswith(f"{len(positions) - 2} harmonic bonds of beads stay as long as they are in the positions")
    moved = setBondLengths(force, positions * 10 * unit.angstrom, bondLength=3.825 * unit.angstrom)
    half = len(positions) // 2
    for chain, start in ((moved[:half], positions[:half]), (moved[half:], positions[half:])):
        steps, before = np.diff(chain, axis=0), np.diff(start, axis=0)
        assert np.linalg.norm(steps, axis=1) == pytest.approx(0.3825, abs=1e-12)
        assert steps == pytest.approx(before * 0.3825 / np.linalg.norm(before, axis=1, keepdims=True), abs=1e-12)
        assert np.array_equal(chain[0], start[0])
    lengths = np.linspace(0.3, 0.4, force.getNumBallJoints())
    moved = setBondLengths(force, positions, lengths)
    first, second = np.array(jointsOf(force)).T
    assert np.linalg.norm(moved[second] - moved[first], axis=1) == pytest.approx(lengths, abs=1e-12)
    system.addForce(force)
    integrator, context, _ = sample(topology, system, moved, 5)
    sampled = positionsOf(context)
    assert np.linalg.norm(sampled[second] - sampled[first], axis=1) == pytest.approx(lengths, abs=1e-9)


def test_bondLengthsAroundADomainAndAFixedBead():
    topology, system, positions = MODELS["CALVADOS 3"](1, _BOX, _DOMAIN)
    system.setParticleMass(30, 0)
    force, _ = create(topology, positions, system=system)
    assert (30, 29) in jointsOf(force) and (30, 31) in jointsOf(force) and (9, 8) in jointsOf(force)
    moved = setBondLengths(force, positions, 0.4)
    first, second = np.array(jointsOf(force)).T
    assert np.linalg.norm(moved[second] - moved[first], axis=1) == pytest.approx(0.4, abs=1e-12)
    assert np.array_equal(moved[30], positions[30])
    shifts = (moved - positions)[_DOMAIN.start : _DOMAIN.stop]
    assert shifts == pytest.approx(np.tile(shifts[0], (len(shifts), 1)), abs=1e-12)
    system.addForce(force)
    integrator, context, _ = sample(topology, system, moved, 5)
    assert np.array_equal(positionsOf(context)[30], positions[30])


def test_badBondLengths():
    topology, system, positions = calvados2(1, _BOX)
    force, _ = create(topology, positions, system=system)
    with pytest.raises(ValueError, match="bondLength must be above 0"):
        setBondLengths(force, positions, 0)
    with pytest.raises(ValueError, match=r"a number or have the shape \(37,\), not \(3,\)"):
        setBondLengths(force, positions, [0.3, 0.4, 0.5])
    with pytest.raises(TypeError, match="bondLength"):
        setBondLengths(force, positions, 3 * unit.radian)
    positions[4] = positions[3]
    with pytest.raises(ValueError, match="particles 3 and 4 are bonded, but at one place"):
        setBondLengths(force, positions, 0.38)


# ---- What is a bead, and which bonds hold ----


def glycines(count, *forces, chains=1):
    """Return the Topology and the System of beads without bonds, with energies of pairs and other forces."""
    topology, system = app.Topology(), openmm.System()
    pairs = openmm.CustomNonbondedForce("0.3/r^9")
    for _ in range(chains):
        chain = topology.addChain()
        for _ in range(count):
            topology.addAtom("CA", app.element.carbon, topology.addResidue("GLY", chain))
            system.addParticle(57)
            pairs.addParticle([])
    for force in (pairs, *forces):
        system.addForce(force)
    return topology, system


def springs(*pairs, length=0.38):
    force = openmm.HarmonicBondForce()
    for first, second in pairs:
        force.addBond(first, second, length, 8000)
    return force


def custom(expression, *pairs):
    force = openmm.CustomBondForce(expression)
    for first, second in pairs:
        force.addBond(first, second)
    return force


def along(count):
    return [(i, i + 1) for i in range(count - 1)]


def test_aSystemWithoutBonds():
    topology, system = glycines(5)
    force, texts = create(topology, system=system)
    assert force.getNumBonds() == force.getNumBallJoints() == 0
    assert texts == [
        "there is no torsion of a protein, because the model has only Cα atoms",
        "neither the Topology nor the System has a bond, so that each particle is a molecule, which only rigid-body "
        "moves can move",
    ]


@pytest.mark.parametrize("kind", ["constraints", "custom", "custom without positions", "custom without elements"])
def test_otherKindsOfBonds(kind):
    topology, system = glycines(6)
    if kind == "constraints":
        for first, second in along(6):
            system.addConstraint(first, second, 0.38)
    else:
        system.addForce(custom("-0.5*30*2.25*log(1-(r/1.5)^2)", *along(6)))
    positions = np.arange(6)[:, np.newaxis] * [0.5, 0, 0]
    if kind == "custom without elements":
        topology = createTopology(system, [None] * 6)
    if "without" in kind:
        positions = None
    force, texts = create(topology, positions, system=system)
    assert jointsOf(force) == along(6) and texts == []


def test_aRingIsLeftToItsEnergy():
    topology, system = glycines(8, springs(*along(8), (0, 7)))
    angles = 2 * np.pi * np.arange(8) / 8
    positions = 0.5 * np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    force, texts = create(topology, positions, system=system)
    assert jointsOf(force) == along(8) and bondsOf(force) == set(along(8))
    assert any(text.startswith("bonds of beads that close rings or join chains, which only") for text in texts)
    system.addForce(force)
    integrator, context, _ = sample(topology, system, positions, 200)
    lengths = np.linalg.norm(positionsOf(context)[[7, 1]] - positionsOf(context)[0], axis=1)
    assert lengths[1] == pytest.approx(0.3827, abs=1e-3) and 0 < abs(lengths[0] - 0.3827) < 0.2


def test_aRestraintBetweenChainsIsNoBond():
    pairs = [*along(4), *((i + 4, j + 4) for i, j in along(4))]
    topology, system = glycines(4, springs(*pairs), springs((1, 6), length=1.5), chains=2)
    force, texts = create(topology, system=system)
    assert bondsOf(force) == set(pairs) and jointsOf(force) == pairs
    assert texts[-1].startswith("bonds of beads that close rings or join chains") and "(1): " in texts[-1]
    integrator = TorsionMonteCarloIntegrator(300)
    system.addForce(force)
    addDefaultMoves(integrator, topology, system)
    assert integrator.RigidBodyMove in [integrator.getMoveType(i) for i in range(integrator.getNumMoves())]


@pytest.mark.parametrize(
    ("expression", "isRigid"),
    [
        ("0.5*kenm*(r-r0)^2", True),
        ("100 * (r - 0.5)^2;", True),
        ("(r-r0)^2*k/2; k=3", False),
        ("k*step(r-r0)*(r-r0)^2", False),
        ("k*(5*(r0/r)^12-6*(r0/r)^10)", False),
    ],
)
def test_elasticNetworksOfCustomBondForces(expression, isRigid):
    near = [(i, j) for i in range(2, 8) for j in range(i + 2, 8)]
    network = custom(expression, *near)
    topology, system = glycines(10, springs(*along(10)), network)
    force, texts = create(topology, system=system)
    rigid = [
        text for text in texts if text.startswith("rigid parts of chains of beads, each an elastic network of bonds")
    ]
    assert bool(rigid) is isRigid
    assert jointsOf(force) == ([(0, 1), (1, 2), (7, 8), (8, 9)] if isRigid else along(10))


def test_springsBetweenSecondNeighborsMakeNothingRigid():
    """Such as springs in place of angles: chains of triangles can bend."""
    topology, system = glycines(9, springs(*along(9)), springs(*((i, i + 2) for i in range(7)), length=0.6))
    force, texts = create(topology, system=system)
    assert jointsOf(force) == along(9) and "(7): " in texts[-1]


def test_fixedBeadsAreOnePart():
    topology, system = glycines(9, springs(*along(9)))
    for particle in (2, 6):
        system.setParticleMass(particle, 0)
    force, texts = create(topology, system=system)
    assert jointsOf(force) == [(1, 0), (2, 1), (2, 3), (3, 4), (4, 5), (6, 7), (7, 8)]
    assert bondsOf(force) == set(along(9)) - {(5, 6)} and "(1): " in texts[-1]


def test_atomsWithRestraintsAreNoBeads(villin):
    system = makeSystem(villin)
    pairs = openmm.NonbondedForce()
    for _ in range(system.getNumParticles()):
        pairs.addParticle(0, 0.1, 0)
    system.addForce(pairs)
    plain, _ = create(villin.topology, villin.positions, system=system)
    alphas = [atom.index for atom in villin.topology.atoms() if atom.name == "CA"]
    near = [(i, j) for i in alphas for j in alphas if i < j]
    system.addForce(springs(*near[:200], length=0.9))
    force, texts = create(villin.topology, villin.positions, system=system)
    assert bondsOf(force) == bondsOf(plain) and force.getNumTorsions() == plain.getNumTorsions()
    assert force.getNumBallJoints() == 0 and texts == []


def test_theNoteNamesAllRigidParts():
    topology, system, positions = MODELS["CALVADOS 3"](3, _BOX, _DOMAIN)
    with pytest.warns(UserWarning, match="harmonic bonds") as caught:
        createStericExclusionForce(topology, positions, system=system)
    note = caught[-1].message.note
    length = len(positions) // 3
    assert note.items == [
        f"{c + 1}:TRP {c * length + 10} CA … {c + 1}:PHE {c * length + 27} CA, 18 beads" for c in range(3)
    ]
