"""Errors of the user's input, and the texts of other errors."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .clashes import FrameClashes
    from .clashscores import ClashScores
    from .notes import Note


class InputError(ValueError):
    """An error of the user's input, in one sentence that names the culprit.

    frames : sequence of FrameClashes or ClashScores
        the results of frames before a damaged one
    """

    frames: "Sequence[FrameClashes] | Sequence[ClashScores]" = ()


class UnknownRadiusError(ValueError):
    """Atoms of unknown radius.

    note : Note, which names the atoms; advice : str, names the argument or option that sets their radius
    """

    def __init__(self, note: "Note", advice: str) -> None:
        super().__init__(f"{note}: {advice}")
        self.note = note


class ClusterError(InputError):
    """An error of a scheduler or of workers on other machines, in one sentence that names them."""


def firstLine(error: BaseException) -> str:
    """Return the first line of the text of another package's error, or its class."""
    return (str(error).strip() or type(error).__name__).splitlines()[0]
