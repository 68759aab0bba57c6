"""A Structure with built residues among its own."""

from string import ascii_uppercase

import numpy as np
from openmm import app

_LINK = ("C", "N")


class ChainAssembly:
    """Collects changes of a Structure, and makes the changed one. Atoms that stay keep their order and names."""

    def __init__(self, structure):
        """Begin with a Structure."""
        self._structure = structure
        self._labels = {_labelsOf(residue) for residue in structure.topology.residues()}
        self._before, self._behind, self._added, self._removed = {}, {}, {}, set()

    def insertBefore(self, residue, built, isLinked):
        """Insert BuiltResidues before a residue, bonded to it, and to the residue before if isLinked."""
        self._before[residue] = built, isLinked

    def insertBehind(self, residue, built):
        """Insert BuiltResidues behind a residue, bonded to it: the last one is the end of its chain."""
        self._behind[residue] = built

    def addHydrogen(self, residue, name, neighbor, place):
        """Add a hydrogen to a residue, bonded to its atom named `neighbor`; place : nm."""
        self._added[residue] = name, neighbor, place

    def remove(self, atoms):
        """Leave out atoms of the Topology."""
        self._removed.update(atoms)

    def finish(self, positions):
        """Make the changed Structure from positions (nm) of all atoms of the old one.

        Returns
        -------
        Structure
        (n,) int array
            for each atom its index in the old Structure, −1 for new ones
        list of lists of Residue
            the built residues, one list for each insertion
        """
        self._topology, self._copies = app.Topology(), {}
        self._sources, self._places, parts = [], [], []
        for chain in self._structure.topology.chains():
            self._chain = self._topology.addChain(chain.id)
            number, previous = 0, None  # of the residue before
            for residue in chain.residues():
                if self._removed.issuperset(residue.atoms()):
                    continue
                own = _numberOf(residue)
                if residue in self._before:
                    built, isLinked = self._before[residue]
                    first = number + 1 if isLinked else own - len(built)
                    parts.append(self._insert(built, first, previous if isLinked else None))
                number, previous = own, self._copy(residue)
                if residue in self._before:
                    self._link(parts[-1][-1], previous)
                if residue in self._behind:
                    parts.append(self._insert(self._behind[residue], own + 1, previous))
        return self._wholeOf(positions), np.array(self._sources), parts

    def _copy(self, residue):
        copy = self._topology.addResidue(residue.name, self._chain, residue.id, residue.insertionCode)
        for atom in residue.atoms():
            if atom not in self._removed:
                self._copies[atom] = self._topology.addAtom(atom.name, atom.element, copy, atom.id)
                self._sources.append(atom.index)
                self._places.append(None)
        if residue in self._added:
            name, neighbor, place = self._added[residue]
            hydrogen = self._topology.addAtom(name, app.element.hydrogen, copy)
            self._sources.append(-1)
            self._places.append(place)
            self._topology.addBond(_atomOf(copy, neighbor), hydrogen)
        return copy

    def _insert(self, built, first, previous):
        """Add BuiltResidues numbered from `first`, bonded to the residue before if given; return their Residues."""
        made = []
        for number, residue in enumerate(built, first):
            copy = self._topology.addResidue(residue.name, self._chain, *self._freeLabel(number))
            atoms = []
            for name, element, place in zip(residue.names, residue.elements, residue.positions, strict=True):
                atoms.append(self._topology.addAtom(name, app.Element.getBySymbol(element), copy))
                self._sources.append(-1)
                self._places.append(place)
            for first, second in residue.bonds:
                self._topology.addBond(atoms[first], atoms[second])
            if previous is not None:
                self._link(previous, copy)
            previous = copy
            made.append(copy)
        return made

    def _link(self, first, second):
        self._topology.addBond(_atomOf(first, _LINK[0]), _atomOf(second, _LINK[1]))

    def _freeLabel(self, number):
        """Return a number and an insertion code that no residue of the chain has."""
        label = self._chain.id, str(number), ""
        codes = iter(ascii_uppercase)
        while label in self._labels and (code := next(codes, None)) is not None:
            label = self._chain.id, str(number), code
        self._labels.add(label)
        return label[1:]

    def _wholeOf(self, positions):
        old = self._structure
        for bond in old.topology.bonds():
            if bond[0] in self._copies and bond[1] in self._copies:
                self._topology.addBond(self._copies[bond[0]], self._copies[bond[1]], bond.type, bond.order)
        places = [
            positions[source] if place is None else place
            for source, place in zip(self._sources, self._places, strict=True)
        ]
        alternates = [old.alternates[source] if source >= 0 and old.alternates else "" for source in self._sources]
        return old._replace(topology=self._topology, positions=np.array(places), alternates=alternates)


def _atomOf(residue, name):
    return next(atom for atom in residue.atoms() if atom.name == name)


def _numberOf(residue):
    return int(residue.id) if residue.id.lstrip("-").isdigit() else 0


def _labelsOf(residue):
    return residue.chain.id, residue.id, residue.insertionCode.strip()
