"""Densities of torsions in Python, and densities from tables by residue."""

import copy
import pickle

import numpy as np
import openmm
import pytest
from openmm import unit
from openmmchaintree import (
    DrawnTorsions,
    StericExclusionForce,
    TorsionDensity,
    TorsionMonteCarloIntegrator,
    createStericExclusionForce,
    findTorsions,
    ramachandranDensities,
    rotamerDensities,
)
from openmmchaintree.densities import loopCounts, rotamerTables
from scenes import HEAVY_ATOMS, peptide

_AMINO_ACIDS = sorted(HEAVY_ATOMS)


def test_table():
    values = np.arange(12.0).reshape(3, 4)
    table = TorsionDensity.fromTable(values, floor=0.1)
    assert table.isTable() and table.getNumTorsions() == 2 and table.getFloor() == 0.1
    assert table.getTable().tolist() == values.tolist()
    middle = [-np.pi + 1.5 * 2 * np.pi / 3, -np.pi + 0.5 * 2 * np.pi / 4]
    expected = (0.9 * values[1, 0] / values.sum() * 12 + 0.1) / (2 * np.pi) ** 2
    assert table.evaluate(middle) == pytest.approx(expected, rel=1e-12)
    assert table.evaluate(np.degrees(middle) * unit.degrees) == pytest.approx(expected, rel=1e-12)
    assert repr(table) == "<TorsionDensity: 3 x 4 bins, floor 0.1>"
    with pytest.raises(openmm.OpenMMException, match="not a sum of rotamers"):
        table.getRotamers()


def testrotamers():
    means, widths = np.array([[60, -60], [180, 30]]), np.array([[5, 6], [7, 8]])
    density = TorsionDensity.fromRotamers([1, 3], means * unit.degrees, widths * unit.degrees, 0.2)
    found = density.getRotamers()
    assert found[0].tolist() == [1, 3]
    np.testing.assert_allclose(np.degrees(found[1]), means)
    np.testing.assert_allclose(np.degrees(found[2]), widths)
    assert repr(density) == "<TorsionDensity: 2 rotamers of 2 torsions, floor 0.2>"
    for bad in (means[0], means[:1], means[:, :1]):
        with pytest.raises((ValueError, openmm.OpenMMException)):
            TorsionDensity.fromRotamers([1, 3], bad, widths, 0.2)
    with pytest.raises(TypeError, match="means must be an angle"):
        TorsionDensity.fromRotamers([1, 3], means * unit.nanometer, widths, 0.2)


def test_copies():
    table = TorsionDensity.fromTable([1, 2, 3])
    rotamers = TorsionDensity.fromRotamers([1, 2], [[1], [2]], [[0.3], [0.4]], 0.1)
    for density in (table, rotamers):
        for duplicate in (copy.copy(density), copy.deepcopy(density), pickle.loads(pickle.dumps(density))):
            assert duplicate == density
    assert table != rotamers and table != TorsionDensity.fromTable([1, 2, 4]) and table != 3


def test_moveParameters():
    integrator = TorsionMonteCarloIntegrator(300)
    line, plane = TorsionDensity.fromTable([1, 2]), TorsionDensity.fromTable([[1, 2], [3, 4]])
    integrator.addDrawnMove(0.5, [3, np.int64(2), (1,)], line)
    integrator.addDrawnMove(weight=1, torsions=[[0, 1], np.array([4])], density=[plane, line])
    assert integrator.getMoveType(0) == TorsionMonteCarloIntegrator.DrawnMove
    assert integrator.getDrawnMoveParameters(0) == [0.5, [(3,), (2,), (1,)], [line]]
    assert integrator.getDrawnMoveParameters(1) == [1, [(0, 1), (4,)], [plane, line]]
    integrator.setDrawnMoveParameters(0, *integrator.getDrawnMoveParameters(1))
    assert integrator.getDrawnMoveParameters(0) == integrator.getDrawnMoveParameters(1)
    integrator.setDrawnMoveParameters(1, weight=2, torsions=DrawnTorsions([(5,)], [line]))
    assert integrator.getDrawnMoveParameters(1) == [2, [(5,)], [line]]
    for torsions, density, message in (
        ([0], None, "rotamerDensities"),
        ([0], 3, "density must be a TorsionDensity or a sequence of them, not int"),
        ([0], [3], "density must be a TorsionDensity or a sequence of them, not of int"),
        (0, line, "torsions must be a sequence"),
        (["0"], line, "torsions must be an integer"),
    ):
        with pytest.raises(TypeError, match=message):
            integrator.addDrawnMove(1, torsions, density)
    with pytest.raises(openmm.OpenMMException, match="at least one set"):
        integrator.addDrawnMove(1, [], line)


@pytest.mark.parametrize("name", [name for name in _AMINO_ACIDS if name not in ("ALA", "GLY", "PRO")])
def test_rotamersOfResidues(name):
    topology = peptide("GLY", name, "GLY")
    force = createStericExclusionForce(topology)
    drawn = rotamerDensities(topology, force, floor=0.2, parts=False)
    chis = [i for i, torsion in enumerate(findTorsions(topology).torsions) if torsion.kind.startswith("chi")]
    assert drawn.torsions == [tuple(chis)]
    (density,) = drawn.density
    weights, means, _ = density.getRotamers()
    assert density.getFloor() == 0.2
    assert means.shape[1] == len(chis)
    if name in ("ASP", "GLU", "PHE", "TYR"):
        # What ends in two atoms that are alike is as likely half a turn on.
        mode = means[weights.argmax()]
        turned = mode + np.pi * (np.arange(len(chis)) == len(chis) - 1)
        assert density.evaluate(turned) == pytest.approx(density.evaluate(mode), rel=1e-9)
    # Each chi is more likely by far to be near its mean than elsewhere.
    assert density.evaluate(means[weights.argmax()]) > (3 / (2 * np.pi)) ** len(chis)


def test_rotamersOfSomeChis():
    topology = peptide("GLY", "LYS", "LEU", "LYS", "MET", "ALA")
    torsions = [torsion for torsion in findTorsions(topology).torsions if torsion.kind in ("chi1", "chi3", "psi")]
    force = createStericExclusionForce(topology, torsions=torsions)
    drawn = rotamerDensities(topology, force, parts=False)
    assert [len(found) for found in drawn.torsions] == [2, 1, 2, 2]
    assert drawn.density[0] == drawn.density[2] != drawn.density[3]
    whole = rotamerDensities(topology, createStericExclusionForce(topology)).density[0].getRotamers()
    some = drawn.density[0].getRotamers()
    assert some[0].tolist() == whole[0].tolist() and some[1].tolist() == whole[1][:, [0, 2]].tolist()
    assert len(rotamerDensities(topology, force, selection="resname LYS", parts=False).torsions) == 2
    with pytest.raises(ValueError, match="no torsion of the StericExclusionForce is one of side chains in tables"):
        rotamerDensities(topology, force, selection="resname ALA")


def test_partsOfSideChains():
    """Runs of neighbours of a side chain have the density of the whole one, whatever its other torsions are."""
    topology = peptide("GLY", "LYS", "VAL", "GLU")
    force = createStericExclusionForce(topology)
    drawn = rotamerDensities(topology, force)
    lysine = rotamerDensities(topology, force, selection="resname LYS", parts=False).torsions[0]
    runs = [lysine[first:end] for first in range(4) for end in range(first + 1, 5)]
    assert sorted(drawn.torsions[:10]) == sorted(runs)
    assert [len(found) for found in drawn.torsions[10:]] == [1, 3, 2, 2, 1, 1, 1]
    whole = drawn.density[0].getRotamers()
    for found, density in zip(drawn.torsions[:10], drawn.density[:10], strict=True):
        weights, means, _ = density.getRotamers()
        columns = [lysine.index(torsion) for torsion in found]
        assert weights.tolist() == whole[0].tolist() and means.tolist() == whole[1][:, columns].tolist()
    # The end of a glutamic acid is as likely half a turn on, even alone.
    end = drawn.density[-1]
    assert end.evaluate([0.2]) == pytest.approx(end.evaluate([0.2 - np.pi]), rel=1e-9)


def test_torsionsTheOtherWayRound():
    # A torsion has the same value from either end; one about the same bond by other particles has another.
    topology = peptide("GLY", "VAL", "GLY")
    made = createStericExclusionForce(topology, torsions="chi1")
    particles = made.getTorsionParticles(0)
    (gamma,) = [atom.index for atom in topology.atoms() if atom.name == "CG2"]
    for defined, isFound in ((particles[::-1], True), ([*particles[:3], gamma], False)):
        force = StericExclusionForce()
        force.addTorsion(*defined)
        if isFound:
            assert rotamerDensities(topology, force).torsions == [(0,)]
        else:
            with pytest.raises(ValueError, match="no torsion"):
                rotamerDensities(topology, force)


def test_backbones():
    topology = peptide("ALA", "GLY", "PRO", "LYS", "PRO", "VAL")
    force = createStericExclusionForce(topology)
    drawn = ramachandranDensities(topology, force)
    kinds = [torsion.kind for torsion in findTorsions(topology).torsions]
    assert [[kinds[i] for i in found] for found in drawn.torsions] == [
        ["psi"], ["phi", "psi"], ["psi"], ["phi", "psi"], ["psi"], ["phi"],
    ]  # fmt: skip
    loops = loopCounts()
    expected = [
        loops["ALA"].sum(axis=0), loops["GLY"], loops["transPRO"].sum(axis=0), loops["prePRO"],
        loops["transPRO"].sum(axis=0), loops["VAL"].sum(axis=1),
    ]  # fmt: skip
    for density, counts in zip(drawn.density, expected, strict=True):
        assert density.getTable().tolist() == counts.tolist()
    with pytest.raises(ValueError, match="no torsion of the StericExclusionForce is one of backbones"):
        ramachandranDensities(topology, createStericExclusionForce(topology, torsions="chi"))


def test_mirroredAminoAcids():
    """They have the densities of the others, with all angles the other way round."""
    topology = peptide("GLY", "LYS", "GLY")
    usual, mirrored = [], []
    for densities, name in ((usual, "LYS"), (mirrored, "DLY")):
        list(topology.residues())[1].name = name
        force = createStericExclusionForce(topology)
        select = lambda atom: atom.residue.index == 1  # noqa: E731
        densities += rotamerDensities(topology, force, select, parts=False).density
        densities += ramachandranDensities(topology, force, select).density
    np.testing.assert_array_equal(usual[0].getRotamers()[1], -mirrored[0].getRotamers()[1])
    np.testing.assert_array_equal(usual[1].getTable(), mirrored[1].getTable()[::-1, ::-1])


def test_tables():
    # Facts that their papers state, or that everyone knows: a slip of columns or signs would show.
    rotamers, loops = rotamerTables(), loopCounts()
    assert set(rotamers) == set(_AMINO_ACIDS) - {"ALA", "GLY", "PRO"}
    assert set(loops) == (set(_AMINO_ACIDS) - {"PRO"}) | {"prePRO", "transPRO", "cisPRO"}
    counts, means, deviations = rotamers["LEU"]
    most = np.argsort(counts)[::-1][:2]
    assert means[most].tolist() == [[-66, 174], [-177, 63]] and 0.9 < counts[most].sum() / counts.sum() < 0.97
    for counts, means, deviations in rotamers.values():
        assert (
            (counts > 0).all() and (np.abs(means) <= 180).all() and (deviations > 0).all() and (deviations < 80).all()
        )
    for name, table in loops.items():
        assert table.shape == (30, 30) and table.sum() > 3000
        left = table[15:].sum() / table.sum()  # phi above 0
        assert left > 0.4 if name == "GLY" else left < 0.25
    phi, psi = np.unravel_index(loops["ALA"].argmax(), (30, 30))
    assert (-180 + 12 * phi, -180 + 12 * psi) in [(-72, 144), (-72, -36), (-72, 132), (-60, -36)]
