"""Race the engine against other methods on the same trials; see docs/benchmark.md.

PYTHONPATH=build/package python benchmarks/race.py --markdown tables.md --picture figures.png
"""

import sys

from openmmchaintree.command.arguments import Parser, listOf, positive
from openmmchaintree.command.cli import runParsed
from openmmchaintree.errors import InputError
from racing.proteins import ProteinModels, findProteins, readProtein
from racing.rows import GROUPS, WITH_PROTEINS, Plan
from racing.running import Maker, Study, addOptions, drawnBy, runStudy
from racing.tables import makeTables

_PICTURED = "figures"  # the group that the picture shows
_CHAINS = 5
_QUICK_CHAINS, _QUICK_TRIALS = 2, 500


def main(arguments=None):
    """Run the script; return its exit status."""
    parser = Parser(
        prog="race.py",
        description="Race the engine against cell grids, trees of boxes and the ChainTree as published in 2002, in "
        "turns on the same trials, all of whose verdicts are compared; and against what one could call from Python. "
        "Times are those of the processor. The groups of rows are "
        + "; ".join(f"{group} ({words[0].lower()}{words[1:]})" for group, words in GROUPS.items())
        + ". What is written to - goes to standard output: Markdown in place of the report, CSV while the report goes "
        "to standard error.",
    )
    parser.set_defaults(run=_run, prog=parser.prog)
    parser.add_argument(
        "structures",
        nargs="*",
        metavar="structure",
        help="PDB or mmCIF files, plain or gzipped, of each the longest chain of amino acids (default: the villin "
        "headpiece in OpenMM's package, and of bpti_h.pdb, 5dfr_h.pdb, 1shg.pdb, 1htb.pdb and 2cas.pdb.gz those that "
        "are in the folder that the variable CHAINTREE_TEST_DATA names)",
    )
    parser.add_argument(
        "--rows", type=listOf(GROUPS), metavar="GROUPS", help="groups of rows, with commas between them (default: all)"
    )
    parser.add_argument(
        "--contestants",
        metavar="NAMES",
        help="those who race, of the program in C, with commas between them (default: whom a group is about)",
    )
    parser.add_argument(
        "--chains",
        type=positive,
        help=f"chains of each row: random ones by as many seeds, of others as many runs with moves of their own "
        f"(default: {_CHAINS})",
    )
    parser.add_argument(
        "--quick",
        action="store_true",
        help=f"only the smallest chains and protein, {_QUICK_CHAINS} chains a row, {_QUICK_TRIALS} trials each",
    )
    addOptions(
        parser,
        "trials of each chain, in place of the number that a group of rows has by itself",
        "draw the paper's figures 7 and 8 and its table 1 anew",
    )
    return runParsed(parser, arguments)


def _run(options):
    groups = list(GROUPS) if options.rows is None else options.rows
    if options.picture and options.read is None and _PICTURED not in groups:
        raise InputError(f"--picture shows the rows of {_PICTURED}, which --rows leaves out")
    options.chains = options.chains or (_QUICK_CHAINS if options.quick else _CHAINS)
    options.trials = options.trials or (_QUICK_TRIALS if options.quick else None)

    def plan(program):
        return _plan(options, groups, program)

    maker = Maker(makeTables, lambda entries: ([], False), *drawnBy("racing.picture"))
    return runStudy(options, plan, maker, options.structures)


def _plan(options, groups, program):
    """Return the Study of the races that the user wants."""
    contestants = _chooseContestants(options.contestants, program)
    if options.structures:
        proteins, missing = [readProtein(path) for path in options.structures], []
    else:
        proteins, missing = findProteins(isQuick=options.quick or not WITH_PROTEINS & set(groups))
    models = [ProteinModels(protein) for protein in proteins]
    rows, skipped = Plan(groups, program.contestants, contestants, models, options.quick).makeRows()
    return Study(rows, skipped + [(name, "not in the folder that CHAINTREE_TEST_DATA names") for name in missing])


def _chooseContestants(text, program):
    """Return the contestants that the user names, or None."""
    if text is None:
        return None
    known = list(dict.fromkeys(contestant.name for contestant in program.contestants))
    for name in text.split(","):
        if name not in known:
            raise InputError(f"there is no contestant {name!r}; there are {', '.join(known)}")
    return text.split(",")


if __name__ == "__main__":
    sys.exit(main())
