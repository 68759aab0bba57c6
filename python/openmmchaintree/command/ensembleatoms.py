"""Options of the command ensemble for all atoms: residues that are missing, as random coils."""

import os

from ..coil import readCoilTables
from ..ensembles.avoidedregions import readRegion
from ..ensembles.sequencefiles import isSequenceFile, readSequences
from ..errors import InputError
from .arguments import refuseWithout

_MODEL = "coil"
_OF_MISSING = ("sequence", "move_domains")
ALL_ATOM_OPTIONS = ("missing", *_OF_MISSING, "hydrogens", "coil_tables", "avoid", "bias")


def addAllAtoms(parser):
    """Describe the options to a parser."""
    group = parser.add_argument_group("all atoms (--model coil)")
    group.add_argument(
        "--missing",
        action="store_true",
        help="build the residues that the sequence of a structure file has but not its model, at the ends of chains, "
        "and sample them; everything else stays in place",
    )
    group.add_argument(
        "--sequence", metavar="FASTA", help="other sequences, of which each chain takes the one that fits best"
    )
    group.add_argument(
        "--move-domains",
        action="store_true",
        help="build linkers in gaps, too: the largest domain of a chain stays, and the others move with the linkers",
    )
    group.add_argument("--hydrogens", action="store_true", help="build hydrogens (default: if the chain has them)")
    group.add_argument(
        "--coil-tables",
        metavar="CSV",
        help="other densities of phi and psi: a file with the columns residue, phi and counts",
    )
    group.add_argument(
        "--avoid",
        metavar="REGION",
        action="append",
        help="where nothing may move to, in nm: 'z < 0', or 'z > -2 and z < 2' for a membrane; may be repeated",
    )
    group.add_argument(
        "--bias",
        metavar="RANGE:DENSITY",
        action="append",
        help="other densities of phi and psi by residue numbers: 70-80:helix, A:5-9:extended, A:90-99:polyproline, or "
        "12-20:FILE.csv; may be repeated",
    )


def atomSettings(options):
    """Return the arguments of sampleEnsemble that the options for all atoms give, {} for beads.

    Raises
    ------
    InputError
        if options contradict each other, or a file cannot be read
    """
    if options.model != _MODEL:
        refuseWithout(options, f"--model {_MODEL}", *ALL_ATOM_OPTIONS)
        return {}
    if not options.missing:
        refuseWithout(options, "--missing", *_OF_MISSING)
    elif isSequenceFile(options.source):
        raise InputError("--missing needs a structure, not sequences")
    elif options.domains:
        raise InputError("--domains needs a structure without missing residues: use --move-domains beside --missing")
    readCoilTables(options.coil_tables)
    for region in options.avoid or []:
        readRegion(region)
    sequences = options.sequence and [each.letters for each in readSequences(options.sequence)]
    return {
        "missing": options.missing,
        "sequences": sequences,
        "hydrogens": options.hydrogens or None,
        "moveDomains": options.move_domains,
        "tables": options.coil_tables and os.path.abspath(options.coil_tables),
        "avoid": options.avoid or [],
        "bias": options.bias or [],
    }
