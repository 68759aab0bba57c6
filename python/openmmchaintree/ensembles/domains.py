"""Folded domains of a protein, written as ranges of residue numbers."""

import re

from ..beadplaces import beadResidues
from ..errors import InputError

_SEGMENT = re.compile(r"(?:(?P<chain>[^:+,]+):)?(?P<first>-?\d+)-(?P<last>-?\d+)")


def readDomains(text, topology):
    """Return the residues of domains, each a list of indices among those that become beads.

    Domains stand between commas, segments of one domain between plus signs, with a chain's name before a colon where
    chains share numbers: "1-72,77-148", "A:5-60+A:90-120,B:5-60".

    Raises
    ------
    InputError
        if the text cannot be read, a segment has no residue, or a residue is in two domains
    """
    residues = [residue for chain in beadResidues(topology) for residue, _ in chain]
    domains, seen = [], {}
    for part in text.split(","):
        domain = []
        for segment in part.split("+"):
            found = residuesOf(segment.strip(), residues)
            for index in found:
                if index in seen:
                    raise InputError(f"residue {residues[index].id} is in {seen[index]} and in {segment.strip()}")
                seen[index] = segment.strip()
            domain += found
        domains.append(sorted(domain))
    return domains


def residuesOf(segment, residues):
    """Return the indices in a list of the residues of a segment such as A:5-60."""
    match = _SEGMENT.fullmatch(segment)
    if match is None:
        raise InputError(f"{segment!r} is no range of residues such as 1-72 or A:5-60")
    first, last, chain = int(match["first"]), int(match["last"]), match["chain"]
    found = [
        index
        for index, residue in enumerate(residues)
        if chain in (None, residue.chain.id) and _isNumber(residue.id) and first <= int(residue.id) <= last
    ]
    if not found:
        raise InputError(f"{segment}: there are no residues with these numbers")
    if len({residues[index].chain for index in found}) > 1:
        raise InputError(f"{segment}: several chains have these numbers; name one, as in A:{segment}")
    return found


def _isNumber(text):
    return text.lstrip("-").isdigit()
