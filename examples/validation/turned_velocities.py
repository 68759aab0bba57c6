"""Do alternating dynamics and Monte Carlo sample the same distribution as dynamics alone?

    python turned_velocities.py [SETTING ...] [--steps 500000] [--every 10] [--temperature 300] [--friction 1]
                                [--seed 1]

Langevin dynamics of a capped alanine of the villin headpiece in AMBER99SB with OBC, with time steps of 2 fs with
constraints and 1 fs without, is compared with alternation: `every` steps of dynamics, then a Monte Carlo step of 50
trials. Prints for both the temperature of the velocities and U with their standard errors, and the least p-value, times
their number, of Welch's tests of 20 block means: kinetic energy, U, cells of phi and psi (for phi below 0, since
dynamics hardly leaves this region), and the mean and variance of the length of each unconstrained bond. Settings:

none, HBonds, AllBonds  the constraints; phi and psi change by any angle
rotors                  no constraints; omega and methyl groups rotate, too
remover                 HBonds, with a CMMotionRemover
rigid                   HBonds, and moves translate and rotate the whole molecule
closed                  HBonds, VAL-PHE-GLY-MET, closed moves alone; slow at 300 K, so use --temperature 600
handed                  HBonds, in two Contexts that exchange positions and velocities, as in openmmtools

Exit status 1 if a p-value is below SIGNIFICANCE divided by their number (Bonferroni). Each block of either run should
have at least 20 ps, or blocks are correlated. With alternation as frequent as here, `handed` is about one percent too
hot, since the integrator's velocities are half a step before the positions; only a common Context corrects for this.
"""

import argparse
import sys

import numpy as np
import openmm
import openmm.app as app
from openmm import unit
from openmmchaintree import TorsionMonteCarloIntegrator, createStericExclusionForce
from peptide import cutPeptide
from scipy.stats import ttest_ind

SIGNIFICANCE = 1e-3
GAS_CONSTANT = 8.31446261815324e-3  # kJ/mol/K
BLOCKS = 20
CELLS = 4  # for each of phi and psi
SETTINGS = ("none", "HBonds", "AllBonds", "rotors", "remover", "rigid", "closed", "handed")


class Peptide:
    """The molecule of a setting: its System and its measured quantities."""

    def __init__(self, setting):
        self.setting = setting
        self.topology, self.positions = cutPeptide(8, 4) if setting == "closed" else cutPeptide(7, 1)
        constraints = {"none": None, "rotors": None, "AllBonds": app.AllBonds}.get(setting, app.HBonds)
        forceField = app.ForceField("amber99sb.xml", "amber99_obc.xml")
        self.system = forceField.createSystem(
            self.topology, constraints=constraints, removeCMMotion=setting == "remover"
        )
        kinds = ("phi", "psi", "omega", "rotor") if setting == "rotors" else ("phi", "psi")
        force = createStericExclusionForce(self.topology, self.positions, torsions=kinds)
        self.phi, self.psi = self._backbone(force)
        self.system.addForce(force)
        self.timeStep = 0.001 if constraints is None else 0.002
        constrained = {tuple(sorted(self.system.getConstraintParameters(i)[:2])) for i in range(self._count())}
        bonds = [tuple(sorted((bond[0].index, bond[1].index))) for bond in self.topology.bonds()]
        self.bonds = np.array([bond for bond in bonds if bond not in constrained], dtype=int).reshape(-1, 2)
        removed = 3 if setting == "remover" else 0
        self.degreesOfFreedom = 3 * self.system.getNumParticles() - self._count() - removed

    def _count(self):
        return self.system.getNumConstraints()

    def _backbone(self, force):
        particles = [force.getTorsionParticles(i) for i in range(force.getNumTorsions())]
        names = [atom.name for atom in self.topology.atoms()]
        named = {tuple(names[i] for i in four): four for four in reversed(particles)}
        return named["C", "N", "CA", "C"], named["N", "CA", "C", "N"]

    def measure(self, context):
        state = context.getState(positions=True, energy=True)
        places = state.getPositions(asNumpy=True).value_in_unit(unit.nanometer)
        lengths = np.linalg.norm(places[self.bonds[:, 0]] - places[self.bonds[:, 1]], axis=1)
        phi, psi = (dihedral(places[list(four)]) for four in (self.phi, self.psi))
        return [state.getKineticEnergy()._value, state.getPotentialEnergy()._value, phi, psi, *lengths]


def dihedral(places):
    first, axis, last = np.diff(places, axis=0)
    return np.arctan2(first @ np.cross(axis, last) * np.linalg.norm(axis), np.cross(first, axis) @ np.cross(axis, last))


class Run:
    """Dynamics of a Peptide, alone or alternating with Monte Carlo."""

    def __init__(self, peptide, arguments, takesTurns):
        self.peptide, self.every = peptide, arguments.every
        self.dynamics = openmm.LangevinMiddleIntegrator(arguments.temperature, arguments.friction, peptide.timeStep)
        self.dynamics.setRandomNumberSeed(arguments.seed)
        self.sampler = self._makeSampler(arguments) if takesTurns else None
        self.isHanded = takesTurns and peptide.setting == "handed"
        self.compound = None
        if takesTurns and not self.isHanded:
            self.compound = openmm.CompoundIntegrator()
            self.compound.addIntegrator(self.dynamics)
            self.compound.addIntegrator(self.sampler)
        self.context = self._makeContext(self.compound or self.dynamics)
        self.other = self._makeContext(self.sampler) if self.isHanded else None
        self.context.applyConstraints(1e-6)
        self.context.setVelocitiesToTemperature(arguments.temperature, arguments.seed)

    def _makeContext(self, integrator):
        context = openmm.Context(self.peptide.system, integrator, openmm.Platform.getPlatform("Reference"))
        context.setPositions(self.peptide.positions)
        return context

    def _makeSampler(self, arguments):
        sampler = TorsionMonteCarloIntegrator(arguments.temperature)
        sampler.setStericMode(sampler.Soft)
        sampler.setRandomNumberSeed(arguments.seed)
        sampler.setTrialsPerStep(50)
        if self.peptide.setting == "closed":
            sampler.addClosedMove(1, 0.5)
        else:
            sampler.addTorsionMove(1, np.pi)
        if self.peptide.setting == "rigid":
            sampler.addRigidBodyMove(1, 0.1, np.pi)
        return sampler

    def _tryMoves(self):
        if self.compound is not None:
            self.compound.setCurrentIntegrator(1)
            self.compound.step(1)
            self.compound.setCurrentIntegrator(0)
        elif self.isHanded:
            hand(self.context, self.other)
            self.sampler.step(1)
            hand(self.other, self.context)

    def sample(self, steps):
        """Return a row of measurements per alternation, without the first tenth."""
        rows = []
        for _ in range(steps // self.every):
            (self.compound or self.dynamics).step(self.every)
            rows.append(self.peptide.measure(self.context))
            self._tryMoves()
        return np.array(rows[len(rows) // 10 :])


def hand(giver, taker):
    state = giver.getState(positions=True, velocities=True)
    taker.setPositions(state.getPositions(asNumpy=True))
    taker.setVelocities(state.getVelocities(asNumpy=True))


def blockMeans(values):
    return np.array([block.mean(axis=0) for block in np.array_split(values, BLOCKS)])


def observables(rows):
    """Return block means, a column per quantity: energies, bond lengths and variances, cells of phi and psi."""
    phi, psi, lengths = rows[:, 2], rows[:, 3], rows[:, 4:]
    isLeft = phi < 0
    inCell = [
        isLeft & (np.floor((angle / np.pi + 1) / 2 * CELLS) == cell) for angle in (phi, psi) for cell in range(CELLS)
    ]
    blocks = [rows[:, :2], lengths, (lengths - lengths.mean(axis=0)) ** 2]
    means = np.concatenate([blockMeans(block) for block in blocks], axis=1)
    shares = blockMeans(np.array(inCell, dtype=float).T) / np.maximum(blockMeans(isLeft[:, None]), 1e-9)
    return np.concatenate([means, shares], axis=1)


def compare(setting, arguments):
    """Print a line, and return the least p-value times the number of tests."""
    peptide = Peptide(setting)
    runs = {name: Run(peptide, arguments, name == "turns") for name in ("dynamics", "turns")}
    found = {name: observables(run.sample(arguments.steps)) for name, run in runs.items()}
    texts = []
    for name, means in found.items():
        kelvins = 2 * means[:, 0] / (peptide.degreesOfFreedom * GAS_CONSTANT)
        numbers = [f"{values.mean():.2f} ± {values.std(ddof=1) / BLOCKS**0.5:.2f}" for values in (kelvins, means[:, 1])]
        texts.append(f"{name} {numbers[0]} K, U {numbers[1]}")
    varied = [column for column in range(found["turns"].shape[1]) if all(np.ptp(m[:, column]) for m in found.values())]
    values = [ttest_ind(*(m[:, column] for m in found.values()), equal_var=False).pvalue for column in varied]
    least = min(1, min(values) * len(values))
    statistics = runs["turns"].sampler.getMoveStatistics(0)
    texts.append(f"accepted {statistics.accepted / statistics.attempted:.3f}; {len(values)} tests, least p {least:.2g}")
    print(f"{setting:9} {'; '.join(texts)}", flush=True)
    return least


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("settings", nargs="*", choices=[*SETTINGS, []], metavar="SETTING", default=[])
    parser.add_argument("--steps", type=int, default=500_000)
    parser.add_argument("--every", type=int, default=10)
    parser.add_argument("--temperature", type=float, default=300.0)
    parser.add_argument("--friction", type=float, default=1.0)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    least = [compare(setting, arguments) for setting in arguments.settings or SETTINGS]
    return int(min(least) < SIGNIFICANCE)


if __name__ == "__main__":
    sys.exit(main())
