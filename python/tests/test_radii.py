"""The sets of radii, atom by atom, and the roles in hydrogen bonds."""

import numpy as np
import pytest
from openmm import app
from openmmchaintree import StericExclusionForce, createStericExclusionForce
from openmmchaintree.bonds import BondGraph
from openmmchaintree.command.allpairs import HardSpheres
from openmmchaintree.radii import ALL_ATOM, UNITED_ATOM, defaultRadii, hydrogenBondRoles, particleRadii
from scenes import peptide

_NONE, _DONOR = StericExclusionForce.NoHydrogenBond, StericExclusionForce.Donor
_ACCEPTOR, _BOTH = StericExclusionForce.Acceptor, StericExclusionForce.DonorAndAcceptor


def byName(topology, values, residueName):
    residue = next(residue for residue in topology.residues() if residue.name == residueName)
    return {atom.name: values[atom.index] for atom in residue.atoms()}


def test_allAtomRadii(villin):
    graph = BondGraph(villin.topology)
    radii = particleRadii(graph, ALL_ATOM)
    phenylalanine = byName(villin.topology, radii, "PHE")
    assert phenylalanine["N"] == 0.155 and phenylalanine["O"] == 0.140
    assert phenylalanine["C"] == 0.165 and phenylalanine["CA"] == phenylalanine["CG"] == 0.175
    assert phenylalanine["H"] == 0.100 and phenylalanine["HA"] == 0.117
    assert phenylalanine["HD1"] == phenylalanine["HZ"] == 0.100
    aspartate = byName(villin.topology, radii, "ASP")
    assert aspartate["CG"] == 0.165 and aspartate["CB"] == 0.175
    assert byName(villin.topology, radii, "MET")["SD"] == 0.180
    assert byName(villin.topology, radii, "SER")["HG"] == 0.100


def test_unitedAtomRadii(villin):
    radii = particleRadii(BondGraph(villin.topology), UNITED_ATOM)
    tryptophan = byName(villin.topology, radii, "TRP")
    assert tryptophan["N"] == tryptophan["NE1"] == 0.164
    assert tryptophan["O"] == 0.142 and tryptophan["C"] == 0.161
    assert tryptophan["CA"] == tryptophan["CB"] == 0.188
    assert tryptophan["CD2"] == tryptophan["CE2"] == tryptophan["CG"] == 0.161
    assert tryptophan["CD1"] == tryptophan["CH2"] == 0.176
    assert byName(villin.topology, radii, "SER")["OG"] == 0.146
    assert byName(villin.topology, radii, "MET")["SD"] == 0.177
    assert all(
        radius == 0 for atom, radius in zip(villin.topology.atoms(), radii, strict=True) if atom.element.symbol == "H"
    )


def test_hydrogensDecideTheSet(villin):
    assert set(defaultRadii(BondGraph(villin.topology))) == {ALL_ATOM}
    assert set(defaultRadii(BondGraph(peptide("ALA", "TYR")))) == {UNITED_ATOM}


def setOfEachMolecule(topology, *bonds):
    atoms = list(topology.atoms())
    for first, second in bonds:
        topology.addBond(atoms[first], atoms[second])
    sets = defaultRadii(BondGraph(topology))
    return [sets[next(chain.atoms()).index] for chain in topology.chains()]


def withResidue(topology, name, atoms):
    """Add a chain of one residue of these atoms, of the elements that their names begin with."""
    residue = topology.addResidue(name, topology.addChain())
    for atom in atoms.split():
        topology.addAtom(atom, app.Element.getBySymbol(atom[0]), residue)
    return topology


def test_moleculesHaveSetsOfTheirOwn():
    """Hydrogens of a ligand, of the protein or of water do not affect the radii of other molecules."""
    topology = withResidue(withResidue(peptide("ALA", "TYR", "SER"), "LIG", "C1 O1 H1"), "HOH", "O H1 H2")
    count = topology.getNumAtoms()
    bonds = [(count - 6, count - 5), (count - 6, count - 4), (count - 3, count - 2), (count - 3, count - 1)]
    assert setOfEachMolecule(topology, *bonds) == [UNITED_ATOM, ALL_ATOM, ALL_ATOM]
    stray = withResidue(peptide("ALA", "TYR", "SER"), "XXX", "H1")
    assert setOfEachMolecule(stray, (1, stray.getNumAtoms() - 1)) == [UNITED_ATOM] * 2
    assert setOfEachMolecule(withResidue(peptide("GLY"), "HOH", "O")) == [UNITED_ATOM] * 2


def test_hydrogensOfNitrogenAndOxygenAlone():
    """Their carbons stand for hydrogens, their nitrogens show them; urea has no others."""
    topology = app.Topology()
    chain = topology.addChain()
    for _ in range(3):
        residue = topology.addResidue("SER", chain)
        for name in ("N", "H", "CA", "CB", "OG", "HG", "C", "O"):
            topology.addAtom(name, app.Element.getBySymbol(name[0]), residue)
    topology.createStandardBonds()
    graph = BondGraph(topology)
    assert set(defaultRadii(graph)) == {UNITED_ATOM}
    roles = byName(topology, hydrogenBondRoles(graph, defaultRadii(graph)), "SER")
    assert (roles["N"], roles["H"], roles["OG"], roles["O"]) == (_DONOR, _NONE, _BOTH, _ACCEPTOR)
    urea = withResidue(app.Topology(), "URE", "C O N1 N2 H1 H2 H3 H4")
    assert setOfEachMolecule(urea, (0, 1), (0, 2), (0, 3), (2, 4), (2, 5), (3, 6), (3, 7)) == [ALL_ATOM]


def test_sulfurGivesNoRoom():
    """Hydrogen bonds of sulfur are as long as its contacts: 0.27 nm from methionine's is a clash."""
    topology = peptide("CYS", "MET")
    roles = hydrogenBondRoles(BondGraph(topology), UNITED_ATOM)
    assert byName(topology, roles, "CYS")["SG"] == byName(topology, roles, "MET")["SD"] == _ACCEPTOR


def test_allAtomRoles(villin):
    roles = hydrogenBondRoles(BondGraph(villin.topology), ALL_ATOM)
    serine = byName(villin.topology, roles, "SER")
    assert serine["H"] == serine["HG"] == _DONOR
    assert serine["O"] == serine["OG"] == _ACCEPTOR
    assert serine["N"] == serine["CA"] == serine["HA"] == _NONE
    histidine = byName(villin.topology, roles, "HIE")
    protonated = {"ND1": "HD1", "NE2": "HE2"}
    for nitrogen, hydrogen in protonated.items():
        assert histidine[nitrogen] == (_NONE if hydrogen in histidine else _ACCEPTOR)


def test_unitedAtomRolesWithoutHydrogens():
    topology = peptide("GLY", "SER", "HIS", "PRO", "ASN", "ARG", "CYS")
    roles = hydrogenBondRoles(BondGraph(topology), UNITED_ATOM)
    serine = byName(topology, roles, "SER")
    assert (serine["N"], serine["O"], serine["OG"], serine["CB"]) == (_DONOR, _ACCEPTOR, _BOTH, _NONE)
    histidine = byName(topology, roles, "HIS")
    assert (histidine["N"], histidine["ND1"], histidine["NE2"]) == (_DONOR, _BOTH, _BOTH)
    assert byName(topology, roles, "PRO")["N"] == _NONE
    asparagine = byName(topology, roles, "ASN")
    assert (asparagine["OD1"], asparagine["ND2"]) == (_ACCEPTOR, _DONOR)
    assert byName(topology, roles, "ARG")["NH1"] == _DONOR
    assert byName(topology, roles, "CYS")["SG"] == _ACCEPTOR


def test_unitedAtomRolesWithHydrogens(villin):
    roles = hydrogenBondRoles(BondGraph(villin.topology), UNITED_ATOM)
    lysine = byName(villin.topology, roles, "LYS")
    assert (lysine["N"], lysine["NZ"], lysine["O"], lysine["H"]) == (_DONOR, _DONOR, _ACCEPTOR, _NONE)


def singleAtom(symbol):
    topology = app.Topology()
    residue = topology.addResidue("LIG", topology.addChain("A"))
    topology.addAtom("X1", symbol and app.Element.getBySymbol(symbol), residue)
    return BondGraph(topology)


@pytest.mark.parametrize("radiiSet", [ALL_ATOM, UNITED_ATOM])
def test_otherElements(radiiSet):
    assert particleRadii(singleAtom("Fe"), radiiSet) == [0.074]
    assert particleRadii(singleAtom("P"), radiiSet) == [0.180]
    assert particleRadii(singleAtom("Cl"), radiiSet) == [0.177]


@pytest.mark.parametrize("radiiSet", [ALL_ATOM, UNITED_ATOM])
def test_extraParticleIsNotModelled(radiiSet):
    assert particleRadii(singleAtom(None), radiiSet) == [0.0]


@pytest.mark.parametrize("radiiSet", [ALL_ATOM, UNITED_ATOM])
def test_unknownElementIsNamed(radiiSet):
    message = r"^atoms of elements without a known radius \(1\): A:LIG 1 X1, xenon: pass radii or unknownRadius$"
    with pytest.raises(ValueError, match=message):
        particleRadii(singleAtom("Xe"), radiiSet)
    assert particleRadii(singleAtom("Xe"), radiiSet, unknownRadius=0.2) == [0.2]


_NATIVE = ["1shg.pdb", "1ctf.pdb", "1crn.pdb", "1ubi_h.pdb", "bpti_h.pdb", "5dfr_h.pdb", "4hhb.pdb"]


@pytest.mark.parametrize("name", _NATIVE)
def test_nativeStructuresHardlyClash(realStructure, name):
    """Radii, roles and tolerances fit together: real structures have at most one clash for 60 atoms."""
    structure = realStructure(name)
    force = createStericExclusionForce(structure.topology, structure.positions, torsions=())
    overlaps = HardSpheres(force).overlaps(structure.positions)
    assert len(overlaps.pairs) <= max(3, structure.topology.getNumAtoms() / 60)
    assert np.all(overlaps.overlaps < 0.14)
