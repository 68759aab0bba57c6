"""Reading structure files: PDB, mmCIF, BinaryCIF, gro, SDF and Mol2, plain or compressed.

gemmi reads them: it keeps all digits of coordinates, distinguishes alternates, links and models, and accepts many
deviations from the formats. BinaryCIF, which gemmi cannot read, is decoded by biotite first.
"""

import bz2
import gzip
import re
import zlib
from contextlib import contextmanager
from pathlib import Path

import gemmi

from ..errors import InputError, firstLine
from ..extras import importExtra
from .coordinatefile import hasCoordinatesOnly
from .elements import NO_ELEMENT, findElements
from .grofile import readGro
from .limits import readAtMost
from .moleculefile import MOLECULE_SUFFIXES, readMolecules
from .pdblines import repairLines

# The first bytes of compressed files.
_GZIP, _BZIP2 = b"\x1f\x8b", b"BZh"

# White space and comments before the data of a CIF file; the beginning of an atom's line in a PDB file.
_BEFORE_DATA = re.compile(rb"\s+|#.*\n")
_ATOM = re.compile(rb"(?:\A|[\n\r\v\f\x1c-\x1e])(?:ATOM  |HETATM)", re.IGNORECASE)

# Columns of atoms that gemmi needs, each with the column that can replace it, and with a default value.
_REQUIRED = {
    "id": (None, "0"),
    "type_symbol": (None, "X"),
    "label_atom_id": ("auth_atom_id", "X"),
    "label_alt_id": (None, "."),
    "label_comp_id": ("auth_comp_id", "UNK"),
    "label_asym_id": ("auth_asym_id", "A"),
    "label_seq_id": (None, "?"),
    "auth_seq_id": ("label_seq_id", "1"),
    "auth_asym_id": ("label_asym_id", "A"),
    "occupancy": (None, "1"),
    "B_iso_or_equiv": (None, "0"),
    "pdbx_PDB_model_num": (None, "1"),
}

# Categories of an mmCIF or BinaryCIF file that are read.
_CATEGORIES = (
    "atom_site", "atom_sites", "cell", "symmetry", "struct_conn", "struct_conn_type", "struct_ncs_oper", "entry",
    "entity", "entity_poly", "entity_poly_seq", "struct_asym",
)  # fmt: skip


# Endings of names, without those of compression, by which the structure files of a folder are known.
_SUFFIXES = {".pdb", ".ent", ".cif", ".mmcif", ".bcif", ".gro", *MOLECULE_SUFFIXES}


def isStructureName(path):
    """Return whether a file is named as a structure; files are read by their content, whatever their names."""
    return _suffixOf(path) in _SUFFIXES


def _suffixOf(path):
    return Path(str(path).lower().removesuffix(".gz").removesuffix(".bz2")).suffix


def readFile(path):
    """Read a structure file.

    Returns
    -------
    gemmi.Structure
        of the models before the first damaged one
    list of gemmi.UnitCell
        the cell of each of these models
    InputError or None
        the description of that damage

    Raises
    ------
    InputError
        if the file, or its first model, cannot be read
    """
    data = readBytes(path)
    cells = damage = None
    suffix = _suffixOf(path)
    if data[:1] >= b"\x80" and b"dataBlocks" in data[:1000]:
        structure = _readBinaryCIF(path, data)
    elif suffix == ".gro":
        structure, cells, damage = readGro(path, data.decode("utf-8", errors="replace"))
    elif suffix in MOLECULE_SUFFIXES:
        structure, damage = readMolecules(path, data.decode("utf-8", errors="replace"), suffix)
    elif isMmCIF(data):
        structure = _readMmCIF(path, data.decode("utf-8", errors="replace"))
    else:
        structure, cells, damage = _readPDB(path, data)
    if structure.input_format != gemmi.CoorFormat.Pdb:
        _correctElements(structure)
    structure.remove_empty_chains()
    if len(structure) == 0 or not any(len(chain) for model in structure for chain in model):
        raise InputError(f"{path}: there are no atoms")
    return structure, cells or [structure.cell] * len(structure), damage


def readBytes(path):
    """Return the content of a file, decompressed."""
    try:
        with open(path, "rb") as file:
            start = file.peek(3)
            if start.startswith(_GZIP):
                return _decompress(path, gzip.GzipFile(fileobj=file))
            if start.startswith(_BZIP2):
                return _decompress(path, bz2.BZ2File(file))
            return readAtMost(file, f"{path}: has")
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from error


def _decompress(path, file):
    try:
        return readAtMost(file, f"{path}: holds, decompressed,")
    except InputError:
        raise
    except (EOFError, zlib.error, ValueError, OSError) as error:
        raise InputError(f"{path}: cannot be decompressed ({error})") from error


def isMmCIF(data):
    """Return whether bytes are those of a CIF file: they begin with a data block, after comments."""
    place = 0
    while skipped := _BEFORE_DATA.match(data, place):
        place = skipped.end()
    return data[place : place + 5].lower() == b"data_"


@contextmanager
def _explaining(path, kind):
    """Turn any exception that a reader of this kind of file raises into an InputError."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"{path}: not {kind} file that can be read ({firstLine(error)})") from error


def _readMmCIF(path, text):
    """Return a Structure. A damaged mmCIF file cannot be read in part."""
    with _explaining(path, "an mmCIF"):
        document = gemmi.cif.read_string(text)
        for block in document:
            if block.find_mmcif_category("_atom_site."):
                _fillIn(block)
                return _fromBlock(path, block)
        for block in document:
            if block.find_mmcif_category("_chem_comp_atom."):
                return gemmi.make_structure_from_chemcomp_block(block)
    raise InputError(f"{path}: there are no atoms")


def _fillIn(block):
    """Add columns of atoms that the reader needs, if a program has left them out."""
    columns = block.get_mmcif_category("_atom_site.", raw=True)
    names = columns.get("label_atom_id") or columns.get("auth_atom_id")
    missing = _REQUIRED.keys() - columns.keys()
    if not missing or not names:
        return
    for name in missing:
        source, value = _REQUIRED[name]
        columns[name] = columns.get(source) or [value] * len(names)
    if "type_symbol" in missing:
        columns["type_symbol"] = ["X"] * len(names)  # elements follow from names
    if "id" in missing:
        columns["id"] = [str(number + 1) for number in range(len(names))]
    block.set_mmcif_category("_atom_site.", columns, raw=True)


def _fromBlock(path, block):
    # Erase other categories, so that damage in them does not matter.
    for category in block.get_mmcif_category_names():
        if category.strip("_.").lower() not in _CATEGORIES:
            block.find_mmcif_category(category).erase()
    # gemmi would use only the first byte of these.
    for code in ("label_alt_id", "pdbx_PDB_ins_code"):
        strange = next((value for value in block.find_values(f"_atom_site.{code}") if not value.isascii()), None)
        if strange is not None:
            raise InputError(f"{path}: the {code} of an atom, {strange}, is not ASCII")
    return gemmi.make_structure_from_block(block)


def _correctElements(structure):
    """Correct elements that contradict residues and names of atoms."""

    def symbolOf(element):
        return "" if element == NO_ELEMENT else element

    atoms = [(residue.name, atom) for model in structure for chain in model for residue in chain for atom in residue]
    kinds = [(name, atom.name, symbolOf(atom.element.name.upper())) for name, atom in atoms]
    elements = findElements(set(kinds))
    wrong = {kind: element for kind, element in elements.items() if kind[2] != symbolOf(element)}
    for (_, atom), kind in zip(atoms, kinds, strict=True) if wrong else ():
        if kind in wrong:
            atom.element = gemmi.Element(wrong[kind])


def _readBinaryCIF(path, data):
    """Return a Structure."""
    # Few files are of this kind, and biotite takes a second to import.
    for package in ("biotite", "msgpack"):
        importExtra(package, "reading BinaryCIF")
    from .binarycif import readCategories

    with _explaining(path, "a BinaryCIF"):
        converted = gemmi.cif.Block("structure")
        for category, columns in readCategories(data, _CATEGORIES, f"{path}: holds, decoded,"):
            converted.set_mmcif_category(f"_{category}.", columns, raw=True)
        return _fromBlock(path, converted)


def _readPDB(path, data):
    """Return a Structure of the models before the first damaged one, their cells, and that damage or None.

    The cells are None if all are that of the Structure.
    """
    if _ATOM.search(data) is None:
        what = "is it a PDB or mmCIF file?"
        if hasCoordinatesOnly(path):
            what = "names of atoms are in another file, such as a prmtop, which sample --system reads"
        raise InputError(f"{path}: there are no atoms; {what}")
    text = data.decode("utf-8", errors="replace")
    if not text.isascii():
        text = text.encode("ascii", errors="replace").decode()  # columns are of one byte each
    lines = repairLines(text)
    damage = None if lines.damage is None else InputError(f"{path}: {lines.damage}")
    if lines.text is None:
        raise damage
    with _explaining(path, "a PDB"):
        structure = gemmi.read_pdb_string(lines.text, split_chain_on_ter=True)
    for model in structure:
        for chain in model:
            for residue in chain:
                residue.name = lines.residueNames.get(residue.name, residue.name)
    areOfModels = len(set(lines.cells)) > 1 and len(lines.cells) == len(structure)
    cells = [gemmi.read_pdb_string(line).cell for line in lines.cells] if areOfModels else None
    return structure, cells, damage
