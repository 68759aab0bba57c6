"""Reading structures: PDB and mmCIF, all models, and what of them is worth looking at."""

import gzip
import io
import re
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import openmm.app
from openmm import unit

from .naming import nameAtom

if TYPE_CHECKING:
    from .clashes import FrameClashes

_WATER = "HOH"  # OpenMM's readers give every water this name

_GZIP = b"\x1f\x8b"  # what compressed files begin with

_COORDINATES = (slice(30, 38), slice(38, 46), slice(46, 54))  # columns of a PDB file


class InputError(ValueError):
    """What is wrong with what the user gave, in one sentence that names it.

    frames : sequence of FrameClashes
        what was found before a damaged frame
    """

    frames: "Sequence[FrameClashes]" = ()


class Models(NamedTuple):
    """What a structure file holds.

    topology : openmm.app.Topology
    positions : list of (n, 3) float64 arrays, nm; those of the models up to a damaged one, at least one
    damage : InputError, or None if all models are sound
    """

    topology: openmm.app.Topology
    positions: list[np.ndarray]
    damage: InputError | None


class Structure(NamedTuple):
    """Molecules without water and ions.

    name : str, for output files; topology : openmm.app.Topology; positions : (n, 3) float64 array, nm
    """

    name: str
    topology: openmm.app.Topology
    positions: np.ndarray


class Selection(NamedTuple):
    """A part of the atoms of a Topology, as a Topology of its own.

    topology : openmm.app.Topology; atoms : (m,) int array, where each of its atoms was
    """

    topology: openmm.app.Topology
    atoms: np.ndarray


def villinPath():
    """Return the path of the villin headpiece in water that OpenMM's own package carries."""
    return Path(openmm.app.__file__).parent / "data" / "test.pdb"


def readStructure(path=None):
    """Read the first model of a PDB or mmCIF file, first conformers only, and leave out water and ions (single atoms).

    The file may be compressed by gzip.

    Parameters
    ----------
    path : str or Path, optional
        default: the villin headpiece of OpenMM's package

    Raises
    ------
    InputError
        if the file cannot be read, or holds nothing to work on
    """
    name = "villin" if path is None else Path(Path(path).name.removesuffix(".gz")).stem
    path = villinPath() if path is None else Path(path)
    models = readModels(path)
    solute = select(path, models.topology)
    solute.topology.setPeriodicBoxVectors(None)
    return Structure(name, solute.topology, models.positions[0][solute.atoms])


def readModels(path):
    """Read all models of a PDB or mmCIF file, which may be compressed by gzip, first conformers only.

    Raises
    ------
    InputError
        if the file or its first model cannot be read
    """
    path = Path(path)
    text = _readText(path)
    file, damage = _readMmCIF(path, text) if _isMmCIF(text) else _readPDB(path, text)
    names = [nameAtom(atom) for atom in file.topology.atoms()]
    positions = []
    for model in range(file.getNumFrames()):
        array = np.array(file.getPositions(frame=model).value_in_unit(unit.nanometer), dtype=np.float64)
        try:
            if len(array) != len(names):
                raise InputError(f"{path}: model {model} (from 0) has {len(array)} atoms, but model 0 has {len(names)}")
            checkFinite(array, names, path if model == 0 else f"{path}: model {model} (from 0)")
        except InputError as error:
            damage = error
            break
        positions.append(array)
    if not positions:
        raise damage
    return Models(file.topology, positions, damage)


def checkFinite(positions, names, source):
    """Raise an InputError that names the first atom with a coordinate that is not a number, and the source."""
    bad = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(bad):
        raise InputError(f"{source}: atom {_describe(names[bad[0]])} has a coordinate that is not a finite number")


def select(path, topology, water=False, ions=False):
    """Select the atoms of a Topology that are neither water nor, as residues of a single atom, ions.

    Parameters
    ----------
    path : str or Path
        where the Topology is from, for messages
    topology : openmm.app.Topology
    water, ions : bool
        select these as well

    Raises
    ------
    InputError
        if nothing is left, or an atom has no element
    """
    left = {
        residue
        for residue in topology.residues()
        if (not water if residue.name == _WATER else not ions and len(list(residue.atoms())) == 1)
    }
    atoms = [atom for atom in topology.atoms() if atom.residue not in left]
    if not atoms:
        raise InputError(f"{path}: nothing but water and ions")
    for atom in atoms:
        if atom.element is None and atom.residue.name != _WATER:
            raise InputError(f"{path}: atom {_describe(nameAtom(atom))} has no element")
    modeller = openmm.app.Modeller(topology, np.zeros((topology.getNumAtoms(), 3)) * unit.nanometer)
    modeller.delete(left)
    return Selection(modeller.topology, np.array([atom.index for atom in atoms]))


def _describe(name):
    return f"{name.atom} of {name.describeResidue()}"


def _readText(path):
    try:
        data = path.read_bytes()
        if data.startswith(_GZIP):
            data = gzip.decompress(data)
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise InputError(f"{path}: cannot be decompressed ({error})") from error
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from error
    return io.TextIOWrapper(io.BytesIO(data), encoding="ascii", errors="replace").read()


def _isMmCIF(text):
    """Whether a text is a CIF file: they begin with a data block, after comments."""
    return re.match(r"(\s|#.*\n)*data_", text, re.IGNORECASE) is not None


def _readMmCIF(path, text):
    """Return a PDBxFile, and None for no damage: what is damaged in mmCIF cannot be read at all."""
    if "_atom_site." not in text:
        raise InputError(f"{path}: there are no atoms")
    try:
        file = openmm.app.PDBxFile(io.StringIO(text))
    except Exception as error:  # PDBxFile reports what it cannot read by whatever exception comes up
        reason = "the last row of a table is incomplete" if isinstance(error, IndexError) else error
        raise InputError(f"{path}: not an mmCIF file that OpenMM can read ({reason})") from error
    # PDBFile does this by itself.
    file.topology.createDisulfideBonds(file.positions)
    return file, None


def _readPDB(path, text):
    """Return a PDBFile of the models before the first damaged one, and that damage as an InputError or None."""
    if not any(line.startswith(("ATOM  ", "HETATM")) for line in text.splitlines()):
        raise InputError(f"{path}: there are no atoms; is it a PDB or mmCIF file?")
    sound, damage = _soundModels(text)
    if damage is not None:
        damage = InputError(f"{path}: {damage}")
        if sound is None:
            raise damage
    try:
        return openmm.app.PDBFile(io.StringIO(text if damage is None else sound)), damage
    except Exception as error:  # PDBFile reports what it cannot read by whatever exception comes up
        raise InputError(f"{path}: not a PDB file that OpenMM can read ({error})") from error


def _soundModels(text):
    """Look for the first damage of a PDB file.

    Return what is left without the damaged model and those after it, None if that is the first one, and the damage in
    words; the words are None if there is none.
    """
    lines = text.splitlines(keepends=True)
    modelStarts = []
    isOpen = False
    damage = None
    for number, line in enumerate(lines):
        record = line[:6].rstrip()
        if record == "MODEL":
            modelStarts.append(number)
            isOpen = True
        elif record in ("ENDMDL", "END"):
            isOpen = False
        elif record in ("ATOM", "HETATM") and not _hasCoordinates(line):
            damage = f"line {number + 1} has no coordinates where they should be (columns 31 to 54)"
            break
    else:
        if isOpen:
            damage = f"the file ends within model {len(modelStarts) - 1} (from 0)"
    if damage is None or len(modelStarts) < 2:
        return None, damage
    bonds = [line for line in lines[number:] if line.startswith("CONECT")]
    return "".join(lines[: modelStarts[-1]] + bonds), damage


def _hasCoordinates(line):
    if len(line.rstrip("\r\n")) < _COORDINATES[-1].stop:
        return False
    try:
        for columns in _COORDINATES:
            float(line[columns])
    except ValueError:
        return False
    return True
