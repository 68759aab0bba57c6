"""The options that choose a force field, its temperature and hydrogens."""

from .arguments import numberIn, positive, refuseWithout
from .energymodel import HARD, OFF, EnergyModel
from .flexible import ATOM_SHARE
from .preparing.segments import LONGEST_GAP

_TEMPERATURE = 300.0  # K
_PH = 7.0

_NEED_FORCE_FIELD = (
    "temperature",
    "nonbonded_cutoff",
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
        help="sample exp(-U/kT) with the energy U of these files of OpenMM's ForceField, given by path or by their "
        "names in OpenMM, such as amber14-all.xml implicit/gbn2.xml (default: hard spheres alone)",
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
        "or undoes these trials (default: 400 for implicit solvents; chosen from the first tests for other forces)",
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
    """Return the EnergyModel chosen by the options, or None, and the pH at which to add hydrogens, or None.

    Raises
    ------
    InputError
        if an option needs another one, or a file is not a force field
    """
    if options.forcefield is None:
        refuseWithout(options, "--forcefield", *_NEED_FORCE_FIELD)
    addsHydrogens = options.add_hydrogens or options.prepare
    if not addsHydrogens:
        refuseWithout(options, "--add-hydrogens or --prepare", "ph")
    pH = None
    if addsHydrogens:
        pH = _PH if options.ph is None else options.ph
    if options.forcefield is None:
        return None, pH
    temperature = _TEMPERATURE if options.temperature is None else options.temperature
    model = EnergyModel(
        options.forcefield,
        temperature,
        options.nonbonded_cutoff,
        options.trials_per_outer_test or 0,
        addsHydrogens,
        options.leave_out is not None,
        not options.no_native_energies,
        options.steric,
        options.flexible,
        options.prepare,
    )
    return model, pH
