"""Minimizing the energy of a structure before sampling."""

import numpy as np

from ...naming import nameAtom
from ...notes import Note
from ..plan import selectByOption


def minimizeStructure(structure, energyModel, fix):
    """Return a Structure at lower energy; a note says how far atoms moved.

    fix : str or None, the selection of atoms that do not move

    Raises
    ------
    InputError
        if the force field does not fit, or the energy is not a number
    """
    moving = np.ones(structure.topology.getNumAtoms(), dtype=bool)
    moving[selectByOption(structure.topology, "--fix", fix)] = False
    positions, energies = energyModel.minimize(structure, np.flatnonzero(moving))
    moved = np.linalg.norm(positions - structure.positions, axis=1)
    most = int(moved.argmax())
    atom = next(atom for atom in structure.topology.atoms() if atom.index == most)
    note = Note(
        f"minimized: energy {energies[0]:,.0f} to {energies[1]:,.0f} kJ/mol; atoms moved by at most {moved[most]:.3f} "
        f"nm ({nameAtom(atom)}), in the mean by {moved.mean():.3f} nm"
    )
    return structure._replace(positions=positions, notes=[*structure.notes, note])
