"""Basins of a loop: conformers that lie near each other in the frame of the fixed part."""

import numpy as np

RADIUS = 0.1  # nm


def findBasins(backbones, radius=RADIUS):
    """Return the basin of each conformer, numbered from 0 in the order of their first conformers.

    A conformer belongs to the first basin whose first conformer has an RMSD below the radius, without superposition;
    if there is none, it begins a new one. Takes O(conformers × basins) time.

    backbones : (conformers, n, 3) array, nm; radius : float, nm
    """
    flat = np.asarray(backbones, dtype=np.float64).reshape(len(backbones), -1)
    most = radius**2 * flat.shape[1] / 3
    firsts, basins = [], []
    for conformer in flat:
        near = np.flatnonzero(np.sum((np.array(firsts) - conformer) ** 2, axis=1) < most) if firsts else []
        basins.append(int(near[0]) if len(near) else len(firsts))
        if not len(near):
            firsts.append(conformer)
    return np.array(basins, dtype=int)
