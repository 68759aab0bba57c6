"""The command openmm-chaintree ensemble."""

import csv
import io
import json
import os
import random
import re
import signal
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path
from queue import SimpleQueue

from ..calvados import MODELS
from ..ensembles.sequencefiles import isSequenceFile, readSequences
from ..errors import ClusterError, InputError
from .arguments import addScheduler, checkWorkers, notNegative, numberIn, positive, seed, usableCores
from .ensemblejob import EnsembleJob, runJob
from .outputs.output import Output
from .outputs.outputfiles import addOverwrite, asJSON
from .terminal import BAD_INPUT, ReportConsole, interruptFlag, ofSignal, printError

_MOST_PICTURES = 20  # drawn without being asked for: each takes as long as hundreds of conformers
_FILES = (".dcd", "-topology.pdb", ".csv", ".png", ".json")
_JOBS_AHEAD = 2  # for each worker
_TOO_FEW = 3  # exit status: a protein ended before it had all conformers


def addArguments(parser):
    """Describe the command and its arguments to a parser."""
    parser.description = (
        "Sample independent conformers of disordered proteins, and of proteins with folded domains, with a bead for "
        "each residue. For each protein, the folder of results gets a trajectory (NAME.dcd), its topology "
        "(NAME-topology.pdb), shapes by conformer (NAME.csv), averages (NAME.json) and a picture of radii of gyration, "
        "distances and contacts (NAME.png); summary.csv has a row for each protein."
    )
    parser.set_defaults(run=_run)
    parser.add_argument(
        "source",
        help="a FASTA file with one sequence or many (B is phosphoserine, O phosphothreonine), or the structure of a "
        "protein without gaps (PDB, mmCIF or BinaryCIF)",
    )
    parser.add_argument("--model", choices=MODELS, default="calvados2", help="the energies (default: %(default)s)")
    parser.add_argument(
        "--domains",
        metavar="RANGES",
        help="in a structure, folded domains that stay rigid, by residue numbers: 1-72,77-148 are two, A:5-60+A:90-120 "
        "is one of two segments (default: none)",
    )
    parser.add_argument(
        "--conformers", type=positive, default=1000, metavar="N", help="independent conformers (default: %(default)s)"
    )
    parser.add_argument(
        "--temperature", type=numberIn(1, 1000), default=298.0, metavar="K", help="in K (default: %(default)g)"
    )
    parser.add_argument("--ph", type=numberIn(0, 14), default=7.0, metavar="PH", help="the pH (default: %(default)g)")
    parser.add_argument(
        "--ionic", type=numberIn(1e-4, 10), default=0.15, metavar="MOLAR", help="the ionic strength (default: 0.15)"
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


def _run(options):
    checkWorkers(options)
    jobs = _makeJobs(options)
    folder = Path(options.output or f"{_stem(options.source)}-ensemble")
    done = _findDone(folder, jobs, options)
    folder.mkdir(parents=True, exist_ok=True)
    outputs = [Output(str(folder / "summary.csv"), overwrite=True)]
    if options.json:
        outputs.append(Output(options.json, options.overwrite or options.resume))
        outputs[-1].check()
    console = ReportConsole(outputs)
    summaries, failures, interrupted = dict(done), [], None
    console.print(_heading())
    arrived, left = SimpleQueue(), [job for job in jobs if job.name not in done]
    with interruptFlag(lambda: arrived.put(None)) as interrupts, _workers(options, len(left)) as (submit, count):
        for job, result in _results(left, submit, count, arrived):
            if isinstance(result, InputError):
                failures.append(f"{job.name}: {result}")
                console.print(f"{job.name}: {result}")
                continue
            _writeFiles(folder, job, result)
            summaries[job.name] = result.summary
            console.print(_row(result.summary))
        interrupted = interrupts.number if interrupts else None
    ordered = [summaries[job.name] for job in jobs if job.name in summaries]
    outputs[0].write(_asCSV(ordered))
    if options.json:
        outputs[1].write(asJSON({"proteins": ordered}))
    console.print(f"\nWrote {len(ordered):,} of {len(jobs):,} proteins to {folder}")
    if interrupted:
        printError(f"interrupted; --resume -o {folder} samples the other proteins")
        return ofSignal(interrupted)
    if failures:
        printError(f"{len(failures):,} of {len(jobs):,} proteins failed; the first: {failures[0]}")
        return BAD_INPUT
    return 0 if all(one["isComplete"] for one in ordered) else _TOO_FEW


# ---- What is sampled ----


def _makeJobs(options):
    """Return the list of EnsembleJob of the source."""
    settings = {
        "model": options.model,
        "conformers": options.conformers,
        "temperature": options.temperature,
        "pH": options.ph,
        "ionicStrength": options.ionic,
        "maxTrials": options.max_trials,
        "domains": options.domains,
    }
    first = options.seed or random.SystemRandom().randrange(1, 2**30)
    if isSequenceFile(options.source):
        if options.domains:
            raise InputError("--domains needs a structure, not sequences")
        sequences = readSequences(options.source)
        names = _fileNames([each.name for each in sequences])
        sources = [(each.letters, None) for each in sequences]
    else:
        names, sources = [_stem(options.source)], [(None, os.path.abspath(options.source))]
    return [
        EnsembleJob(
            name, *source, {**settings, "seed": (first + index - 1) % (2**31 - 1) + 1}, index < options.pictures
        )
        for index, (name, source) in enumerate(zip(names, sources, strict=True))
    ]


def _stem(path):
    """Return the name of a file without its suffixes."""
    return re.sub(r"(\.[^.]*)?(\.(gz|bz2|xz|zst))?$", "", Path(path).name, flags=re.IGNORECASE) or "ensemble"


def _fileNames(names):
    """Return a file's name for each name, all different."""
    used, found = set(), []
    for name in names:
        plain = re.sub(r"[^\w.+-]", "_", name).lstrip(".-")[:100] or "sequence"
        number, unique = 1, plain
        while unique.lower() in used:  # some file systems do not tell cases apart
            number += 1
            unique = f"{plain}-{number}"
        used.add(unique.lower())
        found.append(unique)
    return found


def _findDone(folder, jobs, options):
    """Return the summaries of proteins that the folder has, by name, if the run resumes another.

    Raises
    ------
    InputError
        if files exist that may not be replaced, or that another run with other settings has made
    """
    if not options.resume:
        existing = [folder / "summary.csv", *(folder / f"{job.name}{end}" for job in jobs for end in _FILES)]
        found = next((path for path in existing if path.exists()), None)
        if found and not options.overwrite:
            raise InputError(f"{found}: exists; --resume keeps finished proteins, --overwrite replaces all")
        return {}
    if not folder.is_dir():
        raise InputError(f"{folder}: is no folder with the results of a run to resume")
    done = {}
    for job in jobs:
        path = folder / f"{job.name}.json"
        if not path.exists():
            continue
        try:
            summary = json.loads(path.read_text(encoding="utf-8"))
            former = {**summary["settings"], "seed": None}
        except (OSError, ValueError, TypeError, KeyError) as error:
            raise InputError(f"{path}: cannot be read as a protein's averages ({error}); remove it") from error
        for name, value in {**job.settings, "seed": None}.items():
            if former.get(name) != value:
                raise InputError(f"{path}: was made with {name} {former.get(name)}, not {value}")
        done[job.name] = summary
    return done


# ---- Work ----


@contextmanager
def _workers(options, count):
    """Start workers; yield a function that submits a job to them and returns its future, and their number."""
    if options.scheduler is not None:
        from ..replicas.cluster import Cluster  # Dask takes long to import

        cluster = Cluster(options.scheduler)
        try:
            yield lambda job: cluster.submit(runJob, job), cluster.countThreads()
        finally:
            cluster.close()
        return
    number = max(1, min(options.workers or usableCores(), count))
    pool = ProcessPoolExecutor(number, get_context("spawn"), _ignoreInterrupts)
    try:
        yield lambda job: pool.submit(runJob, job), number
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for process in list((pool._processes or {}).values()):
            process.terminate()


def _ignoreInterrupts():
    """Leave Ctrl-C to the parent process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _results(jobs, submit, count, arrived):
    """Yield each job with its EnsembleResult, or the InputError of its protein, as they come.

    arrived : SimpleQueue of (job, future), which ends the work if it holds None
    """
    left, running = iter(jobs), 0
    while True:
        while running < _JOBS_AHEAD * count and (job := next(left, None)) is not None:
            submit(job).add_done_callback(lambda future, job=job: arrived.put((job, future)))
            running += 1
        if running == 0 or (found := arrived.get()) is None:
            return
        running -= 1
        job, future = found
        try:
            yield job, future.result()
        except ClusterError:
            raise
        except BrokenProcessPool as error:
            raise ClusterError(
                "a process was ended from outside; --resume samples the proteins that are missing"
            ) from error
        except InputError as error:
            yield job, error


# ---- Results ----


def _writeFiles(folder, job, result):
    """Write the files of a protein; the averages are the last, so a protein that has them is complete."""
    for end, content in {**result.files, ".json": asJSON(result.summary)}.items():
        Output(str(folder / f"{job.name}{end}"), overwrite=True).write(content)


_COLUMNS = ("protein", "residues", "conformers", "Rg (nm)", "ends (nm)", "ν")


def _heading():
    return f"{_COLUMNS[0]:24} {_COLUMNS[1]:>8} {_COLUMNS[2]:>10} {_COLUMNS[3]:>15} {_COLUMNS[4]:>15} {_COLUMNS[5]:>13}"


def _row(summary):
    """Return a line for a protein that is finished."""
    shown = f"{summary['name'][:24]:24} {summary['residues']:8,} {summary['conformers']:10,}"
    for name in ("radius of gyration", "end-to-end distance"):
        one = summary["estimates"][name]
        shown += f" {_withError(one['mean'], one['standardError'], 3):>15}"
    shown += f" {_withError(summary['scalingExponent'], summary['scalingExponentError'], 3):>13}"
    if not summary["isComplete"]:
        shown += f"  only {summary['effectiveSampleSize']:.0f} are independent"
    return shown


def _withError(mean, error, digits):
    if mean is None:
        return "–"
    return f"{mean:.{digits}f}" if error is None else f"{mean:.{digits}f} ± {error:.{digits}f}"


def _asCSV(summaries):
    """Return the table of all proteins."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    names = ("radius of gyration", "end-to-end distance", "asphericity")
    headings = [f"{name}{word}" for name in names for word in ("", " error")]
    writer.writerow(
        [
            "protein",
            "residues",
            "conformers",
            "effective sample size",
            *headings,
            "scaling exponent",
            "scaling exponent error",
        ]
    )
    for one in summaries:
        values = [one["estimates"][name][kind] for name in names for kind in ("mean", "standardError")]
        values += [one["scalingExponent"], one["scalingExponentError"]]
        described = ["" if value is None else f"{value:.6g}" for value in values]
        writer.writerow([one["name"], one["residues"], one["conformers"], one["effectiveSampleSize"], *described])
    return text.getvalue()
