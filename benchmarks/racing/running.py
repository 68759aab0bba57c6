"""What the scripts share: options, running rows one after another, and writing what was found."""

import tempfile
from collections.abc import Callable
from importlib import import_module
from typing import Any, NamedTuple

from openmmchaintree.command.arguments import positive, seed
from openmmchaintree.command.outputs.outputfiles import Output, Writing, addOverwrite, checkOutputs, checkPicture
from openmmchaintree.command.status import BAD_INPUT, INTERRUPTED
from openmmchaintree.command.terminal import ReportConsole, interruptFlag, printError, progress

from .course import Course
from .machine import describeLoad, describeMachine
from .program import Interrupted, Program, ProgramError
from .races import OURS
from .report import Report, asCSV, readCSV
from .table import Table

FAILED = 1  # the exit status where a row failed, or a goal was missed

_WIDEST = 1000  # of lines, letters; tables are as wide as they need to be


class Study(NamedTuple):
    """What a script measures, and what it makes of that.

    rows : list, each with a method run(course, seed) that returns the entries of one chain, and `mostChains`
    skipped : list of (str, str), what does not run, and why
    """

    rows: list[Any]
    skipped: list[tuple[str, str]]


class Maker(NamedTuple):
    """What a script makes of entries.

    makeTables : function of entries: list of Table
    makeRemarks : function of entries: list of str, and whether they show that the engine is wrong
    hasPicture : function of entries: whether there is anything to draw
    savePicture : function of an Output, the machine and entries
    """

    makeTables: Callable[[list[dict]], list[Table]]
    makeRemarks: Callable[[list[dict]], tuple[list[str], bool]]
    hasPicture: Callable[[list[dict]], bool]
    savePicture: Callable[[Output, dict[str, str], list[dict]], None]


def drawnBy(module):
    """Return hasPicture and savePicture of a module that is imported as late as they are called: Matplotlib takes long.

    A picture may well not be wanted, and to import Matplotlib takes longer than a short race.
    """

    def late(name):
        return lambda *arguments: getattr(import_module(module), name)(*arguments)

    return late("hasPicture"), late("savePicture")


def addOptions(parser, trials, picture):
    """Add the options of all scripts; trials and picture are the help on two of them. Without trials None is taken."""
    if trials is None:
        parser.set_defaults(trials=None)
    else:
        parser.add_argument("--trials", type=positive, help=trials)
    parser.add_argument(
        "--seed", type=seed, default=1, help="random number seed, 1 to 2147483647 (default: %(default)s)"
    )
    parser.add_argument(
        "--program",
        metavar="FILE",
        help="the program openmm-chaintree-contestants (default: the one that the variable CHAINTREE_CONTESTANTS "
        "names, or that of the build from which openmmchaintree is imported)",
    )
    parser.add_argument(
        "--read", metavar="FILE", help="measure nothing: make tables and picture of the CSV of an earlier run"
    )
    parser.add_argument("--csv", metavar="FILE", help="write all numbers as CSV (-: print them)")
    parser.add_argument("--markdown", metavar="FILE", help="write the tables as Markdown (-: print them so)")
    parser.add_argument("--picture", metavar="FILE", help=f"{picture} (.png, .pdf or .svg)")
    addOverwrite(parser)


def runStudy(options, plan, maker, inputs=()):
    """Run what a script is about; return its exit status.

    Parameters
    ----------
    plan : function of the Program that returns a Study
    maker : Maker
    inputs : names of files that are read
    """
    outputs = checkOutputs(
        {kind: getattr(options, kind) for kind in ("csv", "markdown", "picture")},
        [*inputs, *filter(None, [options.read])],
        options.overwrite,
    )
    if "picture" in outputs:
        checkPicture(outputs["picture"])
    notes, failures, interrupted = [], [], False
    if options.read is not None:
        machine, entries = readCSV(options.read)
    else:
        program = Program(options.program)
        study = plan(program)
        machine = describeMachine(program)
        with tempfile.TemporaryDirectory() as folder:
            course = Course(program, options.seed, options.chains, options.trials, folder)
            entries, failures, interrupted = _runAll(study.rows, course)
        machine["load at end"] = describeLoad()
        if sets := _instructionSets(entries):
            machine["instruction sets of the engine"] = sets
        notes += [f"skipped: {what}: {why}" for what, why in study.skipped]
        notes += [f"FAILED: {what}: {why}" for what, why in failures]
        notes += ["interrupted: this is what was measured so far"] if interrupted else []
    remarks, isWrong = maker.makeRemarks(entries)
    report = Report(machine, entries, maker.makeTables(entries), [*remarks, *notes])
    writing = _write(outputs, report, maker)
    if "markdown" not in outputs or not outputs["markdown"].isStandardOutput:
        console = ReportConsole(outputs.values())
        console.width = _WIDEST
        report.print(writing.files, console)
    if writing.failures:
        printError(writing.describeFailures(), options.prog)
    if failures or isWrong:
        return FAILED
    if writing.failures:
        return BAD_INPUT
    return INTERRUPTED if interrupted else 0


def _runAll(rows, course):
    """Run rows until the user interrupts; return their entries, (row, reason) of those that failed, and whether so.

    A row counts whole or not at all.
    """
    entries, failures = [], []
    counts = [min(row.mostChains, course.chains) for row in rows]
    with interruptFlag() as interrupted, progress(sum(counts)) as advance:
        done = 0
        for row, count in zip(rows, counts, strict=True):
            ofRow = []
            for chain in range(count):
                try:
                    ofRow += row.run(course, course.seed + chain)
                except ProgramError as error:
                    failures.append((f"{row.group}: {row}", str(error)))
                    ofRow = []
                    break
                except Interrupted:
                    interrupted.append(None)
                if interrupted:
                    return entries, failures, True
                advance(done + chain + 1)
            done += count
            entries += ofRow
        return entries, failures, False


def _instructionSets(entries):
    return ", ".join(sorted({e["isa"] for e in entries if "isa" in e and e["contestant"].startswith(OURS)}))


def _write(outputs, report, maker):
    """Write all outputs; return their Writing."""
    writing = Writing()
    writers = {
        "csv": lambda output: output.write(asCSV(report)),
        "markdown": lambda output: output.write(report.markdown()),
        "picture": lambda output: maker.savePicture(output, report.machine, report.entries),
    }
    for kind, output in outputs.items():
        if kind != "picture" or maker.hasPicture(report.entries):
            writing.write(output, writers[kind])
    return writing
