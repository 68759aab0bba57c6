"""Rows in which the program's contestants and those from Python run the same trials."""

from typing import NamedTuple

import numpy as np

from .course import Course, measure, summarizeTimes
from .platforms import whyNot
from .program import ProgramError
from .proteins import Model
from .races import ALL_CHAINS, BLOCK_SIZE, LAZY_GRID, OURS, Chain, Moves, describeChain, runTrials
from .recording import makeForce, readRecording
from .rivals import RIVALS, OurCalls
from .steps import Simulated

_SLOW_BLOCK = 20  # trials of a turn, where some take milliseconds for each
_STEP_SIZE = 100  # trials of a step, as an integrator has it by itself

_IN_COMMON = (
    "group", "chain", "particles", "torsions", "moves", "angle", "seed", "trials", "asked", "block", "accepted"
)  # fmt: skip

STEP = "Simulation.step"


class PythonRace(NamedTuple):
    """The program's contestants first; then, in turns on the same trials, those from Python.

    Last goes a Simulation, in steps of 100 trials; its trials are of the same kind and number, but its own.

    withRivals : whether SciPy and its like race, too, each of which takes many milliseconds for a trial
    """

    group: str
    chain: Chain | Model
    moves: Moves
    trials: int
    withRivals: bool
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return f"{describeChain(self.chain)}, {self.moves}"

    def run(self, course: Course, seed: int):
        """Return an entry for each contestant.

        Raises
        ------
        ProgramError
            if contestants disagree
        """
        block = _SLOW_BLOCK if self.withRivals else BLOCK_SIZE
        options = {"--contestants": f"{LAZY_GRID},{OURS}", "--block": block, "--record": course.recordFile()}
        entries = runTrials(self, course, seed, options)
        recording = readRecording(course.recordFile())
        rivals = [rival for rival in RIVALS if self.withRivals and whyNot(rival.requirement) is None]
        lanes = [_Lane(rival(recording)) for rival in (OurCalls, *rivals)]
        trials = recording.trials
        block = entries[0]["block"]  # no larger than the number of trials
        for first in range(0, len(trials), block):
            for lane in lanes:
                lane.run(trials[first : first + block], first)
        common = {name: entries[0][name] for name in _IN_COMMON}
        entries += [{**common, **lane.summarize()} for lane in lanes]
        return [*entries, {**common, **_runSteps(recording, seed, common["trials"])}]


def _runSteps(recording, seed, trials):
    """Return what is particular of the entry of a Simulation that runs so many trials."""
    count = len(recording.radii)
    simulated = Simulated(makeForce(recording), recording.positions, np.ones(count), range(len(recording.torsions)))
    block = min(trials, _STEP_SIZE)
    simulation = simulated.start(seed, block)
    times = [measure(simulation.step, 1)[1] / block for _ in range(trials // block)]
    attempted, *_, accepted = simulation.integrator.getMoveStatistics(0)
    return {"contestant": STEP, "block": block, "accepted": accepted / attempted, **summarizeTimes(times)}


class _Lane:
    """A Rival on its way through trials."""

    def __init__(self, rival):
        self._times = []  # microseconds a trial of each block
        self._rival = rival
        self._disagreements = 0

    def run(self, block, firstTrial):
        """Run some trials."""
        verdicts, time = measure(self._test, block)
        for number, (verdict, trial) in enumerate(zip(verdicts, block, strict=True), start=firstTrial):
            if verdict != trial.clash:
                self._noteDisagreement(number, verdict)
        self._times.append(time / len(block))

    def _test(self, block):
        verdicts = []
        for trial in block:
            verdicts.append(self._rival.test(trial))
            if not trial.clash:
                self._rival.accept()
        return verdicts

    def _noteDisagreement(self, number, verdict):
        if self._rival.isExact:
            word = "a clash" if verdict else "free of clashes"
            raise ProgramError(f"{self._rival.name} calls trial {number} {word}, {LAZY_GRID} does not")
        self._disagreements += 1

    def summarize(self):
        """Return what is particular of the lane's entry; the first block does not count."""
        inexact = {} if self._rival.isExact else {"disagreements": self._disagreements}
        return {"contestant": self._rival.name, **summarizeTimes(self._times[1:]), **inexact}
