"""Hydrogens where the program Reduce places them, before groups that turn are optimized.

Hydrogens that geometry determines get ideal places. Methyl groups are staggered. Groups that turn start in trans; of a
histidine both nitrogens get one. Bond lengths are those of electron clouds, which are shorter than those of nuclei.

Source: Reduce 4.16; J. M. Word et al., J. Mol. Biol. 285, 1735-1747 (1999).
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ..datatables import readTable
from ..residues import aminoAcid, isPolymerName, nucleotide
from .contactatoms import HYDROGEN, METAL, WATER, atomKinds

# Bond lengths, nm, by kind of group.
_LENGTHS = {
    "CH": 0.097, "CH2": 0.097, "CH3": 0.097, "=CH2": 0.097, "vinyl CH": 0.097, "aromatic CH3": 0.097,
    "aromatic CH": 0.093, "NH": 0.086, "fixed NH": 0.086, "NH2": 0.086, "peptide NH": 0.086, "proline NH2": 0.086,
    "NH3": 0.089, "OH": 0.084, "SH": 0.12,
}  # fmt: skip
TETRAHEDRAL, _TRIGONAL = 109.5, 120.0
# Degrees between a hydrogen of CH2 and the plane's inside.
_OUTSIDE = 126.5
# The hydrogen of a peptide divides the outer angle at N like this.
_PEPTIDE_SHARE = 0.48

# The dihedrals of the hydrogens of a group about its bond, with the angle at the atom that bears them.
_DIHEDRALS = {
    "CH3": (TETRAHEDRAL, (180, -60, 60)), "aromatic CH3": (TETRAHEDRAL, (180, -60, 60)),
    "NH3": (TETRAHEDRAL, (180, -60, 60)), "OH": (TETRAHEDRAL, (180,)), "SH": (TETRAHEDRAL, (180,)),
    "NH2": (_TRIGONAL, (0, 180)), "=CH2": (_TRIGONAL, (0, 180)),
}  # fmt: skip
ROTORS = ("OH", "SH", "NH3", "aromatic CH3")
_REPLACEABLE = ("OH", "SH", "NH3", "NH", "NH2", "peptide NH", "proline NH2")

# Residues are connected if C and N are this far apart, nm.
_PEPTIDE_BOND = (0.11, 0.17)
# A hydrogen is left out if this near (nm) to the surface of another atom that is bonded to its own: else, and metals.
_NEAR, _NEAR_METAL = 0.0125, 0.0865
# How far the distance of bonded atoms may differ from the sum of their covalent radii, nm.
_SHORTEST, _LONGEST = -0.065, 0.025
_SHORTEST_OF_ROTORS = -0.055


class PlacedHydrogens(NamedTuple):
    """Hydrogens of a Topology, in the order of the atoms' residues.

    names : list of str; parents : (m,) int array, the atoms that bear them; positions : (m, 3) float64 array, nm
    rotors : list of Rotor; histidines : list of (int, int): hydrogens on ND1 and NE2, of which Reduce keeps one
    """

    names: list[str]
    parents: np.ndarray
    positions: np.ndarray
    rotors: list["Rotor"]
    histidines: list[tuple[int, int]]


class Rotor(NamedTuple):
    """Hydrogens that turn about a bond.

    kind : str, of ROTORS; axis : (int, int, int): the atom that bears them, its neighbor, and the neighbor's neighbor,
    against which the dihedral is measured; hydrogens : list of int, the first in trans
    """

    kind: str
    axis: tuple[int, int, int]
    hydrogens: list[int]


class _Group(NamedTuple):
    kind: str
    atoms: tuple[int, ...]
    names: list[str]


def placeHydrogens(topology, positions, areClashesBonds=True):
    """Return the PlacedHydrogens of the amino acids, nucleotides and hemes of a Topology without hydrogens.

    positions : (n, 3) float64 array, nm
    areClashesBonds : whether atoms of two residues that are as near as if they were bonded take the places of
        hydrogens, as in Reduce; if not, only sulfurs, metals and residues that are no polymer's do

    Other residues get none, as those that the program's dictionary does not know. Waters get none.
    """
    groups = [group for residue in _connected(topology, positions) for group in _groupsOf(*residue)]
    places = _placesOf(groups, positions)
    areFree = _areFree(topology, positions, groups, places, areClashesBonds)
    names, parents, rotors = [], [], []
    polar: dict[int, int] = {}
    number = 0
    for group in groups:
        first = len(names)
        for name in group.names:
            if areFree[number]:
                names.append(name)
                parents.append(group.atoms[0])
            number += 1
        if len(names) == first:
            continue
        if group.kind in ROTORS:
            rotors.append(Rotor(group.kind, group.atoms[:3], list(range(first, len(names)))))
        elif group.kind == "NH":
            polar[group.atoms[0]] = first
    histidines = []
    for residue in topology.residues():
        if aminoAcid(residue.name) == "HIS":
            ring = {atom.name: atom.index for atom in residue.atoms()}
            both = [polar.get(ring.get(name)) for name in ("ND1", "NE2")]
            if None not in both:
                histidines.append(tuple(both))
    return PlacedHydrogens(names, np.array(parents, dtype=int), places[areFree], rotors, histidines)


def isPlaced(name):
    """Return whether residues of a name get hydrogens."""
    return aminoAcid(name) is not None or nucleotide(name) is not None or name in _table()


@cache
def _table():
    """Return the rows of the table of hydrogens by residue: kind, names of atoms, names of hydrogens."""
    rows: dict[str, list[tuple[str, list[str], list[str]]]] = {}
    for residue, kind, atoms, hydrogens in readTable("hydrogens.csv"):
        rows.setdefault(residue, []).append((kind, atoms.split(), hydrogens.split()))
    return rows


def _connected(topology, positions):
    """Yield for each residue that gets hydrogens: it, its atoms by name, and C of the residue that it is bonded to."""
    previous = None
    for residue in topology.residues():
        atoms = {atom.name: atom.index for atom in residue.atoms() if atom.element is not None}
        before = None
        if previous is not None and previous[0].chain is residue.chain and "N" in atoms and "C" in previous[1]:
            carbon = previous[1]["C"]
            distance = np.linalg.norm(positions[carbon] - positions[atoms["N"]])
            before = carbon if _PEPTIDE_BOND[0] < distance < _PEPTIDE_BOND[1] else None
        yield residue, atoms, before
        previous = residue, atoms


def _groupsOf(residue, atoms, before):
    """Yield the _Group of each atom of a residue that bears hydrogens and has the neighbors that say where."""
    amino, base = aminoAcid(residue.name), nucleotide(residue.name)
    name = amino or (base.removeprefix("D") if base else residue.name)
    name = "T" if name == "T" or base == "DT" else name
    rows = list(_table().get(name, ()))
    if amino is not None or name == "PCA":
        yield from _aminoGroups(residue, name, atoms, before)
        rows = [*_table()["amino acid"], *rows]
    if base is not None:
        rows += _table()["nucleotide"]
        rows = [row for row in rows if row[1][0] != "C2'" or (row[0] == "CH") == ("O2'" in atoms)]
    for kind, needed, hydrogens in rows:
        if all(atom in atoms for atom in needed) and not (name == "GLY" and hydrogens == ["HA"]):
            yield _Group(kind, tuple(atoms[atom] for atom in needed), hydrogens)


def _aminoGroups(residue, name, atoms, before):
    """Yield the group of an amino acid's N: of a peptide, or of the first residue. Behind a gap, N gets no hydrogen."""
    if before is not None:
        if name != "PRO" and "N" in atoms and "CA" in atoms:
            yield _Group("peptide NH", (atoms["N"], atoms["CA"], before), ["H"])
    elif _numberOf(residue) <= 1:
        if name == "PRO":
            if all(atom in atoms for atom in ("N", "CD", "CA")):
                yield _Group("proline NH2", (atoms["N"], atoms["CD"], atoms["CA"]), ["H2", "H3"])
        elif all(atom in atoms for atom in ("N", "CA", "C")):
            yield _Group("NH3", (atoms["N"], atoms["CA"], atoms["C"]), ["H1", "H2", "H3"])


def _numberOf(residue):
    try:
        return int(residue.id)
    except ValueError:
        return residue.index - next(iter(residue.chain.residues())).index + 1


# ---- Places ----


def _placesOf(groups, positions):
    """Return the places of all hydrogens of groups, in order, as an (m, 3) array, nm."""
    counts = np.array([len(group.names) for group in groups], dtype=int)
    starts = np.concatenate([[0], np.cumsum(counts)])
    places = np.zeros((starts[-1], 3))
    kinds: dict[str, list[int]] = {}
    for number, group in enumerate(groups):
        kinds.setdefault(group.kind, []).append(number)
    for kind, numbers in kinds.items():
        points = positions[np.array([groups[number].atoms for number in numbers])].transpose(1, 0, 2)
        for offset, found in enumerate(_placesOfKind(kind, points)):
            places[starts[numbers] + offset] = found
    return places


def _placesOfKind(kind, points):
    """Return the places of each hydrogen of groups of a kind; points are those of their atoms, (atoms, groups, 3)."""
    length = _LENGTHS[kind]
    if kind == "CH":
        return [points[0] - length * _unit(sum(_unit(point - points[0]) for point in points[1:]))]
    if kind in ("CH2", "proline NH2"):
        between = points[0] + 0.5 * (_unit(points[1] - points[0]) + _unit(points[2] - points[0]))
        return [turnedPlace(points[0], between, points[1], length, angle, 90.0) for angle in (-_OUTSIDE, _OUTSIDE)]
    if kind in _DIHEDRALS:
        angle, dihedrals = _DIHEDRALS[kind]
        return [turnedPlace(*points[:3], length, angle, dihedral) for dihedral in dihedrals]
    if kind == "peptide NH":
        first, second = (_unit(point - points[0]) for point in points[1:3])
        normal = _unit(np.cross(first, second))
        inner = np.degrees(np.arccos(np.clip((first * second).sum(axis=1), -1, 1)))
        return [points[0] + length * turn(first, normal, -_PEPTIDE_SHARE * (360 - inner))]
    return [planarPlace(*points, length)]


def planarPlace(bearer, neighbor1, neighbor2, length):
    """Return the places at a length from bearers, opposite to their two neighbors; points are (n, 3) arrays, nm."""
    return bearer - length * _unit(_unit(neighbor1 - bearer) + _unit(neighbor2 - bearer))


def turnedPlace(bearer, neighbor, reference, length, angle, dihedral):
    """Return the places at a length from bearers, an angle with neighbors and a dihedral with references, in degrees.

    The arrays of points are (n, 3), nm; dihedral is a number, or one for each.
    """
    axis = _unit(neighbor - bearer)
    across = reference - neighbor
    across = _unit(across - (across * axis).sum(axis=1)[:, None] * axis)
    side = np.cross(axis, across)
    theta, phi = np.radians(angle), np.radians(np.asarray(dihedral, dtype=float))[..., None]
    return bearer + length * (np.cos(theta) * axis + np.sin(theta) * (np.cos(phi) * across - np.sin(phi) * side))


def turn(vectors, axes, degrees):
    """Return vectors turned about unit axes by angles, right-handed; all are (n, 3) and (n,)."""
    cosine, sine = np.cos(np.radians(degrees))[..., None], np.sin(np.radians(degrees))[..., None]
    along = (vectors * axes).sum(axis=-1)[..., None] * axes
    return along + cosine * (vectors - along) + sine * np.cross(axes, vectors)


def _unit(vectors):
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(lengths > 0, lengths, 1)


# ---- Hydrogens that another bond replaces ----


def _areFree(topology, positions, groups, places, areClashesBonds):
    """Return for each hydrogen of groups whether no bond of its O, S or N takes its place, as a bool array."""
    radii, covalent, flags = atomKinds(topology)
    residues = np.array([atom.residue.index for atom in topology.atoms()])
    isMetal = flags & METAL > 0
    isOther = isMetal | np.array([not isPolymerName(atom.residue.name) for atom in topology.atoms()], dtype=bool)
    areFree = np.ones(len(places), dtype=bool)
    starts = np.cumsum([0, *(len(group.names) for group in groups)])
    suspects = [index for index, group in enumerate(groups) if group.kind in _REPLACEABLE]
    bearers = np.array([groups[index].atoms[0] for index in suspects], dtype=int)
    heavy = np.flatnonzero((covalent > 0) & (flags & (HYDROGEN | WATER) == 0))
    if not len(bearers):
        return areFree
    near = cKDTree(positions[heavy]).query_ball_point(positions[bearers], covalent[heavy].max() + 0.11 + _LONGEST)
    for index, bearer, found in zip(suspects, bearers.tolist(), near, strict=True):
        kind = groups[index].kind
        others = heavy[found]
        excess = np.linalg.norm(positions[others] - positions[bearer], axis=1) - covalent[others] - covalent[bearer]
        isBonded = (others != bearer) & (excess <= _LONGEST)
        isBonded &= excess >= (_SHORTEST_OF_ROTORS if kind in ROTORS else _SHORTEST)
        if kind not in ROTORS:
            isBonded &= residues[others] != residues[bearer]
        own = slice(starts[index], starts[index + 1])
        least = 2 if kind in ROTORS else 1
        if not areClashesBonds and kind != "SH":
            isBonded &= isOther[others]
            least = 1
        if isBonded.sum() < least:
            continue
        if kind in ("OH", "SH"):
            areFree[own] = False
            continue
        others = others[isBonded]
        limits = radii[others] + np.where(isMetal[others] & (kind != "NH3"), _NEAR_METAL, _NEAR)
        gaps = np.linalg.norm(places[own, None] - positions[others], axis=2) - limits
        areFree[own] = (gaps >= 0).all(axis=1)
    return areFree
