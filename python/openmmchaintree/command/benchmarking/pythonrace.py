"""The row in which the program's contestants and those from Python run the same trials."""

from typing import NamedTuple

from .course import Course
from .platforms import whyNot
from .program import ProgramError
from .proteins import Model
from .races import LAZY_GRID, OURS, Chain, Moves, describeChain, runTrials
from .recording import readRecording
from .rivals import RIVALS
from .timing import measure, summarizeTimes

# The slowest take many milliseconds for a trial.
_MOST_TRIALS = 400
_BLOCK_SIZE = 20


class PythonRace(NamedTuple):
    """The program's contestants first; then, in turns on the same trials, those from Python."""

    group: str
    chain: Chain | Model
    moves: Moves

    def __str__(self) -> str:
        return f"{describeChain(self.chain)}, {self.moves}"

    def run(self, course: Course):
        """Return an entry for each contestant.

        Raises
        ------
        ProgramError
            if contestants disagree
        """
        trials = min(course.trials, _MOST_TRIALS)
        options = {"--contestants": f"{LAZY_GRID},{OURS}", "--trials": trials, "--block": _BLOCK_SIZE}
        entries = runTrials(self, course, {**options, "--record": course.recordFile()})
        recording = readRecording(course.recordFile())
        lanes = [_Lane(rival(recording)) for rival in RIVALS if whyNot(rival.requirement) is None]
        counted = _runLanes(lanes, recording.trials, course.seconds)
        common = {key: entries[0][key] for key in ("group", "chain", "particles", "torsions", "moves", "seed", "block")}
        accepted = sum(not trial.clash for trial in counted) / len(counted)
        for lane in lanes:
            entries.append({**common, "trials": len(counted), "accepted": accepted, **lane.summarize()})
        return entries


def _runLanes(lanes, trials, seconds):
    """Run trials block by block until the time is up; return those that count: all but the first block."""
    left = 1e6 * seconds
    end = 0
    while end < len(trials) and (left > 0 or end < 2 * _BLOCK_SIZE):
        block = trials[end : end + _BLOCK_SIZE]
        left -= sum(lane.run(block, end) for lane in lanes)
        end += len(block)
    for lane in lanes:
        del lane.times[0]
    return trials[_BLOCK_SIZE:end]


class _Lane:
    """A Rival on its way through trials.

    times : list of float, microseconds a trial of each block
    """

    def __init__(self, rival):
        self.times = []
        self._rival = rival
        self._disagreements = 0

    def run(self, block, firstTrial):
        """Run some trials; return the time that they took together, in microseconds."""
        verdicts, time = measure(self._test, block)
        for number, (verdict, trial) in enumerate(zip(verdicts, block, strict=True), start=firstTrial):
            if verdict != trial.clash:
                self._noteDisagreement(number, verdict)
        self.times.append(time / len(block))
        return time

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
        """Return what is particular of the lane's entry."""
        inexact = {} if self._rival.isExact else {"disagreements": self._disagreements}
        return {"contestant": self._rival.name, **summarizeTimes(self.times), **inexact}
