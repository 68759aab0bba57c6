"""The formats of trajectories that runs write."""

from .dcdfile import DCDFile
from .xtcfile import XTCFile, isXTC

FORMATS = {"dcd": DCDFile, "xtc": XTCFile}


def formatOf(path):
    """Return the class of the trajectory at a path, which a run has written."""
    return XTCFile if isXTC(path) else DCDFile


def readPositions(path, topology, frames, step=1):
    """Yield the positions of each `step`-th frame of a trajectory with `frames` frames, from the first.

    They are float arrays of shape (n, 3) in nm.
    """
    return formatOf(path).read(path, topology, frames, step)
