"""Preparing a structure as a file has it: what --prepare does, and what it says."""

import numpy as np
from openmm.app import element

from ...bonds import BondGraph
from ...bondsearch import GAPS
from ...naming import describeResidue
from ...notes import Note, countOf, found
from ..hydrogens import addHydrogens
from .additives import withoutAdditives
from .completing import completeHeavyAtoms
from .handedness import findShapes, mirrorWrongCenters, wrongShapes
from .hydrogendefinitions import defineHydrogens
from .replacing import replaceModified

# Iterations to relax added atoms, if heavy atoms are among them.
_RELAXING_ITERATIONS = 1000

# Tries to give centers their hand.
_ROUNDS = 4

# A bond of a built residue that is longer (nm) was not closed.
_LONGEST_BOND = 0.2


def prepareStructure(structure, energyModel, pH, seed):
    """Return a Structure ready for an EnergyModel (None: for hard spheres), and the number of added hydrogens.

    Atoms that stay do not move. The notes of the Structure say what was done.

    Raises
    ------
    InputError
        if too much is missing, or the force field does not have a residue
    """
    former = [note for note in structure.notes if note.kind != GAPS]  # those below say more
    structure, notes = withoutAdditives(structure, energyModel)
    structure, more = replaceModified(structure, energyModel)
    notes += more
    structure, heavy, templates, more = completeHeavyAtoms(structure, energyModel, seed)
    notes += more
    isHeavy = np.zeros(structure.topology.getNumAtoms(), dtype=bool)
    isHeavy[heavy] = True
    if energyModel is not None:
        defineHydrogens(structure.topology, energyModel)
    complete, hydrogens = addHydrogens(structure._replace(notes=[]), pH, seed, mindMetals=True)
    notes += complete.notes
    added = np.zeros(complete.topology.getNumAtoms(), dtype=bool)
    added[hydrogens] = True
    added[~added] = isHeavy
    complete = complete._replace(notes=[])
    isNew = added & _areHeavy(complete.topology)
    shapes = findShapes(complete, isNew, templates)
    if energyModel is not None and added.any():
        complete = complete._replace(positions=_relax(complete, energyModel, added, isNew, shapes))
    notes += _describeResult(complete, isNew, shapes)
    notes.append(Note(f"{countOf(len(hydrogens), 'hydrogen')} added, at pH {pH:g}"))
    return complete._replace(notes=[*former, *notes]), len(hydrogens)


def _relax(structure, energyModel, added, isNew, shapes):
    """Return the positions of a Structure with relaxed added atoms, a bool array; heavy ones are isNew."""
    atoms = np.flatnonzero(added)
    if not isNew.any():
        return energyModel.relax(structure, atoms)
    if not wrongShapes(shapes, structure.positions):
        return energyModel.relax(structure, atoms, _RELAXING_ITERATIONS)
    for _ in range(_ROUNDS):
        if wrongShapes(shapes, structure.positions):
            structure = structure._replace(positions=mirrorWrongCenters(structure, added, shapes))
            structure = structure._replace(positions=energyModel.relax(structure, atoms, _RELAXING_ITERATIONS, shapes))
    return structure.positions


def _describeResult(structure, isNew, shapes):
    """Return Notes on disulfides, and on the geometry of completed residues."""
    graph = BondGraph(structure.topology, structure.positions)
    atoms, positions = graph.atoms, structure.positions
    disulfides = [" – ".join(describeResidue(atoms[atom].residue) for atom in pair) for pair in graph.disulfides]
    bonds = [(bond[0].index, bond[1].index) for bond in structure.topology.bonds()]
    new = [bond for bond in bonds if isNew[list(bond)].any()]
    long = [bond for bond in new if np.linalg.norm(positions[bond[0]] - positions[bond[1]]) > _LONGEST_BOND]
    wrong = dict.fromkeys(describeResidue(shape.residue) for shape in wrongShapes(shapes, positions))
    return found(
        [
            Note("disulfides", disulfides),
            Note(
                "bonds of completed residues that are still too long (--minimize may help)",
                map(graph.describePair, long),
            ),
            Note("completed residues with wrong chirality, or with a cis peptide bond", wrong),
        ]
    )


def _areHeavy(topology):
    return np.array([atom.element is not element.hydrogen for atom in topology.atoms()])
