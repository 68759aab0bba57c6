"""The files that grow during a run: trajectories, and an index of their frames."""

import csv
import io
import zlib
from contextlib import ExitStack

import numpy as np

from ...errors import InputError
from .growingfile import GrowingFile
from .trajectoryfile import TrajectoryFile

_COLUMNS = ("frame", "trials", "replica", "temperature", "potentialEnergy", "radiusOfGyration")


def trajectoryNames(prefix, replicas, temperatures, byTemperature):
    """Return the names of the trajectories of `replicas` replicas, or of temperatures (K)."""
    if not byTemperature:
        width = len(str(replicas - 1))
        return [f"{prefix}-replica-{replica:0{width}}.dcd" for replica in range(replicas)]
    for digits in range(10):
        names = [f"{temperature:.{digits}f}" for temperature in temperatures]
        isExact = all(float(name) == temperature for name, temperature in zip(names, temperatures, strict=True))
        if isExact or digits >= 1 and len({*names}) == len(names):
            break
    return [f"{prefix}-{name}K.dcd" for name in names]


class IndexFile(GrowingFile):
    """A table (CSV) of all frames of all replicas, sorted by frame, then by replica.

    Frames and replicas are numbered from 0; frame 0 is the start. Energies are in kJ/mol, lengths in nm.
    """

    def __init__(self, output, mark=None, rows=0):
        """Begin the file of an Output, or resume it at a mark, after `rows` rows."""
        header = _asLine(_COLUMNS).encode()
        if mark is not None:
            size, self._checksum = mark
            if output.path.is_file() and _linesIn(output.path, size) != 1 + rows:
                raise InputError(f"{output.name}: is not the index that the run has written")
            self.resume(output, size, header, "index", checksum=self._checksum)
            return
        self.begin(output)
        self._checksum = 0
        try:
            self.append(header)
        except BaseException:
            self.close()
            raise

    @property
    def mark(self):
        """The number of complete bytes, and their `zlib.crc32`."""
        return self.size, self._checksum

    def write(self, rows):
        """Add rows, each a sequence of column values."""
        self.append("".join(map(_asLine, rows)).encode())

    def append(self, data):
        """Add bytes, and count them in the checksum."""
        super().append(data)
        self._checksum = zlib.crc32(data, self._checksum)


def _linesIn(path, size):
    """Return the number of lines in the first `size` bytes of a file."""
    lines = 0
    with open(path, "rb") as file:
        while size > 0 and (piece := file.read(min(size, 1 << 20))):
            lines += piece.count(b"\n")
            size -= len(piece)
    return lines


def _asLine(values):
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(["" if value is None else value for value in values])
    return line.getvalue()


def readIndex(path):
    """Return the columns of an index as a dictionary of arrays; empty cells are NaN.

    Raises
    ------
    InputError
        if it is not an index
    """
    orNaN = dict.fromkeys(range(3, len(_COLUMNS)), lambda text: float(text or "nan"))
    try:
        columns = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2, converters=orNaN, encoding="utf-8").T
        if len(columns) != len(_COLUMNS):
            raise ValueError("the number of columns is wrong")
    except ValueError as error:
        raise InputError(f"{path}: is no index of frames ({error})") from error
    return {
        name: column.astype(int) if number < 3 else column
        for number, (name, column) in enumerate(zip(_COLUMNS, columns, strict=True))
    }


class ReplicaFiles:
    """The trajectories and the index of a run; a context manager that closes them.

    Attributes
    ----------
    trajectories : list of TrajectoryFile
    index : IndexFile
    """

    def __init__(self, outputs, plan, byTemperature, start, round=0, indexMark=None):
        """Begin all files with the start, or resume them at the beginning of a round. On failure, remove new files.

        Parameters
        ----------
        outputs : dict
            "index": an Output; "trajectories": a list of them
        plan : RunPlan
        byTemperature : bool
            whether each temperature has a trajectory, instead of each replica
        start : Sampling
            at its start
        round : int
        indexMark : (int, int) or None
            the mark of the index when that round began; None for a new run
        """
        self._plan = plan
        self._byTemperature = byTemperature
        self._start = start
        self._rows = {}
        self.trajectories = []
        self.index = None
        isNew = indexMark is None
        topology, positions, schedule = start.structure.topology, start.structure.positions, plan.schedule
        frames = 0 if isNew else 1 + schedule.framesBefore(round)
        self._nextFrame = max(1, frames)
        try:
            for output in outputs["trajectories"]:
                expected = 1 + schedule.frames
                self.trajectories.append(
                    TrajectoryFile(output, topology, positions, schedule.interval, expected, frames)
                )
            self.index = IndexFile(outputs["index"], indexMark, frames * len(plan.seeds))
            if isNew:
                energy = start.startEnergy
                self.index.write([self._row(0, *place, positions, energy) for place in self._startPlaces()])
        except BaseException:
            self.close()
            if isNew:
                self.remove()
            raise

    def remove(self):
        """Remove the files, after they were closed."""
        for file in (*self.trajectories, self.index):
            if file is not None:
                file.remove()

    def add(self, frame, replica, temperature, kept):
        """Add a KeptFrame of a replica, which has the temperature of this number."""
        self.trajectories[temperature if self._byTemperature else replica].write(kept.positions)
        self._rows.setdefault(frame, {})[replica] = self._row(frame, replica, temperature, kept.positions, kept.energy)
        while len(self._rows.get(self._nextFrame, ())) == len(self._plan.seeds):
            rows = self._rows.pop(self._nextFrame)
            self.index.write([rows[replica] for replica in sorted(rows)])
            self._nextFrame += 1

    def shorten(self, round):
        """Remove the frames of a round and of later ones; nothing can be added afterwards."""
        for trajectory in self.trajectories:
            trajectory.shorten(1 + self._plan.schedule.framesBefore(round))

    def sync(self):
        """Wait until all written data is on disk."""
        for file in (*self.trajectories, self.index):
            file.sync()

    def close(self):
        """Close all files."""
        with ExitStack() as stack:
            for file in (*self.trajectories, self.index):
                if file is not None:
                    stack.callback(file.close)

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()

    def _startPlaces(self):
        count = len(self._plan.seeds)
        return [(replica, replica if self._plan.isExchange else 0) for replica in range(count)]

    def _row(self, frame, replica, temperature, positions, energy):
        radius = self._start.radiusOfGyration(positions)
        kelvin = None if energy is None else self._plan.temperatures[temperature]
        return frame, self._plan.schedule.trialsOfFrame(frame), replica, kelvin, energy, radius
