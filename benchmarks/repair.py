"""Compare repairStructure with OpenMM's minimizer on models with clashes: clashscore, shift, bonds and time.

    python benchmarks/repair.py MODELS... --minimizers vacuum restrained --csv repair.csv --markdown repair.md

Minimizers use AMBER14: `vacuum` and `gbn2` are free; `restrained`, in vacuum, has AlphaFold's springs on heavy atoms
(10 kcal/mol/Å²). Missing atoms and hydrogens are added by PDBFixer. Clashscores are MolProbity's, as the package counts
them, with hydrogens placed as by Reduce. Times are CPU times of one process, without reading.
"""

import argparse
import csv
import io
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
import openmm
import pdbfixer
from openmm import app, unit
from openmmchaintree import repairStructure
from openmmchaintree.bonds import BondGraph
from openmmchaintree.repairs.model import scoreStructure
from openmmchaintree.residues import polymerBackbone
from openmmchaintree.structures.structure import readModels

MINIMIZERS = ("vacuum", "gbn2", "restrained")
REPAIR, MENDED = "repair", "repair, bonds mended"
_STIFFNESS = 10 * 418.4  # kJ/mol/nm²
_TOLERANCE = 2.39  # kJ/mol, as AlphaFold's relaxation has it, here for each nanometer


class Result(NamedTuple):
    """A row of the table. Lengths are in nm, seconds of one core; `failure` is empty if there is none."""

    model: str
    atoms: int
    method: str
    before: float
    after: float
    traceRms: float
    traceLargest: float
    largestBondChange: float
    seconds: float
    failure: str


def measureRepair(name, topology, positions, mendsBonds, seed):
    """Return the Result of repairStructure."""
    begin = time.process_time()
    result = repairStructure(topology, positions, mendsBonds=mendsBonds, seed=seed)
    seconds = time.process_time() - begin
    method = MENDED if mendsBonds else REPAIR
    return _describe(name, topology, method, positions, result.positions, seconds)


def measureMinimizer(name, path, topology, positions, method):
    """Return the Result of OpenMM's minimizer; an error of the minimizer becomes its failure."""
    begin = time.process_time()
    try:
        minimized = _minimize(path, topology, positions, method)
    except Exception as error:
        reason = str(error).splitlines()[0]
        nothing = float("nan")
        before = scoreStructure(topology, positions)[0].score
        seconds = time.process_time() - begin
        return Result(name, len(positions), method, before, *4 * [nothing], seconds, reason)
    return _describe(name, topology, method, positions, minimized, time.process_time() - begin)


def _minimize(path, topology, positions, method):
    """Return the minimized positions (nm) of the atoms of a Topology."""
    fixer = pdbfixer.PDBFixer(filename=str(path))
    fixer.missingResidues = {}
    fixer.findMissingAtoms()
    fixer.addMissingAtoms(seed=1)
    fixer.addMissingHydrogens(7.0)
    solvent = ["implicit/gbn2.xml"] if method == "gbn2" else []
    system = app.ForceField("amber14-all.xml", *solvent).createSystem(fixer.topology)
    start = np.array(fixer.positions.value_in_unit(unit.nanometer))
    if method == "restrained":
        springs = openmm.CustomExternalForce(f"0.5*{_STIFFNESS}*((x-x0)^2+(y-y0)^2+(z-z0)^2)")
        for axis in ("x0", "y0", "z0"):
            springs.addPerParticleParameter(axis)
        for atom in fixer.topology.atoms():
            if atom.element is not app.element.hydrogen:
                springs.addParticle(atom.index, start[atom.index])
        system.addForce(springs)
    platform = openmm.Platform.getPlatformByName("CPU")
    context = openmm.Context(system, openmm.VerletIntegrator(0.001), platform, {"Threads": "1"})
    context.setPositions(start)
    openmm.LocalEnergyMinimizer.minimize(context, _TOLERANCE)
    ended = context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)
    # The fixer keeps the order of residues.
    places = {}
    for residue, own in zip(fixer.topology.residues(), topology.residues(), strict=True):
        places |= {(own.index, atom.name): ended[atom.index] for atom in residue.atoms()}
    names = [(atom.residue.index, atom.name) for atom in topology.atoms()]
    return np.array([places.get(key, positions[number]) for number, key in enumerate(names)])


def _describe(name, topology, method, before, after, seconds):
    """Return the Result of positions (nm) before and after."""
    scores = [scoreStructure(topology, place)[0].score for place in (before, after)]
    shifts = np.linalg.norm(after - before, axis=1)
    traces = [atom for atom in topology.atoms() if atom.name in ("CA", "P") and polymerBackbone(atom.residue)]
    trace = shifts[[atom.index for atom in traces]]
    graph = BondGraph(topology, before)
    first, second = np.array([pair for pair in graph.bonds if (graph.numbers[list(pair)] > 1).all()]).T
    lengths = [np.linalg.norm(place[first] - place[second], axis=1) for place in (before, after)]
    change = float(np.abs(lengths[1] - lengths[0]).max())
    rms = float(np.sqrt((trace**2).mean()))
    return Result(name, len(before), method, *scores, rms, float(trace.max()), change, seconds, "")


def asMarkdown(results):
    """Return the results as a table."""
    lines = [
        "| model | atoms | method | clashscore | Cα or P rms / largest, nm | largest change of a bond, nm | s |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in results:
        numbers = f"{row.traceRms:.3f} / {row.traceLargest:.2f} | {row.largestBondChange:.1g}"
        if row.failure:
            numbers = f"{row.failure} |"
        after = "–" if row.failure else f"{row.after:.1f}"
        cells = f"| {row.model} | {row.atoms:,} | {row.method} | {row.before:.1f} → {after} | {numbers} |"
        lines.append(f"{cells} {row.seconds:.1f} |")
    return "\n".join([*lines, ""])


def asCSV(results):
    """Return the results as CSV."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerows([Result._fields, *results])
    return text.getvalue()


def main(arguments=None):
    """Run the script; return its exit status."""
    parser = argparse.ArgumentParser("repair.py", description=__doc__.splitlines()[0])
    parser.add_argument("models", nargs="+", help="PDB or mmCIF files")
    parser.add_argument("--minimizers", nargs="*", choices=MINIMIZERS, default=[], help="of OpenMM (default: none)")
    parser.add_argument("--mend-bonds", action="store_true", help="repair with --mend-bonds as well")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--csv", type=Path)
    parser.add_argument("--markdown", type=Path)
    options = parser.parse_args(arguments)
    results = []
    for path in map(Path, options.models):
        name = path.name.partition(".")[0]
        models = readModels(path, 0)
        topology, positions = models.topology, models.positions[0]
        for mends in (False, True) if options.mend_bonds else (False,):
            results.append(measureRepair(name, topology, positions, mends, options.seed))
        for method in options.minimizers:
            results.append(measureMinimizer(name, path, topology, positions, method))
        print(asMarkdown(results).splitlines()[-1], flush=True)
        for output, text in ((options.csv, asCSV(results)), (options.markdown, asMarkdown(results))):
            if output is not None:
                output.write_text(text, encoding="utf-8")
    print(asMarkdown(results))
    return 0


if __name__ == "__main__":
    sys.exit(main())
