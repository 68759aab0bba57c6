"""Time pivots of bead chains, and sample a coarse-grained disordered protein by them and by dynamics.

PYTHONPATH=build/package python benchmarks/pivots.py --csv pivots.csv --markdown pivots.md
"""

import sys

import numpy as np
from beads.rows import COIL, COMPACT, DisorderedRow, PivotRow
from beads.tables import makeTables
from openmmchaintree.command.arguments import Parser, numberIn
from openmmchaintree.command.cli import runParsed
from racing.platforms import CPU, whyNot
from racing.running import Maker, Study, addOptions, runStudy

_SIZES, _QUICK_SIZES = (1000, 10000), (300,)
_ANGLES = {COMPACT: (np.pi, np.radians(5), np.radians(1)), COIL: (np.pi, np.radians(5))}
_LENGTH, _QUICK_LENGTH = 300, 30
_CHAINS = 5
_SECONDS = 60  # of a minute
_MINUTES, _QUICK_MINUTES = 10, 0.02
_OUR_SHARE = 0.1  # of the time of dynamics


def main(arguments=None):
    """Run the script; return its exit status."""
    parser = Parser(
        prog="pivots.py",
        description="Time whole trials of pivots of bead chains, and compare how many independent radii of gyration of "
        "a coarse-grained disordered protein a core finds in a second, by pivots and by Langevin dynamics. What is "
        "written to - goes to standard output: Markdown in place of the report, CSV while the report goes to standard "
        "error.",
    )
    parser.set_defaults(run=_run, prog=parser.prog)
    parser.add_argument("--minutes", type=numberIn(1e-3, 1e5), help=f"processor time of dynamics (default: {_MINUTES})")
    parser.add_argument("--quick", action="store_true", help="short chains, hardly sampled")
    addOptions(parser, "of each chain of the table of times", "no picture is drawn")
    return runParsed(parser, arguments)


def _run(options):
    options.chains = 1 if options.quick else _CHAINS
    maker = Maker(makeTables, lambda entries: ([], False), lambda entries: False, lambda *arguments: None)
    return runStudy(options, lambda program: _plan(options), maker)


def _plan(options):
    sizes, length = (_QUICK_SIZES, _QUICK_LENGTH) if options.quick else (_SIZES, _LENGTH)
    seconds = _SECONDS * (options.minutes or (_QUICK_MINUTES if options.quick else _MINUTES))
    rows = [PivotRow(chain, size, angle) for chain, angles in _ANGLES.items() for size in sizes for angle in angles]
    rows.append(DisorderedRow(length, _OUR_SHARE * seconds, seconds))
    skipped = [] if whyNot(CPU) is None else [("OpenMM's CPU platform", f"{whyNot(CPU)}; dynamics takes Reference")]
    return Study(rows, skipped)


if __name__ == "__main__":
    sys.exit(main())
