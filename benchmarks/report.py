"""Reports: the machine that times belong to, measurements as CSV, and tables of them."""

import csv
import datetime
import importlib.metadata
import os
import platform
import statistics
import subprocess
from pathlib import Path
from typing import NamedTuple

import numpy as np
import openmm
import rich.table
from openmmchaintree.errors import InputError
from rich import box

# ---- The machine ----


def describeMachine(program):
    """Return texts by their names: processor, compiler, commit, versions, date and load."""
    versions = {"python": platform.python_version(), "openmm": openmm.Platform.getOpenMMVersion()}
    for name in ("numpy", "scipy", "python-fcl"):
        try:
            versions[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            pass
    return {
        "processor": f"{_processorModel()}, {os.cpu_count()} cores",
        "system": platform.platform(),
        "compiler": program.describeBuild(),
        "commit": _git("rev-parse", "--short=12", "HEAD") + (" (dirty)" if _git("status", "--porcelain") else ""),
        "versions": ", ".join(f"{name} {version}" for name, version in versions.items()),
        "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M UTC"),
        "load at begin": describeLoad(),
    }


def describeLoad():
    """Return the load averages over 1, 5 and 15 minutes."""
    return ", ".join(f"{load:.2f}" for load in os.getloadavg())


def _processorModel():
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or platform.machine()


def _git(*words):
    try:
        command = ["git", "-C", Path(__file__).parent, *words]
        return subprocess.run(command, capture_output=True, text=True).stdout.strip()
    except OSError:
        return ""


# ---- Measurements: an entry is a dictionary of what one contestant did in one row ----

_ROW = ("group", "chain", "particles", "method", "moves")
_SUMS = {"attempted", "clashed", "rejected", "accepted", "trials", "free", "reached", "refused", "computed"}
_SUMS |= {"tests", "kept"}
_MEANS = {"accepted", "volumeTests", "particleTests", "startRg", "rg"}
_LARGEST = {"largest", "energyError"}


def combineRuns(entries):
    """Return one entry for all runs of a contestant in a row.

    Times are medians over runs, with their range as `least` and `most`; counts of whole trials are sums.
    """
    runs = groupBy(entries, lambda entry: (*map(entry.get, _ROW), entry["contestant"]))
    combined = []
    for ofOne in runs.values():
        times = [entry["microseconds"] for entry in ofOne]
        combined.append({**_combine(ofOne), "least": min(times), "most": max(times), "runs": len(ofOne)})
    return combined


def _combine(entries):
    combined = dict(entries[0])
    for key, value in combined.items():
        values = [entry[key] for entry in entries]
        if isinstance(value, dict):
            combined[key] = _combine(values)
        elif key in _SUMS and isinstance(value, int):
            combined[key] = sum(values)
        elif key in _LARGEST:
            combined[key] = max(values)
        elif key in _MEANS:
            combined[key] = statistics.fmean(values)
        elif key == "microseconds" or isinstance(value, float):
            combined[key] = statistics.median(values)
    return combined


def racesOf(entries, group):
    """Return the rows of a group, each a dictionary of entries by contestants."""
    rows = groupBy([entry for entry in entries if entry["group"] == group], lambda entry: [*map(entry.get, _ROW)])
    return [{entry["contestant"]: entry for entry in ofRow} for ofRow in rows.values()]


def anyOf(race):
    """Return an entry of a row, for what all have in common."""
    return next(iter(race.values()))


def groupBy(entries, keyOf):
    """Return entries by a key, in the order in which keys come."""
    groups = {}
    for entry in entries:
        key = keyOf(entry)
        groups.setdefault(tuple(key) if isinstance(key, list) else key, []).append(entry)
    return groups


def writeCSV(path, machine, entries):
    """Write the machine in lines that begin with #, then the entries; values within values have names with dots."""
    flat = [dict(_leaves(entry)) for entry in entries]
    with open(path, "w", encoding="utf-8", newline="") as file:
        for name, words in machine.items():
            print(f"# {name}: {words}", file=file)
        columns = list(dict.fromkeys(key for entry in flat for key in entry))
        lines = csv.DictWriter(file, columns, lineterminator="\n")
        lines.writeheader()
        lines.writerows(flat)


def readCSV(path):
    """Return the machine and the entries of a file; an InputError tells that it is none of ours."""
    with open(path, encoding="utf-8", newline="") as file:
        lines = file.read().splitlines()
    machine = dict(line[2:].split(": ", 1) for line in lines if line.startswith("# ") and ": " in line)
    entries = [_entryOf(values) for values in csv.DictReader(line for line in lines if not line.startswith("# "))]
    if not entries or any(not {"group", "contestant", "microseconds"} <= entry.keys() for entry in entries):
        raise InputError(f"{path}: is no CSV that the benchmarks wrote")
    return machine, entries


def _leaves(values, prefix=""):
    for key, value in values.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _entryOf(values):
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
    return text


# ---- Tables ----


class Table(NamedTuple):
    """A table: its first columns, `words` of them, hold words, the others numbers."""

    heading: str
    columns: list[str]
    rows: list[list[str]]
    words: int
    notes: list[str]

    def print(self, console):
        """Print it on a rich Console."""
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
        marks = "".join("---|" if number < self.words else "---:|" for number in range(len(self.columns)))
        head, *lines = [f"| {' | '.join(cells)} |" for cells in (self.columns, *self.rows)]
        return "\n".join([f"**{self.heading}**\n", head, f"|{marks}", *lines, *(f"\n{note}" for note in self.notes)])


def tabulate(heading, rows, columns, words, *notes):
    """Return the Tables of rows by columns, a dictionary of functions of a row: one, or none without rows."""
    cells = [[cellOf(row) for cellOf in columns.values()] for row in rows]
    return [Table(heading, list(columns), cells, words, list(notes))] if rows else []


def number(value):
    """Return a positive number with about three digits."""
    return f"{value:,.0f}" if value >= 100 else f"{value:.1f}" if value >= 10 else f"{value:.2f}"


def timeOf(entry, key="microseconds"):
    """Return the time of an entry, or a dash."""
    return "–" if entry is None else number(entry[key])


def timeRange(entry):
    """Return the time of an entry with its range over runs, or a dash."""
    if entry is None or entry["runs"] == 1:
        return timeOf(entry)
    return f"{number(entry['microseconds'])} ({number(entry['least'])}–{number(entry['most'])})"


def ratioOf(first, second, key="microseconds"):
    """Return how many times the first entry's time is the second's, or a dash."""
    return "–" if first is None or second is None else number(first["microseconds"] / second[key])


def percent(count, whole):
    """Return a share."""
    return f"{100 * count / whole:.0f} %" if whole else "–"


def exponent(values):
    """Return x where values, by size, go as size^x: the slope of a line through all logarithms."""
    return float(np.polyfit(np.log(list(values)), np.log(list(values.values())), 1)[0])
