"""What the engine promises about its accuracy, and whether a run shows it."""

import math
from typing import Any

from racing.races import OURS
from racing.table import exponent, groupBy, sizeOf

from .tables import error, errorsOf, isOurs, relativeError, stationsOf

SIGMA = 1e-9  # nm: nearer to a limit than that, the engine may decide either way

LARGEST_ERROR = 1e-12  # of a distance, by the size of the chain
_TURNS = 1000000  # after so many turns

# What is random grows as the square root of the number of turns, what adds up as the number.
_MOST_GROWTH = 0.25
_LEAST_RANGE = 100  # of the number of turns, to tell

# Errors depend on how a chain lies. This path remembers nothing but angles, so its errors do not grow.
_STEADY = "sequential"


def judgeGoals(entries) -> list[dict[str, Any]]:
    """Return goals as dictionaries: what, whether it is reached (None: not measured), and what shows it."""
    ofOurs = [entry for entry in entries if isOurs(entry)]
    drift = [entry for entry in ofOurs if entry["group"] == "drift"]
    touch = [entry for entry in ofOurs if entry["group"] == "touch"]
    return [_judgeVerdicts(touch), _judgeError(drift), _judgeGrowth(entries), _judgeBits(drift)]


def _goal(what, reached, evidence):
    return {"what": what, "reached": reached, "evidence": evidence}


def _judgeVerdicts(entries):
    what = f"no missed and no invented clash beyond {SIGMA:g} nm on any path of the engine"
    if not entries:
        return _goal(what, None, "no trials were run")
    missed, clashes, invented, gaps = (
        sum(entry[key] for entry in entries) for key in ("missed", "clashes", "invented", "gaps")
    )
    evidence = f"{missed:,} of {clashes:,} clashes missed, {invented:,} of {gaps:,} gaps taken for one"
    return _goal(what, missed + invented == 0, evidence)


def _judgeError(entries):
    what = f"errors of distances up to {LARGEST_ERROR:g} of the chain's size after {_TURNS:,} turns"
    measured = [entry for entry in entries if entry["turns"] >= _TURNS]
    if not measured:
        return _goal(what, None, f"no chain was turned {_TURNS:,} times")
    worst = max(measured, key=relativeError)
    ofTurns = max(relativeError(entry, lambda entry: entry["ofTurns"]) for entry in measured)
    sizes = ", ".join(f"{size:,}" for size in groupBy(measured, sizeOf))
    evidence = (
        f"up to {error(relativeError(worst))} (N = {sizes}); {error(ofTurns)} with what rounding does to sums of angles"
    )
    return _goal(what, relativeError(worst) <= LARGEST_ERROR, evidence)


def _judgeGrowth(entries):
    what = "errors of distances that do not grow with the number of turns"
    drift = [entry for entry in entries if entry["group"] == "drift"]
    growths = {}
    for size, ofSize in groupBy(drift, sizeOf).items():
        paths = stationsOf(ofSize)
        ofSteady = paths.get(_STEADY, {})
        for stations in (ofOne for name, ofOne in paths.items() if name.startswith(OURS)):
            ratios = {n: _spread(entry) / _spread(ofSteady[n]) for n, entry in stations.items() if n in ofSteady}
            if ratios and max(ratios) >= _LEAST_RANGE * min(ratios):
                growths[size] = max(growths.get(size, -math.inf), exponent(ratios))
    if not growths:
        return _goal(what, None, "no chain was turned often enough")
    evidence = ", ".join(f"turns^{value:.2f} (N = {size:,})" for size, value in growths.items())
    evidence = f"RMS errors, by those of sequential kinematics from the same turns, go as {evidence}"
    return _goal(what, max(growths.values()) <= _MOST_GROWTH, evidence)


def _spread(entry):
    return errorsOf(entry)["distances"]["rms"]


def _judgeBits(entries):
    what = "the same bits with every instruction set"
    groups = groupBy(entries, lambda entry: (entry["particles"], entry["turns"]))
    compared = [ofOne for ofOne in groups.values() if len(ofOne) > 1]
    if not compared:
        return _goal(what, None, "there is one instruction set")
    different = [ofOne for ofOne in compared if len({entry["bits"] for entry in ofOne}) > 1]
    evidence = f"positions differ in {len(different)} of {len(compared)} comparisons"
    return _goal(what, not different, evidence)


def describeGoal(goal):
    """Return a line about a goal."""
    words = {True: "reached", False: "NOT REACHED", None: "not measured"}[goal["reached"]]
    return f"goal: {goal['what']}: {words} ({goal['evidence']})"
