"""Which torsions are rotatable bonds: acyclic single bonds, neither terminal nor conjugated as in amides."""

from openmm import app

from .graphs import ringBonds
from .templates import isStandard, standardName, templateOrders

ROTATABLE = "rotatable"
UNKNOWN_ORDER = "about a bond of unknown order (the file gives none, nor does the component dictionary)"

# Kinds of torsions that are about single bonds wherever they are found.
_SINGLE = {
    "phi", "psi", "chi1", "chi2", "chi3", "chi4", "chi", "alpha", "beta", "gamma", "delta", "epsilon", "zeta",
}  # fmt: skip
_CONJUGATED_OR_TERMINAL = {"omega", "rotor"}

_ORDERS = {app.topology.Single: 1, app.topology.Amide: 1, app.topology.Double: 2, app.topology.Triple: 3}
_AROMATIC = 1.5

# The number of bonds of an atom without double bonds, by atomic number: C, N, O, Si, S.
_SATURATED = {6: 4, 8: 2, 14: 4, 16: 2}
_CARBON, _OXYGEN, _HETEROATOMS = 6, 8, (7, 8, 16)


class RotatableBonds:
    """The orders of the bonds of a BondGraph, as far as needed.

    An order is that of the Topology's bond (`order`, or `type`), else that of the chemical component dictionary. Bonds
    between residues are single, and so are bonds of atoms that have no room for double bonds; an oxygen that binds
    nothing but a trigonal carbon has a double bond.
    """

    def __init__(self, graph, topology):
        self._graph = graph
        self._inRings = ringBonds(graph.neighbors)
        self._orders = {}
        for bond in topology.bonds():
            order = _AROMATIC if bond.type is app.topology.Aromatic else bond.order or _ORDERS.get(bond.type)
            if order is not None:
                self._orders[frozenset((bond[0].index, bond[1].index))] = order
        self._dictionary = {}

    def has(self, torsion):
        """Whether a Torsion is about a rotatable bond; None if the order of the bond is unknown."""
        _, first, second, _ = torsion.particles
        if torsion.kind in _CONJUGATED_OR_TERMINAL or self._isTerminal(first) or self._isTerminal(second):
            return False
        if torsion.kind in _SINGLE:
            return True
        residues = [self._graph.atoms[atom].residue for atom in (first, second)]
        if all(isStandard(standardName(residue.name)) for residue in residues):
            return torsion.kind != "planar"
        order = self._orderOf(first, second)
        if order is None or order != 1:
            return None if order is None else False
        areConjugated = self._isConjugated(first, second), self._isConjugated(second, first)
        return False if True in areConjugated else None if None in areConjugated else True

    def _isTerminal(self, atom):
        return len(self._graph.heavyNeighborsOf(atom)) < 2

    def _isConjugated(self, carbon, other):
        """Whether a bond is one from a carbon with a double bond to N, O or S, to N, O or S, as in amides and esters.

        None if that is unknown. Double bonds in rings do not count: they may be those of an aromatic ring.
        """
        numbers, neighbors = self._graph.numbers, self._graph.neighbors
        if numbers[carbon] != _CARBON or numbers[other] not in _HETEROATOMS:
            return False
        beside = [atom for atom in neighbors[carbon] if atom != other and numbers[atom] in _HETEROATOMS]
        beside = [atom for atom in beside if (min(carbon, atom), max(carbon, atom)) not in self._inRings]
        orders = [self._orderOf(carbon, atom) for atom in beside]
        return True if 2 in orders else None if None in orders else False

    def _orderOf(self, first, second):
        """Return the order of a bond, None if it is unknown."""
        given = self._orders.get(frozenset((first, second)))
        if given is not None:
            return given
        atoms = self._graph.atoms[first], self._graph.atoms[second]
        if atoms[0].residue is not atoms[1].residue:
            return 1
        if atoms[0].residue not in self._dictionary:
            residue = atoms[0].residue
            self._dictionary[residue] = templateOrders(residue.name, tuple(atom.name for atom in residue.atoms()))
        known = self._dictionary[atoms[0].residue].get(frozenset(atom.name for atom in atoms))
        if known is not None:
            return known
        if self._isSaturated(first) or self._isSaturated(second):
            return 1
        return 2 if self._isCarbonyl(first, second) or self._isCarbonyl(second, first) else None

    def _isCarbonyl(self, carbon, oxygen):
        numbers, neighbors = self._graph.numbers, self._graph.neighbors
        counts = len(neighbors[carbon]), len(neighbors[oxygen])
        return (numbers[carbon], numbers[oxygen]) == (_CARBON, _OXYGEN) and counts == (3, 1)

    def _isSaturated(self, atom):
        return len(self._graph.neighbors[atom]) == _SATURATED.get(int(self._graph.numbers[atom]))
