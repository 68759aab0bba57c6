"""The density of random coils as an energy, and as densities of drawn moves."""

import numpy as np
import openmm
import pytest
from openmm import unit
from openmmchaintree import (
    InputError,
    TorsionMonteCarloIntegrator,
    coilDensities,
    createCoilForce,
    createStericExclusionForce,
    findTorsions,
    rotamerDensities,
)
from openmmchaintree.densities import loopCounts
from openmmchaintree.densitymaps import binsOf, mapOf, smoothLogDensity
from peptides import makePeptides
from scenes import peptide

_FRAMES = 8000


def makeScene(*names):
    """Return the Topology of a peptide, a System with a coil's energy alone, its steric force, and positions."""
    topology, positions = makePeptides(names)
    system = openmm.System()
    for atom in topology.atoms():
        system.addParticle(atom.element.mass)
    system.addForce(createStericExclusionForce(topology, positions, radii=np.zeros(len(positions))))
    system.addForce(createCoilForce(topology, 300 * unit.kelvin, positions))
    return topology, system, system.getForce(0), positions


def contextOf(system, integrator, positions):
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(positions)
    return context


def test_torsionsHaveTheFrequenciesOfTheTables():
    topology, system, force, positions = makeScene("ACE", "ALA", "GLY", "DAL", "VAL", "PRO", "NME")
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(1)
    drawn = coilDensities(topology, force)
    move = integrator.addDrawnMove(1, *drawn)
    integrator.addDrawnMove(0.3, *rotamerDensities(topology, force))
    integrator.setTrialsPerStep(20)
    context = contextOf(system, integrator, positions)
    frames = []
    for _ in range(_FRAMES):
        integrator.step(1)
        frames.append(force.getTorsionAngles(context))
    statistics = integrator.getMoveStatistics(move)
    assert statistics.accepted > 0.9 * statistics.attempted
    angles, random = np.degrees(frames), np.random.default_rng(2)
    for torsions, kind in zip(drawn.torsions, ("ALA", "GLY", "ALA", "prePRO", "transPRO"), strict=True):
        counts = loopCounts()[kind]
        counts = counts[::-1, ::-1] if torsions == drawn.torsions[2] else counts
        counts = counts if len(torsions) == 2 else counts.sum(axis=0)
        density = 0.99 * counts / counts.sum() + 0.01 / counts.size
        found, _ = np.histogramdd(angles[:, torsions], [30] * len(torsions), [(-180, 180)] * len(torsions))
        noise = np.mean(
            [np.abs(random.multinomial(_FRAMES, density.ravel()) / _FRAMES - density.ravel()).sum() for _ in range(5)]
        )
        assert np.abs(found / _FRAMES - density).sum() < 1.25 * noise, kind


def test_energyIsThatOfTheDensity():
    """At angles between nodes, by a spline of another library."""
    interpolate = pytest.importorskip("scipy.interpolate")
    topology, system, force, positions = makeScene("ACE", "SER", "NME")
    logDensity = np.tile(smoothLogDensity(loopCounts()["SER"], 0.01), (3, 3))
    middles = np.arange(-540 + 6, 540, 12)
    spline = interpolate.RectBivariateSpline(middles, middles, logDensity)
    context = contextOf(system, TorsionMonteCarloIntegrator(300), positions)
    search = {torsion.kind: torsion.particles for torsion in findTorsions(topology).torsions}
    indices = [tuple(force.getTorsionParticles(i)) for i in range(force.getNumTorsions())]
    order = [indices.index(search[kind]) for kind in ("phi", "psi")]
    energies, expected = [], []
    for phi, psi in np.random.default_rng(3).uniform(-180, 180, (20, 2)):
        angles = force.getTorsionAngles(context)
        angles[order] = np.radians([phi, psi])
        force.setTorsionAngles(context, angles)
        energies.append(context.getState(energy=True).getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole))
        expected.append(-0.0083144626 * 300 * spline(phi, psi)[0, 0])
    assert np.diff(energies) == pytest.approx(np.diff(expected), abs=1e-4)  # apart from χ1, which stays


def test_meansOfBinsAreThoseOfTheCounts():
    for name, counts in loopCounts().items():
        found = binsOf(smoothLogDensity(counts, 0.01), 1)
        expected = 0.99 * counts / counts.mean() + 0.01
        assert np.abs(found - expected).mean() < 0.01, name
    one = smoothLogDensity([3, 0, 5, 1, 1, 1, 7], 0.1)
    assert mapOf(one)[::2] == pytest.approx(np.roll(one, -3)[: len(one)])  # an odd count: 0 is the center of a bin
    assert np.exp(mapOf(one)).min() > 0


def test_endsAndOtherResidues():
    force = createCoilForce(peptide("ALA", "ALA", "ALA"))
    sets = [force.getTorsionParameters(i)[1:] for i in range(force.getNumTorsions())]
    assert [one[:4] == one[4:] for one in sets] == [True, False, True]  # the ends have one torsion each
    assert force.getNumMaps() == 3
    assert createCoilForce(peptide("ALA", "LYS", "ALA"), sideChains=False).getNumTorsions() == 3
    assert createCoilForce(peptide("ALA", "LYS", "ALA")).getNumTorsions() == 5
    assert createCoilForce(peptide("ALA", "GLU", "ALA"), selection=[6]).getNumTorsions() == 1  # φ alone, by CA
    with pytest.raises(ValueError, match="no torsion is one of amino acids"):
        createCoilForce(peptide("GLY"))
    with pytest.raises(InputError, match="temperature must be above 0"):
        createCoilForce(peptide("ALA", "ALA"), temperature=0)


def test_tablesOfTheUser(tmp_path):
    topology = peptide("ALA", "ALA", "GLY", "ALA")
    force = createStericExclusionForce(topology)
    peak = np.zeros((12, 12))
    peak[3, 8] = 1

    def peaksOf(tables):
        drawn = coilDensities(topology, force, tables=tables)
        found = []
        for density in drawn.density:
            table = density.getTable()
            middle = (np.array(np.unravel_index(table.argmax(), table.shape)) + 0.5) * 360 / len(table) - 180
            found.append(tuple((middle + 180) // 30))
        return found

    assert peaksOf({"ALA": peak})[1] == (3, 8)
    assert peaksOf({"ALA-GLY": peak})[1] == (3, 8) != peaksOf({"ALA-ALA": peak})[1]
    path = tmp_path / "own.csv"
    lines = [f"ALA-GLY,{30 * row - 180},{' '.join(map(str, counts))}" for row, counts in enumerate(peak)]
    path.write_text("# mine\nresidue,phi,counts\n" + "\n".join(lines[::-1]) + "\n", encoding="utf-8")
    assert peaksOf(path)[1] == (3, 8)
    for text, message in (
        ("", "holds no table"),
        ("residue,phi,counts\nALA,1\n", "no table with the columns"),
        ("residue,phi,counts\nALA,x,1 2\n", "no table with the columns"),
        ("residue,phi,counts\nALA,-180,1 2 3\n", "ALA must have as many columns as rows"),
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match=message):
            createCoilForce(topology, tables=path)
    path.write_bytes(bytes(range(256)))
    with pytest.raises(InputError, match=r"own\.csv: is no table"):
        createCoilForce(topology, tables=str(path))
    with pytest.raises(InputError, match="No such file"):
        createCoilForce(topology, tables=tmp_path / "none.csv")
    for table in (np.zeros((12, 12)), -peak, np.full((12, 12), np.nan)):
        with pytest.raises(InputError, match="one above 0"):
            createCoilForce(topology, tables={"GLY": table})
