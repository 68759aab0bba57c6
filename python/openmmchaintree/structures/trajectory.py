"""Reading trajectories frame by frame."""

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
from ..extras import importExtra
from ..images import isBox
from .trajectoryreader import KINDS

# Run by its path, not as a module of the package, so that it does not import OpenMM.
_READER = Path(__file__).with_name("trajectoryreader.py")

# The size of the reader's pipe in bytes: it reads ahead by a few frames.
_PIPE_SIZE = 1 << 18


class Trajectory:
    """A trajectory.

    `frames` yields pairs of the positions, a float64 array of shape (n, 3) in nm, and the periodic box, an array of
    shape (3, 3) with one vector a row, or None.

    Attributes
    ----------
    path : Path
    frameCount : int or None
        the number of frames, if it can be known before they are read
    announced : int or None
        the number of frames in the file's header, which programs write at the start or correct at the end

    Call `readHeader` first, which sets both.

    `frames` raises an InputError at the first damaged frame, after the frames before it. A damaged file can do no
    other harm, since a separate process reads it.
    """

    def __init__(self, path):
        """Begin to open a trajectory in another process, without waiting for it.

        Raises
        ------
        InputError
            if the file cannot be opened, or its name is not that of a trajectory
        """
        self.path = Path(path)
        if self.path.suffix.lower() not in KINDS:
            raise InputError(f"{path}: is not named as a trajectory of a known format ({', '.join(KINDS)})")
        try:
            with open(path, "rb") as file:
                if not file.read(1):
                    raise InputError(f"{path}: is empty")
        except OSError as error:
            raise InputError(f"{path}: {error.strerror}") from error
        if importlib.util.find_spec("mdtraj") is None:  # only the reading process imports it
            importExtra("mdtraj", f"{path}: reading trajectories", raising=InputError)
        self._process = subprocess.Popen(
            [sys.executable, str(_READER), str(path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,  # Ctrl-C must not reach the reader
            # Threads for linear algebra would do nothing.
            env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "OPENBLAS_NUM_THREADS": "1"},
        )
        if sys.platform == "linux":
            with suppress(OSError):  # the system may not allow this size
                fcntl.fcntl(self._process.stdout, fcntl.F_SETPIPE_SZ, _PIPE_SIZE)

    def readHeader(self):
        """Wait until the trajectory is open, and read its header.

        Raises
        ------
        InputError
            if its reader crashes; `frames` reports other damage
        """
        self.announced, self.frameCount, self._unit = self._receive(0)

    def frames(self, begin=0, end=-1):
        """Return an iterator over frames begin to end - 1; end=-1: to the last frame.

        Exhaust one iterator before the next call. Any other end than -1 requires a known number of frames.
        """
        index = begin
        with suppress(OSError):  # a reader that has ended has sent the reason
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
