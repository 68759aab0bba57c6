"""What a trial costs on each platform that is here: the villin headpiece, one torsion at a time.

    python benchmarks/platforms.py [TRIALS]

Without other forces, positions go to the platform once a step of 100 trials. With other forces, all of which the
platform evaluates, they go there for each trial without a clash. A single bond shows what handing positions over
costs; a force field adds its energy, measured with a twentieth of the trials.
"""

import sys
import time

import openmm
from openmm import app
from openmmchaintree import TorsionMonteCarloIntegrator, createStericExclusionForce
from proteins import readProtein


def makeSystems(topology):
    """Return the Systems that are measured: without other forces, with a bond, and with a force field."""
    systems = {"no other force": openmm.System(), "one bond": openmm.System()}
    for system in systems.values():
        for atom in topology.atoms():
            system.addParticle(atom.element.mass)
    bond = openmm.HarmonicBondForce()
    bond.addBond(0, 1, 0.1, 1.0)
    systems["one bond"].addForce(bond)
    return {**systems, "amber14": app.ForceField("amber14-all.xml").createSystem(topology)}


def measure(protein, system, platform, properties, trials):
    """Return microseconds a trial, of the wall clock, since a device may do the work."""
    system.addForce(createStericExclusionForce(protein.topology, protein.positions))
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(1)
    integrator.setNativeEnergies(False)
    integrator.addTorsionMove(1.0, 0.2)
    context = openmm.Context(system, integrator, platform, properties)
    context.setPositions(protein.positions)
    integrator.step(1)
    steps = max(1, trials // integrator.getTrialsPerStep())
    start = time.perf_counter()
    integrator.step(steps)
    return 1e6 * (time.perf_counter() - start) / (steps * integrator.getTrialsPerStep())


def main():
    """Print a line for each platform and precision."""
    trials = int(sys.argv[1]) if len(sys.argv) > 1 else 20000
    protein = readProtein()
    print(f"{len(protein.positions)} atoms, µs per trial")
    print("platform   precision  no other force  one bond  amber14")
    for i in range(openmm.Platform.getNumPlatforms()):
        platform = openmm.Platform.getPlatform(i)
        hasPrecision = "Precision" in platform.getPropertyNames()
        for precision in ("single", "mixed", "double") if hasPrecision else ("",):
            properties = {"Precision": precision} if precision else {}
            times = [
                measure(protein, system, platform, properties, trials // 20 if name == "amber14" else trials)
                for name, system in makeSystems(protein.topology).items()
            ]
            print(f"{platform.getName():10} {precision or '-':9} {times[0]:15.1f} {times[1]:9.1f} {times[2]:8.1f}")


if __name__ == "__main__":
    main()
