"""Does a protein fold from an extended chain, and does a run from its native structure agree?

    python folding.py start CLN025.pdb extended.pdb --extended
    python folding.py run extended.pdb chignolin-1 --seed 1
    python folding.py report CLN025.pdb chignolin-1 chignolin-native --picture chignolin.png

`start` omits water and adds hydrogens; with --extended, it also turns phi to -150, psi to 150 and omega to 180 degrees,
and draws side chains at random until no atoms clash. `run` is `openmm-chaintree sample --flexible --disordered
--temperatures`, and records the CPU time of frames. The same command resumes an interrupted run; with more --trials, it
extends a run. Options that `run` does not know are passed on to `sample`.

A frame is folded if the RMSD of its alpha carbons from the native structure is at most --threshold. `report` prints
for each run and temperature, from the second half of the frames: the share of folded ones and its standard error (from
five blocks), mean U and mean radius of gyration; and the CPU time of the first folded frame, and the rate of exchanges
with the next temperature. The picture shows the RMSD at the lowest temperature against CPU time.
"""

import argparse
import sys
import time
from pathlib import Path
from threading import Event, Thread

import mdtraj
import numpy as np
import openmm
import openmm.app as app
from openmm import unit
from openmmchaintree import createStericExclusionForce, findTorsions
from openmmchaintree.command.cli import main as runCommand
from openmmchaintree.command.outputs.indexfile import readIndex
from openmmchaintree.command.outputs.replicafiles import trajectoryNames
from openmmchaintree.replicas.checkpointfile import readCheckpoint

FORCE_FIELD = ("amber14-all.xml", "implicit/gbn2.xml")
TEMPERATURES = "300:450:6"
TRIALS, FRAMES = 400000000, 16000  # of each replica
BACKBONE = {"phi": -150, "psi": 150, "omega": 180}  # degrees, of an extended chain
SIDE_CHAINS = ("chi1", "chi2", "chi3", "chi4")
DRAWS = 10000
SECONDS = 10  # between records of CPU time
BLOCKS = 5


# ---- The start ----


def writeStart(options):
    """Write a structure with hydrogens, native or extended."""
    pdb = app.PDBFile(options.structure)
    modeller = app.Modeller(pdb.topology, pdb.positions)
    modeller.topology.setPeriodicBoxVectors(None)
    modeller.deleteWater()
    modeller.addHydrogens()
    positions = np.array(modeller.positions.value_in_unit(unit.nanometer))
    if options.extended:
        positions = extend(modeller.topology, positions)
    with open(options.output, "w") as file:
        app.PDBFile.writeFile(modeller.topology, positions * unit.nanometer, file)
    return 0


def extend(topology, positions):
    """Return positions (nm) of an extended chain with random side chains, without clashes."""
    kinds = (*BACKBONE, *SIDE_CHAINS)
    force = createStericExclusionForce(topology, positions, torsions=kinds)
    kindOfTorsion = [torsion.kind for torsion in findTorsions(topology, positions, kinds=kinds).torsions]
    system = openmm.System()
    for _ in range(topology.getNumAtoms()):
        system.addParticle(1)
    system.addForce(force)
    context = openmm.Context(system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatform("Reference"))
    context.setPositions(positions)
    angles = np.radians([BACKBONE.get(kind, 0) for kind in kindOfTorsion])
    sideChains = [i for i, kind in enumerate(kindOfTorsion) if kind in SIDE_CHAINS]
    random = np.random.default_rng(1)
    angles[sideChains] = random.uniform(-np.pi, np.pi, len(sideChains))
    least = np.inf
    for _ in range(DRAWS):
        drawn = angles.copy()
        drawn[random.choice(sideChains)] = random.uniform(-np.pi, np.pi)
        force.setTorsionAngles(context, drawn)
        _, overlaps = force.getClashes(context)
        if overlaps.sum() <= least:
            angles, least = drawn, overlaps.sum()
        if least == 0:
            return context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)
    raise SystemExit(f"atoms still clash after {DRAWS:,} changes of side chains")


# ---- The run ----


def run(options):
    """Run `sample`, or resume it, and record CPU times; return the exit status."""
    arguments = ["--trials", options.trials]
    if Path(checkpoint := f"{options.prefix}.checkpoint").exists():
        arguments += ["--resume", checkpoint]
    else:
        arguments += [options.structure, "--output", options.prefix, "--seed", options.seed]
        arguments += ["--temperatures", options.temperatures, "--frames", options.frames]
        arguments += [*([] if options.rigid else ["--flexible"]), "--disordered", "--forcefield", *options.forcefield]
    ended = Event()
    recorder = Thread(target=recordTimes, args=(options.prefix, ended))
    recorder.start()
    try:
        return runCommand(["sample", *map(str, arguments), *options.others])
    finally:
        ended.set()
        recorder.join()


def recordTimes(prefix, ended):
    """Append lines of CPU seconds, which include earlier parts of the run, and the size of the index, until `ended`."""
    path, index = Path(f"{prefix}-cpu.csv"), Path(f"{prefix}-index.csv")
    before = float(path.read_text().split()[-1].split(",")[0]) if path.exists() else 0.0
    with open(path, "a") as file:
        while True:
            isLast = ended.wait(SECONDS)
            size = index.stat().st_size if index.exists() else 0
            file.write(f"{before + time.process_time():.2f},{size}\n")
            file.flush()
            if isLast:
                return


def readTimes(prefix):
    """Return the CPU time (h) of each row of the index."""
    seconds, sizes = np.loadtxt(f"{prefix}-cpu.csv", delimiter=",", ndmin=2).T
    sizes = np.minimum.accumulate(sizes[::-1])[::-1]  # a resumed run repeats the frames after its last checkpoint
    with open(f"{prefix}-index.csv", "rb") as file:
        ends = np.cumsum([len(line) for line in file])[1:]
    return np.interp(ends, sizes, seconds) / 3600


# ---- The report ----


class Run:
    """A run: its temperatures (K); for each an array of CPU times (h), RMSDs, radii of gyration (nm) and U (kJ/mol).

    rates : the rates of exchanges between neighboring temperatures; roundTrips : int, of all replicas
    """

    def __init__(self, prefix, native, selection, limit):
        """Read frames up to a CPU time (h), and compare the atoms of a selection with a native structure."""
        self.name = Path(prefix).name
        state = readCheckpoint(f"{prefix}.checkpoint")[0]["state"]
        self.rates = np.array(state["accepted"]) / np.maximum(1, state["attempted"])
        self.roundTrips = sum(state["roundTrips"])
        topology = mdtraj.load(f"{prefix}-topology.pdb").topology
        reference = native.atom_slice(native.topology.select(selection))
        index, hours = readIndex(f"{prefix}-index.csv"), readTimes(prefix)
        self.temperatures = np.unique(index["temperature"])
        self.hours, self.rmsd, self.energies, self.radii = [], [], [], []
        names = trajectoryNames(prefix, len(self.temperatures), self.temperatures, True)
        for temperature, name in zip(self.temperatures, names, strict=True):
            frames = mdtraj.load_dcd(name, top=topology, atom_indices=topology.select(selection))
            rows = np.flatnonzero((index["temperature"] == temperature) & (hours <= limit))[: len(frames)]
            self.hours.append(hours[rows])
            self.rmsd.append(mdtraj.rmsd(frames[: len(rows)], reference))
            self.energies.append(index["potentialEnergy"][rows])
            self.radii.append(index["radiusOfGyration"][rows])


def report(options):
    """Print tables of runs, and draw them."""
    native = mdtraj.load(options.structure)[0]
    selection = "protein and name CA"
    if options.residues is not None:
        selection += " and resSeq {} to {}".format(*options.residues)
    runs = [Run(prefix, native, selection, options.hours) for prefix in options.prefixes]
    for each in runs:
        printRun(each, options.threshold)
    if options.picture:
        draw(runs, options.threshold, options.picture)
    return 0


def printRun(run, threshold):
    print(f"{run.name}: {run.hours[0][-1]:.2f} CPU hours, {run.roundTrips} round trips")
    print("     K  frames  folded   s.e.  first, h  U, kJ/mol  Rg, nm  exchanged")
    for i, temperature in enumerate(run.temperatures):
        folded = run.rmsd[i] <= threshold
        half = slice(len(folded) // 2, None)
        share, error = meanOfBlocks(folded[half])
        first = f"{run.hours[i][folded.argmax()]:.3f}" if folded.any() else "never"
        rate = f"{run.rates[i]:.2f}" if i < len(run.rates) else ""
        means = f"{run.energies[i][half].mean():9.1f}  {run.radii[i][half].mean():6.3f}"
        print(f"{temperature:6.1f}  {len(folded[half]):6}  {share:6.3f}  {error:5.3f}  {first:>8}  {means}  {rate:>9}")


def meanOfBlocks(values):
    """Return the mean, and its standard error from the means of blocks."""
    means = [block.mean() for block in np.array_split(values, BLOCKS) if len(block)]
    return np.mean(values), np.std(means, ddof=1) / len(means) ** 0.5 if len(means) > 1 else np.nan


def draw(runs, threshold, path):
    """Draw the RMSD at the lowest temperature of each run against CPU time."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(len(runs), sharex=True, sharey=True, figsize=(8, 1 + 1.6 * len(runs)), squeeze=False)
    for axis, run in zip(axes[:, 0], runs, strict=True):
        folded = run.rmsd[0] <= threshold
        share, error = meanOfBlocks(folded[len(folded) // 2 :])
        axis.plot(run.hours[0], run.rmsd[0], ".", markersize=2, color="tab:blue")
        axis.axhline(threshold, color="black", linewidth=0.8)
        axis.set_title(f"{run.name}: folded in the second half {share:.2f} ± {error:.2f}", fontsize=10, loc="left")
        axis.set_ylabel("RMSD, nm")
        axis.set_ylim(0, None)
    axes[-1, 0].set_xlabel(f"CPU time, h (frames at {runs[0].temperatures[0]:.0f} K)")
    figure.tight_layout()
    figure.savefig(path, dpi=110)


# ---- Options ----


def readRange(text):
    first, last = text.split("-")
    return int(first), int(last)


def parse(arguments):
    """Return the options; `others` holds the options of `sample`."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    actions = parser.add_subparsers(required=True, metavar="start, run or report")

    action = actions.add_parser("start", help="write a structure from which runs start")
    action.set_defaults(action=writeStart)
    action.add_argument("structure", help="a PDB file")
    action.add_argument("output", help="the PDB file to write")
    action.add_argument("--extended", action="store_true", help="unfold the chain")

    action = actions.add_parser("run", help="run, resume or extend")
    action.set_defaults(action=run)
    action.add_argument("structure", help="the start, a PDB file with hydrogens")
    action.add_argument("prefix", help="of the names of all output files")
    action.add_argument("--seed", type=int, default=1)
    action.add_argument("--forcefield", nargs="+", default=FORCE_FIELD)
    action.add_argument("--temperatures", default=TEMPERATURES)
    action.add_argument("--rigid", action="store_true", help="keep bond lengths and angles")
    action.add_argument("--trials", type=int, default=TRIALS, help="of each replica")
    action.add_argument("--frames", type=int, default=FRAMES, help="of each replica")

    action = actions.add_parser("report", help="compare runs with the native structure")
    action.set_defaults(action=report)
    action.add_argument("structure", help="the native structure, a PDB file")
    action.add_argument("prefixes", nargs="+", metavar="prefix")
    action.add_argument("--threshold", type=float, default=0.15, help="nm; default: %(default)s")
    action.add_argument("--residues", type=readRange, metavar="FIRST-LAST", help="compare only these")
    action.add_argument("--hours", type=float, default=np.inf, help="ignore frames after this CPU time")
    action.add_argument("--picture", help="a PNG file to write")

    options, others = parser.parse_known_args(arguments)
    options.others = others
    if others and options.action is not run:
        parser.error(f"unknown options: {' '.join(others)}")
    return options


def main(arguments=None):
    options = parse(arguments)
    return options.action(options)


if __name__ == "__main__":
    sys.exit(main())
