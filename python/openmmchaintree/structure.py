"""Reading the structure that a command works on."""

import io
from pathlib import Path
from typing import NamedTuple

import numpy as np
import openmm.app
from openmm import unit

from .bonds import describeResidue

_WATER = "HOH"  # PDBFile gives every water this name


class InputError(Exception):
    """What is wrong with what the user gave, in one sentence that names it."""


class Structure(NamedTuple):
    """Molecules without water and ions.

    name : str, for output files; topology : openmm.app.Topology; positions : (n, 3) float64 array, nm
    """

    name: str
    topology: openmm.app.Topology
    positions: np.ndarray


def villinPath():
    """Return the path of the villin headpiece in water that OpenMM's own package carries."""
    return Path(openmm.app.__file__).parent / "data" / "test.pdb"


def readStructure(path=None):
    """Read the first model of a PDB file, first conformers only, and leave out water and ions (single atoms).

    Parameters
    ----------
    path : str or Path, optional
        default: the villin headpiece of OpenMM's package

    Raises
    ------
    InputError
        if the file cannot be read, or holds nothing to work on
    """
    name = "villin" if path is None else Path(path).stem
    path = villinPath() if path is None else Path(path)
    modeller = _solute(path, _readPDB(path))
    positions = np.array(modeller.positions.value_in_unit(unit.nanometer), dtype=np.float64)
    for atom in modeller.topology.atoms():
        label = f"atom {atom.name} of {describeResidue(atom.residue)}"
        if not np.all(np.isfinite(positions[atom.index])):
            raise InputError(f"{path}: {label} has a coordinate that is not a finite number")
        if atom.element is None:
            raise InputError(f"{path}: {label} has no element")
    modeller.topology.setPeriodicBoxVectors(None)
    return Structure(name, modeller.topology, positions)


def _readPDB(path):
    try:
        text = path.read_text(encoding="ascii", errors="replace")
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from error
    if not any(line.startswith(("ATOM  ", "HETATM")) for line in text.splitlines()):
        raise InputError(f"{path}: there are no atoms; is it a PDB file?")
    try:
        return openmm.app.PDBFile(io.StringIO(text))
    except Exception as error:  # PDBFile reports what it cannot read by whatever exception comes up
        raise InputError(f"{path}: not a PDB file that OpenMM can read ({error})") from error


def _solute(path, pdb):
    modeller = openmm.app.Modeller(pdb.topology, pdb.positions)
    modeller.delete(
        [residue for residue in pdb.topology.residues() if residue.name == _WATER or len(list(residue.atoms())) == 1]
    )
    if modeller.topology.getNumAtoms() == 0:
        raise InputError(f"{path}: nothing but water and ions")
    return modeller
