"""The connected parts of a graph."""

import numpy as np


def connectedParts(count, bonds):
    """Return the number of the part that each of count atoms belongs to, as an int array.

    bonds : sequence of pairs, or (m, 2) int array
    """
    # SciPy takes a while to import.
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    pairs = np.asarray(bonds, dtype=int).reshape(-1, 2)
    table = coo_array((np.ones(len(pairs), dtype=np.int8), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return connected_components(table, directed=False)[1]
