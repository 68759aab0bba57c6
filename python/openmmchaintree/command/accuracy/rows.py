"""What is measured, size by size: where positions get to, verdicts where spheres all but touch, the soft force."""

from collections.abc import Sequence
from typing import NamedTuple

from ..benchmarking.course import Course
from ..benchmarking.races import INSTRUCTION_SETS
from .softforce import measureForces

# The program's measures, and what entries tell them apart by.
DRIFT, TOUCH = "drift", "touch"

_CHAIN = "hilbert"

# Verdicts on so many trials tell enough.
_TOUCHES = 7000


class DriftRow(NamedTuple):
    """How far from exact positions several ways of keeping them are after so many turns."""

    size: int
    contestants: Sequence[str]
    group: str = DRIFT

    def __str__(self) -> str:
        return f"{self.size:,} spheres"

    def run(self, course: Course):
        """Return an entry for each contestant after 1,000 turns, 10,000 and so on, as far as it gets."""
        entries = []
        for line in _race(self, course, course.trials):
            stations = line.pop("stations")
            del line["trials"]
            entries += [{**line, **station} for station in stations]
        return entries


class TouchRow(NamedTuple):
    """What contestants say of trials that stop where spheres all but touch."""

    size: int
    contestants: Sequence[str]
    group: str = TOUCH

    def __str__(self) -> str:
        return f"{self.size:,} spheres"

    def run(self, course: Course):
        """Return an entry for each contestant."""
        return _race(self, course, min(course.trials, _TOUCHES))


class ForceRow(NamedTuple):
    """How far the energy and the forces of the soft force are from exact ones."""

    size: int
    group: str = "force"

    def __str__(self) -> str:
        return f"{self.size:,} spheres"

    def run(self, course: Course):
        """Return an entry for each force on each platform."""
        return [{"group": self.group, **entry} for entry in measureForces(self.size, course)]


def _race(row, course, trials):
    """Return the program's lines, those of instruction sets that the machine lacks left out."""
    lines = course.program.race(
        {
            "--measure": row.group,
            "--chain": _CHAIN,
            "--n": row.size,
            "--contestants": ",".join(row.contestants),
            "--seed": course.seed,
            "--trials": trials,
            "--seconds": course.seconds,
        }
    )
    return [{"group": row.group, **line} for line in lines if _isAsNamed(line)]


def _isAsNamed(line):
    """Whether the engine had the instruction set that it was asked for."""
    name = line["contestant"].removeprefix("ours-")
    return name not in INSTRUCTION_SETS or name == line["isa"]
