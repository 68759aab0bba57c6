"""Rows that the program runs: its contestants on the same questions."""

from collections.abc import Sequence
from typing import NamedTuple

from .course import Course
from .program import ProgramError
from .proteins import Model

OURS, LAZY_GRID, FULL_GRID, SIMD_GRID, VERLET = "ours", "lazygrid", "fullgrid", "simdgrid", "verletlist"
INSTRUCTION_SETS = ("avx512", "avx2", "portable")

ALL_CHAINS = 10**9  # as many as the user wants

# Trials of a contestant before the next has its turn, and finds the caches emptied.
BLOCK_SIZE = 500

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

    slow : those who race on the first chain only
    readsPositions : whether each contestant has to hand over all positions after each trial that it accepts
    """

    group: str
    chain: Chain | Model
    moves: Moves
    trials: int
    contestants: Sequence[str]
    slow: Sequence[str] = ()
    readsPositions: bool = False
    block: int = BLOCK_SIZE
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return f"{describeChain(self.chain)}, {self.moves}"

    def run(self, course: Course, seed: int):
        """Return an entry for each contestant."""
        isSlow = seed == course.seed
        names = [*self.contestants, *(self.slow if isSlow else ())]
        options = {"--contestants": ",".join(names), "--positions": "each" if self.readsPositions else None}
        return runTrials(self, course, seed, {**options, "--block": self.block})


class Question(NamedTuple):
    """Contestants who are asked the same about a chain as it is, over and over.

    measure : str, what they are asked, by the program's name for it; trials : int, how often
    """

    group: str
    measure: str
    chain: Chain | Model
    trials: int
    contestants: Sequence[str]
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return describeChain(self.chain)

    def run(self, course: Course, seed: int):
        """Return an entry for each contestant."""
        return askProgram(self, course, seed)


class EngineRace(NamedTuple):
    """The engine with one setting after the other.

    variable : str, which the engine reads from the environment; settings : dict, its values by names for tables
    """

    group: str
    chain: Chain | Model
    moves: Moves
    trials: int
    variable: str
    settings: dict[str, str]
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return f"{describeChain(self.chain)}, {self.moves}"

    def run(self, course: Course, seed: int):
        """Return an entry for each setting that the machine has.

        Raises
        ------
        ProgramError
            if the settings do not accept the same number of trials
        """
        entries = []
        for name, value in self.settings.items():
            (entry,) = runTrials(self, course, seed, {"--contestants": OURS}, {self.variable: value})
            if name not in INSTRUCTION_SETS or entry["isa"] == name:
                entries.append({**entry, "contestant": name})
        if len({entry["accepted"] for entry in entries}) > 1:
            raise ProgramError(f"the engine accepts other trials with another value of {self.variable}")
        return entries


def runTrials(row, course, seed, options, variables=None):
    """Let the program run a row with `chain`, `moves` and `trials`; return an entry for each contestant.

    Parameters
    ----------
    options : dict
        of the program, beside those that follow from the row, the course and the seed
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
        "--seed": seed,
        "--trials": course.trials or row.trials,
        "--block": BLOCK_SIZE,
        **options,
    }
    lines = course.program.race(given, variables)
    moves = {"moves": str(row.moves), "angle": row.moves.angle}
    return [_makeEntry(row, {**line, **moves}, given["--trials"]) for line in lines]


def askProgram(row, course, seed, options=None):
    """Let the program ask a row's `contestants` its `measure` of its `chain`, `trials` times; return an entry for each.

    Parameters
    ----------
    options : dict, optional
        of the program, beside those that follow from the row, the course and the seed

    Raises
    ------
    ProgramError
        if contestants disagree
    """
    given = {
        "--measure": row.measure,
        **_chainOptions(row.chain, course),
        "--contestants": ",".join(row.contestants),
        "--seed": seed,
        "--trials": course.questions(row.trials),
        **(options or {}),
    }
    return [_makeEntry(row, line, given["--trials"]) for line in course.program.race(given)]


def describeChain(chain):
    """Return a chain as one writes it."""
    return f"{chain.name}, {chain.size:,} spheres" if isinstance(chain, Chain) else chain.name


def _chainOptions(chain, course):
    if isinstance(chain, Chain):
        return {"--chain": chain.kind, "--n": chain.size}
    return {"--chain": course.sceneFile(chain)}


def _makeEntry(row, line, asked):
    if line["trials"] != asked:
        raise ProgramError(f"{line['contestant']} ran {line['trials']} trials of {asked}")
    return {"group": row.group, **line, "asked": asked, "chain": row.chain.name}
