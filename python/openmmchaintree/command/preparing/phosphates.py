"""Phosphates of nucleic acids: missing ones between nucleotides, and ones at 5' ends."""

from itertools import pairwise

import numpy as np
from openmm.app import element

from ...naming import describeResidue
from ...notes import Note
from ...residues import isNucleotide
from ...structures.structure import withoutAtoms
from ...templates import atomAliases, standardName
from ..hydrogens import boundEnds

_PHOSPHATE = ("P", "OP1", "OP2", "OP3", "O1P", "O2P", "O3P")

# The chain between two sugars, and the largest distance (nm) of atoms with 1, 2 or 3 missing atoms between: two bonds
# of 0.16 nm at an angle of at most 120°, and 0.13 nm along the chain for each further bond.
_CHAIN = (("C3'", "O3'"), ("P", "O5'", "C5'"))
_REACH = (0.30, 0.43, 0.56)


def nucleotidesToJoin(structure):
    """Return the nucleotides of a Structure, a set, that follow another one in a chain without the atoms of the bond.

    P, O5' or the O3' before is missing, and the atoms on both sides are close enough. Two hydroxyls are no bond.
    """
    front, back = boundEnds(structure.topology)
    found = set()
    for chain in structure.topology.chains():
        for before, residue in pairwise(chain.residues()):
            if before in back or residue in front or not (isNucleotide(before.name) and isNucleotide(residue.name)):
                continue
            first, second = _byName(before), _byName(residue)
            ends = [name for name in reversed(_CHAIN[0]) if name in first], [n for n in _CHAIN[1] if n in second]
            if not all(ends):
                continue
            missing = 1 - _CHAIN[0].index(ends[0][0]) + _CHAIN[1].index(ends[1][0])
            atoms = first[ends[0][0]], second[ends[1][0]]
            distance = np.linalg.norm(structure.positions[atoms[0].index] - structure.positions[atoms[1].index])
            if missing and distance <= _REACH[missing - 1] and not any(map(_isHydroxyl, atoms)):
                found.add(residue)
    return found


def withoutPhosphates(structure, energyModel):
    """Return a Structure without 5' phosphates that the force field does not have, and a list of Note."""
    if energyModel is None or energyModel.hasPhosphateEnds():
        return structure, []
    inside = boundEnds(structure.topology)[0] | nucleotidesToJoin(structure)
    left, items = [], []
    for residue in structure.topology.residues():
        phosphate = [atom.index for atom in residue.atoms() if atom.name in _PHOSPHATE]
        if isNucleotide(residue.name) and residue not in inside and phosphate:
            left += phosphate
            items.append(describeResidue(residue))
    if not left:
        return structure, []
    note = Note("phosphates at 5' ends left out, which the force field does not have", items)
    return withoutAtoms(structure, np.array(left)), [note]


def _byName(residue):
    """Return the atoms of a residue by their names in OpenMM's tables."""
    aliases = atomAliases(standardName(residue.name))
    return {aliases.get(atom.name, atom.name): atom for atom in residue.atoms()}


def _isHydroxyl(atom):
    bonds = [bond for bond in atom.residue.internal_bonds() if atom in bond[:2]]
    return atom.element is element.oxygen and any(other.element is element.hydrogen for bond in bonds for other in bond)
