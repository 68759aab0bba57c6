"""Reading structures: one model or all of a file, and what of them is worth looking at."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import openmm.app
from openmm import unit

from .bondsearch import BondSearch, boxOf
from .errors import InputError
from .filebonds import bondsOfFile
from .images import reducedBox
from .modeltopology import makeTopology
from .naming import describeResidue, nameAtom
from .notes import Note, found, listFirst
from .pseudoatoms import isMark, isPseudoAtom
from .residues import aminoAcid, isNucleotide, isWater
from .structurefile import readFile

_NOTHING = "nothing but water and ions"

_MOST_COORDINATE = 1e15  # nm, as in the engine


class Models(NamedTuple):
    """What a structure file holds.

    topology : openmm.app.Topology
        of the first of the models, with the bonds that the file tells
    positions : list of (n, 3) float64 arrays, nm; those of the models up to a damaged one, at least one
    damage : InputError, or None if all models are sound
    alternates : list of str
        for each atom the label of its conformer, empty where there is but one
    notes : list of Note
    """

    topology: openmm.app.Topology
    positions: list[np.ndarray]
    damage: InputError | None
    alternates: list[str]
    notes: list[Note]


class Structure(NamedTuple):
    """Molecules without water and loose ions.

    name : str, for output files; topology : openmm.app.Topology, with all bonds; positions : (n, 3) float64 array, nm;
    alternates : list of str, for each atom the label of its conformer; notes : list of Note, on what was read
    box : (3, 3) float64 array, nm, a vector a row, or None: of the file, for the note on images alone
    """

    name: str
    topology: openmm.app.Topology
    positions: np.ndarray
    alternates: list[str] = []
    notes: list[Note] = []
    box: np.ndarray | None = None


class Solute(NamedTuple):
    """A part of the atoms of a Topology.

    topology : openmm.app.Topology, of that part, with all bonds; positions : (m, 3) float64 array, nm, with molecules
    made whole; atoms : (m,) int array, where each of its atoms was; notes : list of Note
    """

    topology: openmm.app.Topology
    positions: np.ndarray
    atoms: np.ndarray
    notes: list[Note]


def villinPath():
    """Return the path of the villin headpiece in water that OpenMM's own package carries."""
    return Path(openmm.app.__file__).parent / "data" / "test.pdb"


def readStructure(path=None, model=0):
    """Read one model of a structure file, one conformer of each residue, without water and loose ions.

    Parameters
    ----------
    path : str or Path, optional
        a PDB, mmCIF or BinaryCIF file, plain or compressed by gzip; default: the villin headpiece of OpenMM's package
    model : int
        which model, from 0

    Raises
    ------
    InputError
        if the file cannot be read, holds nothing to work on, or holds a molecule in pieces that cannot be made whole
    """
    name = "villin" if path is None else Path(Path(path).name.removesuffix(".gz")).stem
    path = villinPath() if path is None else Path(path)
    models = readModels(path, model)
    solute = selectSolute(path, models.topology, models.positions[0])
    box = boxOf(solute.topology)
    solute.topology.setPeriodicBoxVectors(None)
    alternates = [models.alternates[atom] for atom in solute.atoms]
    return Structure(name, solute.topology, solute.positions, alternates, [*models.notes, *solute.notes], box)


def readModels(path, only=None):
    """Read all models of a structure file, or one, with one conformer of each residue.

    Parameters
    ----------
    path : str or Path
    only : int, optional
        the number of the one model to read, from 0; others may then be of any size, or damaged

    Raises
    ------
    InputError
        if the file cannot be read, or its first model, or the one asked for
    """
    path = Path(path)
    structure, damage = readFile(path)
    first = only or 0
    if first >= len(structure):
        raise damage or InputError(f"{path}: there is no model {first} (from 0), but {len(structure)} in all")
    made = makeTopology(structure[first])
    atoms = list(made.topology.atoms())
    for atom1, atom2 in bondsOfFile(structure, made):
        made.topology.addBond(atoms[atom1], atoms[atom2])
    box = _boxOf(structure.cell)
    if box is not None:
        made.topology.setPeriodicBoxVectors([openmm.Vec3(*vector) for vector in box] * unit.nanometer)
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
    return Models(made.topology, positions, damage if only is None else None, made.alternates, made.notes)


def _boxOf(cell):
    """Return the box of a gemmi.UnitCell in OpenMM's reduced form, or None if it has none that OpenMM can express."""
    box = 0.1 * np.array(cell.orth.mat.tolist()).T
    if not cell.is_crystal() or cell.explicit_matrices or not np.isfinite(box).all() or np.diag(box).min() <= 0:
        return None
    return reducedBox(box)


def _positionsOf(source, made, other):
    """Return the positions of a model, if it has the atoms of the one that was made a Topology."""
    if other is not made:
        if len(other.atoms) != len(made.atoms):
            raise InputError(f"{source} has {len(other.atoms)} atoms, but model 0 has {len(made.atoms)}")
        for atom, expected in zip(other.topology.atoms(), made.topology.atoms(), strict=True):
            if (atom.name, atom.residue.name) != (expected.name, expected.residue.name):
                raise InputError(f"{source} has atom {nameAtom(atom)} where model 0 has {nameAtom(expected)}")
    checkPositions(other.positions, other.topology, source)
    return other.positions


def checkPositions(positions, topology, source):
    """Raise an InputError that names the first atom with a coordinate that is none, and the source."""
    arePossible = np.abs(positions) <= _MOST_COORDINATE
    if not arePossible.all():
        bad = np.flatnonzero(~arePossible.all(axis=1))[0]
        atom = next(atom for atom in topology.atoms() if atom.index == bad)
        reason = (
            f"beyond {_MOST_COORDINATE:g} nm" if np.isfinite(positions[bad]).all() else "that is not a finite number"
        )
        raise InputError(f"{source}: atom {_describe(atom)} has a coordinate {reason}")


def selectSolute(source, topology, positions, water=False, ions=False):
    """Select the atoms of a Topology that are neither water nor loose ions nor pseudo-atoms, and find their bonds.

    Loose ions are residues of a single atom, other than amino acids and nucleotides, that nothing binds.

    Parameters
    ----------
    source : str or Path
        where the Topology is from, for messages
    topology : openmm.app.Topology
    positions : (n, 3) float64 array, nm
    water, ions : bool
        select these as well

    Raises
    ------
    InputError
        if nothing is left, or an atom has no element, or a molecule is in pieces that cannot be made whole
    """
    kept, extra, marks, strange = [], [], {}, []
    waters = {residue for residue in topology.residues() if isWater(residue)}
    for atom in topology.atoms():
        if atom.residue in waters and not water:
            continue
        if isMark(atom.residue):
            marks[atom.residue] = None
        elif isPseudoAtom(atom) or (atom.element is None and len(atom.residue) == 1):
            extra.append(_describe(atom))
        elif atom.element is None:
            strange.append(_describe(atom))
        else:
            kept.append(atom)
    if strange:
        remedy = "give elements in columns 77 and 78 (type_symbol of mmCIF), or remove what is no atom from the file"
        raise InputError(f"{source}: {Note('atoms whose element is not known', strange)}: {remedy}")
    if not kept:
        raise InputError(f"{source}: {_NOTHING}")
    atoms = np.array([atom.index for atom in kept], dtype=int)
    dry = subset(topology, kept)
    try:
        search = BondSearch(dry, positions[atoms])
    except InputError as error:
        raise InputError(f"{source}: {error}") from error
    if search.coinciding:
        pairs = [search.describePair(pair) for pair in search.coinciding]
        raise InputError(f"{source}: bonded atoms are at one place ({listFirst(pairs, '; ')})")
    if search.overlong:
        raise tornError(source, [search.describePair(pair) for pair in search.overlong], search.hasBox)
    loose = [] if ions else _looseIons(dry, search.bonds)
    if len(loose) == len(atoms):
        raise InputError(f"{source}: {_NOTHING}")
    notes = found(
        [
            *search.notes,
            Note("ions left out, since nothing binds them", map(describeResidue, loose)),
            Note("dummy atoms left out, which mark planes, axes and places", map(describeResidue, marks)),
            Note("atoms without an element left out, such as virtual sites and lone pairs", extra),
            _noteWhole(dry, search, positions[atoms]),
        ]
    )
    left = set(loose)
    stays = np.array([atom.residue not in left for atom in dry.atoms()])
    whole = subset(dry, [atom for atom in dry.atoms() if atom.residue not in left], search.bonds)
    return Solute(whole, search.positions[stays], atoms[stays], notes)


def _looseIons(topology, bonds):
    bound = {atom for bond in bonds for atom in bond}
    return [
        residue
        for residue in topology.residues()
        if len(residue) == 1
        and next(residue.atoms()).index not in bound
        and not isWater(residue)
        and aminoAcid(residue.name) is None
        and not isNucleotide(residue.name)
    ]


def tornError(source, pairs, hasBox):
    """Return the InputError that tells of bonded atoms that are far apart: the first of some pairs, in words."""
    remedy = "" if hasBox else "; a molecule split over a periodic box is made whole if the file has the box"
    return InputError(f"{source}: bonded atoms are far apart ({listFirst(pairs, '; ')}){remedy}")


def _noteWhole(topology, search, positions):
    moved = (search.positions != positions).any(axis=1)
    chains = dict.fromkeys(atom.residue.chain for atom, isMoved in zip(topology.atoms(), moved, strict=True) if isMoved)
    names = [f"chain {chain.id}" if chain.id.strip() else f"chain number {chain.index + 1}" for chain in chains]
    return Note("molecules split over the periodic box, and made whole", names)


def withoutAtoms(structure, atoms):
    """Return a Structure without some of its atoms, an int array."""
    left = set(atoms.tolist())
    kept = [atom for atom in structure.topology.atoms() if atom.index not in left]
    if not kept:
        raise InputError("nothing is left")
    indices = [atom.index for atom in kept]
    return structure._replace(
        topology=subset(structure.topology, kept),
        positions=structure.positions[indices],
        alternates=[structure.alternates[index] for index in indices] if structure.alternates else [],
    )


def subset(topology, atoms, bonds=None):
    """Return a Topology of some of the atoms, in their order, with their bonds or those given as indices."""
    part = openmm.app.Topology()
    part.setPeriodicBoxVectors(topology.getPeriodicBoxVectors())
    chain = residue = newChain = newResidue = None
    copies = {}
    for atom in atoms:
        if atom.residue.chain is not chain:
            chain = atom.residue.chain
            newChain = part.addChain(chain.id)
        if atom.residue is not residue:
            residue = atom.residue
            newResidue = part.addResidue(residue.name, newChain, residue.id, residue.insertionCode)
        copies[atom.index] = part.addAtom(atom.name, atom.element, newResidue, atom.id)
    if bonds is None:
        bonds = [(bond[0].index, bond[1].index) for bond in topology.bonds()]
    for first, second in bonds:
        if first in copies and second in copies:
            part.addBond(copies[first], copies[second])
    return part


def _describe(atom):
    return f"{atom.name} of {describeResidue(atom.residue)}"
