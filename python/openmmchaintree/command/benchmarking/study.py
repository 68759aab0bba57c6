"""What a benchmark is about, for the command that runs it."""

from collections.abc import Callable
from typing import Any, NamedTuple

from ..outputfiles import Output
from .report import Report


class Study(NamedTuple):
    """A plan and what is made of its results.

    rows : list, each with a method run(course) that returns entries
    trials : int, for a Course, if the user names no number
    makeReport : function of entries, course, failures and whether the run was interrupted
    hasPicture : function of a summary: whether there is anything to draw
    savePicture : function of an Output and a summary
    hasFailed : function of a summary: whether it shows that the engine is wrong
    """

    rows: list[Any]
    trials: int
    makeReport: Callable[..., Report]
    hasPicture: Callable[[dict], bool]
    savePicture: Callable[[Output, dict], None]
    hasFailed: Callable[[dict], bool] = lambda summary: False
