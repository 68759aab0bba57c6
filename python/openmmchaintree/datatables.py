"""The package's tables: CSV files, whose comments name their sources."""

import csv
from functools import cache
from pathlib import Path

_FOLDER = Path(__file__).parent / "tables"


def readTable(name):
    """Return the rows of a table, without its comments and the line of column names."""
    return readRows(_FOLDER / name)


def readRows(path):
    """Return the rows of a CSV file, without comments and the line of column names."""
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.reader(line for line in file if not line.startswith("#")))[1:]


@cache
def readNames(kind):
    """Return the columns residue and atom of each row of a kind in the table of names."""
    return [(residue, atoms) for found, residue, atoms, _ in readTable("names.csv") if found == kind]
