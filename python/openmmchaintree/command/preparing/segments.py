"""The segments of chains between gaps, and the gaps that can be built."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from openmm.app import Residue

from ...bonds import polymerLinks
from ...naming import describeResidue
from ...notes import Note, found
from ...residues import aminoAcid, isPolymer
from ...structures.sequencegaps import SequenceGap, addressOf
from ...templates import standardName
from .phosphates import nucleotidesToJoin
from .replacing import standardOf

# The longest gap that is built, in residues. Loops of more have too many conformations for one guess.
LONGEST_GAP = 8

# The largest distance that one residue of a peptide spans (nm).
_REACH = 0.38


class Segment(NamedTuple):
    """Consecutive residues of a chain, of a polymer or not: between its ends and open gaps.

    residues : list of Residue, and of Missing
    joined : set of Residue, nucleotides whose bond to the residue before is to be built
    """

    residues: list
    joined: set


class Missing(NamedTuple):
    """A residue to build. name : str; after : Residue, the last one before the gap; number : int, from 1 in the gap."""

    name: str
    after: Residue
    number: int


def findSegments(structure, gaps):
    """Divide the chains of a Structure.

    Parameters
    ----------
    structure : Structure
        in which all amino acids have N, CA and C
    gaps : list of SequenceGap

    Returns
    -------
    list of Segment
        in the order of residues
    list of Note
        on gaps, built and open
    """
    topology, positions = structure.topology, structure.positions
    atoms = list(topology.atoms())
    bonds = [(bond[0].index, bond[1].index) for bond in topology.bonds()]
    following = {first.residue: second.residue for first, second in polymerLinks(atoms, bonds)}
    gapAfter = {gap.before: gap for gap in gaps}
    joined = nucleotidesToJoin(structure)
    segments, built, isOpen = [], [], []
    for chain in topology.chains():
        previous = None
        for residue in chain.residues():
            if previous is None or isPolymer(previous) != isPolymer(residue):
                segments.append(Segment([], set()))
            elif residue in joined:
                segments[-1].joined.add(residue)
            elif isPolymer(residue) and following.get(previous) is not residue:
                gap = gapAfter.get(addressOf(previous))
                if gap is None or gap.after != addressOf(residue):
                    names, reason = [], "the file has no sequence of it"
                else:
                    names, reason = _namesToBuild(gap.names, previous, residue, positions)
                ends = f"{describeResidue(previous)} – {describeResidue(residue)}"
                if reason is None:
                    segments[-1].residues.extend(Missing(name, previous, 1 + i) for i, name in enumerate(names))
                    built.append(f"{ends}: {' '.join(names)}")
                else:
                    isOpen.append(f"{ends}: {reason}")
                    segments.append(Segment([], set()))
            segments[-1].residues.append(residue)
            previous = residue
    return segments, found(
        [
            Note("gaps in chains built from the sequence", built),
            Note("gaps in chains that stay open, and whose sides became ends of chains", isOpen),
        ]
    )


def _namesToBuild(names, before, after, positions):
    """Return the standard names of the residues of a gap, and why it is not built, or None."""
    if len(names) > LONGEST_GAP:
        return [], f"{len(names)} residues, and at most {LONGEST_GAP} are built"
    if aminoAcid(before.name) is None or aminoAcid(after.name) is None:
        return [], "only gaps between amino acids are built"
    standard = [name if aminoAcid(name) == name and name != "MSE" else standardOf(name) for name in names]
    unknown = [name for name, known in zip(names, standard, strict=True) if known is None]
    if unknown:
        return [], f"no template of {unknown[0]}"
    ends = [_atomNamed(before, "C"), _atomNamed(after, "N")]
    distance = np.linalg.norm(positions[ends[0].index] - positions[ends[1].index])
    if distance > _REACH * (len(names) + 1):
        return [], f"{len(names)} residues cannot span {distance:.1f} nm"
    return standard, None


def _atomNamed(residue, name):
    return next(atom for atom in residue.atoms() if atom.name == name)


def gapsWithStubs(topology, gaps, stubs):
    """Return SequenceGaps to which residues of a Topology, which are to be left out, are added with their names."""
    byEnds = {(gap.before, gap.after): gap.names for gap in gaps}
    found = []
    for chain in topology.chains():
        start, names = None, []
        for previous, residue in pairwise(filter(isPolymer, chain.residues())):
            if previous not in stubs:
                start, names = previous, []
            names += byEnds.get((addressOf(previous), addressOf(residue)), [])
            if residue in stubs:
                names.append(standardName(residue.name))
            elif start is not None and names:
                found.append(SequenceGap(addressOf(start), addressOf(residue), names))
    return found
