"""The bonds of a Topology as a graph, with or without those of disulfides and metals; rings and molecules of graphs."""

from collections.abc import Iterable
from functools import cached_property
from typing import TypeAlias

from .bondsearch import BondSearch, Gap, polymerLinks
from .components import connectedParts
from .loops import loopBonds
from .shownhydrogens import ShownHydrogens

__all__ = ["BondGraph", "Gap", "molecules", "neighborLists", "polymerLinks", "ringBonds"]

DISULFIDES, LOOPS = "disulfides", "loops"  # names of sets of closures
Closures: TypeAlias = str | Iterable[str | tuple[int, int]]


class BondGraph:
    """The atoms of a Topology and the bonds between them.

    Attributes
    ----------
    atoms : list of openmm.app.Atom
    numbers : (n,) int array
        atomic numbers, 0 for extra particles and pseudo-atoms
    residueOf : (n,) int array
        the index of the residue of each atom
    bonds : list of (int, int)
        the bonds, without gaps, cut bonds and closures
    neighbors : list of list of int
        for each atom the atoms that `bonds` bond to it
    gaps : list of Gap
    disulfides, metalBonds : list of (int, int)
        the bonds between residues that join two sulfurs, or that a metal has, whether cut or not
    cut : list of (int, int)
        the disulfides and metal bonds that are cut
    closures : list of (int, int, int, int)
        bonds that are not in `bonds`, but that moves keep: each is between the second and third atom; the others are
        neighbors of these
    positions : (n, 3) float64 array or None
        the given positions, with molecules made whole that are split over the periodic box of the Topology
    overlong : list of (int, int)
        bonds longer than 0.8 nm, as of a molecule split over a periodic box
    hasTemplate : (n,) bool array
        whether the residue of each atom has a template, so that its bonds are known
    notes : list of Note
        on gaps, bonds that the Topology lacks, and impossible bonds of the Topology
    """

    def __init__(
        self, topology, positions=None, cutDisulfides=False, cutMetals=False, closures=(), fixed=(), others=()
    ):
        """Find the bonds of a Topology: those it has, those of residue templates, and, with positions, by distance.

        Parameters
        ----------
        topology : openmm.app.Topology
        positions : numpy array of shape (n, 3), optional
            nm; with them, bonds between residues are checked for gaps
        cutDisulfides, cutMetals : bool
            leave disulfide bonds, or bonds between metals and other residues, out of `bonds`
        closures : "disulfides", "loops" or an iterable of these and of (int, int), optional
            bonds that become closures; "disulfides" are the disulfides that close a ring, "loops" the last bond of each
            loop between fixed atoms
        fixed : iterable of int, optional
            the fixed atoms
        others : iterable of (int, int), optional
            bonds that the Topology lacks, lower index first
        """
        if topology.getNumAtoms() == 0:
            raise ValueError("the Topology has no atoms")
        search = BondSearch(topology, positions, others)
        self.atoms = list(topology.atoms())
        self.numbers = search.numbers
        self.residueOf = search.residueOf
        self.gaps = search.gaps
        self.disulfides = search.disulfides
        self.metalBonds = search.metalBonds
        self.positions = search.positions
        self.overlong = search.overlong
        self.notes = search.notes
        self.hasTemplate = search.hasTemplate
        self.cut = [*(search.disulfides if cutDisulfides else []), *(search.metalBonds if cutMetals else [])]
        self.describePair = search.describePair
        closing = self._bondsOf(closures, search, fixed)
        self.cut = [bond for bond in self.cut if bond not in closing]
        areCut = closing.union(self.cut)
        self.bonds = [bond for bond in search.bonds if bond not in areCut]
        self.neighbors = neighborLists(len(self.atoms), self.bonds)
        self.closures = [(self._neighborOf(a), a, b, self._neighborOf(b)) for a, b in sorted(closing)]

    def _bondsOf(self, closures, search, fixed):
        """Return the bonds that are to be closures as a set of (lower, higher) index."""
        closing = set()
        known = set(search.bonds)
        for which in (closures,) if isinstance(closures, str) else closures:
            if not isinstance(which, str):
                atom1, atom2 = sorted(map(int, which))
                if (atom1, atom2) not in known:
                    raise ValueError(f"closures names atoms {atom1} and {atom2}, which are not bonded")
                closing.add((atom1, atom2))
            elif which == DISULFIDES:
                closing |= self._disulfidesInRings(search)
            elif which == LOOPS:
                closing |= loopBonds(self.atoms, search.bonds, fixed)
            else:
                raise ValueError(f'closures must be "disulfides", "loops" or pairs of atoms, not {which!r}')
        return closing

    def _disulfidesInRings(self, search):
        """Return the disulfides that close a ring; others hold parts together that no other bond joins."""
        closing = set()
        others = set(search.bonds).difference(search.disulfides)
        parts = connectedParts(len(self.atoms), sorted(others))
        for atom1, atom2 in search.disulfides:
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


def neighborLists(count, bonds):
    """Return, for each of count atoms, the list of atoms bonded to it."""
    neighbors = [[] for _ in range(count)]
    for atom1, atom2 in bonds:
        neighbors[atom1].append(atom2)
        neighbors[atom2].append(atom1)
    return neighbors


def ringBonds(neighbors):
    """Return the bonds that lie in a ring, as a set of (lower, higher) index.

    A depth-first search: a tree edge lies in a ring if a bond leads from below it to above it. O(atoms + bonds).
    """
    count = len(neighbors)
    order = [-1] * count  # when an atom was first met
    reach = [0] * count  # the earliest atom that its subtree reaches by one ring-closing bond
    inRing = set()
    clock = 0
    for start in range(count):
        if order[start] >= 0:
            continue
        order[start] = reach[start] = clock
        clock += 1
        path = [(start, -1, iter(neighbors[start]))]
        while path:
            atom, parent, remaining = path[-1]
            for other in remaining:
                if order[other] < 0:
                    order[other] = reach[other] = clock
                    clock += 1
                    path.append((other, atom, iter(neighbors[other])))
                    break
                if other != parent:
                    reach[atom] = min(reach[atom], order[other])
                    inRing.add((min(atom, other), max(atom, other)))
            else:
                path.pop()
                if parent >= 0:
                    reach[parent] = min(reach[parent], reach[atom])
                    if reach[atom] <= order[parent]:
                        inRing.add((min(atom, parent), max(atom, parent)))
    return inRing


def molecules(neighbors):
    """Return the number of the molecule of each atom, as a list: connected atoms share one."""
    bonds = [(atom, other) for atom, others in enumerate(neighbors) for other in others if atom < other]
    return connectedParts(len(neighbors), bonds).tolist()
