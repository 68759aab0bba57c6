"""Do drawn moves leave the distribution of torsions invariant, and how often are they accepted?

    python drawn_moves.py uniform [--draws 100000] [--seed 1]
    python drawn_moves.py dipeptide [--draws 100000] [--seed 1] [--temperature 300]
    python drawn_moves.py acceptance STRUCTURE [--trials 200000] [--seed 1] [--temperature 300]

uniform: without energy and spheres, independent uniform torsions stay uniform under moves with each density of the
package: rotamers of all amino acids, whole side chains and their ends, and loops. Prints the least p-value of
chi-squared tests of each torsion (24 cells) and each pair of torsions of a set (12 x 12), times their number.

dipeptide: a capped alanine of the villin headpiece in AMBER14 with GBn2, in which only phi and psi are drawn, against
quadrature of OpenMM's energies on a grid of 2 x 144. Prints p-values of block means of 6 x 6 cells, and of U.

acceptance: a folded protein with hydrogens in AMBER14 with GBn2, or the villin headpiece (`villin`), after a relaxation
of twice TRIALS trials. Prints the shares of trials that clash and that are accepted, the number of side-chain torsions
that change by more than 60 degrees in 1000 trials, the number of different torsions among these, the share of outer
tests passed, and microseconds of processor time per trial.

Exit status 1 if a p-value is below SIGNIFICANCE divided by their number (Bonferroni).
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np
import openmm
import openmm.app as app
from openmm import unit
from openmmchaintree import (
    DrawnTorsions,
    StericExclusionForce,
    TorsionDensity,
    TorsionMonteCarloIntegrator,
    createStericExclusionForce,
    densities,
    ramachandranDensities,
    rotamerDensities,
)
from openmmchaintree.residues import aminoAcid
from peptide import FORCE_FIELD, cutPeptide
from scipy.stats import chisquare, t

SIGNIFICANCE = 1e-3
COPIES = 200  # of a set of torsions in one chain
GAS_CONSTANT = 8.31446261815324e-3  # kJ/mol/K
GRID, CELLS = 144, 6  # per torsion, for quadrature and for histograms
TRIALS = 40  # between two samples of the dipeptide
BLOCKS = 50
JUMP = np.pi / 3
FLOOR = 0.1


def contextOf(system, integrator, positions, platform="Reference"):
    context = openmm.Context(system, integrator, openmm.Platform.getPlatform(platform))
    context.setPositions(positions)
    return context


# ---- Torsions without energy ----


class FreeChain:
    """A chain of beads without radius, with COPIES sets of `numTorsions` torsions."""

    def __init__(self, numTorsions):
        self.sets = [tuple(range(i * numTorsions, (i + 1) * numTorsions)) for i in range(COPIES)]
        count = COPIES * numTorsions + 3
        force = StericExclusionForce()
        self.system = openmm.System()
        for i in range(count):
            self.system.addParticle(1)
            force.addParticle(0)
            if i > 0:
                force.addBond(i - 1, i)
            if i > 2:
                force.addTorsion(i - 3, i - 2, i - 1, i)
        self.system.addForce(force)
        steps = np.arange(count)
        self.positions = np.array([0.3 * np.cos(steps * 1.5), 0.3 * np.sin(steps * 1.5), 0.1 * steps]).T

    def move(self, density, draws, generator):
        """Return torsions after some trials from uniform ones, a row per sample, and the move's statistics."""
        integrator = TorsionMonteCarloIntegrator(300)
        integrator.setRandomNumberSeed(int(generator.integers(1, 2**31)))
        integrator.addDrawnMove(1, self.sets, density)
        integrator.setTrialsPerStep(4 * COPIES)
        context = contextOf(self.system, integrator, self.positions)
        found = []
        for _ in range(draws // COPIES):
            angles = generator.uniform(-np.pi, np.pi, len(self.sets) * len(self.sets[0]))
            integrator.setTorsionAngles(context, angles)
            integrator.step(1)
            found.append(np.array(integrator.getTorsionAngles(context)).reshape(COPIES, -1))
        return np.concatenate(found), integrator.getMoveStatistics(0)


def pValueOfUniform(samples):
    """Return the least p-value of single torsions and pairs of torsions, times their number."""
    values = []
    for i in range(samples.shape[1]):
        values.append(chisquare(np.histogram(samples[:, i], 24, (-np.pi, np.pi))[0]).pvalue)
        for j in range(i):
            counts, _, _ = np.histogram2d(samples[:, i], samples[:, j], 12, [(-np.pi, np.pi)] * 2)
            values.append(chisquare(counts.ravel()).pvalue)
    return min(1, min(values) * len(values))


def tabledDensities():
    """Generate (name, density) for each density of the tables."""
    for name, (_, means, _) in densities.rotamerTables().items():
        chis = tuple(range(means.shape[1]))
        for first in chis:
            yield f"{name} from chi{first + 1} on", densities.rotamerDensity(name, False, chis[first:], FLOOR)
    for name, counts in densities.loopCounts().items():
        yield f"{name} phi, psi", TorsionDensity.fromTable(counts, FLOOR)


def testUniform(arguments):
    generator = np.random.default_rng(arguments.seed)
    chains, least, count = {}, 1.0, 0
    for name, density in tabledDensities():
        numTorsions = density.getNumTorsions()
        chain = chains.setdefault(numTorsions, FreeChain(numTorsions))
        samples, moves = chain.move(density, arguments.draws, generator)
        value = pValueOfUniform(samples)
        least, count = min(least, value), count + 1
        print(f"{name:20} {density!r:60} accepted {moves.accepted / moves.attempted:.3f}  p {value:.2g}", flush=True)
    print(f"least p-value of {count} densities, times their number: {min(1, least * count):.2g}")
    return least * count > SIGNIFICANCE


# ---- Alanine dipeptide ----


def testDipeptide(arguments):
    topology, positions = cutPeptide(first=15, count=1)
    assert [residue.name for residue in topology.residues()] == ["ACE", "ALA", "NME"]
    system = app.ForceField(*FORCE_FIELD).createSystem(topology)
    reference = contextOf(system, openmm.VerletIntegrator(0.001), positions)
    force = createStericExclusionForce(topology, positions)
    system.addForce(force)
    drawn = ramachandranDensities(topology, force)
    integrator = TorsionMonteCarloIntegrator(arguments.temperature)
    integrator.setRandomNumberSeed(arguments.seed)
    integrator.addDrawnMove(1, drawn)
    integrator.setTrialsPerStep(TRIALS)
    context = contextOf(system, integrator, positions)
    force = StericExclusionForce.cast(context.getSystem().getForces()[-1])
    (pair,) = drawn.torsions

    def look():
        angles = np.array(integrator.getTorsionAngles(context))[list(pair)]
        cells = np.minimum((angles + np.pi) / (2 * np.pi) * CELLS, CELLS - 1).astype(int)
        return np.append(np.eye(CELLS**2)[cells[0] * CELLS + cells[1]], integrator.getPotentialEnergy(context))

    integrator.step(100)
    start = np.array(integrator.getTorsionAngles(context))
    energies, values = [], []
    middles = (np.arange(GRID) + 0.5) / GRID * 2 * np.pi - np.pi
    for point in np.array(np.meshgrid(middles, middles)).reshape(2, -1).T:
        angles = start.copy()
        angles[list(pair)] = point
        integrator.setTorsionAngles(context, angles)
        if not force.hasClash(context):
            reference.setPositions(context.getState(positions=True).getPositions())
            energy = reference.getState(energy=True).getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)
            energies.append(energy)
            values.append(np.append(look()[:-1], energy))
    weights = np.exp(-(np.array(energies) - min(energies)) / (GAS_CONSTANT * arguments.temperature))
    expected = weights @ np.array(values) / weights.sum()
    integrator.setTorsionAngles(context, start)
    integrator.resetMoveStatistics()
    samples = []
    for _ in range(arguments.draws):
        integrator.step(1)
        samples.append(look())
    moves, tests = integrator.getMoveStatistics(0), integrator.getOuterStatistics()
    print(f"accepted {moves.accepted / moves.attempted:.3f}; outer tests kept {tests.accepted / tests.attempted:.3f}")
    blocks = np.array(samples)[: len(samples) // BLOCKS * BLOCKS].reshape(BLOCKS, -1, CELLS**2 + 1).mean(axis=1)
    isSeldom = np.append(expected[:-1] < 0.005, False)
    blocks, expected = (
        np.column_stack([rows[:, ~isSeldom], rows[:, isSeldom].sum(axis=1)]) for rows in (blocks, expected[None])
    )
    errors = blocks.std(axis=0, ddof=1) / np.sqrt(BLOCKS)
    pValues = 2 * t.sf(np.abs(blocks.mean(axis=0) - expected[0]) / errors, BLOCKS - 1)
    for mean, wanted, error, value in zip(blocks.mean(axis=0), expected[0], errors, pValues, strict=True):
        print(f"{mean:12.5f}  expected {wanted:12.5f}  error {error:.5f}  p {value:.2g}")
    print(f"least p-value of {len(pValues)} means, times their number: {min(1, pValues.min() * len(pValues)):.2g}")
    return pValues.min() * len(pValues) > SIGNIFICANCE


# ---- Folded proteins ----


def readProtein(name):
    """Return the topology and positions of a structure without residues that have no AMBER14 template."""
    path = Path(app.__file__).parent / "data" / "test.pdb" if name == "villin" else Path(name)
    pdb = app.PDBFile(str(path))
    modeller = app.Modeller(pdb.topology, pdb.positions)
    modeller.delete([residue for residue in pdb.topology.residues() if aminoAcid(residue.name) is None])
    return modeller.topology, modeller.positions


def reportAcceptance(arguments):
    topology, positions = readProtein(arguments.structure)
    system = app.ForceField(*FORCE_FIELD).createSystem(topology)
    force = createStericExclusionForce(topology, positions)
    parts, whole = rotamerDensities(topology, force), rotamerDensities(topology, force, parts=False)
    chis = sorted({torsion for found in whole.torsions for torsion in found})
    flat = [TorsionDensity.fromTable(np.ones((1,) * len(found))) for found in whole.torsions]
    moves = {
        "one chi, any angle": lambda integrator: integrator.addTorsionMove(1, np.pi, chis),
        "whole, any angles": lambda integrator: integrator.addDrawnMove(1, DrawnTorsions(whole.torsions, flat)),
        "whole, rotamers": lambda integrator: integrator.addDrawnMove(1, whole),
        "parts, rotamers": lambda integrator: integrator.addDrawnMove(1, parts),
    }
    system.addForce(force)

    def contextWith(addMoves, positions):
        integrator = TorsionMonteCarloIntegrator(arguments.temperature)
        integrator.setRandomNumberSeed(arguments.seed)
        integrator.setTrialsPerStep(400)
        addMoves(integrator)
        return integrator, contextOf(system, integrator, positions, "CPU")

    def addAll(integrator):
        integrator.addTorsionMove(3, 0.2, chis)
        integrator.addTorsionMove(1, 0.02)
        integrator.addDrawnMove(1, parts)

    integrator, context = contextWith(addAll, positions)
    for _ in range(2):
        integrator.step(arguments.trials // 400)
        integrator.renewStandIns(context)
    start = context.getState(positions=True).getPositions()
    print(f"{topology.getNumAtoms()} atoms, {len(whole.torsions)} side chains with {len(chis)} torsions")
    for name, add in moves.items():
        integrator, context = contextWith(add, start)
        integrator.step(2)
        integrator.resetMoveStatistics()
        before, jumped, begun = np.array(integrator.getTorsionAngles(context))[chis], [], time.process_time()
        for _ in range(arguments.trials // 400):
            integrator.step(1)
            after = np.array(integrator.getTorsionAngles(context))[chis]
            jumped.extend(np.flatnonzero(np.abs((after - before + np.pi) % (2 * np.pi) - np.pi) > JUMP))
            before = after
        seconds, trials = time.process_time() - begun, arguments.trials // 400 * 400
        counts, tests = integrator.getMoveStatistics(0), integrator.getOuterStatistics()
        clashed, accepted = counts.clashed / counts.attempted, counts.accepted / counts.attempted
        print(
            f"{name:20} clashed {clashed:.3f}  accepted {accepted:.4f}"
            f"  jumps in 1000 {1000 * len(jumped) / trials:5.2f} of {len(set(jumped)):3} torsions"
            f"  tests kept {tests.accepted / tests.attempted:.2f}  {1e6 * seconds / trials:.1f} us",
            flush=True,
        )
    return True


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("what", choices=("uniform", "dipeptide", "acceptance"))
    parser.add_argument("structure", nargs="?", default="villin")
    parser.add_argument("--draws", type=int, default=100000)
    parser.add_argument("--trials", type=int, default=200000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--temperature", type=float, default=300)
    arguments = parser.parse_args()
    tests = {"uniform": testUniform, "dipeptide": testDipeptide, "acceptance": reportAcceptance}
    return 0 if tests[arguments.what](arguments) else 1


if __name__ == "__main__":
    sys.exit(main())
