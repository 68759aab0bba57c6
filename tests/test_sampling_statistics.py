"""TorsionMonteCarloIntegrator samples the right distribution: histograms against quadrature, by chi-squared tests.

Samples are enough trials apart to be independent, which is checked. A test fails if its p-value is below SIGNIFICANCE;
seeds are fixed, so it fails always or never. Samplers with planted errors show that these tests can fail.
"""

import numpy as np
import openmm
import pytest
from openmm import unit
from openmmchaintree import StericExclusionForce, TorsionMonteCarloIntegrator
from scipy.stats import chisquare

SIGNIFICANCE = 1e-4
SAMPLES = 20000

SPACING = 0.3  # nm, from bead to bead
DIAMETER = 0.99 * SPACING
TORSIONS = [(0, 1, 2, 3), (1, 2, 3, 4)]

TEMPERATURE = 300
KT = (unit.MOLAR_GAS_CONSTANT_R * TEMPERATURE * unit.kelvin).value_in_unit(unit.kilojoule_per_mole)


# ---- Statistics ----


def pValue(samples, edges, probabilities):
    """Return the p-value of samples (n, d), given the probabilities of the cells of a histogram with these edges."""
    observed = np.histogramdd(samples, edges)[0].ravel()
    expected = np.ravel(probabilities) / np.sum(probabilities) * len(samples)
    if observed.sum() < len(samples) or np.any(observed[expected == 0] > 0):
        return 0.0  # there are samples where there can be none
    # The statistic has its distribution only where some samples are expected, so the emptiest cells are made one.
    order = np.argsort(expected)
    observed, expected = observed[order], expected[order]
    pooled = max(np.searchsorted(expected, 10), np.searchsorted(np.cumsum(expected), 10) + 1)
    observed, expected = (np.append(values[pooled:], values[:pooled].sum()) for values in (observed, expected))
    return chisquare(observed, expected).pvalue


def assertIndependent(series):
    """Check that numbers (n, k), one row a sample, have no correlation with those of the next sample."""
    deviations = series - series.mean(axis=0)
    correlations = (deviations[1:] * deviations[:-1]).mean(axis=0) / deviations.var(axis=0)
    assert np.abs(correlations).max() < 4.5 / np.sqrt(len(series))


# ---- A chain of five hard beads ----


def angleBetween(normal1, axis, normal2):
    sine = np.einsum("ij,ij->i", np.cross(normal1, normal2), axis) / np.linalg.norm(axis, axis=1)
    return np.arctan2(sine, np.einsum("ij,ij->i", normal1, normal2))


def torsionAngles(frames):
    """Return the IUPAC dihedrals of frames (n, 5, 3) of the chain: (n, 2)."""
    bonds = np.diff(frames, axis=1)
    normals = np.cross(bonds[:, :-1], bonds[:, 1:])
    return np.stack([angleBetween(normals[:, i], bonds[:, i + 1], normals[:, i + 1]) for i in range(2)], axis=1)


def endDistance(phi1, phi2):
    """Return the distance from the first bead to the last.

    It alone decides: beads three bonds apart are at least SPACING apart, those with fewer bonds between are excluded.
    """
    # The second bead is the origin, the third is up, the first in the direction of x.
    cos1, sin1, cos2, sin2 = np.cos(phi1), np.sin(phi1), np.cos(phi2), np.sin(phi2)
    end = np.stack([cos1 - sin1 * sin2, sin1 + cos1 * sin2, 1 - cos2 + 0 * phi1], axis=-1)
    return SPACING * np.linalg.norm(end - [1, 0, 0], axis=-1)


def torsionEnergy(phi1, phi2):
    return 2.5 * (1 + np.cos(2 * phi1 - 1)) + 1.5 * (1 + np.cos(3 * phi2))


def addTorsionEnergy(system):
    force = openmm.PeriodicTorsionForce()
    force.addTorsion(*TORSIONS[0], 2, 1, 2.5)
    force.addTorsion(*TORSIONS[1], 3, 0, 1.5)
    system.addForce(force)


CELLS, POINTS_A_CELL = 12, 80
EDGES = [np.linspace(-np.pi, np.pi, CELLS + 1)] * 2


def quadrature(energy=None):
    """Return the probabilities of the cells of EDGES by the midpoints of a fine grid, where DIAMETER allows them."""
    count = CELLS * POINTS_A_CELL
    midpoints = (np.arange(count) + 0.5) / count * 2 * np.pi - np.pi
    grid = np.meshgrid(midpoints, midpoints, indexing="ij")
    weights = (endDistance(*grid) >= DIAMETER).astype(float)
    if energy is not None:
        weights *= np.exp(-energy(*grid) / KT)
    cells = weights.reshape(CELLS, POINTS_A_CELL, CELLS, POINTS_A_CELL).sum(axis=(1, 3))
    return cells / cells.sum()


def makeContext(system, integrator, positions):
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(positions)
    return context


def makeChain():
    system = openmm.System()
    force = StericExclusionForce()
    for bead in range(5):
        system.addParticle(1)
        force.addParticle(DIAMETER / 2)
        if bead > 0:
            force.addBond(bead - 1, bead)
    for torsion in TORSIONS:
        force.addTorsion(*torsion)
    force.createExclusionsFromBonds(2)
    force.setOverlapTolerance(0)
    system.addForce(force)
    positions = SPACING * np.array([[1, 0, 0], [0, 0, 0], [0, 0, 1], [-1, 0, 1], [-1, 0, 2]])
    return system, force, positions


def positionsOf(context):
    return context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)


def sample(context, integrator, trialsBetween):
    """Return the positions of SAMPLES samples."""
    integrator.setTrialsPerStep(trialsBetween)
    frames = []
    for _ in range(SAMPLES):
        integrator.step(1)
        frames.append(positionsOf(context))
    return np.array(frames)


def chainAngles(frames):
    """Return the torsions of frames, having checked that nothing else differs between them."""
    angles = torsionAngles(frames)
    bonds = np.diff(frames, axis=1)
    np.testing.assert_allclose(np.linalg.norm(bonds, axis=2), SPACING, rtol=1e-12)
    np.testing.assert_allclose(np.einsum("ijk,ijk->ij", bonds[:, 1:], bonds[:, :-1]), 0, atol=1e-12)
    distances = np.linalg.norm(frames[:, 4] - frames[:, 0], axis=1)
    np.testing.assert_allclose(distances, endDistance(*angles.T), atol=1e-12)
    return angles


def assertChainIndependent(angles):
    assertIndependent(np.hstack([np.cos(angles), np.sin(angles), np.cos(angles @ [[1, 1], [1, -1]])]))


def turn(count, maxAngle):
    """Return what adds a move of torsions to an integrator."""
    return lambda integrator: integrator.addTorsionMove(1, maxAngle, count=count)


@pytest.mark.parametrize(
    "moves, trialsBetween",
    [
        ([turn(1, np.pi)], 20),
        ([turn(2, np.pi)], 10),
        ([turn(1, 0.6)], 400),
        ([turn(2, 0.8)], 120),
        ([turn(1, 2.5), turn(2, 0.3)], 60),
        ([lambda integrator: integrator.addLocalMove(1, 2, 50)], 60),
    ],
    ids=["one torsion, any angle", "both, any angle", "one, small", "both, small", "mixed", "local"],
)
def test_hard_chain_is_uniform_in_the_allowed_region(moves, trialsBetween):
    system, force, positions = makeChain()
    integrator = TorsionMonteCarloIntegrator(TEMPERATURE)
    integrator.setRandomNumberSeed(5)
    for addMove in moves:
        addMove(integrator)
    context = makeContext(system, integrator, positions)
    angles = chainAngles(sample(context, integrator, trialsBetween))
    assertChainIndependent(angles)
    assert endDistance(*angles.T).min() > DIAMETER - 1e-9
    assert pValue(angles, EDGES, quadrature()) > SIGNIFICANCE
    for move in range(len(moves)):
        statistics = integrator.getMoveStatistics(move)
        assert statistics.clashed > 0
        # Without energy, what is rejected is rejected by the ratio of densities.
        assert (statistics.rejectedByEnergy == 0) == (integrator.getMoveType(move) == integrator.TorsionMove)


def test_energy_weighs_the_allowed_region():
    system, force, positions = makeChain()
    addTorsionEnergy(system)
    integrator = TorsionMonteCarloIntegrator(TEMPERATURE)
    integrator.setRandomNumberSeed(6)
    integrator.addTorsionMove(1, np.pi)
    integrator.addTorsionMove(1, 2, count=2)
    context = makeContext(system, integrator, positions)
    angles = chainAngles(sample(context, integrator, 40))
    assertChainIndependent(angles)
    assert pValue(angles, EDGES, quadrature(torsionEnergy)) > SIGNIFICANCE
    assert pValue(angles, EDGES, quadrature()) < SIGNIFICANCE
    assert integrator.getMoveStatistics(0).rejectedByEnergy > 0


# ---- Errors planted in a sampler in Python ----


class Sampler:
    """Samples the hard chain by the force's proposals: a torsion at random, turned by a uniform angle."""

    def __init__(self):
        system, self.force, positions = makeChain()
        self.random = np.random.default_rng(7)
        self.context = makeContext(system, openmm.VerletIntegrator(0.001), positions)
        self.angles = torsionAngles(positions[np.newaxis])[0]

    def maxAngle(self, torsion):
        return np.pi

    def isAccepted(self, isFree):
        return isFree

    def isTrial(self, isAccepted):
        return True

    def sample(self, trialsBetween):
        frames, trials = [], 0
        while len(frames) < SAMPLES:
            torsion = int(self.random.integers(2))
            maxAngle = self.maxAngle(torsion)
            change = self.random.uniform(-maxAngle, maxAngle)
            isAccepted = self.isAccepted(self.force.proposeTorsions(self.context, [torsion], [change]))
            if isAccepted:
                self.force.acceptProposal(self.context)
                self.angles[torsion] += change
            if self.isTrial(isAccepted):
                trials += 1
                if trials % trialsBetween == 0:
                    frames.append(positionsOf(self.context))
        return np.array(frames)


class StepThatDependsOnTheState(Sampler):
    """Turns a torsion by less the nearer it is to trans, without a correction for that."""

    def maxAngle(self, torsion):
        return np.pi * (0.8 + 0.2 * np.cos(self.angles[torsion]))


class ClashesNowAndThen(Sampler):
    """Accepts one clashing trial in a thousand."""

    def isAccepted(self, isFree):
        return isFree or self.random.uniform() < 0.001


class RefusedTrialsThatDoNotCount(Sampler):
    """Takes a refused trial for no trial, so that it never samples the same conformation again."""

    def isTrial(self, isAccepted):
        return isAccepted


@pytest.mark.parametrize(
    "sampler, isCorrect",
    [
        (Sampler, True),
        (StepThatDependsOnTheState, False),
        (ClashesNowAndThen, False),
        (RefusedTrialsThatDoNotCount, False),
    ],
)
def test_planted_errors_are_caught(sampler, isCorrect):
    angles = chainAngles(sampler().sample(12))
    assertChainIndependent(angles)
    assert (pValue(angles, EDGES, quadrature()) > SIGNIFICANCE) == isCorrect


# ---- Rigid bodies ----

BALL, LARGE, SMALL = 0.2, 0.15, 0.1  # nm, radii: a fixed ball, and the ends of a dumbbell
LENGTH = 0.3  # nm, of the dumbbell
STIFFNESS = 30  # kJ/mol/nm^2, of the springs that pull both its ends to the ball's centre


def dumbbellQuadrature(edges):
    """Return the probabilities of cells of the centre's distance from the ball and the cosine of the tilt."""
    pointsACell = 40
    points = [
        np.interp((np.arange((len(edge) - 1) * pointsACell) + 0.5) / pointsACell, np.arange(len(edge)), edge)
        for edge in edges
    ]
    distance, cosine = np.meshgrid(*points, indexing="ij")
    # The law of cosines, for the end towards which the cosine is taken and for the other one.
    squares = distance**2 + LENGTH**2 / 4
    toLarge = np.sqrt(squares + distance * LENGTH * cosine)
    toSmall = np.sqrt(squares - distance * LENGTH * cosine)
    allowed = (toLarge >= BALL + LARGE) & (toSmall >= BALL + SMALL)
    weights = distance**2 * np.exp(-STIFFNESS * distance**2 / KT) * allowed
    rows, columns = (len(edge) - 1 for edge in edges)
    return weights.reshape(rows, pointsACell, columns, pointsACell).sum(axis=(1, 3))


@pytest.mark.parametrize("maxTranslation, maxAngle, trialsBetween", [(0.5, np.pi, 120), (0.2, 1.5, 300)])
def test_rigid_dumbbell_around_a_fixed_ball(maxTranslation, maxAngle, trialsBetween):
    system = openmm.System()
    force = StericExclusionForce()
    for mass, radius in [(0, BALL), (1, LARGE), (1, SMALL)]:
        system.addParticle(mass)
        force.addParticle(radius)
    force.addBond(1, 2)
    force.createExclusionsFromBonds(1)
    force.setOverlapTolerance(0)
    system.addForce(force)
    springs = openmm.CustomExternalForce(f"{STIFFNESS}/2*(x^2+y^2+z^2)")
    springs.addParticle(1)
    springs.addParticle(2)
    system.addForce(springs)
    integrator = TorsionMonteCarloIntegrator(TEMPERATURE)
    integrator.setRandomNumberSeed(8)
    integrator.addRigidBodyMove(1, maxTranslation, maxAngle)
    positions = np.array([[0, 0, 0], [0.4, 0, 0], [0.4, LENGTH, 0]])
    context = makeContext(system, integrator, positions)

    frames = sample(context, integrator, trialsBetween)
    assert np.all(frames[:, 0] == positions[0])
    axis = (frames[:, 1] - frames[:, 2]) / LENGTH
    np.testing.assert_allclose(np.linalg.norm(axis, axis=1), 1, rtol=1e-12)
    centre = frames[:, 1:].mean(axis=1)
    distance = np.linalg.norm(centre, axis=1)
    cosine = np.einsum("ij,ij->i", centre, axis) / distance
    assertIndependent(np.column_stack([centre, axis, distance, cosine]))
    edges = [np.linspace(0.1, 1.7, 41), np.linspace(-1, 1, 21)]
    assert pValue(np.column_stack([distance, cosine]), edges, dumbbellQuadrature(edges)) > SIGNIFICANCE

    # In space, all directions are alike.
    for vectors in (centre / distance[:, np.newaxis], axis):
        for component in vectors.T:
            assert pValue(component[:, np.newaxis], [np.linspace(-1, 1, 21)], np.ones(20)) > SIGNIFICANCE
