"""The command openmm-chaintree sample."""

import argparse
import os
import random
from typing import NamedTuple

import openmm

from ..bonds import DISULFIDES, LOOPS
from ..errors import InputError
from ..structures.structure import readStructure, withoutAtoms
from ..torsions import KIND_WORDS, KINDS_WITH_ENERGIES
from .arguments import frameCount, listOf, notNegative, numberIn, positive, seed
from .config import addConfig, applySettings, readSettings, settingsOf
from .ending import endRun, writeReports
from .energymodel import EnergyModel
from .energyoptions import addEnergyOptions, readEnergyOptions
from .forbidden import measureForbidden
from .hydrogens import addHydrogens
from .outputs.outputfiles import OutputError, Writing, addOverwrite, beginning, checkOutputs
from .outputs.scenefiles import removeScene, writeScene
from .outputs.trajectoryfile import TrajectoryFile
from .plan import DEFAULT_KINDS, Choice, selectByOption
from .replicaoptions import addReplicaOptions, readReplicaOptions
from .replicarun import SavedRun
from .replicasample import replicaNames, sampleReplicas
from .reports.energyreport import describeEnergies
from .reports.noteoutput import addNotes
from .reports.planreport import describePlan
from .reports.samplereport import printReport, summarize
from .sampling import Sampling
from .terminal import ReportConsole, collectionPaused, interruptFlag, printError, progress

__all__ = ["addArguments", "applySettings"]

_NONE = "none"

_ENDINGS = {"trajectory": ".dcd", "topology": "-topology.pdb", "picture": ".png", "settings": "-settings.toml"}

_DESCRIPTION = """\
Sample the torsions of proteins and nucleic acids: as hard spheres, or, with --forcefield, the Boltzmann distribution
exp(-U/kT). Water and ions are left out; what has no torsions stays where it is, as an obstacle. Says what moves and
what stays, writes a trajectory (DCD), which begins with the start, a PDB file that matches it and a picture, and
prints a table."""

_SELECTIONS = """
In a force field, with implicit solvent:

  openmm-chaintree sample my.pdb --add-hydrogens --forcefield amber14-all.xml implicit/gbn2.xml --temperature 300

A force field needs all atoms of each residue: --add-hydrogens adds hydrogens, PDBFixer what else is missing. Moves
are those that folded chains accept, where hard spheres alone just turn torsions: windows of the backbone turn so that
what lies behind them stays or hardly moves, and side chains turn by a little and go from rotamer to rotamer. Bond
lengths and angles stay as they are at the start.

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
a loop between fixed ends only the side chains turn. To sample a loop as a whole, by moves that keep it closed:

  --fix "not resSeq 20 to 30" --close loops
"""


def addArguments(sample):
    """Describe the command and its arguments to a parser."""
    sample.description = _DESCRIPTION
    sample.epilog = _SELECTIONS
    sample.formatter_class = argparse.RawDescriptionHelpFormatter
    sample.set_defaults(run=_run, parser=sample)
    sample.add_argument(
        "structure",
        nargs="?",
        help="a PDB, mmCIF or BinaryCIF file, plain or compressed (default: the villin headpiece in OpenMM's package)",
    )
    sample.add_argument(
        "--model", type=notNegative, default=0, metavar="K", help="the model to sample, from 0 (default: %(default)s)"
    )
    sample.add_argument("--trials", type=positive, default=100000, help="number of trials (default: %(default)s)")
    sample.add_argument(
        "--frames", type=frameCount, default=200, help="frames to write after the start (default: %(default)s)"
    )
    sample.add_argument("--seed", type=seed, help="random number seed, 1 to 2147483647 (default: a new one each time)")
    sample.add_argument(
        "-o", "--output", metavar="PREFIX", help="what the names of output files begin with (default: the structure's)"
    )
    sample.add_argument(
        "--json",
        metavar="FILE",
        help="write what the table says, and all tolerated pairs, as JSON (-: to standard output, and the report to "
        "standard error)",
    )
    addOverwrite(sample)
    addNotes(sample)
    addConfig(sample)
    addEnergyOptions(sample)
    addReplicaOptions(sample)
    sample.add_argument(
        "--torsions",
        type=listOf(KIND_WORDS),
        metavar="KINDS",
        help=f"kinds of torsions that turn, with commas between them, of {', '.join(KIND_WORDS)} "
        f"(default: {','.join(DEFAULT_KINDS)}; in a force field {','.join(KINDS_WITH_ENERGIES)}, all bonds in no ring)",
    )
    sample.add_argument("--leave-out", metavar="SELECTION", help="atoms that are left out, such as those of a ligand")
    sample.add_argument(
        "--unknown-radius",
        type=numberIn(0, 1),
        metavar="NM",
        help="the radius of atoms of elements of which none is known, such as boron: 0.2 (default: they are an error)",
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
    sample.add_argument(
        "--cut-metals", action="store_true", help="let the torsions between residues that bind a metal turn"
    )
    sample.add_argument(
        "--close",
        type=listOf((DISULFIDES, LOOPS, _NONE)),
        metavar="WHAT",
        help=f"{DISULFIDES}, {LOOPS} or both with a comma between: let the torsions of rings that disulfides close, "
        f"and of loops between parts that --fix holds, turn by closed moves, which keep the bonds; or {_NONE} "
        f"(default: {DISULFIDES} in a force field, unless they are cut, else {_NONE})",
    )
    sample.add_argument(
        "--allow-unbonded",
        action="store_true",
        help="go on though atoms as near as if they were bonded, but that are not, would leave each other",
    )


class Prepared(NamedTuple):
    """A run before it begins.

    options : argparse.Namespace; settings : dict, for --config; outputs : dict of Output by kind; console : Console;
    sampling : Sampling; energyModel : EnergyModel or None; seed : int; addedHydrogens : int
    """

    options: argparse.Namespace
    settings: dict
    outputs: dict
    console: ReportConsole
    sampling: Sampling
    energyModel: EnergyModel | None
    seed: int
    addedHydrogens: int


def _run(options):
    saved = None if options.resume is None else SavedRun(options.resume)
    energyModel, pH = readEnergyOptions(options)
    replicas = readReplicaOptions(options)
    if replicas is not None and replicas.temperatures is not None:
        energyModel.temperature = replicas.temperatures[0]
    seed = options.seed if options.seed is not None else random.SystemRandom().randint(1, 2**31 - 1)
    settings = {**settingsOf(options.parser, options), "seed": seed}
    if saved is not None:
        saved.checkSettings(settings)
        options.frames = settings["frames"] = saved.framesOf(options.trials)
    _checkFolder(options)
    for name in () if saved is None else options.pathsOfRun:
        saved.checkPath(name, getattr(options, name))
    with collectionPaused():
        structure = readStructure(options.structure, options.model)
    outputs = _checkOutputs(options, structure.name, settings, replicas, saved)
    console = ReportConsole(outputs.values())
    choice = Choice(
        None if options.torsions is None else tuple(options.torsions),
        options.move,
        options.fix,
        options.rigid_bodies,
        options.cut_disulfides,
        options.cut_metals,
        options.allow_unbonded,
        None if options.close is None else tuple(what for what in options.close if what != _NONE),
        energyModel is not None,
        options.unknown_radius,
    )
    try:
        with collectionPaused():
            structure, added = _prepare(structure, options, energyModel, pH, seed)
            sampling = Sampling(structure, seed, choice, energyModel)
    except (InputError, openmm.OpenMMException) as error:
        raise InputError(f"{options.structure or structure.name}: {error}") from error
    prepared = Prepared(options, settings, outputs, console, sampling, energyModel, seed, added)
    return _sampleOne(prepared) if replicas is None else sampleReplicas(prepared, replicas, saved)


def _checkFolder(options):
    """Refuse a structure that is named by settings and is not there: perhaps the command runs in another folder."""
    source, name = options.resume or options.config, options.structure
    if source is not None and name is not None and not os.path.isabs(name) and not os.path.exists(name):
        raise InputError(
            f"structure {name}: there is no such file; names in {source} are relative to where the command runs"
        )


def _sampleOne(prepared):
    """Run one replica; return the exit status."""
    options, settings, outputs, console, sampling, _, seed, added = prepared
    writing = Writing()
    try:
        with beginning(outputs.values()):
            trajectory = _beginFiles(outputs, sampling.structure, settings, options.trials, options.frames)
        with trajectory:
            for line in describePlan(sampling.plan):
                console.print(line)
            if sampling.energies is not None:
                console.print(describeEnergies(sampling.energies))
            writing.files = [outputs[kind].name for kind in ("topology", "trajectory", "settings") if kind in outputs]
            interrupted, forbidden = _sample(sampling, options.trials, trajectory, writing.failures)
        if len(sampling.frames) > 1:
            writing.write(outputs["picture"], lambda output: _savePicture(output, sampling.structure, sampling))
        summary = summarize(sampling, seed, writing.files, bool(interrupted), added, forbidden)
        writeReports(writing, outputs, sampling.notes, summary)
    finally:
        outputs["topology"].release()
    printReport(summary, console, options.verbose)
    return endRun(writing, summary["pairsBeyondLimit"] or summary["changedBonds"], interrupted)


def _prepare(structure, options, energyModel, pH, seed):
    """Return a Structure with atoms left out and hydrogens added as the options say, and how many were added."""
    if options.leave_out is not None:
        structure = withoutAtoms(structure, selectByOption(structure.topology, "--leave-out", options.leave_out))
    if pH is None:
        return structure, 0
    structure, added = addHydrogens(structure, pH, seed)
    if energyModel is not None and len(added) > 0:
        structure = structure._replace(positions=energyModel.relax(structure, added))
    return structure, len(added)


def _checkOutputs(options, structureName, settings, replicas, saved):
    """Return the Outputs by their kind. A file of settings that is read, and says the same, is not written again."""
    prefix = structureName if options.output is None else options.output
    folder, beginning = os.path.split(prefix)
    if beginning in ("", ".", ".."):
        example = os.path.join(folder, beginning, structureName)
        raise InputError(f"-o {prefix or repr('')}: the names of output files need a beginning, such as {example}")
    names = {kind: f"{prefix}{ending}" for kind, ending in _ENDINGS.items()}
    if replicas is not None:
        del names["trajectory"]
        names = {**replicaNames(prefix, replicas), **names}
    names |= {"json": options.json, "notes": options.notes}
    inputs = [name for name in (options.structure, options.config) if name is not None]
    if options.config is not None and os.path.realpath(options.config) == os.path.realpath(names["settings"]):
        if readSettings(options.config) == settings:
            del names["settings"]
    check = checkOutputs if saved is None else saved.checkOutputs
    return check(names, inputs, options.overwrite)


def _beginFiles(outputs, structure, settings, trials, frames):
    """Write what stays as it is, and the start into the trajectory; return that. None stays if one fails."""
    writeScene(outputs, structure, settings)
    try:
        interval = -(-trials // frames)
        expected = 1 + -(-trials // interval)
        return TrajectoryFile(outputs["trajectory"], structure.topology, structure.positions, interval, expected)
    except BaseException:
        removeScene(outputs)
        raise


def _sample(sampling, trials, trajectory, failures):
    """Run all trials and write frames evenly along them; return Interrupts, and what hard spheres forbid.

    An OutputError ends the run, too, and joins the failures.
    """
    with interruptFlag() as interrupted, progress(trials) as advance:

        def proceed():
            advance(sampling.trials)
            return not interrupted

        try:
            while sampling.trials < trials and not interrupted:
                trajectory.write(sampling.run(min(trajectory.interval, trials - sampling.trials), proceed, interrupted))
        except OutputError as error:
            failures.append(error)
            del sampling.frames[trajectory.frames :]
        except openmm.OpenMMException as error:
            raise OutputError(f"{error}; {trajectory.describe()}") from error
        except KeyboardInterrupt:
            printError(f"interrupted; {trajectory.describe()}")
            raise
        return interrupted, measureForbidden(sampling, interrupted)


def _savePicture(output, structure, sampling):
    # Matplotlib takes longer to import than a short run.
    from .pictures.samplepicture import savePicture

    kinds = [torsion.kind for torsion in sampling.torsions]
    savePicture(output, structure.name, sampling.frames, kinds, [move.name for move in sampling.moves])
