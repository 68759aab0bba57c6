"""ClashReporter, beside OpenMM's own reporters."""

import csv
import io

import numpy as np
import openmm
import pytest
from openmm import app, unit
from openmmchaintree import (
    ClashError,
    ClashReporter,
    TorsionMonteCarloIntegrator,
    createStericExclusionForce,
)
from openmmchaintree.command.allpairs import HardSpheres
from scenes import makeSystem, readDCD

_HEADING = "step,time_ps,clashes,worst_overlap_nm,atom1,atom2"


def simulationOf(structure, system, integrator):
    platform = openmm.Platform.getPlatformByName("Reference")
    simulation = app.Simulation(structure.topology, system, integrator, platform)
    simulation.context.setPositions(structure.positions)
    return simulation


def stericSimulation(villin, integrator, tolerance=0.04):
    force = createStericExclusionForce(villin.topology, villin.positions)
    force.setOverlapTolerance(tolerance)
    return force, simulationOf(villin, makeSystem(villin, force), integrator)


def linesOf(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def namesOf(topology):
    return [f"{atom.residue.name} {atom.residue.id} {atom.name}" for atom in topology.atoms()]


def assertSame(line, overlaps, topology):
    """Compare a line with Overlaps that were found without the engine."""
    assert int(line["clashes"]) == len(overlaps.pairs)
    if len(overlaps.pairs) == 0:
        assert [line["worst_overlap_nm"], line["atom1"], line["atom2"]] == ["", "", ""]
        return
    worst = np.argmax(overlaps.overlaps)
    names = namesOf(topology)
    assert [line["atom1"], line["atom2"]] == [names[particle] for particle in overlaps.pairs[worst]]
    assert float(line["worst_overlap_nm"]) == pytest.approx(overlaps.overlaps[worst], abs=1e-6)


def amber(villin):
    forceField = app.ForceField("amber14-all.xml", "implicit/gbn2.xml")
    return forceField.createSystem(villin.topology, constraints=app.HBonds)


class KeepPositions:
    """A reporter that keeps the positions of its steps."""

    def __init__(self, interval):
        self.positions = {}
        self._interval = interval

    def describeNextReport(self, simulation):
        steps = self._interval - simulation.currentStep % self._interval
        return {"steps": steps, "periodic": False, "include": ["positions"]}

    def report(self, simulation, state):
        positions = state.getPositions(asNumpy=True).value_in_unit(unit.nanometer)
        self.positions[simulation.currentStep] = np.array(positions)


# ---- What is written ----


def test_dynamicsWithoutAStericForce(villin, tmp_path):
    """The reporter brings the spheres, and the System stays as it is."""
    system = amber(villin)
    forces = system.getNumForces()
    integrator = openmm.LangevinMiddleIntegrator(300, 1, 0.002)
    integrator.setRandomNumberSeed(1)
    simulation = simulationOf(villin, system, integrator)
    simulation.context.setVelocitiesToTemperature(300, 1)
    kept = KeepPositions(5)
    simulation.reporters += [ClashReporter(tmp_path / "clashes.csv", 5), kept]
    simulation.step(20)
    assert (tmp_path / "clashes.csv").read_text().startswith(_HEADING + "\n5,0.01,")
    lines = linesOf(tmp_path / "clashes.csv")
    assert [line["step"] for line in lines] == ["5", "10", "15", "20"]
    assert [line["time_ps"] for line in lines] == ["0.01", "0.02", "0.03", "0.04"]
    spheres = HardSpheres(createStericExclusionForce(villin.topology, villin.positions))
    for line in lines:
        assertSame(line, spheres.overlaps(kept.positions[int(line["step"])]), villin.topology)
    assert any(int(line["clashes"]) > 0 for line in lines)
    assert system.getNumForces() == forces


def test_dynamicsWithTheSystemsForce(villin, tmp_path):
    """Its tolerance counts."""
    force, simulation = stericSimulation(villin, openmm.VerletIntegrator(0.0005), tolerance=0.01)
    kept = KeepPositions(10)
    simulation.reporters += [ClashReporter(str(tmp_path / "clashes.csv"), 10), kept]
    simulation.step(30)
    lines = linesOf(tmp_path / "clashes.csv")
    assert len(lines) == 3 and int(lines[0]["clashes"]) > 10
    spheres = HardSpheres(force)
    for line in lines:
        assertSame(line, spheres.overlaps(kept.positions[int(line["step"])]), villin.topology)


def test_torsionMonteCarlo(villin, tmp_path):
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(1)
    integrator.addTorsionMove(1, 0.3)
    _, simulation = stericSimulation(villin, integrator)
    kept = KeepPositions(1)
    simulation.reporters += [ClashReporter(tmp_path / "clashes.csv", 1), kept]
    simulation.step(20)
    lines = linesOf(tmp_path / "clashes.csv")
    assert len(lines) == 20
    # Villin starts with one clash, which is tolerated, and never gets another.
    assert {int(line["clashes"]) for line in lines} <= {0, 1}
    assert not np.array_equal(kept.positions[1], kept.positions[20])


def test_reportingChangesNothing(villin, tmp_path):
    """The same seed, with and without the reporter: the same trajectory."""
    final = []
    for reporters in ([], [ClashReporter(tmp_path / "clashes.csv", 1)]):
        integrator = TorsionMonteCarloIntegrator(300)
        integrator.setRandomNumberSeed(1)
        integrator.addTorsionMove(1, 0.3)
        _, simulation = stericSimulation(villin, integrator)
        simulation.reporters += reporters
        simulation.step(10)
        final.append(simulation.context.getState(positions=True).getPositions(asNumpy=True))
    assert np.array_equal(final[0], final[1])


def test_noClash(villin, tmp_path):
    _, simulation = stericSimulation(villin, openmm.VerletIntegrator(0.0001), tolerance=0.1)
    simulation.reporters.append(ClashReporter(tmp_path / "clashes.csv", 1, maxOverlap=0))
    simulation.step(1)
    assert (tmp_path / "clashes.csv").read_text() == _HEADING + "\n1,0.0001,0,,,\n"


def test_openFileAndAppending(villin, tmp_path):
    _, simulation = stericSimulation(villin, openmm.VerletIntegrator(0.0001))
    file = io.StringIO()
    path = tmp_path / "clashes.csv"
    simulation.reporters += [ClashReporter(file, 1), ClashReporter(path, 1)]
    simulation.step(1)
    simulation.reporters[:] = [ClashReporter(path, 1, append=True)]
    simulation.step(1)
    assert path.read_text().startswith(file.getvalue())
    assert [line.split(",")[0] for line in path.read_text().splitlines()] == ["step", "1", "2"]
    simulation.reporters[:] = [ClashReporter(tmp_path / "new.csv", 1, append=True)]
    assert (tmp_path / "new.csv").exists()
    simulation.step(1)
    assert (tmp_path / "new.csv").read_text().startswith(_HEADING)


def test_linesAreWrittenAtOnce(villin, tmp_path):
    """Every line is in the file as soon as it is written."""
    _, simulation = stericSimulation(villin, openmm.VerletIntegrator(0.0001))
    simulation.reporters.append(ClashReporter(tmp_path / "clashes.csv", 1))
    for count in (1, 2, 3):
        simulation.step(1)
        assert len(linesOf(tmp_path / "clashes.csv")) == count


# ---- Ending a run ----


def test_dynamicsEndsAtAClash(villin, tmp_path):
    """Without a force that holds the atoms apart, spheres that fly about meet."""
    simulation = simulationOf(villin, makeSystem(villin), openmm.VerletIntegrator(0.002))
    simulation.context.setVelocitiesToTemperature(300, 1)
    dcd = app.DCDReporter(str(tmp_path / "run.dcd"), 10)
    simulation.reporters += [dcd, ClashReporter(tmp_path / "clashes.csv", 10, maxOverlap=0.8 * unit.angstrom)]
    with pytest.raises(ClashError) as caught:
        simulation.step(100000)
    error = caught.value
    lines = linesOf(tmp_path / "clashes.csv")
    assert all(float(line["worst_overlap_nm"]) <= 0.08 for line in lines[:-1])
    last = lines[-1]
    assert float(last["worst_overlap_nm"]) > 0.08
    assert str(error) == (
        f"step {last['step']}: {last['atom1']} and {last['atom2']} overlap by {error.clash.overlap:.4f} nm, more than "
        "the 0.08 nm that ClashReporter is to stop at"
    )
    assert error.step == simulation.currentStep == int(last["step"])
    assert isinstance(error, openmm.OpenMMException)
    assert len(readDCD(tmp_path / "run.dcd")) == len(lines)


def test_torsionMonteCarloEndsAtAClash(villin, tmp_path):
    """The sampler tolerates clashes that it starts with; the reporter need not."""
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(1)
    integrator.addTorsionMove(1, 0.3)
    _, simulation = stericSimulation(villin, integrator)
    simulation.reporters.append(ClashReporter(tmp_path / "clashes.csv", 1, maxOverlap=0.1))
    simulation.step(5)
    simulation.context.setPositions(0.5 * villin.positions)
    with pytest.raises(ClashError, match=r"^step 6: \w+ \d+ \w+ and \w+ \d+ \w+ overlap by 0\.\d{4} nm"):
        simulation.step(5)


# ---- Bad input ----


def test_badArguments(villin, tmp_path):
    with pytest.raises(ValueError, match="^reportInterval must be above 0, not 0$"):
        ClashReporter(tmp_path / "a.csv", 0)
    with pytest.raises(ValueError, match="^maxOverlap must be at least 0, not -1$"):
        ClashReporter(tmp_path / "a.csv", 1, maxOverlap=-1)
    with pytest.raises(TypeError, match="^maxOverlap must be a length"):
        ClashReporter(tmp_path / "a.csv", 1, maxOverlap=1 * unit.kelvin)
    assert not (tmp_path / "a.csv").exists()
    with pytest.raises(FileNotFoundError):
        ClashReporter(tmp_path / "missing" / "a.csv", 1)


def test_twoForces(villin, tmp_path):
    system = makeSystem(villin, *[createStericExclusionForce(villin.topology) for _ in range(2)])
    simulation = simulationOf(villin, system, openmm.VerletIntegrator(0.001))
    simulation.reporters.append(ClashReporter(tmp_path / "a.csv", 1))
    with pytest.raises(ValueError, match="^the System has more than one StericExclusionForce$"):
        simulation.step(1)
