"""The connected parts of a graph."""

import numpy as np


def connectedParts(count, bonds):
    """Return for each of count atoms the number of its connected part, as an int array.

    Parts are numbered in the order of their first atoms. bonds : sequence of pairs, or (m, 2) int array
    """
    # Union-find.
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
