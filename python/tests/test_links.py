"""Links: rigid parts, torsions between fixed parts, and what holds a molecule."""

import numpy as np
from openmmchaintree import findTorsions
from openmmchaintree.bonds import BondGraph
from openmmchaintree.graphs import connectedParts
from openmmchaintree.links import Links
from scenes import peptide


def test_torsionsBetweenAgainstCuttingEachOne():
    """A torsion is between fixed atoms exactly if, without its bond, both of its ends still hang on one."""
    random = np.random.default_rng(1)
    topology = peptide("LYS", "GLU", "TRP", "ARG", "ILE", chains=2)
    graph = BondGraph(topology)
    every = findTorsions(topology, kinds=("phi", "psi", "omega", "chi")).torsions
    for _ in range(100):
        torsions = [every[i] for i in np.flatnonzero(random.random(len(every)) < 0.6)]
        fixed = random.choice(len(graph.atoms), int(random.integers(0, 6)), replace=False)
        found = Links(graph, torsions).torsionsBetween(fixed)
        for torsion, isBetween in zip(torsions, found, strict=True):
            axis = frozenset(torsion.particles[1:3])
            cut = connectedParts(len(graph.atoms), [b for b in graph.bonds if frozenset(b) != axis])
            held = {cut[atom] for atom in fixed}
            assert isBetween == all(cut[atom] in held for atom in axis)


def test_rootIsTheLargestRigidBackbone():
    topology = peptide(*["ALA"] * 10)
    tail = findTorsions(topology, selection="resid 0 to 2").torsions
    assert rootResidues(topology, tail) == ({2, 3, 4, 5, 6, 7, 8, 9}, True)
    hinge = findTorsions(topology, selection="resid 6").torsions
    assert rootResidues(topology, hinge) == ({0, 1, 2, 3, 4, 5, 6}, True)
    assert rootResidues(topology, hinge, "resid 9") == ({6, 7, 8, 9}, True)


def test_rootIsTheFirstAtomWhereAllTurns():
    topology = peptide("GLY", "TRP", "ALA", "PRO")
    assert rootResidues(topology, findTorsions(topology).torsions) == ({0}, False)


def rootResidues(topology, torsions, fixed=None):
    """Return the residues that have an atom in the root, and whether it is large."""
    graph = BondGraph(topology)
    atoms = [] if fixed is None else [a.index for a in topology.atoms() if f"resid {a.residue.index}" == fixed]
    backbones = [
        np.array([atom.index for atom in residue.atoms() if atom.name in ("N", "CA", "C")])
        for residue in topology.residues()
    ]
    links = Links(graph, torsions)
    (root,), (isLarge,) = links.roots(np.array(atoms, dtype=int), backbones)
    return {graph.atoms[atom].residue.index for atom in np.flatnonzero(links.ofAtom == root)}, isLarge
