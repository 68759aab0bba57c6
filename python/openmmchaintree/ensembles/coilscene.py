"""What is flexible in a random coil of all atoms, what moves with it as a rigid body, and what stays."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from openmm import app

from ..beadplaces import beadResidues
from ..bonds import polymerLinks
from ..errors import InputError
from ..graphs import connectedParts
from ..naming import describeResidue
from ..solute import selectSolute
from ..units import positionsInNm


class CoilScene(NamedTuple):
    """A structure, of which some residues are flexible.

    topology : openmm.app.Topology; positions : (n, 3) float64 array, nm
    parts : list of lists of Residue, the flexible ones in a row
    isFlexible : (n,) bool array, the atoms of flexible residues; isRigid : (n,) bool array, other atoms that move
    """

    topology: app.Topology
    positions: np.ndarray
    parts: list
    isFlexible: np.ndarray
    isRigid: np.ndarray


def sceneOfBuilt(built):
    """Return the CoilScene of a BuiltStructure: built residues are flexible."""
    return CoilScene(built.topology, built.positions, built.parts, built.isBuilt, built.isMoved)


def sceneOfDomains(source, domains):
    """Return the CoilScene of a structure in which the residues of chains with domains are flexible outside them.

    In each chain the largest domain stays, the others move as rigid bodies. Chains without a domain stay, unless no
    chain has one.

    Parameters
    ----------
    source : object with topology and positions
    domains : iterable of iterables of int
        residues, counted from 0 over all with a Cα atom

    Raises
    ------
    InputError
        if a domain names no residue, nothing is flexible, or a domain that has to move cannot
    """
    positions = positionsInNm(source.positions, source.topology.getNumAtoms())
    solute = selectSolute("structure", source.topology, positions)
    scene = _Domains(solute.topology, solute.positions, domains)
    return CoilScene(solute.topology, solute.positions, scene.parts, scene.isFlexible, scene.isRigid)


class _Domains:
    """Divides a structure by its domains."""

    def __init__(self, topology, positions, domains):
        chains = [[residue for residue, _ in chain] for chain in beadResidues(topology)]
        residues = [residue for chain in chains for residue in chain]
        self._domainOf = {}
        for number, domain in enumerate(domains):
            for index in domain:
                if not 0 <= index < len(residues):
                    raise InputError(f"domains names residue {index}, but there are {len(residues):,} residues")
                self._domainOf[residues[index]] = number
        chosen = [chain for chain in chains if any(residue in self._domainOf for residue in chain)] or chains
        if not self._domainOf and len(chains) > 1:
            raise InputError("several chains need domains, which say what stays in place")
        flexible = [residue for chain in chosen for residue in chain if residue not in self._domainOf]
        if not flexible:
            raise InputError("nothing is flexible: domains hold all residues of their chains")
        count = topology.getNumAtoms()
        self.isFlexible = np.zeros(count, dtype=bool)
        self.isFlexible[[atom.index for residue in flexible for atom in residue.atoms()]] = True
        self._bonds = [(bond[0].index, bond[1].index) for bond in topology.bonds()]
        atoms = list(topology.atoms())
        self._following = {first.residue: second.residue for first, second in polymerLinks(atoms, self._bonds)}
        staying = self._staying(chosen)
        for chain in chosen:
            self._checkLinks(chain, staying)
        self.parts = self._rows(flexible)
        self.isRigid = self._rigid(staying, count)

    def _checkLinks(self, chain, staying):
        """Raise an InputError if there is a gap beside residues that move."""
        for first, second in pairwise(chain):
            moves = any(self._domainOf.get(residue) not in staying for residue in (first, second))
            if moves and self._following.get(first) is not second:
                raise InputError(
                    f"there is a gap between {describeResidue(first)} and {describeResidue(second)}, beside residues "
                    "that would move: build the missing residues first, as ensemble --move-domains does"
                )

    def _rows(self, flexible):
        """Return the flexible residues as lists of residues that follow each other."""
        rows, previous = [], None
        for residue in flexible:
            if previous is None or self._following.get(previous) is not residue:
                rows.append([])
            rows[-1].append(residue)
            previous = residue
        return rows

    def _staying(self, chains):
        """Return the numbers of domains that stay: the largest of each chain."""
        staying = set()
        for chain in chains:
            numbers = [self._domainOf[residue] for residue in chain if residue in self._domainOf]
            if numbers:
                staying.add(max(sorted(set(numbers)), key=numbers.count))
        return staying

    def _rigid(self, staying, count):
        """Return which atoms move as rigid bodies: domains that do not stay, and what flexible residues bear."""
        inside = [bond for bond in self._bonds if not self.isFlexible[list(bond)].any()]
        pieces = connectedParts(count, inside)
        borne = {
            pieces[atom]
            for bond in self._bonds
            for atom, other in (bond, bond[::-1])
            if self.isFlexible[other] and not self.isFlexible[atom]
        }
        held, moving = {}, {}
        for residue, number in self._domainOf.items():
            found = held if number in staying else moving
            found.setdefault(pieces[next(residue.atoms()).index], (number, residue))
        for piece, (number, residue) in moving.items():
            others = [one for one, (each, _) in moving.items() if each == number and one != piece]
            if piece in held:
                raise InputError(
                    f"the domain of {describeResidue(residue)} cannot move: a bond holds it to one that stays"
                )
            if others:
                raise InputError(
                    f"the domain of {describeResidue(residue)} cannot move: it has several segments, which only the "
                    "largest domain of a chain may have"
                )
        rigid = np.isin(pieces, sorted((borne | moving.keys()) - held.keys()))
        return rigid & ~self.isFlexible
