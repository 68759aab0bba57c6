"""The net under all that finds bonds: atoms at covalent distance that are not bonded, and that trials would part."""

import warnings

import numpy as np
import pytest
from openmm import app
from openmmchaintree import createStericExclusionForce
from openmmchaintree.bonds import BondGraph
from openmmchaintree.notes import NoteWarning
from openmmchaintree.structures.structure import readStructure
from openmmchaintree.unbonded import unbondedNeighbors
from scenes import GLYCINES, pdbLine, writePDB


def isopeptide():
    """Two chains of carbon whose side branches touch at 0.15 nm, without a bond: residues of one chain each."""
    topology = app.Topology()
    for _ in range(2):
        chain = topology.addChain()
        residue = topology.addResidue("LYS", chain)
        for name in ("N", "CA", "C", "O", "CB", "CG"):
            topology.addAtom(name, app.Element.getBySymbol(name[0]), residue)
    topology.createStandardBonds()
    backbone = [[0, 0, 0], [0.146, 0, 0], [0.196, 0.142, 0], [0.12, 0.238, 0]]
    half = np.array([*backbone, [0.2, -0.07, 0.12], [0.35, -0.07, 0.12]])
    mirrored = half * [-1, 1, 1] + [0.85, 0, 0]
    return topology, np.vstack([half, mirrored])


def test_oneWarningWithTheWorst():
    topology, positions = isopeptide()
    with pytest.warns(NoteWarning, match=r"not bonded, .* \(1\): 1:LYS 1 CG – 2:LYS 2 CG, 0.150"):
        createStericExclusionForce(topology, positions, torsions=("chi",))


def test_bondedOrFarAtomsAreNotMeant():
    topology, positions = isopeptide()
    atoms = list(topology.atoms())
    topology.addBond(atoms[5], atoms[11])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        createStericExclusionForce(topology, positions, torsions=())
    topology, positions = isopeptide()
    positions[6:] += [0.05, 0, 0]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        createStericExclusionForce(topology, positions, torsions=())


def test_whatNeverMoves():
    topology, positions = isopeptide()
    graph = BondGraph(topology, positions)
    assert len(unbondedNeighbors(graph, [])) == 1
    assert unbondedNeighbors(graph, [], fixed=range(12)) == []
    assert len(unbondedNeighbors(graph, [], fixed=range(6))) == 1
    assert unbondedNeighbors(graph, [], alternates=["A"] * 6 + ["B"] * 6) == []
    assert len(unbondedNeighbors(graph, [], alternates=["A"] * 6 + [""] * 6)) == 1


def test_neighborsOfNeighbors():
    """Angles may be sharp: atoms with a common neighbour are not meant, whatever turns."""
    topology, positions = isopeptide()
    positions[2] = positions[0] + [0.0, 0.15, 0.0]  # N and C of the first residue
    graph = BondGraph(topology, positions)
    assert len(unbondedNeighbors(graph, [(0, 1)])) == 1


@pytest.mark.parametrize(("distance", "isNoted"), [(1.0, True), (1.75, True), (1.95, True), (2.05, True), (2.3, False)])
def test_withinAResidueWithoutTemplate(tmp_path, distance, isNoted):
    """Cβ at any distance of a bond is bonded, or noted; never parted in silence."""
    lines = [line.replace("GLY A   2", "XAA A   2") for line in GLYCINES]
    place = np.array([3.9, 2.87, 0]) + distance * np.array([-0.32, 0.46, 0.83])
    lines.append(pdbLine(9, "CB", "XAA", "A", 2, *place))
    structure = readStructure(writePDB(tmp_path / "residue.pdb", lines))
    graph = BondGraph(structure.topology, structure.positions)
    isBonded = bool(graph.neighbors[8])
    assert isBonded == (1.1 < distance < 1.9)
    found = unbondedNeighbors(graph, [(4, 5), (5, 6)])
    assert bool(found) == (isNoted and not isBonded)


@pytest.mark.parametrize(("distance", "isNoted"), [(0.9, False), (1.3, True), (1.65, True), (1.85, True), (2.0, False)])
def test_betweenResiduesOneOfWhichHasNoTemplate(distance, isNoted):
    topology, positions = isopeptide()
    positions[6:, 0] += (distance - 1.5) / 10
    graph = BondGraph(topology, positions)
    assert bool(unbondedNeighbors(graph, [])) == (isNoted and distance < 1.7)
    graph.hasTemplate[6:] = False
    assert bool(unbondedNeighbors(graph, [])) == isNoted
