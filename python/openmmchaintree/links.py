"""The links of molecules: rigid parts that torsions join, and the links that stay in place."""

import numpy as np

from .bonds import BondGraph
from .graphs import connectedParts, growTrees, neighborLists


class Links:
    """The links that torsions make of molecules, as a forest with the torsions as its edges.

    Attributes
    ----------
    ofAtom : (n,) int array
        the link of each atom; links, and molecules, are numbered by their lowest atom
    count : int
    ends : (m, 2) int array
        the links that each torsion joins
    moleculeOfAtom : (n,) int array
    moleculeOfLink : (count,) int array
    """

    def __init__(self, graph: BondGraph, torsions):
        """Find the links of a BondGraph under a list of Torsion, none of which lies in a ring."""
        count = len(graph.atoms)
        bonds = np.array(graph.bonds, dtype=int).reshape(-1, 2)
        axes = np.array([torsion.particles[1:3] for torsion in torsions], dtype=int).reshape(-1, 2)
        self.ofAtom = rigidLinks(graph, axes.tolist())
        self.count = int(self.ofAtom.max(initial=-1)) + 1
        self.ends = self.ofAtom[axes]
        self.moleculeOfAtom = connectedParts(count, bonds)
        self.moleculeOfLink = np.empty(self.count, dtype=int)
        self.moleculeOfLink[self.ofAtom] = self.moleculeOfAtom

    def torsionsBetween(self, atoms):
        """Return for each torsion whether some of these atoms lie on both sides, as an (m,) bool array."""
        marked = np.zeros(self.count, dtype=bool)
        marked[self.ofAtom[atoms]] = True
        beyond = marked.copy()  # whether the subtree of a link has one of the atoms
        between = np.zeros(len(self.ends), dtype=bool)
        joining = {(link1, link2): torsion for torsion, (link1, link2) in enumerate(self.ends.tolist())}
        neighbors = neighborLists(self.count, joining)
        for link, parent in reversed([*growTrees(neighbors, np.flatnonzero(marked).tolist())]):
            torsion = joining[link, parent] if (link, parent) in joining else joining[parent, link]
            between[torsion] = beyond[link]
            beyond[parent] |= beyond[link]
        return between

    def roots(self, atoms, traces):
        """Return the link of each molecule that stays in place, and whether it is more than a few atoms.

        It is the link with one of the atoms, of which each molecule has at most one; else the link with most residues
        of a polymer, if it has at least two; else the link with the lowest atom, which counts as small.

        Parameters
        ----------
        atoms : int array
        traces : list of int array
            the backbone atoms of each residue of a polymer

        Returns
        -------
        (molecules,) int array, (molecules,) bool array
        """
        weight = np.zeros(self.count)
        for trace in traces:
            links = self.ofAtom[trace]
            if np.all(links == links[0]):
                weight[links[0]] += 1
        weight[weight < 2] = 0
        weight[self.ofAtom[atoms]] = np.inf
        order = np.lexsort((np.arange(self.count), -weight, self.moleculeOfLink))
        _, first = np.unique(self.moleculeOfLink[order], return_index=True)
        roots = order[first]
        return roots, weight[roots] > 0


def rigidLinks(graph, axes):
    """Return the number of each atom's rigid link in a BondGraph with some turning bonds, as an int array."""
    turning = {(min(axis), max(axis)) for axis in axes}
    return connectedParts(len(graph.atoms), [bond for bond in graph.bonds if (min(bond), max(bond)) not in turning])
