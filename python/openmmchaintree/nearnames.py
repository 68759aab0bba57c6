"""Finds the name that a user probably meant."""

import difflib
from collections.abc import Iterable

_LEAST_LIKENESS = 0.6  # of difflib.SequenceMatcher


def nearestName(name: str, known: Iterable[str]) -> str | None:
    """Return the known name that is most like a name, whatever its case; None if none is like it."""
    byLower = {text.lower(): text for text in known}
    found = difflib.get_close_matches(name.lower(), byLower, 1, _LEAST_LIKENESS)
    return byLower[found[0]] if found else None


def didYouMean(name: str, known: Iterable[str]) -> str:
    """Return the end of an error on an unknown name: whether another one was meant; empty if none is near."""
    near = nearestName(name, known)
    return "" if near is None else f"; did you mean {near}?"
