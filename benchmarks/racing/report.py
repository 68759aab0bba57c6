"""What a run found: tables for people, and CSV with all numbers, from which the tables can be made again."""

import csv
import io
from typing import Any, NamedTuple

from openmmchaintree.errors import InputError

from .table import Table


class Report(NamedTuple):
    """What a run found.

    machine : dict of texts by their names, what the numbers belong to
    entries : list of dict, every measurement
    tables : list of Table
    remarks : list of str, lines that stand below the tables
    """

    machine: dict[str, str]
    entries: list[dict[str, Any]]
    tables: list[Table]
    remarks: list[str]

    def markdown(self):
        """Return it as Markdown."""
        heading = "\n".join(f"- {name}: {words}" for name, words in self.machine.items())
        remarks = "\n".join(f"- {remark}" for remark in self.remarks)
        return "\n\n".join([heading, *(table.markdown() for table in self.tables), *filter(None, [remarks])]) + "\n"

    def print(self, files, console):
        """Print it on a rich Console, and the names of files with more."""
        for name, words in self.machine.items():
            console.print(f"{name}: {words}")
        for table in self.tables:
            table.print(console)
        console.print()
        for remark in self.remarks:
            console.print(remark)
        if files:
            console.print(f"wrote {', '.join(map(str, files))}")


def asCSV(report):
    """Return CSV: what the numbers belong to in lines that begin with #, column names, a line for every entry."""
    text = io.StringIO()
    for name, words in report.machine.items():
        print(f"# {name}: {words}", file=text)
    entries = [dict(_leaves(entry)) for entry in report.entries]
    lines = csv.DictWriter(text, list(dict.fromkeys(key for entry in entries for key in entry)), lineterminator="\n")
    lines.writeheader()
    lines.writerows(entries)
    return text.getvalue()


def readCSV(path):
    """Return what asCSV has written: the machine and the entries.

    Raises
    ------
    InputError
        if the file is not of that kind
    """
    with open(path, encoding="utf-8", newline="") as file:
        lines = file.read().splitlines()
    heading = [line[2:].partition(": ") for line in lines if line.startswith("# ")]
    machine = {name: words for name, _, words in heading}
    entries = [_entryOf(values) for values in csv.DictReader(line for line in lines if not line.startswith("# "))]
    if not entries or any(not {"group", "contestant", "microseconds"} <= entry.keys() for entry in entries):
        raise InputError(f"{path}: is no CSV that the benchmarks wrote")
    return machine, entries


def _leaves(values, prefix=""):
    """Yield what is in dictionaries within dictionaries, under names with dots."""
    for key, value in values.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _entryOf(values):
    """Return the entry of a line of CSV: what is empty was not measured."""
    entry = {}
    for name, text in values.items():
        if text:
            *folders, key = name.split(".")
            place = entry
            for folder in folders:
                place = place.setdefault(folder, {})
            place[key] = _valueOf(text)
    return entry


def _valueOf(text):
    for read in (int, float):
        try:
            return read(text)
        except ValueError:
            pass
    return {"True": True, "False": False}.get(text, text)
