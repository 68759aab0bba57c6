"""What createStericExclusionForce makes of the System that it is given: energies, fixed particles, bonds."""

import re
import warnings
from collections import Counter

import numpy as np
import openmm
import pytest
from openmm import app, unit
from openmmchaintree import (
    TorsionMonteCarloIntegrator,
    addDefaultMoves,
    createStericExclusionForce,
    createTopology,
    findTorsions,
)
from scenes import DIPEPTIDE, makeSystem, peptide, writePDB


def addPairs(system):
    force = openmm.NonbondedForce()
    for _ in range(system.getNumParticles()):
        force.addParticle(0, 0.1, 0)
    system.addForce(force)
    return system


def asList(force):
    return [tuple(force.getTorsionParticles(i)) for i in range(force.getNumTorsions())]


def bondsOf(force):
    return {tuple(sorted(force.getBondParticles(i))) for i in range(force.getNumBonds())}


def closuresOf(force):
    return [tuple(force.getClosureParticles(i))[1:3] for i in range(force.getNumClosures())]


def test_withEnergiesAllThatTurnsTurns(villin):
    plain = createStericExclusionForce(villin.topology, villin.positions)
    athermal = createStericExclusionForce(villin.topology, villin.positions, system=makeSystem(villin))
    assert asList(athermal) == asList(plain)
    system = addPairs(makeSystem(villin))
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # nothing stays rigid that could turn
        force = createStericExclusionForce(villin.topology, villin.positions, system=system)
    torsions = findTorsions(villin.topology, villin.positions, kinds="all").torsions
    assert asList(force) == [torsion.particles for torsion in torsions]
    assert {"omega", "rotor", "planar", "other"} < {torsion.kind for torsion in torsions}
    chosen = createStericExclusionForce(villin.topology, villin.positions, torsions="phi", system=system)
    assert asList(chosen) == [torsion.particles for torsion in torsions if torsion.kind == "phi"]


def test_restraintsAloneAreNoForceField(villin):
    system = makeSystem(villin, openmm.HarmonicBondForce(), openmm.CustomExternalForce("x"), openmm.CMMotionRemover())
    force = createStericExclusionForce(villin.topology, villin.positions, system=system)
    assert asList(force) == asList(createStericExclusionForce(villin.topology, villin.positions))


def test_whatStaysRigidIsTold(villin):
    system = addPairs(makeSystem(villin))
    with pytest.warns(UserWarning, match=r"bonds in no ring that stay rigid \(35\): .*; and 32 more"):
        createStericExclusionForce(
            *(villin.topology, villin.positions),
            torsions=("phi", "psi", "chi", "rotor", "planar"),
            system=system,
        )


def test_fixedAtomsThatHaveAMass(villin):
    system = makeSystem(villin)
    system.setParticleMass(1, 0)
    with pytest.warns(UserWarning, match=r"fixed atoms with a mass, .* mass 0 \(2\): LEU 1 N; LEU 1 H2"):
        createStericExclusionForce(villin.topology, villin.positions, fixed=[0, 1, 2], system=system)
    for atom in range(3):
        system.setParticleMass(atom, 0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        createStericExclusionForce(villin.topology, villin.positions, fixed=[0, 1, 2], system=system)


def test_disulfidesAreClosedWithEnergies():
    topology = peptide("CYS", "ALA", "CYS", "ALA")
    sulfurs = [atom for atom in topology.atoms() if atom.name == "SG"]
    topology.addBond(*sulfurs)
    system = openmm.System()
    for _ in topology.atoms():
        system.addParticle(1)
    with pytest.warns(UserWarning, match="in a ring that disulfide bonds close"):
        assert closuresOf(createStericExclusionForce(topology, system=system)) == []
    addPairs(system)
    bond = tuple(sulfur.index for sulfur in sulfurs)
    assert closuresOf(createStericExclusionForce(topology, system=system)) == [bond]
    for options in ({"cutDisulfides": True}, {"closures": ()}):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            assert closuresOf(createStericExclusionForce(topology, system=system, **options)) == []


def test_particlesOfMass0AreFixed(villin):
    fixed = [atom.index for atom in villin.topology.atoms() if not 9 <= atom.residue.index <= 15]
    system = makeSystem(villin)
    for atom in fixed:
        system.setParticleMass(atom, 0)
    options = [{"fixed": fixed}, {"system": system}, {"fixed": fixed[:5], "system": system}]
    forces = [createStericExclusionForce(villin.topology, villin.positions, closures="loops", **one) for one in options]
    assert len({(*asList(force), *closuresOf(force)) for force in forces}) == 1 and closuresOf(forces[0])
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.addClosedMove(1, 0.1)
    system.addForce(forces[1])
    openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))


def test_virtualSitesAreNotFixed():
    topology = peptide("ALA", "ALA", "ALA")
    for _ in range(2):
        topology.addAtom("LP", None, list(topology.residues())[-1])
    system = openmm.System()
    for atom in topology.atoms():
        system.addParticle(0 if atom.element is None else 1)
    for site, parent in ((system.getNumParticles() - 2, 2), (system.getNumParticles() - 1, 8)):
        system.setVirtualSite(site, openmm.TwoParticleAverageSite(parent, parent - 1, 0.5, 0.5))
    assert asList(createStericExclusionForce(topology, system=system)) == asList(createStericExclusionForce(topology))


def beads(count):
    topology = app.Topology()
    chain = topology.addChain()
    for _ in range(count):
        topology.addAtom("B", None, topology.addResidue("BEA", chain))
    system = openmm.System()
    for _ in range(count):
        system.addParticle(50)
    return topology, system


@pytest.mark.parametrize("kind", ["harmonic", "constraint", "custom"])
def test_bondsOfBeadsAreThoseOfTheSystem(kind):
    topology, system = beads(5)
    harmonic, custom = openmm.HarmonicBondForce(), openmm.CustomBondForce("(r-0.38)^2")
    pairs = [(0, 1), (2, 1), (2, 3), (3, 4)]
    for first, second in pairs:
        if kind == "harmonic":
            harmonic.addBond(first, second, 0.38, 1000)
            custom.addBond(0, 3)  # a contact
        elif kind == "constraint":
            system.addConstraint(first, second, 0.38)
        else:
            custom.addBond(first, second)
    system.addForce(harmonic)
    system.addForce(custom)
    options = {"radii": np.full(5, 0.2), "torsions": (), "ballJoints": "bonds", "bondCutoff": 1}
    force = createStericExclusionForce(topology, system=system, **options)
    assert bondsOf(force) == {(0, 1), (1, 2), (2, 3), (3, 4)} and force.getNumBallJoints() == 4
    rotatable = createStericExclusionForce(topology, radii=np.full(5, 0.2), torsions="all", system=system)
    assert asList(rotatable) == [(0, 1, 2, 3), (1, 2, 3, 4)]


def test_drudeParticlesAreBondedToTheirParents():
    topology = peptide("ALA", "ALA", "ALA")
    count = topology.getNumAtoms()
    residue = list(topology.residues())[-1]
    system = openmm.System()
    for _ in range(count):
        system.addParticle(12)
    drude = openmm.DrudeForce()
    for i in range(3):
        topology.addAtom(f"D{i}", None, residue)
        drude.addParticle(system.addParticle(0.4), i, -1, -1, -1, 1, 0.001, 1, 1)
    system.addForce(drude)
    force = createStericExclusionForce(topology, system=system)
    assert {(0, count), (1, count + 1), (2, count + 2)} < bondsOf(force)
    assert force.getParticleParameters(count)[0] == 0 * unit.nanometer
    system.addForce(force)
    integrator = TorsionMonteCarloIntegrator(300)
    addDefaultMoves(integrator, topology, system)
    assert integrator.RigidBodyMove not in [integrator.getMoveType(i) for i in range(integrator.getNumMoves())]


def test_aSystemOfAnotherTopology(villin):
    with pytest.raises(ValueError, match="the System has 0 particles, but the Topology 582 atoms"):
        createStericExclusionForce(villin.topology, system=openmm.System())


def test_movesOfAForceFieldLeaveMostTrialsToTheRest(villin):
    system = addPairs(makeSystem(villin))
    system.addForce(createStericExclusionForce(villin.topology, villin.positions, system=system))
    integrator = TorsionMonteCarloIntegrator(300)
    added = addDefaultMoves(integrator, villin.topology, system)
    weights = Counter()
    for one in added:
        weights[one.purpose] += float(re.search(r"weight ([\d.e-]+)", one.description)[1])
    minor = [name for name in weights if name.startswith(("peptide bonds", "rotors", "planar groups"))]
    assert len(minor) == 6 and sum(weights[name] for name in minor) == pytest.approx(0.1, rel=0.01)
    assert 0.9 < sum(weights.values()) < 1
    openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))


def readDipeptide(tmp_path, constraints):
    writePDB(tmp_path / "dipeptide.pdb", DIPEPTIDE)
    pdb = app.PDBFile(str(tmp_path / "dipeptide.pdb"))
    return pdb, app.ForceField("amber14-all.xml").createSystem(pdb.topology, constraints=constraints)


@pytest.mark.parametrize("constraints", [None, app.HBonds, app.AllBonds, app.HAngles])
def test_aSystemWithoutATopology(tmp_path, constraints):
    """Elements by masses and bonds by Forces and constraints: the same force as from the Topology."""
    pdb, system = readDipeptide(tmp_path, constraints)
    topology = createTopology(system)
    assert [atom.element for atom in topology.atoms()] == [atom.element for atom in pdb.topology.atoms()]
    forces = [createStericExclusionForce(one, pdb.positions, system=system) for one in (pdb.topology, topology)]
    assert bondsOf(forces[0]) == bondsOf(forces[1])
    axes = [{tuple(sorted(particles[1:3])) for particles in asList(force)} for force in forces]
    assert axes[0] == axes[1] and len(asList(forces[1])) == forces[0].getNumTorsions() == 7
    for i in range(system.getNumParticles()):
        assert forces[0].getParticleParameters(i)[0] == forces[1].getParticleParameters(i)[0]
    system.addForce(forces[1])
    integrator = TorsionMonteCarloIntegrator(300)
    addDefaultMoves(integrator, topology, system)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(pdb.positions)
    integrator.step(1)


def test_elementsAndBondsOfChoice():
    # Butane without hydrogens, and two beads; butane is torn apart by one of them.
    system = openmm.System()
    for mass in (15, 14, 14, 90, 15, 90):
        system.addParticle(mass)
    with pytest.raises(ValueError, match="particle 0 has the mass 15 Da, which no element has: give elements"):
        createTopology(system)
    elements = ["C", 6, app.element.carbon, None, "C", 0]
    topology = createTopology(system, elements, [(0, 1), (1, 2), (2, 4)])
    assert [atom.element and atom.element.symbol for atom in topology.atoms()] == ["C", "C", "C", None, "C", None]
    assert topology.getNumChains() == 4
    force = createStericExclusionForce(topology, torsions="all")
    assert asList(force) == [(0, 1, 2, 4)]
    with pytest.raises(ValueError, match="there are 2 elements, but 6 particles"):
        createTopology(system, ["C", "C"])
    with pytest.raises(ValueError, match="bonds names particles 0 and 6, but there are 6 particles"):
        createTopology(system, elements, [(0, 6)])
