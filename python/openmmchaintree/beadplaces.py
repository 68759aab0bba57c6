"""Where the beads of chains are: in a protein with all atoms, or on a lattice to start from."""

import math
from itertools import pairwise

import numpy as np
from openmm import app, unit

from .errors import InputError
from .units import positionsInNm

_LONGEST_STEP = 0.5  # nm, between the Cα atoms of neighbors


def beadResidues(topology):
    """Return the residues of each chain that become beads, those with a Cα atom, as a list of (residue, Cα atom)."""
    chains = []
    for chain in topology.chains():
        found = []
        for residue in chain.residues():
            alphas = [atom for atom in residue.atoms() if atom.name == "CA" and atom.element is app.element.carbon]
            found.extend((residue, alpha) for alpha in alphas[:1])
        if found:
            chains.append(found)
    return chains


def placesOfResidues(source, usesMassCenters):
    """Return the names of residues by chain, and the places of their beads (nm): centers of mass, or Cα atoms.

    source : an object with `topology` and `positions`
    """
    positions = positionsInNm(source.positions, source.topology.getNumAtoms())
    chains = beadResidues(source.topology)
    for chain in chains:
        for (first, before), (second, after) in pairwise(chain):
            if math.dist(positions[before.index], positions[after.index]) > _LONGEST_STEP:
                raise InputError(
                    f"chain {first.chain.id} has a gap between residues {first.id} and {second.id}: first build the "
                    "residues that are missing there"
                )
    names = [[residue.name for residue, _ in chain] for chain in chains]
    if usesMassCenters:
        places = [_massCenter(residue, positions) for chain in chains for residue, _ in chain]
    else:
        places = [positions[alpha.index] for chain in chains for _, alpha in chain]
    return names, np.array(places).reshape(-1, 3)


def _massCenter(residue, positions):
    atoms = [atom for atom in residue.atoms() if atom.element is not None]
    masses = [atom.element.mass.value_in_unit(unit.dalton) for atom in atoms]
    return np.average(positions[[atom.index for atom in atoms]], axis=0, weights=masses)


def layOut(counts, bond, lengths=None):
    """Return chains on a lattice, without overlaps: straight lines, folded where the box ends, an (n, 3) array in nm.

    counts : residues of each chain; bond : nm; lengths : of the box in nm, or None
    """
    perRow, rows, layers = (max(counts), 1, 1) if lengths is None else _room(bond, lengths)
    places, row = [], 0
    for count in counts:
        path = []
        while len(path) < count:
            layer, inLayer = divmod(row, rows)
            if layer == layers:
                raise InputError(f"the box has no room for {sum(counts):,} residues that do not overlap: enlarge it")
            y = inLayer if layer % 2 == 0 else rows - 1 - inLayer
            x = range(perRow) if row % 2 == 0 else range(perRow - 1, -1, -1)
            line = [(each, 2 * y, 2 * layer) for each in x]
            if path:  # a bead between the rows
                path.append(tuple((a + b) // 2 for a, b in zip(path[-1], line[0], strict=True)))
            path.extend(line)
            row += 1
        places.extend(path[:count])
    return bond * np.array(places, dtype=np.float64)


def _room(bond, lengths):
    """Return how many beads a row has, how many rows a layer, and how many layers the box; rows are 2 bonds apart."""
    perRow, rows, layers = (np.floor(lengths / bond).astype(int) - [1, 0, 0]) // [1, 2, 2]
    return int(perRow), int(rows), int(layers)
