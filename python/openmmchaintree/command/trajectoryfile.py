"""Writing a trajectory (DCD) that is sound after every frame, whatever may end the run."""

import io
import os
import struct
from contextlib import suppress

import numpy as np
import openmm.app
from openmm import unit

from .outputfiles import OutputError

# Where in the header of a DCD file is what each frame changes: the number of frames, the step of the last one.
_FRAME_COUNT, _LAST_STEP = 8, 20

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

    def __init__(self, output, topology, positions, interval, expectedFrames):
        """Begin the file of an Output by the start's positions; a frame is to follow every interval trials.

        Raises
        ------
        OutputError
            if the file cannot be written
        """
        self.frames = 0
        self._output = output
        self._expectedFrames = expectedFrames
        self.interval = interval
        # Where steps are too many for the format, they are longer.
        self._step = 1 if interval * expectedFrames <= _LARGEST_STEP else interval
        header = io.BytesIO()
        openmm.app.DCDFile(header, topology, self._step * unit.picosecond, 0, interval // self._step)
        self._file = output.open()
        self._size = 0  # of what is complete
        try:
            self._append(header.getvalue())
            self._size = len(header.getvalue())
            self.write(positions)
        except BaseException:
            self.close()
            raise

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
