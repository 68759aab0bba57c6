"""The command openmm-chaintree repair."""

from pathlib import Path

from ..errors import InputError
from ..structures.modelfile import readModelFile
from .arguments import addScheduler, numberIn, positive, refuseWithout, seed
from .outputs.outputfiles import Writing, addOverwrite, asJSON, checkOutputs
from .repairfolder import NOT_CLEAN, repairFolder
from .repairjob import HYDROGENS, KEEP, RepairJob, runRepair
from .reports.noteoutput import addNotes, asText
from .reports.repairreport import asCSV, printReport, summarize
from .terminal import BAD_INPUT, ReportConsole, printError


def addArguments(parser):
    """Describe the command and its arguments to a parser."""
    parser.description = (
        "Remove the clashes of a model of proteins, nucleic acids and their complexes, and move as little as possible: "
        "side chains near clashes turn, then backbones near clashes that remain, and chains of complexes shift. Bond "
        "lengths and angles stay, except disulfides that are far from 0.205 nm. The repaired file differs from the "
        "given one in coordinates only. The report has MolProbity's clashscore before and after, with hydrogens placed "
        "as by Reduce. The exit status is 3 if the result is not clean: a clashscore above --clean, or a pierced ring."
    )
    parser.set_defaults(run=_run)
    parser.add_argument(
        "structure",
        help="a PDB or mmCIF file, plain or compressed, of which all models are repaired, or a folder of such files",
    )
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="the repaired file or folder (default: NAME-repaired, same kind)"
    )
    parser.add_argument(
        "--hydrogens",
        choices=HYDROGENS,
        default=KEEP,
        help="in the repaired file: keep those of the given file, add all where Reduce places them, or write none "
        "(default: %(default)s)",
    )
    parser.add_argument("--fix", metavar="ATOMS", help="atoms that must not move, in MDTraj's selection language")
    parser.add_argument("--move", metavar="ATOMS", help="the only atoms that may move, in MDTraj's selection language")
    parser.add_argument(
        "--interface",
        metavar="A,B",
        help="move only residues of these two chains that are near the other chain, and chains as a whole",
    )
    parser.add_argument(
        "--max-shift", type=numberIn(1e-3, 10), metavar="NM", help="the largest shift of any backbone atom, in nm"
    )
    parser.add_argument("--side-chains-only", action="store_true", help="leave backbones and whole chains in place")
    parser.add_argument(
        "--turn-ligands",
        action="store_true",
        help="let molecules move and turn that are bound to no protein or nucleic acid (default: they stay)",
    )
    parser.add_argument(
        "--mend-bonds",
        action="store_true",
        help="first give residues with broken bonds ideal bond lengths and angles, by OpenMM's minimizer",
    )
    parser.add_argument(
        "--clean",
        type=numberIn(0, 1000),
        default=2.0,
        metavar="SCORE",
        help="the largest clashscore of a clean model (default: %(default)g)",
    )
    parser.add_argument("--seed", type=seed, default=1, help="random number seed, 1 to 2147483647 (default: 1)")
    parser.add_argument(
        "--rows", type=positive, default=10, metavar="N", help="maximum number of rows per list (default: %(default)s)"
    )
    parser.add_argument("--csv", metavar="FILE", help="write the shift of every residue as CSV (-: print it)")
    parser.add_argument("--json", metavar="FILE", help="write everything as JSON (-: print it)")
    parser.add_argument("--workers", type=positive, metavar="W", help="processes for a folder (default: all cores)")
    parser.add_argument("--resume", action="store_true", help="keep repaired files that the folder of results has")
    addScheduler(parser, "the repairs of a folder")
    addOverwrite(parser)
    addNotes(parser)


def _run(options):
    settings = {
        "fixed": options.fix,
        "move": options.move,
        "interface": _readInterface(options.interface),
        "maxShift": options.max_shift,
        "sideChainsOnly": options.side_chains_only,
        "turnsLigands": options.turn_ligands,
        "mendsBonds": options.mend_bonds,
        "cleanBelow": options.clean,
        "seed": options.seed,
    }
    if Path(options.structure).is_dir():
        return repairFolder(options, settings)
    refuseWithout(options, "a folder of models", "workers", "resume", "scheduler")
    return _repairFile(options, settings)


def _repairFile(options, settings):
    file = readModelFile(options.structure)
    name = options.output or _defaultName(options.structure)
    _checkKind(name, file)
    names = {"structure": name, "csv": options.csv, "json": options.json, "notes": options.notes}
    outputs = checkOutputs(names, [options.structure], options.overwrite)
    repaired = runRepair(RepairJob(options.structure, settings, options.hydrogens))
    summary = summarize(options.structure, repaired, name)
    writers = {
        "structure": lambda output: output.write(repaired.contentFor(name)),
        "csv": lambda output: output.write(asCSV(repaired)),
        "json": lambda output: output.write(asJSON(summary)),
        "notes": lambda output: output.write(asText(repaired.notes)),
    }
    with Writing() as writing:
        for kind, output in outputs.items():
            writing.write(output, writers[kind])
    printReport(summary, writing.files, options.rows, ReportConsole(outputs.values()), options.verbose)
    if writing.failures:
        printError(writing.describeFailures())
        return BAD_INPUT
    return 0 if summary["isClean"] else NOT_CLEAN


def _readInterface(text):
    if text is None:
        return None
    chains = [name.strip() for name in text.split(",")]
    if len(chains) != 2 or not all(chains) or chains[0] == chains[1]:
        raise InputError(f"--interface: {text!r} does not name two chains, as A,B does")
    return tuple(chains)


def _defaultName(path):
    """Return the name of the repaired file in the working folder: x-repaired.pdb.gz for folder/x.pdb.gz."""
    name = Path(path).name
    stem, dot, suffix = name.partition(".")
    return f"{stem}-repaired{dot}{suffix}" if stem else f"repaired{name}"


def _checkKind(name, file):
    """Refuse a name of a repaired file that says another kind than that of the given file."""
    suffix = Path(name.lower().removesuffix(".gz").removesuffix(".bz2")).suffix
    others = {".pdb", ".ent", ".cif", ".mmcif", ".bcif", ".gro"} - set(file.suffixes)
    if suffix in others:
        raise InputError(f"{name}: the repaired file is of the kind of the given one: {', '.join(file.suffixes)}")
