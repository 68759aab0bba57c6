"""createStericExclusionForce."""

import warnings

import numpy as np
import pytest
from openmm import app, unit
from openmmchaintree import createStericExclusionForce, findTorsions
from openmmchaintree.graphs import connectedParts
from scenes import peptide


def bondsOf(force):
    return [tuple(force.getBondParticles(i)) for i in range(force.getNumBonds())]


def exclusionsOf(force):
    return {frozenset(force.getExclusionParticles(i)) for i in range(force.getNumExclusions())}


def moleculeCount(force):
    return max(connectedParts(force.getNumParticles(), bondsOf(force))) + 1


def pairsWithin(count, bonds, cutoff):
    """All pairs up to cutoff bonds apart, by powers of the adjacency matrix."""
    adjacency = np.eye(count, dtype=int)
    for first, second in bonds:
        adjacency[first, second] = adjacency[second, first] = 1
    reached = np.linalg.matrix_power(adjacency, cutoff)
    return {frozenset(pair) for pair in np.argwhere(np.triu(reached, 1)).tolist()}


def test_villin(villin):
    force = createStericExclusionForce(villin.topology, villin.positions)
    assert force.getNumParticles() == 582
    assert {frozenset(bond) for bond in bondsOf(force)} == {
        frozenset((bond[0].index, bond[1].index)) for bond in villin.topology.bonds()
    }
    torsions = [tuple(force.getTorsionParticles(i)) for i in range(force.getNumTorsions())]
    assert torsions == [torsion.particles for torsion in findTorsions(villin.topology).torsions]
    assert exclusionsOf(force) == pairsWithin(582, bondsOf(force), 3)
    assert force.getForceGroup() == 31
    assert not force.usesPeriodicBoundaryConditions()


def test_arguments(villin):
    force = createStericExclusionForce(villin.topology, radii="united-atom", torsions="psi", bondCutoff=2, forceGroup=5)
    assert force.getNumTorsions() == 34
    assert exclusionsOf(force) == pairsWithin(582, bondsOf(force), 2)
    assert force.getForceGroup() == 5
    hydrogen = next(atom.index for atom in villin.topology.atoms() if atom.element.symbol == "H")
    assert force.getParticleParameters(hydrogen)[0] == 0 * unit.nanometer


def test_torsionsOfChoice(villin):
    chosen = [torsion for torsion in findTorsions(villin.topology).torsions if torsion.residue.index < 5]
    force = createStericExclusionForce(villin.topology, torsions=chosen)
    assert [tuple(force.getTorsionParticles(i)) for i in range(force.getNumTorsions())] == [
        torsion.particles for torsion in chosen
    ]
    assert createStericExclusionForce(villin.topology, torsions=()).getNumTorsions() == 0


def test_radiiOfChoice(villin):
    radii = np.linspace(0, 0.2, 582)
    for given in (radii, radii * unit.nanometer, (10 * radii).tolist() * unit.angstrom):
        force = createStericExclusionForce(villin.topology, radii=given)
        taken = [force.getParticleParameters(i)[0].value_in_unit(unit.nanometer) for i in range(582)]
        assert taken == pytest.approx(radii)


def test_badArguments(villin):
    topology = villin.topology
    with pytest.raises(ValueError, match="^'bondi' is not a set of radii; the sets are all-atom, united-atom$"):
        createStericExclusionForce(topology, radii="bondi")
    with pytest.raises(ValueError, match=r"^radii must have the shape \(582,\), not \(3,\)$"):
        createStericExclusionForce(topology, radii=[0.1, 0.1, 0.1])
    with pytest.raises(TypeError, match="^radii must be a length"):
        createStericExclusionForce(topology, radii=np.ones(582) * unit.kelvin)
    with pytest.raises(ValueError, match=r"^positions must have the shape \(582, 3\)"):
        createStericExclusionForce(topology, villin.positions[:-1])
    with pytest.raises(ValueError, match="^'tau' is not a kind of torsion"):
        createStericExclusionForce(topology, torsions=("tau",))
    with pytest.raises(Exception, match="bondCutoff|bonds"):
        createStericExclusionForce(topology, bondCutoff=-1)


def test_gapMakesTwoMolecules():
    topology = peptide("ALA", "ALA", "ALA")
    positions = np.random.default_rng(1).normal(size=(15, 3)) * 0.02
    positions[5:] += 1.0
    with pytest.warns(UserWarning, match="gaps in the chain .*between .*ALA 1 and .*ALA 2, C and N, bonded"):
        force = createStericExclusionForce(topology, positions)
    assert moleculeCount(force) == 2
    assert force.getNumTorsions() == 2
    carbon, nitrogen = 2, 5
    assert frozenset((carbon, nitrogen)) not in exclusionsOf(force)


def cystines():
    topology = peptide("CYS", "ALA", "ALA", "ALA", "CYS")
    topology.addBond(*[atom for atom in topology.atoms() if atom.name == "SG"])
    return topology


def test_disulfideStaysABond():
    topology = cystines()
    with pytest.warns(UserWarning, match=r"^torsions left out, in a ring that disulfide bonds close, .*\(10\)"):
        force = createStericExclusionForce(topology)
    assert force.getNumTorsions() == 0
    assert len(bondsOf(force)) == topology.getNumBonds()


@pytest.mark.parametrize("bondCutoff", [1, 2, 3, 4])
def test_cutDisulfideStaysExcluded(bondCutoff):
    topology = cystines()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        force = createStericExclusionForce(topology, bondCutoff=bondCutoff, cutDisulfides=True)
    assert force.getNumTorsions() == 10
    assert len(bondsOf(force)) == topology.getNumBonds() - 1
    bonds = [(bond[0].index, bond[1].index) for bond in topology.bonds()]
    assert exclusionsOf(force) == pairsWithin(topology.getNumAtoms(), bonds, bondCutoff)


def test_prolineIsNoReasonToWarn():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        createStericExclusionForce(peptide("ALA", "PRO", "ALA"))


def test_waterIsModelled():
    topology = app.Topology()
    residue = topology.addResidue("HOH", topology.addChain())
    for name in ("O", "H1", "H2"):
        topology.addAtom(name, app.Element.getBySymbol(name[0]), residue)
    topology.addAtom("M", None, residue)
    topology.createStandardBonds()
    force = createStericExclusionForce(topology)
    radii = [force.getParticleParameters(i)[0].value_in_unit(unit.nanometer) for i in range(4)]
    assert radii == pytest.approx([0.140, 0.100, 0.100, 0.0])
    assert force.getNumTorsions() == 0


def test_atomsWithoutBondsAreBondedByDistance():
    """A phosphate as it comes from a PDB file without CONECT records."""
    topology = app.Topology()
    residue = topology.addResidue("PO4", topology.addChain())
    for name in ("P", "O1", "O2", "O3", "O4"):
        topology.addAtom(name, app.Element.getBySymbol(name[0]), residue)
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) * 0.154 / np.sqrt(3)
    positions = np.vstack([[0, 0, 0], corners])
    for given in (topology, renamed(topology, "XYZ")):
        force = createStericExclusionForce(given, positions)
        assert sorted(map(sorted, bondsOf(force))) == [[0, 1], [0, 2], [0, 3], [0, 4]]
    assert moleculeCount(createStericExclusionForce(topology)) == 1  # the dictionary knows it
    assert moleculeCount(createStericExclusionForce(renamed(topology, "XYZ"))) == 5


def renamed(topology, name):
    """Return the Topology of one residue under a name that no dictionary has."""
    other = app.Topology()
    residue = other.addResidue(name, other.addChain())
    for atom in topology.atoms():
        other.addAtom(atom.name, atom.element, residue)
    return other


@pytest.mark.parametrize("cutMetals", [False, True])
def test_hemeMovesWithTheHistidineThatBindsIt(realStructure, cutMetals):
    structure = realStructure("4hhb.pdb")
    force = createStericExclusionForce(structure.topology, structure.positions, cutMetals=cutMetals)
    molecule = connectedParts(force.getNumParticles(), bondsOf(force)).tolist()
    hemes = [residue for residue in structure.topology.residues() if residue.name == "HEM"]
    assert len(hemes) == 4
    for heme in hemes:
        atoms = [atom.index for atom in heme.atoms()]
        (number,) = {molecule[atom] for atom in atoms}
        assert len(atoms) == 43 and (molecule.count(number) == 43) == cutMetals
    assert max(molecule) + 1 == (8 if cutMetals else 4)


def test_gapsOf6msm(realStructure):
    structure = realStructure("6msm.pdb")
    with pytest.warns(UserWarning, match="^gaps in the chain") as caught:
        createStericExclusionForce(structure.topology, structure.positions)
    assert len(caught[0].message.note.items) == 4


def test_unknownRadius():
    topology = app.Topology()
    residue = topology.addResidue("XEN", topology.addChain())
    topology.addAtom("XE", app.Element.getBySymbol("Xe"), residue)
    force = createStericExclusionForce(topology, unknownRadius=2 * unit.angstrom)
    assert force.getParticleParameters(0)[0].value_in_unit(unit.nanometer) == pytest.approx(0.2)
    with pytest.raises(TypeError, match="^unknownRadius must be a length"):
        createStericExclusionForce(topology, unknownRadius=2 * unit.kelvin)


def test_missingAtomsAreOneNote():
    topology = peptide("ALA", "LYS", "MET")
    modeller = app.Modeller(topology, np.zeros((topology.getNumAtoms(), 3)))
    modeller.delete([atom for atom in modeller.topology.atoms() if atom.name in ("CE", "NZ")])
    pattern = r"^torsions left out, since atoms or bonds are missing \(3\): chi3 of .*LYS 2"
    with pytest.warns(UserWarning, match=pattern) as caught:
        createStericExclusionForce(modeller.topology)
    assert len(caught) == 1
