"""Closures: rings of disulfides, cyclic peptides, and loops between fixed parts that closed moves turn."""

import warnings
from collections import Counter

import numpy as np
import openmm
import pytest
from openmm import app
from openmmchaintree import (
    StericExclusionForce,
    TorsionMonteCarloIntegrator,
    createStericExclusionForce,
    findTorsions,
)
from scenes import makeSystem, peptide, positionsOf, realStructurePath


def closuresOf(force):
    return [tuple(force.getClosureParticles(i)) for i in range(force.getNumClosures())]


def atomOf(topology, residue, name):
    """Return the index of an atom by the index of its residue and its name."""
    residues = list(topology.residues())
    return next(atom.index for atom in residues[residue].atoms() if atom.name == name)


def cystines(chains=1):
    topology = peptide("CYS", "ALA", "CYS", "ALA", chains=chains)
    return topology, [atom for atom in topology.atoms() if atom.name == "SG"]


def exclusionsOf(force):
    return {frozenset(force.getExclusionParticles(i)) for i in range(force.getNumExclusions())}


def sampled(structure, force, steps, fixed=(), moves=()):
    """Return the positions after steps of closed moves, and the integrator."""
    system = makeSystem(structure, force)
    for atom in fixed:
        system.setParticleMass(int(atom), 0)
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(3)
    integrator.addClosedMove(1, 0.2)
    for weight, angle in moves:
        integrator.addTorsionMove(weight, angle)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(structure.positions)
    start = positionsOf(context)
    integrator.step(steps)
    return start, positionsOf(context), integrator


def assertKept(closures, start, end):
    for closure in closures:
        for i, j in ((1, 2), (0, 2), (1, 3), (0, 3)):
            before, after = (np.linalg.norm(x[closure[i]] - x[closure[j]]) for x in (start, end))
            assert after == pytest.approx(before, abs=1e-9)


def test_disulfideIsKept():
    topology, sulfurs = cystines()
    topology.addBond(*sulfurs)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        force = createStericExclusionForce(topology, closures="disulfides")
        plain = createStericExclusionForce(topology, torsions=())
    search = findTorsions(topology, closures="disulfides")
    assert len(search.torsions) == force.getNumTorsions() == 8 and search.leftOut == []
    first, second = sorted(sulfur.index for sulfur in sulfurs)
    beta = [atom.index for atom in topology.atoms() if atom.name == "CB" and atom.residue.name == "CYS"]
    assert closuresOf(force) == [(beta[0], first, second, beta[1])]
    assert force.getNumBonds() == plain.getNumBonds() - 1
    assert exclusionsOf(force) == exclusionsOf(plain)


def test_disulfidesBetweenChainsCloseARingFromTheSecondOn():
    topology, sulfurs = cystines(chains=2)
    topology.addBond(sulfurs[0], sulfurs[2])
    assert closuresOf(createStericExclusionForce(topology, closures="disulfides")) == []
    topology.addBond(sulfurs[1], sulfurs[3])
    force = createStericExclusionForce(topology, closures="disulfides")
    assert [closure[1:3] for closure in closuresOf(force)] == [(sulfurs[1].index, sulfurs[3].index)]


def test_cyclicPeptide():
    # Beside the closure psi is told by O; phi of the first residue by nothing, since no hydrogen is there.
    topology = peptide("GLY", "ALA", "LEU", "ALA")
    first, last = atomOf(topology, 0, "N"), atomOf(topology, 3, "C")
    atoms = list(topology.atoms())
    topology.addBond(atoms[last], atoms[first])
    search = findTorsions(topology, closures=[(last, first)])
    assert Counter(torsion.kind for torsion in search.torsions) == {"phi": 3, "psi": 4, "chi1": 1, "chi2": 1}
    assert search.torsions[-1].particles[3] == atomOf(topology, 3, "O")
    assert [(left.kind, left.residue.index) for left in search.leftOut] == [("phi", 0)]
    force = createStericExclusionForce(topology, closures=[(last, first)], torsions=search.torsions)
    assert closuresOf(force) == [(atomOf(topology, 0, "CA"), first, last, atomOf(topology, 3, "CA"))]


def test_torsionsBesideAClosureTurnAsOthers():
    """A ring of six equal parts, closed between two of them: all torsions of a kind turn by as much."""
    topology = app.Topology()
    residue = topology.addResidue("RNG", topology.addChain())
    atoms = [topology.addAtom(f"C{i}", app.element.carbon, residue) for i in range(18)]
    for i in range(18):
        topology.addBond(atoms[i], atoms[(i + 1) % 18])
    for i in (0, 17):  # to tell torsions beside the closure by
        topology.addBond(atoms[i], topology.addAtom(f"H{i}", app.element.hydrogen, residue))
    turn = 2 * np.pi * np.array([*range(18), 0, 17]) / 18
    radius = 0.45 + 0.1 * (np.arange(20) >= 18)
    positions = np.stack([radius * np.cos(turn), radius * np.sin(turn), 0.05 * np.cos(6 * turn)], axis=1)
    force = createStericExclusionForce(topology, positions, np.zeros(20), torsions=(), closures=[(0, 17)])
    for i in range(17):
        if i % 3 != 2:  # two torsions, and a bond that does not turn
            force.addTorsion(i - 1 if i > 0 else 18, i, i + 1, i + 2 if i < 16 else 19)
    system = openmm.System()
    for _ in range(20):
        system.addParticle(1)
    system.addForce(force)
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(1)
    integrator.setTrialsPerStep(10)
    integrator.addClosedMove(1, 0.2)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(positions)
    angles = []
    for _ in range(1000):
        integrator.step(1)
        angles.append(integrator.getTorsionAngles(context))
    turned = np.mean(np.angle(np.exp(1j * np.diff(angles, axis=0))) ** 2, axis=0)
    assert turned.min() > 0.2 * turned.max()


def test_badClosures():
    topology, sulfurs = cystines()
    with pytest.raises(ValueError, match="closures names atoms 5 and 17, which are not bonded"):
        createStericExclusionForce(topology, closures=[(5, 17)])
    with pytest.raises(ValueError, match='closures must be "disulfides", "loops" or pairs of atoms, not \'rings\''):
        findTorsions(topology, closures="rings")
    with pytest.raises(ValueError, match="closures names atom 5, which has no other bond"):
        createStericExclusionForce(topology, closures=[(4, 5)])
    system = openmm.System()
    for _ in topology.atoms():
        system.addParticle(1)
    with pytest.warns(UserWarning, match="C and N are not bonded"):
        system.addForce(createStericExclusionForce(topology, closures=[(2, 6)]))
    with pytest.raises(openmm.OpenMMException, match="closes nothing.*add a bond instead"):
        openmm.Context(system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatformByName("Reference"))


def test_loopOfAFixedProtein(villin):
    # Seven residues between the helices move, and all else stays, bit by bit.
    topology = villin.topology
    loop = [atom.index for atom in topology.atoms() if 9 <= atom.residue.index <= 15]
    fixed = np.setdiff1d(np.arange(topology.getNumAtoms()), loop)
    bond = (atomOf(topology, 15, "C"), atomOf(topology, 16, "N"))
    assert not findTorsions(topology, villin.positions, kinds="phi psi".split(), selection=loop, fixed=fixed).torsions
    search = findTorsions(topology, villin.positions, selection=loop, fixed=fixed, closures=[bond])
    assert sum(torsion.kind in ("phi", "psi") for torsion in search.torsions) >= 13
    force = createStericExclusionForce(topology, villin.positions, torsions=search.torsions, closures=[bond])
    (closure,) = closuresOf(force)
    start, end, integrator = sampled(villin, force, 200, fixed, [(0.5, 0.3)])
    moved = np.linalg.norm(end - start, axis=1)
    assert np.all(end[fixed] == start[fixed])
    assert moved[atomOf(topology, 12, "CA")] > 0.005
    assert integrator.getMoveStatistics(0).accepted > 500
    assertKept([closure], start, end)


def test_loopsBetweenFixedParts(villin):
    # The bond at the end of a loop is found; a row of two residues is too short, and the end of a chain is no loop.
    topology = villin.topology

    def make(fixed, closures="loops"):
        return createStericExclusionForce(topology, villin.positions, closures=closures, fixed=fixed)

    bond = (atomOf(topology, 15, "C"), atomOf(topology, 16, "N"))
    given = findTorsions(topology, villin.positions, fixed="not resid 9 to 15", closures=[bond])
    force = make("not resid 9 to 15")
    assert [closure[1:3] for closure in closuresOf(force)] == [bond]
    assert force.getNumTorsions() == len(given.torsions)
    assert exclusionsOf(force) == exclusionsOf(make(None, ()))
    assert findTorsions(topology, villin.positions, fixed="not resid 9 to 15", closures="loops").torsions == (
        given.torsions
    )
    assert [closure[1:3] for closure in closuresOf(make("not (resid 9 to 15 or resid 20 to 22)"))] == [
        bond,
        (atomOf(topology, 22, "C"), atomOf(topology, 23, "N")),
    ]
    for fixed in ("not resid 9 to 10", "resid 0 to 20", "resid 20 to 35"):
        assert closuresOf(make(fixed, ["disulfides", "loops"])) == []


def test_disulfidesOfAProtein():
    structure = app.PDBFile(str(realStructurePath("bpti_h.pdb")))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        force = createStericExclusionForce(structure.topology, structure.positions, closures="disulfides")
    closures = closuresOf(force)
    assert len(closures) == 3
    start, end, integrator = sampled(structure, force, 100, moves=[(0.5, 0.3)])
    assert integrator.getMoveStatistics(0).accepted > 200
    assert np.sqrt(np.mean((end - start) ** 2)) > 1e-3
    assertKept(closures, start, end)


def test_disulfidesOfAForceField(tmp_path):
    # The tag in a file of ForceField has closures, too.
    structure = app.PDBFile(str(realStructurePath("bpti_h.pdb")))
    path = tmp_path / "spheres.xml"
    path.write_text("<ForceField><StericExclusionForce closures='disulfides'/></ForceField>")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        system = app.ForceField("amber14-all.xml", str(path)).createSystem(structure.topology)
        expected = createStericExclusionForce(structure.topology, closures="disulfides")
    (force,) = (force for force in system.getForces() if StericExclusionForce.isinstance(force))
    assert closuresOf(StericExclusionForce.cast(force)) == closuresOf(expected) != []
