"""The solute of a model: its molecules without water, loose ions and pseudo-atoms."""

from typing import NamedTuple

import numpy as np
from openmm import app

from .bondsearch import BondSearch
from .errors import InputError
from .naming import describeAtom, describeResidue
from .notes import Note, found, listFirst
from .pseudoatoms import isMark, isPseudoAtom
from .residues import aminoAcid, isNucleotide, isWater

_NOTHING = "nothing but water and ions"


class Solute(NamedTuple):
    """A part of the atoms of a Topology.

    topology : openmm.app.Topology, of that part, with all bonds; positions : (m, 3) float64 array, nm, with whole
    molecules; atoms : (m,) int array, the index of each atom in the original Topology; notes : list of Note
    """

    topology: app.Topology
    positions: np.ndarray
    atoms: np.ndarray
    notes: list[Note]


def selectSolute(source, topology, positions, water=False, ions=False):
    """Select the atoms of a Topology that are neither water nor loose ions nor pseudo-atoms, and find their bonds.

    Loose ions are residues of a single atom, other than amino acids and nucleotides, that nothing binds.

    Parameters
    ----------
    source : str or Path
        names the Topology in messages
    topology : openmm.app.Topology
    positions : (n, 3) float64 array, nm
    water, ions : bool
        select water, and loose ions, too

    Raises
    ------
    InputError
        if nothing remains, an atom has no element, or a molecule is in pieces that cannot be made whole
    """
    kept, extra, marks, strange = [], [], {}, []
    waters = {residue for residue in topology.residues() if isWater(residue)}
    for atom in topology.atoms():
        if atom.residue in waters and not water:
            continue
        if isMark(atom.residue):
            marks[atom.residue] = None
        elif isPseudoAtom(atom) or (atom.element is None and len(atom.residue) == 1):
            extra.append(describeAtom(atom))
        elif atom.element is None:
            strange.append(describeAtom(atom))
        else:
            kept.append(atom)
    if strange:
        remedy = "give elements in columns 77 and 78 (type_symbol of mmCIF), or remove what is not an atom"
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
    """Return an InputError on bonded atoms that are far apart, which names the first of some pairs, given in words."""
    remedy = "" if hasBox else "; a molecule split over a periodic box is made whole if the file has the box"
    return InputError(f"{source}: bonded atoms are far apart ({listFirst(pairs, '; ')}){remedy}")


def _noteWhole(topology, search, positions):
    moved = (search.positions != positions).any(axis=1)
    chains = dict.fromkeys(atom.residue.chain for atom, isMoved in zip(topology.atoms(), moved, strict=True) if isMoved)
    names = [f"chain {chain.id}" if chain.id.strip() else f"chain number {chain.index + 1}" for chain in chains]
    return Note("molecules split over the periodic box, and made whole", names)


def subset(topology, atoms, bonds=None):
    """Return a Topology of some of the atoms, in their order, with their bonds or with bonds given as indices.

    Bonds of the Topology keep their types and orders.
    """
    part = app.Topology()
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
    known = [bond for bond in topology.bonds() if bond.type is not None or bond.order is not None]
    orders = {tuple(sorted((bond[0].index, bond[1].index))): (bond.type, bond.order) for bond in known}
    if bonds is None:
        bonds = [(bond[0].index, bond[1].index) for bond in topology.bonds()]
    for first, second in bonds:
        if first in copies and second in copies:
            order = orders.get(tuple(sorted((first, second))), (None, None))
            part.addBond(copies[first], copies[second], *order)
    return part
