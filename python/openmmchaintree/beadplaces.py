"""Where the beads of chains are: in a protein with all atoms, or on a lattice to start from."""

import math

import numpy as np
from openmm import app, unit

from .errors import InputError
from .units import positionsInNm

_LONGEST_STEP = 0.5  # nm, between the Cα atoms of neighbors


def placesOfResidues(source, usesMassCenters):
    """Return the names of residues by chain, and the places of their beads (nm)."""
    positions = positionsInNm(source.positions, source.topology.getNumAtoms())
    chains, places = [], []
    for chain in source.topology.chains():
        names, alphas, last = [], [], None
        for residue in chain.residues():
            atoms = list(residue.atoms())
            alpha = next((atom for atom in atoms if atom.name == "CA" and atom.element is app.element.carbon), None)
            if alpha is None:
                continue
            if last and math.dist(alphas[-1], positions[alpha.index]) > _LONGEST_STEP:
                raise InputError(
                    f"chain {chain.id} has a gap between residues {last.id} and {residue.id}; build missing ones first"
                )
            last = residue
            names.append(residue.name)
            alphas.append(positions[alpha.index])
            if usesMassCenters:
                modelled = [atom for atom in atoms if atom.element is not None]
                masses = [atom.element.mass.value_in_unit(unit.dalton) for atom in modelled]
                places.append(np.average(positions[[atom.index for atom in modelled]], axis=0, weights=masses))
            else:
                places.append(alphas[-1])
        if names:
            chains.append(names)
    return chains, np.array(places).reshape(-1, 3)


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
