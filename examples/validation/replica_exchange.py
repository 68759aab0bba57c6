"""Do replicas that exchange temperatures sample exp(-U/kT) at each temperature?

    python replica_exchange.py [--rounds 20000] [--seed 1] [--workers 2] [--factor 1]

A capped alanine of the villin headpiece in AMBER14 without solvent. Moves change phi and psi by up to 20 degrees, or by
any angle, which is seldom accepted at 300 K. Four replicas exchange 300, 424, 600 and 849 K after every 5 trials, with
the Coordinator and the Workplace of the command. At each temperature, the distribution of phi and psi and the mean U
are compared with quadrature of OpenMM's energies on a grid of 2 x 96: p-values of block means, of 6 x 6 cells and of U.
Prints the least p-value at each temperature, times their number, the exchange rates and the round trips. Exit status 1
if a p-value is below SIGNIFICANCE divided by their number (Bonferroni).

--factor multiplies the exponent of the exchange, to plant an error: with any factor except 1, p-values must be low.
"""

import argparse
import random
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import openmm
import openmm.app as app
from openmm import unit
from openmmchaintree import StericExclusionForce, TorsionMonteCarloIntegrator, createStericExclusionForce
from openmmchaintree.command.geometry import dihedrals
from openmmchaintree.replicas import ladder
from openmmchaintree.replicas.coordinator import Coordinator, RunPlan, RunState
from openmmchaintree.replicas.ladder import deriveSeeds, geometricLadder
from openmmchaintree.replicas.schedule import Schedule
from openmmchaintree.replicas.segment import Workplace, makeModel
from peptide import cutPeptide
from scipy.stats import ttest_1samp

FORCE_FIELD = "amber14-all.xml"
SIGNIFICANCE = 1e-3
GAS_CONSTANT = 8.31446261815324e-3  # kJ/mol/K
TEMPERATURES = geometricLadder(300, 849, 4)
GRID, CELLS = 96, 6  # per torsion, for quadrature and for histograms
TRIALS = 5  # between exchanges
STEPS = 20, 180  # degrees
BLOCKS = 20


def makeDipeptide():
    """Return the System of ACE-ALA-NME, and positions."""
    random.seed(1)  # adding hydrogens uses it; with several threads, relaxing them is not reproducible
    openmm.Platform.getPlatform("CPU").setPropertyDefaultValue("Threads", "1")
    topology, positions = cutPeptide(7, 1)
    system = app.ForceField(FORCE_FIELD).createSystem(topology)
    system.addForce(createStericExclusionForce(topology, positions, torsions=("phi", "psi")))
    return system, positions


def makeIntegrator():
    integrator = TorsionMonteCarloIntegrator(300)
    for degrees in STEPS:
        integrator.addTorsionMove(1, degrees * unit.degree)
    return integrator


def dihedralsOf(force, positions):
    """Return phi and psi, rad."""
    return dihedrals(positions, np.array([force.getTorsionParticles(i) for i in range(2)]))


def quadrature(system, positions):
    """Return probabilities of cells, a row per temperature; means of U; positions of the lowest U. Excludes clashes."""
    context = openmm.Context(system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatform("Reference"))
    force = stericForce(system)
    others = set(range(32)) - {force.getForceGroup()}
    context.setPositions(positions)
    angles = (np.arange(GRID) + 0.5) / GRID * 2 * np.pi - np.pi
    energies, best = np.full((GRID, GRID), np.inf), None
    for i, phi in enumerate(angles):
        for j, psi in enumerate(angles):
            force.setTorsionAngles(context, [phi, psi])
            if not force.hasClash(context):
                energies[i, j] = energyOf(context, others)
                if energies[i, j] == energies.min():
                    best = context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)
    cells, means = [], []
    for temperature in TEMPERATURES:
        weights = np.exp(-(energies - energies.min()) / (GAS_CONSTANT * temperature))
        weights /= weights.sum()
        cells.append(weights.reshape(CELLS, GRID // CELLS, CELLS, GRID // CELLS).sum(axis=(1, 3)).ravel())
        means.append((weights * np.where(weights > 0, energies, 0)).sum())
    return np.array(cells), np.array(means), best


def energyOf(context, groups):
    return context.getState(energy=True, groups=groups).getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)


def stericForce(system):
    (force,) = [force for force in system.getForces() if StericExclusionForce.isinstance(force)]
    return StericExclusionForce.cast(force)


def sample(system, start, rounds, seed, workers):
    """Return phi, psi and U at each temperature after each round, shape (temperatures, rounds, 3), and the RunState."""
    force = stericForce(system)
    plan = RunPlan(Schedule(rounds * TRIALS, TRIALS, TRIALS), TEMPERATURES, deriveSeeds(seed, len(TEMPERATURES)), seed)
    state = RunState(plan, len(STEPS))
    rows = np.zeros((len(TEMPERATURES), rounds, 3))

    def keep(frame, replica, temperature, kept):
        rows[temperature, frame - 1] = *dihedralsOf(force, kept.positions), kept.energy

    workplace = Workplace(makeModel(system, makeIntegrator(), start, "Reference", {}, True))
    with ThreadPoolExecutor(workers) as pool:
        submit = lambda segment: pool.submit(workplace.run, segment)  # noqa: E731
        Coordinator(plan, state, keep).run(submit, 2 * workers, lambda: False)
    return rows, state


def pValues(rows, cells, mean):
    """Return p-values of U and of cells that are not rare, from block means without the first tenth of the run."""
    rows = rows[len(rows) // 10 :]
    rows = rows[: len(rows) // BLOCKS * BLOCKS]
    places = np.clip(((rows[:, :2] + np.pi) / (2 * np.pi) * CELLS).astype(int), 0, CELLS - 1)
    number = places[:, 0] * CELLS + places[:, 1]
    values = [ttest_1samp(rows[:, 2].reshape(BLOCKS, -1).mean(axis=1), mean).pvalue]
    for cell in np.flatnonzero(cells > 0.01):
        blocks = (number == cell).reshape(BLOCKS, -1).mean(axis=1)
        values.append(ttest_1samp(blocks, cells[cell]).pvalue if blocks.std() > 0 else 0.0)
    return np.array(values)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--rounds", type=int, default=20000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--factor", type=float, default=1.0)
    options = parser.parse_args(arguments)
    honest = ladder.logExchangeRatio
    ladder.logExchangeRatio = lambda *values: options.factor * honest(*values)
    system, positions = makeDipeptide()
    cells, means, start = quadrature(system, positions)
    rows, state = sample(system, start, options.rounds, options.seed, options.workers)
    values = [pValues(*of) for of in zip(rows, cells, means, strict=True)]
    count = sum(map(len, values))
    for temperature, found, of, mean in zip(TEMPERATURES, values, rows, means, strict=True):
        print(
            f"{temperature:.0f} K: U {of[len(of) // 10 :, 2].mean():.3f}, by quadrature {mean:.3f} kJ/mol; "
            f"least p-value of {len(found)}, times {count}: {min(1, found.min() * count):.3g}"
        )
    rates = 100 * state.accepted / np.maximum(1, state.attempted)
    print("exchanged:", ", ".join(f"{rate:.0f} %" for rate in rates), "; round trips:", sum(state.roundTrips))
    return int(min(found.min() for found in values) < SIGNIFICANCE / count)


if __name__ == "__main__":
    sys.exit(main())
