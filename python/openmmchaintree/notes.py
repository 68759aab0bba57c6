"""Notes for users on their input: one line for each kind of observation, however often it occurs."""

import warnings
from collections.abc import Iterable

# The number of items in the line of a kind.
_NAMED = 3


def listFirst(items: Iterable[str], separator: str = ", ") -> str:
    """Return the first three items, and the number of the others, in one short line."""
    items = list(items)
    more = [f"and {len(items) - _NAMED:,} more"] if len(items) > _NAMED else []
    return separator.join([*items[:_NAMED], *more])


def countOf(number: int, noun: str) -> str:
    """Return a number of things in words: 1 atom, 2 atoms."""
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


class Note:
    """One kind of observation, and where it occurs.

    kind : str, in the plural ("gaps in the chain"), or a sentence if there is nothing to list
    items : list of str, each a place with its details

    As a string it is one line, with the number of items and the first three.
    """

    def __init__(self, kind: str, items: Iterable[str] = ()) -> None:
        self.kind = kind
        self.items = list(items)

    def __str__(self) -> str:
        if not self.items:
            return self.kind
        return f"{self.kind} ({len(self.items):,}): {listFirst(self.items, '; ')}"

    def lines(self) -> list[str]:
        """Return the kind and all items, a line each."""
        if not self.items:
            return [self.kind]
        return [f"{self.kind} ({len(self.items):,}):", *(f"  {item}" for item in self.items)]


class NoteWarning(UserWarning):
    """A warning with a Note: its attribute `note` holds all items, its text the first three."""

    def __init__(self, note: Note) -> None:
        super().__init__(str(note))
        self.note = note


def found(notes: Iterable[Note]) -> list[Note]:
    """Return the Notes that have items."""
    return [note for note in notes if note.items]


def warnOf(notes: Iterable[Note], stacklevel: int) -> None:
    """Issue a NoteWarning for each Note. A stack level of 1 is the caller."""
    for note in notes:
        warnings.warn(NoteWarning(note), stacklevel=stacklevel + 1)
