"""The package's tables: CSV files with comments that name their sources."""

import csv
from pathlib import Path

_FOLDER = Path(__file__).parent / "tables"


def readTable(name):
    """Return the rows of a table, without its comments and the line of column names."""
    with open(_FOLDER / name, newline="", encoding="utf-8") as file:
        return list(csv.reader(line for line in file if not line.startswith("#")))[1:]
