"""What is measured, size by size: where positions get to, verdicts where spheres all but touch, the soft force."""

from collections.abc import Sequence
from typing import NamedTuple

from racing.course import Course
from racing.races import INSTRUCTION_SETS

from .softforce import measureForces

# The program's measures, and what entries tell them apart by.
DRIFT, TOUCH = "drift", "touch"

_CHAIN = "hilbert"

TURNS = 1000000  # after which positions are looked at last, beside powers of ten below

# A path that goes through the whole chain for each turn goes on until it has passed so many spheres.
_MOST_SPHERES = 10**9
_WHOLE_CHAIN = ("sequential", "cartesian")

# Verdicts on so many trials tell enough.
_TOUCHES = 7000


class DriftRow(NamedTuple):
    """How far from exact positions several ways of keeping them are after so many turns."""

    size: int
    contestants: Sequence[str]
    group: str = DRIFT
    mostChains: int = 1

    def __str__(self) -> str:
        return f"{self.size:,} spheres"

    def run(self, course: Course, seed: int):
        """Return an entry for each contestant after 1,000 turns, 10,000 and so on."""
        turns = course.trials or TURNS
        slow = [name for name in self.contestants if name.startswith(_WHOLE_CHAIN)]
        fast = [name for name in self.contestants if name not in slow]
        entries = []
        for names, most in ((fast, turns), (slow, min(turns, _MOST_SPHERES // self.size))):
            for line in _race(self, names, course, seed, most):
                stations = line.pop("stations")
                del line["trials"]
                # As text, whatever its digits.
                entries += [{**line, **station, "bits": f"0x{station['bits']}"} for station in stations]
        return entries


class TouchRow(NamedTuple):
    """What contestants say of trials that stop where spheres all but touch."""

    size: int
    contestants: Sequence[str]
    group: str = TOUCH
    mostChains: int = 1

    def __str__(self) -> str:
        return f"{self.size:,} spheres"

    def run(self, course: Course, seed: int):
        """Return an entry for each contestant."""
        return _race(self, self.contestants, course, seed, min(course.trials or _TOUCHES, _TOUCHES))


class ForceRow(NamedTuple):
    """How far the energy and the forces of the soft force are from exact ones."""

    size: int
    group: str = "force"
    mostChains: int = 1

    def __str__(self) -> str:
        return f"{self.size:,} spheres"

    def run(self, course: Course, seed: int):
        """Return an entry for each force on each platform."""
        return [{"group": self.group, **entry} for entry in measureForces(self.size, seed)]


def _race(row, names, course, seed, trials):
    """Return the program's lines, those of instruction sets that the machine lacks left out."""
    lines = course.program.race(
        {
            "--measure": row.group,
            "--chain": _CHAIN,
            "--n": row.size,
            "--contestants": ",".join(names),
            "--seed": seed,
            "--trials": trials,
        }
    )
    return [{"group": row.group, **line} for line in lines if _isAsNamed(line)]


def _isAsNamed(line):
    """Whether the engine had the instruction set that it was asked for."""
    name = line["contestant"].removeprefix("ours-")
    return name not in INSTRUCTION_SETS or name == line["isa"]
