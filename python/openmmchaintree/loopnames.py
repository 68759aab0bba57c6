"""Loops of a protein by name, such as A:63-74."""

import re

import numpy as np

from .errors import InputError
from .naming import describeResidue
from .residues import aminoAcid

_NAME = re.compile(r"(?:(?P<chain>[^:,]*):)?(?P<first>-?\d+[A-Za-z]?)-(?P<last>-?\d+[A-Za-z]?)")
_FEWEST = 3
_LONGEST_BOND = 0.4  # nm; a longer one is a gap


def findLoop(topology, positions, name):
    """Return the residues of a loop, checked: bonded in a row, between two residues of the same chain.

    Parameters
    ----------
    topology : openmm.app.Topology, with all bonds
    positions : (n, 3) array, nm
    name : str
        the chain and the numbers of the first and last residue, with insertion codes: "A:63-74", "H:52-52C"; without a
        chain where only one chain has these numbers

    Raises
    ------
    InputError
        if the name cannot be read, no chain or several chains have these residues, there are fewer than three, or the
        loop has a gap, a residue that is no amino acid, or a bond beside the two at its ends; or reaches an end
    """
    match = _NAME.fullmatch(name.strip())
    if match is None:
        raise InputError(f"{name!r} is no loop such as A:63-74: a chain, and its first and last residue")
    found = [run for run in (_runOf(chain, match) for chain in topology.chains()) if run is not None]
    if not found:
        raise InputError(f"{name}: {_missing(topology, match)}")
    if len(found) > 1:
        numbers = f"{match['first']}-{match['last']}"
        raise InputError(f"{name}: several chains have these residues; name one, as in A:{numbers}")
    before, loop, after = found[0]
    if len(loop) < _FEWEST:
        raise InputError(f"{name}: a loop needs at least {_FEWEST} residues, since three of them close it")
    for residue in loop:
        if aminoAcid(residue.name) is None:
            raise InputError(f"{name}: {describeResidue(residue)} is no amino acid")
    if before is None or after is None:
        raise InputError(f"{name}: reaches an end of its chain, so nothing holds it; a loop lies between two residues")
    _checkBonds(topology, positions, name, [before, *loop, after])
    return loop


def _idOf(residue):
    return f"{residue.id}{residue.insertionCode.strip()}"


def _runOf(chain, match):
    """Return (the residue before a loop, its residues, the residue after it) of a chain, or None."""
    if match["chain"] not in (None, chain.id.strip()):
        return None
    residues = list(chain.residues())
    names = [_idOf(residue) for residue in residues]
    if match["first"] not in names or match["last"] not in names:
        return None
    first, last = names.index(match["first"]), names.index(match["last"])
    before = residues[first - 1] if first > 0 else None
    return before, residues[first : last + 1], residues[last + 1] if last + 1 < len(residues) else None


def _missing(topology, match):
    chains = [chain for chain in topology.chains() if match["chain"] in (None, chain.id.strip())]
    if not chains:
        known = ", ".join(dict.fromkeys(chain.id.strip() or "(no name)" for chain in topology.chains()))
        return f"there is no chain {match['chain']}; there are {known}"
    names = {_idOf(residue) for chain in chains for residue in chain.residues()}
    for number in (match["first"], match["last"]):
        if number not in names:
            return f"there is no residue {number}" + (f" in chain {match['chain']}" if match["chain"] else "")
    return "no chain has both residues"


def _checkBonds(topology, positions, name, residues):
    """Check that residues are bonded in a row by peptide bonds, and those of the loop to nothing else."""
    places = {residue: place for place, residue in enumerate(residues)}
    linked = set()
    for atom1, atom2 in topology.bonds():
        place1, place2 = places.get(atom1.residue), places.get(atom2.residue)
        if atom1.residue is atom2.residue or not {place1, place2} & set(range(1, len(residues) - 1)):
            continue
        if place1 is not None and place2 is not None and {atom1.name, atom2.name} == {"C", "N"}:
            low, high = sorted((place1, place2))
            length = np.linalg.norm(positions[atom1.index] - positions[atom2.index])
            if high == low + 1 and length < _LONGEST_BOND:
                linked.add(low)
                continue
        if place1 is not None and place2 is not None and abs(place1 - place2) == 1 and "C" in (atom1.name, atom2.name):
            continue  # a gap, reported below
        raise InputError(
            f"{name}: {describeResidue(atom1.residue)} {atom1.name} is bonded to {describeResidue(atom2.residue)} "
            f"{atom2.name}, so the loop cannot move freely; choose a loop without such a bond"
        )
    for place in range(len(residues) - 1):
        if place not in linked:
            raise InputError(
                f"{name}: there is a gap in the chain between {describeResidue(residues[place])} and "
                f"{describeResidue(residues[place + 1])}; build the missing residues first"
            )
