"""What all rows of a run share, and how what runs in Python is timed."""

import time
from pathlib import Path

import numpy as np


class Course:
    """The settings of a run.

    Attributes
    ----------
    program : Program
    seed : int
        of the first chain of each row; the others have the following
    chains : int
        of a row, unless it has fewer
    trials : int or None
        of a chain, in place of what a row has by itself
    folder : Path
        for files that end with the run
    """

    def __init__(self, program, seed, chains, trials, folder):
        """Make a Course that keeps files of its own in a folder."""
        self.program = program
        self.seed = seed
        self.chains = chains
        self.trials = trials
        self.folder = Path(folder)
        self._scenes = {}

    def questions(self, usual):
        """Return how often a question is asked that a row asks so often by itself: not more than that."""
        return min(self.trials or usual, usual)

    def sceneFile(self, model):
        """Return the path of a file with the scene of a Model."""
        if id(model) not in self._scenes:
            path = self.folder / f"scene-{len(self._scenes)}"
            model.scene.write(path)
            self._scenes[id(model)] = path, model  # which keeps the id its own
        return self._scenes[id(model)][0]

    def recordFile(self):
        """Return the path of a file for the record of a race, of which there is one at a time."""
        return self.folder / "record"


def measure(function, *arguments):
    """Return what a call returns, and the processor time it takes, of all threads, in microseconds."""
    start = time.process_time_ns()
    result = function(*arguments)
    return result, 1e-3 * (time.process_time_ns() - start)


def summarizeTimes(times):
    """Return the median and the quartiles of times as an entry has them."""
    first, median, third = np.quantile(times, [0.25, 0.5, 0.75]).tolist()
    return {"microseconds": median, "quartile1": first, "quartile3": third}
