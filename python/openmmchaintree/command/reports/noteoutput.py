"""Notes on the input: one line per kind in the report, every note on request."""

from ...notes import Note
from ..terminal import printable


def addNotes(parser):
    """Add the options that show all notes."""
    parser.add_argument("-v", "--verbose", action="store_true", help="print all notes, not the first three of a kind")
    parser.add_argument("--notes", metavar="FILE", help="write all notes (-: print them)")


def asText(notes):
    """Return Notes with all items, as the text of a file."""
    return "".join(f"{printable(line)}\n" for note in notes for line in note.lines())


def asPlain(notes):
    """Return Notes as plain dictionaries, for JSON."""
    return [vars(note) for note in notes]


def printNotes(plain, console, isVerbose):
    """Print the result of `asPlain` on a rich Console."""
    for note in (Note(**entry) for entry in plain):
        first, *others = note.lines() if isVerbose else [str(note)]
        console.print("\n".join([f"note: {first}", *others]))
