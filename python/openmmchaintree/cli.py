"""The command openmm-chaintree."""

import argparse
import io
import json
import random
import signal
import sys
from contextlib import contextmanager
from pathlib import Path

import openmm.app
from openmm import unit
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

from .report import printReport, summarize
from .sampling import Sampling
from .structure import InputError, readStructure

_BEYOND_LIMIT, _BAD_INPUT, _INTERRUPTED = 1, 2, 130


def main(arguments=None):
    """Run the command; return its exit status.

    0 if all went well, 1 if pairs are beyond their limit in the last positions, 2 if the input is bad, 130 if
    interrupted.
    """
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # Greek letters must not stop the report on any terminal
    options = _parser().parse_args(arguments)
    try:
        return options.run(options)
    except (InputError, openmm.OpenMMException) as error:
        return _fail(error)
    except OSError as error:
        return _fail(f"{error.filename}: {error.strerror}" if error.filename else error)
    except KeyboardInterrupt:
        return _INTERRUPTED


def _fail(message):
    print(f"openmm-chaintree: {message}", file=sys.stderr)
    return _BAD_INPUT


class _Parser(argparse.ArgumentParser):
    """A parser that reports an error in one line."""

    def error(self, message):
        print(f"{self.prog}: {message}", file=sys.stderr)
        sys.exit(_BAD_INPUT)


def _parser():
    parser = _Parser(prog="openmm-chaintree", description="Torsion-space Monte Carlo of proteins as hard spheres.")
    commands = parser.add_subparsers(required=True, metavar="command", parser_class=_Parser)
    sample = commands.add_parser(
        "sample",
        help="sample a protein free of clashes",
        description="Sample the φ, ψ and χ torsions of a protein: hard spheres, no other energy. Water and ions are "
        "left out; molecules without such torsions are fixed obstacles. Writes a trajectory (DCD), a PDB file that "
        "matches it and a picture, and prints a table.",
    )
    sample.set_defaults(run=_sample)
    sample.add_argument("structure", nargs="?", help="a PDB file (default: the villin headpiece in OpenMM's package)")
    sample.add_argument("--trials", type=_positive, default=100000, help="number of trials (default: %(default)s)")
    sample.add_argument("--frames", type=_positive, default=200, help="frames to write (default: %(default)s)")
    sample.add_argument("--seed", type=_seed, help="random number seed, 1 to 2147483647 (default: a new one each time)")
    sample.add_argument("-o", "--output", help="prefix of the output files (default: the structure's name)")
    sample.add_argument("--json", metavar="FILE", help="write what the table says, and all tolerated pairs, as JSON")
    sample.add_argument("--cut-disulfides", action="store_true", help="let the torsions between disulfides turn")
    return parser


def _positive(text):
    return _integer(text, 1, 10**15)


def _seed(text):
    return _integer(text, 1, 2**31 - 1)


def _integer(text, least, largest):
    try:
        value = int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number") from None
    if not least <= value <= largest:
        raise argparse.ArgumentTypeError(f"{value} is not in the range {least} to {largest}")
    return value


def _sample(options):
    structure = readStructure(options.structure)
    prefix = structure.name if options.output is None else options.output
    files = {kind: Path(f"{prefix}{ending}") for kind, ending in _ENDINGS.items()}
    if options.json is not None:
        files["json"] = Path(options.json)
    _checkOutput(files.values(), options.structure)
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
        files["json"].write_text(json.dumps(summary, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    printReport(summary, Console(highlight=False, soft_wrap=True))
    if summary["pairsBeyondLimit"]:
        return _BEYOND_LIMIT
    return _INTERRUPTED if interrupted else 0


_ENDINGS = {"dcd": ".dcd", "pdb": "-topology.pdb", "picture": ".png"}


def _checkOutput(paths, structure):
    """Refuse files that cannot be written, or that are the input, before anything is written."""
    for path in paths:
        if structure is not None and path.exists() and path.samefile(structure):
            raise InputError(f"{path}: would overwrite the structure that is read")
        if path.is_dir():
            raise InputError(f"{path}: is a folder, not a file")
        if not path.parent.is_dir():
            raise InputError(f"{path}: there is no folder {path.parent}")
        _checkWritable(path)


def _checkWritable(path):
    """Open a file for writing without changing it; this is the only test that holds for every user and file system."""
    isNew = not path.exists()
    try:
        path.open("ab").close()
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from error
    if isNew:
        path.unlink()


def _writeTrajectory(sampling, structure, path, trials, frames):
    """Run all trials and write frames evenly along them; return whether the user interrupted."""
    interval = -(-trials // frames)
    with open(path, "w+b") as file, _interruptFlag() as interrupted, _progress(trials) as advance:

        def proceed():
            advance(sampling.trials)
            return not interrupted

        # Trials have no time: a frame's label is the number of trials, at 1 ps each.
        trajectory = openmm.app.DCDFile(file, structure.topology, 1 * unit.picosecond, interval, interval)
        while sampling.trials < trials and not interrupted:
            positions = sampling.run(min(interval, trials - sampling.trials), proceed)
            trajectory.writeModel(positions * unit.nanometer)
        return bool(interrupted)


@contextmanager
def _interruptFlag():
    """Collect interrupts (Ctrl-C) in a list instead of stopping between two bytes of a file; a second one stops."""
    received = []

    def note(signum, frame):
        received.append(signum)
        signal.signal(signal.SIGINT, previous)

    previous = signal.signal(signal.SIGINT, note)
    try:
        yield received
    finally:
        signal.signal(signal.SIGINT, previous)


@contextmanager
def _progress(trials):
    """Show a progress bar on a terminal, nothing in a pipe; gives a function that takes the trials done."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda done: None
        return
    with Progress(BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), console=console, transient=True) as bar:
        task = bar.add_task("", total=trials)
        yield lambda done: bar.update(task, completed=done)


def _savePicture(path, structure, sampling):
    # Matplotlib takes longer to import than a short run.
    from .picture import savePicture

    title = f"{structure.name}, {sampling.trials:,} trials"
    savePicture(path, title, sampling.frames, [move.name for move in sampling.moves])
