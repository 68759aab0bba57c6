"""The repair of all models of a folder, in parallel, which a later run can resume."""

import csv
import io
import json
from pathlib import Path
from queue import SimpleQueue

from ..errors import InputError
from .arguments import checkWorkers, refuseWithout
from .ensembleworkers import results, workers
from .outputs.output import Output
from .outputs.outputfiles import asJSON
from .repairjob import RepairJob, runRepair
from .reports.repairreport import summarize
from .terminal import BAD_INPUT, ReportConsole, interruptFlag, ofSignal, printable, printError

NOT_CLEAN = 3  # exit status

_SUFFIXES = (".pdb", ".ent", ".pdb1", ".cif", ".mmcif")
_COLUMNS = (
    "clashscoreBefore", "clashscoreAfter", "clashesBefore", "clashesAfter", "traceShiftRms", "traceShiftLargest",
    "heavyAtomShiftRms", "rotamersChanged", "rotamers",
)  # fmt: skip


def repairFolder(options, settings):
    """Repair all PDB and mmCIF files of a folder; return the exit status.

    The folder of results gets the repaired files, under the same names, a JSON file beside each, and summary.csv.
    """
    refuseWithout(options, "one model, not a folder", "csv", "notes")
    checkWorkers(options)
    source = Path(options.structure)
    folder = Path(options.output or f"{source.resolve().name}-repaired")
    if folder.resolve() == source.resolve():
        raise InputError(f"{folder}: repaired files go to another folder than that of the models")
    jobs = [RepairJob(str(path), settings, options.hydrogens) for path in _modelsIn(source)]
    done = _findDone(folder, jobs, options)
    outputs = [Output(str(folder / "summary.csv"), overwrite=True)]
    if options.json:
        outputs.append(Output(options.json, options.overwrite or options.resume))
        outputs[-1].check()
    folder.mkdir(parents=True, exist_ok=True)
    console = ReportConsole(outputs)
    summaries, failures = dict(done), []
    arrived, left = SimpleQueue(), [job for job in jobs if job.path not in done]
    with interruptFlag(lambda: arrived.put(None)) as interrupts, workers(options, len(left), runOne) as (submit, count):
        for job, result in results(left, submit, count, arrived):
            if isinstance(result, InputError):
                failures.append(str(result))
                console.print(f"{result}")
                continue
            content, summary = result
            Output(str(folder / Path(job.path).name), overwrite=True).write(content)
            Output(str(_recordOf(folder, job)), overwrite=True).write(asJSON({**summary, "settings": _asKept(job)}))
            summaries[job.path] = summary
            console.print(_lineOf(summary))
        interrupted = interrupts.number if interrupts else None
    ordered = [summaries[job.path] for job in jobs if job.path in summaries]
    outputs[0].write(_asCSV(ordered))
    if options.json:
        outputs[1].write(asJSON({"structures": ordered}))
    clean = sum(summary["isClean"] for summary in ordered)
    console.print(f"repaired {len(ordered):,} of {len(jobs):,} files to {folder}: {clean:,} clean")
    if interrupted:
        printError(f"interrupted; --resume -o {folder} repairs the other files")
        return ofSignal(interrupted)
    if failures:
        printError(f"{len(failures):,} of {len(jobs):,} files failed; the first: {failures[0]}")
        return BAD_INPUT
    return 0 if clean == len(ordered) else NOT_CLEAN


def runOne(job):
    """Return the content of a repaired file, and the plain summary of its repair."""
    repaired = runRepair(job)
    return repaired.contentFor(job.path), summarize(job.path, repaired, Path(job.path).name)


def _modelsIn(folder):
    def isModel(path):
        plain = path.name.lower().removesuffix(".gz").removesuffix(".bz2")
        return path.is_file() and not path.name.startswith(".") and Path(plain).suffix in _SUFFIXES

    found = sorted(filter(isModel, folder.iterdir()))
    if not found:
        raise InputError(f"{folder}: there is no PDB or mmCIF file")
    return found


def _recordOf(folder, job):
    return folder / f"{Path(job.path).name}.json"


def _asKept(job):
    """Return what decides the result of a job, as JSON keeps it."""
    return json.loads(json.dumps({**job.settings, "hydrogens": job.hydrogens}))


def _findDone(folder, jobs, options):
    """Return the summaries of files that the folder of results has, by the paths of their models.

    Raises
    ------
    InputError
        if files exist that may not be replaced, or were made with other settings
    """
    if not options.resume:
        names = ["summary.csv", *(Path(job.path).name for job in jobs), *(_recordOf(folder, job).name for job in jobs)]
        found = next((name for name in names if (folder / name).exists()), None)
        if found and not options.overwrite:
            raise InputError(f"{folder / found}: exists; --resume keeps repaired files, --overwrite replaces all")
        return {}
    done = {}
    for job in jobs:
        record = _recordOf(folder, job)
        if not record.exists() or not (folder / Path(job.path).name).exists():
            continue
        try:
            summary = json.loads(record.read_text(encoding="utf-8"))
            former = summary.pop("settings")
        except (OSError, ValueError, KeyError, AttributeError) as error:
            raise InputError(f"{record}: cannot be read as a record of a repair ({error}); remove it") from error
        if former != _asKept(job):
            raise InputError(f"{record}: was made with other options; --overwrite repairs all files again")
        done[job.path] = summary
    return done


def _lineOf(summary):
    scores = [
        f"{model['clashscoreBefore']:.1f} → {model['clashscoreAfter']:.1f}, Cα or P {model['traceShiftRms']:.3f} nm"
        for model in summary["models"]
    ]
    word = "clean" if summary["isClean"] else "not clean"
    return f"{summary['structure']}: clashscore {'; '.join(scores)}: {word}"


def _asCSV(summaries):
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["structure", "model", "isClean", *_COLUMNS])
    for summary in summaries:
        for number, model in enumerate(summary["models"]):
            name = printable(Path(summary["structure"]).name)
            writer.writerow([name, number, model["isClean"], *(model[column] for column in _COLUMNS)])
    return text.getvalue()
