"""Measure how exact the engine and weaker methods are, for the time that they take; see docs/accuracy.md.

PYTHONPATH=build/package python benchmarks/accuracy.py --markdown accuracy.md --picture accuracy.png
"""

import sys

from openmmchaintree.command.arguments import Parser
from openmmchaintree.command.cli import runParsed
from precision.goals import describeGoal, judgeGoals
from precision.rows import DRIFT, TOUCH, TURNS, DriftRow, ForceRow, TouchRow
from precision.softforce import whyNoReference
from precision.tables import makeTables
from racing.platforms import CPU, whyNot
from racing.races import LAZY_GRID
from racing.running import Maker, Study, addOptions, drawnBy, runStudy

_SIZES = (100, 1000, 10000, 100000)
_QUICK_SIZES, _QUICK_TURNS = (100, 1000), 10000


def main(arguments=None):
    """Run the script; return its exit status."""
    parser = Parser(
        prog="accuracy.py",
        description="Measure how far positions are from exact ones after many turns, which clashes are missed or "
        "invented where spheres all but touch, and how exact the soft force is, by the engine on all its paths and by "
        "weaker methods, against long double. What is written to - goes to standard output: Markdown in place of the "
        "report, CSV while the report goes to standard error.",
    )
    parser.set_defaults(run=_run, prog=parser.prog)
    parser.add_argument("--quick", action="store_true", help="only the smallest chains, and few turns")
    addOptions(parser, f"turns after which positions are looked at last (default: {TURNS})", "draw error by time")
    return runParsed(parser, arguments)


def _run(options):
    options.chains = 1
    options.trials = options.trials or (_QUICK_TURNS if options.quick else TURNS)
    sizes = _QUICK_SIZES if options.quick else _SIZES
    maker = Maker(makeTables, _judge, *drawnBy("precision.picture"))
    return runStudy(options, lambda program: _plan(sizes, program), maker)


def _plan(sizes, program):
    """Return the Study of accuracy for chains of some sizes."""
    rows = [DriftRow(size, _namesOf(program, DRIFT)) for size in sizes]
    rows += [TouchRow(size, [*_namesOf(program, TOUCH), LAZY_GRID]) for size in sizes]
    if whyNoReference() is None:
        rows += [ForceRow(size) for size in sizes]
        skipped = [("forces on the CPU platform", whyNot(CPU))]
    else:
        skipped = [("forces", whyNoReference())]
    return Study(rows, [entry for entry in skipped if entry[1] is not None])


def _namesOf(program, measure):
    return [contestant.name for contestant in program.contestants if contestant.measure == measure]


def _judge(entries):
    goals = judgeGoals(entries)
    return [describeGoal(goal) for goal in goals], any(goal["reached"] is False for goal in goals)


if __name__ == "__main__":
    sys.exit(main())
