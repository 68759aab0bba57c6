"""The command openmm-chaintree clashes."""

from pathlib import Path

from ..clashes import ClashSearch
from ..errors import InputError
from ..radii import RADII_SETS
from .arguments import positive
from .clashreport import printReport, summarize, writeCSV
from .outputfiles import checkOutput, checkPicture, writeJSON
from .status import BAD_INPUT, INTERRUPTED
from .terminal import ReportConsole, interruptFlag, printError, progress


def addParser(commands):
    """Add the command and its arguments."""
    clashes = commands.add_parser(
        "clashes",
        help="find the clashes of a structure or trajectory",
        description="Find atoms that overlap by more than 0.04 nm (0.1 nm where one may donate a hydrogen bond to the "
        "other) and are more than three bonds apart: in all models of a structure, or in all frames of a trajectory. "
        "Models, frames and particles are numbered from 0. Water and ions (residues of a single atom) are left out, of "
        "alternate conformers all but the first. Positions are taken as they are, without periodic images.",
    )
    clashes.set_defaults(run=_run)
    clashes.add_argument(
        "structure",
        nargs="?",
        help="a PDB or mmCIF file, plain or gzipped (default: the villin headpiece in OpenMM's package)",
    )
    clashes.add_argument(
        "trajectory", nargs="?", help="a DCD or XTC file with the atoms of the structure, in place of its models"
    )
    clashes.add_argument("--water", action="store_true", help="look at water, too")
    clashes.add_argument("--ions", action="store_true", help="look at ions, too")
    clashes.add_argument(
        "--radii", choices=RADII_SETS, help="the set of radii (default: all-atom if there are hydrogens)"
    )
    clashes.add_argument(
        "--rows", type=positive, default=10, metavar="N", help="rows of each table at most (default: %(default)s)"
    )
    clashes.add_argument("--csv", metavar="FILE", help="write a line of CSV for every clash")
    clashes.add_argument("--json", metavar="FILE", help="write everything as JSON")
    clashes.add_argument("--picture", metavar="FILE", help="draw the clashes by frame and residue (.png, .pdf or .svg)")


def _run(options):
    outputs = {"csv": options.csv, "json": options.json, "picture": options.picture}
    outputs = {kind: Path(path) for kind, path in outputs.items() if path is not None}
    inputs = [path for path in (options.structure, options.trajectory) if path is not None]
    checkOutput(outputs.values(), inputs)
    if "picture" in outputs:
        checkPicture(outputs["picture"])
    search = ClashSearch(options.structure, options.trajectory, options.radii, options.water, options.ions)
    frames, damage, interrupted = _findAll(search)
    if damage is not None and not frames:
        raise damage
    summary = summarize(search, frames, damage, interrupted)
    if "csv" in outputs:
        writeCSV(outputs["csv"], frames)
    if "json" in outputs:
        writeJSON(outputs["json"], summary)
    if "picture" in outputs:
        _savePicture(outputs["picture"], search, frames)
    printReport(summary, list(outputs.values()), options.rows, ReportConsole())
    if damage is not None:
        printError(f"{damage}; the results are those of the frames before it")
        return BAD_INPUT
    return INTERRUPTED if interrupted else 0


def _findAll(search):
    """Return the list of FrameClashes before a damaged frame or an interrupt; that damage; whether that interrupt."""
    frames = []
    damage = None
    with interruptFlag() as interrupted, progress(search.frameCount) as advance:
        try:
            for frame in search:
                frames.append(frame)
                advance(len(frames))
                if interrupted:
                    break
        except InputError as error:
            damage = error
        return frames, damage, bool(interrupted)


def _savePicture(path, search, frames):
    # Matplotlib takes longer to import than most searches.
    from .clashpicture import savePicture

    savePicture(path, search, frames)
