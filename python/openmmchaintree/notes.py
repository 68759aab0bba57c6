"""What users should know of their input, gathered: one line for each kind of thing, however often it is met."""

import warnings
from collections.abc import Iterable

# So many things are named in the line of a kind.
_NAMED = 3


def listFirst(items: Iterable[str], separator: str = ", ") -> str:
    """Return the first three of some things in words, and how many more there are: lines stay short."""
    items = list(items)
    more = [f"and {len(items) - _NAMED:,} more"] if len(items) > _NAMED else []
    return separator.join([*items[:_NAMED], *more])


class Note:
    """One kind of thing that was met, and where.

    kind : str, in the plural ("gaps in the chain"), or a sentence where there is nothing to list
    items : list of str, each a place with what there is to say of it

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
    """A warning that is a Note: its attribute `note` holds all items, its text the first of them."""

    def __init__(self, note: Note) -> None:
        super().__init__(str(note))
        self.note = note


def found(notes: Iterable[Note]) -> list[Note]:
    """Return those of some Notes that have items."""
    return [note for note in notes if note.items]


def warnOf(notes: Iterable[Note], stacklevel: int) -> None:
    """Warn of each of some Notes. A stack level of 1 is the caller."""
    for note in notes:
        warnings.warn(NoteWarning(note), stacklevel=stacklevel + 1)
