"""A PDB or mmCIF file whose coordinates change, and nothing else.

PDB files are edited line by line. mmCIF files are edited in gemmi's document, which may write other white space.
"""

import bz2
import gzip
from pathlib import Path
from typing import NamedTuple

import gemmi
import numpy as np

from ..errors import InputError, firstLine
from .pdblines import hasCoordinates
from .structurefile import isMmCIF, readBytes

_OF_ATOMS = ("ANISOU", "SIGATM", "SIGUIJ")  # records that follow an atom's
_SAME = 5e-4  # Å: less than the last digit of a file


class AtomEntry(NamedTuple):
    """An atom as a file has it.

    row : int, the number of its line or row; place : (3,) float64 array, Å
    residue : tuple, what names its residue; name, alternate : str
    """

    row: int
    place: np.ndarray
    residue: tuple
    name: str
    alternate: str


class NewAtom(NamedTuple):
    """A hydrogen to write. after : int, the row of the atom after whose residue it stands; bearer : int, a row

    name : str; place : (3,) float64 array, Å
    """

    bearer: int
    name: str
    place: np.ndarray


def readModelFile(path):
    """Return a PDBModelFile or an mmCIFModelFile.

    Raises
    ------
    InputError
        if the file cannot be read, or is neither a PDB nor an mmCIF file
    """
    data = readBytes(path)
    suffix = Path(str(path).lower().removesuffix(".gz").removesuffix(".bz2")).suffix
    if suffix in (".gro", ".sdf", ".mol", ".mol2", ".bcif") or data[:1] >= b"\x80":
        raise InputError(f"{path}: only PDB and mmCIF files can be repaired; convert it, for example with gemmi")
    kind = MmCIFModelFile if isMmCIF(data) else PDBModelFile
    file = kind(path, data.decode("utf-8", errors="surrogateescape"))
    if not file.models:
        raise InputError(f"{path}: there are no atoms; is it a PDB or mmCIF file?")
    return file


def compressedAs(name, text):
    """Return the bytes of a text, compressed if the name of its file ends in .gz or .bz2."""
    data = text.encode("utf-8", errors="surrogateescape")
    if str(name).lower().endswith(".gz"):
        return gzip.compress(data, mtime=0)
    return bz2.compress(data) if str(name).lower().endswith(".bz2") else data


class _ModelFile:
    """What both kinds of files share.

    suffixes : the ends of names of such files; models : list of list of AtomEntry
    """

    def matchRows(self, model, places):
        """Return the rows of atoms of a model by their places, (n, 3) in Å, in the order of the file.

        Raises
        ------
        InputError
            if an atom has no row, as where columns are shifted
        """
        rows = {}
        for entry in reversed(self.models[model]):
            rows.setdefault(_key(entry.place), []).append(entry.row)
        found = []
        for place in np.asarray(places):
            waiting = rows.get(_key(place))
            if not waiting:
                raise InputError(f"{self.path}: coordinates are not where they should be: rewrite it, such as by gemmi")
            found.append(waiting.pop())
        return found

    def withAlternates(self, model, moved):
        """Return moved places by row, with other conformers shifted like the atom of the same name.

        moved : dict, new places (Å) by row
        """
        byRow = {entry.row: entry for entry in self.models[model]}
        shifts = {(byRow[row].residue, byRow[row].name): place - byRow[row].place for row, place in moved.items()}
        whole = dict(moved)
        for entry in self.models[model]:
            shift = shifts.get((entry.residue, entry.name))
            if entry.row not in moved and entry.alternate and shift is not None:
                whole[entry.row] = entry.place + shift
        return {row: place for row, place in whole.items() if np.abs(place - byRow[row].place).max() >= _SAME}


class PDBModelFile(_ModelFile):
    """A PDB file."""

    suffixes = (".pdb", ".ent", ".pdb1")

    def __init__(self, path, text):
        self.path = path
        self._lines = text.splitlines(keepends=True)
        self.models = []
        isOpen = False
        for number, line in enumerate(self._lines):
            record = line[:6].rstrip().upper()
            if record in ("ATOM", "HETATM"):
                if not isOpen:
                    self.models.append([])
                    isOpen = True
                if hasCoordinates(line):
                    place = np.array([float(line[start : start + 8]) for start in (30, 38, 46)])
                    residue = (line[21:27], line[17:20])
                    self.models[-1].append(AtomEntry(number, place, residue, line[12:16].strip(), line[16].strip()))
            elif record in ("MODEL", "ENDMDL", "END"):
                isOpen = False
                if record == "MODEL":
                    self.models.append([])
                    isOpen = True
        self.models = [model for model in self.models if model]

    def write(self, moved, removed=(), added=()):
        """Return the text with new places.

        moved : dict, places (Å) by row; removed : set of rows; added : list of NewAtom
        """
        lines = list(self._lines)
        for row, place in moved.items():
            text = "".join(f"{value:8.3f}" for value in place)
            if len(text) != 24:
                raise InputError(f"{self.path}: coordinates beyond what a PDB file holds")
            lines[row] = f"{lines[row][:30]}{text}{lines[row][54:]}"
        names = {row: line[6:11] for row, line in enumerate(self._lines) if row in removed}
        following = self._newLines(added, removed)
        gone = {name.strip() for name in names.values()}
        written = []
        for row, line in enumerate(lines):
            if row not in removed and not (gone and line.startswith("CONECT") and line[6:11].strip() in gone):
                written.append(_withoutBonds(line, gone) if gone and line.startswith("CONECT") else line)
            written += following.get(row, [])
        return "".join(written)

    def _newLines(self, added, removed):
        """Return the lines of new atoms by the row after which they stand: the last one of their residue."""
        if not added:
            return {}
        last, residueOf = {}, {}
        for number, model in enumerate(self.models):
            for entry in model:
                last[number, entry.residue] = entry.row
                residueOf[entry.row] = number, entry.residue
        serial = max((int(line[6:11]) for line in self._lines if _hasSerial(line)), default=0)
        lines = {}
        for atom in added:
            serial += 1
            pattern = self._lines[atom.bearer]
            name = atom.name if len(atom.name) == 4 else f" {atom.name:<3}"
            place = "".join(f"{value:8.3f}" for value in atom.place)
            rest = f"{pattern[54:76].rstrip():<22}{'H':>2}"
            line = f"{pattern[:6]}{serial % 100000:5d} {name}{pattern[16:27]}   {place}{rest}\n"
            lines.setdefault(self._lastLineOf(last[residueOf[atom.bearer]]), []).append(line)
        return lines

    def _lastLineOf(self, row):
        """Return the row of the last line that belongs to the atom of a row."""
        while row + 1 < len(self._lines) and self._lines[row + 1][:6].rstrip() in _OF_ATOMS:
            row += 1
        return row


class MmCIFModelFile(_ModelFile):
    """An mmCIF file."""

    suffixes = (".cif", ".mmcif")

    def __init__(self, path, text):
        self.path = path
        try:
            self._document = gemmi.cif.read_string(text)
        except Exception as error:
            raise InputError(f"{path}: not an mmCIF file that can be read ({firstLine(error)})") from error
        blocks = [block for block in self._document if block.find_mmcif_category("_atom_site.")]
        if not blocks:
            raise InputError(f"{path}: there are no atoms in _atom_site")
        self._item = blocks[0].find_loop("_atom_site.Cartn_x")
        self._loop = self._item.get_loop()
        if self._loop is None:
            raise InputError(f"{path}: _atom_site is not a loop")
        self._tags = list(self._loop.tags)
        columns = {tag: [] for tag in self._tags}
        for row in range(self._loop.length()):
            for number, tag in enumerate(self._tags):
                columns[tag].append(self._loop[row, number])
        self._columns = columns
        self._readModels()

    def _readModels(self):
        columns = self._columns
        count = self._loop.length()

        def column(*names):
            found = next((columns[f"_atom_site.{name}"] for name in names if f"_atom_site.{name}" in columns), None)
            return [gemmi.cif.as_string(value) for value in found] if found else [""] * count

        try:
            texts = [[value.partition("(")[0] for value in column(f"Cartn_{axis}")] for axis in "xyz"]
            places = np.array(texts, dtype=np.float64).T
        except ValueError as error:
            raise InputError(f"{self.path}: a coordinate is no number ({firstLine(error)})") from error
        residues = zip(
            column("auth_asym_id", "label_asym_id"), column("auth_seq_id", "label_seq_id"),
            column("pdbx_PDB_ins_code"), column("label_comp_id", "auth_comp_id"), strict=True,
        )  # fmt: skip
        names, alternates = column("label_atom_id", "auth_atom_id"), column("label_alt_id")
        byModel = {}
        rows = zip(column("pdbx_PDB_model_num"), places, residues, names, alternates, strict=True)
        for row, (model, place, residue, name, alternate) in enumerate(rows):
            byModel.setdefault(model, []).append(AtomEntry(row, place, residue, name, alternate))
        self.models = list(byModel.values())

    def write(self, moved, removed=(), added=()):
        """Return the text with new places; arguments as for a PDBModelFile."""
        columns = {tag: list(values) for tag, values in self._columns.items()}
        for row, place in moved.items():
            for axis, value in zip("xyz", place, strict=True):
                values = columns[f"_atom_site.Cartn_{axis}"]
                digits = len(values[row].partition("(")[0].partition(".")[2]) or 3
                values[row] = f"{value:.{digits}f}"
        following = self._newRows(added)
        order = []
        for row in range(self._loop.length()):
            if row not in removed:
                order.append({tag: columns[tag][row] for tag in self._tags})
            order += following.get(row, [])
        self._loop.set_all_values([[row[tag] for row in order] for tag in self._tags])
        return self._document.as_string()

    def _newRows(self, added):
        last, residueOf = {}, {}
        for number, model in enumerate(self.models):
            for entry in model:
                last[number, entry.residue] = entry.row
                residueOf[entry.row] = number, entry.residue
        numbers = self._columns.get("_atom_site.id", [])
        identity = max((int(value) for value in numbers if value.isdigit()), default=0)
        rows = {}
        for atom in added:
            identity += 1
            values = {tag: self._columns[tag][atom.bearer] for tag in self._tags}
            quoted = gemmi.cif.quote(atom.name)
            changed = {"id": str(identity), "type_symbol": "H", "label_atom_id": quoted, "auth_atom_id": quoted}
            changed |= {f"Cartn_{axis}": f"{value:.3f}" for axis, value in zip("xyz", atom.place, strict=True)}
            values |= {f"_atom_site.{key}": value for key, value in changed.items() if f"_atom_site.{key}" in values}
            rows.setdefault(last[residueOf[atom.bearer]], []).append(values)
        return rows


def _key(place):
    return tuple(round(1e4 * float(value)) for value in place)


def _hasSerial(line):
    return line[:6].rstrip() in ("ATOM", "HETATM", "TER") and line[6:11].strip().isdigit()


def _withoutBonds(line, gone):
    """Return a CONECT line without atoms of some numbers."""
    numbers = [line[start : start + 5] for start in range(6, len(line.rstrip()), 5)]
    kept = "".join(f"{number:>5}" for number in numbers if number.strip() not in gone)
    return f"CONECT{kept}\n"
