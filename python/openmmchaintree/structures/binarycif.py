"""Reading BinaryCIF by biotite. Sizes are checked first, since biotite decodes arrays of any size."""

import gemmi
import msgpack
import numpy as np
from biotite.structure.io.pdbx import BinaryCIFFile
from biotite.structure.io.pdbx.encoding import decode_stepwise, deserialize_encoding

from .limits import checkMemory

# Upper bounds of memory in bytes: for an item of the file's tree, for a cell in the result, for it while it is read.
_ITEM, _CELL, _TEXT, _NUMBER = 100, 40, 64, 128

_LONGEST_LIST = 10000  # of categories, columns or encodings


def readCategories(data, names, what):
    """Yield the name and the columns of each of some categories that a file has.

    Columns are lists of values as a CIF file would write them; masked values are . or ?.

    Parameters
    ----------
    data : bytes-like
        the content of the file
    names : sequence of str
        the categories
    what : str
        begins the message about a file that is too large, as for `checkMemory`

    Raises
    ------
    InputError
        if it would take too much memory
    Exception
        if it is damaged
    """
    content = _unpack(data, what)
    block = BinaryCIFFile.deserialize(content).block
    encoded = {category["name"].lstrip("_"): category for category in content["dataBlocks"][0]["categories"]}
    cells = 0
    for name in names:
        if name not in block:
            continue
        columns = {}
        for column in encoded[name]["columns"]:
            for part in (column["data"], column["mask"]):
                if part is not None:
                    _checkSizes(part, what)
            found = block[name][column["name"]]
            array = found.data.array
            width = array.dtype.itemsize if array.dtype.kind == "U" else _NUMBER
            checkMemory(len(array) * (width + _TEXT), what)
            cells += len(array)
            checkMemory(cells * _CELL, what)
            columns[column["name"]] = _textOf(found)
        yield name, columns


def _unpack(data, what):
    """Return the tree of a file, in which columns are still encoded."""
    items = 0

    def count(container):
        nonlocal items
        items += len(container)
        checkMemory(items * _ITEM, what)
        return container

    longest = {"max_array_len": _LONGEST_LIST, "max_map_len": _LONGEST_LIST}
    return msgpack.unpackb(data, raw=False, list_hook=count, object_hook=count, **longest)


def _checkSizes(part, what):
    """Raise an InputError if an encoded array would become too large."""
    outermost, *others = part["encoding"]
    if outermost["kind"] == "StringArray":
        _checkNumbers([*outermost["offsetEncoding"], *outermost["dataEncoding"], *others], what)
        offsets = _decode(outermost["offsets"], outermost["offsetEncoding"])
        lengths = np.diff(offsets.astype(np.int64))
        if len(lengths) == 0 or offsets[0] < 0 or lengths.min() < 0:
            raise ValueError("a column's strings are not in order")
        rows = len(_decode(_decode(part["data"], others), outermost["dataEncoding"]))
        checkMemory(max(rows, len(lengths)) * 4 * int(lengths.max()), what)
    else:
        _checkNumbers(part["encoding"], what)


def _checkNumbers(encodings, what):
    for encoding in encodings:
        if encoding["kind"] == "StringArray":
            raise ValueError("a column's numbers are encoded as strings")
        if encoding["kind"] == "RunLength" and not isinstance(encoding.get("srcSize"), int):
            raise ValueError("an array has no size")
        if isinstance(size := encoding.get("srcSize"), int):
            checkMemory(8 * size, what)


def _decode(data, encodings):
    return decode_stepwise(data, [deserialize_encoding(encoding) for encoding in encodings]) if encodings else data


def _textOf(column):
    """Return the values of a column as a CIF file would write them; equal ones are one object."""
    written = {".": ".", "?": "?"}
    values = column.as_array(str).tolist()
    for value in values:
        if value not in written:
            written[value] = gemmi.cif.quote(value)
    return [written[value] for value in values]
