"""Sample a protein in implicit solvent by trials and by Langevin dynamics, for the same time; see docs/benchmark.md.

PYTHONPATH=build/package python benchmarks/dynamics.py --csv dynamics.csv --picture dynamics.png
"""

import sys

from energy.dynamicsrows import Pair, TurnRow
from energy.dynamicstables import makeTables
from energy.options import nameOf
from energy.proteins import readSampled
from openmmchaintree.command.arguments import Parser, numberIn, positive
from openmmchaintree.command.cli import runParsed
from racing.platforms import CPU, whyNot
from racing.running import Maker, Study, addOptions, drawnBy, runStudy

_MINUTES, _TURNS, _ITERATIONS = 10, 300, 200
_QUICK_MINUTES, _QUICK_TURNS, _QUICK_ITERATIONS = 0.01, 4, 2
_SECONDS = 60  # of a minute


def main(arguments=None):
    """Run the script; return its exit status."""
    parser = Parser(
        prog="dynamics.py",
        description="Sample a protein in AMBER14 with GBn2 at 300 K, from a minimized start, by trials of the moves of "
        "examples/sample_protein.py and by Langevin dynamics on OpenMM's CPU platform with one thread, in turns; and "
        "look at energy, RMSD and radius of gyration by processor time. What is written to - goes to standard output: "
        "Markdown in place of the report, CSV while the report goes to standard error.",
    )
    parser.set_defaults(run=_run, prog=parser.prog)
    parser.add_argument(
        "structure",
        nargs="?",
        help="a PDB or mmCIF file, plain or gzipped, with amino acids; hydrogens are added if there are none (default: "
        "the villin headpiece in OpenMM's package)",
    )
    parser.add_argument("--minutes", type=numberIn(1e-3, 1e5), help=f"processor time of each run (default: {_MINUTES})")
    parser.add_argument("--turns", type=positive, help=f"of each run, and points of its curves (default: {_TURNS})")
    parser.add_argument(
        "--quick", action="store_true", help=f"{_QUICK_MINUTES} minutes in {_QUICK_TURNS} turns, hardly minimized"
    )
    addOptions(parser, None, "draw energy, RMSD and radius of gyration by processor time")
    return runParsed(parser, arguments)


def _run(options):
    options.chains = 1
    inputs = [] if options.structure is None else [options.structure]
    maker = Maker(makeTables, lambda entries: ([], False), *drawnBy("energy.dynamicspicture"))
    return runStudy(options, lambda program: _plan(options), maker, inputs)


def _plan(options):
    """Return the Study: a row for each turn, so that progress is seen, and an interrupted run keeps its turns."""
    minutes = options.minutes or (_QUICK_MINUTES if options.quick else _MINUTES)
    turns = options.turns or (_QUICK_TURNS if options.quick else _TURNS)
    iterations = _QUICK_ITERATIONS if options.quick else _ITERATIONS
    pair = Pair(lambda: readSampled(options.structure), iterations)
    seconds = _SECONDS * minutes / turns
    rows = [TurnRow(nameOf(options.structure), pair, turn, turns, seconds) for turn in range(turns + 1)]
    skipped = [] if whyNot(CPU) is None else [("OpenMM's CPU platform", f"{whyNot(CPU)}; dynamics takes Reference")]
    return Study(rows, skipped)


if __name__ == "__main__":
    sys.exit(main())
