"""How many independent closed loops grow a second, and do annealed loops find the crystal's?

    python loops.py growth FOLDER [--seconds 10] [--seed 1]
    python loops.py growth STRUCTURE LOOP [--seconds 10] [--seed 1]
    python loops.py energies FOLDER | STRUCTURE LOOP [--starts 20] [--trials 200000] [--seed 1] [--only NAME ...]

FOLDER holds loops.json and NAME.pdb.gz of the benchmark Kortemme-Lab/loop_modeling; a LOOP is a name such as A:63-74.

growth: hard spheres and the density of random coils. Prints for each loop the attempts, the closed loops without
clashes, these by second of processor time, and the independent conformers by second that their weights are worth.

energies: AMBER14 with GBn2, hydrogens and missing atoms added, everything but the loop fixed. Prints the
lowest energy from grown loops less the lowest from the crystal's loop, which is annealed as often by the same trials
and the same quench; the RMSD of both from the crystal (N, CA, C, O, in its frame); the number of basins (0.1 nm); and
processor time. The share of loops whose grown starts come within 2 kT of the crystal's, or below, ends the table.
"""

import argparse
import json
import time
import warnings
from pathlib import Path

import numpy as np
from openmmchaintree import InputError
from openmmchaintree.command.energymodel import EnergyModel
from openmmchaintree.command.preparing.preparation import prepareStructure
from openmmchaintree.ensembles.loopannealing import LoopAnnealing
from openmmchaintree.ensembles.looprun import LoopRun, effectiveSize
from openmmchaintree.structures.structure import readStructure

FORCE_FIELD = ["amber14-all.xml", "implicit/gbn2.xml"]
TEMPERATURE, HOTTEST, PH = 300.0, 1500.0, 7.0
TWO_KT = 2 * 8.31446261815324e-3 * TEMPERATURE  # kJ/mol


def main():
    options = readOptions()
    warnings.simplefilter("ignore")
    results = []
    for name, path, loop in findLoops(options):
        try:
            results.append((growth if options.study == "growth" else energies)(name, path, loop, options))
        except InputError as error:
            print(f"{name:8} {loop:14} {error}", flush=True)
    if options.study == "energies" and results:
        print(f"{np.mean([difference <= TWO_KT for difference in results]):.2f} of {len(results)} loops within 2 kT")
    elif results:
        print(f"median: {np.median(results):.1f} closed loops a second")


def readOptions():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", choices=("growth", "energies"))
    parser.add_argument("source", type=Path)
    parser.add_argument("loop", nargs="?")
    parser.add_argument("--only", nargs="+", default=[])
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("--starts", type=int, default=20)
    parser.add_argument("--trials", type=int, default=200000)
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


def findLoops(options):
    """Generate (name, path, loop) of the source."""
    if options.loop is not None:
        yield options.source.name.split(".")[0], options.source, options.loop
        return
    for name, entry in sorted(json.loads((options.source / "loops.json").read_text()).items()):
        ends = "-".join(entry[f"{end}ResidueID"].strip() for end in ("Start", "End"))
        if not options.only or name in options.only:
            yield name, options.source / f"{name}.pdb.gz", f"{entry['chainID']}:{ends}"


def growth(name, path, loop, options):
    """Return the closed loops a second."""
    structure = readStructure(str(path))
    run = LoopRun(structure.topology, structure.positions, loop, "coil", 298.0, options.seed)
    attempts, start = 0, time.process_time()
    while time.process_time() - start < options.seconds:
        run.grow()
        attempts += 1
    seconds, count = time.process_time() - start, len(run.loops)
    size = effectiveSize(run.logWeights)
    print(
        f"{name:8} {loop:14} {attempts:6} attempts, {count:5} loops, {count / seconds:6.1f} a second, "
        f"independent by weight {size / seconds:.2f} a second",
        flush=True,
    )
    return count / seconds


def energies(name, path, loop, options):
    """Return by how much the lowest energy of grown loops is above that of the crystal's, kJ/mol."""
    model = EnergyModel(FORCE_FIELD, TEMPERATURE, isPrepared=True)
    structure, _ = prepareStructure(readStructure(str(path)), model, PH, options.seed)
    system, _ = model.makeSystem(structure)
    start = time.process_time()
    run = LoopAnnealing(structure.topology, structure.positions, loop, system, options.seed)
    grown = run.anneal(options.starts, TEMPERATURE, HOTTEST, options.trials)
    crystal = [grown.native]
    for _ in range(options.starts - 1):
        positions, energy, distance = run.annealGiven(TEMPERATURE, HOTTEST, options.trials)
        crystal.append((positions, energy, distance))
    best, native = int(np.argmin(grown.energies)), min(crystal, key=lambda one: one[1])
    difference = grown.energies[best] - native[1]
    print(
        f"{name:8} {loop:14} grown - crystal {difference:8.1f} kJ/mol; RMSD {grown.distances[best]:.3f} and "
        f"{native[2]:.3f} nm, least {grown.distances.min():.3f} nm; {grown.basins.max() + 1} basins of "
        f"{options.starts}; {grown.runs} attempts; {time.process_time() - start:.0f} s",
        flush=True,
    )
    return difference


if __name__ == "__main__":
    main()
