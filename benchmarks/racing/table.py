"""Tables, on the terminal and as Markdown, and the numbers in them."""

from typing import NamedTuple

import numpy as np
import rich.table
from rich import box


class Table(NamedTuple):
    """A table: the first columns, as many as `words`, are of words, the others of numbers."""

    heading: str
    columns: list[str]
    rows: list[list[str]]
    words: int
    notes: list[str]

    def print(self, console):
        """Print it on a rich Console, in lines as long as they are."""
        table = rich.table.Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
        for number, column in enumerate(self.columns):
            table.add_column(column, justify="left" if number < self.words else "right", no_wrap=True)
        for row in self.rows:
            table.add_row(*row)
        console.print(f"\n{self.heading}:")
        console.print(table)
        for note in self.notes:
            console.print(note)

    def markdown(self):
        """Return it as Markdown."""
        marks = ["---" if number < self.words else "---:" for number in range(len(self.columns))]
        lines = [f"| {' | '.join(cells)} |" for cells in (self.columns, marks, *self.rows)]
        return "\n".join([f"**{self.heading}**\n", *lines, *(f"\n{note}" for note in self.notes)])


def groupBy(entries, keyOf):
    """Return entries by a key, in the order in which keys come."""
    groups = {}
    for entry in entries:
        groups.setdefault(keyOf(entry), []).append(entry)
    return groups


def sizeOf(entry):
    """Return the number of spheres."""
    return entry["particles"]


def exponent(values):
    """Return x where values, by size, go as size^x: the slope of the line through all logarithms."""
    return float(np.polyfit(np.log(list(values)), np.log(list(values.values())), 1)[0])


def number(value):
    """Return a positive number with about three digits."""
    return f"{value:,.0f}" if value >= 100 else f"{value:.1f}" if value >= 10 else f"{value:.2f}"
