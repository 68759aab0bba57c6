"""Do moves leave exp(-U/kT) invariant? A capped tetrapeptide in AMBER14 with GBn2 in which all torsions move.

    python peptide_moves.py [--draws 2000] [--seed 1] [--temperature 400] [MOVE ...]

A long chain of single-torsion moves, small and of any angle, gives samples ("draws"). From each sample, each MOVE alone
makes 400 trials and their outer test. The results must be distributed as the samples, even if the move mixes slowly.
Prints p-values of the mean changes of U, of the radius of gyration and of the cosines and sines of all torsions, by
Student's test of block means, and the size of the changes. Exit status 1 if a p-value is below SIGNIFICANCE divided by
their number (Bonferroni).

MOVE is a key of MOVES; default: all but `wrong`, which is the closed move at a temperature that is 30 % too high. The
tests must notice it.
"""

import argparse
import sys
import time

import numpy as np
import openmm
import openmm.app as app
import openmmchaintree as chaintree
from openmm import unit
from peptide import FORCE_FIELD, cutPeptide
from scipy.stats import t

SIGNIFICANCE = 1e-3
TRIALS = 400  # per step, and from each sample
STEPS_BETWEEN_DRAWS = 5
RELAXATION = 200  # steps
BLOCKS = 20
ROUNDING = 1e-10  # above the rounding error of torsions that a move does not change

MOVES = {
    "torsion": lambda integrator, scene: integrator.addTorsionMove(1, 0.3),
    "two torsions": lambda integrator, scene: integrator.addTorsionMove(1, 0.2, None, 2),
    "closed": lambda integrator, scene: integrator.addClosedMove(1, 0.2, None, 0),
    "hops": lambda integrator, scene: integrator.addClosedMove(1, 0.2, None, 1),
    "closed and hops": lambda integrator, scene: integrator.addClosedMove(1, 0.3),
    "local": lambda integrator, scene: integrator.addLocalMove(1, 0.3, 300, window=6),
    "side chains drawn": lambda integrator, scene: integrator.addDrawnMove(1, scene.rotamers),
    "phi and psi drawn": lambda integrator, scene: integrator.addDrawnMove(1, scene.ramachandran),
    "all": lambda integrator, scene: [MOVES[name](integrator, scene) for name in SINGLE],
    "wrong": lambda integrator, scene: integrator.addClosedMove(1, 0.2),
}


def addSource(integrator, scene):
    integrator.addTorsionMove(1, 0.5)
    integrator.addTorsionMove(3, np.pi)


SINGLE = ("torsion", "closed and hops", "local", "side chains drawn", "phi and psi drawn")


class Scene:
    """The peptide ASP-PHE-LYS-ALA of the villin headpiece that comes with OpenMM, capped."""

    def __init__(self):
        self.topology, self.positions = cutPeptide()
        self.system = app.ForceField(*FORCE_FIELD).createSystem(self.topology)
        force = chaintree.createStericExclusionForce(self.topology, self.positions)
        self.rotamers = chaintree.rotamerDensities(self.topology, force)
        self.ramachandran = chaintree.ramachandranDensities(self.topology, force)
        self.system.addForce(force)


class Run:
    """The peptide, sampled with one move."""

    def __init__(self, scene, addMove, temperature, seed):
        self.integrator = chaintree.TorsionMonteCarloIntegrator(temperature)
        self.integrator.setRandomNumberSeed(seed)
        self.integrator.setTrialsPerStep(TRIALS)
        addMove(self.integrator, scene)
        self.context = openmm.Context(scene.system, self.integrator, openmm.Platform.getPlatform("Reference"))
        self.context.setPositions(scene.positions)
        self.integrator.renewStandIns(self.context)

    def step(self, state=None):
        """Make a step, from the given torsions if any; return the torsions and the compared quantities."""
        if state is not None:
            self.integrator.setTorsionAngles(self.context, state)
        self.integrator.step(1)
        return self.look()

    def look(self):
        angles = np.array(self.integrator.getTorsionAngles(self.context))
        places = self.context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)
        energy = self.integrator.getPotentialEnergy(self.context)
        radius = np.sqrt(places.var(axis=0).sum())
        return angles, np.concatenate([[energy, radius], np.cos(angles), np.sin(angles)])


def pValues(changes):
    """Return p-values of Student's test for zero mean, one per column of `changes`, which has a row per sample."""
    rows = changes[: len(changes) // BLOCKS * BLOCKS].reshape(BLOCKS, -1, changes.shape[1]).mean(axis=1)
    errors = rows.std(axis=0, ddof=1) / np.sqrt(BLOCKS) + ROUNDING
    return 2 * t.sf(np.abs(rows.mean(axis=0)) / errors, BLOCKS - 1)


def report(name, run, changes, seconds):
    """Print a line about a move; return its p-values."""
    found = pValues(changes)
    columns = ["U", "Rg"] + [f"{f} {i}" for f in ("cos", "sin") for i in range((changes.shape[1] - 2) // 2)]
    moved = np.abs(changes[:, 1]) > 1e-9
    size = np.sqrt((changes**2).mean(axis=0))
    integrator = run.integrator
    statistics = [integrator.getMoveStatistics(move) for move in range(integrator.getNumMoves())]
    attempted, accepted = sum(move.attempted for move in statistics), sum(move.accepted for move in statistics)
    print(
        f"{name}: {len(changes)} draws, {accepted / max(1, attempted):.3f} accepted, "
        f"{moved.mean():.3f} of the draws moved, rms change of U {size[0]:.2f} kJ/mol, of Rg {size[1]:.4f} nm, "
        f"{seconds / len(changes) / TRIALS * 1e6:.1f} us a trial; "
        f"least of {len(found)} p-values {found.min():.2g} ({columns[int(found.argmin())]}), "
        f"median {np.median(found):.2f}",
        flush=True,
    )
    return found


def main():
    parser = argparse.ArgumentParser(description="Test that moves leave the distribution of a peptide invariant.")
    parser.add_argument("moves", nargs="*", metavar="MOVE", help=", ".join(MOVES))
    parser.add_argument("--draws", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--temperature", type=float, default=400)
    arguments = parser.parse_args()
    names = arguments.moves or [name for name in MOVES if name != "wrong"]
    scene = Scene()
    source = Run(scene, addSource, arguments.temperature, arguments.seed)
    for _ in range(RELAXATION):
        source.step()
    runs, changes, seconds = {}, {name: [] for name in names}, dict.fromkeys(names, 0.0)
    for number, name in enumerate(names):
        temperature = arguments.temperature * (1.3 if name == "wrong" else 1)
        runs[name] = Run(scene, MOVES[name], temperature, arguments.seed + 1 + number)
    for _ in range(arguments.draws):
        for _ in range(STEPS_BETWEEN_DRAWS):
            angles, before = source.step()
        for name, run in runs.items():
            start = time.process_time()
            changes[name].append(run.step(angles)[1] - before)
            seconds[name] += time.process_time() - start
    found = {name: report(name, runs[name], np.array(changes[name]), seconds[name]) for name in names}
    count = sum(map(len, found.values()))
    least = min(values.min() for values in found.values())
    print(f"least of {count} p-values: {least:.2g}, expected {1 / count:.2g}")
    return 0 if least > SIGNIFICANCE / count else 1


if __name__ == "__main__":
    sys.exit(main())
