"""Residues of peptides in ideal geometry: their atoms, bonds and places, around a backbone of standard geometry."""

import warnings
from functools import cache
from typing import NamedTuple

import numpy as np

from ..datatables import readTable
from ..errors import InputError
from ..extras import importExtra
from ..graphs import growTrees, neighborLists
from ..residues import PEPTIDE_BACKBONE, aminoAcid, isMirrored
from ..templates import templateBonds

# The backbone, in nm and degrees: R. A. Engh and R. Huber, Acta Cryst. A47, 392-400 (1991).
N_CA, CA_C, C_N, C_O, N_H = 0.1458, 0.1525, 0.1329, 0.1231, 0.101
N_CA_C, CA_C_N, C_N_CA, CA_C_O = np.radians([111.2, 116.2, 121.7, 120.8])

_OF_FREE_ENDS = ("OXT", "HXT", "H2", "H3")  # in the dictionary; and H, where the nitrogen has two other neighbors


class ResidueTemplate(NamedTuple):
    """A residue in a chain.

    names : tuple of str; elements : tuple of str; positions : (n, 3) float64 array, nm
    bonds : tuple of pairs of indices
    isMirrored : bool, whether it is a D-amino acid
    """

    names: tuple
    elements: tuple
    positions: np.ndarray
    bonds: tuple
    isMirrored: bool

    def place(self, name):
        """Return the index of an atom, -1 if there is none of this name."""
        return self.names.index(name) if name in self.names else -1

    def beyond(self, first, second):
        """Return the indices of the atoms that a turn about a bond moves: those on the side of its second atom."""
        bonds = [bond for bond in self.bonds if set(bond) != {first, second}]
        neighbors = neighborLists(len(self.names), bonds)
        return [second, *(atom for atom, _ in growTrees(neighbors, [second]) if atom != second)]


def residueTemplate(name):
    """Return the ResidueTemplate of an amino acid: N at the origin, CA and C in standard geometry.

    Amino acids at pH 7 come from the package's table, others from the chemical component dictionary.

    Raises
    ------
    InputError
        if the residue is unknown or no amino acid
    """
    own = aminoAcid(name)
    kind = name if name in _table() else own
    if kind in _table():
        names, elements, positions = _table()[kind]
    else:
        names, elements, positions = _ofDictionary(name)
    mirrored = isMirrored(name)
    if mirrored and kind == own and kind != name:
        positions = positions * [1, 1, -1]
    if not set(PEPTIDE_BACKBONE).issubset(names):
        raise InputError(f"{name} cannot be built: it has no atoms N, CA and C")
    bonds = tuple(templateBonds(kind if kind in _table() else name, list(names)))
    return ResidueTemplate(names, elements, _withStandardBackbone(names, positions), bonds, mirrored)


def _withStandardBackbone(names, positions):
    """Move N, CA and C to their standard places, and other atoms with the frame of CA."""
    n, ca, c = (positions[names.index(name)] for name in PEPTIDE_BACKBONE)
    ideal = np.array([[0, 0, 0], [N_CA, 0, 0], [N_CA - CA_C * np.cos(N_CA_C), CA_C * np.sin(N_CA_C), 0]])
    moved = ideal[1] + (positions - ca) @ _frameOf(n, ca, c) @ _frameOf(*ideal).T
    for name, place in zip(PEPTIDE_BACKBONE, ideal, strict=True):
        moved[names.index(name)] = place
    return moved


def _frameOf(n, ca, c):
    """Return axes as columns: the first between N and C as seen from CA, the last normal to their plane."""
    toN, toC = (n - ca) / np.linalg.norm(n - ca), (c - ca) / np.linalg.norm(c - ca)
    first, last = toN + toC, np.cross(toN, toC)
    first, last = first / np.linalg.norm(first), last / np.linalg.norm(last)
    return np.column_stack([first, np.cross(last, first), last])


@cache
def _table():
    rows = {}
    for residue, atom, element, *place in readTable("aminoacids.csv"):
        rows.setdefault(residue, []).append((atom, element, [float(x) for x in place]))
    return {residue: _columns(atoms) for residue, atoms in rows.items()}


def _columns(atoms):
    names, elements, positions = zip(*atoms, strict=True)
    return names, elements, np.array(positions)


@cache
def _ofDictionary(name):
    info = importExtra("biotite.structure.info", f"building {name}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of atoms without ideal coordinates
            found = info.residue(name)
    except KeyError:
        raise InputError(f"{name} cannot be built: the chemical component dictionary does not have it") from None
    if not np.isfinite(found.coord).all():
        raise InputError(f"{name} cannot be built: the chemical component dictionary lacks places of its atoms")
    left = set(_OF_FREE_ENDS)
    heavyOnN = [
        other
        for bond in info.bonds_in_residue(name)
        if "N" in bond
        for other in bond
        if other not in ("N", "CA") and not other.startswith("H")
    ]
    if heavyOnN:
        left.add("H")
    places = (0.1 * found.coord.astype(float)).tolist()
    atoms = zip(found.atom_name.tolist(), found.element.tolist(), places, strict=True)
    return _columns([(atom, element.capitalize(), place) for atom, element, place in atoms if atom not in left])
