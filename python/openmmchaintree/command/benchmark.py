"""The command openmm-chaintree benchmark."""

import tempfile

from ..errors import InputError
from .accuracy.plan import TURNS, planAccuracy
from .arguments import listOf, positive, positiveReal, seed
from .benchmarking.course import Course
from .benchmarking.program import Interrupted, Program, ProgramError
from .benchmarking.proteins import ProteinModels, findProteins, readProtein
from .benchmarking.report import asCSV, describeProcessor, makeReport, summarize
from .benchmarking.rows import GROUPS, WITH_PROTEINS, Plan
from .benchmarking.study import Study
from .outputfiles import Writing, addOverwrite, asJSON, checkOutputs, checkPicture
from .status import BAD_INPUT, CONTESTANTS_FAILED, INTERRUPTED
from .terminal import ReportConsole, interruptFlag, printError, progress

_TRIALS = 20000
_SECONDS, _QUICK_SECONDS = 20.0, 0.5
_PICTURED = "figures"  # the group that the picture shows


def addArguments(benchmark):
    """Describe the command and its arguments to a parser."""
    benchmark.description = (
        "Race the engine against cell grids, trees of boxes and the ChainTree as published in 2002, in turns on the "
        "same trials, all of whose verdicts are compared; and against what one could call from Python. Times are those "
        "of the processor. The groups of rows are "
        + "; ".join(f"{group} ({words[0].lower()}{words[1:]})" for group, words in GROUPS.items())
        + ". What is written to - goes to standard output: Markdown in place of the report, JSON and CSV while the "
        "report goes to standard error."
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
    benchmark.add_argument(
        "--accuracy",
        action="store_true",
        help="instead of races, measure how far positions are from exact ones after many turns, which clashes are "
        "missed or invented where spheres all but touch, and how exact the soft force is, by the engine on all its "
        "paths and by weaker methods, against long double",
    )
    benchmark.add_argument(
        "--trials",
        type=positive,
        help=f"trials of a race (default: {_TRIALS}), or turns after which accuracy is measured (default: {TURNS})",
    )
    benchmark.add_argument(
        "--seconds", type=positiveReal, help=f"processor time after which a race ends sooner (default: {_SECONDS:g})"
    )
    benchmark.add_argument(
        "--quick", action="store_true", help=f"only the smallest chains and protein, and {_QUICK_SECONDS:g} s for each"
    )
    benchmark.add_argument(
        "--seed", type=seed, default=1, help="random number seed, 1 to 2147483647 (default: %(default)s)"
    )
    benchmark.add_argument("--json", metavar="FILE", help="write everything as JSON (-: print it)")
    benchmark.add_argument(
        "--csv", metavar="FILE", help="write a line of CSV for each contestant of each row (-: print them)"
    )
    benchmark.add_argument("--markdown", metavar="FILE", help="write the tables as Markdown (-: print them so)")
    benchmark.add_argument(
        "--picture",
        metavar="FILE",
        help="draw the paper's figures 7 and 8 and its table 1, or error by time (.png, .pdf or .svg)",
    )
    addOverwrite(benchmark)


def _run(options):
    outputs = _checkOutputs(options)
    program = Program()
    study = planAccuracy(options, program) if options.accuracy else _planRaces(options, program)
    seconds = options.seconds or (_QUICK_SECONDS if options.quick else _SECONDS)
    with tempfile.TemporaryDirectory() as folder:
        course = Course(program, options.seed, options.trials or study.trials, seconds, folder)
        entries, failures, interrupted = _runAll(study.rows, course)
    report = study.makeReport(entries, course, failures, interrupted)
    writing = _write(outputs, report, study)
    if "markdown" not in outputs or not outputs["markdown"].isStandardOutput:
        report.print(writing.files, ReportConsole(outputs.values()))
    if writing.failures:
        printError(writing.describeFailures())
    if failures or study.hasFailed(report.summary):
        return CONTESTANTS_FAILED
    if writing.failures:
        return BAD_INPUT
    return INTERRUPTED if interrupted else 0


def _planRaces(options, program):
    """Return the Study of the races that the user wants."""
    groups = _groups(options)
    contestants = _chooseContestants(options.contestants, program)
    if options.structures:
        proteins, missing = [readProtein(path) for path in options.structures], []
    else:
        proteins, missing = findProteins(isQuick=options.quick or not WITH_PROTEINS & set(groups))
    models = [ProteinModels(protein) for protein in proteins]
    rows, skipped = Plan(groups, program.contestants, contestants, models, options.quick).makeRows()
    skipped += [(name, "not in the folder that CHAINTREE_TEST_DATA names") for name in missing]

    def report(entries, course, failures, interrupted):
        return makeReport(summarize(entries, course, proteins, skipped, failures, interrupted))

    return Study(rows, _TRIALS, report, _hasPicture, _savePicture)


def _groups(options):
    return list(GROUPS) if options.rows is None else options.rows


def _checkOutputs(options):
    """Return the Outputs by their kind."""
    names = {kind: getattr(options, kind) for kind in ("json", "csv", "markdown", "picture")}
    outputs = checkOutputs(names, options.structures, options.overwrite)
    if "picture" in outputs:
        checkPicture(outputs["picture"])
        if not options.accuracy and _PICTURED not in _groups(options):
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


def _write(outputs, report, study):
    """Write all outputs; return their Writing."""
    writing = Writing()
    writers = {
        "json": lambda output: output.write(asJSON(report.summary)),
        "csv": lambda output: output.write(asCSV(report.summary["entries"])),
        "markdown": lambda output: output.write(report.markdown()),
        "picture": lambda output: study.savePicture(output, report.summary),
    }
    for kind, output in outputs.items():
        if kind != "picture" or study.hasPicture(report.summary):
            writing.write(output, writers[kind])
    return writing


def _hasPicture(summary):
    return any(entry["group"] == _PICTURED for entry in summary["entries"])


def _savePicture(output, summary):
    # Matplotlib takes longer to import than a short race.
    from .benchmarking.picture import savePicture

    savePicture(output, describeProcessor(summary), summary["entries"])
