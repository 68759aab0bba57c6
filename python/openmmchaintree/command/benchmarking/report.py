"""A benchmark as tables for people, and as JSON, CSV and Markdown for what follows."""

import csv
import io
from typing import Any, NamedTuple

from .machine import describeMachine
from .races import OURS
from .rows import CHOSEN
from .steps import FROM_C
from .tables import Table, makeTables


class Report(NamedTuple):
    """What a benchmark found.

    summary : dict, everything, for JSON
    heading : str, where and how it was measured
    tables : list of Table
    conclusions : list of str, lines that follow from the tables
    """

    summary: dict[str, Any]
    heading: str
    tables: list[Table]
    conclusions: list[str]

    def markdown(self):
        """Return it as Markdown."""
        parts = [self.heading, *(table.markdown() for table in self.tables)]
        return "\n\n".join([*parts, *self.conclusions, *_describeRest(self.summary)]) + "\n"

    def print(self, files, console):
        """Print it on a rich Console, and the names of files with more."""
        console.print(self.heading)
        for table in self.tables:
            table.print(console)
        console.print()
        for line in (*self.conclusions, *_describeRest(self.summary)):
            console.print(line)
        if files:
            console.print(f"wrote {', '.join(map(str, files))}")


def makeReport(summary):
    """Return the Report of races from their summary."""
    heading = f"{describeRun(summary)}; up to {summary['trials']:,} trials or {summary['seconds']:g} s a row"
    return Report(summary, heading, makeTables(summary["entries"]), [])


def summarize(entries, course, proteins, skipped, failures, interrupted):
    """Return everything that a benchmark measured as plain dictionaries and lists, for JSON. Times are in µs.

    Parameters
    ----------
    entries : list of dict
        of all rows
    course : Course
    proteins : list of Protein
    skipped, failures : list of (str, str)
        what did not run, or failed, and why
    interrupted : bool
    """
    return {
        "machine": describeMachine(),
        "instructionSets": sorted({entry["isa"] for entry in entries if entry["contestant"] in (OURS, FROM_C, CHOSEN)}),
        "seed": course.seed,
        "trials": course.trials,
        "seconds": course.seconds,
        "proteins": [
            {"name": name, "residues": residues, "atoms": len(positions)} for name, residues, _, positions in proteins
        ],
        "entries": entries,
        "skipped": [{"what": what, "why": why} for what, why in skipped],
        "failures": [{"what": what, "why": why} for what, why in failures],
        "interrupted": interrupted,
    }


def asCSV(entries):
    """Return CSV: a heading, and a line for every entry."""
    text = io.StringIO()
    columns = dict.fromkeys(key for entry in entries for key in _flatten(entry))
    lines = csv.DictWriter(text, list(columns), lineterminator="\n")
    lines.writeheader()
    lines.writerows(map(_flatten, entries))
    return text.getvalue()


def _flatten(entry):
    first, third = entry["quartiles"]
    others = {key: value for key, value in entry.items() if key != "quartiles"}
    return dict(_leaves({**others, "quartile1": first, "quartile3": third}))


def _leaves(values, prefix=""):
    """Yield what is in dictionaries within dictionaries, under names with dots."""
    for key, value in values.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def describeProcessor(summary):
    """Return the processor and what of its instruction sets the engine used."""
    return ", ".join([summary["machine"]["processor"], *summary["instructionSets"]])


def describeRun(summary):
    """Return the processor, the versions and the seed."""
    versions = summary["machine"]["versions"].items()
    versions = [f"{name} {version}" for name, version in versions if version is not None]
    return f"{describeProcessor(summary)}; {', '.join(versions)}; seed {summary['seed']}"


def _describeRest(summary):
    lines = [f"skipped: {entry['what']}: {entry['why']}" for entry in summary["skipped"]]
    lines += [f"FAILED: {entry['what']}: {entry['why']}" for entry in summary["failures"]]
    if summary["interrupted"]:
        lines.append("interrupted: this is what was measured so far")
    return lines
