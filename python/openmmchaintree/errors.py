"""What is wrong with what the user gave."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .clashes import FrameClashes
    from .notes import Note


class InputError(ValueError):
    """What is wrong with what the user gave, in one sentence that names it.

    frames : sequence of FrameClashes
        what was found before a damaged frame
    """

    frames: "Sequence[FrameClashes]" = ()


class UnknownRadiusError(ValueError):
    """Atoms of which no radius is known.

    note : Note, which names them; advice names the argument or option that gives them one
    """

    def __init__(self, note: "Note", advice: str) -> None:
        super().__init__(f"{note}: {advice}")
        self.note = note


class ClusterError(InputError):
    """What is wrong with a scheduler or with workers on other machines, in one sentence that names them."""
