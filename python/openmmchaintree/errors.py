"""What is wrong with what the user gave."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .clashes import FrameClashes


class InputError(ValueError):
    """What is wrong with what the user gave, in one sentence that names it.

    frames : sequence of FrameClashes
        what was found before a damaged frame
    """

    frames: "Sequence[FrameClashes]" = ()


class ClusterError(InputError):
    """What is wrong with a scheduler or with workers on other machines, in one sentence that names them."""
