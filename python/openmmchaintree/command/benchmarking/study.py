"""What a benchmark is about, for the command that runs it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from .report import Report


class Study(NamedTuple):
    """A plan and what is made of its results.

    rows : list, each with a method run(course) that returns entries
    trials : int, for a Course, if the user names no number
    makeReport : function of entries, course, failures and whether the run was interrupted
    savePicture : function of a path and a summary; False if there is nothing to draw
    hasFailed : function of a summary: whether it shows that the engine is wrong
    """

    rows: list[Any]
    trials: int
    makeReport: Callable[..., Report]
    savePicture: Callable[[Path, dict], bool]
    hasFailed: Callable[[dict], bool] = lambda summary: False
