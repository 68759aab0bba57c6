"""Pseudo-atoms: virtual sites, lone pairs, and residues of dummy atoms by which programs mark planes and axes.

They are recognized by name, from the table `tables/names.csv`.
"""

from functools import cache

import numpy as np

from .datatables import readNames
from .residues import isCalledWater, isPolymerName, polymerBackbone

_HYDROGEN_LETTERS = "HD"

_DRUDE = "D"


def isMark(residue):
    """Whether a residue of a Topology consists of dummy atoms, such as membrane markers."""
    if residue.name not in _marks():
        return False
    names = {atom.name for atom in residue.atoms()}
    known = _marks()[residue.name]
    return not polymerBackbone(residue) and any(not some or names <= some for some in known)


def isPseudoAtom(atom):
    """Whether an atom of a Topology is a virtual site, a lone pair, or a part of a mark."""
    residue = atom.residue
    return isMark(residue) or isSite(
        residue.name, atom.name, lambda: {other.name for other in residue.atoms()}, atom.element is not None
    )


def atomicNumbers(atoms):
    """Return the atomic numbers of atoms of a Topology, an int array; 0 for pseudo-atoms and other extra particles."""
    return np.array([0 if atom.element is None or isPseudoAtom(atom) else atom.element.atomic_number for atom in atoms])


def isSite(residueName, name, otherNames, hasElement):
    """Whether an atom is a virtual site, a lone pair or a pseudo-atom by its name.

    otherNames : function that returns the names of all atoms of the residue
    hasElement : bool, whether it is known to be of an element
    """
    begin, needsOther = _siteName(_kindOf(residueName), residueName, name, hasElement)
    if begin is None or not needsOther:
        return begin is not None
    names = otherNames()
    return name[len(begin) :] in names and (begin != _DRUDE or _hasDrudeParticles(names))


@cache
def _siteName(kind, residueName, name, hasElement):
    """Return the beginning of a site's name, or None for other atoms, and whether another atom's name follows it."""
    for residue, pattern in readNames("site"):
        if residue not in (kind, residueName) and (residue != "*" or hasElement):
            continue
        begin = pattern.rstrip("*+")
        if name == begin or (pattern != begin and name.startswith(begin)):
            return begin, pattern.endswith("+")
    return None, False


def _hasDrudeParticles(names):
    """Whether a residue with these names of atoms has Drude particles, whose names look like names of deuterium."""
    heavy = {name for name in names if name[:1].isalpha() and name[0] not in _HYDROGEN_LETTERS}
    return 2 * sum(_DRUDE + name in names for name in heavy) >= len(heavy)


@cache
def _kindOf(residueName):
    if isCalledWater(residueName):
        return "water"
    return "polymer" if isPolymerName(residueName) else ""


@cache
def _marks():
    """Return the names of marks, each with a list of sets of atoms that identify it."""
    marks = {}
    for residue, atoms in readNames("mark"):
        marks.setdefault(residue, []).append(set(atoms.split()))
    return marks
