"""A benchmark as tables for people, and as JSON, CSV and Markdown for what follows."""

import csv
import io
from pathlib import Path

from .machine import describeMachine
from .races import OURS
from .rows import CHOSEN
from .steps import FROM_C
from .tables import makeTables


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


def writeCSV(path, entries):
    """Write a heading, and a line for every entry."""
    text = io.StringIO()
    columns = dict.fromkeys(key for entry in entries for key in _flatten(entry))
    lines = csv.DictWriter(text, list(columns), lineterminator="\n")
    lines.writeheader()
    lines.writerows(map(_flatten, entries))
    Path(path).write_text(text.getvalue(), encoding="utf-8")


def _flatten(entry):
    first, third = entry["quartiles"]
    flat = {"quartile1": first, "quartile3": third}
    return {key: value for key, value in {**entry, **flat}.items() if key != "quartiles"}


def makeMarkdown(summary):
    """Return the tables of a summary as Markdown."""
    parts = [_describe(summary), *(table.markdown() for table in makeTables(summary["entries"]))]
    return "\n\n".join([*parts, *_describeRest(summary)]) + "\n"


def printReport(summary, files, console):
    """Print a summary on a rich Console, and the names of files with more."""
    console.print(_describe(summary), markup=False)
    for table in makeTables(summary["entries"]):
        table.print(console)
    console.print()
    for line in _describeRest(summary):
        console.print(line, markup=False)
    if files:
        console.print(f"wrote {', '.join(map(str, files))}", markup=False)


def describeProcessor(summary):
    """Return the processor and what of its instruction sets the engine used."""
    return ", ".join([summary["machine"]["processor"], *summary["instructionSets"]])


def _describe(summary):
    versions = summary["machine"]["versions"].items()
    versions = [f"{name} {version}" for name, version in versions if version is not None]
    return (
        f"{describeProcessor(summary)}; {', '.join(versions)}; seed {summary['seed']}; "
        f"up to {summary['trials']:,} trials or {summary['seconds']:g} s a row"
    )


def _describeRest(summary):
    lines = [f"skipped: {entry['what']}: {entry['why']}" for entry in summary["skipped"]]
    lines += [f"FAILED: {entry['what']}: {entry['why']}" for entry in summary["failures"]]
    if summary["interrupted"]:
        lines.append("interrupted: this is what was measured so far")
    return lines
