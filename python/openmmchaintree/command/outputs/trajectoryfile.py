"""Writes a trajectory (DCD) that is valid after every frame, however the run ends."""

import io
import os
import struct

import numpy as np
import openmm.app
from openmm import unit

from ...notes import countOf
from .growingfile import GrowingFile
from .output import OutputError

# Positions in the DCD header of fields that each frame changes: the number of frames, the step of the last one.
_FRAME_COUNT, _LAST_STEP = 8, 20

# The title line with the date.
_TITLE, _TITLE_LENGTH = 180, 80

_LARGEST_STEP = 2**31 - 1  # the format's limit


def _trialsOfAStep(interval, expectedFrames):
    """Return the number of trials per step in a trajectory: 1, or more if the format cannot hold that many steps."""
    return 1 if interval * expectedFrames <= _LARGEST_STEP else interval


class TrajectoryFile(GrowingFile):
    """A DCD file, to which `write` adds a frame.

    Trials have no time: a frame's step is the number of trials before it, at 1 ps each.

    Attributes
    ----------
    interval : int
        the number of trials between frames
    frames : int
        the number of frames in the file
    """

    def __init__(self, output, topology, positions, interval, expectedFrames, framesThere=0):
        """Begin the file of an Output with the initial positions; frames follow every `interval` trials.

        Or resume a file that this class has written: keep its first `framesThere` frames and remove the rest.

        Raises
        ------
        InputError
            if the file to resume is not the file that was written, or has fewer frames
        OutputError
            if the file cannot be written
        """
        self.frames = framesThere
        self._expectedFrames = expectedFrames
        self.interval = interval
        self._step = _trialsOfAStep(interval, expectedFrames)
        self._cell = _unitCell(topology)
        self._frameSize = len(self._cell) + 3 * (4 * len(positions) + 8)
        header = _makeHeader(topology, interval, self._step)
        if framesThere > 0:
            # Of a run whose trials the format could hold, or not, unlike those of this one.
            other = interval if self._step == 1 or interval > _LARGEST_STEP else 1
            former = _withoutCounts(_makeHeader(topology, interval, other))

            def normalize(data):
                kept = _withoutCounts(data)
                return _withoutCounts(header) if kept == former else kept

            self.resume(output, len(header) + framesThere * self._frameSize, header, "trajectory", normalize)
        else:
            self.begin(output)
        try:
            if framesThere > 0:
                self.replace(0, header[:_TITLE])
                self._setCounts(framesThere)
            else:
                self.append(header)
                self.write(positions)
        except BaseException:
            self.close()
            raise

    def write(self, positions):
        """Add positions, a float64 array of shape (n, 3) in nm.

        Raises
        ------
        OutputError
            if they cannot be written; the file keeps its earlier frames
        """
        axes = np.zeros(3, [("before", "<i4"), ("values", "<f4", len(positions)), ("after", "<i4")])
        axes["before"] = axes["after"] = 4 * len(positions)
        axes["values"] = 10 * positions.T
        size = self.size
        try:
            self.append(self._cell + axes.tobytes())
            self._setCounts(self.frames + 1)
        except OutputError as error:
            self.size = size
            raise OutputError(f"{error}; {self.describe()}" if self.frames > 0 else str(error)) from error
        self.frames += 1

    def shorten(self, frames):
        """Remove all but the first `frames` frames."""
        if frames < self.frames:
            self.size -= (self.frames - frames) * self._frameSize
            self.frames = frames

    def describe(self):
        """Describe how much of the trajectory is written."""
        name, held, expected = self._output.name, self.frames, self._expectedFrames
        return f"{name} is partial: it holds the first {held:,} of {countOf(expected, 'frame')}"

    def close(self):
        """Close the file without an incomplete frame; remove a file without frames."""
        try:
            if self.frames > 0:
                self._setCounts(self.frames)
        finally:
            super().close()
        if self.frames == 0:
            self.remove()

    def _setCounts(self, frames):
        """Write the number of frames into the header."""
        self.replace(_FRAME_COUNT, struct.pack("<i", frames))
        self.replace(_LAST_STEP, struct.pack("<i", (frames - 1) * (self.interval // self._step)))


def readPositions(path, topology, frames):
    """Yield the positions of the frames of a closed TrajectoryFile, float arrays of shape (n, 3) in nm."""
    axis = [("before", "<i4"), ("values", "<f4", topology.getNumAtoms()), ("after", "<i4")]
    frame = np.dtype([("cell", f"V{len(_unitCell(topology))}"), ("axes", axis, 3)])
    begin = os.path.getsize(path) - frames * frame.itemsize
    for found in np.memmap(path, frame, mode="r", offset=begin, shape=frames):
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
