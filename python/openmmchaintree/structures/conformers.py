"""Choosing one conformer of each residue if a structure file has several."""

from collections import defaultdict
from typing import NamedTuple

import gemmi

NO_ALTERNATE = "\0"  # gemmi's label of an atom without alternates


class Choice(NamedTuple):
    """A model with one conformer of each residue.

    atoms : list of list of (gemmi.Residue, list of gemmi.Atom)
        by chain and residue, in the order of the file
    described : list of str
        the residues that have more than one conformer, with the chosen one
    """

    chains: list[list[tuple[gemmi.Residue, list[gemmi.Atom]]]]
    described: list[str]


def chooseConformers(model, name):
    """Choose, in each residue of a gemmi.Model, the conformer of highest occupancy, the first of equals.

    Residues of different names at one place in the chain (microheterogeneity) are conformers of one residue. Conformers
    without common atoms are not alternatives to each other: one of each set of alternatives is chosen.

    Parameters
    ----------
    model : gemmi.Model
    name : function
        names a residue of a chain in messages: name(chain, residue)

    Returns
    -------
    Choice
    """
    chains, described = [], []
    for chain in model:
        residues = []
        for place in _places(chain):
            if all(atom.altloc == NO_ALTERNATE for residue in place for atom in residue):
                residues += [(residue, list(residue)) for residue in place]
                continue
            chosen, taken = _chooseAt(place)
            residues += chosen
            described.append(f"{name(chain, chosen[0][0])} conformer {', '.join(taken)}")
        chains.append(residues)
    return Choice(chains, described)


def _places(chain):
    """Return lists of the residues at each place of a chain: neighbors with the same number, and alternates of it."""
    places, byNumber = [], {}
    for residue in chain:
        number = str(residue.seqid)
        place = places[-1] if places and str(places[-1][0].seqid) == number else None
        if place is None and any(atom.has_altloc() for atom in residue):
            place = byNumber.get(number)
        if place is None:
            place = []
            places.append(place)
        place.append(residue)
        if any(atom.has_altloc() for atom in residue):
            byNumber[number] = place
    return places


def _chooseAt(place):
    """Return the chosen (residue, atoms) at one place in the chain, and the chosen labels."""
    occupancies = defaultdict(list)
    names = defaultdict(set)
    labelled = {_nameIn(residue, atom) for residue in place for atom in residue if atom.has_altloc()}
    for residue in place:
        for atom in residue:
            # Some programs give the first conformer no label.
            if atom.has_altloc() or _nameIn(residue, atom) in labelled:
                occupancies[atom.altloc].append(atom.occ)
                names[atom.altloc].add(_plainName(atom))
    taken = []
    for labels in _alternatives(names):
        # Python's max returns the first of equals; labels are in the order of the file.
        taken.append(max(labels, key=lambda label: sum(occupancies[label]) / len(occupancies[label])))
    replaced = {_nameIn(residue, atom) for residue in place for atom in residue if _isTaken(atom, taken)}
    kept = []
    for residue in place:
        atoms = [
            atom
            for atom in residue
            if (atom.altloc in taken if atom.has_altloc() else _nameIn(residue, atom) not in replaced)
        ]
        if atoms:
            kept.append((residue, atoms))
    if len({residue.name for residue, _ in kept}) > 1:
        # An atom without a label belongs to the residue whose name was chosen.
        kept = [(residue, atoms) for residue, atoms in kept if any(_isTaken(atom, taken) for atom in atoms)] or kept[:1]
    return kept, ["without a label" if label == NO_ALTERNATE else label for label in taken]


def _isTaken(atom, taken):
    return atom.has_altloc() and atom.altloc in taken


def _nameIn(residue, atom):
    return residue.name, _plainName(atom)


def _alternatives(names):
    """Return sets of labels that share names of atoms, as lists in the order of the file."""
    groups = []
    for label, found in names.items():
        joined = [group for group in groups if any(names[other] & found for other in group)]
        merged = [other for group in joined for other in group] + [label]
        groups = [group for group in groups if group not in joined] + [merged]
    return groups


def _plainName(atom):
    """Return the name of an atom; deuterium gets the name of the hydrogen that it replaces."""
    return "H" + atom.name[1:] if atom.element.name == "D" and atom.name.startswith("D") else atom.name
