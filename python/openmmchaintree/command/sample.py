"""The command openmm-chaintree sample."""

import random
from pathlib import Path

import openmm.app
from openmm import unit

from ..errors import InputError
from ..structure import readStructure
from .arguments import positive, seed
from .outputfiles import checkOutput, writeJSON
from .samplereport import printReport, summarize
from .sampling import Sampling
from .status import BEYOND_LIMIT, INTERRUPTED
from .terminal import ReportConsole, interruptFlag, progress

_ENDINGS = {"dcd": ".dcd", "pdb": "-topology.pdb", "picture": ".png"}


def addParser(commands):
    """Add the command and its arguments."""
    sample = commands.add_parser(
        "sample",
        help="sample a protein free of clashes",
        description="Sample the φ, ψ and χ torsions of a protein: hard spheres, no other energy. Water and ions are "
        "left out; molecules without such torsions are fixed obstacles. Writes a trajectory (DCD), a PDB file that "
        "matches it and a picture, and prints a table.",
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
    sample.add_argument("--cut-disulfides", action="store_true", help="let the torsions between disulfides turn")


def _run(options):
    structure = readStructure(options.structure)
    prefix = structure.name if options.output is None else options.output
    files = {kind: Path(f"{prefix}{ending}") for kind, ending in _ENDINGS.items()}
    if options.json is not None:
        files["json"] = Path(options.json)
    checkOutput(files.values(), [] if options.structure is None else [options.structure])
    seed = options.seed if options.seed is not None else random.SystemRandom().randint(1, 2**31 - 1)
    try:
        sampling = Sampling(structure, seed, options.cut_disulfides)
    except (InputError, openmm.OpenMMException) as error:
        raise InputError(f"{options.structure or structure.name}: {error}") from error

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
    printReport(summary, ReportConsole())
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
