"""PoseBusters' checks of distance and volume between a ligand and the molecules around it.

Source: PoseBusters 0.6 (dock.yml, intermolecular_distance.py, volume_overlap.py); M. Buttenschoen, G. M. Morris and
C. M. Deane, Chem. Sci. 15, 3130-3139 (2024). Radii and volumes are RDKit's.
"""

from typing import NamedTuple

import numpy as np

from ..errors import InputError
from ..extras import importExtra
from ..graphs import connectedParts
from ..naming import describeResidue
from ..residues import isPolymer, isWater

PROTEIN, ORGANIC, INORGANIC, WATERS = "protein", "organic cofactors", "inorganic cofactors", "waters"

# The least distance of two atoms, as a share of the sum of their radii, and the largest share of volume that overlaps.
_LEAST_DISTANCE, _MOST_VOLUME = 0.75, 0.075
# What radii are multiplied by before volumes are compared.
_VOLUME_SCALES = {PROTEIN: 0.8, ORGANIC: 0.8, INORGANIC: 0.5, WATERS: 0.5}
# A ligand's atoms are compared with atoms this near, nm.
_NEAR = 0.6

_INORGANIC_ELEMENTS = {
    "Li", "Be", "Na", "Mg", "Cl", "K", "Ca", "Mn", "Fe", "Co", "Ni", "Cu", "Zn", "Br", "Rb", "Mo", "Cd",
}  # fmt: skip
_INORGANIC_RESIDUES = {"FES", "MOS", "PO3", "PO4", "PPK", "SO3", "SO4", "VO4"}


class PoseCheck(NamedTuple):
    """A ligand beside molecules of a kind.

    ligand : str, its residues; other : str, the kind; leastDistance : float, of heavy atoms as a share of the sum of
    their radii, infinite if none is near; clashCount : int, pairs below 0.75; volumeOverlap : float, the share of the
    ligand's volume inside; passes : bool
    """

    ligand: str
    other: str
    leastDistance: float
    clashCount: int
    volumeOverlap: float
    passes: bool


def checkPoses(topology, positions, areHetero):
    """Return the PoseCheck of each ligand with each kind of molecules around it.

    Parameters
    ----------
    topology : openmm.app.Topology
    positions : (n, 3) float64 array, nm
    areHetero : (n,) bool array
        whether the file calls an atom a heteroatom; others are the protein's

    A ligand is a molecule that is no polymer, no water and not inorganic, and that no bond of the Topology joins to a
    polymer. Heteroatoms of other molecules are organic cofactors.

    Raises
    ------
    InputError
        if RDKit is not installed
    """
    rdkit = importExtra("rdkit.Chem", "the definition posebusters", InputError)
    kinds = _kindsOf(topology, areHetero)
    checks = []
    for atoms, name in _ligandsOf(topology):
        others = np.ones(len(kinds), dtype=bool)
        others[atoms] = False
        for kind in (PROTEIN, ORGANIC, INORGANIC, WATERS):
            around = np.flatnonzero(others & (kinds == kind))
            if len(around):
                checks.append(_check(rdkit, topology, positions, name, atoms, kind, around))
    return checks


def _kindsOf(topology, areHetero):
    """Return the kind of each atom, as an array of str; hydrogens have none."""
    kinds = []
    for atom, isHetero in zip(topology.atoms(), areHetero.tolist(), strict=True):
        symbol = "" if atom.element is None else atom.element.symbol
        if symbol in ("", "H"):
            kinds.append("")
        elif atom.residue.name == "HOH":
            kinds.append(WATERS)
        elif symbol in _INORGANIC_ELEMENTS or atom.residue.name in _INORGANIC_RESIDUES:
            kinds.append(INORGANIC)
        else:
            kinds.append(ORGANIC if isHetero else PROTEIN)
    return np.array(kinds)


def _ligandsOf(topology):
    """Return the atoms and the name of each ligand."""
    residues = list(topology.residues())
    mayBe = np.array([_mayBeLigand(residue) for residue in residues], dtype=bool)
    isBound = np.zeros(len(residues), dtype=bool)
    joined = []
    for bond in topology.bonds():
        first, second = bond[0].residue, bond[1].residue
        if mayBe[first.index] and mayBe[second.index]:
            joined += [(first.index, second.index), (second.index, first.index)]
        elif not (isWater(first) or isWater(second)):
            isBound[[first.index, second.index]] = True
    parts = connectedParts(len(residues), joined)
    bound = set(parts[isBound & mayBe].tolist())
    ligands = []
    for part in dict.fromkeys(parts[mayBe].tolist()):
        if part not in bound:
            own = [residues[index] for index in np.flatnonzero(mayBe & (parts == part))]
            atoms = np.array([atom.index for residue in own for atom in residue.atoms()], dtype=int)
            ligands.append((atoms, ", ".join(map(describeResidue, own))))
    return ligands


def _mayBeLigand(residue):
    elements = {atom.element.symbol for atom in residue.atoms() if atom.element is not None}
    if isPolymer(residue) or isWater(residue) or residue.name in _INORGANIC_RESIDUES:
        return False
    return not elements <= _INORGANIC_ELEMENTS and sum(1 for _ in residue.atoms()) > 1


def _check(rdkit, topology, positions, name, atoms, kind, around):
    symbols = [atom.element.symbol if atom.element is not None else "H" for atom in topology.atoms()]
    table = rdkit.GetPeriodicTable()
    radiusOf = table.GetRcovalent if kind == INORGANIC else table.GetRvdw
    heavy = np.array([atom for atom in atoms if symbols[atom] != "H"], dtype=int)
    radii1 = 0.1 * np.array([radiusOf(symbols[atom]) for atom in heavy])
    radii2 = 0.1 * np.array([radiusOf(symbols[atom]) for atom in around])
    distances = np.linalg.norm(positions[heavy][:, None] - positions[around], axis=2)
    shares = distances / (radii1[:, None] + radii2)
    isNear = distances.min(axis=0, initial=np.inf) <= _NEAR
    shares = shares[:, isNear]
    count = int((shares < _LEAST_DISTANCE).sum())
    volume = _volumeOverlap(rdkit, symbols, positions, atoms, around, _VOLUME_SCALES[kind])
    passes = count == 0 and volume <= _MOST_VOLUME
    return PoseCheck(name, kind, float(shares.min(initial=np.inf)), count, volume, passes)


def _volumeOverlap(rdkit, symbols, positions, atoms, around, scale):
    """Return the share of a ligand's volume that lies in other atoms."""
    shapes = importExtra("rdkit.Chem.rdShapeHelpers", "the definition posebusters", InputError)
    distances = np.linalg.norm(positions[atoms][:, None] - positions[around], axis=2).min(axis=0)
    around = around[distances <= scale * _NEAR]
    if not len(around):
        return 0.0
    ligand, others = (_moleculeOf(rdkit, symbols, positions, chosen) for chosen in (atoms, around))
    return float(shapes.ShapeTverskyIndex(ligand, others, alpha=1, beta=0, vdwScale=scale, ignoreHs=True))


def _moleculeOf(rdkit, symbols, positions, atoms):
    """Return an RDKit molecule of some atoms without bonds."""
    molecule = rdkit.RWMol()
    conformer = rdkit.Conformer(len(atoms))
    for number, atom in enumerate(atoms.tolist()):
        molecule.AddAtom(rdkit.Atom(symbols[atom]))
        conformer.SetAtomPosition(number, (10 * positions[atom]).tolist())
    molecule.AddConformer(conformer)
    return molecule
