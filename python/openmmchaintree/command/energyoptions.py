"""The options that choose a force field, its temperature and hydrogens."""

import argparse

from ..errors import InputError
from .arguments import numberIn, positive, refuseWithout
from .energymodel import HARD, OFF, EnergyModel
from .energysettings import PERIODIC_METHODS
from .flexible import ATOM_SHARE
from .givensystem import GivenSystem, SystemOptions
from .preparing.segments import LONGEST_GAP
from .systemfiles import IMPLICIT_SOLVENTS

_TEMPERATURE = 300.0  # K
_PH = 7.0

_NEED_ENERGY = (
    "temperature",
    "nonbonded_cutoff",
    "nonbonded_method",
    "steric",
    "trials_per_outer_test",
    "no_native_energies",
    "flexible",
    "disordered",
    "minimize",
)


def addEnergyOptions(parser):
    """Add the options of a force field to a parser."""
    parser.add_argument(
        "--forcefield",
        nargs="+",
        metavar="XML",
        help="sample exp(-U/kT) with the energy U of a force field: files for OpenMM's ForceField, by path or by name "
        "in OpenMM, such as amber14-all.xml implicit/gbn2.xml (default: hard spheres alone)",
    )
    parser.add_argument(
        "--system",
        metavar="FILE",
        help="sample exp(-U/kT) with the energy U of a System of this file: an AMBER prmtop, GROMACS top, CHARMM PSF, "
        "or XML of a serialized System; the structure has its atoms, water and ions included (see below)",
    )
    parser.add_argument(
        "--parameters", nargs="+", metavar="FILE", help="CHARMM's files for a PSF: .rtf, .prm, .str, .par, .inp"
    )
    parser.add_argument(
        "--include",
        metavar="FOLDER",
        help="the folder of force fields that a GROMACS top includes (default: GROMACS's)",
    )
    parser.add_argument(
        "--implicit",
        type=_implicitSolvent,
        metavar="NAME",
        help=f"the implicit solvent for a prmtop or PSF: {', '.join(IMPLICIT_SOLVENTS)} (default: none)",
    )
    parser.add_argument(
        "--temperature",
        type=numberIn(0, 1e5),
        metavar="K",
        help=f"the temperature in a force field (default: {_TEMPERATURE:g})",
    )
    parser.add_argument(
        "--nonbonded-cutoff",
        type=numberIn(0.1, 1e3),
        metavar="NM",
        help="omit pairs of atoms beyond this distance (default: no cutoff)",
    )
    parser.add_argument(
        "--nonbonded-method",
        choices=PERIODIC_METHODS,
        help="OpenMM's nonbonded method in a periodic box (default: CutoffPeriodic, for --system PME)",
    )
    parser.add_argument(
        "--steric",
        choices=(OFF, HARD),
        help="in a force field: off samples exp(-U/kT); hard also forbids overlapping atoms (default: off if the force "
        "field has energies of all pairs of atoms, else hard)",
    )
    parser.add_argument(
        "--trials-per-outer-test",
        type=positive,
        metavar="M",
        help="evaluate forces that are not native, and the full energy, once in M trials, in an outer test that keeps "
        "or undoes these trials (default: 400 for implicit solvents, more with --flexible; chosen from the first tests "
        "for other forces)",
    )
    parser.add_argument(
        "--no-native-energies",
        action="store_true",
        help="let OpenMM evaluate every force in each trial, which is much slower",
    )
    parser.add_argument(
        "--flexible",
        action="store_true",
        help="in a force field, also displace single atoms, so that bond lengths and angles change as in dynamics "
        f"(a share of {ATOM_SHARE:g} of the trials; default: they keep their initial values)",
    )
    parser.add_argument(
        "--disordered",
        action="store_true",
        help="in a force field, choose moves for disordered chains, and for chains that fold: backbones are mostly "
        "drawn from the density of residues in loops, and get large turns (default: moves for folded chains)",
    )
    parser.add_argument("--add-hydrogens", action="store_true", help="add missing hydrogens")
    parser.add_argument(
        "--prepare",
        action="store_true",
        help="complete a structure as the Protein Data Bank has it: missing heavy atoms, ends of chains, gaps of up to "
        f"{LONGEST_GAP} residues (by the sequence in the file) and hydrogens; additives and modified residues that the "
        "force field does not have are left out or replaced; atoms that stay do not move",
    )
    parser.add_argument(
        "--minimize",
        action="store_true",
        help="minimize the energy in the force field before sampling; atoms selected by --fix do not move",
    )
    parser.add_argument(
        "--ph", type=numberIn(0, 14), metavar="PH", help=f"the pH at which to add hydrogens (default: {_PH:g})"
    )


def readEnergyOptions(options):
    """Return the EnergyModel or GivenSystem of the options, or None, and the pH at which to add hydrogens, or None.

    Raises
    ------
    InputError
        if an option needs another one, or a file is not a force field
    """
    if options.system is None:
        refuseWithout(options, "--system", "parameters", "include", "implicit")
        if options.forcefield is None:
            refuseWithout(options, "--forcefield or --system", *_NEED_ENERGY)
    elif options.forcefield is not None:
        raise InputError("--forcefield and --system cannot be used together: each defines the energy")
    else:
        _refuseOtherAtoms(options)
    addsHydrogens = options.add_hydrogens or options.prepare
    if not addsHydrogens:
        refuseWithout(options, "--add-hydrogens or --prepare", "ph")
    if not options.periodic:
        refuseWithout(options, "--periodic", "nonbonded_method")
    pH = None
    if addsHydrogens:
        pH = _PH if options.ph is None else options.ph
    return _readModel(options, addsHydrogens), pH


def _refuseOtherAtoms(options):
    """Refuse options that change the atoms of a structure, which a given System has."""
    for name in ("add_hydrogens", "prepare", "leave_out"):
        if getattr(options, name) not in (None, False):
            raise InputError(f"--{name.replace('_', '-')} cannot be used with --system, which has all its atoms")


def _readModel(options, addsHydrogens):
    """Return the EnergyModel or GivenSystem that the options choose, or None."""
    settings = {
        "temperature": _TEMPERATURE if options.temperature is None else options.temperature,
        "cutoff": options.nonbonded_cutoff,
        "trialsPerOuterTest": options.trials_per_outer_test or 0,
        "areNative": not options.no_native_energies,
        "steric": options.steric,
        "isFlexible": options.flexible,
    }
    if options.forcefield is not None:
        method = options.nonbonded_method or "CutoffPeriodic"
        done = {
            "hydrogensAreAdded": addsHydrogens,
            "someAreLeftOut": options.leave_out is not None,
            "isPrepared": options.prepare,
        }
        return EnergyModel(options.forcefield, periodicMethod=method, **done, **settings)
    if options.system is not None:
        of = SystemOptions(options.parameters, options.include, options.implicit, options.periodic)
        return GivenSystem(options.system, options=of, periodicMethod=options.nonbonded_method, **settings)
    return None


def _implicitSolvent(text):
    """Return OpenMM's name of an implicit solvent; upper and lower case are the same."""
    names = {name.lower(): name for name in IMPLICIT_SOLVENTS}
    if text.lower() not in names:
        raise argparse.ArgumentTypeError(f"{text!r} is not one of {', '.join(IMPLICIT_SOLVENTS)}")
    return names[text.lower()]
