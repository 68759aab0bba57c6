"""Making a Topology from a model that gemmi has read."""

from functools import cache
from typing import NamedTuple

import gemmi
import numpy as np
from openmm import app

from ..naming import joinNames
from ..notes import Note, found
from ..residues import isCalledWater, isWaterOf
from .conformers import NO_ALTERNATE, chooseConformers


class ModelTopology(NamedTuple):
    """A model with one conformer of each residue.

    model : gemmi.Model
    topology : openmm.app.Topology, without bonds
    atoms : list of gemmi.Atom, in the order of the Topology
    positions : (n, 3) float64 array, nm
    alternates : list of str, for each atom the label of its conformer, empty if the atom has one conformer
    notes : list of Note
    """

    model: gemmi.Model
    topology: app.Topology
    atoms: list[gemmi.Atom]
    positions: np.ndarray
    alternates: list[str]
    notes: list[Note]


def makeTopology(model):
    """Make a ModelTopology from a gemmi.Model: deuterium becomes hydrogen, every water is named HOH."""
    choice = chooseConformers(model, _describe)
    topology = app.Topology()
    atoms, alternates = [], []
    for chain, residues in zip(model, choice.chains, strict=True):
        newChain = topology.addChain(chain.name)
        for residue, members in residues:
            number = residue.seqid
            isWater = isCalledWater(residue.name) and isWaterOf(atom.element.name for atom in members)
            name = "HOH" if isWater else residue.name
            for part in _splitCopies(members):
                newResidue = topology.addResidue(name, newChain, _textOf(number.num), number.icode.strip())
                for atom in part:
                    element = _element(atom.element.name)
                    # Old files write C1* for C1'.
                    topology.addAtom(atom.name.replace("*", "'"), element, newResidue, str(atom.serial))
                    atoms.append(atom)
                    alternates.append("" if atom.altloc == NO_ALTERNATE else atom.altloc)
    positions = 0.1 * np.array([atom.pos.tolist() for atom in atoms], dtype=np.float64).reshape(-1, 3)
    notes = found([Note("residues of which the conformer of highest occupancy is taken", choice.described)])
    return ModelTopology(model, topology, atoms, positions, alternates, notes)


def _describe(chain, residue):
    return joinNames(chain.name, f"{residue.name} {residue.seqid}")


def _textOf(number):
    return "" if number is None else str(number)


@cache
def _element(symbol):
    if symbol == "X":
        return None
    return app.Element.getBySymbol("H" if symbol == "D" else symbol)


def _splitCopies(atoms):
    """Split a residue that repeats the same atoms: consecutive ions or waters under one number."""
    names = [atom.name for atom in atoms]
    count = len(set(names))
    copies = len(names) // max(count, 1)
    isCopied = copies > 1 and names == names[:count] * copies and (count > 1 or atoms[0].element.is_metal)
    return [atoms[start : start + count] for start in range(0, len(atoms), count)] if isCopied else [atoms]
