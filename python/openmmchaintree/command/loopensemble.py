"""Loops in the command ensemble: options, the run, and its files."""

import csv
import io
import random
from pathlib import Path

import numpy as np

from ..ensembles.sequencefiles import isSequenceFile
from ..errors import InputError
from ..loops import annealLoop, sampleLoop
from ..structures.structure import readStructure
from .arguments import positive, refuseWithout
from .energymodel import EnergyModel
from .ensembleatoms import ALL_ATOM_OPTIONS
from .ensemblejob import asDCD, asPDB
from .ensemblejobs import stemOf
from .outputs.output import Output
from .outputs.outputfiles import asJSON
from .preparing.preparation import prepareStructure
from .reports.noteoutput import asPlain, printNotes
from .terminal import ReportConsole

_ENDS = (".dcd", "-topology.pdb", ".csv", ".json")
CONFORMERS_OF_LOOPS = 100
_TOO_FEW = 3  # exit status: the weights hold too few independent conformers
_TRIALS = {False: 5000, True: 50000}  # of each conformer, without and with a force field
_OPTIONS = ("forcefield", "prepare", "trials", "max_grown")
_OTHERS = ("domains", *ALL_ATOM_OPTIONS, "resume", "scheduler")


def addLoops(parser):
    """Describe the options of loops to a parser."""
    group = parser.add_argument_group("loops")
    group.add_argument(
        "--loop",
        metavar="LOOP",
        help="sample a loop of a structure, such as A:63-74, whose ends stay in place as everything else does: each "
        "conformer is grown independently and closed exactly; with --model coil or --forcefield",
    )
    group.add_argument(
        "--forcefield",
        nargs="+",
        metavar="XML",
        help="anneal the grown loops in a force field: files for OpenMM's ForceField, such as amber14-all.xml "
        "implicit/gbn2.xml; conformers are local minima of each start",
    )
    group.add_argument(
        "--prepare", action="store_true", help="in a force field, first complete the structure as sample --prepare does"
    )
    group.add_argument(
        "--trials",
        type=positive,
        metavar="N",
        help=f"trials from each grown loop to its conformer (default: {_TRIALS[False]:,}; in a force field "
        f"{_TRIALS[True]:,})",
    )
    group.add_argument(
        "--max-grown",
        type=positive,
        metavar="N",
        help="the largest number of loops to grow (default: 30 for each conformer)",
    )


def checkNoLoop(options):
    """Refuse options of loops without a loop."""
    refuseWithout(options, "--loop", *_OPTIONS)


def runLoop(options):
    """Sample the loop of the options; return the exit status."""
    _check(options)
    stem = stemOf(options.source)
    folder = Path(options.output or f"{stem}-ensemble")
    outputs = {end: Output(str(folder / f"{stem}{end}"), overwrite=True) for end in _ENDS}
    existing = next((output.path for output in outputs.values() if output.path.exists()), None)
    if existing and not options.overwrite:
        raise InputError(f"{existing}: exists; --overwrite replaces it")
    extra = [Output(options.json, options.overwrite)] if options.json else []
    for output in extra:
        output.check()
    console = ReportConsole(extra)
    seed = options.seed or random.SystemRandom().randrange(1, 2**31 - 1)
    structure = readStructure(options.source)
    printNotes(asPlain(structure.notes), console, False)
    console.print(f"Growing loops of {options.loop}; files are written at the end")
    found, summary = (_anneal if options.forcefield else _sample)(options, structure, seed, console)
    summary = {"name": stem, "loop": options.loop, **summary, "seed": seed, "notes": asPlain(structure.notes)}
    folder.mkdir(parents=True, exist_ok=True)
    outputs[".dcd"].write(asDCD(found))
    outputs["-topology.pdb"].write(asPDB(found))
    outputs[".csv"].write(_asCSV(found))
    outputs[".json"].write(asJSON(summary))
    for output in extra:
        output.write(asJSON(summary))
    console.print(f"Wrote {len(found.positions):,} conformers to {folder}")
    return 0 if summary["isComplete"] else _TOO_FEW


def _check(options):
    given = [name for name in _OTHERS if getattr(options, name) not in (None, False, [])]
    if given:
        raise InputError(f"--{given[0].replace('_', '-')} cannot be used with --loop")
    if isSequenceFile(options.source):
        raise InputError("--loop needs a structure, not sequences")
    if options.forcefield:
        if options.model == "coil":
            raise InputError("--model and --forcefield cannot be used together: each defines the energy")
        refuseWithout(options, "--model coil", "max_grown")
    else:
        if options.model != "coil":
            raise InputError("--loop needs --model coil or --forcefield")
        refuseWithout(options, "--forcefield", "prepare")


def _sample(options, structure, seed, console):
    """Sample with hard spheres and the density of random coils; return a LoopEnsemble and its summary."""
    found = sampleLoop(
        structure.topology,
        structure.positions,
        options.loop,
        options.model,
        options.conformers or CONFORMERS_OF_LOOPS,
        seed,
        options.temperature,
        options.trials or _TRIALS[False],
        options.max_grown,
    )
    parents = len(set(found.parents.tolist()))
    console.print(
        f"Grew {found.grown:,} closed loops without clashes in {found.runs:,} attempts; their weights are worth "
        f"{found.effectiveSampleSize:.1f} independent conformers of the ensemble"
    )
    console.print(f"Sampled {len(found.positions):,} conformers from {parents:,} of them, in {_basins(found)}")
    console.print(
        f"RMSD from the given loop: {found.distances.mean():.3f} nm on average, {found.distances.min():.3f} at least"
    )
    if not found.isComplete:
        console.print("These are too few for the requested conformers: grow more with --max-grown")
    return found, {
        "model": options.model,
        **_common(found),
        "effectiveSampleSize": round(found.effectiveSampleSize, 1),
        "parents": parents,
        "isComplete": found.isComplete,
    }


def _anneal(options, structure, seed, console):
    """Anneal in a force field; return AnnealedLoops and their summary."""
    model = EnergyModel(options.forcefield, options.temperature, isPrepared=options.prepare)
    if options.prepare:
        structure, _ = prepareStructure(structure, model, options.ph, seed)
    system, notes = model.makeSystem(structure)
    printNotes(asPlain(notes), console, False)
    found = annealLoop(
        structure.topology,
        structure.positions,
        options.loop,
        system,
        options.conformers or CONFORMERS_OF_LOOPS,
        seed,
        options.temperature,
        trials=options.trials or _TRIALS[True],
    )
    best = int(np.argmin(found.energies))
    console.print(f"Annealed {found.grown:,} grown loops, in {_basins(found)}")
    difference = found.energies[best] - found.native[1]
    console.print(
        f"Lowest energy: {difference:+.1f} kJ/mol from that of the given loop after the same trials; RMSD from the "
        f"given loop {found.distances[best]:.3f} nm, of the other {found.native[2]:.3f} nm"
    )
    return found, {
        "forcefield": options.forcefield,
        **_common(found),
        "lowestEnergy": float(found.energies[best]),
        "lowestDistance": float(found.distances[best]),
        "givenEnergy": found.native[1],
        "givenDistance": found.native[2],
        "isComplete": True,
    }


def _basins(found):
    count = int(found.basins.max()) + 1
    return f"{count:,} basin{'s' if count > 1 else ''} (N, CA, C and O within 0.1 nm, without superposition)"


def _common(found):
    return {
        "conformers": len(found.positions),
        "grown": found.grown,
        "attempts": found.runs,
        "basins": int(found.basins.max()) + 1,
        "meanDistance": float(found.distances.mean()),
        "leastDistance": float(found.distances.min()),
    }


def _asCSV(found):
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["conformer", "energy (kJ/mol)", "RMSD (nm)", "basin", "grown loop"])
    parents = getattr(found, "parents", np.arange(len(found.positions)))
    for index, row in enumerate(zip(found.energies, found.distances, found.basins, parents, strict=True)):
        writer.writerow([index, f"{row[0]:.4f}", f"{row[1]:.6f}", int(row[2]), int(row[3])])
    return text.getvalue()
