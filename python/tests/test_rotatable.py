"""Rotatable bonds: single, acyclic, neither terminal nor conjugated, by orders of the file or the dictionary."""

import pytest
from biotite.structure.info import residue as component
from commands import filesIn
from openmm import app
from openmmchaintree import createStericExclusionForce, findTorsions
from openmmchaintree.structures.structure import readStructure
from peptides import makePeptides
from scenes import pdbLine, writePDB

# Components of the dictionary, and the number of their rotatable bonds by RDKit.
_COUNTS = {"IBP": 4, "TYL": 1, "AIN": 2, "BNZ": 0, "BTN": 5, "PLM": 14, "STI": 7}


def moleculeOf(code, name=None, orders=False):
    """Return the Topology of a component, with its bonds, and perhaps their orders, and its positions in nm."""
    atoms = component(code)
    topology = app.Topology()
    residue = topology.addResidue(name or code, topology.addChain())
    made = [
        topology.addAtom(name, app.Element.getBySymbol(element.title()), residue)
        for name, element in zip(atoms.atom_name, atoms.element, strict=True)
    ]
    for first, second, kind in atoms.bonds.as_array():
        # AROMATIC_SINGLE and AROMATIC_DOUBLE are 5 and 6
        order = int(kind) if kind < 5 else int(kind) - 4
        topology.addBond(made[first], made[second], None, order if orders else None)
    return topology, 0.1 * atoms.coord.astype(float)


def bondsOf(search):
    return {frozenset((torsion.particles[1], torsion.particles[2])) for torsion in search.torsions}


@pytest.mark.parametrize("code", _COUNTS)
def test_moleculesOfTheDictionary(code):
    topology, _ = moleculeOf(code)
    search = findTorsions(topology, kinds="rotatable")
    assert len(bondsOf(search)) == len(search.torsions) == _COUNTS[code]
    assert not [left for left in search.leftOut if "order" in left.reason]


@pytest.mark.parametrize("code", _COUNTS)
def test_ordersOfTheTopologyCount(code):
    """A name that the dictionary does not have; orders of a Kekulé formula."""
    known, _ = moleculeOf(code)
    own, _ = moleculeOf(code, "?~?", orders=True)
    assert bondsOf(findTorsions(own, kinds="rotatable")) == bondsOf(findTorsions(known, kinds="rotatable"))


def test_typesOfTheTopologyCount():
    topology, _ = moleculeOf("TYL", "?~?", orders=True)
    types = {1: app.topology.Single, 2: app.topology.Double}
    topology._bonds = [app.topology.Bond(bond[0], bond[1], types[bond.order], None) for bond in topology.bonds()]
    known, _ = moleculeOf("TYL")
    assert bondsOf(findTorsions(topology, kinds="rotatable")) == bondsOf(findTorsions(known, kinds="rotatable"))


def test_unknownOrdersAreLeftOutAndSaid():
    """Without orders, bonds of saturated atoms are single; whether aryl–COOH is, nothing says."""
    topology, _ = moleculeOf("AIN", "?~?")
    search = findTorsions(topology, kinds="rotatable")
    assert [left.reason for left in search.leftOut if "unknown order" in left.reason]
    everything = bondsOf(findTorsions(topology, kinds="all"))
    assert bondsOf(search) < everything


def test_peptidesHaveNoOmegaAndNoRotors():
    topology, positions = makePeptides(("ACE", "ARG", "ASN", "SER", "MET", "NME"))
    kinds = [torsion.kind for torsion in findTorsions(topology, positions, kinds="rotatable").torsions]
    expected = findTorsions(topology, positions, kinds=("phi", "psi", "chi")).torsions
    assert kinds == [torsion.kind for torsion in expected]
    both = findTorsions(topology, positions, kinds=("rotatable", "omega")).torsions
    assert [torsion.kind for torsion in both if torsion.kind != "omega"] == kinds
    assert len([torsion for torsion in both if torsion.kind == "omega"]) == 5


def test_theForceTakesThem():
    topology, positions = moleculeOf("IBP")
    force = createStericExclusionForce(topology, positions, torsions="rotatable")
    assert force.getNumTorsions() == 4
    assert createStericExclusionForce(topology, positions, torsions="all").getNumTorsions() > 4


def linesOf(topology, positions):
    atoms = zip(topology.atoms(), 10 * positions, strict=True)
    return [
        pdbLine(atom.index + 1, atom.name, "XX9", "A", 1, *place, record="HETATM", element=atom.element.symbol)
        for atom, place in atoms
    ]


def conectOf(topology, areOrders):
    lines = []
    for bond in topology.bonds():
        for _ in range(bond.order if areOrders else 1):
            lines += [f"CONECT{bond[0].index + 1:>5}{bond[1].index + 1:>5}"]
    return lines


@pytest.mark.parametrize(("areOrders", "expected"), [(True, 2), (False, 1)])
def test_ordersOfConect(tmp_path, areOrders, expected):
    """CONECT lists a double bond twice; a file that lists each bond once has no orders."""
    topology, positions = moleculeOf("AIN", orders=True)
    lines = linesOf(topology, positions) + conectOf(topology, areOrders)
    structure = readStructure(writePDB(tmp_path / "aspirin.pdb", lines))
    search = findTorsions(structure.topology, structure.positions, kinds="rotatable")
    assert len(search.torsions) == expected
    assert any("unknown order" in left.reason for left in search.leftOut) != areOrders


def test_theCommandTakesThem(runCommandHere, tmp_path):
    topology, positions = moleculeOf("AIN", orders=True)
    structure = writePDB(tmp_path / "aspirin.pdb", linesOf(topology, positions) + conectOf(topology, True))
    result = runCommandHere("sample", structure, "--torsions", "rotatable", "--trials", 20, "--seed", 1)
    assert result.returncode == 0, result.stderr
    assert "by 2 torsions (2 other)" in result.stdout
    before = filesIn(tmp_path)
    refused = runCommandHere("sample", structure, "--torsions", "rotable", "--overwrite")
    assert refused.returncode == 2 and "rotatable" in refused.stderr and filesIn(tmp_path) == before
