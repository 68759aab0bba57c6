"""Measure what moves do to folded proteins, and how many independent samples mixtures give; see docs/benchmark.md.

PYTHONPATH=build/package python benchmarks/moves.py --csv moves.csv --markdown moves.md --picture moves.png
"""

import sys

from energy.coilrows import COILS, CoilRow
from energy.moverows import ALL_MIXTURES, DEFAULTS, MIXTURES, MOVES, PIVOTS, SINGLE_MOVES, MixtureRow, MoveRow
from energy.movetables import makeTables
from energy.options import addRowOptions, chooseStructures, describeSkipped, nameOf, settle
from energy.proteins import IMPLICIT_SOLVENT, readSampled
from energy.rows import Prepared
from energy.stationaryrows import STATIONARY, StationaryRow
from openmmchaintree.command.arguments import Parser
from openmmchaintree.command.cli import runParsed
from racing.running import Maker, Study, addOptions, drawnBy, runStudy

GROUPS = {
    MOVES: "acceptance, shift and time of each move alone",
    MIXTURES: "independent samples a second by mixtures of moves",
    STATIONARY: "independent samples a second by the default moves, and the most that pivots alone can give",
    COILS: "independent radii of gyration a second of a loose chain of hard spheres",
}

_FILES = ("1bna.pdb", "1ubi_h.pdb", "5dfr_h.pdb")
_RUNS = 3
_WARM_TRIALS = 200000
_QUICK_RUNS, _QUICK_TRIALS = 1, 800
_QUICK_MOVES = SINGLE_MOVES[::6]
_QUICK_MIXTURES = (PIVOTS, "closed", DEFAULTS.name)


def main(arguments=None):
    """Run the script; return its exit status."""
    parser = Parser(
        prog="moves.py",
        description="Measure moves of proteins in AMBER14 with GBn2 at 300 K from the folded state, and of a loose "
        "chain. Times are those of the processor. The groups of rows are "
        + "; ".join(f"{group} ({words})" for group, words in GROUPS.items())
        + ". What is written to - goes to standard output: Markdown in place of the report, CSV while the report goes "
        "to standard error.",
    )
    parser.set_defaults(run=_run, prog=parser.prog)
    addRowOptions(parser, GROUPS, _FILES, _RUNS, _WARM_TRIALS)
    parser.add_argument(
        "--quick",
        action="store_true",
        help=f"only the smallest protein and few moves, {_QUICK_RUNS} run a row, {_QUICK_TRIALS} trials each",
    )
    parser.add_argument(
        "--defaults",
        action="store_true",
        help="of the mixtures only pivots alone and what addDefaultMoves adds, for long chains",
    )
    addOptions(
        parser,
        "trials of each run, in place of those of its row",
        "draw acceptance and shift of moves, and what mixtures give beside pivots",
    )
    return runParsed(parser, arguments)


def _run(options):
    settle(options, GROUPS, _RUNS, _WARM_TRIALS, _QUICK_RUNS, _QUICK_TRIALS)
    maker = Maker(makeTables, lambda entries: ([], False), *drawnBy("energy.movepicture"))
    return runStudy(options, lambda program: _plan(options), maker, options.structures)


def _plan(options):
    """Return the Study of the rows that the user wants."""
    paths, missing = chooseStructures(options, _FILES)

    def prepare(path):
        return Prepared(lambda: readSampled(path).relaxed(options.warm, method=IMPLICIT_SOLVENT))

    proteins = {nameOf(path): prepare(path) for path in paths}
    moves, mixtures = (_QUICK_MOVES, _QUICK_MIXTURES) if options.quick else (SINGLE_MOVES, tuple(ALL_MIXTURES))
    mixtures = (PIVOTS, DEFAULTS.name) if options.defaults else mixtures
    rows = []
    for group, makeRow, of in ((MOVES, MoveRow, moves), (MIXTURES, MixtureRow, mixtures)):
        if group in options.rows:
            rows += [makeRow(name, prepared, of) for name, prepared in proteins.items()]
    if STATIONARY in options.rows:
        rows += [StationaryRow(name, prepared) for name, prepared in proteins.items()]
    if COILS in options.rows:
        longest = paths[-1]
        rows.append(CoilRow(nameOf(longest), Prepared(lambda: readSampled(longest))))
    return Study(rows, describeSkipped(missing))


if __name__ == "__main__":
    sys.exit(main())
