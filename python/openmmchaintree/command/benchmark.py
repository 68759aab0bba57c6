"""The command openmm-chaintree benchmark."""

import tempfile
from pathlib import Path

from ..structure import InputError
from .arguments import listOf, positive, positiveReal, seed
from .benchmarking.course import Course
from .benchmarking.program import Interrupted, Program, ProgramError
from .benchmarking.proteins import ProteinModels, findProteins, readProtein
from .benchmarking.report import describeProcessor, makeMarkdown, printReport, summarize, writeCSV
from .benchmarking.rows import GROUPS, WITH_PROTEINS, Plan
from .outputfiles import checkOutput, checkPicture, writeJSON
from .status import CONTESTANTS_FAILED, INTERRUPTED
from .terminal import ReportConsole, interruptFlag, progress

_STANDARD_OUTPUT = "-"
_SECONDS, _QUICK_SECONDS = 20.0, 0.5
_PICTURED = "figures"  # the group that the picture shows


def addParser(commands):
    """Add the command and its arguments."""
    benchmark = commands.add_parser(
        "benchmark",
        help="race the engine against other methods",
        description="Race the engine against cell grids, trees of boxes and the ChainTree as published in 2002, in "
        "turns on the same trials, all of whose verdicts are compared; and against what one could call from Python. "
        "Times are those of the processor. The groups of rows are "
        + "; ".join(f"{group} ({words[0].lower()}{words[1:]})" for group, words in GROUPS.items())
        + ".",
    )
    benchmark.set_defaults(run=_run)
    benchmark.add_argument(
        "structures",
        nargs="*",
        metavar="structure",
        help="PDB or mmCIF files, plain or gzipped, of each the longest chain of amino acids (default: the villin "
        "headpiece in OpenMM's package, and of bpti_h.pdb, 5dfr_h.pdb, 1shg.pdb, 1htb.pdb and 2cas.pdb.gz those that "
        "are in the folder that the variable CHAINTREE_TEST_DATA names)",
    )
    benchmark.add_argument(
        "--rows", type=listOf(GROUPS), metavar="GROUPS", help="groups of rows, with commas between them (default: all)"
    )
    benchmark.add_argument(
        "--contestants",
        metavar="NAMES",
        help="those who race, of the program in C, with commas between them (default: whom a group is about)",
    )
    benchmark.add_argument("--trials", type=positive, default=20000, help="trials of a race (default: %(default)s)")
    benchmark.add_argument(
        "--seconds", type=positiveReal, help=f"processor time after which a race ends sooner (default: {_SECONDS:g})"
    )
    benchmark.add_argument(
        "--quick", action="store_true", help=f"only the smallest chains and protein, and {_QUICK_SECONDS:g} s for each"
    )
    benchmark.add_argument(
        "--seed", type=seed, default=1, help="random number seed, 1 to 2147483647 (default: %(default)s)"
    )
    benchmark.add_argument("--json", metavar="FILE", help="write everything as JSON")
    benchmark.add_argument("--csv", metavar="FILE", help="write a line of CSV for each contestant of each row")
    benchmark.add_argument("--markdown", metavar="FILE", help="write the tables as Markdown (-: print them so)")
    benchmark.add_argument(
        "--picture", metavar="FILE", help="draw the paper's figures 7 and 8 and its table 1 (.png, .pdf or .svg)"
    )


def _run(options):
    groups = list(GROUPS) if options.rows is None else options.rows
    outputs = _checkOutputs(options, groups)
    program = Program()
    contestants = _chooseContestants(options.contestants, program)
    if options.structures:
        proteins, missing = [readProtein(path) for path in options.structures], []
    else:
        proteins, missing = findProteins(isQuick=options.quick or not WITH_PROTEINS & set(groups))
    models = [ProteinModels(protein) for protein in proteins]
    rows, skipped = Plan(groups, program.contestants, contestants, models, options.quick).makeRows()
    skipped += [(name, "not in the folder that CHAINTREE_TEST_DATA names") for name in missing]
    seconds = options.seconds or (_QUICK_SECONDS if options.quick else _SECONDS)
    with tempfile.TemporaryDirectory() as folder:
        course = Course(program, options.seed, options.trials, seconds, folder)
        entries, failures, interrupted = _runAll(rows, course)
    summary = summarize(entries, course, proteins, skipped, failures, interrupted)
    _write(outputs, summary)
    if options.markdown == _STANDARD_OUTPUT:
        print(makeMarkdown(summary), end="")
    else:
        printReport(summary, list(outputs.values()), ReportConsole())
    if failures:
        return CONTESTANTS_FAILED
    return INTERRUPTED if interrupted else 0


def _checkOutputs(options, groups):
    """Return the files to write, by their kind."""
    given = {kind: getattr(options, kind) for kind in ("json", "csv", "markdown", "picture")}
    outputs = {kind: Path(path) for kind, path in given.items() if path not in (None, _STANDARD_OUTPUT)}
    checkOutput(outputs.values(), options.structures)
    if "picture" in outputs:
        checkPicture(outputs["picture"])
        if _PICTURED not in groups:
            raise InputError(f"--picture shows the rows of {_PICTURED}, which --rows leaves out")
    return outputs


def _chooseContestants(text, program):
    """Return the contestants that the user names, or None."""
    if text is None:
        return None
    known = list(dict.fromkeys(contestant.name for contestant in program.contestants))
    for name in text.split(","):
        if name not in known:
            raise InputError(f"there is no contestant {name!r}; there are {', '.join(known)}")
    return text.split(",")


def _runAll(rows, course):
    """Run rows until the user interrupts; return their entries, (row, reason) of those that failed, and whether so."""
    entries, failures = [], []
    with interruptFlag() as interrupted, progress(len(rows)) as advance:
        for done, row in enumerate(rows, start=1):
            try:
                entries += row.run(course)
            except ProgramError as error:
                failures.append((f"{row.group}: {row}", str(error)))
            except Interrupted:
                interrupted.append(None)
            if interrupted:
                break
            advance(done)
        return entries, failures, bool(interrupted)


def _write(outputs, summary):
    if "json" in outputs:
        writeJSON(outputs["json"], summary)
    if "csv" in outputs:
        writeCSV(outputs["csv"], summary["entries"])
    if "markdown" in outputs:
        outputs["markdown"].write_text(makeMarkdown(summary), encoding="utf-8")
    if "picture" in outputs:
        if any(entry["group"] == _PICTURED for entry in summary["entries"]):
            _savePicture(outputs["picture"], summary)
        else:
            del outputs["picture"]


def _savePicture(path, summary):
    # Matplotlib takes longer to import than a short race.
    from .benchmarking.picture import savePicture

    savePicture(path, describeProcessor(summary), summary["entries"])
