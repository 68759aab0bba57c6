"""Measure what trials in implicit solvent cost, and how near what they see is to U; see docs/benchmark.md.

PYTHONPATH=build/package python benchmarks/solvent.py --markdown solvent.md --picture solvent.png
"""

import sys

from energy.options import addRowOptions, chooseStructures, describeSkipped, nameOf, settle
from energy.proteins import IMPLICIT_SOLVENT, readSampled
from energy.rows import Prepared
from energy.samplerows import SAMPLES, SampleRow
from energy.solventgoals import judge
from energy.solventrows import (
    EXPRESSION_MOVES,
    EXPRESSIONS,
    SIZE_MOVES,
    SIZES,
    SOLVENT,
    STAND_INS,
    WHOLE,
    ExpressionRow,
    SizeRow,
    SolventRow,
    StandInRow,
    WholeEnergyRow,
)
from energy.solventtables import makeTables
from openmmchaintree.command.arguments import Parser
from openmmchaintree.command.cli import runParsed
from racing.running import Maker, Study, addOptions, drawnBy, runStudy

GROUPS = {
    SOLVENT: "whole trials by Simulation.step, ours and with OpenMM's energies",
    WHOLE: "one whole energy",
    STAND_INS: "whole trials by cutoffs of the stand-in and trials of an outer test",
    SAMPLES: "independent samples a second by cutoffs of the stand-in and trials of an outer test",
    SIZES: "trials that move few atoms, as proteins grow",
    EXPRESSIONS: "pairs by the expression of a CustomNonbondedForce",
}

# What is run where nobody names structures: the villin headpiece, and of these those that are there. The last two take
# part in the growth alone; to 4hhb, of four chains, hydrogens are added.
_FILES = ("1ubi_h.pdb", "5dfr_h.pdb", "bpti_h.pdb", "4hhb.pdb")
_OF_SIZES_ONLY = ("bpti_h", "4hhb")
_ONCE = ("4hhb",)  # a run of it takes minutes
_WITH_SAMPLES = "villin"
_WITH_EXPRESSIONS = "5dfr_h"

_RUNS = 3
_WARM_TRIALS = 200000
_QUICK_RUNS, _QUICK_TRIALS = 1, 400


def main(arguments=None):
    """Run the script; return its exit status."""
    parser = Parser(
        prog="solvent.py",
        description="Measure what trials of proteins in AMBER14 with GBn2 cost, outer tests included, in turns with "
        "OpenMM's CPU platform with one thread; and how near stand-ins are to the energy. Times are those of the "
        "processor. The groups of rows are "
        + "; ".join(f"{group} ({words})" for group, words in GROUPS.items())
        + ". What is written to - goes to standard output: Markdown in place of the report, CSV while the report goes "
        "to standard error.",
    )
    parser.set_defaults(run=_run, prog=parser.prog)
    addRowOptions(parser, GROUPS, _FILES, _RUNS, _WARM_TRIALS)
    parser.add_argument(
        "--quick",
        action="store_true",
        help=f"only the smallest protein, {_QUICK_RUNS} run a row, {_QUICK_TRIALS} trials each",
    )
    addOptions(parser, "trials of each run, in place of those of its row", "draw stand-ins by cutoffs and trials")
    return runParsed(parser, arguments)


def _run(options):
    settle(options, GROUPS, _RUNS, _WARM_TRIALS, _QUICK_RUNS, _QUICK_TRIALS)
    return runStudy(
        options,
        lambda program: _plan(options),
        Maker(makeTables, judge, *drawnBy("energy.solventpicture")),
        options.structures,
    )


def _plan(options):
    """Return the Study of the rows that the user wants."""
    paths, missing = chooseStructures(options, _FILES)

    def prepare(path):
        return Prepared(lambda: readSampled(path).relaxed(options.warm, method=IMPLICIT_SOLVENT))

    proteins = {nameOf(path): prepare(path) for path in paths}
    chosen = {name: prepared for name, prepared in proteins.items() if name not in _OF_SIZES_ONLY or options.structures}
    rows = []
    for group, makeRow in ((SOLVENT, SolventRow), (WHOLE, WholeEnergyRow), (STAND_INS, StandInRow)):
        if group in options.rows:
            rows += [makeRow(name, prepared) for name, prepared in chosen.items()]
    if SAMPLES in options.rows:
        rows += [
            SampleRow(name, prepared)
            for name, prepared in chosen.items()
            if name == _WITH_SAMPLES or options.structures
        ]
    if EXPRESSIONS in options.rows:
        name = _WITH_EXPRESSIONS if _WITH_EXPRESSIONS in proteins else next(iter(proteins))
        rows += [ExpressionRow(name, proteins[name], moves) for moves in EXPRESSION_MOVES]
    if SIZES in options.rows:
        rows += [
            SizeRow(name, prepared, moves)._replace(**({"mostChains": 1} if name in _ONCE else {}))
            for name, prepared in proteins.items()
            for moves in SIZE_MOVES
        ]
    return Study(rows, describeSkipped(missing))


if __name__ == "__main__":
    sys.exit(main())
