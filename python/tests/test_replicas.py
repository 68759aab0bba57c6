"""The command openmm-chaintree sample with replicas: independent ones, and some that exchange temperatures."""

import json

import numpy as np
import openmm
import pytest
from commands import assertRefused, filesIn
from openmm import app, unit
from openmmchaintree import TorsionMonteCarloIntegrator, createStericExclusionForce
from openmmchaintree.command.outputs.indexfile import readIndex
from openmmchaintree.command.outputs.replicafiles import trajectoryNames
from openmmchaintree.command.plan import DEFAULT_KINDS, Choice
from openmmchaintree.command.sampling import Sampling
from openmmchaintree.replicas.segment import Segment, Stop, Workplace, makeModel
from openmmchaintree.structures.structure import readStructure
from scenes import DIPEPTIDE, GLYCINES, readDCD, writePDB, writeSmallStructures

PROTEIN = "amber14/protein.ff14SB.xml"
IN_FORCE_FIELD = ("dipeptide.pdb", "--forcefield", PROTEIN, "--seed", 5)


@pytest.fixture
def runHere(runCommandHere, tmp_path):
    writeSmallStructures(tmp_path)
    return lambda *arguments: runCommandHere("sample", *arguments)


def contents(folder, prefix):
    """Return all results of a run as bytes, without the dates in headers of trajectories."""
    found = {}
    for path in sorted(folder.glob(f"{prefix}-*.dcd")):
        found[path.name.removeprefix(prefix)] = path.read_bytes()[276:]
    found["index"] = (folder / f"{prefix}-index.csv").read_bytes()
    return found


def test_sameBitsWhateverTheWorkers(runHere, tmp_path):
    for workers in (1, 3):
        options = ("--replicas", 3, "--workers", workers, "--trials", 25000, "--frames", 7, "--seed", 3)
        result = runHere("run.pdb", *options, "-o", f"by{workers}", "--json", f"by{workers}.json")
        assert result.returncode == 0, result.stderr
    assert len(contents(tmp_path, "by1")) == 4
    assert contents(tmp_path, "by1") == contents(tmp_path, "by3")
    summaries = [json.loads((tmp_path / f"by{workers}.json").read_text()) for workers in (1, 3)]
    for key in ("moves", "ends", "temperatures"):
        assert summaries[0][key] == summaries[1][key]
    assert [summary["workers"] for summary in summaries] == [1, 3]


def test_files(runHere, tmp_path):
    result = runHere(
        "run.pdb", "--replicas", 2, "--trials", 1000, "--frames", 3, "--json", "a.json", "--notes", "n.txt"
    )
    assert result.returncode == 0 and result.stderr == ""
    replicas = ["run-replica-0.dcd", "run-replica-1.dcd"]
    others = ["a.json", "n.txt", "run-index.csv", "run-settings.toml", "run-topology.pdb", "run.checkpoint", "run.png"]
    assert filesIn(tmp_path) == sorted([*others, *replicas, "dipeptide.pdb", "run.pdb"])
    summary = json.loads((tmp_path / "a.json").read_text())
    assert {*summary["files"]} == {*others, *replicas} - {"a.json"}
    assert summary["trials"] == 1000 and summary["frames"] == 4 and summary["replicas"] == 2
    assert sum(move["attempted"] for move in summary["moves"]) == 2000
    assert summary["exchanges"] == [] and summary["roundTrips"] is None
    assert len({end["seed"] for end in summary["ends"]}) == 2
    assert "none beyond its limit" in result.stdout and "4 frames each, the first of them the start" in result.stdout
    frames = [readDCD(tmp_path / name) for name in replicas]
    assert np.array_equal(frames[0][0], frames[1][0])
    assert np.abs(frames[0][1] - frames[1][1]).max() > 0.001
    index = readIndex(tmp_path / "run-index.csv")
    assert index["frame"].tolist() == [0, 0, 1, 1, 2, 2, 3, 3] and index["replica"].tolist() == [0, 1] * 4
    assert index["trials"].tolist() == [0, 0, 334, 334, 668, 668, 1000, 1000]
    assert np.isnan(index["temperature"]).all() and np.isnan(index["potentialEnergy"]).all()
    masses = [
        a.element.mass.value_in_unit(unit.dalton) for a in app.PDBFile(str(tmp_path / "run.pdb")).topology.atoms()
    ]
    for frame, replica, radius in zip(index["frame"], index["replica"], index["radiusOfGyration"], strict=True):
        positions = frames[replica][frame]
        centred = positions - np.average(positions, axis=0, weights=masses)
        assert radius == pytest.approx(np.sqrt(np.average((centred**2).sum(axis=1), weights=masses)), abs=1e-6)


def test_oneReplicaOfMoreIsTheSame(runHere, tmp_path):
    """The first replicas of many are those of few: seeds do not depend on their number."""
    for count in (1, 3):
        assert runHere("run.pdb", "--replicas", count, "--trials", 500, "--seed", 8, "-o", f"of{count}").returncode == 0
    assert contents(tmp_path, "of1")["-replica-0.dcd"] == contents(tmp_path, "of3")["-replica-0.dcd"]


def test_roundsOfAnyLength(runHere, tmp_path):
    """Hard spheres go the same way, whenever they are looked at."""
    for trials in (700, 10000):
        options = ("--replicas", 2, "--trials", 3000, "--frames", 4, "--trials-per-round", trials, "--seed", 3)
        assert runHere("run.pdb", *options, "-o", f"by{trials}", "--json", f"{trials}.json").returncode == 0
        assert json.loads((tmp_path / f"{trials}.json").read_text())["trialsPerRound"] == trials
    assert contents(tmp_path, "by700") == contents(tmp_path, "by10000")


def test_aReplicaThatWasElsewhere(tmp_path):
    """A workplace that has a replica's Context takes up what another one has done with it since."""
    structure = readStructure(writePDB(tmp_path / "run.pdb", GLYCINES), 0)
    choice = Choice(tuple(DEFAULT_KINDS), None, None, False, False, False, False, ())
    sampling = Sampling(structure, 1, choice, None)  # whose Context has the System
    here, there = (Workplace(sampling.model()) for _ in range(2))

    def segment(round, checkpoint):
        return Segment(0, round, 7, 300.0, checkpoint, (Stop(100, True),))

    first = here.run(segment(0, None))
    second = there.run(segment(1, first.checkpoint))
    third, expected = (place.run(segment(2, second.checkpoint)) for place in (here, there))
    assert third.checkpoint == expected.checkpoint and len({first.checkpoint, second.checkpoint, third.checkpoint}) == 3
    assert np.array_equal(third.counts, expected.counts) and third.counts[:, 0].sum() == 100
    assert np.array_equal(third.frames[0].positions, expected.frames[0].positions)


# ---- Exchange ----


def test_exchange(runHere, tmp_path):
    options = ("--temperatures", "300:600:3", "--trials", 4000, "--frames", 11, "--trials-per-exchange", 500)
    for trajectories, workers in (("temperature", 1), ("replica", 2)):
        outputs = ("-o", trajectories, "--json", f"{trajectories}.json", "--trajectories", trajectories)
        result = runHere(*IN_FORCE_FIELD, *options, *outputs, "--workers", workers)
        assert result.returncode == 0, result.stderr
    assert "exchange the temperatures 300.0, 424.3, 600.0 K every 500 trials" in result.stdout
    index = readIndex(tmp_path / "temperature-index.csv")
    assert (tmp_path / "temperature-index.csv").read_bytes() == (tmp_path / "replica-index.csv").read_bytes()
    names = [f"temperature-{kelvin}K.dcd" for kelvin in ("300.0", "424.3", "600.0")]
    byTemperature = np.array([readDCD(tmp_path / name) for name in names])
    byReplica = np.array([readDCD(tmp_path / f"replica-replica-{replica}.dcd") for replica in range(3)])
    kelvins = np.unique(index["temperature"])
    assert kelvins == pytest.approx([300, 300 * np.sqrt(2), 600])
    rows = list(zip(*index.values(), strict=True))
    assert len(rows) == 3 * 12
    for frame, _, replica, kelvin, energy, *_ in rows:
        number = np.searchsorted(kelvins, kelvin)
        assert np.array_equal(byTemperature[number, frame], byReplica[replica, frame])
        assert energy == pytest.approx(energyByOpenMM(tmp_path, byReplica[replica, frame]), abs=0.2)
    for frame in range(12):
        assert np.unique(index["temperature"][index["frame"] == frame]).size == 3

    summary = json.loads((tmp_path / "temperature.json").read_text())
    assert [exchange["attempted"] for exchange in summary["exchanges"]] == [4, 4]
    assert sum(exchange["accepted"] for exchange in summary["exchanges"]) > 0
    assert {end["temperature"] for end in summary["ends"]} == {*kelvins}
    for kelvin, temperature in zip(kelvins, summary["temperatures"], strict=True):
        assert temperature["temperature"] == kelvin and temperature["frames"] == 11
        here = (index["temperature"] == kelvin) & (index["frame"] > 0)
        assert temperature["potentialEnergy"]["mean"] == pytest.approx(index["potentialEnergy"][here].mean())
        moves, outer = temperature["moves"], temperature["outerTests"]
        assert sum(move["attempted"] for move in moves) + outer["trialsTakenBack"] == 4000
    for end in summary["ends"]:
        assert end["potentialEnergyByOpenMM"] == pytest.approx(end["potentialEnergy"], abs=5e-3)
    assert (tmp_path / "temperature.png").read_bytes().startswith(b"\x89PNG")


def energyByOpenMM(folder, positions):
    if energyByOpenMM.context is None:
        topology = app.PDBFile(str(folder / "replica-topology.pdb")).topology
        system = app.ForceField(PROTEIN).createSystem(topology)
        platform = openmm.Platform.getPlatformByName("Reference")
        energyByOpenMM.context = openmm.Context(system, openmm.VerletIntegrator(0.001), platform)
    energyByOpenMM.context.setPositions(positions)
    return energyByOpenMM.context.getState(energy=True).getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)


energyByOpenMM.context = None


def test_energyOfASegment(tmp_path):
    """What decides exchanges is the energy where a segment ends."""
    pdb = app.PDBFile(str(writePDB(tmp_path / "dipeptide.pdb", DIPEPTIDE)))
    positions = pdb.getPositions(asNumpy=True).value_in_unit(unit.nanometer)
    system = app.ForceField(PROTEIN).createSystem(pdb.topology)
    system.addForce(createStericExclusionForce(pdb.topology, positions))
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.addTorsionMove(1, 0.5)
    model = makeModel(system, integrator, positions, "Reference", {}, True)
    result = Workplace(model).run(Segment(0, 0, 1, 300.0, None, (Stop(50, True), Stop(50, True), Stop(50, False))))
    middle, end = Workplace(model).run(Segment(0, 0, 1, 300.0, None, (Stop(100, True), Stop(50, True)))).frames
    assert result.frames[1].energy == middle.energy and result.energy == end.energy
    assert len({frame.energy for frame in (*result.frames, end)}) == 3


def test_namesOfTemperatures():
    assert trajectoryNames("a", 2, [300.0, 450.0], True) == ["a-300K.dcd", "a-450K.dcd"]
    assert trajectoryNames("a", 3, [300.0, 300.04, 300.06], True) == [
        f"a-300.{digits}K.dcd" for digits in ("00", "04", "06")
    ]
    assert trajectoryNames("a", 11, None, False)[::10] == ["a-replica-00.dcd", "a-replica-10.dcd"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--replicas", 0], "--replicas"),
        (["--workers", 2], "--workers needs --replicas or --temperatures"),
        (["--trajectories", "replica"], "--trajectories needs --replicas or --temperatures"),
        (["--trials-per-exchange", 2], "--trials-per-exchange needs --temperatures"),
        (
            ["--temperatures", "300:450:4", "--forcefield", PROTEIN, "--trials-per-round", 2],
            "--trials-per-round and --temperatures cannot be used together",
        ),
        (["--replicas", 2, "--trials-per-exchange", 2], "--trials-per-exchange needs --temperatures"),
        (["--replicas", 2, "--trajectories", "temperature"], "--trajectories temperature needs --temperatures"),
        (
            ["--temperatures", "300:450:4"],
            "--temperatures needs --forcefield or --system: hard spheres alone have no energy",
        ),
        (["--temperatures", "300:450", "--forcefield", PROTEIN], "--temperatures '300:450' is neither"),
        (
            ["--temperatures", "300:450:4", "--forcefield", PROTEIN, "--temperature", 300],
            "--temperature and --temperatures cannot be used together",
        ),
        (
            ["--temperatures", "300:450:4", "--forcefield", PROTEIN, "--replicas", 3],
            "--replicas 3: there is one replica for each of 4 temperatures",
        ),
    ],
)
def test_badArguments(runHere, tmp_path, arguments, words):
    assertRefused(runHere(*arguments), tmp_path, ["dipeptide.pdb", "run.pdb"], words)


def test_nothingIsOverwritten(runHere, tmp_path):
    for name in ("run-replica-1.dcd", "run-index.csv", "run.checkpoint", "run-settings.toml", "run.png"):
        (tmp_path / name).write_text("mine")
        files = sorted([name, "dipeptide.pdb", "run.pdb"])
        result = runHere("run.pdb", "--replicas", 2, "--trials", 10)
        assertRefused(result, tmp_path, files, f"{name}: exists; --overwrite replaces it")
        assert (tmp_path / name).read_text() == "mine"
        (tmp_path / name).unlink()
    (tmp_path / "run.checkpoint").write_text("mine")
    assert runHere("run.pdb", "--replicas", 2, "--trials", 10, "--overwrite").returncode == 0
