"""What the command lines of the benchmarks of energies have in common."""

from openmmchaintree.command.arguments import listOf, positive
from racing.platforms import CPU, whyNot

from energy.proteins import findFiles


def addRowOptions(parser, groups, files, runs, warmTrials):
    """Add the structures, and which rows they make, how often and after how much relaxation."""
    parser.add_argument(
        "structures",
        nargs="*",
        metavar="structure",
        help="PDB or mmCIF files, plain or gzipped, of each all amino acids; hydrogens are added if there are none "
        f"(default: the villin headpiece in OpenMM's package, and of {', '.join(files)} those that are in the folder "
        "that the variable CHAINTREE_TEST_DATA names)",
    )
    parser.add_argument(
        "--rows", type=listOf(groups), metavar="GROUPS", help="groups of rows, with commas between them (default: all)"
    )
    parser.add_argument("--runs", type=positive, help=f"of each row, each by a seed of its own (default: {runs})")
    parser.add_argument(
        "--warm",
        type=positive,
        metavar="TRIALS",
        help=f"trials that each protein goes through before anything is measured (default: {warmTrials})",
    )


def settle(options, groups, runs, warmTrials, quickRuns, quickTrials):
    """Set what the user has left to the defaults, those of a quick run if one is wanted."""
    options.rows = list(groups) if options.rows is None else options.rows
    options.chains = options.runs or (quickRuns if options.quick else runs)
    options.trials = options.trials or (quickTrials if options.quick else None)
    options.warm = options.warm or (quickTrials if options.quick else warmTrials)


def chooseStructures(options, files):
    """Return the paths of what is run, None for the villin headpiece, and the names of files that are not there."""
    if options.structures:
        return options.structures, []
    found, missing = ([], []) if options.quick else findFiles(files)
    return [None, *found], missing


def nameOf(path):
    """Return what a structure is called in tables."""
    return "villin" if path is None else str(path).rpartition("/")[2].partition(".")[0]


def describeSkipped(missing):
    """Return what is left out, and why: rows of these files, and OpenMM's energies where it lacks the platform."""
    skipped = [(name, "not in the folder that CHAINTREE_TEST_DATA names") for name in missing]
    return skipped if whyNot(CPU) is None else [*skipped, ("OpenMM's energies", whyNot(CPU))]
