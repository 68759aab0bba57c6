"""The bonds of a Topology as a graph, with or without disulfides and bonds of metals; links and loops of polymers."""

from collections.abc import Iterable
from functools import cached_property
from typing import TypeAlias

from .bondsearch import LINKS, BondSearch
from .graphs import connectedParts, neighborLists
from .shownhydrogens import ShownHydrogens

# Shorter loops have too few torsions for a closed window.
_SHORTEST_LOOP = 3  # residues

DISULFIDES, LOOPS = "disulfides", "loops"  # names of sets of closures
Closures: TypeAlias = str | Iterable[str | tuple[int, int]]


class BondGraph(BondSearch):
    """The bonds of a BondSearch that are not cut, without closures, which are listed apart.

    Attributes
    ----------
    bonds : list of (int, int)
        the bonds, without gaps, cut bonds and closures
    neighbors : list of list of int
        for each atom the atoms that `bonds` bond to it
    disulfides, metalBonds : list of (int, int)
        as in a BondSearch, whether cut or not
    cut : list of (int, int)
        the disulfides and metal bonds that are cut
    closures : list of (int, int, int, int)
        bonds that are not in `bonds`, but that moves keep: each is between the second and third atom; the others are
        neighbors of these
    """

    def __init__(
        self, topology, positions=None, cutDisulfides=False, cutMetals=False, closures=(), fixed=(), others=(), beads=()
    ):
        """Find the bonds of a Topology: its own, by residue templates, and, with positions, by distance.

        Parameters
        ----------
        topology : openmm.app.Topology
        positions : numpy array of shape (n, 3), optional
            nm; with them, bonds between residues are checked for gaps
        cutDisulfides, cutMetals : bool
            leave disulfide bonds, or bonds between metals and other residues, out of `bonds`; cutDisulfides may also
            be a list of pairs, lower index first: the disulfides to leave out, which are no closures
        closures : "disulfides", "loops" or an iterable of these and of (int, int), optional
            bonds that become closures; "disulfides" are the disulfides that close a ring, "loops" the last bond of each
            loop between fixed atoms
        fixed : iterable of int, optional
            the fixed atoms
        others : iterable of (int, int), optional
            bonds that the Topology lacks, lower index first
        beads : set of int, optional
            as in a BondSearch
        """
        if topology.getNumAtoms() == 0:
            raise ValueError("the Topology has no atoms")
        super().__init__(topology, positions, others, beads)
        open_ = cutDisulfides if isinstance(cutDisulfides, list) else []
        closing = self._bondsOf(closures, fixed, open_)
        cut = [*(self.disulfides if cutDisulfides is True else open_), *(self.metalBonds if cutMetals else [])]
        self.cut = [bond for bond in cut if bond not in closing]
        areCut = closing.union(self.cut)
        self.bonds = [bond for bond in self.bonds if bond not in areCut]
        self.neighbors = neighborLists(len(self.atoms), self.bonds)
        self.closures = [(self._neighborOf(a), a, b, self._neighborOf(b)) for a, b in sorted(closing)]

    def _bondsOf(self, closures, fixed, open_):
        """Return the bonds that are to be closures as a set of (lower, higher) index.

        open_ : list of (int, int), disulfides that are no closures
        """
        closing = set()
        known = set(self.bonds)
        for which in (closures,) if isinstance(closures, str) else closures:
            if not isinstance(which, str):
                atom1, atom2 = sorted(map(int, which))
                if (atom1, atom2) not in known:
                    raise ValueError(f"closures names atoms {atom1} and {atom2}, which are not bonded")
                closing.add((atom1, atom2))
            elif which == DISULFIDES:
                closing |= self._disulfidesInRings(open_)
            elif which == LOOPS:
                closing |= loopBonds(self.atoms, self.bonds, fixed)
            else:
                raise ValueError(f'closures must be "disulfides", "loops" or pairs of atoms, not {which!r}')
        return closing

    def _disulfidesInRings(self, open_):
        """Return the disulfides that close a ring; others hold parts together that no other bond joins."""
        closing = set()
        others = set(self.bonds).difference(self.disulfides)
        parts = connectedParts(len(self.atoms), sorted(others))
        for atom1, atom2 in self.disulfides:
            if (atom1, atom2) in open_:
                continue
            if parts[atom1] == parts[atom2]:
                closing.add((atom1, atom2))
            parts[parts == parts[atom2]] = parts[atom1]
        return closing

    def _neighborOf(self, atom):
        """Return an atom that `bonds` bond to an atom at the end of a closure."""
        others = self.heavyNeighborsOf(atom) or self.neighbors[atom]
        if not others:
            raise ValueError(f"closures names atom {atom}, which has no other bond")
        return min(others)

    @cached_property
    def shownHydrogens(self):
        """Which molecules show their hydrogens: a ShownHydrogens."""
        return ShownHydrogens(self)

    def elementNumber(self, atom):
        """Return the atomic number of an atom, 0 for an extra particle."""
        return int(self.numbers[atom])

    def hydrogensOf(self, atom):
        """Return the hydrogens bonded to an atom."""
        return [other for other in self.neighbors[atom] if self.elementNumber(other) == 1]

    def heavyNeighborsOf(self, atom):
        """Return the atoms other than hydrogens bonded to an atom."""
        return [other for other in self.neighbors[atom] if self.elementNumber(other) > 1]

    def beyond(self, atom, other):
        """Return the neighbors of an atom other than a given one; extra particles only if the atom is one, too."""
        areExtra = self.elementNumber(atom) == 0
        return [
            neighbor for neighbor in self.neighbors[atom] if neighbor != other and (areExtra or self.numbers[neighbor])
        ]


def defaultClosures(hasEnergies, cutDisulfides):
    """Return the default closures: disulfides if energies are sampled, unless disulfides are cut."""
    return (DISULFIDES,) if hasEnergies and not cutDisulfides else ()


def polymerLinks(atoms, bonds):
    """Yield the pairs of atoms whose bonds link residues of a polymer, each in the order of the chain.

    Parameters
    ----------
    atoms : list of openmm.app.Atom
    bonds : iterable of (int, int)
    """
    for bond in bonds:
        for atom1, atom2 in (bond, bond[::-1]):
            first, second = atoms[atom1], atoms[atom2]
            if first.residue is not second.residue and (first.name, second.name) in LINKS:
                yield first, second


def loopBonds(atoms, bonds, fixed):
    """Return the last bond of each loop: a row of residues without fixed atoms, between two residues with fixed atoms.

    The whole loop then hangs on one fixed part, so that windows can lie anywhere in it.

    Parameters
    ----------
    atoms : list of openmm.app.Atom
    bonds : iterable of (int, int)
    fixed : iterable of int

    Returns
    -------
    set of (int, int), lower index first
    """
    held = {atoms[atom].residue.index for atom in fixed}
    following = {}  # the residue after a residue, and the bond between them
    for first, second in polymerLinks(atoms, bonds):
        bond = min(first.index, second.index), max(first.index, second.index)
        following[first.residue.index] = second.residue.index, bond
    found = set()
    for start in sorted(held):
        row, residue = [], start
        while residue in following and (residue == start or residue not in held):
            residue, bond = following[residue]
            row.append(bond)
        if residue in held and len(row) > _SHORTEST_LOOP:
            found.add(row[-1])
    return found
