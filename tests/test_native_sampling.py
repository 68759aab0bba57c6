"""What is sampled with native energies is exp(-U/kT): an alanine dipeptide against quadrature of OpenMM's energies, and
a protein, stage by stage, against evaluation of all Forces by OpenMM.

A test fails if one of its p-values is below SIGNIFICANCE divided by their number (Bonferroni); seeds are fixed. Run as
a program, it compares longer runs of the protein: python test_native_sampling.py [NATIVE TRIALS] [PLAIN TRIALS].
"""

import sys

import numpy as np
import openmm
import pytest
from realsystems import Reference, Run, isSteric, makeSystem, positionsOf
from scipy.stats import chisquare, t

SIGNIFICANCE = 1e-3
TEMPERATURE = 400  # K, so that barriers matter, but are crossed
KT = 8.31446261815324e-3 * TEMPERATURE  # kJ/mol


# ---- Alanine dipeptide ----

CELLS = 12  # a torsion, of the histogram
POINTS = 96  # of the grid of energies
SAMPLES = 4000
TRIALS_BETWEEN = 800


def quadrature(system, positions, steric, points=POINTS):
    """Return the most probable positions of a System whose two torsions are phi and psi, and probabilities of cells of
    these.
    """
    run, reference = Run(system, positions), Reference(system)
    assert len(run.torsions) == 2
    angles = (np.arange(points) + 0.5) / points * 2 * np.pi - np.pi
    energies = np.full((points, points), np.inf)
    for i, phi in enumerate(angles):
        for j, psi in enumerate(angles):
            run.integrator.setTorsionAngles(run.context, [phi, psi])
            if not steric or not run.clashes:
                energies[i, j] = reference.energy(positionsOf(run.context))
    assert np.isinf(energies).any() == steric
    weights = np.exp(-(energies - energies.min()) / KT)
    cells = weights.reshape(CELLS, points // CELLS, CELLS, points // CELLS).sum(axis=(1, 3))
    start = np.unravel_index(energies.argmin(), energies.shape)
    run.integrator.setTorsionAngles(run.context, angles[list(start)])
    return positionsOf(run.context), cells / cells.sum()


@pytest.fixture(scope="module", params=[False, True], ids=["no spheres", "hard spheres"])
def dipeptide(request):
    system, _, positions = makeSystem("alanine dipeptide", steric=request.param, torsions=("phi", "psi"))
    return system, *quadrature(system, positions, request.param)


def pValue(angles, probabilities):
    """Return the p-value of samples (n, 2); cells where little is expected are taken together."""
    edges = np.linspace(-np.pi, np.pi, CELLS + 1)
    observed = np.histogram2d(*angles.T, [edges, edges])[0].ravel()
    expected = probabilities.ravel() * len(angles)
    order = np.argsort(expected)
    observed, expected = observed[order], expected[order]
    pooled = max(np.searchsorted(expected, 10), np.searchsorted(np.cumsum(expected), 10) + 1)
    observed, expected = (np.append(values[pooled:], values[:pooled].sum()) for values in (observed, expected))
    return chisquare(observed, expected).pvalue


# Steps that go far, so that samples are independent, and small ones, of one torsion and of both.
DIPEPTIDE_MOVES = ((3, np.pi, 1), (4, np.pi, 2), (1, 0.5, 1), (1, 0.3, 2))


def sampleDipeptide(system, positions, seed):
    run = Run(system, positions, seed=seed, temperature=TEMPERATURE, moves=DIPEPTIDE_MOVES)
    run.integrator.setTrialsPerStep(TRIALS_BETWEEN)
    angles = []
    for _ in range(SAMPLES):
        run.integrator.step(1)
        angles.append(run.torsions)
    return np.array(angles)


def assertIndependent(angles):
    values = np.hstack([np.cos(angles), np.sin(angles)])
    deviations = values - values.mean(axis=0)
    correlations = (deviations[1:] * deviations[:-1]).mean(axis=0) / deviations.var(axis=0)
    assert np.abs(correlations).max() < 4.5 / np.sqrt(SAMPLES)


def test_dipeptide_is_where_quadrature_says(dipeptide):
    system, positions, probabilities = dipeptide
    angles = sampleDipeptide(system, positions, 11)
    assertIndependent(angles)
    assert pValue(angles, probabilities) > SIGNIFICANCE
    # It would notice energies that are a fifth too low.
    warmer = probabilities**0.8
    assert pValue(angles, warmer / warmer.sum()) < SIGNIFICANCE


def countImages(system, arePeriodic):
    """Let the Forces of a System with a cutoff count images or not."""
    for force in system.getForces():
        if isSteric(force):
            force.setUsesPeriodicBoundaryConditions(arePeriodic)
        elif isinstance(force, openmm.NonbondedForce):
            force.setNonbondedMethod(force.CutoffPeriodic if arePeriodic else force.CutoffNonPeriodic)
            force.setCutoffDistance(0.35)


def test_dipeptide_meets_its_images():
    """In a box as wide as the molecule is long, images exclude most of its conformations."""
    system, _, start = makeSystem("alanine dipeptide", method="reaction field", torsions=("phi", "psi"))
    system.setDefaultPeriodicBoxVectors(*np.diag([0.75, 0.8, 0.72]))
    countImages(system, True)
    positions, probabilities = quadrature(system, start, True, 2 * POINTS)
    angles = sampleDipeptide(system, positions, 11)
    assertIndependent(angles)
    assert pValue(angles, probabilities) > SIGNIFICANCE
    countImages(system, False)
    _, withoutImages = quadrature(system, start, True)
    assert np.abs(probabilities - withoutImages).sum() > 1  # of at most 2
    assert pValue(angles, withoutImages) < SIGNIFICANCE


# ---- A protein ----

TORSIONS = 10
BLOCKS = 20


@pytest.fixture(scope="module")
def villin():
    """A System, positions that a long run has come to, and torsions of side chains."""
    return relaxedVillin()


def relaxedVillin():
    system, _, positions = makeSystem("villin", method="reaction field", torsions=("chi",))
    run = Run(system, positions, temperature=TEMPERATURE, moves=((1, 0.3, 1), (1, np.pi, 1)))
    count = len(run.torsions)
    run.run(300000)
    return system, run.positions, [int(torsion) for torsion in np.linspace(0, count - 1, TORSIONS)]


def sampleProtein(villin, native, trials, samples, seed):
    """Return U and the cosines of torsions of samples: (samples, 1 + TORSIONS). Only these torsions move."""
    system, positions, torsions = villin
    run = Run(
        system,
        positions,
        native=native,
        seed=seed,
        temperature=TEMPERATURE,
        moves=((1, 0.5, 1), (3, np.pi, 1)),
        torsions=torsions,
    )
    run.integrator.setTrialsPerStep(trials // samples)
    rows = []
    for _ in range(samples):
        run.integrator.step(1)
        rows.append([run.energy, *np.cos(run.torsions[torsions])])
    return np.array(rows)


def blockMeans(rows):
    """Return means of blocks, without the first quarter, in which the structure relaxes: (BLOCKS, columns)."""
    rows = rows[len(rows) // 4 :]
    rows = rows[: len(rows) // BLOCKS * BLOCKS]
    return rows.reshape(BLOCKS, -1, rows.shape[1]).mean(axis=1)


def comparison(rows1, rows2):
    """Return the p-values of Welch's test of the means of blocks, one a column."""
    blocks1, blocks2 = blockMeans(rows1), blockMeans(rows2)
    variances = [blocks.var(axis=0, ddof=1) / BLOCKS for blocks in (blocks1, blocks2)]
    total = np.maximum(variances[0] + variances[1], 1e-30)
    freedom = total**2 / ((variances[0] ** 2 + variances[1] ** 2) / (BLOCKS - 1) + 1e-300)
    differences = blocks1.mean(axis=0) - blocks2.mean(axis=0)
    return 2 * t.sf(np.abs(differences) / np.sqrt(total), np.maximum(freedom, 1))


def test_stages_sample_a_protein_as_openmm_does(villin):
    staged = sampleProtein(villin, True, 200000, 2000, 3)
    plain = sampleProtein(villin, False, 4000, 1000, 4)
    assert comparison(staged, plain).min() > SIGNIFICANCE / (1 + TORSIONS)


if __name__ == "__main__":
    trials = [int(argument) for argument in sys.argv[1:]] + [4000000, 100000][len(sys.argv) - 1 :]
    start = relaxedVillin()
    rows = [sampleProtein(start, True, trials[0], 4000, 1), sampleProtein(start, False, trials[1], 1000, 2)]
    found = comparison(*rows)
    for blocks, name in zip(map(blockMeans, rows), ("native", "plain"), strict=True):
        print(name, *(f"{mean:.4f}" for mean in blocks.mean(axis=0)))
    print("p-values", *(f"{value:.3g}" for value in found))
    sys.exit(int(found.min() < SIGNIFICANCE / (1 + TORSIONS)))
