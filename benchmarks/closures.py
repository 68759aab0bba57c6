"""Measure how long the closures of windows in backbones take: all of them, and the near one; see docs/benchmark.md.

PYTHONPATH=build/package python benchmarks/closures.py --markdown closures.md
"""

import json
import os
import statistics
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

from openmmchaintree.command.arguments import Parser, positive
from openmmchaintree.command.cli import runParsed
from openmmchaintree.errors import InputError
from openmmchaintree.loading import compiledFolder
from precision.goals import describeGoal
from racing.backbones import describeBackbones
from racing.program import ProgramError
from racing.proteins import Protein, findProteins, readProtein
from racing.running import Maker, Study, addOptions, runStudy
from racing.table import Table, groupBy

_VARIABLE = "CHAINTREE_CLOSURES"
_PROGRAM = "platforms/reference/moves/chaintree_closures"
_GROUP = "closures"
_NAMES = {"all": "all closures", "near": "the near closure, by Newton's method"}
_PARTS = {"microseconds": "median", "percentile99": "99 %", "worst": "worst"}
_GOALS = (("all", "microseconds", 4), ("all", "percentile99", 12), ("near", "microseconds", 2))  # µs
_RUNS, _WINDOWS = 3, 2000
_QUICK_RUNS, _QUICK_WINDOWS = 1, 50


class Row(NamedTuple):
    """Windows of a protein. The others of a run have other seeds."""

    program: Path
    protein: Protein

    group = _GROUP
    mostChains = sys.maxsize

    def __str__(self):
        """Return what messages call it."""
        return self.protein.name

    def run(self, course, seed):
        """Return the entries of a run."""
        command = [str(self.program), str(course.trials), "0", str(seed)]
        text = describeBackbones(self.protein.topology, self.protein.positions)
        done = subprocess.run(command, input=text, capture_output=True, text=True)
        if done.returncode != 0:
            raise ProgramError(f"{self.program.name}: {done.stdout or done.stderr}")
        found = json.loads(done.stdout)
        shared = {key: found[key] for key in ("windows", "closable", "closed")}
        shared["closures"] = sum(number * count for number, count in enumerate(found["counts"]))
        return [
            {"group": _GROUP, "contestant": kind, "chain": self.protein.name, **found[kind], **shared}
            for kind in _NAMES
        ]


def main(arguments=None):
    """Run the script; return its exit status."""
    parser = Parser(
        prog="closures.py",
        description="Measure how long it takes to close windows of eight or nine torsions in backbones of proteins: "
        "to find all closures, and the near one by Newton's method. In every other window two or three torsions turn "
        "by up to 16 degrees before. All windows are solved in turn, seven times; of each the shortest time counts.",
    )
    parser.set_defaults(run=_run, prog=parser.prog)
    parser.add_argument(
        "structures",
        nargs="*",
        metavar="structure",
        help="PDB or mmCIF files, of each the longest chain of amino acids (default: those of race.py)",
    )
    parser.add_argument(
        "--closures",
        metavar="FILE",
        help=f"the program chaintree_closures (default: the one that the variable {_VARIABLE} names, or that of the "
        "build from which openmmchaintree is imported)",
    )
    parser.add_argument("--chains", type=positive, help=f"runs of each row, with seeds of their own (default: {_RUNS})")
    parser.add_argument(
        "--quick",
        action="store_true",
        help=f"only the smallest protein, {_QUICK_RUNS} run, {_QUICK_WINDOWS} windows",
    )
    addOptions(parser, f"windows of each run (default: {_WINDOWS})", "draw nothing")
    return runParsed(parser, arguments)


def _run(options):
    options.chains = options.chains or (_QUICK_RUNS if options.quick else _RUNS)
    options.trials = options.trials or (_QUICK_WINDOWS if options.quick else _WINDOWS)
    maker = Maker(_makeTables, _judge, lambda entries: False, lambda *arguments: None)
    return runStudy(options, lambda program: _plan(options), maker, options.structures)


def _plan(options):
    """Return the Study of the proteins that the user wants."""
    program = Path(options.closures or os.environ.get(_VARIABLE) or compiledFolder().parents[1] / _PROGRAM)
    if not program.exists():
        raise InputError(f"there is no program {program}: name it by --closures or {_VARIABLE}")
    if options.structures:
        proteins, missing = [readProtein(path) for path in options.structures], []
    else:
        proteins, missing = findProteins(isQuick=options.quick)
    rows = [Row(program.resolve(), protein) for protein in proteins]
    return Study(rows, [(name, "not in the folder that CHAINTREE_TEST_DATA names") for name in missing])


def _combine(entries):
    """Return times by kind and protein: medians of runs."""
    grouped = groupBy(entries, lambda entry: (entry["contestant"], entry["chain"]))
    return {
        key: {part: statistics.median(run[part] for run in runs) for part in _PARTS} for key, runs in grouped.items()
    }


def _makeTables(entries):
    times = _combine(entries)
    rows = [[_NAMES[kind], chain, *(f"{parts[part]:.2f}" for part in _PARTS)] for (kind, chain), parts in times.items()]
    return [Table("Closures of a window, µs", ["what", "protein", *_PARTS.values()], rows, 2, [])]


def _judge(entries):
    """Return lines about goals; a machine may be slow, which is no failure."""
    times = _combine(entries)
    lines = []
    for kind, part, goal in _GOALS:
        slowest = max(parts[part] for (ofKind, _), parts in times.items() if ofKind == kind)
        lines.append(
            describeGoal(
                {
                    "what": f"{_NAMES[kind]}: {_PARTS[part]} at most {goal} µs",
                    "reached": slowest <= goal,
                    "evidence": f"{slowest:.2f} of the slowest protein",
                }
            )
        )
    return lines, False


if __name__ == "__main__":
    sys.exit(main())
