"""The command openmm-chaintree clashes."""

import os
from contextlib import closing, contextmanager

from ..errors import ClusterError, InputError
from ..radii import RADII_SETS
from ..structures.clashsearch import ClashSearch
from ..structures.limits import Limit
from .arguments import addPeriodic, addScheduler, addStructure, checkWorkers, listOf, numberIn, positive, positiveUpTo
from .clashscores import isScoring, runScores
from .outputs.outputfiles import Writing, addOverwrite, asJSONWith, checkOutputs, checkPicture
from .pictures import savePicture
from .reports.clashranking import ClashRanking
from .reports.clashreport import asCSV, plainFrames, printReport, summarize
from .reports.noteoutput import addNotes, asText
from .terminal import BAD_INPUT, ReportConsole, interruptFlag, ofSignal, printError, progress

_PROCESSES = Limit("CHAINTREE_MAX_PROCESSES", max(64, 4 * (os.cpu_count() or 1)))


def addArguments(clashes):
    """Describe the command and its arguments to a parser."""
    clashes.description = (
        "Find atoms that overlap by more than 0.04 nm (0.1 nm where one may donate a hydrogen bond to the other) and "
        "are more than three bonds apart, in all models of a structure or all frames of a trajectory. Models, frames "
        "and particles are numbered from 0. Water, free ions and alternate conformers of lower occupancy are omitted. "
        "Molecules split over a periodic box are made whole. Periodic images count with --periodic, copies in a "
        "crystal with --symmetry; otherwise a note says so. The file name - stands for standard output; the report "
        "then goes to standard error."
    )
    clashes.set_defaults(run=_run)
    addStructure(clashes)
    clashes.add_argument(
        "trajectory",
        nargs="?",
        help="a DCD, XTC, TRR, NetCDF or HDF5 (MDTraj) file with the structure's atoms, used instead of its models",
    )
    clashes.add_argument("--water", action="store_true", help="include water")
    clashes.add_argument("--ions", action="store_true", help="include ions")
    copies = clashes.add_mutually_exclusive_group()
    addPeriodic(copies, "of each frame, or else of the structure")
    copies.add_argument(
        "--symmetry",
        action="store_true",
        help="let the copies in a crystal count, by the space group and cell of the structure",
    )
    clashes.add_argument(
        "--radii",
        choices=RADII_SETS,
        help="the set of radii (default: all-atom for molecules that include their hydrogens, united-atom for others)",
    )
    clashes.add_argument(
        "--rows", type=positive, default=10, metavar="N", help="maximum number of rows per table (default: %(default)s)"
    )
    clashes.add_argument("--csv", metavar="FILE", help="write a line of CSV for every clash (-: print them)")
    clashes.add_argument("--json", metavar="FILE", help="write everything as JSON (-: print it)")
    clashes.add_argument(
        "--picture",
        metavar="FILE",
        help="draw the clashes by frame and residue; with --definition those of a single model by pairs of residues "
        "(.png, .pdf or .svg)",
    )
    clashes.add_argument(
        "--workers",
        type=positiveUpTo(_PROCESSES),
        metavar="W",
        help="number of processes that search frames in parallel (default: 1)",
    )
    addScheduler(clashes, "the search, which needs the same file names on every machine,")
    _addScores(clashes)
    addOverwrite(clashes)
    addNotes(clashes)


def _addScores(clashes):
    scores = clashes.add_argument_group("scores by other definitions")
    scores.add_argument(
        "--definition",
        type=listOf(("own", "molprobity", "af3", "posebusters")),
        action="extend",
        metavar="NAME,…",
        help="score by one or more definitions: own; molprobity, the clashscore with the hydrogens of Reduce and the "
        "contacts of Probe; af3, AlphaFold 3's has_clash; posebusters, PoseBusters' checks of distance and volume, "
        "which need the package rdkit. CSV then has a line for each model (default: own)",
    )
    scores.add_argument(
        "--keep-hydrogens", action="store_true", help="score the hydrogens of the file, and place none (molprobity)"
    )
    scores.add_argument(
        "--flips",
        action="store_true",
        help="flip side chains of Asn, Gln and His first, where hydrogens fit clearly better (molprobity)",
    )
    scores.add_argument(
        "--fail-above",
        type=numberIn(0, 1e6),
        metavar="SCORE",
        help="end with exit status 1 if a clashscore is above this (molprobity)",
    )
    scores.add_argument(
        "--script",
        metavar="FILE",
        help="write a script that shows the clashes of the first model in PyMOL (.pml) or ChimeraX (.cxc)",
    )
    scores.add_argument(
        "--models",
        metavar="FOLDER",
        help="score all structure files of a folder; a file that cannot be read is named, and does not stop the others",
    )


def _run(options):
    if isScoring(options):
        return runScores(options)
    checkWorkers(options)
    names = {"csv": options.csv, "json": options.json, "picture": options.picture, "notes": options.notes}
    inputs = [path for path in (options.structure, options.trajectory) if path is not None]
    outputs = checkOutputs(names, inputs, options.overwrite)
    if "picture" in outputs:
        checkPicture(outputs["picture"])
    choices = (options.radii, options.water, options.ions, options.periodic, options.symmetry)
    arguments = (options.structure, options.trajectory, *choices)
    with _startWorkers(options, arguments) as (searchFrames, stop):
        search = ClashSearch(*arguments)
        ranking = ClashRanking(search.finder.names)
        frames, damage, interrupted = _findAll(search, searchFrames, stop, ranking)
    if interrupted and not frames:
        printError("interrupted before any frame was looked at")
        return ofSignal(interrupted.number)
    if damage is not None and not frames:
        raise damage
    summary = summarize(search, frames, ranking, damage, bool(interrupted))
    writers = {
        "csv": lambda output: output.write(asCSV(search, frames)),
        "json": lambda output: output.write(asJSONWith(summary, "frames", plainFrames(search, frames))),
        "picture": lambda output: savePicture("clashpicture", output, search, frames),
        "notes": lambda output: output.write(asText(search.notes)),
    }
    with Writing() as writing:
        for kind, output in outputs.items():
            writing.write(output, writers[kind])
    printReport(summary, search, frames, writing.files, options.rows, ReportConsole(outputs.values()), options.verbose)
    errors = [writing.describeFailures()] if writing.failures else []
    if damage is not None:
        errors.append(f"{damage}; the results cover the frames before it")
    if errors:
        printError("; ".join(errors))
        return BAD_INPUT
    return ofSignal(interrupted.number) if interrupted else 0


def _findAll(search, searchFrames, stop, ranking):
    """Return the list of FrameOverlaps up to a damaged frame or an interrupt; the error of that frame; Interrupts.

    They come from searchFrames(search), which stop() ends. A ClashRanking counts them while workers search others.
    """
    frames = []
    damage = None
    with interruptFlag(stop) as interrupted, progress(search.frameCount) as advance:
        try:
            with closing(searchFrames(search)) as found:
                for frame in found:
                    frames.append(frame)
                    ranking.add(frame)
                    advance(len(frames))
                    if interrupted:
                        break
        except ClusterError:
            raise
        except InputError as error:
            damage = error
        finally:
            search.noteBoxes()
            search.close()
        return frames, damage, interrupted


@contextmanager
def _startWorkers(options, arguments):
    """Start the workers chosen by the options. Yields two functions: one yields the FrameOverlaps of a ClashSearch, the
    other stops the workers, for a signal handler.

    arguments are those of the ClashSearch, which can be made while the workers start.
    """
    if options.scheduler is None and options.workers in (None, 1):
        yield ClashSearch.overlaps, _doNothing
        return
    from ..structures import clashchunks

    try:
        files = clashchunks.describeFiles(*arguments)
    except OSError:
        yield ClashSearch.overlaps, _doNothing  # the search itself says what is missing
        return
    if options.scheduler is None:
        workers = clashchunks.ProcessChunks(options.workers, files)
    else:
        from ..replicas.cluster import Cluster  # Dask takes long to import

        workers = clashchunks.ClusterChunks(Cluster(options.scheduler))

    stop = clashchunks.ChunkStop()

    def searchFrames(search):
        with closing(workers):
            yield from clashchunks.searchInChunks(search, files, workers, stop)

    with closing(workers):
        yield searchFrames, stop.call


def _doNothing():
    """Stop nobody."""
