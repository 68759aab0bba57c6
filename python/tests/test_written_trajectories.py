"""Trajectories of `sample` in DCD and XTC, as MDTraj and MDAnalysis read them, also after a run was resumed."""

import json
import warnings

import mdtraj
import numpy as np
import pytest
from commands import assertRefused, filesIn
from mdtraj.formats import XTCTrajectoryFile
from openmm import app
from openmmchaintree.command.outputs.output import Output
from openmmchaintree.command.outputs.trajectories import FORMATS, readPositions
from scenes import writeSmallStructures

_OPTIONS = ("run.pdb", "--trials", 1200, "--frames", 4, "--seed", 3)


@pytest.fixture
def runHere(runCommandHere, tmp_path):
    writeSmallStructures(tmp_path)
    return lambda *arguments: runCommandHere("sample", *arguments)


@pytest.fixture
def frames(runHere, tmp_path):
    """Run in both formats; return the frames as MDTraj reads them."""
    for form in FORMATS:
        result = runHere(*_OPTIONS, "--format", form, "-o", form, "--json", f"{form}.json")
        assert result.returncode == 0, result.stderr
    return {form: mdtraj.load(tmp_path / f"{form}.{form}", top=tmp_path / f"{form}-topology.pdb") for form in FORMATS}


def test_mdtraj(frames, tmp_path):
    dcd, xtc = frames["dcd"], frames["xtc"]
    assert dcd.n_frames == xtc.n_frames == 5 and dcd.n_atoms == xtc.n_atoms == 8
    assert xtc.xyz == pytest.approx(dcd.xyz, abs=6e-4) and np.abs(dcd.xyz[4] - dcd.xyz[1]).max() > 0.01
    with XTCTrajectoryFile(str(tmp_path / "xtc.xtc")) as file:
        _, times, steps, _ = file.read()
    assert times.tolist() == steps.tolist() == [0, 300, 600, 900, 1200]  # trials
    assert (tmp_path / "dcd.csv").read_bytes() == (tmp_path / "xtc.csv").read_bytes()
    found = [json.loads((tmp_path / f"{form}.json").read_text())["estimates"][0] for form in FORMATS]
    assert found[0]["observables"] == found[1]["observables"]


def test_mdanalysis(frames, tmp_path):
    analysis = pytest.importorskip("MDAnalysis")
    for form in FORMATS:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            universe = analysis.Universe(str(tmp_path / f"{form}-topology.pdb"), str(tmp_path / f"{form}.{form}"))
            found = [(frame.time, frame.positions.copy()) for frame in universe.trajectory]
        assert [time for time, _ in found] == pytest.approx([0, 300, 600, 900, 1200])
        assert np.array([positions for _, positions in found]) == pytest.approx(10 * frames[form].xyz, abs=1e-4)
        assert universe.select_atoms("name CA").n_atoms == 2


def test_resumedXTC(runHere, tmp_path):
    """A run that is extended, of replicas with an odd interval between frames, writes what a longer run writes."""
    options = ("run.pdb", "--replicas", 2, "--frames", 30, "--trials-per-round", 100, "--seed", 3, "--format", "xtc")
    assert runHere(*options, "--trials", 6000, "-o", "whole", "--json", "whole.json").returncode == 0
    options = (*options[:4], 10, *options[5:])
    assert runHere(*options, "--trials", 2000, "-o", "cut", "--json", "cut.json").returncode == 0
    with open(tmp_path / "cut-replica-0.xtc", "ab") as file:
        file.write(b"the beginning of a frame that a kill has cut")
    result = runHere("--resume", "cut.checkpoint", "--trials", 6000)
    assert result.returncode == 0, result.stderr
    for replica in range(2):
        whole, cut = (tmp_path / f"{prefix}-replica-{replica}.xtc" for prefix in ("whole", "cut"))
        assert whole.read_bytes() == cut.read_bytes()
    assert (tmp_path / "whole-index.csv").read_bytes() == (tmp_path / "cut-index.csv").read_bytes()
    estimates = [json.loads((tmp_path / f"{prefix}.json").read_text())["estimates"] for prefix in ("whole", "cut")]
    assert estimates[0] == estimates[1]


@pytest.mark.parametrize("change", ["shorter", "other"])
def test_anotherXTCIsNotResumed(runHere, tmp_path, change):
    options = ("run.pdb", "--trials", 2000, "--frames", 10, "--trials-per-round", 500, "--seed", 3)
    assert runHere(*options, "--format", "xtc").returncode == 0
    path = tmp_path / "run.xtc"
    content = path.read_bytes()
    path.write_bytes(content[:-1] if change == "shorter" else bytes(len(content)))
    before = filesIn(tmp_path)
    result = runHere("--resume", "run.checkpoint", "--trials", 4000)
    assertRefused(result, tmp_path, before, "run.xtc: is not the trajectory that the run has written")


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("atoms", [8, 20])
def test_framesAreReadBack(tmp_path, form, atoms):
    """With few atoms XTC does not compress. Names need not be ASCII."""
    topology = app.Topology()
    residue = topology.addResidue("ALA", topology.addChain())
    for _ in range(atoms):
        topology.addAtom("CA", None, residue)
    positions = 3 * np.random.default_rng(1).random((7, atoms, 3))
    output = Output(str(tmp_path / f"é 1.{form}"))
    with FORMATS[form](output, topology, positions[0], 10, 7) as trajectory:
        for frame in positions[1:]:
            trajectory.write(frame)
        trajectory.shorten(6)
        found = np.array(list(readPositions(output.path, topology, 7)))
        assert found == pytest.approx(positions, abs=6e-4)
    assert np.array(list(readPositions(output.path, topology, 6, 2))) == pytest.approx(positions[:6:2], abs=6e-4)
    with FORMATS[form](Output(output.name, True), topology, positions[0], 10, 7, 4) as trajectory:
        trajectory.write(positions[6])
    expected = [*positions[:4], positions[6]]
    assert np.array(list(readPositions(output.path, topology, 5))) == pytest.approx(np.array(expected), abs=6e-4)


def test_unknownFormat(runHere, tmp_path):
    assertRefused(runHere("run.pdb", "--format", "trr"), tmp_path, ["dipeptide.pdb", "run.pdb"], "--format", "trr")
