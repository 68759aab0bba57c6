"""Rows that the program runs: its contestants on the same questions."""

from collections.abc import Sequence
from typing import NamedTuple

from .course import Course
from .program import ProgramError
from .proteins import Model

OURS, LAZY_GRID, FULL_GRID = "ours", "lazygrid", "fullgrid"
INSTRUCTION_SETS = ("avx512", "avx2", "portable")

_QUESTIONS = 50

_CHAIN_NAMES = {"random": "random compact", "hilbert": "Hilbert", "serpentine": "serpentine", "worst": "figure 6"}


class Moves(NamedTuple):
    """What trials are: their kind by the program's name, an angle in degrees, the number of torsions that turn."""

    kind: str
    angle: float | None = None
    kappa: int = 1

    def __str__(self) -> str:
        step = self.kind if self.angle is None else f"{self.angle:g}°"
        return step if self.kappa == 1 else f"{self.kappa} × {step}"

    def options(self):
        """Return what the program is asked for."""
        return {"--moves": self.kind, "--angle": self.angle, "--kappa": self.kappa}


class Chain(NamedTuple):
    """A chain that the program makes: its kind by the program's name, and its number of spheres."""

    kind: str
    size: int

    @property
    def name(self):
        """What tables call it."""
        return _CHAIN_NAMES[self.kind]


class Race(NamedTuple):
    """Contestants in turns on the same trials.

    block : int, trials of a turn; None: as many as the program's own
    """

    group: str
    chain: Chain | Model
    moves: Moves
    contestants: Sequence[str]
    block: int | None = None

    def __str__(self) -> str:
        return f"{describeChain(self.chain)}, {self.moves}"

    def run(self, course: Course):
        """Return an entry for each contestant."""
        return runTrials(self, course, {"--contestants": ",".join(self.contestants), "--block": self.block})


class Question(NamedTuple):
    """Contestants who are asked the same about a chain as it is, over and over.

    measure : str, what they are asked, by the program's name for it
    """

    group: str
    measure: str
    chain: Chain | Model
    contestants: Sequence[str]

    def __str__(self) -> str:
        return describeChain(self.chain)

    def run(self, course: Course):
        """Return an entry for each contestant."""
        return askProgram(self, course)


class EngineRace(NamedTuple):
    """The engine with one setting after the other, over and over.

    variable : str, which the engine reads from the environment; settings : dict, its values by names for tables
    """

    group: str
    chain: Chain | Model
    moves: Moves
    variable: str
    settings: dict[str, str]

    def __str__(self) -> str:
        return f"{describeChain(self.chain)}, {self.moves}"

    def run(self, course: Course):
        """Return an entry for each setting that the machine has: the run with the median time.

        Raises
        ------
        ProgramError
            if the settings do not accept the same number of trials
        """
        runs: dict[str, list] = {name: [] for name in self.settings}
        for _ in range(course.REPEATS):
            for name, entries in runs.items():
                variables = {self.variable: self.settings[name]}
                entries += runTrials(self, course, {"--contestants": OURS}, variables)
        entries = []
        for name, ofOne in runs.items():
            median = sorted(ofOne, key=_timeOf)[len(ofOne) // 2]
            if name not in INSTRUCTION_SETS or median["isa"] == name:
                entries.append({**median, "contestant": name})
        if len({entry["trials"] for entry in entries}) == 1 < len({entry["accepted"] for entry in entries}):
            raise ProgramError(f"the engine accepts other trials with another value of {self.variable}")
        return entries


def runTrials(row, course, options, variables=None):
    """Let the program run a row with `chain` and `moves`; return an entry for each contestant.

    Parameters
    ----------
    options : dict
        of the program, in place of those that follow from the row and the course or beside them
    variables : dict, optional
        of the environment

    Raises
    ------
    ProgramError
        if the race fails, or contestants disagree
    """
    given = {
        **_chainOptions(row.chain, course),
        **row.moves.options(),
        "--seed": course.seed,
        "--trials": course.trials,
        "--seconds": course.seconds,
        **options,
    }
    lines = course.program.race(given, variables)
    moves = {"moves": str(row.moves), "angle": row.moves.angle}
    return [_makeEntry(row.group, row.chain, {**line, **moves}) for line in lines]


def askProgram(row, course, options=None):
    """Let the program ask a row's `contestants` its `measure` of its `chain`; return an entry for each contestant.

    Parameters
    ----------
    options : dict, optional
        of the program, beside those that follow from the row and the course

    Raises
    ------
    ProgramError
        if contestants disagree
    """
    given = {
        "--measure": row.measure,
        **_chainOptions(row.chain, course),
        "--contestants": ",".join(row.contestants),
        "--seed": course.seed,
        "--trials": min(course.trials, _QUESTIONS),
        **(options or {}),
    }
    return [_makeEntry(row.group, row.chain, line) for line in course.program.race(given)]


def describeChain(chain):
    """Return a chain as one writes it."""
    return f"{chain.name}, {chain.size:,} spheres" if isinstance(chain, Chain) else chain.name


def _chainOptions(chain, course):
    if isinstance(chain, Chain):
        return {"--chain": chain.kind, "--n": chain.size}
    return {"--chain": course.sceneFile(chain)}


def _makeEntry(group, chain, line):
    return {"group": group, **line, "chain": chain.name}


def _timeOf(entry):
    return entry["microseconds"]
