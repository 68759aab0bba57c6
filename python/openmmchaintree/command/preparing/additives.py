"""Ions and crystallisation additives that a force field does not have."""

import gemmi
import numpy as np

from ...covalent import isMetal
from ...datatables import readNames
from ...naming import describeResidue
from ...notes import Note, found
from ...residues import CAPS, isPolymer
from ...structures.structure import withoutAtoms

# Ions of these elements are loosely bound, and common in buffers; other metals are part of a site.
_HALOGENS = {9, 17, 35, 53}
_LIGHT_METALS = {3, 11, 19, 37, 55, 4, 12, 20, 38, 56}  # alkali and alkaline earth metals


def withoutAdditives(structure, energyModel):
    """Return a Structure without ions of buffers and additives that an EnergyModel does not have, and list of Note.

    Ions of zinc, iron and other transition metals, ligands, and what is bonded to a residue stay. So does everything
    without an EnergyModel.
    """
    if energyModel is None:
        return structure, []
    bound = _boundResidues(structure.topology)
    ions, additives = [], []
    for residue in structure.topology.residues():
        if isPolymer(residue) or residue.name in CAPS or energyModel.hasTemplateOf(residue):
            continue
        if _isBufferIon(residue):
            ions.append(residue)
        elif residue not in bound and _isAdditive(residue):
            additives.append(residue)
    left = set(ions + additives)
    if not left:
        return structure, []
    atoms = [atom.index for residue in left for atom in residue.atoms()]
    return withoutAtoms(structure, np.array(sorted(atoms))), found(
        [
            Note("bound ions left out, which the force field does not have", map(describeResidue, ions)),
            Note("crystallisation additives left out", map(describeResidue, additives)),
        ]
    )


def _boundResidues(topology):
    """Return the residues with bonds to other residues, except bonds of metals."""
    bound = set()
    for first, second in topology.bonds():
        areMetals = [isMetal(atom.element.atomic_number) for atom in (first, second)]
        if first.residue is not second.residue and not any(areMetals):
            bound.update((first.residue, second.residue))
    return bound


def _isBufferIon(residue):
    atoms = list(residue.atoms())
    return len(atoms) == 1 and atoms[0].element.atomic_number in _HALOGENS | _LIGHT_METALS


def _isAdditive(residue):
    kind = gemmi.find_tabulated_residue(residue.name).kind
    isIon = len(residue) == 1
    return not isIon and (
        kind == gemmi.ResidueKind.BUF or any(residue.name == name for name, _ in readNames("additive"))
    )
