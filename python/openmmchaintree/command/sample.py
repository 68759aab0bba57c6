"""The command openmm-chaintree sample."""

import argparse
import os
import random
from typing import NamedTuple

import openmm

from ..bonds import DISULFIDES, LOOPS
from ..errors import InputError
from ..images import engineBox
from ..structures.structure import readStructure, withoutAtoms
from ..torsions import KIND_WORDS, KINDS_WITH_ENERGIES
from .arguments import addPeriodic, addStructure, listOf, notNegative, numberIn, seed
from .config import addConfig, applySettings, readSettings, settingsOf
from .energyoptions import addEnergyOptions, readEnergyOptions
from .energysettings import EnergySettings
from .hydrogens import addHydrogens
from .outputs.outputfiles import addOverwrite, checkOutputs
from .plan import DEFAULT_KINDS, Choice, selectByOption
from .preparing.minimizing import minimizeStructure
from .preparing.preparation import prepareStructure
from .replicaoptions import addCheckpointOptions, addFormat, addReplicaOptions, readReplicaOptions
from .replicasample import namesOfRun, sampleReplicas
from .reports.noteoutput import addNotes, asText
from .sampling import Sampling
from .savedrun import SavedRun
from .startforces import noteOnForces
from .stopping import addStopping, settleTrials
from .terminal import ReportConsole, collectionPaused

__all__ = ["addArguments", "applySettings"]

_NONE = "none"

_ENDINGS = {"topology": "-topology.pdb", "picture": ".png", "settings": "-settings.toml"}

_DESCRIPTION = """\
Sample the torsions of proteins and nucleic acids: as hard spheres or, with --forcefield or --system, from the Boltzmann
distribution exp(-U/kT). Water and ions are omitted, unless a System has them; parts without torsions stay in place as
obstacles. Reports what moves and what does not, writes a trajectory (DCD) that begins with the initial structure, its
topology (PDB) and a picture, and prints a table."""

_SELECTIONS = """
In a force field, with implicit solvent:

  openmm-chaintree sample my.pdb --prepare --forcefield amber14-all.xml implicit/gbn2.xml --temperature 300

A force field needs all atoms of each residue: --add-hydrogens adds hydrogens, and --prepare also adds other missing
atoms and short gaps, and leaves out or replaces what the force field does not have. --minimize relaxes the structure.
Moves suit folded chains: closed and local moves of backbone windows, which leave the chain behind them in place or
hardly move it, and side-chain moves, small or between rotamers. With --disordered, they suit disordered and unfolded
chains. Hard spheres alone are sampled by moves of single torsions. Bond lengths and angles keep their initial values,
unless --flexible also displaces single atoms, which samples the ensemble of unconstrained dynamics.

Systems of other programs, read by OpenMM:

  openmm-chaintree sample x.inpcrd --system x.prmtop --implicit gbn2
  openmm-chaintree sample x.gro --system topol.top --include /usr/share/gromacs/top --periodic --nonbonded-cutoff 1
  openmm-chaintree sample x.crd --system x.psf --parameters top_all36_prot.rtf par_all36m_prot.prm toppar.str
  openmm-chaintree sample x.pdb --system system.xml

The structure may be any file with the atoms of the System in their order: inpcrd, rst7, crd, gro, PDB or mmCIF.
Torsions of proteins and ligands turn; water and ions of the System stay in place. Constraints are kept.

A SELECTION is written in MDTraj's language (https://mdtraj.org/latest/atom_selection.html), in quotes:

  --move "segname A"                   chain A by its name; "chainid 0" is the first chain of the file
  --move "resSeq 10 to 20"             residues by their numbers in the file (52 is 52 and 52A); "resid" counts from 0
  --move "sidechain and not resname PRO"
  --fix "protein" --rigid-bodies       ligands in a fixed protein
  --fix "nucleic or (segname B and resSeq < 100)"
  --fix "name CA \\"C1'\\""             names with primes in quotes

--move selects torsions by their third atom (of C-N-CA-C: CA), so "backbone" selects φ and ψ, "sidechain" all χ. Atoms
behind a torsion move with it; in each molecule, the largest part of the backbone without a rotating torsion stays in
place. Atoms selected by --fix never move, and torsions between two fixed parts are omitted, so only side chains move in
a loop between fixed ends. To sample the whole loop with moves that keep it closed:

  --fix "not resSeq 20 to 30" --close loops
"""


def addArguments(sample):
    """Describe the command and its arguments to a parser."""
    sample.description = _DESCRIPTION
    sample.epilog = _SELECTIONS
    sample.formatter_class = argparse.RawDescriptionHelpFormatter
    sample.set_defaults(run=_run, parser=sample)
    addStructure(sample)
    sample.add_argument(
        "--model", type=notNegative, default=0, metavar="K", help="the model to sample, from 0 (default: %(default)s)"
    )
    addStopping(sample.add_argument_group("length of the run"))
    addCheckpointOptions(sample.add_argument_group("checkpoints"))
    sample.add_argument("--seed", type=seed, help="random number seed, 1 to 2147483647 (default: a new one each time)")
    sample.add_argument(
        "-o", "--output", metavar="PREFIX", help="prefix of output file names (default: the structure's name)"
    )
    addFormat(sample)
    sample.add_argument(
        "--json",
        metavar="FILE",
        help="write the contents of the table, and all tolerated pairs, as JSON (-: to standard output; the report "
        "then goes to standard error)",
    )
    sample.add_argument(
        "--report",
        metavar="FILE",
        help="write a page (HTML) with means, picture, moves, energies, settings and the ensemble in three dimensions; "
        "a browser shows it without a network",
    )
    addPeriodic(sample, "of the structure; a force field then needs --nonbonded-cutoff")
    addOverwrite(sample)
    addNotes(sample)
    addConfig(sample)
    addEnergyOptions(sample.add_argument_group("force field"))
    addReplicaOptions(sample.add_argument_group("replicas"))
    moving = sample.add_argument_group("what moves")
    moving.add_argument(
        "--torsions",
        type=listOf(KIND_WORDS),
        metavar="KINDS",
        help=f"kinds of rotating torsions, separated by commas, from {', '.join(KIND_WORDS)} (default: "
        f"{','.join(DEFAULT_KINDS)}; in a force field {','.join(KINDS_WITH_ENERGIES)}, every bond outside rings; "
        "rotatable: single bonds, neither terminal nor conjugated as in amides)",
    )
    moving.add_argument("--leave-out", metavar="SELECTION", help="atoms to omit, such as a ligand")
    moving.add_argument(
        "--unknown-radius",
        type=numberIn(0, 1),
        metavar="NM",
        help="the radius of atoms of elements without a known radius, such as 0.2 for boron (default: an error)",
    )
    moving.add_argument("--move", metavar="SELECTION", help="atoms whose torsions rotate (default: all); see below")
    moving.add_argument("--fix", metavar="SELECTION", help="atoms that never move (default: none); see below")
    moving.add_argument(
        "--rigid-bodies",
        action="store_true",
        help="also move whole molecules: all except molecules with atoms selected by --fix, and fragments at gaps in a "
        "chain; with --move, only molecules with selected atoms",
    )
    moving.add_argument(
        "--cut-disulfides", action="store_true", help="cut disulfides, so that torsions between them rotate"
    )
    moving.add_argument(
        "--cut-metals", action="store_true", help="cut bonds of metals, so that the torsions between them rotate"
    )
    moving.add_argument(
        "--close",
        type=listOf((DISULFIDES, LOOPS, _NONE)),
        metavar="WHAT",
        help=f"{DISULFIDES}, {LOOPS} or both, separated by a comma: sample rings closed by disulfides, and loops "
        f"between parts fixed by --fix, with closed moves, which keep the bonds; or {_NONE} "
        f"(default: {DISULFIDES} in a force field, unless they are cut, else {_NONE})",
    )
    moving.add_argument(
        "--allow-unbonded",
        action="store_true",
        help="continue even if moves can separate atoms at bonding distance that are not bonded",
    )


class Prepared(NamedTuple):
    """A run before its start.

    options : argparse.Namespace; settings : dict, for --config; outputs : dict of Output by kind; console : Console;
    sampling : Sampling; energyModel : EnergySettings or None; seed : int; addedHydrogens : int
    """

    options: argparse.Namespace
    settings: dict
    outputs: dict
    console: ReportConsole
    sampling: Sampling
    energyModel: EnergySettings | None
    seed: int
    addedHydrogens: int


def _run(options):
    saved = None if options.resume is None else SavedRun(options.resume)
    settleTrials(options)
    if options.report is not None:
        from .reports.htmlreport import importPackages  # which few runs need

        importPackages()
    energyModel, pH = readEnergyOptions(options)
    replicas = readReplicaOptions(options)
    if replicas.temperatures is not None:
        energyModel.temperature = replicas.temperatures[0]
    seed = options.seed if options.seed is not None else random.SystemRandom().randint(1, 2**31 - 1)
    settings = {**settingsOf(options.parser, options), "seed": seed}
    if saved is not None:
        saved.checkSettings(settings)
        options.frames = settings["frames"] = saved.framesOf(options.trials)
    _checkFolder(options)
    for name in () if saved is None else options.pathsOfRun:
        saved.checkPath(name, getattr(options, name))
    if options.periodic and energyModel is not None:
        energyModel.checkPeriodic()
    with collectionPaused():
        read = readStructure if energyModel is None else energyModel.read
        structure = read(options.structure, options.model)
    if options.periodic:
        structure = structure._replace(box=engineBox(structure.box, options.structure or structure.name))
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
        options.periodic,
        options.flexible,
        options.disordered,
    )
    try:
        with collectionPaused():
            structure, added = _prepare(structure, options, energyModel, pH, seed)
            sampling = Sampling(structure, seed, choice, energyModel)
            if energyModel is not None:
                sampling.notes += noteOnForces(sampling, options.minimize)
    except (InputError, openmm.OpenMMException) as error:
        raise InputError(f"{options.structure or structure.name}: {error}") from error
    if options.prepare or options.minimize:  # line by line, and shortly again in the report
        console.print(asText(structure.notes).rstrip())
    prepared = Prepared(options, settings, outputs, console, sampling, energyModel, seed, added)
    return sampleReplicas(prepared, replicas, saved)


def _checkFolder(options):
    """Refuse a missing structure named by settings: perhaps the command runs in another folder."""
    source, name = options.resume or options.config, options.structure
    if source is not None and name is not None and not os.path.isabs(name) and not os.path.exists(name):
        raise InputError(
            f"structure {name}: there is no such file; names in {source} are relative to where the command runs"
        )


def _prepare(structure, options, energyModel, pH, seed):
    """Return a Structure without the omitted atoms and with added hydrogens, and the number of these."""
    if options.leave_out is not None:
        structure = withoutAtoms(structure, selectByOption(structure.topology, "--leave-out", options.leave_out))
    count = 0
    if options.prepare:
        structure, count = prepareStructure(structure, energyModel, pH, seed)
    elif pH is not None:
        structure, added = addHydrogens(structure, pH, seed)
        count = len(added)
        if energyModel is not None and count > 0:
            structure = structure._replace(positions=energyModel.relax(structure, added))
    if options.minimize:
        structure = minimizeStructure(structure, energyModel, options.fix)
    return structure, count


def _checkOutputs(options, structureName, settings, replicas, saved):
    """Return the Outputs by kind. A settings file that is an input with equal content is not written again."""
    prefix = structureName if options.output is None else options.output
    folder, beginning = os.path.split(prefix)
    if beginning in ("", ".", ".."):
        example = os.path.join(folder, beginning, structureName)
        raise InputError(f"-o {prefix or repr('')}: the names of output files need a beginning, such as {example}")
    names = {**namesOfRun(prefix, replicas), **{kind: f"{prefix}{ending}" for kind, ending in _ENDINGS.items()}}
    names |= {"json": options.json, "notes": options.notes, "report": options.report}
    given = [options.system, *(options.parameters or ())]
    inputs = [name for name in (options.structure, options.config, *given) if name is not None]
    if options.config is not None and os.path.realpath(options.config) == os.path.realpath(names["settings"]):
        if readSettings(options.config) == settings:
            del names["settings"]
    check = checkOutputs if saved is None else saved.checkOutputs
    outputs = check(names, inputs, options.overwrite)
    for kind in namesOfRun(prefix, replicas):
        outputs[kind].requireFile()
    return outputs
