"""Replacing modified residues that a force field does not have by the standard ones they are made from."""

import gemmi
import numpy as np

from ...errors import InputError
from ...extras import importExtra
from ...graphs import growTrees, neighborLists
from ...naming import describeResidue
from ...notes import Note, found
from ...residues import PEPTIDE_BACKBONE, isPolymer
from ...structures.structure import withoutAtoms
from ...templates import isStandard, templateBonds

# The atom that a replaced residue keeps in any case.
_CENTERS = (PEPTIDE_BACKBONE[1], "C4'")


def standardOf(name):
    """Return the standard residue that a modified one is made from, such as MET for MSE; None if that is not known."""
    fixer = importExtra("pdbfixer.pdbfixer", "--prepare", InputError)
    standard = fixer.substitutions.get(name)
    if standard is None:
        entry = gemmi.find_tabulated_residue(name)
        letter = entry.one_letter_code.strip()
        standard = gemmi.expand_one_letter(letter.upper(), entry.kind) if letter else None
    return standard if standard is not None and standard != name and isStandard(standard) else None


def replaceModified(structure, energyModel):
    """Return a Structure without modified residues of polymers that an EnergyModel does not have, and a list of Note.

    The standard residue keeps the atoms that the two have in common; what it lacks is to be completed. Without an
    EnergyModel, nothing is replaced.
    """
    if energyModel is None:
        return structure, []
    left, names, items = [], {}, []
    for residue in structure.topology.residues():
        if not isPolymer(residue) or energyModel.hasTemplateOf(residue):
            continue
        standard = standardOf(residue.name)
        kept = set() if standard is None else _commonAtoms(structure.topology, residue, standard)
        if kept:
            names[residue] = standard
            items.append(f"{describeResidue(residue)} by {standard}")
            left += [atom.index for atom in residue.atoms() if atom.index not in kept]
    if not names:
        return structure, []
    changed = withoutAtoms(structure, np.array(left, dtype=int))
    for residue, copy in zip(structure.topology.residues(), changed.topology.residues(), strict=True):
        copy.name = names.get(residue, copy.name)
    return changed, found([Note("residues replaced, which the force field does not have", items)])


def _commonAtoms(topology, residue, standard):
    """Return the indices of atoms that a residue shares with a standard one: bonded alike, around its center."""
    atoms = list(residue.atoms())
    places = {atom.index: number for number, atom in enumerate(atoms)}
    own = {
        frozenset((places[first.index], places[second.index]))
        for first, second in topology.bonds()
        if first.residue is residue and second.residue is residue
    }
    center = next((number for number, atom in enumerate(atoms) if atom.name in _CENTERS), None)
    if center is None:
        return set()
    wanted = [tuple(bond) for bond in templateBonds(standard, [atom.name for atom in atoms])]
    left = set()
    while True:
        bonds = [bond for bond in wanted if frozenset(bond) in own and left.isdisjoint(bond)]
        order = [center, *(atom for atom, _ in growTrees(neighborLists(len(atoms), bonds), [center]) if atom != center)]
        extra = [bond for bond in own - set(map(frozenset, wanted)) if bond <= set(order)]
        if not extra:
            return {atoms[number].index for number in order}
        left.add(max(extra[0], key=order.index))  # the ring of pyroglutamate opens at its end
