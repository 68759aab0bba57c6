"""What a trial costs on each platform that is here: the villin headpiece, one torsion at a time.

    python benchmarks/platforms.py [TRIALS]

Without other forces, positions go to the platform once a step of 100 trials. With other forces, of which the platform
evaluates all, they go there for each trial that is free of clashes: with a single bond, next to nothing is computed, so
that this is the cost of handing positions over; with a force field its energy comes on top, measured with a twentieth
of the trials.
"""

import sys
import time

import openmm
from openmm import app, unit
from openmmchaintree import TorsionMonteCarloIntegrator, createStericExclusionForce
from openmmchaintree.structures.structure import readStructure


def bareSystem(structure):
    system = openmm.System()
    for atom in structure.topology.atoms():
        system.addParticle(atom.element.mass)
    return system


def oneBondSystem(structure):
    system = bareSystem(structure)
    bond = openmm.HarmonicBondForce()
    bond.addBond(0, 1, 0.1, 1.0)
    system.addForce(bond)
    return system


def amberSystem(structure):
    return app.ForceField("amber14-all.xml").createSystem(structure.topology)


def measure(structure, system, platform, precision, trials):
    """Microseconds per trial."""
    system.addForce(createStericExclusionForce(structure.topology, structure.positions))
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(1)
    integrator.setNativeEnergies(False)
    integrator.addTorsionMove(1.0, 0.2)
    properties = {"Precision": precision} if precision else {}
    context = openmm.Context(system, integrator, platform, properties)
    context.setPositions(structure.positions * unit.nanometer)
    integrator.step(1)
    steps = max(1, trials // integrator.getTrialsPerStep())
    start = time.perf_counter()
    integrator.step(steps)
    return 1e6 * (time.perf_counter() - start) / (steps * integrator.getTrialsPerStep())


def main():
    trials = int(sys.argv[1]) if len(sys.argv) > 1 else 20000
    structure = readStructure()
    print(f"{structure.topology.getNumAtoms()} atoms, µs per trial")
    print("platform   precision  no other force  one bond  amber14")
    for i in range(openmm.Platform.getNumPlatforms()):
        platform = openmm.Platform.getPlatform(i)
        for precision in ("single", "mixed", "double") if "Precision" in platform.getPropertyNames() else ("",):
            alone = measure(structure, bareSystem(structure), platform, precision, trials)
            bond = measure(structure, oneBondSystem(structure), platform, precision, trials)
            amber = measure(structure, amberSystem(structure), platform, precision, trials // 20)
            print(f"{platform.getName():10} {precision or '-':9} {alone:15.1f} {bond:9.1f} {amber:8.1f}", flush=True)


if __name__ == "__main__":
    main()
