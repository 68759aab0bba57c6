"""What the program Probe knows of the atoms of a Topology: radii, hydrogen bonds, charges and bonds.

Source: Probe 2.26 (atomprops.h, select.c); J. M. Word et al., J. Mol. Biol. 285, 1711-1733 (1999).
"""

from functools import cache
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ..datatables import readTable
from ..residues import aminoAcid, isCalledWater, nucleotide

# Bits of ContactAtoms.flags.
HYDROGEN, DONOR, ACCEPTOR, POSITIVE, NEGATIVE, WATER, AROMATIC, DUMMY, ABSENT, METAL = (1 << bit for bit in range(10))

# Radii, nm: carbon of C=O, aromatic carbon, hydrogen on an aromatic carbon or on N, O or S.
_CARBONYL, _AROMATIC, _SMALL_HYDROGEN = 0.165, 0.175, 0.105

# Two atoms are bonded if they are nearer than the sum of their covalent radii and this, nm ...
_LONG = 0.02
# ... and farther than that sum less this.
_SHORT = 0.06

# Atoms of lower occupancies do not count.
LEAST_OCCUPANCY = 0.02

# Residues that count as amino acids beside the twenty and MSE.
_OTHER_AMINO_ACIDS = {"ACE", "FOR", "NH2", "NME", "AIB", "ABU", "PCA"}

_CARBONYLS = {"ASP": "CG", "ASN": "CG", "GLU": "CD", "GLN": "CD"}
_RINGS = {
    "PHE": "CG CD1 CD2 CE1 CE2 CZ", "TYR": "CG CD1 CD2 CE1 CE2 CZ", "HIS": "CG ND1 CD2 CE1 NE2",
    "TRP": "CG CD1 NE1 CD2 CE2 CE3 CZ2 CZ3 CH2",
    "HEM": " ".join(f"C{number}{ring}" for ring in "ABCD" for number in "1234"),
}  # fmt: skip
# Rings whose faces accept hydrogen bonds.
_FACES = {"TRP": "CD2 CE2 CE3 CZ2 CZ3 CH2"} | {name: _RINGS[name] for name in ("PHE", "TYR", "HEM")}
_PURINE, _PYRIMIDINE = "N1 C2 N3 C4 C5 C6 N7 C8 N9", "N1 C2 N3 C4 C5 C6"
_NOT_ACCEPTING = {
    "LYS": "NZ", "ARG": "NE NH1 NH2", "ASN": "ND2", "GLN": "NE2", "TRP": "NE1", "A": "N6", "C": "N4", "G": "N2",
}  # fmt: skip
_CHARGED = {
    "ASP": ("OD1 OD2", NEGATIVE), "GLU": ("OE1 OE2", NEGATIVE), "LYS": ("NZ", POSITIVE),
    "ARG": ("NE NH1 NH2", POSITIVE), "HEM": ("O1A O2A O1D O2D", NEGATIVE),
}  # fmt: skip
_HALOGENS = {9, 17, 35, 53}
_H, _C, _N, _O, _S = 1, 6, 7, 8, 16


class ContactAtoms(NamedTuple):
    """The atoms of a Topology as Probe sees them.

    radii, covalent : (n,) float64 array, nm; 0 for extra particles
    flags : (n,) int array, of the bits above; a hydrogen that N, O or S bears is the donor, not the atom that bears it
    residues : (n,) int array, the index of the residue
    parents : (n,) int array, for a hydrogen the atom that bears it, else -1
    bonds : (n + 1,), (m,) int arrays: the atoms bonded to atom i are bonds[1][bonds[0][i] : bonds[0][i + 1]]
    """

    radii: np.ndarray
    covalent: np.ndarray
    flags: np.ndarray
    residues: np.ndarray
    parents: np.ndarray
    bonds: tuple[np.ndarray, np.ndarray]


def contactAtoms(topology, positions, occupancies=None):
    """Return the ContactAtoms of a Topology at given positions, (n, 3) in nm.

    occupancies : (n,) array, optional; atoms of an occupancy below 0.02 clash with nothing

    Bonds are found by distance, as Probe finds them: between heavy atoms anywhere, and between a hydrogen and the
    nearest heavy atom of its residue.
    """
    numbers = np.array([_numberOf(atom) for atom in topology.atoms()], dtype=int)
    residues = np.array([atom.residue.index for atom in topology.atoms()], dtype=int)
    radii, covalent, flags = atomKinds(topology)
    pairs = _bondedPairs(positions, covalent, flags, residues)
    parents = _parents(positions, pairs, numbers, residues)
    pairs = pairs[(parents[pairs[:, 0]] < 0) | (parents[pairs[:, 0]] == pairs[:, 1])]
    pairs = pairs[(parents[pairs[:, 1]] < 0) | (parents[pairs[:, 1]] == pairs[:, 0])]
    _describeHydrogens(radii, flags, parents, numbers)
    _chargeHistidines(topology, flags, parents)
    _chargeEnds(topology, flags)
    if occupancies is not None:
        flags[np.abs(occupancies) < LEAST_OCCUPANCY] |= ABSENT
    return ContactAtoms(radii, covalent, flags, residues, parents, _asLists(len(numbers), pairs))


def atomKinds(topology):
    """Return the radii, covalent radii (nm) and flags of atoms, as in ContactAtoms; of hydrogens without neighbors."""
    rows = [_kindOf(atom.residue.name, atom.name, _numberOf(atom)) for atom in topology.atoms()]
    table = np.array(rows, dtype=float).reshape(-1, 3)
    return table[:, 0].copy(), table[:, 1].copy(), table[:, 2].astype(int)


def countedAtoms(atoms):
    """Return the number of atoms, with hydrogens and without water, per thousand of which clashes are counted."""
    return int(((atoms.radii > 0) & (atoms.flags & (WATER | ABSENT) == 0)).sum())


@cache
def _elements():
    return {
        int(number): (float(radius), float(covalent), isMetal == "1")
        for number, _, radius, covalent, isMetal in readTable("contactradii.csv")
    }


@cache
def _namesOf(names):
    return frozenset(names.split())


@cache
def _residueOf(name):
    """Return the name that tables have for a residue, and what it is: "amino acid", "nucleotide", "water" or ""."""
    amino = aminoAcid(name)
    if amino is not None or name in _OTHER_AMINO_ACIDS:
        return amino or name, "amino acid"
    base = nucleotide(name)
    if base is not None:
        return base.removeprefix("D"), "nucleotide"
    return name, "water" if isCalledWater(name) else ""


def _numberOf(atom):
    return 0 if atom.element is None else atom.element.atomic_number


@cache
def _kindOf(residueName, name, number):
    """Return the radius, the covalent radius and the flags of an atom; what a hydrogen is bonded to comes later."""
    if number == 0:
        return 0.0, 0.0, 0
    residue, kind = _residueOf(residueName)
    radius, covalent, isMetal = _elements().get(number, _elements()[_C])
    flags = 0
    ring = (_PURINE if residue in "AGI" else _PYRIMIDINE) if kind == "nucleotide" else _RINGS.get(residue, "")
    if kind == "water":
        flags |= WATER
    if number == _H:
        return radius, covalent, flags | HYDROGEN
    if name in _namesOf(ring):
        flags |= AROMATIC
        radius = _AROMATIC if number == _C else radius
    if kind == "amino acid" and number == _C and (name == "C" or name == _CARBONYLS.get(residue)):
        radius = _CARBONYL
    if number in (_N, _O, _S) and not (kind == "amino acid" and name in ("N", "NT")):
        flags |= 0 if kind and name in _namesOf(_NOT_ACCEPTING.get(residue, "")) else ACCEPTOR
    if name in _namesOf(ring if kind == "nucleotide" else _FACES.get(residue, "")):
        flags |= ACCEPTOR
    charged, sign = _CHARGED.get(residue, ("", 0))
    if name in _namesOf(charged):
        flags |= sign
    if isMetal:
        flags |= POSITIVE | METAL
    elif number in _HALOGENS and kind == "":
        flags |= NEGATIVE | ACCEPTOR
    if kind == "nucleotide" and name == "P":
        flags |= NEGATIVE
    if kind == "amino acid" and name == "OXT":
        flags |= NEGATIVE
    return radius, covalent, flags


def _bondedPairs(positions, covalent, flags, residues):
    """Return the pairs that are as far apart as bonded atoms, without those that Probe never bonds."""
    isMetal = flags & METAL > 0
    pairs = _pairsWithin(positions, np.flatnonzero(~isMetal & (covalent > 0)), 2 * 0.133 + _LONG)
    if isMetal.any():
        tree = cKDTree(positions)
        metals = np.flatnonzero(isMetal).tolist()
        near = tree.query_ball_point(positions[metals], 0.6)
        more = [pair for metal, others in zip(metals, near, strict=True) for pair in product((metal,), others)]
        pairs = np.concatenate([pairs, np.array(more, dtype=int).reshape(-1, 2)])
        pairs = np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0)
    first, second = pairs.T
    squares = ((positions[first] - positions[second]) ** 2).sum(axis=1)
    sums = covalent[first] + covalent[second]
    areNear = (squares <= (sums + _LONG) ** 2) & (squares > np.maximum(sums - _SHORT, 0) ** 2)
    hydrogens = (flags[first] & HYDROGEN) + (flags[second] & HYDROGEN)
    allowed = (hydrogens == 0) | ((hydrogens == 1) & (residues[first] == residues[second]))
    return pairs[areNear & allowed & (covalent[first] > 0) & (covalent[second] > 0)]


def _pairsWithin(positions, chosen, distance):
    return chosen[cKDTree(positions[chosen]).query_pairs(distance, output_type="ndarray")]


def _parents(positions, pairs, numbers, residues):
    """Return for each hydrogen the nearest heavy atom of its residue that it is bonded to, -1 for other atoms."""
    parents = np.full(len(numbers), -1)
    ends = np.concatenate([pairs, pairs[:, ::-1]])
    ends = ends[numbers[ends[:, 0]] == _H]
    distances = np.linalg.norm(positions[ends[:, 0]] - positions[ends[:, 1]], axis=1)
    farthestFirst = ends[np.argsort(-distances, kind="stable")]
    parents[farthestFirst[:, 0]] = farthestFirst[:, 1]
    return parents


def _describeHydrogens(radii, flags, parents, numbers):
    """Set the radii and flags of hydrogens by the atoms that bear them."""
    hydrogens = np.flatnonzero(parents >= 0)
    bearing = parents[hydrogens]
    isPolar = np.isin(numbers[bearing], (_N, _O, _S))
    isAromatic = (flags[bearing] & AROMATIC > 0) & (numbers[bearing] == _C)
    radii[hydrogens[isPolar | isAromatic]] = _SMALL_HYDROGEN
    flags[hydrogens[isPolar]] |= DONOR
    flags[hydrogens] |= flags[bearing] & POSITIVE


def _chargeHistidines(topology, flags, parents):
    """Make histidines with a hydrogen on both nitrogens positive; their nitrogens then accept no hydrogen bond."""
    bearing = set(parents[parents >= 0].tolist())
    for residue in topology.residues():
        if aminoAcid(residue.name) != "HIS":
            continue
        atoms = {atom.name: atom.index for atom in residue.atoms()}
        nitrogens = [atoms[name] for name in ("ND1", "NE2") if name in atoms]
        if len(nitrogens) == 2 and bearing.issuperset(nitrogens):
            ring = [atoms[name] for name in _RINGS["HIS"].split() if name in atoms]
            flags[ring] = flags[ring] & ~ACCEPTOR | POSITIVE
            polar = np.flatnonzero(np.isin(parents, nitrogens))
            flags[polar] |= POSITIVE


def _chargeEnds(topology, flags):
    """Make the oxygen O of a chain's end negative, as OXT is."""
    for chain in topology.chains():
        for residue in chain.residues():
            atoms = {atom.name: atom.index for atom in residue.atoms()}
            if "OXT" in atoms and "O" in atoms and _residueOf(residue.name)[1] == "amino acid":
                flags[atoms["O"]] |= NEGATIVE


def _asLists(count, pairs):
    """Return the neighbors of each atom as two arrays: where those of an atom begin, and all of them."""
    ends = np.concatenate([pairs, pairs[:, ::-1]]).reshape(-1, 2)
    ends = ends[np.argsort(ends[:, 0], kind="stable")]
    return np.searchsorted(ends[:, 0], np.arange(count + 1)), ends[:, 1]
