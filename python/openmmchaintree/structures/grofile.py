"""Reading GROMACS's gro files as structures of gemmi: residues, names and positions in columns, and the periodic box.

OpenMM's reader needs an uncompressed file, and does not tell where a damaged file ends.
"""

import gemmi
import numpy as np

from ..errors import InputError
from ..residues import isPolymerName
from .limits import checkMemory

# Columns of the residue's number and name, and of the atom's name; numbers begin again at 0 after 99999.
_NUMBER, _RESIDUE, _NAME = slice(0, 5), slice(5, 10), slice(10, 15)
_POSITIONS = 20
_LARGEST_NUMBER = 100000

# The last oxygens of a protein, after which another chain begins.
_ENDS = {"OXT", "OC2", "OT2", "O2"}

_ATOM = 500  # bytes, an upper bound of what an atom takes


def readGro(path, text):
    """Read the frames of a gro file as models.

    Returns
    -------
    gemmi.Structure
        of the frames before the first damaged one
    list of gemmi.UnitCell
        the cell of each of these frames
    InputError or None
        the description of that damage

    Raises
    ------
    InputError
        if the first frame cannot be read
    """
    lines = text.rstrip().split("\n")
    structure, cells, start = gemmi.Structure(), [], 0
    structure.input_format = gemmi.CoorFormat.Unknown
    checkMemory(len(lines) * _ATOM, f"{path}: holds, decoded,")
    while start < len(lines):
        try:
            count = _countOf(lines, start)
            end = start + 2 + count
            cell = _cellOf(lines, end)
            model = _readModel(lines, start + 2, end, len(cells) + 1)
        except ValueError as error:
            damage = InputError(f"{path}: {error}")
            if not cells:
                raise damage from None
            return structure, cells, damage
        structure.add_model(model)
        cells.append(cell)
        start = end + 1
    if not cells:
        raise InputError(f"{path}: there are no atoms")
    structure.cell = cells[0]
    return structure, cells, None


def _countOf(lines, start):
    text = lines[start + 1].strip() if start + 1 < len(lines) else ""
    if not text.isdecimal() or int(text) == 0:
        raise ValueError(f"line {start + 2} is not a number of atoms; is it a gro file?")
    count = int(text)
    if len(lines) < start + count + 3:
        raise ValueError(f"is cut off: line {start + 2} tells of {count:,} atoms and a box")
    return count


def _cellOf(lines, index):
    """Return the cell of a line with a box in nm: the diagonal, and for oblique boxes the other components."""
    try:
        numbers = [float(word) for word in lines[index].split()]
    except ValueError:
        numbers = []
    if len(numbers) not in (3, 9) or not np.isfinite(numbers).all():
        raise ValueError(f"line {index + 1} is not a box, which follows the atoms")
    x, y, z, *rest = numbers
    xy, xz, yx, yz, zx, zy = rest or [0.0] * 6
    box = np.array([[x, xy, xz], [yx, y, yz], [zx, zy, z]])
    lengths = np.linalg.norm(box, axis=1)
    if lengths.min() == 0:
        return gemmi.UnitCell()
    cosines = [box[i] @ box[j] / (lengths[i] * lengths[j]) for i, j in ((1, 2), (0, 2), (0, 1))]
    return gemmi.UnitCell(*(10 * lengths).tolist(), *np.degrees(np.arccos(np.clip(cosines, -1, 1))).tolist())


def _readModel(lines, start, end, number):
    model = gemmi.Model(number)
    chain, residue, last, names = None, None, None, set()
    for index in range(start, end):
        line = lines[index]
        key = line[_NUMBER].strip(), line[_RESIDUE].strip()
        name = line[_NAME].strip()
        if key != last or name in names:
            if not key[0].isdecimal() or not key[1]:
                raise ValueError(f"line {index + 1} has no number and name of a residue")
            if chain is None or _beginsChain(key, last, names):
                model.add_chain(gemmi.Chain(_nameOfChain(len(model))))
                chain = model[-1]
            residue = gemmi.Residue()
            residue.name, residue.seqid = key[1], gemmi.SeqId(int(key[0]), " ")
            chain.add_residue(residue)
            residue, last, names = chain[-1], key, set()
        names.add(name)
        atom = gemmi.Atom()
        atom.name, atom.serial, atom.pos = name, index - start + 1, gemmi.Position(*_positionOf(line, index))
        residue.add_atom(atom)
    return model


def _beginsChain(key, last, names):
    """Whether a residue begins a chain: the format has no chains, but their ends show in names and numbers."""
    isPolymer = isPolymerName(key[1])
    if isPolymer != isPolymerName(last[1]):
        return True
    isNext = (int(key[0]) - int(last[0])) % _LARGEST_NUMBER in (0, 1)
    return isPolymer and not (isNext and names.isdisjoint(_ENDS))


def _nameOfChain(index):
    return chr(ord("A") + index) if index < 26 else str(index)


def _positionOf(line, index):
    """Return the position in Å; the distance of decimal points is the width of a column."""
    try:
        point = line.index(".", _POSITIONS)
        width = line.index(".", point + 1) - point
        values = [10 * float(line[_POSITIONS + k * width : _POSITIONS + (k + 1) * width]) for k in range(3)]
    except ValueError:
        values = [np.nan]
    if not np.isfinite(values).all():
        raise ValueError(f"line {index + 1} has no position of three numbers")
    return values
