"""Trajectories in DCD, whose frames have single precision."""

import io
import os
import struct

import numpy as np
import openmm.app
from openmm import unit

from .trajectoryfile import TrajectoryFile

# Positions in the DCD header of fields that each frame changes: the number of frames, the step of the last one.
_FRAME_COUNT, _LAST_STEP = 8, 20

# The title line with the date, the only part of the header that differs between equal runs.
_TITLE, _TITLE_LENGTH = 180, 80
TITLE = slice(_TITLE, _TITLE + _TITLE_LENGTH)

_LARGEST_STEP = 2**31 - 1  # the format's limit


def _trialsOfAStep(interval, expectedFrames):
    """Return the number of trials per step in a trajectory: 1, or more if the format cannot hold that many steps."""
    return 1 if interval * expectedFrames <= _LARGEST_STEP else interval


class DCDFile(TrajectoryFile):
    """A DCD file. Trials have no time: a frame's step is the number of trials before it, at 1 ps each."""

    # The greatest changes of torsion angles (rad) by rounding of coordinates.
    resolution = 1e-3

    def _prepare(self, topology, atoms, expectedFrames):
        self._step = _trialsOfAStep(self.interval, expectedFrames)
        self._cell = _unitCell(topology)
        self._frameSize = len(self._cell) + 3 * (4 * atoms + 8)
        self._header = _makeHeader(topology, self.interval, self._step)
        # Of a run whose trials the format could hold, or not, unlike those of this one.
        other = self.interval if self._step == 1 or self.interval > _LARGEST_STEP else 1
        self._former = _withoutCounts(_makeHeader(topology, self.interval, other))

    def _resumeFrames(self, output):
        def normalize(data):
            kept = _withoutCounts(data)
            return _withoutCounts(self._header) if kept == self._former else kept

        self.resume(output, self._sizeOf(self.frames), self._header, "trajectory", normalize)
        try:
            self.replace(0, self._header[:_TITLE])
            self._noteFrames(self.frames)
        except BaseException:
            self.close()
            raise

    def _encode(self, positions):
        axes = np.zeros(3, [("before", "<i4"), ("values", "<f4", len(positions)), ("after", "<i4")])
        axes["before"] = axes["after"] = 4 * len(positions)
        axes["values"] = 10 * positions.T
        return self._cell + axes.tobytes()

    def _noteFrames(self, frames):
        """Write the number of frames into the header."""
        self.replace(_FRAME_COUNT, struct.pack("<i", frames))
        self.replace(_LAST_STEP, struct.pack("<i", (frames - 1) * (self.interval // self._step)))

    def _sizeOf(self, frames):
        return len(self._header) + frames * self._frameSize

    @staticmethod
    def read(path, topology, frames, step):
        """Yield positions, as `readPositions` does."""
        axis = [("before", "<i4"), ("values", "<f4", topology.getNumAtoms()), ("after", "<i4")]
        frame = np.dtype([("cell", f"V{len(_unitCell(topology))}"), ("axes", axis, 3)])
        begin = os.path.getsize(path) - frames * frame.itemsize
        for found in np.memmap(path, frame, mode="r", offset=begin, shape=frames)[::step]:
            yield 0.1 * found["axes"]["values"].T.astype(float)


def _unitCell(topology):
    """Return the record of the periodic box of a Topology in a frame; nothing without a box."""
    vectors = topology.getPeriodicBoxVectors()
    if vectors is None:
        return b""
    a, b, c, alpha, beta, gamma = openmm.app.internal.unitcell.computeLengthsAndAngles(vectors)
    cosines = np.cos([gamma, beta, alpha])
    return struct.pack("<i6di", 48, 10 * a, cosines[0], 10 * b, cosines[1], cosines[2], 10 * c, 48)


def _makeHeader(topology, interval, step):
    """Return the header of a DCD file without frames; step : trials per step."""
    header = io.BytesIO()
    openmm.app.DCDFile(header, topology, step * unit.picosecond, 0, interval // step)
    return header.getvalue()


def _withoutCounts(header):
    """Return the header of a DCD file without the fields that each frame changes and without its date."""
    kept = bytearray(header)
    for begin, length in ((_FRAME_COUNT, 4), (_LAST_STEP, 4), (_TITLE, _TITLE_LENGTH)):
        kept[begin : begin + length] = bytes(length)
    return kept
