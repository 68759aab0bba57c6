"""The elements of atoms: by their residues, by the columns of their names, and by what the file says.

The name alone tells little: CA is a carbon in alanine and calcium in a residue CA, HG a hydrogen in cysteine and
mercury elsewhere. What the file says may be wrong, too: some programs take the first letters of all names.
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

# What amino acids, nucleotides and water are made of, selenium apart.
_OF_POLYMERS = set("HDCNOSP")

# Elements of one letter that names in other residues begin with, and those that are all of their letters, as in B1.
_ONE_LETTER = {*_OF_POLYMERS, "F"}
_WHOLE_NAMES = set("BIKVWUY")

# Elements of two letters that no names of lighter elements begin with.
_CERTAIN = {"BR", "FE", "ZN", "MG", "MN", "CU"}

# Elements whose names programs mostly mean where one begins with these letters and nothing else tells.
_LIKELY = {"CL", "SE", "SI", "AL", *_CERTAIN}

# Names of atoms in the field's Greek letters that are symbols of elements, too.
_GREEK = {"CA", "CD", "CE", "NA", "NB", "ND", "NE", "HG", "HE", "HO", "PA", "PB", "PD", "SB", "SG", "OG"}


def findElements(atoms):
    """Find the elements of atoms.

    Parameters
    ----------
    atoms : set of (str, str, str)
        residue name; atom name, in its four columns if the file has these; the symbol that the file gives

    Returns
    -------
    dict
        by these, the symbol in capitals, X for what is no atom or of no known element
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
    """Whether names begin in the first of their columns only if that is a part of the element, as they should.

    Some programs begin all of them there.
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
        """Return the element that the file gives, unless residue and column of the name agree on another."""
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
        """Return the element of an atom for which the file gives none."""
        one, two = self._letters[:1], self._letters[:2]
        if two in _CERTAIN:
            return two
        if len(two) == 2 and _isSymbol(two):
            isFull = len(self._name) == 4 and self._column[0] != " "  # as CME1, which has to begin there
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
    """Return a name without what stands before its letters, as in 1HB."""
    return name.strip().lstrip("0123456789'\"*+-").upper()


def _core(name):
    """Return the name of an ion without charge and number, as in NA+ and 3CO."""
    return _letters(name).rstrip("0123456789+-")


@cache
def _isSymbol(text):
    # The reader takes what it does not know for X.
    return gemmi.Element(text).atomic_number > 0 or text.upper() == "D"


@cache
def _ions():
    return {residue: symbol.upper() for residue, symbol in readNames("ion")}


@cache
def _dictionaryElements(residueName, atomNames):
    """Return the elements of a residue's atoms by their names, in capitals; none if the dictionary does not know it.

    atomNames : frozenset of str, all of which it has to have, hydrogens apart
    """
    info = importExtra("biotite.structure.info", f"finding the elements of {residueName}")
    try:
        known = info.residue(residueName, allow_missing_coord=True)
    except KeyError:
        return {}
    elements = dict(zip(known.atom_name.tolist(), (symbol.upper() for symbol in known.element.tolist()), strict=True))
    return elements if all(name in elements for name in atomNames if not mayBeHydrogen(name)) else {}
