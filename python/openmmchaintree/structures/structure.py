"""Reading structures: one model of a file or all models, with or without water and loose ions."""

from pathlib import Path
from typing import NamedTuple

import gemmi
import numpy as np
import openmm.app
from openmm import unit

from ..errors import InputError
from ..images import boxOf, reducedBox, vectorsOf
from ..naming import describeAtom, nameAtom
from ..notes import Note
from ..solute import selectSolute, subset
from .filebonds import bondsOfFile
from .modeltopology import makeTopology
from .structurefile import readFile

_MOST_COORDINATE = 1e15  # nm, as in the engine


class Models(NamedTuple):
    """The content of a structure file.

    topology : openmm.app.Topology
        of the first model that was read, with the bonds that the file lists
    positions : list of (n, 3) float64 arrays, nm
        of the models before the first damaged one, at least one
    damage : InputError, or None if no model is damaged
    boxes : list of (3, 3) float64 array in nm, a vector a row, or None
        the periodic boxes of these models
    alternates : list of str
        for each atom the label of its conformer, empty if the atom has one conformer
    notes : list of Note
    file : gemmi.Structure
    atoms : list of gemmi.Atom, of the first model that was read, in the order of the Topology
    """

    topology: openmm.app.Topology
    positions: list[np.ndarray]
    damage: InputError | None
    boxes: list[np.ndarray | None]
    alternates: list[str]
    notes: list[Note]
    file: gemmi.Structure
    atoms: list[gemmi.Atom]


class Structure(NamedTuple):
    """Molecules without water and loose ions.

    name : str, for output files; topology : openmm.app.Topology, with all bonds; positions : (n, 3) float64 array, nm;
    alternates : list of str, for each atom the label of its conformer; notes : list of Note, on the file
    box : (3, 3) float64 array, nm, a vector a row, or None: the periodic box of the file
    spaceGroup : str, as `spaceGroupOf` returns it
    file : gemmi.Structure or None, the whole file; model : int, the number of the model that was read
    """

    name: str
    topology: openmm.app.Topology
    positions: np.ndarray
    alternates: list[str] = []
    notes: list[Note] = []
    box: np.ndarray | None = None
    spaceGroup: str = ""
    file: gemmi.Structure | None = None
    model: int = 0


def villinPath():
    """Return the path of the villin headpiece in water that OpenMM's package contains."""
    return Path(openmm.app.__file__).parent / "data" / "test.pdb"


def readStructure(path=None, model=0):
    """Read one model of a structure file, one conformer of each residue, without water and loose ions.

    Parameters
    ----------
    path : str or Path, optional
        a PDB, mmCIF, BinaryCIF, gro, SDF or Mol2 file, plain or compressed; default: OpenMM's villin headpiece
    model : int
        the number of the model, from 0

    Raises
    ------
    InputError
        if the file cannot be read, holds only water and ions, or holds a molecule in pieces that cannot be made whole
    """
    name = "villin" if path is None else Path(Path(path).name.removesuffix(".gz")).stem
    path = villinPath() if path is None else Path(path)
    models = readModels(path, model)
    solute = selectSolute(path, models.topology, models.positions[0])
    box = boxOf(solute.topology)
    solute.topology.setPeriodicBoxVectors(None)
    alternates = [models.alternates[atom] for atom in solute.atoms]
    notes = [*models.notes, *solute.notes]
    group = spaceGroupOf(models)
    return Structure(name, solute.topology, solute.positions, alternates, notes, box, group, models.file, model)


def readModels(path, only=None):
    """Read all models of a structure file, or one, with one conformer of each residue.

    Parameters
    ----------
    path : str or Path
    only : int, optional
        the number of the only model to read, from 0; other models may then have other atoms, or be damaged

    Raises
    ------
    InputError
        if the file, its first model, or the model `only` cannot be read
    """
    path = Path(path)
    structure, cells, damage = readFile(path)
    first = only or 0
    if first >= len(structure):
        raise damage or InputError(f"{path}: there is no model {first} (from 0), but {len(structure)} in all")
    made = makeTopology(structure[first])
    atoms = list(made.topology.atoms())
    for (atom1, atom2), order in bondsOfFile(structure, made).items():
        made.topology.addBond(atoms[atom1], atoms[atom2], order=order)
    box = _boxOf(cells[first])
    if box is not None:
        made.topology.setPeriodicBoxVectors(vectorsOf(box) * unit.nanometer)
    positions = []
    for number in range(len(structure)) if only is None else [only]:
        source = path if number == 0 else f"{path}: model {number} (from 0)"
        try:
            positions.append(_positionsOf(source, made, made if number == first else makeTopology(structure[number])))
        except InputError as error:
            damage = error
            break
    if not positions:
        raise damage
    boxes = [_boxOf(cell) for cell in cells[first:][: len(positions)]]
    damage = damage if only is None else None
    return Models(made.topology, positions, damage, boxes, made.alternates, made.notes, structure, made.atoms)


def spaceGroupOf(models):
    """Return the name of the space group of Models; empty if unknown, or P 1, in which all copies are images."""
    group = models.file.find_spacegroup()
    return "" if group is None or group.number == 1 else group.xhm()


def _boxOf(cell):
    """Return the box of a gemmi.UnitCell in OpenMM's reduced form, or None if there is no such box."""
    box = 0.1 * np.array(cell.orth.mat.tolist()).T
    if not cell.is_crystal() or cell.explicit_matrices or not np.isfinite(box).all() or np.diag(box).min() <= 0:
        return None
    return reducedBox(box)


def _positionsOf(source, made, other):
    """Return the positions of a model; an InputError, if its atoms differ from those of the model of the Topology."""
    if other is not made:
        if len(other.atoms) != len(made.atoms):
            raise InputError(f"{source} has {len(other.atoms)} atoms, but model 0 has {len(made.atoms)}")
        for atom, expected in zip(other.topology.atoms(), made.topology.atoms(), strict=True):
            if (atom.name, atom.residue.name) != (expected.name, expected.residue.name):
                raise InputError(f"{source} has atom {nameAtom(atom)} where model 0 has {nameAtom(expected)}")
    checkPositions(other.positions, other.topology, source)
    return other.positions


def checkPositions(positions, topology, source):
    """Raise an InputError that names the source and the first atom with an impossible coordinate."""
    arePossible = np.abs(positions) <= _MOST_COORDINATE
    if not arePossible.all():
        bad = np.flatnonzero(~arePossible.all(axis=1))[0]
        atom = next(atom for atom in topology.atoms() if atom.index == bad)
        reason = (
            f"beyond {_MOST_COORDINATE:g} nm" if np.isfinite(positions[bad]).all() else "that is not a finite number"
        )
        raise InputError(f"{source}: atom {describeAtom(atom)} has a coordinate {reason}")


def withoutAtoms(structure, atoms):
    """Return a Structure without some of its atoms, an int array."""
    left = set(atoms.tolist())
    kept = [atom for atom in structure.topology.atoms() if atom.index not in left]
    if not kept:
        raise InputError("no atom remains")
    indices = [atom.index for atom in kept]
    return structure._replace(
        topology=subset(structure.topology, kept),
        positions=structure.positions[indices],
        alternates=[structure.alternates[index] for index in indices] if structure.alternates else [],
    )
