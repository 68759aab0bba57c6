"""Writing a trajectory (DCD) that is sound after every frame, whatever may end the run."""

import io
import os
import struct
from contextlib import suppress

import numpy as np
import openmm.app
from openmm import unit

from ..errors import InputError
from .outputfiles import OutputError

# Where in the header of a DCD file is what each frame changes: the number of frames, the step of the last one.
_FRAME_COUNT, _LAST_STEP = 8, 20

# The line of the title that has the date.
_TITLE, _TITLE_LENGTH = 180, 80

_LARGEST_STEP = 2**31 - 1  # what a DCD file can hold


class TrajectoryFile:
    """A DCD file, to which `write` adds a frame. As a context manager it closes itself.

    Trials have no time: a frame's step is the number of trials before it, at 1 ps each.

    Attributes
    ----------
    interval : int
        the number of trials between frames
    frames : int
        the number of frames that the file holds
    """

    def __init__(self, output, topology, positions, interval, expectedFrames, framesThere=0):
        """Begin the file of an Output by the start's positions; a frame is to follow every interval trials.

        Or go on with a file that this class has written, of which so many frames count; what follows them is cut off.

        Raises
        ------
        InputError
            if the file to go on with is not what was written, or has fewer frames
        OutputError
            if the file cannot be written
        """
        self.frames = framesThere
        self._output = output
        self._expectedFrames = expectedFrames
        self.interval = interval
        # Where steps are too many for the format, they are longer.
        self._step = 1 if interval * expectedFrames <= _LARGEST_STEP else interval
        header = io.BytesIO()
        openmm.app.DCDFile(header, topology, self._step * unit.picosecond, 0, interval // self._step)
        header = header.getvalue()
        if framesThere > 0:
            self._size = len(header) + framesThere * 3 * (4 * len(positions) + 8)
            self._goOn(header)
            return
        self._file = output.open()
        self._size = 0  # of what is complete
        try:
            self._append(header)
            self._size = len(header)
            self.write(positions)
        except BaseException:
            self.close()
            raise

    def _goOn(self, header):
        """Open the file that is there, and cut off what does not count."""
        self._file = self._output.openThere()
        try:
            with self._output.explainingErrors():
                there = self._file.read(len(header))
                size = self._file.seek(0, os.SEEK_END)
            if _withoutCounts(there) != _withoutCounts(header) or size < self._size:
                raise InputError(f"{self._output.name}: is not the trajectory that the run has written")
            with self._output.explainingErrors():
                self._file.truncate(self._size)
                self._file.seek(self._size)
            self._setCounts(self.frames)
        except BaseException:
            self._file.close()
            raise

    def sync(self):
        """Wait until what was written is on the disk."""
        with self._output.explainingErrors():
            os.fsync(self._file.fileno())

    def write(self, positions):
        """Add positions, a float64 array of shape (n, 3) in nm.

        Raises
        ------
        OutputError
            if they cannot be written; the file holds what came before
        """
        axes = np.zeros(3, [("before", "<i4"), ("values", "<f4", len(positions)), ("after", "<i4")])
        axes["before"] = axes["after"] = 4 * len(positions)
        axes["values"] = 10 * positions.T
        data = axes.tobytes()
        try:
            self._append(data)
            self._setCounts(self.frames + 1)
        except OutputError as error:
            raise OutputError(f"{error}; {self.describe()}" if self.frames > 0 else str(error)) from error
        self.frames += 1
        self._size += len(data)

    def describe(self):
        """Say how much of the trajectory there is."""
        name, held, expected = self._output.name, self.frames, self._expectedFrames
        return f"{name} is partial: it holds the first {held:,} of {expected:,} frames"

    def close(self):
        """Close the file, without what is not a complete frame; without any, remove it."""
        with suppress(OSError):  # a device has no size
            self._file.truncate(self._size)
        if self.frames > 0:
            self._setCounts(self.frames)
        with self._output.explainingErrors():
            self._file.close()
        if self.frames == 0:
            self._output.remove()

    def remove(self):
        """Remove the file, after it was closed."""
        self._output.remove()

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()

    def _append(self, data):
        with self._output.explainingErrors():
            while data:
                data = data[self._file.write(data) :]

    def _setCounts(self, frames):
        """Tell in the header how many frames there are."""
        with self._output.explainingErrors():
            os.pwrite(self._file.fileno(), struct.pack("<i", frames), _FRAME_COUNT)
            os.pwrite(self._file.fileno(), struct.pack("<i", (frames - 1) * (self.interval // self._step)), _LAST_STEP)


def _withoutCounts(header):
    """Return the header of a DCD file without what each frame changes, and without its date."""
    kept = bytearray(header)
    for begin, length in ((_FRAME_COUNT, 4), (_LAST_STEP, 4), (_TITLE, _TITLE_LENGTH)):
        kept[begin : begin + length] = bytes(length)
    return kept
