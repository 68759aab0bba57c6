"""Structures with the hydrogens that the program Reduce gives them."""

from typing import NamedTuple

import numpy as np
from openmm import app

from ..residues import aminoAcid, isCalledWater
from .choices import flipChoices, histidineChoice
from .contactatoms import ACCEPTOR, contactAtoms
from .hydrogens import isPlaced, placeHydrogens
from .rotors import optimizeRotors

# Atoms that hydroxyls point at as at acceptors, since the side chain could be flipped.
_FLIPPING = {"ASN": ("ND2",), "GLN": ("NE2",), "HIS": ("CD2", "CE1", "ND1", "NE2")}


class Protonated(NamedTuple):
    """A structure with hydrogens.

    topology : openmm.app.Topology, the hydrogens of each residue after its other atoms; their bonds are not listed
    positions : (n, 3) float64 array, nm
    origins : (n,) int array, the particle of the given Topology that each atom is, -1 for an added hydrogen
    bearers : (n,) int array, the same, but for an added hydrogen the particle that bears it
    flipped : list of int, the residues whose side chains were flipped, by index
    """

    topology: app.Topology
    positions: np.ndarray
    origins: np.ndarray
    bearers: np.ndarray
    flipped: list[int] = []


def withHydrogens(topology, positions, areClashesBonds=True, flips=False):
    """Return a structure with the hydrogens of Reduce, as Protonated.

    topology : openmm.app.Topology; positions : (n, 3) float64 array, nm; areClashesBonds : as in placeHydrogens
    flips : bool, exchange O and N of Asn and Gln, and the sides of His, where hydrogens fit clearly better

    Amino acids, nucleotides and hemes get hydrogens in place of those that they have. Water gets none, and other
    residues keep theirs.
    """
    kept = np.array([atom.index for atom in topology.atoms() if not _isReplaced(atom)], dtype=int)
    bare = topology if len(kept) == topology.getNumAtoms() else _build(topology, kept, [], kept[:0])[0]
    placed = placeHydrogens(bare, positions[kept], areClashesBonds)
    whole, order = _build(topology, kept, placed.names, kept[placed.parents])
    index = np.empty(len(order), dtype=int)
    index[order] = np.arange(len(order))
    bearing, hydrogens = index[: len(kept)], index[len(kept) :]
    rotors = [
        rotor._replace(axis=bearing[list(rotor.axis)].tolist(), hydrogens=hydrogens[rotor.hydrogens].tolist())
        for rotor in placed.rotors
    ]
    places = np.concatenate([positions[kept], placed.positions])[order]
    atoms = contactAtoms(whole, places)
    mayAccept = (atoms.flags & ACCEPTOR > 0) | np.array([_mayFlip(atom) for atom in whole.atoms()], dtype=bool)
    flipping = flipChoices(whole, atoms, places) if flips else {}
    choices = list(flipping.values())
    for pair in placed.histidines:
        pair = hydrogens[list(pair)].tolist()
        if atoms.residues[pair[0]] not in flipping:
            choices.append(histidineChoice(atoms, pair))
    states = optimizeRotors(atoms, places, rotors, choices, mayAccept)
    absent = [atom for choice, state in zip(choices, states, strict=True) for atom in choice.absent[state]]
    flipped = [
        residue for residue, state in zip(flipping, states, strict=False) if flipping[residue].penalties[state] > 0
    ]
    origins = np.concatenate([kept, np.full(len(placed.names), -1)])[order]
    bearers = np.concatenate([kept, kept[placed.parents]])[order]
    if absent:
        rest = np.setdiff1d(np.arange(len(order)), absent)
        whole, _ = _build(whole, rest, [], rest[:0])
        places, origins, bearers = places[rest], origins[rest], bearers[rest]
    return Protonated(whole, places, origins, bearers, flipped)


def _isReplaced(atom):
    return atom.element is app.element.hydrogen and (isPlaced(atom.residue.name) or isCalledWater(atom.residue.name))


def _mayFlip(atom):
    return atom.name in _FLIPPING.get(aminoAcid(atom.residue.name), ())


def _build(topology, kept, names, bearers):
    """Return a Topology of some atoms and of hydrogens on them, and the order of both in it.

    kept : (n,) int array, ascending; names : list of str, of the hydrogens; bearers : (m,) int array, atoms that are
    kept. In the order that is returned, a number below n is one of `kept`, and n + i is hydrogen i.
    """
    isKept = np.zeros(topology.getNumAtoms(), dtype=bool)
    isKept[kept] = True
    numbers = np.cumsum(isKept) - 1
    onAtom: dict[int, list[int]] = {}
    for hydrogen, bearer in enumerate(bearers.tolist()):
        onAtom.setdefault(bearer, []).append(hydrogen)
    built, order, copies = app.Topology(), [], {}
    built.setPeriodicBoxVectors(topology.getPeriodicBoxVectors())
    for chain in topology.chains():
        newChain = built.addChain(chain.id)
        for residue in chain.residues():
            own = [atom for atom in residue.atoms() if isKept[atom.index]]
            if not own:
                continue
            newResidue = built.addResidue(residue.name, newChain, residue.id, residue.insertionCode)
            for atom in own:
                copies[atom.index] = built.addAtom(atom.name, atom.element, newResidue, atom.id)
                order.append(numbers[atom.index])
            for atom in own:
                for hydrogen in onAtom.get(atom.index, ()):
                    built.addAtom(names[hydrogen], app.element.hydrogen, newResidue)
                    order.append(len(kept) + hydrogen)
    for bond in topology.bonds():
        if isKept[bond[0].index] and isKept[bond[1].index]:
            built.addBond(copies[bond[0].index], copies[bond[1].index], bond.type, bond.order)
    return built, np.array(order, dtype=int)
