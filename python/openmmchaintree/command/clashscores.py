"""The command openmm-chaintree clashes with the definitions of other programs, for a file or a folder of models."""

import signal
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path

from ..errors import InputError
from ..scoring.modelscores import MOLPROBITY, OWN, ScoreSearch
from ..structures.structurefile import isStructureName
from .outputs.outputfiles import Writing, asJSONWith, checkOutputs, checkPicture
from .pictures import savePicture
from .reports.noteoutput import asPlain, asText
from .reports.scorereport import SCHEMA, asCSV, plainScores, printFolder, printScores
from .reports.viewerscript import ENDINGS, asScript
from .terminal import BAD_INPUT, BEYOND_LIMIT, ReportConsole, printError, progress

# Options of a search by our own definition alone.
_OTHERS = ("water", "ions", "periodic", "symmetry", "radii", "scheduler")
# Files that a process is given at a time.
_FILES_AT_A_TIME = 4


def isScoring(options):
    """Return whether options ask for scores, and not for the clashes of a structure or trajectory alone."""
    others = set(options.definition or ()) - {OWN}
    chosen = (options.models, options.fail_above, options.script)
    return bool(others) or options.keep_hydrogens or options.flips or any(value is not None for value in chosen)


def runScores(options):
    """Score a file, or the files of a folder; return the exit status."""
    definitions = tuple(dict.fromkeys(options.definition or (MOLPROBITY,)))
    _checkOptions(options, definitions)
    drawn = next((definition for definition in (MOLPROBITY, OWN) if definition in definitions), None)
    names = {kind: getattr(options, kind) for kind in ("csv", "json", "notes", "picture", "script")}
    paths = _modelsOf(options.models) if options.models is not None else []
    inputs = paths or [path for path in (options.structure, options.trajectory) if path is not None]
    outputs = checkOutputs(names, list(map(str, inputs)), options.overwrite)
    if "picture" in outputs:
        checkPicture(outputs["picture"])
    console = ReportConsole(outputs.values())
    head = {"schema": SCHEMA, "definitions": list(definitions), "keepHydrogens": options.keep_hydrogens}
    head["flips"] = options.flips
    if paths:
        files = _scoreFolder(paths, definitions, options)
        content, items = {**head, "folder": str(options.models)}, files
        notes, search, models, word = [], None, [], ""
        printFolder(files, definitions, console, options.rows)
    else:
        search = ScoreSearch(options.structure, options.trajectory, definitions, options.keep_hydrogens, options.flips)
        models, error = _scoreAll(search)
        if error is not None and not models:
            raise error
        notes = search.notes
        files = [{"file": str(search.source), "error": None if error is None else str(error), "models": models}]
        trajectory = None if options.trajectory is None else str(options.trajectory)
        word = "model" if trajectory is None else "frame"
        content, items = {**head, "trajectory": trajectory, "notes": asPlain(notes)}, files
        printScores(models, content["notes"], console, options.rows, options.verbose)
    writers = {
        "csv": lambda output: output.write(asCSV(files, definitions)),
        "json": lambda output: output.write(asJSONWith(content, "files", items)),
        "notes": lambda output: output.write(asText(notes)),
        "picture": lambda output: savePicture("scorepicture", output, search, models, drawn, word),
        "script": lambda output: output.write(asScript(Path(output.name).suffix.lower(), search, models[0], drawn)),
    }
    with Writing() as writing:
        for kind, output in outputs.items():
            writing.write(output, writers[kind])
    if writing.files:
        console.print(f"wrote {', '.join(map(str, writing.files))}")
    errors = [file["error"] for file in files if file["error"] is not None]
    for error in errors:
        printError(error)
    if writing.failures:
        printError(writing.describeFailures())
        return BAD_INPUT
    if errors and (not paths or not any(file["models"] for file in files)):
        return BAD_INPUT
    return BEYOND_LIMIT if _isAbove(options.fail_above, files) else 0


def _checkOptions(options, definitions):
    """Refuse options that do not go together."""
    for name in _OTHERS:
        if getattr(options, name) not in (None, False):
            raise InputError(f"--{name} works only with the definition own")
    if options.models is not None and options.structure is not None:
        raise InputError(f"{options.structure}: --models takes a folder of models, and no other structure")
    if options.workers is not None and options.models is None:
        raise InputError("--workers needs --models, or only the definition own")
    for name in ("picture", "script"):
        if getattr(options, name) is not None:
            if options.models is not None:
                raise InputError(f"--{name} shows the models of one file, not of a folder")
            if not {MOLPROBITY, OWN} & set(definitions):
                raise InputError(f"--{name} shows clashes by --definition molprobity or own")
    if options.script is not None and Path(options.script).suffix.lower() not in ENDINGS:
        raise InputError(f"{options.script}: a script's name ends in {' or '.join(ENDINGS)}")
    if options.flips and options.keep_hydrogens:
        raise InputError("--flips places hydrogens: it cannot be used with --keep-hydrogens")
    for name in ("fail_above", "keep_hydrogens", "flips"):
        if getattr(options, name) not in (None, False) and MOLPROBITY not in definitions:
            raise InputError(f"--{name.replace('_', '-')} needs --definition molprobity")


def _modelsOf(folder):
    """Return the structure files of a folder, sorted by name."""
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"{folder}: is not a folder")
    paths = sorted(path for path in folder.iterdir() if isStructureName(path) and not path.is_dir())
    if not paths:
        raise InputError(f"{folder}: has no structure files")
    return paths


def _scoreAll(search):
    """Return the plain scores of a ScoreSearch up to an error, and the error or None."""
    models = []
    try:
        for scores in search:
            models.append(plainScores(search, scores))
    except InputError as error:
        return models, error
    return models, None


def scoreFile(path, definitions, keepHydrogens, flips=False):
    """Return the plain scores of a file: "file", "error" or None, and "models"."""
    try:
        models, error = _scoreAll(ScoreSearch(path, None, definitions, keepHydrogens, flips))
    except (InputError, OSError) as found:
        models, error = [], found
    text = None if error is None else str(error)
    if text is not None and str(path) not in text:
        text = f"{path}: {text}"
    return {"file": str(path), "error": text, "models": models}


def _scoreFolder(paths, definitions, options):
    """Return the plain scores of files, in their order."""
    arguments = [(str(path), definitions, options.keep_hydrogens, options.flips) for path in paths]
    files = []
    with progress(len(paths)) as advance, _startWorkers(options.workers, len(paths)) as scoreAll:
        for file in scoreAll(arguments):
            files.append(file)
            advance(len(files))
    return files


@contextmanager
def _startWorkers(count, fileCount):
    """Yield a function that yields the result of `_scoreOne` for each item of a list, in order, by some processes."""
    count = min(count or 1, fileCount)
    if count == 1:
        yield lambda items: map(_scoreOne, items)
        return
    # Processes forked from a process with threads may hang.
    pool = ProcessPoolExecutor(count, get_context("spawn"), _beginProcess)
    try:
        yield lambda items: pool.map(_scoreOne, items, chunksize=_FILES_AT_A_TIME)
    except BrokenProcessPool:
        raise InputError("a process that scores models was ended") from None
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _beginProcess():
    """Leave Ctrl-C to the process that waits for this one."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _scoreOne(arguments):
    return scoreFile(*arguments)


def _isAbove(limit, files):
    if limit is None:
        return False
    return any(model[MOLPROBITY]["clashscore"] > limit for file in files for model in file["models"])
