"""Clashes counted by chain, by interface of two chains, and by ligand."""

from collections import Counter
from typing import NamedTuple

from ..naming import describeResidue
from ..residues import isPolymer, isWater


class PartCounts(NamedTuple):
    """The numbers of clashes of the parts of a structure that have any; chains without a name are numbered from 1.

    chains : dict, by chain: within it; interfaces : dict, by two chains: between them; ligands : dict, by residue that
    is neither of a polymer nor water: with other residues
    """

    chains: dict[str, int]
    interfaces: dict[tuple[str, str], int]
    ligands: dict[str, int]


def countByParts(topology, pairs):
    """Return the PartCounts of clashing pairs of particles of a Topology, a sequence of (int, int)."""
    atoms = list(topology.atoms())
    names = {chain.index: chain.id.strip() or str(chain.index + 1) for chain in topology.chains()}
    chains: Counter[str] = Counter()
    interfaces: Counter[tuple[str, str]] = Counter()
    ligands: Counter[str] = Counter()
    for pair in pairs:
        residue1, residue2 = (atoms[particle].residue for particle in pair)
        first, second = sorted((names[residue1.chain.index], names[residue2.chain.index]))
        if first == second:
            chains[first] += 1
        else:
            interfaces[first, second] += 1
        if residue1 is not residue2:
            for residue in (residue1, residue2):
                if not isPolymer(residue) and not isWater(residue):
                    ligands[describeResidue(residue)] += 1
    return PartCounts(*(dict(counts.most_common()) for counts in (chains, interfaces, ligands)))
