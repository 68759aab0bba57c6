"""Reading HDF5 trajectories in MDTraj's layout by h5py: MDTraj itself needs PyTables, which brings a dozen packages."""

import h5py


class HDF5TrajectoryFile:
    """An open file, read like the trajectory files of MDTraj."""

    distance_unit = "nanometers"

    def __init__(self, path):
        """Open it; ValueError: it has another layout."""
        self._file = h5py.File(path, "r")
        self._arrays = [self._file.get(name) for name in ("coordinates", "cell_lengths", "cell_angles")]
        if self._arrays[0] is None or self._arrays[0].ndim != 3 or self._arrays[0].shape[2] != 3:
            raise ValueError("there are no coordinates of the shape (frames, atoms, 3)")
        self._next = 0

    def __len__(self):
        """Return the number of frames."""
        return len(self._arrays[0])

    def seek(self, frame):
        """Make a frame the next that is read."""
        self._next = frame

    def read(self, count):
        """Return coordinates, and lengths and angles of boxes (or None), of the next frames, at most count."""
        chosen = slice(self._next, self._next + count)
        self._next += count
        return [None if array is None else array[chosen] for array in self._arrays]

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self._file.close()
