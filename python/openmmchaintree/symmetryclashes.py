"""Clashes of molecules with their copies in a crystal."""

import numpy as np
from openmm import app, unit

from .bondsearch import BondSearch
from .contexts import contextOf
from .errors import InputError
from .notes import Note, found
from .openmmchaintree import StericExclusionForce
from .plainspheres import PlainSpheres
from .solute import subset
from .sterics import pairsAcross

# An atom nearer than this (nm) to its own copy is on an axis, and both are one atom. gemmi has the same limit.
_ON_AXIS = 0.08

# If copies of other atoms are at the places of more than this share of the atoms, the file holds what copies make.
_MOST_COINCIDING = 0.25

# Occupancies of alternatives add up to 1, but for their rounding in files.
_ROUNDING = 0.015

# Atoms at most this number of bonds apart do not clash.
_BOND_CUTOFF = 3


class SymmetryClashes:
    """Finds the clashes of atoms with the copies that a Crystal makes of them.

    The engine looks at the atoms and one copy after the other, in a scene that holds both.

    Attributes
    ----------
    notes : list of Note
        bonds with copies, and atoms that do not clash since they are alternatives
    """

    def __init__(self, force, graph, topology, crystal, atoms, names):
        """Take the particles of a StericExclusionForce, and find their bonds with copies.

        Parameters
        ----------
        force : StericExclusionForce
        graph, topology : BondGraph, openmm.app.Topology
            of the particles, with positions
        crystal : structures.crystal.Crystal
        atoms : (n,) int array
            the particles in the arrays of the crystal
        names : list of AtomName

        Raises
        ------
        InputError
            if the file holds more than the asymmetric unit
        """
        self._crystal = crystal
        self._graph, self._topology, self._names = graph, topology, names
        self._count = force.getNumParticles()
        self._reach = PlainSpheres(force).reach
        self._force = _twice(force)
        self._context = contextOf(self._force)
        self._occupancies = crystal.occupancies[atoms]
        place = {atom: number for number, atom in enumerate(atoms.tolist())}
        self._listed = [(place[a], place[b]) for a, b in crystal.bondsWithCopies if a in place and b in place]
        self._excluded, bonds, alternatives, coinciding = {}, [], [], []
        for copy in crystal.copiesNear(graph.positions, self._reach):
            pairs, _ = self._overlapsWith(copy, graph.positions)
            coinciding += self._describe(copy, self._otherAtomsInPlace(copy, pairs))
            bonded = self._bondsWith(copy, pairs)
            bonds += self._describe(copy, bonded)
            self._excluded[copy.operator] = self._keys(self._nearBonds(copy, bonded))
            alternatives += self._describe(copy, pairs[self._areAlternatives(pairs)])
        if len(coinciding) > _MOST_COINCIDING * self._count:
            coinciding = Note("atoms at the place of a copy of another atom", coinciding)
            raise InputError(f"{crystal.path}: {coinciding}: does the file hold more than the asymmetric unit?")
        self.notes = found(
            [
                Note("bonds with copies in the crystal", bonds),
                Note("overlaps with copies that do not count, since both atoms have partial occupancy", alternatives),
            ]
        )

    def find(self, positions):
        """Return the clashes with copies at positions, an (n, 3) float64 array in nm.

        Returns
        -------
        pairs : (m, 2) int array
            the lower index first
        overlaps : (m,) float64 array, nm
        operators : (m,) array of str
            the operations that make the copies of the second atoms
        """
        results = [(np.empty((0, 2), dtype=int), np.empty(0), np.empty(0, dtype=str))]
        for copy in self._crystal.copiesNear(positions, self._reach):
            pairs, overlaps = self._overlapsWith(copy, positions)
            counts = ~self._areAlternatives(pairs) & ~np.isin(self._keys(pairs), self._excluded.get(copy.operator, ()))
            pairs, overlaps = pairs[counts], overlaps[counts]
            operators = np.where(pairs[:, 0] > pairs[:, 1], copy.inverse, copy.operator)
            results.append((np.sort(pairs, axis=1), overlaps, operators))
        return tuple(map(np.concatenate, zip(*results, strict=True)))

    def _overlapsWith(self, copy, positions):
        """Return pairs of an atom and an atom of a Copy that overlap, and by how much; equivalent pairs once."""
        self._context.setPositions(np.concatenate([positions, _placed(copy, positions)]))
        pairs, overlaps = self._force.getClashes(self._context)
        isAcross = (pairs[:, 0] < self._count) & (pairs[:, 1] >= self._count)
        pairs, overlaps = pairs[isAcross] - [0, self._count], overlaps[isAcross]
        if copy.operator == copy.inverse:
            isFirst = pairs[:, 0] <= pairs[:, 1]
            return pairs[isFirst], overlaps[isFirst]
        return pairs, overlaps

    def _otherAtomsInPlace(self, copy, pairs):
        """Return the pairs of different atoms of which the copy puts one where the other is."""
        positions = self._graph.positions
        first, second = pairs[(pairs[:, 0] != pairs[:, 1]) & ~self._areAlternatives(pairs)].T
        isInPlace = np.linalg.norm(_placed(copy, positions[second]) - positions[first], axis=1) < _ON_AXIS
        return np.column_stack([first, second])[isInPlace]

    def _areAlternatives(self, pairs):
        """Return whether the occupancies of both atoms of pairs say that only one of them is there at a time."""
        occupancies = self._occupancies[pairs]
        arePartial = ((0 < occupancies) & (occupancies < 1)).all(axis=1)
        return arePartial & (occupancies.sum(axis=1) <= 1 + _ROUNDING)

    def _bondsWith(self, copy, pairs):
        """Return which of some overlapping pairs are bonds, by the file or by distance."""
        if len(pairs) == 0:
            return pairs
        positions = self._graph.positions, _placed(copy, self._graph.positions)
        parts = [self._residuesAround(column) for column in pairs.T]
        both = app.Modeller(subset(self._topology, parts[0]), positions[0][_indices(parts[0])] * unit.nanometer)
        both.add(subset(self._topology, parts[1]), positions[1][_indices(parts[1])] * unit.nanometer)
        both.topology.setPeriodicBoxVectors(None)
        members = [*_indices(parts[0]), *_indices(parts[1])]
        middle = len(parts[0])
        placed = np.concatenate([places[_indices(part)] for places, part in zip(positions, parts, strict=True)])
        listed = {pair for bond in self._listed for pair in (bond, bond[::-1])}.intersection(map(tuple, pairs.tolist()))
        atoms = list(both.topology.atoms())
        for first, second in listed:
            both.topology.addBond(atoms[members.index(first)], atoms[members.index(second, middle)])
        bonds = [bond for bond in BondSearch(both.topology, placed).bonds if bond[0] < middle <= bond[1]]
        return np.array([[members[first], members[second]] for first, second in bonds], dtype=int).reshape(-1, 2)

    def _residuesAround(self, atoms):
        """Return the atoms of the residues of some atoms, and of the residues bonded to these."""
        members = self._graph.atoms
        residues = {members[atom].residue for atom in atoms.tolist()}
        residues |= {
            members[other].residue
            for residue in residues
            for atom in residue.atoms()
            for other in self._graph.neighbors[atom.index]
        }
        return [atom for atom in members if atom.residue in residues]

    def _nearBonds(self, copy, bonds):
        """Return the pairs that bonds with a copy exclude, and atoms that stay in their places in the copy."""
        positions = self._graph.positions
        (same,) = np.nonzero(np.linalg.norm(_placed(copy, positions) - positions, axis=1) < _ON_AXIS)
        excluded = [
            pair
            for length, joined in ((1, bonds), (0, np.column_stack([same, same])))
            for first, second in joined.tolist()
            for pair in pairsAcross(self._graph.neighbors, first, second, _BOND_CUTOFF, length)
        ]
        pairs = np.array(excluded, dtype=int).reshape(-1, 2)
        return np.sort(pairs, axis=1) if copy.operator == copy.inverse else pairs

    def _keys(self, pairs):
        return pairs[:, 0].astype(np.int64) * self._count + pairs[:, 1]

    def _describe(self, copy, pairs):
        return [f"{self._names[first]} – {self._names[second]} ({copy.operator})" for first, second in pairs.tolist()]


def _placed(copy, positions):
    return positions @ copy.rotation.T + copy.translation


def _indices(atoms):
    return [atom.index for atom in atoms]


def _twice(force):
    """Return a StericExclusionForce of the particles of another one, with their bonds, and of a copy of these."""
    both = StericExclusionForce()
    both.setOverlapTolerance(force.getOverlapTolerance())
    both.setHydrogenBondAllowance(force.getHydrogenBondAllowance())
    count = force.getNumParticles()
    for start in (0, count):
        for particle in range(count):
            both.addParticle(*force.getParticleParameters(particle))
        for bond in range(force.getNumBonds()):
            both.addBond(*(start + particle for particle in force.getBondParticles(bond)))
    both.createExclusionsFromBonds(_BOND_CUTOFF)
    return both
