"""Reading trajectories, DCD and XTC, frame by frame."""

import importlib.util
import os
import pickle
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

if sys.platform == "linux":
    import fcntl

from ..errors import InputError
from ..images import isBox

_FORMATS = (".dcd", ".xtc")

# Run by its path, not as a module of the package, since it has no need of OpenMM.
_READER = Path(__file__).with_name("trajectoryreader.py")

# The reader goes ahead by as much as its pipe holds (bytes): some frames, not one.
_PIPE_SIZE = 1 << 18


class Trajectory:
    """A trajectory. As a context manager it closes itself.

    `frames`, and iteration for all of them, gives pairs of the positions, a float64 array of shape (n, 3) in nm, and
    the periodic box, one of shape (3, 3) with a vector a row, or None.

    Attributes
    ----------
    path : Path
    frameCount : int or None
        the number of frames, where that can be known before they are read
    announced : int or None
        the number of frames that the file's header tells; programs write it when they start, or correct it at the end

    Both are known after `readHeader`, which comes before all frames.

    Iteration raises an InputError at the first damaged frame, after the sound ones. A damaged file can do no other
    harm: it is read by a process of its own.
    """

    def __init__(self, path):
        """Begin to open a trajectory, which takes a while that one can use for something else.

        Raises
        ------
        InputError
            if the file cannot be opened, or its name is not that of a trajectory
        """
        self.path = Path(path)
        if self.path.suffix.lower() not in _FORMATS:
            raise InputError(f"{path}: is not named as a trajectory of a known format ({', '.join(_FORMATS)})")
        try:
            with open(path, "rb") as file:
                if not file.read(1):
                    raise InputError(f"{path}: is empty")
        except OSError as error:
            raise InputError(f"{path}: {error.strerror}") from error
        if importlib.util.find_spec("mdtraj") is None:
            raise InputError(f"{path}: reading trajectories needs MDTraj (pip install mdtraj)")
        self._process = subprocess.Popen(
            [sys.executable, str(_READER), str(path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,  # Ctrl-C is for the program that asked
            # Threads for linear algebra would wait for work that never comes.
            env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "OPENBLAS_NUM_THREADS": "1"},
        )
        if sys.platform == "linux":
            with suppress(OSError):  # it may be more than the system grants
                fcntl.fcntl(self._process.stdout, fcntl.F_SETPIPE_SZ, _PIPE_SIZE)

    def readHeader(self):
        """Wait until the trajectory is open, and learn what its header tells.

        Raises
        ------
        InputError
            if its reader crashes; other damage is told in place of frames
        """
        self.announced, self.frameCount, self._unit = self._receive(0)

    def __iter__(self):
        return self.frames()

    def frames(self, begin=0, end=-1):
        """Return an iterator of frames from one to another, which is not among them; -1: to the last.

        It has to come to its end before the next one begins. A number of frames has to be known for any other end.
        """
        index = begin
        with suppress(OSError):  # a reader that has ended says why
            self._process.stdin.write(f"{begin} {end}\n".encode())
            self._process.stdin.flush()
        while True:
            received = self._receive(index)
            if received is None:
                return
            if isinstance(received, str):
                raise InputError(f"{self.path}: {received}")
            positions, box = received
            yield positions.astype("float64") * self._unit, box if box is not None and isBox(box) else None
            index += 1

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()

    def close(self):
        """End the reading process."""
        self._process.kill()
        with suppress(OSError):
            self._process.stdin.close()
        self._process.stdout.close()
        self._process.wait()

    def _receive(self, index):
        try:
            return pickle.load(self._process.stdout)
        except (EOFError, pickle.UnpicklingError):
            raise InputError(f"{self.path}: frame {index} (from 0) is damaged so that its reader crashed") from None
