"""SampleReporter and the shapes that it writes, compared with MDTraj."""

import io

import mdtraj
import numpy as np
import openmm
import pytest
from openmm import app, unit
from openmmchaintree import SampleReporter, TorsionMonteCarloIntegrator, createStericExclusionForce
from openmmchaintree.shape import Shape
from peptides import makePeptides
from scenes import makeSystem
from scipy.spatial.distance import cdist

_HEADING = '#"Trial","Radius of Gyration (nm)","End-to-End Distance (nm)","RMSD (nm)","Acceptance (%)"\n'


def massesOf(topology):
    return np.array([atom.element.mass.value_in_unit(unit.dalton) for atom in topology.atoms()])


def wholeShape(topology, positions):
    return Shape(topology, positions, massesOf(topology), np.ones(len(positions), bool))


def sampling(structure, *moves, system=None):
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(1)
    for move in moves or (0.3,):
        integrator.addTorsionMove(1, move)
    force = createStericExclusionForce(structure.topology, structure.positions, system=system)
    if system is None:
        system = makeSystem(structure, force)
    else:
        system.addForce(force)
    simulation = app.Simulation(structure.topology, system, integrator, openmm.Platform.getPlatformByName("Reference"))
    simulation.context.setPositions(structure.positions)
    return simulation


def readLines(text):
    return np.genfromtxt(io.StringIO(text), delimiter=",", skip_header=1, ndmin=2)


def test_shapesAreMDTrajs(villin):
    shape = wholeShape(villin.topology, villin.positions)
    simulation = sampling(villin, 0.5)
    simulation.step(20)
    positions = simulation.context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)
    topology = mdtraj.Topology.from_openmm(villin.topology)
    frames = mdtraj.Trajectory(np.array([villin.positions, positions]), topology)
    trace = topology.select("name CA")
    values = shape.measure(positions)
    assert values.rmsd > 0.1
    assert values.rmsd == pytest.approx(mdtraj.rmsd(frames, frames, 0, atom_indices=trace)[1], rel=1e-4)
    masses = massesOf(villin.topology)
    squares = cdist(positions, positions, "sqeuclidean")
    assert values.radiusOfGyration == pytest.approx(np.sqrt(masses @ squares @ masses / 2) / masses.sum())
    distance = mdtraj.compute_distances(frames, [[trace[0], trace[-1]]])[1, 0]
    assert values.endToEndDistance == pytest.approx(distance, rel=1e-5)
    assert shape.measure(villin.positions).rmsd < 1e-12
    # A mirror image cannot be superposed.
    mirrored = villin.positions * [1, 1, -1]
    mirror = mdtraj.Trajectory(np.array([villin.positions, mirrored]), topology)
    expected = mdtraj.rmsd(mirror, mirror, 0, atom_indices=trace)[1]
    assert shape.measure(mirrored).rmsd == pytest.approx(expected, rel=1e-4)


def test_turnedAndShiftedAtTheStart(villin):
    shape = wholeShape(villin.topology, villin.positions)
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    values = shape.measure(villin.positions @ turn + 5)
    assert values.rmsd < 1e-12
    assert values.radiusOfGyration == pytest.approx(shape.measure(villin.positions).radiusOfGyration)


def test_aMoleculeWithoutAChain():
    """A dipeptide between caps has one Cα: the RMSD is that of its heavy atoms."""
    topology, positions = makePeptides(("ACE", "ALA", "NME"))
    shape = wholeShape(topology, positions)
    assert shape.ends is None and not shape.isTrace and len(shape.compared) == 10
    assert shape.measure(positions).endToEndDistance is None


def test_linesOfHardSpheres(villin, tmp_path):
    simulation = sampling(villin)
    simulation.reporters.append(SampleReporter(tmp_path / "run.csv", 2))
    simulation.step(6)
    text = (tmp_path / "run.csv").read_text()
    assert text.startswith(_HEADING)
    table = readLines(text)
    assert table[:, 0].tolist() == [200, 400, 600]
    assert np.all((table[:, -1] > 0) & (table[:, -1] < 100))
    move = simulation.integrator.getMoveStatistics(0)
    assert table[-1, -1] == 100 * move.accepted / move.attempted
    assert np.all(table[:, 3] > 0)


def test_energyAndChangedSteps(villin):
    system = app.ForceField("amber14-all.xml").createSystem(villin.topology)
    simulation = sampling(villin, system=system)
    simulation.integrator.setTrialsPerStep(10)
    file = io.StringIO()
    simulation.reporters.append(SampleReporter(file, 1, reference=villin.positions * unit.nanometer))
    simulation.step(2)
    simulation.integrator.setTrialsPerStep(30)
    simulation.step(1)
    assert file.getvalue().startswith('#"Trial","Potential Energy (kJ/mole)","Radius')
    table = readLines(file.getvalue())
    assert table[:, 0].tolist() == [10, 20, 50]
    assert table[-1, 1] == simulation.integrator.getPotentialEnergy(simulation.context)


def test_appending(villin, tmp_path):
    path = tmp_path / "run.csv"
    simulation = sampling(villin)
    for append in (False, True):
        simulation.reporters[:] = [SampleReporter(str(path), 1, append=append)]
        simulation.step(1)
    assert [line.split(",")[0] for line in path.read_text().splitlines()] == ['#"Trial"', "100", "200"]


def test_reportingChangesNothing(villin):
    final = []
    for reporters in ([], [SampleReporter(io.StringIO(), 1)]):
        simulation = sampling(villin)
        simulation.reporters += reporters
        simulation.step(5)
        final.append(simulation.context.getState(positions=True).getPositions(asNumpy=True))
    assert np.array_equal(final[0], final[1])


def test_badArguments(villin, tmp_path):
    with pytest.raises(ValueError, match="^reportInterval must be above 0, not 0$"):
        SampleReporter(tmp_path / "a.csv", 0)
    simulation = sampling(villin)
    simulation.reporters.append(SampleReporter(io.StringIO(), 1, reference=villin.positions[:5]))
    with pytest.raises(ValueError, match=r"^positions must have the shape \(582, 3\), not \(5, 3\)$"):
        simulation.step(1)
    dynamics = app.Simulation(villin.topology, makeSystem(villin), openmm.VerletIntegrator(0.001))
    dynamics.context.setPositions(villin.positions)
    dynamics.reporters.append(SampleReporter(io.StringIO(), 1))
    with pytest.raises(ValueError, match="^SampleReporter needs a TorsionMonteCarloIntegrator; for dynamics, use"):
        dynamics.step(1)
