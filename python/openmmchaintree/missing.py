"""Building the residues that a protein's sequence has but not its model, in one call."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from openmm import app

from .coil import CoilTables
from .errors import InputError
from .notes import warnOf

_LETTERS = {
    "A": "ALA", "R": "ARG", "N": "ASN", "D": "ASP", "C": "CYS", "Q": "GLN", "E": "GLU", "G": "GLY", "H": "HIS",
    "I": "ILE", "L": "LEU", "K": "LYS", "M": "MET", "F": "PHE", "P": "PRO", "S": "SER", "T": "THR", "W": "TRP",
    "Y": "TYR", "V": "VAL", "B": "SEP", "O": "TPO",
}  # fmt: skip


class BuiltStructure(NamedTuple):
    """A structure with residues that it lacked.

    topology : openmm.app.Topology, with all bonds; positions : (n, 3) float64 array, nm
    parts : list of lists of Residue, the built ones of each tail or linker
    isBuilt : (n,) bool array, for each atom whether it is new
    isMoved : (n,) bool array, for each atom whether it belongs to a domain that was moved to the end of its linker
    """

    topology: app.Topology
    positions: np.ndarray
    parts: list[list[app.topology.Residue]]
    isBuilt: np.ndarray
    isMoved: np.ndarray


def buildMissing(
    source: str | Path | None,
    sequences: Iterable[str | Sequence[str]] | None = None,
    hydrogens: bool | None = None,
    moveDomains: bool = False,
    seed: int = 0,
    tables: CoilTables | None = None,
    model: int = 0,
    closeGaps: bool = False,
) -> BuiltStructure:
    """Build the residues that a protein's sequence has but not its model, or a chain from its sequence alone.

    Residues have the ideal geometry of the chemical component dictionary, a backbone of the bond lengths and angles of
    Engh and Huber (1991), trans peptide bonds, and φ, ψ and χ drawn from the densities of `createCoilForce` and
    `rotamerDensities`. Atoms that are there stay in place, bit for bit; only OXT, and the hydrogens of an amine where a
    residue is built before it, are left out. New atoms may clash: `sampleEnsemble` removes clashes. Takes about 1 ms a
    residue, and seconds the first time that a residue is looked up in the dictionary.

        built = buildMissing("1shg.pdb")
        app.PDBFile.writeFile(built.topology, built.positions * unit.nanometer, file)

    Parameters
    ----------
    source : str or Path, or None
        a structure file with its sequence (SEQRES, _entity_poly_seq); None builds a chain from the one sequence alone
    sequences : iterable of str or sequences of str, optional
        other sequences, of which each chain takes the one that fits best: in letters (B is phosphoserine, O
        phosphothreonine), or names of residues, in which caps (ACE, NME, NH2) may be at the ends
    hydrogens : bool, optional
        whether new residues have hydrogens. Default: if their chain has them; from a sequence alone they have none.
    moveDomains : bool
        build linkers in gaps, too: the largest domain of a chain stays, and the others move to the ends of the linkers
        as rigid bodies, with all that is bonded to them. Default: gaps stay open, and only tails are built.
    seed : int
        of the torsions; the same seed gives the same structure, and 0 draws one
    tables : mapping of str to array, or path, optional
        as for `createCoilForce`
    model : int
        the number of the model in the file, from 0
    closeGaps : bool
        build gaps whose sides stay, too, if three residues or more are missing: of some random closed conformations,
        the one with fewest contacts, which may clash. Takes about 1 s.

    Returns
    -------
    BuiltStructure

    Raises
    ------
    InputError
        if the file cannot be read, a residue is unknown, or nothing is missing that can be built
    """
    from .building.coildraws import CoilDraws
    from .building.missingresidues import buildFromSequence, buildOnto
    from .structures.structure import readStructure

    names = None if sequences is None else [namesOf(sequence) for sequence in sequences]
    draws = CoilDraws(seed or None, tables)
    if moveDomains and closeGaps:
        raise InputError("moveDomains and closeGaps exclude each other")
    if source is None:
        if names is None or len(names) != 1:
            raise InputError("without a structure, one sequence is needed")
        built, notes = buildFromSequence(names[0], draws, bool(hydrogens)), []
    else:
        structure = readStructure(source, model)
        built, notes = buildOnto(structure, names, draws, hydrogens, moveDomains, closeGaps)
    warnOf(notes, stacklevel=2)
    return BuiltStructure(built.structure.topology, built.structure.positions, *built[1:])


def namesOf(sequence: str | Sequence[str]) -> list[str]:
    """Return the names of the residues of a sequence in letters, or the names themselves.

    Raises
    ------
    InputError
        if the sequence is empty, or a letter is no amino acid
    """
    names = list("".join(sequence.split()).upper() if isinstance(sequence, str) else sequence)
    if not names:
        raise InputError("a sequence is empty")
    if not isinstance(sequence, str):
        return names
    strange = next((letter for letter in names if letter not in _LETTERS), None)
    if strange is not None:
        raise InputError(f"{strange!r} in a sequence is no amino acid")
    return [_LETTERS[letter] for letter in names]
