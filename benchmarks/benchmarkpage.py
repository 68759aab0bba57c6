"""Rewrite the tables of docs/benchmark.md from results: python benchmarks/benchmarkpage.py

The page says what a table shows: its heading, its columns, its rows, and by the last links to CSV files before it the
measurements. This script sets the other cells: medians, without their ranges over runs.
"""

import re
from pathlib import Path

import energytables
import movetables
import pivots
import racetables
import solventtables
from report import Table, readCSV

PROJECT = Path(__file__).parents[1]
PAGE = PROJECT / "docs" / "benchmark.md"

_MAKERS = (racetables, energytables, solventtables, movetables, pivots)
# Columns whose cells name a row.
_NAMES = {"", "chain", "moves", "rotations", "beads", "N", "protein", "U", "move", "mixture", "m"}
_NAMES |= {"cutoffs: Born sums / pairs, nm"}
_FILE = r"(?P<file>\.\./benchmarks/results/[\w-]+\.csv)"
_TABLE = re.compile(_FILE + r"|^\*\*(?P<heading>.+)\*\*\n\n(?P<lines>(?:\|.*\n)+)", re.MULTILINE)
_RANGE = re.compile(r" \([\d.,]+–[\d.,]+\)$")
_WITH_RANGE = ", median over chains (range)"  # in headings


class PageError(Exception):
    """A table of the page that is not in the results."""


def rewrite(text):
    """Return the text of the page with the cells of its tables from results."""
    files, used = [], False

    def replace(match):
        nonlocal files, used
        if match["file"]:
            files, used = [*([] if used else files), match["file"]], False
            return match[0]
        used = True
        return _tableOf(files, match["heading"], _cellsOf(match["lines"])).markdown() + "\n"

    return _TABLE.sub(replace, text)


def _tableOf(files, heading, shown):
    """Return a table with the columns and rows that the page shows."""
    columns, _, *rows = shown
    found = (table for file in files for table in _makeTables(file))
    tables = [table for table in found if table.heading.removesuffix(_WITH_RANGE) == heading]
    if not tables or not {*columns} <= {*tables[0].columns}:
        raise PageError(f"{', '.join(files)}: no table {heading!r} with the columns {columns}")
    places = [tables[0].columns.index(column) for column in columns]
    names = [number for number, column in enumerate(columns) if column in _NAMES]
    cells = [[_RANGE.sub("", row[place]) for place in places] for table in tables for row in table.rows]
    chosen = []
    for row in rows:
        found = [one for one in cells if all(one[number] == row[number] for number in names)]
        if len(found) != 1:
            raise PageError(f"{heading}: {len(found)} rows are named {[row[number] for number in names]}")
        chosen += found
    return Table(heading, columns, chosen, sum(place < tables[0].words for place in places), [])


def _makeTables(file):
    _, entries = readCSV(PAGE.parent / file)
    return [table for maker in _MAKERS for table in maker.makeTables(entries)]


def _cellsOf(lines):
    return [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in lines.splitlines()]


if __name__ == "__main__":
    PAGE.write_text(rewrite(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
