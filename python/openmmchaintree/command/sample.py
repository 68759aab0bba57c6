"""The command openmm-chaintree sample."""

import argparse
import random
from pathlib import Path

import openmm.app
from openmm import unit

from ..errors import InputError
from ..structure import readStructure
from ..torsions import KIND_WORDS
from .arguments import listOf, positive, seed
from .outputfiles import checkOutput, writeJSON
from .plan import DEFAULT_KINDS, Choice
from .planreport import describePlan
from .samplereport import printReport, summarize
from .sampling import Sampling
from .status import BEYOND_LIMIT, INTERRUPTED
from .terminal import ReportConsole, interruptFlag, progress

_ENDINGS = {"dcd": ".dcd", "pdb": "-topology.pdb", "picture": ".png"}

_DESCRIPTION = """\
Sample the torsions of proteins and nucleic acids: hard spheres, no other energy. Water and ions are left out; what has
no torsions stays where it is, as an obstacle. Says what moves and what stays, writes a trajectory (DCD), a PDB file
that matches it and a picture, and prints a table."""

_SELECTIONS = """
A SELECTION is in the language of MDTraj (https://mdtraj.org/latest/atom_selection.html), in quotes:

  --move "segname A"                   chain A by its name; "chainid 0" is the first chain of the file
  --move "resSeq 10 to 20"             residues by their numbers in the file (52 is 52 and 52A); "resid" counts from 0
  --move "sidechain and not resname PRO"
  --fix "protein" --rigid-bodies       what is bound to a protein, within it
  --fix "nucleic or (segname B and resSeq < 100)"
  --fix "name CA \\"C1'\\""             names with primes in quotes

--move chooses which torsions turn: those whose third atom (of C-N-CA-C: CA) it selects. So "backbone" selects φ and ψ,
"sidechain" all χ. What hangs on them goes along; of each molecule the largest part of the backbone that does not turn
stays where it is. Atoms of --fix never move, whatever turns: torsions between two fixed parts are left out, so that of
a loop between fixed ends only the side chains turn.
"""


def addParser(commands):
    """Add the command and its arguments."""
    sample = commands.add_parser(
        "sample",
        help="sample proteins and nucleic acids free of clashes",
        description=_DESCRIPTION,
        epilog=_SELECTIONS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    sample.set_defaults(run=_run)
    sample.add_argument(
        "structure",
        nargs="?",
        help="a PDB or mmCIF file, plain or gzipped (default: the villin headpiece in OpenMM's package)",
    )
    sample.add_argument("--trials", type=positive, default=100000, help="number of trials (default: %(default)s)")
    sample.add_argument("--frames", type=positive, default=200, help="frames to write (default: %(default)s)")
    sample.add_argument("--seed", type=seed, help="random number seed, 1 to 2147483647 (default: a new one each time)")
    sample.add_argument("-o", "--output", help="prefix of the output files (default: the structure's name)")
    sample.add_argument("--json", metavar="FILE", help="write what the table says, and all tolerated pairs, as JSON")
    sample.add_argument(
        "--torsions",
        type=listOf(KIND_WORDS),
        default=DEFAULT_KINDS,
        metavar="KINDS",
        help=f"kinds of torsions that turn, with commas between them, of {', '.join(KIND_WORDS)} "
        f"(default: {','.join(DEFAULT_KINDS)})",
    )
    sample.add_argument("--move", metavar="SELECTION", help="atoms whose torsions turn (default: all); see below")
    sample.add_argument("--fix", metavar="SELECTION", help="atoms that never move (default: none); see below")
    sample.add_argument(
        "--rigid-bodies",
        action="store_true",
        help="move molecules as a whole, too, all but those that --fix holds and fragments at gaps in a chain; with "
        "--move, those that it selects atoms of",
    )
    sample.add_argument("--cut-disulfides", action="store_true", help="let the torsions between disulfides turn")


def _run(options):
    structure = readStructure(options.structure)
    prefix = structure.name if options.output is None else options.output
    files = {kind: Path(f"{prefix}{ending}") for kind, ending in _ENDINGS.items()}
    if options.json is not None:
        files["json"] = Path(options.json)
    checkOutput(files.values(), [] if options.structure is None else [options.structure])
    choice = Choice(tuple(options.torsions), options.move, options.fix, options.rigid_bodies, options.cut_disulfides)
    seed = options.seed if options.seed is not None else random.SystemRandom().randint(1, 2**31 - 1)
    try:
        sampling = Sampling(structure, seed, choice)
    except (InputError, openmm.OpenMMException) as error:
        raise InputError(f"{options.structure or structure.name}: {error}") from error

    console = ReportConsole()
    for line in describePlan(sampling.plan):
        console.print(line)
    with open(files["pdb"], "w") as file:
        openmm.app.PDBFile.writeFile(structure.topology, structure.positions * unit.nanometer, file, keepIds=True)
    interrupted = _writeTrajectory(sampling, structure, files["dcd"], options.trials, options.frames)
    if len(sampling.frames) > 1:
        _savePicture(files["picture"], structure, sampling)
    else:
        del files["picture"]
    summary = summarize(sampling, structure, seed, [str(path) for path in files.values()], interrupted)
    if "json" in files:
        writeJSON(files["json"], summary)
    printReport(summary, console)
    if summary["pairsBeyondLimit"]:
        return BEYOND_LIMIT
    return INTERRUPTED if interrupted else 0


def _writeTrajectory(sampling, structure, path, trials, frames):
    """Run all trials and write frames evenly along them; return whether the user interrupted."""
    interval = -(-trials // frames)
    with open(path, "w+b") as file, interruptFlag() as interrupted, progress(trials) as advance:

        def proceed():
            advance(sampling.trials)
            return not interrupted

        # Trials have no time: a frame's label is the number of trials, at 1 ps each.
        trajectory = openmm.app.DCDFile(file, structure.topology, 1 * unit.picosecond, interval, interval)
        while sampling.trials < trials and not interrupted:
            positions = sampling.run(min(interval, trials - sampling.trials), proceed)
            trajectory.writeModel(positions * unit.nanometer)
        return bool(interrupted)


def _savePicture(path, structure, sampling):
    # Matplotlib takes longer to import than a short run.
    from .samplepicture import savePicture

    title = f"{structure.name}, {sampling.trials:,} trials"
    savePicture(path, title, sampling.frames, [move.name for move in sampling.moves])
