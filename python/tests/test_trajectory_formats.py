"""TRR, NetCDF and HDF5 trajectories have the clashes of the same frames as DCD, and damage in them is told."""

import os

import h5py
import numpy as np
import pytest
from mdtraj.formats import DCDTrajectoryFile, NetCDFTrajectoryFile, TRRTrajectoryFile
from openmmchaintree import InputError
from openmmchaintree.structures.clashsearch import ClashSearch

pytestmark = pytest.mark.filterwarnings("ignore:Warning. The 'netCDF4' Python package")

_ANGLES = [[90, 90, 90]]


def writeFrames(path, frames, box=None):
    """Write positions (nm) in the format that the suffix names, with a cubic or no box; return the path."""
    frames = np.array(frames, dtype=np.float32)
    boxes = None if box is None else np.tile(np.float32([box] * 3), (len(frames), 1))
    angles = None if box is None else np.tile(np.float32(_ANGLES), (len(frames), 1))
    if path.suffix == ".trr":
        with TRRTrajectoryFile(str(path), "w") as file:
            file.write(
                frames, box=None if box is None else np.tile(box * np.eye(3, dtype=np.float32), (len(frames), 1, 1))
            )
    elif path.suffix == ".h5":
        with h5py.File(path, "w") as file:
            file["coordinates"] = frames
            if box is not None:
                file["cell_lengths"], file["cell_angles"] = boxes, angles
    else:
        Writer = {".dcd": DCDTrajectoryFile, ".nc": NetCDFTrajectoryFile}[path.suffix]
        with Writer(str(path), "w") as file:
            file.write(10 * frames, cell_lengths=None if box is None else 10 * boxes, cell_angles=angles)
    return path


@pytest.fixture(scope="module")
def frames(villin):
    """Villin as it shrinks."""
    return [villin.positions * scale for scale in (1, 0.97, 0.94, 0.91)]


def clashesOf(structure, trajectory, **options):
    return [
        {(clash.particle1, clash.particle2): clash.overlap for clash in frame.clashes}
        for frame in ClashSearch(structure, trajectory, **options)
    ]


@pytest.mark.parametrize("suffix", ["trr", "nc", "h5"])
@pytest.mark.parametrize("box", [None, 2.7])
def test_sameClashesAsInDCD(tmp_path, structure, frames, suffix, box):
    expected = clashesOf(structure, writeFrames(tmp_path / "a.dcd", frames, box), periodic=box is not None)
    found = clashesOf(structure, writeFrames(tmp_path / f"a.{suffix}", frames, box), periodic=box is not None)
    assert len(found) == 4 and len(found[0]) < len(found[3])
    for ours, theirs in zip(found, expected, strict=True):
        # DCD holds ångström in single precision; an overlap within its rounding of the tolerance may differ.
        assert all(
            abs(overlap - 0.04) < 1e-6
            for pair in ours.keys() ^ theirs.keys()
            for overlap in [ours.get(pair, theirs.get(pair))]
        )
        assert all(ours[pair] == pytest.approx(theirs[pair], abs=2e-6) for pair in ours.keys() & theirs.keys())


@pytest.mark.parametrize("suffix", ["trr", "nc", "h5"])
def test_chunks(tmp_path, structure, frames, suffix):
    """A search may begin at any frame."""
    search = ClashSearch(structure, writeFrames(tmp_path / f"a.{suffix}", frames))
    whole = [len(frame.pairs) for frame in search.overlaps()]
    assert search.frameCount == 4
    for begin, end in ((2, 4), (0, 1), (3, 4), (1, 3)):
        part = list(search.overlaps(begin, end))
        assert [frame.number for frame in part] == list(range(begin, end))
        assert [len(frame.pairs) for frame in part] == whole[begin:end]
    search.close()


@pytest.mark.parametrize("suffix", ["trr", "nc", "h5"])
def test_otherAtoms(tmp_path, structure, frames, suffix):
    path = writeFrames(tmp_path / f"a.{suffix}", [frame[:-1] for frame in frames])
    with pytest.raises(InputError, match=f"a.{suffix}: has 581 atoms, but .*villin.pdb has 582"):
        list(ClashSearch(structure, path))


@pytest.mark.parametrize("suffix", ["nc", "h5"])
@pytest.mark.parametrize("kept", [0.001, 0.3, 0.999])
def test_truncated(tmp_path, structure, frames, suffix, kept):
    """These formats tell the number of frames first, so that the readers refuse what is incomplete."""
    path = writeFrames(tmp_path / f"a.{suffix}", frames)
    os.truncate(path, int(kept * path.stat().st_size))
    kind = {"nc": "a NetCDF", "h5": "an HDF5"}[suffix]
    with pytest.raises(InputError, match=f"a.{suffix}: not {kind} file, or damaged at its start"):
        list(ClashSearch(structure, path))


def test_truncatedTRR(tmp_path, structure, frames):
    path = writeFrames(tmp_path / "a.trr", frames)
    os.truncate(path, int(0.6 * path.stat().st_size))
    found = []
    with pytest.raises(InputError, match=r"a.trr: frame 2 \(from 0\) is damaged"):
        found.extend(ClashSearch(structure, path))
    assert len(found) == 2


def test_TRRWithoutPositions(tmp_path, structure, frames):
    """GROMACS may write velocities alone, at which MDTraj returns what was in its memory."""
    path = writeFrames(tmp_path / "a.trr", frames, box=4)
    data = bytearray(path.read_bytes())
    place = 2 * (len(data) // 4) + data.index(b"GMX_trn_file") + 12 + 4 * 7
    data[place : place + 8] = data[place + 4 : place + 8] + data[place : place + 4]
    path.write_bytes(data)
    found = []
    with pytest.raises(InputError, match=r"a.trr: frame 2 \(from 0\) has no positions"):
        found.extend(ClashSearch(structure, path))
    assert len(found) == 2
    search = ClashSearch(structure, path)
    with pytest.raises(InputError, match=r"a.trr: frame 2 \(from 0\) has no positions"):
        list(search.overlaps(2, 4))
    assert [frame.number for frame in ClashSearch(structure, path).overlaps(3, 4)] == [3]


@pytest.mark.parametrize("suffix", ["nc", "h5"])
def test_noFrames(tmp_path, structure, frames, suffix):
    path = writeFrames(tmp_path / f"a.{suffix}", np.empty((0, 582, 3)))
    with pytest.raises(InputError, match=f"a.{suffix}: (there are no frames|not )"):
        list(ClashSearch(structure, path))


def test_otherHDF5(tmp_path, structure):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["coordinates"] = np.zeros(3)
    with pytest.raises(InputError, match="a.h5: not an HDF5 file, or damaged at its start"):
        list(ClashSearch(structure, tmp_path / "a.h5"))
