"""The mixtures of moves that addDefaultMoves adds."""

import re
from itertools import pairwise

import numpy as np
import openmm
import pytest
from openmm import app, unit
from openmmchaintree import (
    AddedMoves,
    StericExclusionForce,
    TorsionMonteCarloIntegrator,
    addDefaultMoves,
    createStericExclusionForce,
    findTorsions,
)
from scenes import makeSystem, peptide


def add(topology, force, **options):
    integrator = TorsionMonteCarloIntegrator(300)
    system = openmm.System()
    for _ in topology.atoms():
        system.addParticle(1)
    system.addForce(force)
    return integrator, addDefaultMoves(integrator, topology, system, **options), system


def kindsOf(integrator):
    return [integrator.getMoveType(move) for move in range(integrator.getNumMoves())]


def test_aProteinGetsAllMovesAndMoves(villin):
    force = createStericExclusionForce(villin.topology, villin.positions)
    system = makeSystem(villin, force)
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(1)
    before = integrator.addTorsionMove(0, 0.1)
    added = addDefaultMoves(integrator, villin.topology, system)
    assert isinstance(added, AddedMoves) and [one.move for one in added] == list(range(before + 1, len(added) + 1))
    kinds = kindsOf(integrator)[1:]
    for kind in (integrator.ClosedMove, integrator.LocalMove, integrator.TorsionMove, integrator.DrawnMove):
        assert kind in kinds
    assert integrator.RigidBodyMove not in kinds
    for one, line in zip(added, str(added).splitlines(), strict=True):
        assert one.description == integrator.getMoveDescription(one.move)
        assert line.split() == [str(one.move), *one.description.split(), *one.purpose.split()]
    # Each torsion of the force is turned by some move: all angles change.
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(villin.positions)
    start = integrator.getTorsionAngles(context)
    integrator.step(200)
    for one in added:
        assert integrator.getMoveStatistics(one.move).accepted > 0
    turned = np.angle(np.exp(1j * (integrator.getTorsionAngles(context) - start)))
    assert np.count_nonzero(np.abs(turned) > 1e-9) == force.getNumTorsions()


def test_loosePeptides():
    topology = peptide(*["ALA"] * 12)
    force = createStericExclusionForce(topology)
    integrator, added, _ = add(topology, force, disordered=True)
    kinds = kindsOf(integrator)
    assert kinds[0] == integrator.DrawnMove and integrator.ClosedMove in kinds
    assert sum(kind == integrator.TorsionMove for kind in kinds) == 2
    assert integrator.LocalMove not in kinds and len(added) == len(kinds)


def test_whatIsTooShortForClosedMovesGetsNone():
    topology = peptide("ALA", "SER", "ALA")
    integrator, added, system = add(topology, createStericExclusionForce(topology))
    assert integrator.ClosedMove not in kindsOf(integrator) and integrator.LocalMove in kindsOf(integrator)
    openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))


def test_theMiddleOfAChainHasNoEnds():
    """Ends are those of the chain, not those of the torsions that move."""
    topology = peptide(*["ALA"] * 30)
    purposes = {}
    for selection in ("resid 10 to 20", "resid 3 to 12"):
        torsions = findTorsions(topology, selection=selection).torsions
        _, added, _ = add(topology, createStericExclusionForce(topology, torsions=torsions))
        purposes[selection] = {one.purpose for one in added}
    assert purposes["resid 3 to 12"] - purposes["resid 10 to 20"] == {
        "ends of chains",
        "ends of chains, drawn uniformly",
    }
    assert purposes["resid 10 to 20"] < purposes["resid 3 to 12"]


def test_allOfAShortChainIsAnEnd():
    topology = peptide("ALA", "SER", "ALA")
    force = createStericExclusionForce(topology)
    integrator, added, _ = add(topology, force)
    backbones = [i for i, one in enumerate(findTorsions(topology).torsions) if one.kind in ("phi", "psi")]
    ends = [one.move for one in added if one.purpose.startswith("ends of chains")]
    assert len(ends) == 2
    for move in ends:
        assert integrator.getTorsionMoveParameters(move)[2].tolist() == backbones


def test_endsOfASmallProteinLeaveMostTrialsToTheRest(villin):
    integrator, added, _ = add(villin.topology, createStericExclusionForce(villin.topology, villin.positions))
    backbones, sideChains = [], []
    for one in added:
        weight = float(re.search(r"weight ([\d.e-]+)", one.description)[1])
        (sideChains if "side chains" in one.purpose else backbones).append((weight, one.purpose))
    for moves, purpose, most in (
        (backbones, "ends of chains", 0.4),
        (sideChains, "side chains of ends of chains", 0.3),
    ):
        ofEnds = sum(weight for weight, of in moves if of.startswith(purpose))
        assert 0.5 * most < ofEnds / sum(weight for weight, _ in moves) < most + 0.01


def test_sideChainsAreDrawnFromTheirFirstTorsionMostly():
    """Sets that begin with χ1 are one move, other sets another; sets at chain ends are drawn more often."""
    topology = peptide(*["LYS", "VAL", "GLU"] * 7)
    force = createStericExclusionForce(topology)
    integrator, added, _ = add(topology, force)
    torsions = findTorsions(topology).torsions
    drawn = {}
    for one in added:
        if integrator.getMoveType(one.move) == integrator.DrawnMove:
            weight, sets, _ = integrator.getDrawnMoveParameters(one.move)
            drawn[one.purpose] = weight, {tuple(torsions[i].kind for i in found) for found in sets}, sets
    whole, outer, ofEnds = drawn.values()
    assert all(kinds[0] == "chi1" for kinds in whole[1]) and ("chi1",) in whole[1]
    assert ("chi1", "chi2", "chi3", "chi4") in whole[1] and ("chi2", "chi3") in outer[1]
    assert not any("chi1" in kinds for kinds in outer[1]) and whole[0] > 2 * outer[0]
    residues = {torsions[i].residue.index for found in ofEnds[2] for i in found}
    assert residues == {*range(5), *range(16, 21)}
    assert set(ofEnds[2]) < {*whole[2], *outer[2]}
    loose, _, _ = add(topology, createStericExclusionForce(topology), disordered=True)
    drawn = [i for i, kind in enumerate(kindsOf(loose)) if kind == loose.DrawnMove]
    assert len(drawn) == 3  # φ and ψ, side chains, their ends


def test_closuresAreKept():
    # Cystines between the second and the last residues, whose bond is a closure: side chains of these are in its ring.
    topology = peptide("ALA", "CYS", *["SER"] * 9, "CYS", "ALA")
    force = createStericExclusionForce(topology)
    atoms = {(atom.residue.index, atom.name): atom.index for atom in topology.atoms()}
    force.addClosure(*(atoms[place] for place in ((1, "CB"), (1, "SG"), (11, "SG"), (11, "CB"))))
    integrator, added, system = add(topology, force)
    kinds = kindsOf(integrator)
    assert integrator.ClosedMove in kinds and integrator.DrawnMove in kinds
    openmm.Context(
        system, integrator, openmm.Platform.getPlatformByName("Reference")
    )  # which refuses torsions of the ring
    turned = set()
    for move, kind in enumerate(kinds):
        if kind == integrator.TorsionMove:
            turned |= set(integrator.getTorsionMoveParameters(move)[2].tolist())
    axes = {tuple(sorted(force.getTorsionParticles(torsion)[1:3])) for torsion in turned}
    assert (atoms[1, "CA"], atoms[1, "CB"]) not in axes and (atoms[2, "CA"], atoms[2, "CB"]) in axes
    assert (atoms[0, "CA"], atoms[0, "C"]) in axes and (atoms[5, "CA"], atoms[5, "C"]) not in axes


def test_aRingThatAClosureKeepsIsTurned():
    topology = peptide(*["ALA"] * 6)
    atoms = {(atom.residue.index, atom.name): atom for atom in topology.atoms()}
    topology.addBond(atoms[5, "C"], atoms[0, "N"])
    closures = [(atoms[5, "C"].index, atoms[0, "N"].index)]
    for torsions, options in (("phi", "psi"), {}), (("phi", "psi"), {"disordered": True}), (None, {}):
        if torsions is None:  # by particles that findTorsions does not name
            backbones = findTorsions(topology, closures=closures, kinds=("phi", "psi")).torsions
            force = createStericExclusionForce(topology, torsions=(), closures=closures)
            for torsion in backbones:
                particles = list(torsion.particles)
                if torsion.kind == "psi":
                    particles[3] = atoms[torsion.residue.index, "O"].index
                force.addTorsion(*particles)
        else:
            force = createStericExclusionForce(topology, torsions=torsions, closures=closures)
        integrator, added, system = add(topology, force, **options)
        assert kindsOf(integrator) == [integrator.ClosedMove]
        assert integrator.getClosedMoveParameters(0)[2].tolist() == list(range(force.getNumTorsions()))
        openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))


def test_aRingOfOtherTorsionsIsTurned():
    # A ring of an unknown residue.
    topology = app.Topology()
    residue = topology.addResidue("RNG", topology.addChain())
    atoms = [topology.addAtom(f"C{i}", app.element.carbon, residue) for i in range(12)]
    for i in range(12):
        topology.addBond(atoms[i], atoms[(i + 1) % 12])
    force = createStericExclusionForce(topology, torsions=(), closures=[(0, 11)])
    for i in range(9):
        force.addTorsion(i, i + 1, i + 2, i + 3)
    integrator, added, _ = add(topology, force)
    assert kindsOf(integrator) == [integrator.ClosedMove]
    assert integrator.getClosedMoveParameters(0)[2].tolist() == list(range(9))


def waters(count):
    """Return a Topology of an alanine tripeptide and waters with a virtual site without bonds, and its System."""
    topology = peptide("ALA", "ALA", "ALA")
    chain = topology.addChain()
    for _ in range(count):
        residue = topology.addResidue("HOH", chain)
        oxygen, *hydrogens = (
            topology.addAtom(name, app.Element.getBySymbol(name[0]), residue) for name in ("O", "H1", "H2")
        )
        for hydrogen in hydrogens:
            topology.addBond(oxygen, hydrogen)
        topology.addAtom("M", None, residue)
    system = openmm.System()
    for atom in topology.atoms():
        system.addParticle(0 if atom.element is None else 1)
        if atom.element is None:
            system.setVirtualSite(atom.index, openmm.TwoParticleAverageSite(atom.index - 3, atom.index - 2, 0.5, 0.5))
    return topology, system


def test_virtualSitesWithoutBondsBelongToTheirMolecules():
    topology, system = waters(3)
    system.addForce(createStericExclusionForce(topology))
    integrator = TorsionMonteCarloIntegrator(300)
    added = addDefaultMoves(integrator, topology, system)
    oxygens = [atom.index for atom in topology.atoms() if atom.residue.name == "HOH" and atom.name == "O"]
    assert integrator.getRigidBodyMoveParameters(added[-1].move)[3].tolist() == [0, *oxygens]
    openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))


def test_drudeParticlesMustBeBonded():
    topology, system = waters(1)
    drude = topology.getNumAtoms()
    topology.addAtom("DO", None, list(topology.residues())[-1])
    system.addParticle(0.4)
    force = openmm.DrudeForce()
    force.addParticle(drude, drude - 4, -1, -1, -1, 1, 0.001, 1, 1)
    system.addForce(force)
    spheres = createStericExclusionForce(topology)
    system.addForce(spheres)
    integrator = TorsionMonteCarloIntegrator(300)
    with pytest.raises(ValueError, match=f"particle {drude} is the Drude particle of particle {drude - 4}, but moves"):
        addDefaultMoves(integrator, topology, system)


def beads(length, chains, box=None):
    """Return the Topology and force of chains of hard beads, in a cubic box of this size (nm)."""
    topology = app.Topology()
    for _ in range(chains):
        chain = topology.addChain()
        atoms = [topology.addAtom("CA", app.element.carbon, topology.addResidue("BEA", chain)) for _ in range(length)]
        for before, atom in pairwise(atoms):
            topology.addBond(before, atom)
    radii = [0.2] * topology.getNumAtoms()
    force = createStericExclusionForce(topology, radii=radii, torsions=(), bondCutoff=1, ballJoints="bonds")
    force.setUsesPeriodicBoundaryConditions(box is not None)
    return topology, force


def test_beads():
    topology, force = beads(6, 2)
    integrator, added, system = add(topology, force)
    pivots, bodies = [integrator.PivotMove] * 2, [integrator.RigidBodyMove] * 2
    assert kindsOf(integrator) == [*pivots, integrator.CrankshaftMove, *bodies]
    assert [one.purpose for one in added][-2:] == ["where chains are", "chains to anywhere"]
    assert integrator.getRigidBodyMoveParameters(4)[1] == 2 * unit.nanometer
    openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    # A fixed molecule is not moved as a body.
    system.setParticleMass(0, 0)
    other = TorsionMonteCarloIntegrator(300)
    addDefaultMoves(other, topology, system)
    assert other.getRigidBodyMoveParameters(3)[3].tolist() == [6]
    # In a box, a chain may go anywhere.
    topology, force = beads(6, 2, box=8)
    system = openmm.System()
    for _ in topology.atoms():
        system.addParticle(1)
    system.setDefaultPeriodicBoxVectors([8, 0, 0], [0, 8, 0], [3, 0, 12])
    system.addForce(force)
    other = TorsionMonteCarloIntegrator(300)
    addDefaultMoves(other, topology, system)
    assert other.getRigidBodyMoveParameters(4)[1] == 6.185 * unit.nanometer


def test_aChainOfBeadsAlone():
    """It gets more pivots than one among others, no rigid-body moves, and no crankshafts if it is too short."""
    weights = {}
    for length, chains in ((6, 1), (6, 2), (3, 1)):
        integrator, added, _ = add(*beads(length, chains))
        ofPivots = [one.description for one in added if integrator.getMoveType(one.move) == integrator.PivotMove]
        weights[length, chains] = sum(float(re.search(r"weight ([\d.e-]+)", text)[1]) for text in ofPivots)
        if chains == 1:
            assert kindsOf(integrator)[2:] == ([integrator.CrankshaftMove] if length == 6 else [])
    assert weights == {(6, 1): pytest.approx(0.9), (6, 2): pytest.approx(0.3), (3, 1): pytest.approx(1)}


def test_otherTorsionsAreTurnedToo():
    topology = peptide("ALA", "ALA", "ALA")
    force = createStericExclusionForce(topology, torsions=("omega",))
    integrator, added, _ = add(topology, force)
    assert kindsOf(integrator) == [integrator.TorsionMove] * 2
    assert all(re.match("other torsions", one.purpose) for one in added)


def test_badArguments(villin):
    integrator = TorsionMonteCarloIntegrator(300)
    system = openmm.System()
    with pytest.raises(ValueError, match="the System has 0 particles, but the Topology"):
        addDefaultMoves(integrator, villin.topology, system)
    system = makeSystem(villin)
    with pytest.raises(ValueError, match="must have one StericExclusionForce, but has 0"):
        addDefaultMoves(integrator, villin.topology, system)
    force = StericExclusionForce()
    for _ in range(system.getNumParticles()):
        force.addParticle(0.1)
    system.addForce(force)
    for particle in range(system.getNumParticles()):
        system.setParticleMass(particle, 0)
    with pytest.raises(ValueError, match="nothing to move"):
        addDefaultMoves(integrator, villin.topology, system)
    assert integrator.getNumMoves() == 0
