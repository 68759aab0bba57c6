"""The lines of a PDB file, checked, and repaired if a program deviated from the format.

gemmi would misread some such lines: it cuts residue names of four letters, reads names that begin in the wrong column
as other elements, stops at the first END, and reads malformed numbers as 0.
"""

import re
from typing import NamedTuple

import gemmi

from ..residues import isCalledWater, isPolymerName
from .elements import findElements

# Records that are read, besides those of models.
_RECORDS = {
    "CRYST1", "SCALE1", "SCALE2", "SCALE3", "MTRIX1", "MTRIX2", "MTRIX3", "TER", "LINK", "SSBOND", "CONECT", "SEQRES",
}  # fmt: skip

_COORDINATES = (slice(30, 38), slice(38, 46), slice(46, 54))

# Names of four letters that programs write, although the first three letters are the name of another residue.
_FOUR_LETTERS = {
    "ALAD", "POPC", "POPE", "POPG", "POPS", "POPA", "POPI", "DPPC", "DPPE", "DPPG", "DMPC", "DMPG", "DOPC", "DOPE",
    "DOPS", "DOPG", "DLPC", "DLPE", "DSPC", "CHL1", "CHOL", "HEME", "BMAN", "BGLC", "AGLC", "BGAL", "AMAN", "AFUC",
}  # fmt: skip


class PDBLines(NamedTuple):
    """A PDB file that can be read.

    text : str, all models before the first damaged one; None if the first model is damaged
    cells : list of str, the CRYST1 line of each model, the last one before its last atom; empty for models without one
    residueNames : dict, the original names by the shorter ones in the text
    damage : str, a description of the damage, or None
    """

    text: str | None
    cells: list[str]
    residueNames: dict[str, str]
    damage: str | None


def repairLines(text):
    """Check the lines of a PDB file, and return them as a PDBLines.

    Models are renumbered. An END, which some programs write instead of MODEL and ENDMDL, ends a model, too.
    """
    return _Repair().run(text)


class _Repair:
    def __init__(self):
        self._lines = []
        self._models = 0
        self._isOpen = False
        self._modelStart = 0
        self._cell = ""
        self._cells = []
        self._shortNames = {}
        self._atoms = []  # for each atom the index of its line, and the arguments of findElements
        # A file that ends within a MODEL was cut off.
        self._wantsEnd = False

    def run(self, text):
        damage = None
        given = text.splitlines()
        self._hasLongChains = _haveLongChains(given)
        for number, line in enumerate(given):
            record = line[:6].rstrip().upper()
            if record in ("ATOM", "HETATM"):
                if not hasCoordinates(line):
                    line = _shiftBack(line)
                if not hasCoordinates(line):
                    damage = f"line {number + 1} has no coordinates where they should be (columns 31 to 54)"
                    break
                if not self._isOpen:
                    self._openModel()
                self._addAtom(line)
            elif record == "MODEL":
                self._closeModel()
                self._openModel()
                self._wantsEnd = True
            elif record in ("ENDMDL", "END"):
                self._closeModel()
            elif record in _RECORDS:
                self._cell = line if record == "CRYST1" else self._cell
                self._lines.append(line)
        else:
            if self._isOpen and self._wantsEnd:
                damage = f"the file ends within model {self._models - 1} (from 0)"
            self._closeModel()
        if damage is not None:
            if self._models < 2:
                return PDBLines(None, [], {}, damage)
            # Bonds come after all models.
            bonds = [line for line in given[number:] if line.startswith("CONECT")]
            self._lines[self._modelStart :] = bonds
            del self._cells[-1]
            self._atoms = [atom for atom in self._atoms if atom[0] < self._modelStart]
        self._tellElements()
        names = {short: name for name, short in self._shortNames.items()}
        return PDBLines("\n".join([*self._lines, "END", ""]), self._cells, names, damage)

    def _openModel(self):
        self._models += 1
        self._modelStart = len(self._lines)
        self._lines.append(f"MODEL     {self._models:4d}")
        self._cells.append(self._cell)
        self._isOpen = True

    def _closeModel(self):
        if self._isOpen:
            self._lines.append("ENDMDL")
        self._isOpen = False

    def _addAtom(self, line):
        self._cells[-1] = self._cell
        name = line[17:21].strip()
        if line[20] != " ":
            if self._hasLongChains and line[21] != " ":
                name = line[17:20].strip()  # the rest belongs to the chain
            else:
                line = f"{line[:17]}{self._shortNameFor(name)} {line[21:]}"
        self._atoms.append((len(self._lines), (name, line[12:16], line[76:78].strip())))
        # Old files have other data in the columns of element and charge.
        self._lines.append(line[:76])

    def _tellElements(self):
        elements = findElements({kind for _, kind in self._atoms})
        for index, kind in self._atoms:
            self._lines[index] = f"{self._lines[index]:76}{elements[kind]:>2}"

    def _shortNameFor(self, name):
        if name not in self._shortNames:
            high, low = divmod(len(self._shortNames), len(_DIGITS))
            self._shortNames[name] = f"~{_DIGITS[high % len(_DIGITS)]}{_DIGITS[low]}"
        return self._shortNames[name]


_DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ"


def hasCoordinates(line):
    """Return whether a line of an atom has its coordinates in columns 31 to 54."""
    if len(line) < _COORDINATES[-1].stop:
        return False
    try:
        for columns in _COORDINATES:
            float(line[columns])
    except ValueError:
        return False
    return True


def _shiftBack(line):
    """Return a line with its columns in place, if numbers too large for their columns have shifted them."""
    if re.match(r".{6}\d{6}", line):
        line = f"{line[:6]}*****{line[12:]}"
    if re.match(r".{22}\d{5}", line):
        line = line[:22] + line[23:]
    return line


def _haveLongChains(lines):
    """Whether column 21 of atoms is the first letter of a chain's name of two, not the last letter of TIP3 or HISE.

    Each residue name counts as one vote.
    """
    names = {line[17:22] for line in lines if line[20:21].strip() and line[:6].upper() in ("ATOM  ", "HETATM")}
    votes = [vote for vote in {name[:4]: _isOfLongChain(name) for name in names}.values() if vote is not None]
    return 2 * votes.count(True) > len(votes)


def _isOfLongChain(columns):
    """Whether columns 18 to 22 are a residue and a chain of two letters; None if that is not known."""
    short, long, chain = columns[:3].strip(), columns[:4].strip(), columns[3:5]
    if not short or len(chain.strip()) < 2 or long in _FOUR_LETTERS:
        return False
    if columns[0] == " " and _isKnown(short):  # a name of four letters begins in the first column
        return True
    if _isKnown(short) or _isKnown(long):
        return not _isKnown(long)
    return True if columns[0] == " " or chain[0].islower() else None


def _isKnown(name):
    """Whether a residue name is that of a polymer, cap, water, ion or a compound that many files have."""
    return isPolymerName(name) or isCalledWater(name) or gemmi.find_tabulated_residue(name).found()
