"""Reads the trajectory that its argument names and writes the frames to standard output.

This is a separate program, so that a damaged file cannot harm the calling process: the C code that reads these formats
may crash, and prints messages. The program writes pickles. The first is the number of frames in the file's header, the
number that the file holds (each None if unknown), and its unit of length in nm. Each line of standard input requests
frames, by the number of the first frame (from 0) and of the frame after the last one, or -1 for all remaining frames.
The answer has for each frame the positions as a float32 array in that unit and the periodic box as a float64 array in
nm (None without a box), and at the end a description of the damage in words, or None.
"""

import importlib
import os
import pickle
import struct
import sys
from pathlib import Path

import numpy as np


def main(path):
    with os.fdopen(os.dup(1), "wb") as output:
        silent = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silent, 1)
        os.dup2(silent, 2)
        try:
            _answer(Path(path), output)
        except BrokenPipeError:
            os._exit(0)  # the caller has closed the pipe


def _answer(path, output):
    """Write the counts, then the requested frames."""
    suffix = path.suffix.lower()
    name, package, module, reader, boxOf = KINDS[suffix]
    try:
        Reader = getattr(importlib.import_module(module), reader)
    except ImportError as error:
        advice = "pip install 'openmm-chaintree[tools]'"
        return _refuse(output, f"{package}, which reads it, cannot be imported ({error}): {advice}")
    isDCD = suffix == ".dcd"
    try:
        file = Reader(str(path))
    except Exception:
        return _refuse(output, f"not {name} file, or damaged at its start")
    with file:
        header = _DCDHeader(path) if isDCD else None
        headers = _TRRHeaders(path) if suffix == ".trr" else None
        count = _length(file)
        unit = 0.1 if file.distance_unit == "angstroms" else 1.0
        _write((header.frames if isDCD else None, count, unit), output)
        place = 0
        for line in sys.stdin:
            begin, end = map(int, line.split())
            if begin != place:
                file.seek(begin)
            place = None  # after a damaged frame, the position in the file is unknown
            damage, place = _writeFrames(file, boxOf, header, headers, count, begin, end, output)
            _write(damage, output)


def _refuse(output, reason):
    """Write unknown counts, and the reason as the answer to the first request."""
    for content in ((None, None, None), reason):
        _write(content, output)


def _write(content, output):
    pickle.dump(content, output, pickle.HIGHEST_PROTOCOL)
    output.flush()


def _writeFrames(file, boxOf, header, headers, count, begin, end, output):
    """Write frames begin to end - 1, or to the last for -1; return the damage or None, and the next frame."""
    isDCD = header is not None
    index = begin
    while index != end:
        try:
            positions, *others = file.read(1)
        except Exception:
            return f"frame {index} (from 0) is damaged", None
        if len(positions) == 0:
            break
        if headers is not None and not headers.havePositions(index):
            return f"frame {index} (from 0) has no positions, but other data alone", None
        _write((positions[0], boxOf(*others)), output)
        index += 1
    if index < end or isDCD and end == -1 and index < count:
        return f"frame {index} (from 0) is damaged", None
    if isDCD and end in (-1, count) and not header.endsWithAFrame():
        return f"frame {index} (from 0) is cut off", None
    return (None if index > 0 else "there are no frames"), index


def _boxOfAngstroms(lengths, angles):
    """Return the box of the frame that was read, or None; some programs write zeros if there is none."""
    if lengths is None or angles is None or not (np.all(lengths > 0) and np.all(angles > 0)):
        return None
    from mdtraj.utils.unitcell import lengths_and_angles_to_box_vectors

    vectors = lengths_and_angles_to_box_vectors(*(0.1 * lengths[0].astype("float64")), *angles[0].astype("float64"))
    return np.array(vectors)


def _boxOfNetCDF(times, lengths, angles):
    return _boxOfAngstroms(lengths, angles)


def _boxOfGromacs(times, steps, boxes, *others):
    return None if boxes is None else boxes[0].astype("float64")


def _boxOfHDF5(lengths, angles):
    return _boxOfAngstroms(None if lengths is None else 10 * lengths, angles)


def _length(file):
    try:
        return len(file)
    except Exception:  # of an XTC or TRR file in which the header of a frame is damaged
        return None


class _DCDHeader:
    """Properties of a DCD file that MDTraj ignores: the number of frames in the header, an incomplete last frame."""

    def __init__(self, path):
        self._path = path
        with open(path, "rb") as file:
            start = file.read(88)
        self._order = next((order for order in "<>" if struct.unpack(order + "i", start[:4]) == (84,)), None)
        # Rare kinds have markers of eight bytes; only MDTraj reads those.
        if self._order is None or start[4:8] != b"CORD":
            self._order = self.frames = None
            return
        control = struct.unpack(self._order + "20i", start[8:])
        self.frames = control[0]
        isCHARMM = control[19] != 0
        self._recordsBefore = 4 if control[8] else 3
        self._recordsInAFrame = 3 + (isCHARMM and control[10] != 0) + (isCHARMM and control[11] != 0)

    def endsWithAFrame(self):
        """Whether the file ends with a complete record that is the last one of a frame."""
        if self._order is None:
            return True
        records, position, size = 0, 0, self._path.stat().st_size
        with open(self._path, "rb") as file:
            while position < size:
                file.seek(position)
                marker = file.read(4)
                if len(marker) < 4:
                    return False
                position += 8 + max(0, struct.unpack(self._order + "i", marker)[0])
                records += 1
        return position == size and (records - self._recordsBefore) % self._recordsInAFrame == 0


class _TRRHeaders:
    """The headers of a TRR file, by which each frame has positions or not: MDTraj would return any numbers for them."""

    _FIRST, _NUMBERS = 24, struct.Struct(">13i")  # the magic number and the version; sizes in bytes, then counts

    def __init__(self, path):
        self._path = path
        self._starts = [0]

    def havePositions(self, index):
        """Whether a frame has positions; frames before it must be whole."""
        with open(self._path, "rb") as file:
            while True:
                place = min(index, len(self._starts) - 1)
                file.seek(self._starts[place] + self._FIRST)
                numbers = self._NUMBERS.unpack(file.read(self._NUMBERS.size))
                box, positions, velocities, forces, atoms = (numbers[i] for i in (2, 7, 8, 9, 10))
                if place == index:
                    return positions > 0
                real = box // 9 or max(positions, velocities, forces) // (3 * atoms)  # bytes of a number
                self._starts.append(file.tell() + 2 * real + sum(numbers[:10]))


# For each suffix: the kind of file with its article, the package that reads it, the module and name of the reader, and
# the function that returns the box from what the reader returns in addition to positions.
_OF_MDTRAJ = "MDTraj", "mdtraj.formats"
_NETCDF = "a NetCDF", *_OF_MDTRAJ, "NetCDFTrajectoryFile", _boxOfNetCDF
_HDF5 = "an HDF5", "h5py", "hdf5trajectory", "HDF5TrajectoryFile", _boxOfHDF5
KINDS = {
    ".dcd": ("a DCD", *_OF_MDTRAJ, "DCDTrajectoryFile", _boxOfAngstroms),
    ".xtc": ("an XTC", *_OF_MDTRAJ, "XTCTrajectoryFile", _boxOfGromacs),
    ".trr": ("a TRR", *_OF_MDTRAJ, "TRRTrajectoryFile", _boxOfGromacs),
    ".nc": _NETCDF,
    ".ncdf": _NETCDF,
    ".netcdf": _NETCDF,
    ".h5": _HDF5,
    ".hdf5": _HDF5,
}

if __name__ == "__main__":
    main(sys.argv[1])
