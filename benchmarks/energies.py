"""Measure what energies of trials cost and how exact they are, ours and OpenMM's; see docs/benchmark.md.

PYTHONPATH=build/package python benchmarks/energies.py --markdown energies.md --picture energies.png
"""

import sys

from energy.goals import judge
from energy.options import addRowOptions, chooseStructures, describeSkipped, nameOf, settle
from energy.packing import PackedCopies
from energy.proteins import METHODS, readSampled
from energy.rows import (
    GROWTH,
    PIVOT,
    SIDE_CHAIN,
    SMALL_PIVOT,
    TRIALS,
    WHOLE_TRIALS,
    WINDOW,
    WORK,
    WORK_TRIALS,
    GrowthRow,
    Prepared,
    WholeRow,
    WorkRow,
)
from energy.tables import TABLES, makeTables
from openmmchaintree.command.arguments import Parser
from openmmchaintree.command.cli import runParsed
from racing.running import Maker, Study, addOptions, drawnBy, runStudy

GROUPS = {
    WORK: "the energy work of a trial: a χ, an open window of eight, a pivot",
    TRIALS: "whole trials by Simulation.step",
    GROWTH: "copies of a protein in one chain, 1 to 16",
}

# What is run where nobody names structures: the villin headpiece, and of these those that are there. The last has no
# hydrogens, and four chains; it takes part in the first group only.
_FILES = ("1ubi_h.pdb", "bpti_h.pdb", "5dfr_h.pdb", "4hhb.pdb")
_OF_WORK_ONLY = ("4hhb.pdb",)
_PACKED = "5dfr_h.pdb"
_COPIES = (1, 2, 4, 8, 16)

_RUNS = 3
_WARM_TRIALS = 200000
_QUICK_RUNS, _QUICK_TRIALS, _QUICK_COPIES = 1, 200, (1, 2)


def main(arguments=None):
    """Run the script; return its exit status."""
    parser = Parser(
        prog="energies.py",
        description="Measure what the energies of trials of proteins in AMBER14 cost, by our library of energies with "
        "each set of instructions and by OpenMM's CPU platform with one thread, on the same trials; and how far both "
        "are from OpenMM's Reference platform. Times are those of the processor. The groups of rows are "
        + "; ".join(f"{group} ({words})" for group, words in GROUPS.items())
        + ". What is written to - goes to standard output: Markdown in place of the report, CSV while the report goes "
        "to standard error.",
    )
    parser.set_defaults(run=_run, prog=parser.prog)
    addRowOptions(parser, GROUPS, _FILES, _RUNS, _WARM_TRIALS)
    parser.add_argument(
        "--quick",
        action="store_true",
        help=f"only the smallest protein, {_QUICK_RUNS} run a row, {_QUICK_TRIALS} trials each, few copies",
    )
    parser.add_argument(
        "--tables",
        choices=(*TABLES, "all"),
        default="all",
        help=f"which tables are made: {' or '.join(TABLES)}, which docs/benchmark.md and docs/accuracy.md show, or all "
        "(default: %(default)s)",
    )
    addOptions(
        parser,
        f"trials of each run, in place of {WORK_TRIALS} (whole trials: {WHOLE_TRIALS})",
        "draw times by protein, and error by time",
    )
    return runParsed(parser, arguments)


def _run(options):
    settle(options, GROUPS, _RUNS, _WARM_TRIALS, _QUICK_RUNS, _QUICK_TRIALS)
    maker = Maker(lambda entries: makeTables(entries, options.tables), judge, *drawnBy("energy.picture"))
    return runStudy(options, lambda program: _plan(options), maker, options.structures)


def _plan(options):
    """Return the Study of the rows that the user wants."""
    paths, missing = chooseStructures(options, _FILES)
    proteins = {nameOf(path): Prepared(lambda path=path: readSampled(path).relaxed(options.warm)) for path in paths}
    rows = []
    if WORK in options.rows:
        rows += [
            WorkRow(name, prepared, method, moves)
            for name, prepared in proteins.items()
            for method in METHODS
            for moves in (SIDE_CHAIN, WINDOW, PIVOT)
        ]
    if TRIALS in options.rows:
        rows += [WholeRow(name, prepared) for name, prepared in proteins.items() if f"{name}.pdb" not in _OF_WORK_ONLY]
    if GROWTH in options.rows:
        name = nameOf(_PACKED) if nameOf(_PACKED) in proteins else next(iter(proteins))
        for copies in _QUICK_COPIES if options.quick else _COPIES:
            packed = Prepared(lambda copies=copies: PackedCopies(proteins[name].protein, copies))
            rows += [GrowthRow(name, packed, moves) for moves in (SIDE_CHAIN, SMALL_PIVOT)]
    return Study(rows, describeSkipped(missing))


if __name__ == "__main__":
    sys.exit(main())
