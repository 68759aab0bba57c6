"""Points that follow atoms as if they were bonded to them."""

import numpy as np


def carryAlong(neighbors, start, end, parents, points):
    """Return points (nm) after the motion of atoms that bear them, from `start` to `end`.

    neighbors : for each atom the list of atoms bonded to it; start, end : (n, 3) float64 arrays, nm
    parents : (m,) int array, the atom that bears each point; points : (m, 3) float64 array, nm, at the start

    A point turns with the bonds of its parent, or with the next bonds where that has only one. Where there are no such
    bonds, it is shifted with its parent.
    """
    if len(parents) == 0:
        return points
    first, second = np.array([_references(neighbors, start, atom) for atom in parents.tolist()]).T
    hasFrame = first >= 0
    moved = points + end[parents] - start[parents]
    before = _frames(start[parents], start[first], start[second])
    after = _frames(end[parents], end[first], end[second])
    local = np.einsum("nij,nj->ni", before, points - start[parents])
    turned = end[parents] + np.einsum("nji,nj->ni", after, local)
    moved[hasFrame] = turned[hasFrame]
    return moved


def _references(neighbors, start, atom):
    """Return two atoms that define the orientation of an atom's bonds; -1, -1 if there are none."""
    near = neighbors[atom]
    candidates = [(near[0], other) for other in near[1:]]
    if near:
        candidates += [(near[0], other) for other in neighbors[near[0]] if other != atom]
    for first, second in candidates:
        one, two = start[first] - start[atom], start[second] - start[atom]
        if np.linalg.norm(np.cross(one, two)) > 0.1 * np.linalg.norm(one) * np.linalg.norm(two):
            return first, second
    return -1, -1


def _frames(origins, first, second):
    """Return orthonormal frames, (n, 3, 3), a vector a row."""
    with np.errstate(invalid="ignore", divide="ignore"):
        x = first - origins
        x /= np.linalg.norm(x, axis=1, keepdims=True)
        z = np.cross(x, second - origins)
        z /= np.linalg.norm(z, axis=1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=1)
