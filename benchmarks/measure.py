"""How every benchmark runs: its options, its rows one after another, and the files that it writes."""

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import numpy as np
import openmm
from openmmchaintree.errors import InputError
from program import VARIABLE, Program, ProgramError
from report import combineRuns, describeLoad, describeMachine, readCSV, writeCSV
from rich.console import Console
from rich.progress import Progress

OURS = "ours"
CPU = "CPU"  # the platform
FAILED, BAD_INPUT, INTERRUPTED = 1, 2, 130  # exit statuses

_WIDEST = 1000  # letters of a line on the terminal


class Row(NamedTuple):
    """What is measured: `measure(course, seed)` returns the entries of one run."""

    group: str
    name: str
    measure: Callable
    mostRuns: int = sys.maxsize


class Course(NamedTuple):
    """The settings of all rows: the program, the seed of the first run, trials, and a folder for temporary files."""

    program: Program
    seed: int
    trials: int | None
    folder: Path


# ---- Times ----


def timed(function, *arguments):
    """Return what a call returns, and its processor time, of all threads, in microseconds."""
    start = time.process_time_ns()
    result = function(*arguments)
    return result, 1e-3 * (time.process_time_ns() - start)


def medianTime(times):
    """Return the median of times as an entry has it."""
    return {"microseconds": float(np.median(times))}


def hasCPU():
    """Return whether OpenMM has its CPU platform here."""
    count = openmm.Platform.getNumPlatforms()
    return CPU in [openmm.Platform.getPlatform(i).getName() for i in range(count)]


# ---- Options ----


def listOf(names):
    """Return a type of argument: some of the names, with commas between them."""

    def read(text):
        for name in text.split(","):
            if name not in names:
                raise argparse.ArgumentTypeError(f"{name!r} is none of {', '.join(names)}")
        return text.split(",")

    return read


def positive(text):
    """Return a whole number above 0."""
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"{text!r} is no positive whole number")
    return int(text)


def makeParser(name, description, groups, runs, files=(), warm=None):
    """Return the parser of a benchmark with the options that all have.

    Parameters
    ----------
    groups : dict, what each group of rows is about
    runs : int, of each row
    files : names of structures that are taken where they lie ready; without any, no structure can be named
    warm : int, trials that each protein goes through before anything is measured
    """
    about = "; ".join(f"{group}: {words}" for group, words in groups.items())
    parser = argparse.ArgumentParser(prog=name, description=f"{description} The groups of rows are {about}.")
    parser.set_defaults(structures=[])
    if files:
        parser.add_argument(
            "structures",
            nargs="*",
            metavar="structure",
            help="PDB or mmCIF files (default: the villin headpiece of OpenMM's package, and of "
            f"{', '.join(files)} those in the folder that the variable CHAINTREE_TEST_DATA names)",
        )
    parser.add_argument("--rows", type=listOf(groups), default=list(groups), help="groups, with commas between them")
    parser.add_argument("--runs", type=positive, help=f"of each row, each with its own seed (default: {runs})")
    if warm is not None:
        parser.add_argument(
            "--warm", type=positive, default=warm, help="trials before all others (default: %(default)s)"
        )
    parser.add_argument("--trials", type=positive, help="of each run, in place of the number of its group")
    parser.add_argument("--seed", type=positive, default=1, help="of the first run (default: %(default)s)")
    parser.add_argument("--quick", action="store_true", help="only what is small, one run, few trials")
    parser.add_argument("--program", metavar="FILE", help=f"the contestants (default: by {VARIABLE}, or of the build)")
    parser.add_argument("--read", metavar="FILE", help="measure nothing: make tables and picture of an earlier CSV")
    parser.add_argument("--csv", metavar="FILE", help="write all numbers as CSV")
    parser.add_argument("--markdown", metavar="FILE", help="write the tables as Markdown")
    parser.add_argument("--picture", metavar="FILE", help="draw a picture, where the benchmark has one")
    parser.set_defaults(usualRuns=runs)
    return parser


# ---- Running ----


def run(parser, arguments, plan, makeTables, draw=None, judge=lambda entries: []):
    """Run a benchmark; return its exit status.

    Parameters
    ----------
    plan : function of the options that returns the Rows, and lines about what is skipped
    makeTables : function of the entries
    draw : name of a module with a function draw(machine, entries) that returns a matplotlib Figure, or None if there is
        nothing to draw; it is imported late, since to import Matplotlib takes longer than a short race
    judge : function of the entries that returns lines about what is wrong with the results
    """
    options = parser.parse_args(arguments)
    try:
        return _run(options, plan, makeTables, draw, judge)
    except (InputError, OSError) as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return BAD_INPUT


def _run(options, plan, makeTables, draw, judge):
    notes, failures, isInterrupted = [], [], False
    if options.read:
        machine, entries = readCSV(options.read)
    else:
        program = Program(options.program)
        rows, skipped = plan(options)
        machine = describeMachine(program)
        runs = options.runs or (1 if options.quick else options.usualRuns)
        with tempfile.TemporaryDirectory() as folder:
            course = Course(program, options.seed, options.trials, Path(folder))
            measured, failures, isInterrupted = _measureAll(rows, course, runs)
        entries = combineRuns(measured)
        machine["load at end"] = describeLoad()
        if sets := sorted({e["isa"] for e in entries if "isa" in e and e["contestant"].startswith(OURS)}):
            machine["instruction sets of the engine"] = ", ".join(sets)
        notes = [*(f"skipped: {line}" for line in skipped), *(f"FAILED: {line}" for line in failures)]
        notes += ["interrupted: this is what was measured so far"] if isInterrupted else []
    wrong = judge(entries)
    tables, notes = makeTables(entries), [*(f"WRONG: {line}" for line in wrong), *notes]
    _report(options, machine, entries, tables, notes, draw)
    if failures or wrong:
        return FAILED
    return INTERRUPTED if isInterrupted else 0


def _measureAll(rows, course, runs):
    """Return the entries of all rows, lines about rows that failed, and whether the user interrupted.

    A row counts whole or not at all.
    """
    entries, failures = [], []
    counts = [min(row.mostRuns, runs) for row in rows]
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("rows", total=sum(counts))
        for row, count in zip(rows, counts, strict=True):
            ofRow = []
            try:
                for number in range(count):
                    ofRow += [{"group": row.group, **entry} for entry in row.measure(course, course.seed + number)]
                    progress.advance(task)
                entries += ofRow
            except ProgramError as error:
                failures.append(f"{row.group}: {row.name}: {error}")
            except KeyboardInterrupt:
                return entries, failures, True
    return entries, failures, False


def _report(options, machine, entries, tables, notes, draw):
    console = Console(width=_WIDEST, highlight=False, markup=False)
    for name, words in machine.items():
        console.print(f"{name}: {words}")
    for table in tables:
        table.print(console)
    console.print()
    for note in notes:
        console.print(note)
    if options.csv:
        writeCSV(options.csv, machine, entries)
    if options.markdown:
        lines = ["\n".join(f"- {name}: {words}" for name, words in machine.items())]
        lines += [table.markdown() for table in tables] + ["\n".join(f"- {note}" for note in notes)]
        Path(options.markdown).write_text("\n\n".join(filter(None, lines)) + "\n", encoding="utf-8")
    figure = import_module(draw).draw(machine, entries) if options.picture and draw else None
    if figure is not None:
        figure.savefig(options.picture, dpi=150)
