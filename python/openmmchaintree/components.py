"""The connected parts of a graph."""

import numpy as np


def connectedParts(count, bonds):
    """Return the number of the part that each of count atoms belongs to, as an int array, in the order of first atoms.

    bonds : sequence of pairs, or (m, 2) int array
    """
    # Union-find; SciPy's takes longer to import than this takes for a hundred thousand atoms.
    parent = list(range(count))

    def find(atom):
        while parent[atom] != atom:
            parent[atom] = parent[parent[atom]]
            atom = parent[atom]
        return atom

    for first, second in np.asarray(bonds, dtype=int).reshape(-1, 2).tolist():
        first, second = find(first), find(second)
        parent[max(first, second)] = min(first, second)
    lowest = np.array([find(atom) for atom in range(count)], dtype=int)
    return np.unique(lowest, return_inverse=True)[1]
