"""Checks the header of a saved run before its use, since anybody may have written the file."""

import re

from ..replicas.coordinator import RunState

_LARGEST_COUNT = 10**15
_LONGEST_TIME = 1e12  # s


def _whole(least, largest):
    return lambda value: isinstance(value, int) and not isinstance(value, bool) and least <= value <= largest


def _text(pattern):
    return lambda value: isinstance(value, str) and re.fullmatch(pattern, value) is not None


def _all(check, count=None):
    """Return a check for a list of `count` items, or of any number."""
    return lambda value: isinstance(value, list) and count in (None, len(value)) and all(map(check, value))


def _isScalar(value):
    return isinstance(value, (str, int, float))


def _isSetting(value):
    return _isScalar(value) or _all(_isScalar)(value)


def _isTime(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and 0 <= value <= _LONGEST_TIME


def _isBoolOrNone(value):
    return value is None or isinstance(value, bool)


_count = _whole(0, _LARGEST_COUNT)
_digest = _text("[0-9a-f]{64}")

_HEADER = {
    "version": _count,
    "digests": lambda value: isinstance(value, dict) and all(map(_digest, value.values())),
    "model": _digest,
    "madeBy": _text(r"[\w.+-]{1,50}"),
    "settings": lambda value: isinstance(value, dict) and all(map(_isSetting, value.values())),
    "index": lambda value: _all(_count, 2)(value) and value[1] < 2**32,
    "reports": _all(_digest),
    "state": lambda value: isinstance(value, dict),
    "temporary": _text(r"\.[0-9a-f]{16}\.part"),
}
# Settings that are needed before the parser checks all of them.
_SETTINGS = {"trials": _whole(1, _LARGEST_COUNT), "frames": _whole(1, _LARGEST_COUNT), "seed": _whole(1, 2**31 - 1)}


def findWrong(header):
    """Return the name of the first wrong entry of a header, or None."""
    return _firstWrong(header, _HEADER, "") or _firstWrong(header["settings"], _SETTINGS, "settings.", others=True)


def findWrongState(state, plan, moves):
    """Return the name of the first wrong entry in the state of a RunPlan with `moves` moves, or None."""
    replicas, temperatures = len(plan.seeds), len(plan.temperatures)
    checks = {
        "round": _whole(0, plan.schedule.rounds),
        "temperatureOf": _all(_whole(0, temperatures - 1), replicas),
        "wasHotLast": _all(_isBoolOrNone, replicas),
        "roundTrips": _all(_count, replicas),
        "attempted": _all(_count, temperatures - 1),
        "accepted": _all(_count, temperatures - 1),
        "seconds": _isTime,
        "secondsInSteps": _isTime,
        "wallSeconds": _isTime,
        "counts": _table(temperatures, moves, 4),
        "countsOfReplica": _table(replicas, moves, 4),
        "outerTests": _table(temperatures, 3),
    }
    assert checks.keys() == RunState(plan, moves).asPlain().keys()
    wrong = _firstWrong(state, checks, "state.")
    if wrong is None and plan.isExchange and sorted(state["temperatureOf"]) != list(range(temperatures)):
        return "state.temperatureOf"
    if wrong is None and state["round"] > 0 and state["wallSeconds"] == 0:
        return "state.wallSeconds"
    return wrong


def _table(*shape):
    check = _count
    for count in reversed(shape):
        check = _all(check, count)
    return check


def _firstWrong(values, checks, prefix, others=False):
    """Return the name of the first value that is missing, fails its check, or has no check unless `others` is true."""
    if not isinstance(values, dict):
        return prefix.removesuffix(".") or "run.json"
    for name, check in checks.items():
        if name not in values or not check(values[name]):
            return prefix + name
    return None if others else next((prefix + repr(name) for name in values if name not in checks), None)
