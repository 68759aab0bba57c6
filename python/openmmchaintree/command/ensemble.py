"""The command openmm-chaintree ensemble."""

from pathlib import Path
from queue import SimpleQueue

from ..ensemble import MODELS
from ..errors import InputError
from .arguments import addScheduler, checkWorkers, notNegative, numberIn, positive, seed
from .ensembleatoms import addAllAtoms
from .ensemblejobs import findDone, makeJobs, stemOf
from .ensembleworkers import results, workers
from .loopensemble import CONFORMERS_OF_LOOPS, addLoops, checkNoLoop, runLoop
from .outputs.output import Output
from .outputs.outputfiles import addOverwrite, asJSON
from .reports.ensemblereport import asCSV, heading, rowOf, writeFiles
from .reports.noteoutput import printNotes
from .terminal import BAD_INPUT, ReportConsole, interruptFlag, ofSignal, printError

_MOST_PICTURES = 20  # drawn without being asked for: each takes as long as hundreds of conformers
_CONFORMERS = 1000
_TOO_FEW = 3  # exit status: a protein ended before it had all conformers


def addArguments(parser):
    """Describe the command and its arguments to a parser."""
    parser.description = (
        "Sample independent conformers of disordered proteins, and of proteins with folded domains, with a bead for "
        "each residue; of tails, linkers and chains as random coils of all atoms; or of a loop between fixed ends. For "
        "each protein, the folder of results gets a trajectory (NAME.dcd), its topology (NAME-topology.pdb), shapes by "
        "conformer (NAME.csv), averages (NAME.json) and a picture of radii of gyration, distances and contacts "
        "(NAME.png); summary.csv has a row for each protein. A loop has neither picture nor summary.csv."
    )
    parser.set_defaults(run=_run)
    parser.add_argument(
        "source",
        help="a FASTA file with one sequence or many (B is phosphoserine, O phosphothreonine), or the structure of a "
        "protein (PDB, mmCIF or BinaryCIF), without gaps unless --missing builds them",
    )
    parser.add_argument(
        "--model", choices=MODELS, default="calvados2", help="the energies (default: %(default)s); coil: all atoms"
    )
    parser.add_argument(
        "--domains",
        metavar="RANGES",
        help="in a structure, folded domains that stay rigid, by residue numbers: 1-72,77-148 are two, A:5-60+A:90-120 "
        "is one of two segments (default: none)",
    )
    parser.add_argument(
        "--conformers",
        type=positive,
        metavar="N",
        help=f"independent conformers (default: {_CONFORMERS}, of loops {CONFORMERS_OF_LOOPS})",
    )
    parser.add_argument(
        "--temperature", type=numberIn(1, 1000), default=298.0, metavar="K", help="in K (default: %(default)g)"
    )
    parser.add_argument(
        "--ph", type=numberIn(0, 14), default=7.0, metavar="PH", help="the pH (default: %(default)g; beads)"
    )
    parser.add_argument(
        "--ionic",
        type=numberIn(1e-4, 10),
        default=0.15,
        metavar="MOLAR",
        help="the ionic strength (default: 0.15; beads)",
    )
    parser.add_argument("--seed", type=seed, help="random number seed, 1 to 2147483647 (default: a new one each time)")
    parser.add_argument(
        "--max-trials",
        type=positive,
        default=10**9,
        metavar="TRIALS",
        help="end a protein here even if it has too few independent conformers (default: 1,000,000,000)",
    )
    parser.add_argument("-o", "--output", metavar="FOLDER", help="the folder of results (default: SOURCE-ensemble)")
    parser.add_argument(
        "--resume", action="store_true", help="keep proteins that the folder has, and sample the others"
    )
    parser.add_argument(
        "--pictures",
        type=notNegative,
        default=_MOST_PICTURES,
        metavar="N",
        help="draw pictures of the first N proteins (default: %(default)s)",
    )
    parser.add_argument("--json", metavar="FILE", help="write all averages as JSON (-: to standard output)")
    parser.add_argument("--workers", type=positive, metavar="W", help="processes (default: the number of cores)")
    addScheduler(parser, "proteins")
    addOverwrite(parser)
    addAllAtoms(parser)
    addLoops(parser)


def _run(options):
    if options.loop is not None:
        return runLoop(options)
    checkNoLoop(options)
    options.conformers = options.conformers or _CONFORMERS
    checkWorkers(options)
    jobs = makeJobs(options)
    folder = Path(options.output or f"{stemOf(options.source)}-ensemble")
    done = findDone(folder, jobs, options)
    folder.mkdir(parents=True, exist_ok=True)
    outputs = [Output(str(folder / "summary.csv"), overwrite=True)]
    if options.json:
        outputs.append(Output(options.json, options.overwrite or options.resume))
        outputs[-1].check()
    console = ReportConsole(outputs)
    summaries, failures, interrupted = dict(done), [], None
    console.print(heading())
    arrived, left = SimpleQueue(), [job for job in jobs if job.name not in done]
    with interruptFlag(lambda: arrived.put(None)) as interrupts, workers(options, len(left)) as (submit, count):
        for job, result in results(left, submit, count, arrived):
            if isinstance(result, InputError):
                failures.append(f"{job.name}: {result}")
                console.print(f"{job.name}: {result}")
                continue
            writeFiles(folder, job, result)
            summaries[job.name] = result.summary
            printNotes(result.summary["notes"], console, False)
            console.print(rowOf(result.summary))
        interrupted = interrupts.number if interrupts else None
    ordered = [summaries[job.name] for job in jobs if job.name in summaries]
    if ordered:
        outputs[0].write(asCSV(ordered))
    elif not any(folder.iterdir()):
        folder.rmdir()
    if options.json:
        outputs[1].write(asJSON({"proteins": ordered}))
    console.print(f"\nWrote {len(ordered):,} of {len(jobs):,} proteins{f' to {folder}' if ordered else ''}")
    if interrupted:
        printError(f"interrupted; --resume -o {folder} samples the other proteins")
        return ofSignal(interrupted)
    if failures:
        printError(f"{len(failures):,} of {len(jobs):,} proteins failed; the first: {failures[0]}")
        return BAD_INPUT
    return 0 if all(one["isComplete"] for one in ordered) else _TOO_FEW
