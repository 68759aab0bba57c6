"""Does Monte Carlo with atom moves sample what unconstrained Langevin dynamics samples?

    python dynamics.py all MOLECULE [--frames 20000] [--temperature 300] [--chains 4] [--time-step 0.5] [--seed 1]
    python dynamics.py sample MOLECULE METHOD FILE [the same options]
    python dynamics.py compare FILE FILE

Small molecules in AMBER14 with OBC2, without constraints: alanine, glycine, valine, proline (capped), trialanine
(capped), dinucleotide (ApA, an RNA). METHOD is one of

dynamics  Langevin dynamics (LangevinMiddleIntegrator, 1/ps, the masses of the force field)
half      the same with half the time step
atoms     atom moves and the default moves of torsions
torsions  the default moves of torsions alone, at the bond lengths and angles of a local minimum

`all` samples by dynamics, half and atoms, and compares the others with dynamics. `compare` prints of two samples, with
standard errors from at least 64 blocks, which should be much longer than the time between transitions:

- shares of alpha (psi from -120 to 50, phi < 0), beta (phi < -100), PPII and left (phi > 0), and of the thirds of the
  circle for other torsions, with the effective size of the samples;
- the total variation of phi and psi on 18 x 18 bins, next to what two such samples of one distribution give;
- means and widths of each kind of bond and angle (by its parameters), and the mean energy of each Force.

Exit status 1 if a p-value is below SIGNIFICANCE divided by their number (Bonferroni).
"""

import argparse
import sys
import time

import numpy as np
import openmm
from comparison import Comparison
from molecules import NAMES, makeMolecule
from openmm import unit
from openmmchaintree import TorsionMonteCarloIntegrator, addDefaultMoves, createStericExclusionForce
from samples import Samples

SIGNIFICANCE = 1e-3
FRICTION = 1  # 1/ps
PICOSECONDS = 0.5  # between frames of dynamics
SWEEPS = 2  # between frames of Monte Carlo: trials for each atom
ATOM_WEIGHT, ATOM_STEP = 3, 0.02  # nm; the others have the weight 1 together
ADAPTATION = 400  # steps
RELAXATION = 0.1  # frames that are left out first, to one that is kept
METHODS = ("dynamics", "half", "atoms", "torsions")


class Sampler:
    """A chain of one molecule by one method."""

    def __init__(self, molecule, method, arguments, seed):
        topology, self.system, positions = molecule
        if method in ("atoms", "torsions"):
            self.integrator = self._makeMoves(topology, positions, method, arguments)
            self.steps = 1
        else:
            timeStep = arguments.time_step * (0.5 if method == "half" else 1)
            self.integrator = openmm.LangevinMiddleIntegrator(arguments.temperature, FRICTION, timeStep * 1e-3)
            self.steps = round(PICOSECONDS * 1e3 / timeStep)
        self.integrator.setRandomNumberSeed(seed)
        platform = openmm.Platform.getPlatform(arguments.platform)
        self.context = openmm.Context(self.system, self.integrator, platform)
        self.context.setPositions(positions)
        openmm.LocalEnergyMinimizer.minimize(self.context)
        self.context.setVelocitiesToTemperature(arguments.temperature, seed)
        if method in ("atoms", "torsions"):
            if method == "atoms":
                self._adapt()
            addDefaultMoves(self.integrator, topology, self.system)

    def _makeMoves(self, topology, positions, method, arguments):
        self.system = openmm.XmlSerializer.clone(self.system)
        self.system.addForce(createStericExclusionForce(topology, positions, system=self.system))
        integrator = TorsionMonteCarloIntegrator(arguments.temperature)
        integrator.setStericMode(integrator.Off)
        if method == "atoms":
            integrator.addAtomMove(ATOM_WEIGHT, ATOM_STEP)
        integrator.setTrialsPerStep(SWEEPS * topology.getNumAtoms())
        return integrator

    def _adapt(self):
        """Let the sizes of atom moves adapt, before there are other moves: these should stay as large as they are."""
        self.integrator.setAdaptMoveSizes(True)
        self.integrator.step(ADAPTATION)
        self.integrator.setAdaptMoveSizes(False)

    def sample(self, frames):
        """Return positions and energies of frames, after a relaxation."""
        self.integrator.step(round(RELAXATION * frames) * self.steps)
        positions, energies = [], []
        for _ in range(frames):
            self.integrator.step(self.steps)
            state = self.context.getState(positions=True)
            places = state.getPositions(asNumpy=True).value_in_unit(unit.nanometer)
            positions.append((places - places.mean(axis=0)).astype(np.float32))
            energies.append([self._energy(force.getForceGroup()) for force in self.forces()])
        return np.array(positions), np.array(energies)

    def _energy(self, group):
        energy = self.context.getState(energy=True, groups=1 << group).getPotentialEnergy()
        return energy.value_in_unit(unit.kilojoule_per_mole)

    def forces(self):
        return [force for force in self.system.getForces() if force.getName() != "StericExclusionForce"]


def sample(arguments, method):
    """Return Samples of some chains by a method."""
    molecule, chains, start = makeMolecule(arguments.molecule), [], time.process_time()
    for chain in range(arguments.chains):
        sampler = Sampler(molecule, method, arguments, arguments.seed * 1000 + chain)
        chains.append(sampler.sample(arguments.frames))
    seconds = time.process_time() - start
    positions, energies = map(np.array, zip(*chains, strict=True))
    names = np.array([force.getName() for force in sampler.forces()])
    return Samples(arguments.molecule, method, arguments.temperature, positions, energies, names, seconds)


def compare(first, second):
    """Print the comparison of two Samples; return whether they agree."""
    comparison = Comparison(first, second)
    comparison.report()
    count = len(comparison.pValues)
    least = min(1, min(comparison.pValues) * count)
    print(f"least p-value of {count}, times their number: {least:.2g}\n", flush=True)
    return least > SIGNIFICANCE


def _parse(arguments):
    options = argparse.ArgumentParser(add_help=False)
    options.add_argument("molecule", choices=NAMES)
    options.add_argument("--frames", type=int, default=20000, help="of each chain")
    options.add_argument("--temperature", type=float, default=300)
    options.add_argument("--chains", type=int, default=4)
    options.add_argument("--time-step", type=float, default=0.5, metavar="FS")
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--platform", default="Reference")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("all", parents=[options])
    sampling = commands.add_parser("sample", parents=[options])
    sampling.add_argument("method", choices=METHODS)
    sampling.add_argument("file")
    comparing = commands.add_parser("compare")
    comparing.add_argument("files", nargs=2, metavar="FILE")
    return parser.parse_args(arguments)


def main():
    arguments = _parse(sys.argv[1:])
    if arguments.command == "sample":
        sample(arguments, arguments.method).save(arguments.file)
        return 0
    if arguments.command == "compare":
        return 0 if compare(*map(Samples.load, arguments.files)) else 1
    reference = sample(arguments, "dynamics")
    agree = [compare(reference, sample(arguments, method)) for method in ("half", "atoms")]
    return 0 if all(agree) else 1


if __name__ == "__main__":
    sys.exit(main())
