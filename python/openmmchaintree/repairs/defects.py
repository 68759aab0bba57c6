"""Defects that torsions cannot mend: broken bonds, twisted peptides, and bonds that pierce rings."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ..covalent import isMetal, longestBonds
from ..graphs import ringBonds
from ..naming import describeResidue, nameAtom
from .angles import dihedral

# The longest and the shortest bonds that are whole, as factors of the sum of covalent radii.
_LONGEST, _SHORTEST = 1.12, 0.75
# Degrees from cis or trans.
_TWISTED = 30
_LARGEST_RING = 7
_NEAR_RING = 0.3  # nm from the middle of a ring to the middle of a bond through it


class Defect(NamedTuple):
    """A defect.

    kind : str, "broken bond", "twisted peptide" or "pierced ring"; atoms : tuple of int, the atoms that define it
    text : str, in words
    """

    kind: str
    atoms: tuple[int, ...]
    text: str


def findDefects(graph, positions, torsions):
    """Return the list of Defect of the atoms of a BondGraph at positions (nm), (n, 3). torsions : list of Torsion"""
    return [
        *_brokenBonds(graph, positions),
        *_twistedPeptides(graph, positions, torsions),
        *_piercedRings(graph, positions),
    ]


def _brokenBonds(graph, positions):
    """Return the bonds that are much longer or shorter than bonds of their elements, without bonds of metals."""
    bonds = np.array(graph.bonds, dtype=int).reshape(-1, 2)
    numbers = graph.numbers[bonds]
    bonds = bonds[(numbers > 1).all(axis=1) & ~isMetal(numbers).any(axis=1)]
    first, second = graph.numbers[bonds].T
    lengths = np.linalg.norm(positions[bonds[:, 0]] - positions[bonds[:, 1]], axis=1)
    sums = longestBonds(first, second, 1.0)
    isBad = (lengths > _LONGEST * sums) | (lengths < _SHORTEST * sums)
    return [
        Defect("broken bond", tuple(pair), f"{_pairName(graph, pair)}, {length:.3f} nm")
        for pair, length in zip(bonds[isBad].tolist(), lengths[isBad].tolist(), strict=True)
    ]


def _twistedPeptides(graph, positions, torsions):
    found = []
    for torsion in torsions:
        if torsion.kind != "omega":
            continue
        angle = np.degrees(dihedral(positions[list(torsion.particles)]))
        if _TWISTED < abs(angle) < 180 - _TWISTED:
            bond = torsion.particles[1:3]
            found.append(Defect("twisted peptide", tuple(bond), f"{_pairName(graph, bond)}, {angle:.0f}°"))
    return found


def _piercedRings(graph, positions):
    """Return the bonds of heavy atoms that pass through rings, of at most seven atoms, that they do not belong to."""
    rings = _ringsOf(graph)
    bonds = np.array([pair for pair in graph.bonds if (graph.numbers[list(pair)] > 1).all()], dtype=int).reshape(-1, 2)
    if not rings or len(bonds) == 0:
        return []
    middles = positions[bonds].mean(axis=1)
    centers = np.array([positions[ring].mean(axis=0) for ring in rings])
    found = []
    for ring, near in zip(rings, cKDTree(middles).query_ball_point(centers, _NEAR_RING), strict=True):
        for bond in bonds[sorted(near)].tolist():
            if set(bond).isdisjoint(ring) and _passesThrough(positions[bond], positions[ring]):
                residue = describeResidue(graph.atoms[ring[0]].residue)
                text = f"{_pairName(graph, bond)} through the ring of {residue}"
                found.append(Defect("pierced ring", (*bond, *ring), text))
    return found


def _ringsOf(graph):
    """Return the smallest rings of at most seven atoms that the bonds in rings close, as lists of atoms in order."""
    inRings = ringBonds(graph.neighbors)
    near = {}
    for first, second in inRings:
        near.setdefault(first, []).append(second)
        near.setdefault(second, []).append(first)
    found = {}
    for first, second in sorted(inRings):
        paths = [[first]]
        while paths and len(paths[0]) < _LARGEST_RING:
            paths = [[*path, atom] for path in paths for atom in sorted(near[path[-1]]) if atom not in path]
            paths = [path for path in paths if path[1:2] != [second]]
            closed = [path for path in paths if path[-1] == second]
            if closed:
                found.setdefault(frozenset(closed[0]), closed[0])
                break
    return list(found.values())


def _passesThrough(ends, corners):
    """Return whether a segment, (2, 3), crosses one of the triangles between the middle of a ring and its sides."""
    center, origin, direction = corners.mean(axis=0), ends[0], ends[1] - ends[0]
    side1, side2 = corners - center, np.roll(corners, -1, axis=0) - center
    normal = np.cross(direction, side2)
    determinant = (side1 * normal).sum(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        offset = origin - center
        u = (normal @ offset) / determinant
        q = np.cross(offset, side1)
        v = q @ direction / determinant
        t = (side2 * q).sum(axis=1) / determinant
    return bool(((u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0) & (t <= 1)).any())


def _pairName(graph, pair):
    return " – ".join(str(nameAtom(graph.atoms[atom])) for atom in pair)
