"""Reading files of small molecules, SDF (and MOL) and Mol2, as structures of gemmi with the bonds of the file.

biotite reads the tables of an SDF record, but ignores a missing end. MDTraj's reader of Mol2 needs pandas.
"""

from collections import Counter
from typing import NamedTuple

import gemmi

from ..errors import InputError, firstLine
from ..extras import importExtra

MOLECULE_SUFFIXES = (".sdf", ".sd", ".mol", ".mol2")

_UNKNOWN = "UNL"  # the name of an unknown ligand in the Protein Data Bank
_END = "M  END"
_SECTION = "@<TRIPOS>"

# The orders of bonds other than single ones, by the numbers of biotite's BondType and by the words of Mol2. Aromatic
# bonds outside rings, as of carboxylates, count as double.
_ORDERS = {2: 2, 3: 3, 5: 2, 6: 2, 7: 3, 9: 2}
_ORDERS_OF_MOL2 = {"2": 2, "3": 3, "ar": 2}


class _Row(NamedTuple):
    """An atom: name, symbol, position in Å, residue's number and name."""

    name: str
    symbol: str
    position: tuple[float, float, float]
    number: int
    residue: str


def readMolecules(path, text, suffix):
    """Read the molecules of a file, conformers of each other, as models.

    Returns
    -------
    gemmi.Structure
        of the molecules before the first damaged one, with the bonds of the first
    InputError or None
        the description of that damage

    Raises
    ------
    InputError
        if the first molecule cannot be read
    """
    isMol2 = suffix == ".mol2"
    read = _readMol2 if isMol2 else _readSDF
    structure = gemmi.Structure()
    structure.input_format = gemmi.CoorFormat.ChemComp
    for number, record in enumerate(_recordsOf(text, isMol2)):
        try:
            rows, bonds = read(record)
            if not rows:
                raise ValueError("there are no atoms")
        except Exception as error:  # biotite and Python raise many kinds
            kind = "a Mol2" if isMol2 else "an SDF"
            damage = InputError(f"{path}: molecule {number} (from 0) is not one of {kind} file ({firstLine(error)})")
            if number == 0:
                raise damage from error
            return structure, damage
        structure.add_model(_modelOf(rows, number + 1))
        for first, second, order in bonds if number == 0 else ():
            structure.add_conect(first + 1, second + 1, order)
    if len(structure) == 0:
        raise InputError(f"{path}: there are no molecules")
    return structure, None


def _recordsOf(text, isMol2):
    """Return the texts of the molecules."""
    text = text.replace("\r\n", "\n")
    if isMol2:
        return text.split(f"{_SECTION}MOLECULE")[1:]
    records = text.split("\n$$$$")
    return [record.removeprefix("\n") if i else record for i, record in enumerate(records) if record.strip()]


def _readSDF(record):
    mol = importExtra("biotite.structure.io.mol", "reading SDF")
    if _END not in record:
        raise ValueError(f"it is cut off: it lacks {_END}")
    atoms = mol.SDRecord.deserialize(record.split(_END)[0] + _END).get_structure()
    counts = Counter()
    rows = []
    for symbol, position in zip(atoms.element.tolist(), atoms.coord.tolist(), strict=True):
        counts[symbol] += 1
        rows.append(_Row(f"{symbol.upper()}{counts[symbol]}", symbol, tuple(position), 1, _UNKNOWN))
    return rows, [(first, second, _ORDERS.get(kind, 1)) for first, second, kind in atoms.bonds.as_array().tolist()]


def _readMol2(record):
    header, *sections = record.split(_SECTION)
    tables = {}
    for section in sections:
        name, *lines = section.split("\n")
        tables[name.strip()] = [line.split() for line in lines if line.strip() and not line.startswith("#")]
    counts = next(line for line in header.split("\n")[2:] if not line.startswith("#")).split()
    atoms, bonds = tables.get("ATOM", []), tables.get("BOND", [])
    if len(atoms) != int(counts[0]) or len(bonds) != (int(counts[1]) if len(counts) > 1 else 0):
        raise ValueError(f"it has {len(atoms)} atoms and {len(bonds)} bonds, but tells of {' and '.join(counts[:2])}")
    places = {words[0]: index for index, words in enumerate(atoms)}
    return [_rowOf(*words) for words in atoms], [
        (places[first], places[second], _ORDERS_OF_MOL2.get(kind, 1)) for _, first, second, kind, *_ in bonds
    ]


def _rowOf(identity, name, x, y, z, kind, number="1", residue=_UNKNOWN, *others):
    residue = residue.strip("<>*").rstrip("0123456789") or _UNKNOWN
    return _Row(name, _symbolOf(kind), (float(x), float(y), float(z)), int(number), residue)


def _symbolOf(kind):
    """Return the element of an atom by its type: of SYBYL, such as C.ar and Cl, or of GAFF, such as c3 and cl.

    X: its name shows the element, as for the types of other force fields, such as CT.
    """
    symbol = kind.partition(".")[0]
    if symbol.islower():
        symbol = (symbol[:2] if symbol[:2] in ("cl", "br") else symbol[:1]).capitalize()
    isSymbol = symbol == symbol.capitalize() and gemmi.Element(symbol).atomic_number > 0
    return symbol if isSymbol else "X"


def _modelOf(rows, number):
    model, chain, last = gemmi.Model(number), gemmi.Chain("A"), None
    for serial, row in enumerate(rows, 1):
        if (row.number, row.residue) != last:
            last = row.number, row.residue
            residue = gemmi.Residue()
            residue.name, residue.seqid = row.residue, gemmi.SeqId(row.number, " ")
            chain.add_residue(residue)
        atom = gemmi.Atom()
        atom.name, atom.element, atom.serial = row.name, gemmi.Element(row.symbol), serial
        atom.pos = gemmi.Position(*row.position)
        chain[-1].add_atom(atom)
    model.add_chain(chain)
    return model
