"""Two levels sample exp(-U/kT) with any stand-in: molecules with two torsions in generalized Born solvent, against
quadrature of OpenMM's energies.

An alanine dipeptide is smaller than the default cutoffs, so its stand-ins neglect only the rounding of radii; absurd
stand-ins are the sensitive test, at a temperature at which chains still move. In a chain of charged beads radii
change more. Chains begin at different places; Student's test compares means of their blocks with quadrature. Exact
samples need not mix: after any number of trials from each of many, they must be distributed as before. A test fails
if one of its p-values is below SIGNIFICANCE divided by their number (Bonferroni); seeds are fixed. long_two_levels.py
does the same with larger molecules.
"""

import numpy as np
import openmm
import pytest
from openmmchaintree import (
    StericExclusionForce,
    TorsionDensity,
    TorsionMonteCarloIntegrator,
    createStericExclusionForce,
    ramachandranDensities,
)
from realsystems import Reference, Run, isSteric, makeSystem, readSystem
from scipy.stats import t
from test_native_energies import ABSOLUTE
from test_native_sampling import DIPEPTIDE_MOVES, SIGNIFICANCE

GAS_CONSTANT = 8.31446261815324e-3  # kJ/mol/K
POINTS = 60  # of the grid of energies, a torsion
CELLS = 6  # of the histogram, a torsion
RARE = 0.02  # cells of less than that are taken together
BLOCKS = 25  # a chain
STEPS = 100  # a block
TRIALS = 40  # a step
PAIRS_OF_CHAINS = 6
DRAWS = 2000
LOWER = 1  # kJ/mol, that an energy may be below all of the grid
SOFT_CONSTANT = 3e3  # kJ/mol/nm^2: so soft that spheres that overlap are sampled
MEDIUM, HOT = 400, 900  # K

# Cutoffs of Born sums and pairs (nm), the width of the grid, and the trials to an outer test.
DEFAULT = (0.55, 0.8, 0.1, 40)
ABSURD = {"cutoffs": (0.3, 0.3, 0.05, 2), "grid": (0.8, 0.9, 1, 5), "both": (0.3, 0.3, 0.5, 2)}
SHORT = (0.4, 0.45, 0.05, 2)
CONSTANT = (0.05, 2, 0.05, 200)  # radii do not depend on the state


class Scene:
    """A System of two torsions, and what quadrature says of it."""

    def __init__(self, system, positions, temperature, starts, isSoft=False):
        self.system, self.temperature, self.isSoft = system, temperature, isSoft
        run, reference = Run(system, positions), Reference(system)
        self.starts = []
        for start in starts:
            run.integrator.setTorsionAngles(run.context, start)
            assert isSoft or not run.clashes
            self.starts.append(run.positions)
        angles = (np.arange(POINTS) + 0.5) / POINTS * 2 * np.pi - np.pi
        points, energies = [], []
        for point in np.array(np.meshgrid(angles, angles)).reshape(2, -1).T:
            run.integrator.setTorsionAngles(run.context, point)
            softEnergy = run.softEnergy
            if isSoft or softEnergy == 0:
                points.append(point)
                energies.append(reference.energy(run.positions) + softEnergy)
        self.lowest = min(energies)
        energies = np.array(energies) - self.lowest
        weights = np.exp(-energies / (GAS_CONSTANT * temperature))
        means = weights @ functionsOf(np.array(points), energies) / weights.sum()
        self.isRare = (np.arange(len(means)) < CELLS**2) & (means < RARE)
        self.expected = self.pooled(means[None])[0]

    def pooled(self, values):
        """Return functions of samples, with cells that are rare taken together."""
        return np.hstack([values[:, ~self.isRare], values[:, self.isRare].sum(axis=1, keepdims=True)])

    def sample(self, standIn, constantsOf="start", renewals=False, seed=1, drawn=None):
        """Return means of blocks of both chains: (chains, blocks, functions). The torsions are turned, or drawn from a
        density.
        """
        blocks = []
        for chain, start in enumerate(self.starts):
            moves = () if drawn is not None else DIPEPTIDE_MOVES
            run = Run(self.system, start, seed=seed + chain, temperature=self.temperature, moves=moves)
            integrator, context = run.integrator, run.context
            if drawn is not None:
                integrator.addDrawnMove(1, [(0, 1)], drawn)
            if self.isSoft:
                integrator.setStericMode(TorsionMonteCarloIntegrator.Soft)
            *cutoffs, width, trialsPerTest = standIn
            integrator.setStandInCutoffs(*cutoffs)
            integrator.setStandInGridWidth(width)
            integrator.setTrialsPerOuterTest(trialsPerTest)
            integrator.setTrialsPerStep(max(TRIALS, trialsPerTest))
            if constantsOf == "other start":
                context.setPositions(self.starts[1 - chain])
                integrator.renewStandIns(context)
                context.setPositions(start)
            integrator.step(50)
            angles, energies = [], []
            for _ in range(BLOCKS * STEPS):
                integrator.step(1)
                angles.append(run.torsions)
                energies.append(run.energy)
                if renewals:
                    integrator.renewStandIns(context)
            values = self.pooled(functionsOf(np.array(angles), np.array(energies) - self.lowest))
            blocks.append(values.reshape(BLOCKS, STEPS, -1).mean(axis=1))
            self.tests = integrator.getOuterStatistics()
        return np.array(blocks)

    def draw(self, count, seed=1):
        """Return independent draws from exp(-U/kT): torsions, one row a draw, by rejection of uniform ones."""
        run, generator, draws = Run(self.system, self.starts[0]), np.random.default_rng(seed), []
        while len(draws) < count:
            angles = generator.uniform(-np.pi, np.pi, 2)
            run.integrator.setTorsionAngles(run.context, angles)
            excess = run.energy - self.lowest + LOWER
            assert excess > 0
            if generator.random() < np.exp(-excess / (GAS_CONSTANT * self.temperature)) and not run.clashes:
                draws.append(angles)
        return np.array(draws)

    def follow(self, draws, standIn, trials, temperature, seed=1):
        """Return torsions after `trials` trials from each draw, by one stand-in."""
        run = Run(self.system, self.starts[0], seed=seed, temperature=temperature, moves=DIPEPTIDE_MOVES)
        integrator, ends = run.integrator, []
        *cutoffs, width, trialsPerTest = standIn
        integrator.setStandInCutoffs(*cutoffs)
        integrator.setStandInGridWidth(width)
        integrator.setTrialsPerOuterTest(trialsPerTest)
        integrator.setTrialsPerStep(trials)
        integrator.renewStandIns(run.context)
        for angles in draws:
            integrator.setTorsionAngles(run.context, angles)
            integrator.step(1)
            ends.append(run.torsions)
        self.tests = integrator.getOuterStatistics()
        return np.array(ends)

    def valuesOf(self, angles):
        """Return what is compared of states with these torsions."""
        run, energies = Run(self.system, self.starts[0]), []
        for point in angles:
            run.integrator.setTorsionAngles(run.context, point)
            energies.append(run.energy)
        return self.pooled(functionsOf(np.array(angles), np.array(energies) - self.lowest))

    def pValue(self, blocks):
        """Return the lowest of Student's test of the means of blocks, times their number."""
        rows = blocks.reshape(-1, blocks.shape[2])
        errors = rows.std(axis=0, ddof=1) / np.sqrt(len(rows)) + 1e-300
        values = 2 * t.sf(np.abs(rows.mean(axis=0) - self.expected) / errors, len(rows) - 1)
        return min(1, values.min() * len(values))


def pValueOfChanges(before, after):
    """Return the lowest of Student's test of the means of changes, one row a draw, times their number."""
    changes = after - before
    errors = changes.std(axis=0, ddof=1) / np.sqrt(len(changes)) + 1e-300
    values = 2 * t.sf(np.abs(changes.mean(axis=0)) / errors, len(changes) - 1)
    return min(1, values.min() * len(values))


def functionsOf(angles, energies):
    """Return what is compared of samples: cells that they are in, and U."""
    cells = np.minimum((angles + np.pi) / (2 * np.pi) * CELLS, CELLS - 1).astype(int)
    return np.column_stack([np.eye(CELLS**2)[cells[:, 0] * CELLS + cells[:, 1]], energies])


def makeDipeptide(temperature, isSoft=False):
    system, _, positions = makeSystem("alanine dipeptide", solvent="implicit/gbn2.xml", torsions=("phi", "psi"))
    for force in system.getForces():
        if isSteric(force) and isSoft:
            StericExclusionForce.cast(force).setForceConstant(SOFT_CONSTANT)
    return Scene(system, positions, temperature, ((-2.4, 2.6), (-1.2, -0.6)), isSoft)


def makeBeads():
    """Return a chain of five beads, of which the ends are charged and bury others."""
    positions = np.array([[0, 0.4, 0], [0, 0, 0], [0.3, 0, 0], [0.3, 0.3, 0], [0.7, 0.3, 0.1]])
    charges, radii = (0.6, -0.4, 0.4, -0.4, 0.6), (0.35, 0.15, 0.15, 0.15, 0.35)
    system, steric = openmm.System(), StericExclusionForce()
    pairs, born = openmm.NonbondedForce(), openmm.GBSAOBCForce()
    for i in range(5):
        system.addParticle(10)
        steric.addParticle(0.01)
        pairs.addParticle(charges[i], 0.25, 0.5)
        born.addParticle(charges[i], radii[i], 0.8)
    for i in range(4):
        steric.addBond(i, i + 1)
        pairs.addException(i, i + 1, 0, 1, 0)
    for i in range(3):
        pairs.addException(i, i + 2, 0, 1, 0)
    steric.createExclusionsFromBonds(3)
    for i in range(2):
        steric.addTorsion(i, i + 1, i + 2, i + 3)
    for force in (steric, pairs, born):
        system.addForce(force)
    steric.setForceGroup(1)
    return Scene(system, positions, MEDIUM, ((3, 1), (-1, 2)))


@pytest.fixture(scope="module")
def hot():
    return makeDipeptide(HOT)


@pytest.fixture(scope="module")
def medium():
    return makeDipeptide(MEDIUM)


@pytest.fixture(scope="module")
def beads():
    return makeBeads()


def test_soft_spheres():
    scene = makeDipeptide(MEDIUM, isSoft=True)
    assert scene.pValue(scene.sample(DEFAULT)) > SIGNIFICANCE


@pytest.mark.parametrize("standIn", [DEFAULT, SHORT], ids=["default", "short cutoffs"])
def test_hard_spheres(medium, standIn):
    assert medium.pValue(medium.sample(standIn)) > SIGNIFICANCE


def test_drawn_moves(medium):
    """By phi and psi of alanines in loops, and by a density that is high where hardly any of them are."""
    topology, _ = readSystem("alanine dipeptide", None)
    (loops,) = ramachandranDensities(topology, createStericExclusionForce(topology)).density
    elsewhere = TorsionDensity.fromRotamers([1, 1], [[-2, 0.5], [1, 2]], [[0.5, 0.5], [0.5, 0.5]], 0.5)
    for density in (loops, elsewhere):
        assert medium.pValue(medium.sample(DEFAULT, drawn=density)) > SIGNIFICANCE


@pytest.mark.parametrize(
    "name, constantsOf",
    [("cutoffs", "start"), ("cutoffs", "other start"), ("grid", "start"), ("both", "other start")],
)
def test_absurd_stand_in(hot, name, constantsOf):
    """Such stand-ins hold chains fast, so that blocks of a chain depend on each other; chains do not."""
    chains = [hot.sample(ABSURD[name], constantsOf, seed=2 * n + 1) for n in range(PAIRS_OF_CHAINS)]
    assert hot.pValue(np.concatenate(chains).mean(axis=1, keepdims=True)) > SIGNIFICANCE
    assert hot.tests.accepted < hot.tests.attempted
    assert hot.tests.standardDeviation > 0.2 * GAS_CONSTANT * HOT


@pytest.mark.parametrize("constantsOf", ["start", "other start"])
def test_constant_radii(beads, constantsOf):
    assert beads.pValue(beads.sample(CONSTANT, constantsOf)) > SIGNIFICANCE


@pytest.fixture(scope="module")
def draws(medium):
    """Draws at a temperature at which absurd stand-ins hold chains fast, and what is compared of them."""
    angles = medium.draw(DRAWS)
    values = medium.valuesOf(angles)
    assert medium.pValue(values[None]) > SIGNIFICANCE
    return angles, values


@pytest.mark.parametrize("name", ABSURD)
def test_draws_stay_draws(medium, draws, name):
    """Whether chains mix or not."""
    ends = medium.follow(draws[0], ABSURD[name], TRIALS, MEDIUM)
    values = medium.valuesOf(ends)
    assert medium.pValue(values[None]) > SIGNIFICANCE
    assert pValueOfChanges(draws[1], values) > SIGNIFICANCE
    assert medium.tests.accepted < medium.tests.attempted
    assert np.mean(np.abs(ends - draws[0]).max(axis=1) > 1e-6) > 0.5  # have moved


def test_draws_of_another_temperature_are_noticed(medium, draws):
    values = medium.valuesOf(medium.follow(draws[0], ABSURD["grid"], TRIALS, 1.2 * MEDIUM))
    assert pValueOfChanges(draws[1], values) < SIGNIFICANCE


def test_constants_renewed_in_mid_run_are_noticed(beads):
    assert beads.pValue(beads.sample(CONSTANT, renewals=True)) < SIGNIFICANCE


@pytest.mark.parametrize("name", ["villin", "bpti_h"])
def test_energy_of_a_protein_after_many_outer_tests(name):
    """Some of which keep their trials, and some of which do not."""
    system, _, positions = makeSystem(name, solvent="implicit/gbn2.xml")
    run = Run(system, positions, moves=((1, 0.3, 1), (1, 0.05, 1)))
    run.integrator.setStandInCutoffs(0.6, 0.7)
    run.integrator.setTrialsPerOuterTest(5)
    run.run(10000)
    run.integrator.setTrialsPerOuterTest(40)
    run.integrator.resetMoveStatistics()
    run.run(10000)
    tests = run.integrator.getOuterStatistics()
    assert min(tests.accepted, tests.attempted - tests.accepted) > 10
    assert run.energy == pytest.approx(Reference(system).energy(run.positions), abs=ABSOLUTE)
