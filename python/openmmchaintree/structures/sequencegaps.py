"""Residues that the sequence of a structure file has, but not its coordinates."""

import re
from typing import NamedTuple

import gemmi

from ..naming import joinNames
from ..notes import Note, found

# A chain is taken for the sequence if this share of its residues have the names of the sequence.
_LEAST_MATCH = 0.9


class SequenceGap(NamedTuple):
    """Missing residues between two residues of a chain.

    before, after : (str, str), each a chain and a number with insertion code
    names : list of str, of the missing residues, as in the sequence
    """

    before: tuple[str, str]
    after: tuple[str, str]
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
    copy = file.clone()
    copy.setup_entities()
    gaps, strange = [], []
    for chain in copy[model]:
        polymer = chain.get_polymer()
        entity = copy.get_entity_of(polymer) if len(polymer) else None
        if entity is None or not entity.full_sequence:
            continue
        alignment = gemmi.align_sequence_to_polymer(entity.full_sequence, polymer, entity.polymer_type)
        steps = [(int(count), step) for count, step in re.findall(r"(\d+)(\D)", alignment.cigar_str())]
        if any(step == "D" for _, step in steps) or alignment.match_count < _LEAST_MATCH * polymer.length():
            strange.append(joinNames(chain.name, f"{polymer.length()} residues"))
        else:
            gaps += _gapsOf(chain.name, [str(residue.seqid) for residue in polymer.first_conformer()], entity, steps)
    return gaps, found([Note("chains that differ from the sequence of the file, which was not used", strange)])


def _gapsOf(chain, numbers, entity, steps):
    """Return the SequenceGaps of one chain.

    numbers : the numbers of its residues; steps : list of (count, "M" or "I"), "I" for missing residues
    """
    gaps, place, residue = [], 0, 0
    for count, step in steps:
        if step == "I":
            if 0 < residue < len(numbers):
                names = [gemmi.Entity.first_mon(name) for name in entity.full_sequence[place : place + count]]
                gaps.append(SequenceGap((chain, numbers[residue - 1]), (chain, numbers[residue]), names))
        else:
            residue += count
        place += count
    return gaps
