"""Energies of real systems for longer than tests may take: is U still OpenMM's after many accepted trials?

    python tests/long_native_energies.py [ACCEPTED TRIALS] [NAME ...]
    python tests/long_native_energies.py --beads COUNT

By default a million accepted trials of each structure and method. Real structures lie where CHAINTREE_TEST_DATA says.
Prints by how much U is off, kJ/mol, at each tenth; exit status 1 if it is off by more than 5e-3 and by more than single
precision explains where atoms overlap. --beads measures time and memory of a chain of this number of beads,
packed as densely as atoms of a protein, with a cutoff of 1 nm.
"""

import sys
import time
from pathlib import Path

import numpy as np
import openmm
from openmmchaintree import StericExclusionForce
from realsystems import METHODS, Reference, Run, makeSystem

NAMES = ("alanine dipeptide", "villin", "1ubi_h", "bpti_h", "5dfr_h", "1bna", "4hhb")
ABSOLUTE = 5e-3  # kJ/mol
ROUNDING = 1e-7  # nm


def follow(name, method, accepted):
    """Print the error of U now and then; return whether it was always small."""
    system, _, positions = makeSystem(name, method=method)
    run, reference = Run(system, positions), Reference(system)
    errors, isGood, target = [], True, 0
    while target <= accepted:
        while run.accepted < target:
            run.run(1000)
        positions = run.positions
        errors.append(run.energy - reference.energy(positions))
        isGood = isGood and abs(errors[-1]) <= ABSOLUTE + ROUNDING * reference.gradient(positions)
        target += max(1, accepted // 10)
    print(f"{name}, {method}:", *(f"{error:.1e}" for error in errors), "" if isGood else "TOO MUCH", flush=True)
    return isGood


# ---- Memory ----

SPACING = 0.22  # nm


def serpentine(count):
    """Return places in a cube, each next to the one before, a little off so that no torsion is straight."""
    side = round(count ** (1 / 3))
    index = np.arange(side**3)
    layer, inLayer = index // side**2, index % side**2
    inLayer = np.where(layer % 2 == 1, side**2 - 1 - inLayer, inLayer)
    row, column = inLayer // side, inLayer % side
    column = np.where(row % 2 == 1, side - 1 - column, column)
    places = SPACING * np.stack([column, row, layer], axis=1)
    return places + np.random.default_rng(1).uniform(-0.02, 0.02, places.shape)


def bytesInUse():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


def measureBeads(count):
    positions = serpentine(count)
    system, force, pairs = openmm.System(), StericExclusionForce(), openmm.NonbondedForce()
    pairs.setNonbondedMethod(openmm.NonbondedForce.CutoffNonPeriodic)
    pairs.setCutoffDistance(1)
    for i in range(len(positions)):
        system.addParticle(1)
        force.addParticle(0)
        pairs.addParticle(0.2 if i % 2 else -0.2, 0.2, 0.2)
        if i >= 1:
            force.addBond(i - 1, i)
        for j in range(max(0, i - 2), i):
            pairs.addException(j, i, 0, 1, 0)
        if i >= 3:
            force.addTorsion(i - 3, i - 2, i - 1, i)
    system.addForce(force)
    system.addForce(pairs)

    begun, before = time.time(), bytesInUse()

    def report(what):
        used = (bytesInUse() - before) / len(positions)
        print(f"{what}: {time.time() - begun:.1f} s, {used:.0f} bytes a particle", flush=True)

    run = Run(system, positions, moves=((1, 1e-6, 1),))
    report("Context")
    print(run.energy, "kJ/mol")
    report("energy")
    run.run(100)
    report("100 trials, and OpenMM's energy to compare with")
    run.run(100)
    report("100 trials")


def main(arguments):
    if arguments[:1] == ["--beads"]:
        return measureBeads(int(arguments[1]))
    accepted = int(arguments[0]) if arguments else 1000000
    names = arguments[1:] or NAMES
    return not all([follow(name, method, accepted) for name in names for method in METHODS])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
