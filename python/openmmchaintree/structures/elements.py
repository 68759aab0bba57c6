"""The elements of atoms: by their residues, by the columns of their names, and by the symbols in the file.

A name alone is ambiguous: CA is a carbon in alanine and calcium in a residue CA, HG a hydrogen in cysteine and mercury
elsewhere. Symbols in the file may be wrong, too: some programs write the first letters of all names.
"""

from collections import defaultdict
from functools import cache

import gemmi

from ..datatables import readNames
from ..extras import importExtra
from ..pseudoatoms import isSite
from ..residues import isCalledWater, isPolymerName
from ..templates import mayBeHydrogen

NO_ELEMENT = "X"

# The elements of amino acids, nucleotides and water, except selenium.
_OF_POLYMERS = set("HDCNOSP")

# Elements of one letter that may begin a name in other residues, and elements that must be all letters of a name (B1).
_ONE_LETTER = {*_OF_POLYMERS, "F"}
_WHOLE_NAMES = set("BIKVWUY")

# Symbols of two letters that never begin the name of an atom of another element.
_CERTAIN = {"BR", "FE", "ZN", "MG", "MN", "CU"}

# Symbols of two letters that mean this element if a name begins with them and nothing else is known.
_LIKELY = {"CL", "SE", "SI", "AL", *_CERTAIN}

# Names of atoms with a Greek letter that are also symbols of elements.
_GREEK = {"CA", "CD", "CE", "NA", "NB", "ND", "NE", "HG", "HE", "HO", "PA", "PB", "PD", "SB", "SG", "OG"}


def findElements(atoms):
    """Find the elements of atoms.

    Parameters
    ----------
    atoms : set of (str, str, str)
        residue name; atom name, in its four columns if the file has these; the symbol in the file

    Returns
    -------
    dict
        by these tuples the symbol in capitals, X for pseudo-atoms and unknown elements
    """
    names = defaultdict(set)
    for residue, column, _ in atoms:
        names[residue].add(column.strip())
    isAligned = _areAligned(atoms)
    return {
        (residue, column, given): _Atom(residue, names[residue], column, given, isAligned).findElement()
        for residue, column, given in atoms
    }


def _areAligned(atoms):
    """Whether only names with a symbol of two letters begin in the first column, as they should.

    Some programs begin all names there.
    """
    short = [column for _, column, _ in atoms if len(column) == 4 and len(column.strip()) < 4]
    plain = [column for column in short if len(_letters(column)) < 2 or not _isSymbol(_letters(column)[:2])]
    return any(column[0] == " " for column in short) and all(column[0] in " 0123456789" for column in plain)


class _Atom:
    def __init__(self, residue, names, column, given, isAligned):
        self._residue = residue
        self._names = names
        self._column = column
        self._isAligned = isAligned
        self._name = column.strip()
        self._letters = _letters(self._name)
        self._given = given.upper() if _isSymbol(given) else ""

    def findElement(self):
        if isSite(self._residue, self._name, lambda: self._names, bool(self._given)):
            return NO_ELEMENT
        if isPolymerName(self._residue) or isCalledWater(self._residue):
            return self._inPolymer()
        return self._asIon() or (self._givenElement() if self._given else self._elementOfName()) or NO_ELEMENT

    def _inPolymer(self):
        first = self._letters[:1]
        if self._letters[:2] == "SE":
            return "SE"
        if first and first in _OF_POLYMERS:
            return "D" if self._given == "D" and first == "H" else first
        return self._given or self._elementOfName() or NO_ELEMENT

    def _asIon(self):
        """Return the element of a single atom whose residue has its name, or is a known ion."""
        if len(self._names) > 1:
            return None
        if self._residue in _ions():
            return _ions()[self._residue]
        core = _core(self._residue)
        return core if core == _core(self._name) and _isSymbol(core) and core not in _OF_POLYMERS else None

    def _givenElement(self):
        """Return the element in the file, unless the residue and the column of the name show another."""
        given = self._given
        if len(given) == 1:
            isCut = self._letters[:2] in _CERTAIN and self._letters[0] == given and given not in _OF_POLYMERS
            return self._letters[:2] if isCut and self._column[0] != " " else given
        if given not in _GREEK or not self._letters.startswith(given) or len(self._names) == 1:
            return given
        isAmino = given == "CA" and {"N", "C"} <= self._names
        if not isAmino and not (self._isAligned and self._column[0] == " "):
            return given
        return self._fromDictionary() or given[0]

    def _elementOfName(self):
        """Return the element of an atom without a symbol in the file."""
        one, two = self._letters[:1], self._letters[:2]
        if two in _CERTAIN:
            return two
        if len(two) == 2 and _isSymbol(two):
            isFull = len(self._name) == 4 and self._column[0] != " "  # such as CME1, which must begin there
            if self._isAligned and not isFull:
                return two if self._column[0] != " " else one
            if two in _LIKELY and (not isFull or self._letters[2:].isdigit()):
                return two
            known = self._fromDictionary()
            if known:
                return known
        return one if one in _ONE_LETTER or (one in _WHOLE_NAMES and _core(self._name) == one) else None

    def _fromDictionary(self):
        return _dictionaryElements(self._residue, frozenset(self._names)).get(self._name)


def _letters(name):
    """Return a name without the characters before its first letter, as in 1HB."""
    return name.strip().lstrip("0123456789'\"*+-").upper()


def _core(name):
    """Return the name of an ion without charge and number, as in NA+ and 3CO."""
    return _letters(name).rstrip("0123456789+-")


@cache
def _isSymbol(text):
    # gemmi reads unknown symbols as X.
    return gemmi.Element(text).atomic_number > 0 or text.upper() == "D"


@cache
def _ions():
    return {residue: symbol.upper() for residue, symbol in readNames("ion")}


@cache
def _dictionaryElements(residueName, atomNames):
    """Return the elements of a residue's atoms by their names, in capitals; {} if the dictionary lacks the residue.

    atomNames : frozenset of str; the residue must have all of these atoms except hydrogens
    """
    info = importExtra("biotite.structure.info", f"finding the elements of {residueName}")
    try:
        known = info.residue(residueName, allow_missing_coord=True)
    except KeyError:
        return {}
    elements = dict(zip(known.atom_name.tolist(), (symbol.upper() for symbol in known.element.tolist()), strict=True))
    return elements if all(name in elements for name in atomNames if not mayBeHydrogen(name)) else {}
