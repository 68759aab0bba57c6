"""Reading files of coordinates without a topology: AMBER's inpcrd and restart files, and CHARMM's crd, by OpenMM."""

from pathlib import Path

import numpy as np
from openmm import app, unit

from ..errors import InputError, firstLine
from ..images import reducedBox

_SUFFIXES = (".inpcrd", ".rst7", ".rst", ".restrt", ".ncrst", ".crd", ".cor")

_NETCDF, _HDF5 = b"CDF", b"\x89HDF"


def hasCoordinatesOnly(path):
    """Whether a file is named as one of coordinates without a topology, such as x.inpcrd, or inpcrd alone."""
    return f".{Path(path).name.lower().rpartition('.')[2]}" in _SUFFIXES


def readCoordinates(path):
    """Read coordinates.

    Returns
    -------
    (n, 3) float64 array
        positions, nm
    (3, 3) float64 array or None
        the periodic box, nm, a vector a row

    Raises
    ------
    InputError
        if the file cannot be read
    """
    try:
        with open(path, "rb") as file:
            start = file.read(100)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from error
    if not start:
        raise InputError(f"{path}: is empty")
    if start.startswith(_HDF5):
        raise InputError(f"{path}: is NetCDF 4, which OpenMM cannot read: write inpcrd or NetCDF 3 by cpptraj")
    isCHARMM = start.lstrip().startswith(b"*")
    try:
        file = (app.CharmmCrdFile if isCHARMM else app.AmberInpcrdFile)(str(path))
        positions = np.array(file.positions.value_in_unit(unit.nanometer), dtype=np.float64).reshape(-1, 3)
        vectors = None if isCHARMM else file.boxVectors
        box = None if vectors is None else np.array(vectors.value_in_unit(unit.nanometer), dtype=np.float64)
    except Exception as error:  # OpenMM passes on any exception of its parsers
        kind = "a CHARMM crd" if isCHARMM else "an AMBER inpcrd or restart"
        raise InputError(f"{path}: not {kind} file that can be read ({firstLine(error)})") from error
    return positions, None if box is None or not np.isfinite(box).all() or np.diag(box).min() <= 0 else reducedBox(box)
