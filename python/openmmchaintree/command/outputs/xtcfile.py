"""Trajectories in XTC, whose coordinates are rounded to 0.001 nm and compressed."""

import os
import struct
import tempfile

import numpy as np
from openmm import unit
from openmm.app.internal.xtc_utils import read_xtc, xtc_write_frame

from ...errors import InputError
from .output import OutputError
from .trajectoryfile import TrajectoryFile

_MAGIC = 1995
_MOST_UNCOMPRESSED = 9  # atoms
_BEFORE_COORDINATES, _BEFORE_LENGTH = 56, 88  # bytes of a frame before its coordinates, or their compressed length
_LARGEST_STEP = 2**31 - 1  # the format's limit


class XTCFile(TrajectoryFile):
    """An XTC file. A frame's step, and its time in ps, are the number of trials before it, up to 2147483647."""

    # The greatest changes of torsion angles (rad) by rounding of coordinates.
    resolution = 0.05

    _header = b""

    def _prepare(self, topology, atoms, expectedFrames):
        vectors = topology.getPeriodicBoxVectors()
        self._box = np.zeros((3, 3), np.float32)
        if vectors is not None:
            self._box[:] = vectors.value_in_unit(unit.nanometer)
        self._start = struct.pack(">3if", _MAGIC, atoms, 0, 0.0)
        self._ends = []  # of frames, in bytes

    def _resumeFrames(self, output):
        if output.path.is_file():
            self._ends = _endsOfFrames(output.path, self.frames)
            if len(self._ends) < self.frames:
                raise InputError(f"{output.name}: is not the trajectory that the run has written")
        self.resume(output, self._ends[-1] if self._ends else 0, self._start, "trajectory")

    def _encode(self, positions):
        trials = self.frames * self.interval
        with tempfile.TemporaryDirectory() as folder:  # the writer takes a file's name
            path = os.path.join(folder, "frame.xtc")
            coordinates = positions.astype(np.float32)
            time, step = np.float32(trials), np.int32(min(trials, _LARGEST_STEP))
            xtc_write_frame(path.encode(), coordinates, self._box, time, step)
            with open(path, "rb") as file:
                content = file.read()
        if not content:
            raise OutputError(f"{self._output.name}: atoms are too far away for XTC")
        return content

    def _noteFrames(self, frames):
        del self._ends[frames - 1 :]
        self._ends.append(self.size)

    def _sizeOf(self, frames):
        return self._ends[frames - 1]

    @staticmethod
    def read(path, topology, frames, step):
        """Yield positions, as `readPositions` does."""
        ends = _endsOfFrames(path, frames)
        with open(path, "rb") as file, tempfile.TemporaryDirectory() as folder:
            for begin, end in list(zip([0, *ends], ends, strict=False))[::step]:
                file.seek(begin)
                with open(os.path.join(folder, "frame.xtc"), "wb") as frame:  # the reader takes a whole file
                    frame.write(file.read(end - begin))
                yield read_xtc(frame.name.encode())[0][:, :, 0].astype(float)


def isXTC(path):
    """Whether a file begins as XTC files do."""
    with open(path, "rb") as file:
        return file.read(4) == struct.pack(">i", _MAGIC)


def _endsOfFrames(path, count):
    """Return where the first `count` frames of an XTC file end, in bytes; fewer if it is damaged or has fewer."""
    ends, begin, size = [], 0, os.path.getsize(path)
    with open(path, "rb") as file:
        while len(ends) < count:
            file.seek(begin)
            header = file.read(_BEFORE_LENGTH + 4)
            if len(header) < _BEFORE_COORDINATES:
                break
            magic, atoms = struct.unpack(">2i", header[:8])
            if atoms <= _MOST_UNCOMPRESSED:
                length = _BEFORE_COORDINATES + 12 * atoms
            elif len(header) == _BEFORE_LENGTH + 4:
                (compressed,) = struct.unpack(">i", header[_BEFORE_LENGTH:])
                length = _BEFORE_LENGTH + 4 + 4 * -(-compressed // 4)
            else:
                break
            if magic != _MAGIC or length < _BEFORE_COORDINATES or begin + length > size:
                break
            begin += length
            ends.append(begin)
    return ends
