"""Residues that the sequence of a structure file has, but not its coordinates."""

import re
from typing import NamedTuple

import gemmi

from ..naming import joinNames
from ..notes import Note, found
from ..residues import PEPTIDE_BACKBONE, aminoAcid

# A chain is taken for the sequence if this share of its residues have the names of the sequence.
_LEAST_MATCH = 0.9

_NO_SEQUENCE = "chains of which the file has no sequence"


class SequenceGap(NamedTuple):
    """Missing residues between two residues of a chain, or at one of its ends.

    before, after : (str, str), each a chain and a number with insertion code; None at an end of the chain
    names : list of str, of the missing residues, as in the sequence
    """

    before: tuple[str, str] | None
    after: tuple[str, str] | None
    names: list[str]


def findSequenceGaps(file, model):
    """Compare a model of a gemmi.Structure with SEQRES (PDB) or _entity_poly_seq (mmCIF).

    Missing residues at the ends of a chain are no gaps.

    Returns
    -------
    list of SequenceGap
    list of Note
        on chains that differ from their sequence
    """
    missing, notes = findMissingResidues(file, model)
    inner = [gap for gap in missing if gap.before is not None and gap.after is not None]
    return inner, [note for note in notes if note.kind != _NO_SEQUENCE]


def findMissingResidues(file, model, sequences=None):
    """Find the residues that sequences have but not a model of a gemmi.Structure, in gaps and at the ends of chains.

    sequences : list of lists of residue names, of which each chain takes the one that fits best; default: SEQRES (PDB)
        or _entity_poly_seq (mmCIF)

    Returns
    -------
    list of SequenceGap
    list of Note
        on chains that differ from their sequence, or have none
    """
    copy = file.clone()
    copy.setup_entities()
    gaps, strange, bare = [], [], []
    for chain in copy[model]:
        polymer = chain.get_polymer()
        entity = copy.get_entity_of(polymer) if len(polymer) else None
        if entity is None:
            continue
        candidates = [entity.full_sequence] if sequences is None else sequences
        fits = [_align(names, polymer, entity) for names in candidates if names]
        if not fits:
            bare.append(joinNames(chain.name, f"{polymer.length()} residues"))
            continue
        fit = max(fits, key=lambda one: (one.areComplete, one.matches))
        if not fit.areComplete or fit.matches < _LEAST_MATCH * polymer.length():
            strange.append(joinNames(chain.name, f"{polymer.length()} residues"))
        else:
            gaps += _gapsOf(chain.name, [str(residue.seqid) for residue in polymer.first_conformer()], fit)
    which = "the sequence of the file, which was not used" if sequences is None else "all given sequences"
    return gaps, found([Note(f"chains that differ from {which}", strange), Note(_NO_SEQUENCE, bare)])


class _Fit(NamedTuple):
    """A sequence aligned to a chain.

    names : list of str; steps : list of (count, "M" or "I"), "I" for missing residues
    matches : int; areComplete : bool, whether all residues of the chain are in the sequence
    """

    names: list
    steps: list
    matches: int
    areComplete: bool


def _align(names, polymer, entity):
    alignment = gemmi.align_sequence_to_polymer(names, polymer, entity.polymer_type)
    steps = [(int(count), step) for count, step in re.findall(r"(\d+)(\D)", alignment.cigar_str())]
    return _Fit(names, steps, alignment.match_count, all(step != "D" for _, step in steps))


def _gapsOf(chain, numbers, fit):
    """Return the SequenceGaps of one chain.

    numbers : the numbers of its residues
    """
    gaps, place, residue = [], 0, 0
    for count, step in fit.steps:
        if step == "I":
            names = [gemmi.Entity.first_mon(name) for name in fit.names[place : place + count]]
            before = (chain, numbers[residue - 1]) if residue > 0 else None
            after = (chain, numbers[residue]) if residue < len(numbers) else None
            gaps.append(SequenceGap(before, after, names))
        else:
            residue += count
        place += count
    return gaps


def addressOf(residue):
    """Return the chain of a residue of a Topology, and its number with insertion code, as in a SequenceGap."""
    return residue.chain.id, f"{residue.id}{residue.insertionCode.strip()}"


def lacksBackbone(residue):
    """Whether a residue of a Topology is an amino acid without N, CA or C."""
    names = {atom.name for atom in residue.atoms()}
    return aminoAcid(residue.name) is not None and not names.issuperset(PEPTIDE_BACKBONE)
