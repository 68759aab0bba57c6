"""The accuracy as tables for people, and as JSON, CSV and Markdown for what follows."""

from ..benchmarking.machine import describeMachine
from ..benchmarking.report import Report, describeRun
from .goals import describeGoal, judgeGoals
from .tables import isOurs, makeTables


def makeReport(entries, course, skipped, failures, interrupted):
    """Return the Report of what was measured.

    Parameters
    ----------
    entries : list of dict
        of all rows; times are in µs
    course : Course
    skipped, failures : list of (str, str)
        what did not run, or failed, and why
    interrupted : bool
    """
    summary = {
        "machine": describeMachine(),
        "instructionSets": sorted({entry["isa"] for entry in entries if isOurs(entry) and "isa" in entry}),
        "seed": course.seed,
        "turns": course.trials,
        "seconds": course.seconds,
        "entries": entries,
        "goals": judgeGoals(entries),
        "skipped": [{"what": what, "why": why} for what, why in skipped],
        "failures": [{"what": what, "why": why} for what, why in failures],
        "interrupted": interrupted,
    }
    heading = (
        f"{describeRun(summary)}; up to {course.trials:,} turns, {course.seconds:g} s a row: a path goes on to ten "
        "times as many turns as long as that is within its share"
    )
    return Report(summary, heading, makeTables(entries), [describeGoal(goal) for goal in summary["goals"]])
