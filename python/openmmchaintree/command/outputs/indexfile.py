"""The table of all frames of a run, with energies and shapes."""

import csv
import io
import zlib
from typing import NamedTuple

import numpy as np

from ...errors import InputError
from ...samplecolumns import COLUMNS, headerOf, lineOf
from ...shape import ShapeValues
from .growingfile import GrowingFile

_WHOLE = ("frame", "trials", "replica")
_MEASURED = ("potentialEnergy", "radiusOfGyration", "endToEndDistance", "rmsd", "acceptance")
_NAMES = (*_WHOLE, "temperature", *_MEASURED)

# The names of the columns in the table of a single run.
_NAME_OF = dict(zip(COLUMNS, ("trials", *_MEASURED), strict=True))


class IndexRow(NamedTuple):
    """A frame. temperature : K, energy : kJ/mol, None for hard spheres alone; attempted, accepted : trials so far"""

    frame: int
    trials: int
    replica: int
    temperature: float | None
    energy: float | None
    shape: ShapeValues
    attempted: int
    accepted: int


class IndexFile(GrowingFile):
    """A table (CSV) of all frames of all replicas, sorted by frame, then by replica.

    Frames and replicas are numbered from 0; frame 0 is the start. Energies are in kJ/mol, lengths in nm, acceptance in
    per cent. A single run has the table of `SampleReporter`.
    """

    def __init__(self, output, isSingle, start, mark=None):
        """Begin the file of an Output, or resume it at a mark. start : IndexRow, for its columns"""
        header = _headerOf(isSingle, start)
        self._describe = _describeFrame if isSingle else _describeReplica
        if mark is not None:
            size, self._checksum = mark
            self.resume(output, size, header.encode(), "index", checksum=self._checksum)
            return
        self.begin(output)
        self._checksum = 0
        try:
            self.append(header.encode())
        except BaseException:
            self.close()
            raise

    @property
    def mark(self):
        """The number of complete bytes, and their `zlib.crc32`."""
        return self.size, self._checksum

    def write(self, rows):
        """Add IndexRows."""
        self.append("".join(map(self._describe, rows)).encode())

    def append(self, data):
        """Add bytes, and count them in the checksum."""
        super().append(data)
        self._checksum = zlib.crc32(data, self._checksum)


def checkIndex(output, isSingle, start, mark, rows):
    """Refuse the index of an Output that cannot be resumed at a mark, after `rows` rows, before any file changes.

    Raises
    ------
    InputError
        if it is missing, is not what the run has written, or has the columns of another version
    """
    size, checksum = mark
    with output.openThere() as file, output.explainingErrors():
        content = file.read(min(size, output.path.stat().st_size))
    if len(content) < size or zlib.crc32(content) != checksum or content.count(b"\n") != 1 + rows:
        raise InputError(f"{output.name}: is not the index that the run has written")
    if not content.startswith(_headerOf(isSingle, start).encode()):
        raise InputError(
            f"{output.name}: has the columns of another version of openmm-chaintree: resume with that version, or "
            "start a new run"
        )


def _headerOf(isSingle, start):
    if isSingle:
        return headerOf(start.energy is not None, start.shape.endToEndDistance is not None)
    return _asLine(_NAMES)


def _describeFrame(row):
    return lineOf(row.trials, row.energy, row.shape, row.attempted, row.accepted)


def _describeReplica(row):
    acceptance = 100 * row.accepted / row.attempted if row.attempted else None
    return _asLine((row.frame, row.trials, row.replica, row.temperature, row.energy, *row.shape, acceptance))


def _asLine(values):
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(["" if value is None else value for value in values])
    return line.getvalue()


def readIndex(path):
    """Return the columns of an index as a dictionary of arrays; empty cells and missing columns are NaN.

    Raises
    ------
    InputError
        if it is not an index
    """
    try:
        with open(path, encoding="utf-8", newline="") as file:
            names = [name.removeprefix("#").strip('"') for name in next(csv.reader(file), ())]
            names = [_NAME_OF.get(name, name) for name in names]
            if not {"trials", "radiusOfGyration"} <= {*names} <= {*_NAMES}:
                raise ValueError("its columns are others")
            orNaN = dict.fromkeys(range(len(names)), lambda text: float(text or "nan"))
            rows = np.loadtxt(file, delimiter=",", ndmin=2, converters=orNaN)
        columns = dict(zip(names, rows.T, strict=True))
    except ValueError as error:
        raise InputError(f"{path}: is not an index of frames ({error})") from error
    count = len(rows)
    missing = {"frame": np.arange(count), "replica": np.zeros(count)}
    columns = {name: columns.get(name, missing.get(name, np.full(count, np.nan))) for name in _NAMES}
    return {name: column.astype(int) if name in _WHOLE else column for name, column in columns.items()}
