"""The lines of a PDB file, checked and put right where programs write what the format does not allow.

The reader behind takes some such lines for others than they are: it cuts residue names of four letters, reads names
that begin in the wrong column as other elements, ends at the first END, and reads numbers that are none as 0.
"""

import re
from typing import NamedTuple

from .residues import aminoAcid, isNucleotide, isWater

# Records that are read, beside those of models.
_RECORDS = {"CRYST1", "TER", "LINK", "SSBOND", "CONECT"}

_COORDINATES = (slice(30, 38), slice(38, 46), slice(46, 54))

# Of names in residues of unknown kind that begin a column too early, those that are not carbon, nitrogen and so on.
_TWO_LETTER_ELEMENTS = {"CL", "BR", "FE", "ZN", "MG", "MN", "CU", "SE", "SI", "AL"}

# Of these, those that no names of lighter elements begin with.
_CERTAIN_ELEMENTS = {"BR", "FE", "ZN", "MG", "MN", "CU"}


class PDBLines(NamedTuple):
    """A PDB file that can be read.

    text : str, all models before the first damaged one; None if that is the first
    residueNames : dict, the names for which shorter ones stand in the text
    damage : str, what is wrong with the file, or None
    """

    text: str | None
    residueNames: dict[str, str]
    damage: str | None


def repairLines(text):
    """Check the lines of a PDB file, and return them as a PDBLines.

    Models are numbered anew; an END between models, which some programs write in place of MODEL and ENDMDL, ends one.
    """
    return _Repair().run(text)


class _Repair:
    def __init__(self):
        self._lines = []
        self._models = 0
        self._isOpen = False
        self._modelStart = 0
        self._shortNames = {}
        # MODEL without ENDMDL is a file cut off; atoms without MODEL are not.
        self._wantsEnd = False

    def run(self, text):
        damage = None
        given = text.splitlines()
        self._hasLongChains = any(map(_isOfLongChain, given))
        for number, line in enumerate(given):
            record = line[:6].rstrip().upper()
            if record in ("ATOM", "HETATM"):
                if not _hasCoordinates(line):
                    line = _shiftBack(line)
                if not _hasCoordinates(line):
                    damage = f"line {number + 1} has no coordinates where they should be (columns 31 to 54)"
                    break
                if not self._isOpen:
                    self._openModel()
                self._lines.append(self._repairAtom(line))
            elif record == "MODEL":
                self._closeModel()
                self._openModel()
                self._wantsEnd = True
            elif record in ("ENDMDL", "END"):
                self._closeModel()
            elif record in _RECORDS:
                self._lines.append(line)
        else:
            if self._isOpen and self._wantsEnd:
                damage = f"the file ends within model {self._models - 1} (from 0)"
            self._closeModel()
        if damage is not None:
            if self._models < 2:
                return PDBLines(None, {}, damage)
            # Bonds stand behind all models.
            bonds = [line for line in given[number:] if line.startswith("CONECT")]
            self._lines[self._modelStart :] = bonds
        names = {short: name for name, short in self._shortNames.items()}
        return PDBLines("\n".join([*self._lines, "END", ""]), names, damage)

    def _openModel(self):
        self._models += 1
        self._modelStart = len(self._lines)
        self._lines.append(f"MODEL     {self._models:4d}")
        self._isOpen = True

    def _closeModel(self):
        if self._isOpen:
            self._lines.append("ENDMDL")
        self._isOpen = False

    def _repairAtom(self, line):
        name = line[17:21].strip()
        if line[20] != " ":
            if not self._hasLongChains:
                line = f"{line[:17]}{self._shortNameFor(name)} {line[21:]}"
            else:
                name = line[17:20].strip()  # the rest belongs to the chain
        # In old files there are other things in the columns of element and charge.
        line = line[:78]
        if not line[76:78].strip().isalpha():
            line = f"{line[:76]:76}{_guessElement(line[12:16], name) or '':>2}"
        return line

    def _shortNameFor(self, name):
        if name not in self._shortNames:
            high, low = divmod(len(self._shortNames), len(_DIGITS))
            self._shortNames[name] = f"~{_DIGITS[high % len(_DIGITS)]}{_DIGITS[low]}"
        return self._shortNames[name]


_DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ"


def _hasCoordinates(line):
    if len(line) < _COORDINATES[-1].stop:
        return False
    try:
        for columns in _COORDINATES:
            float(line[columns])
    except ValueError:
        return False
    return True


def _shiftBack(line):
    """Return a line in which numbers too large for their columns have moved the rest, with the rest in its place."""
    if re.match(r".{6}\d{6}", line):
        line = f"{line[:6]}*****{line[12:]}"
    if re.match(r".{22}\d{5}", line):
        line = line[:22] + line[23:]
    return line


def _isOfLongChain(line):
    """Whether column 21 of a line is the first of two letters of a chain, and not the last of TIP3 or HISE."""
    return (
        line[20:22].strip() == line[20:22] != ""
        and line.startswith(("ATOM", "HETATM"))
        and aminoAcid(line[17:20]) is not None
        and aminoAcid(line[17:21]) is None
    )


def _guessElement(name, residue):
    """Return the element of an atom whose line tells none, or None where the column of its name tells it."""
    letters = name.strip().lstrip("0123456789")
    if not letters:
        return None
    twoLetters = {"SE"} if residue == "MSE" else _TWO_LETTER_ELEMENTS
    if aminoAcid(residue) is not None or isNucleotide(residue) or isWater(residue):
        twoLetters = twoLetters & {"SE"}
    elif letters[:2] in _CERTAIN_ELEMENTS:
        return letters[:2]
    elif not name[0].isalpha() or letters == residue or len(name.strip()) == 4:
        return None
    if letters[:2] in twoLetters:
        return letters[:2]
    return letters[0] if letters[0] in "HDCNOSP" else None
