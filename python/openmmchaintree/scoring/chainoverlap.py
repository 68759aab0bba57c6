"""The verdict `has_clash` of AlphaFold 3: whether a chain lies in another, or in itself.

Source: AlphaFold 3, src/alphafold3/model/confidences.py.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ..residues import isPolymer

_DISTANCE = 0.11  # nm
_MOST_ATOMS, _MOST_SHARE = 100, 0.5


class ChainOverlap(NamedTuple):
    """A chain of a polymer.

    chain : str; atomCount : int; clashingCount : int, the number of its atoms that clash; hasClash : bool
    """

    chain: str
    atomCount: int
    clashingCount: int
    hasClash: bool


def chainOverlaps(topology, positions):
    """Return the ChainOverlap of each chain of proteins and nucleic acids; chains of one name are one.

    topology : openmm.app.Topology; positions : (n, 3) float64 array, nm

    An atom clashes if an atom at most 0.11 nm from it is of another chain, or of a residue whose number differs by more
    than one. A chain clashes if more than 100 of its atoms, or more than half of them, clash. AlphaFold 3 gives its
    models no hydrogens; here those of a file count.
    """
    residues = list(topology.residues())
    arePolymers = np.array([isPolymer(residue) for residue in residues], dtype=bool)
    numbers = np.array([_numberOf(residue) for residue in residues], dtype=int)
    names = [residue.chain.id for residue in residues]
    chains = {name: index for index, name in enumerate(dict.fromkeys(names))}
    chainOf = np.array([chains[name] for name in names], dtype=int)
    residueOf = np.array([atom.residue.index for atom in topology.atoms()], dtype=int)
    atoms = np.flatnonzero(arePolymers[residueOf]) if len(residueOf) else residueOf
    if not len(atoms):
        return []
    first, second = atoms[cKDTree(positions[atoms]).query_pairs(_DISTANCE, output_type="ndarray")].T
    residue1, residue2 = residueOf[first], residueOf[second]
    areApart = (np.abs(numbers[residue1] - numbers[residue2]) > 1) | (chainOf[residue1] != chainOf[residue2])
    clashes = np.zeros(len(residueOf), dtype=bool)
    clashes[first[areApart]] = clashes[second[areApart]] = True
    found = []
    for name, chain in chains.items():
        own = atoms[chainOf[residueOf[atoms]] == chain]
        if len(own):
            count = int(clashes[own].sum())
            found.append(ChainOverlap(name, len(own), count, count > _MOST_ATOMS or count / len(own) > _MOST_SHARE))
    return found


def _numberOf(residue):
    """Return the number of a residue, or its index in the chain where that is no number."""
    try:
        return int(residue.id)
    except ValueError:
        return residue.index
