"""Trajectories that are valid after every frame, however the run ends."""

from ...notes import countOf
from .growingfile import GrowingFile
from .output import OutputError


class TrajectoryFile(GrowingFile):
    """A trajectory, to which `write` adds a frame; DCDFile and XTCFile are its formats.

    A format has the methods _prepare, which makes _header, the bytes before all frames; _encode, which returns those of
    a frame; _noteFrames, called with the number of frames after each change; _sizeOf, which returns the number of bytes
    for a number of frames; and _resumeFrames, which opens a file that was written.

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
        self._prepare(topology, len(positions), expectedFrames)
        if framesThere > 0:
            self._resumeFrames(output)
            return
        self.begin(output)
        try:
            self.append(self._header)
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
        size = self.size
        try:
            self.append(self._encode(positions))
            self._noteFrames(self.frames + 1)
        except OutputError as error:
            self.size = size
            raise OutputError(f"{error}; {self.describe()}" if self.frames > 0 else str(error)) from error
        self.frames += 1

    def shorten(self, frames):
        """Remove all but the first `frames` frames."""
        if frames < self.frames:
            self.size = self._sizeOf(frames)
            self.frames = frames

    def describe(self):
        """Describe how much of the trajectory is written."""
        name, held, expected = self._output.name, self.frames, self._expectedFrames
        return f"{name} is partial: it holds the first {held:,} of {countOf(expected, 'frame')}"

    def close(self):
        """Close the file without an incomplete frame; remove a file without frames."""
        try:
            if self.frames > 0:
                self._noteFrames(self.frames)
        finally:
            super().close()
        if self.frames == 0:
            self.remove()
