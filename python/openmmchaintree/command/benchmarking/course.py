"""What all rows of a benchmark share: the program, how long they may take, and where scenes lie."""

from pathlib import Path


class Course:
    """The settings of a run.

    Attributes
    ----------
    program : Program
    seed : int
    trials : int
        of a race, unless its time is up before
    seconds : float
        of processor time that the contestants of a row may take together
    """

    REPEATS = 3  # of runs that take turns as whole processes

    def __init__(self, program, seed, trials, seconds, folder):
        """Make a Course that keeps files of its own in a folder."""
        self.program = program
        self.seed = seed
        self.trials = trials
        self.seconds = seconds
        self._folder = Path(folder)
        self._scenes = {}

    def sceneFile(self, model):
        """Return the path of a file with the scene of a Model."""
        if id(model) not in self._scenes:
            path = self._folder / f"scene-{len(self._scenes)}"
            model.scene.write(path)
            self._scenes[id(model)] = path, model  # which keeps the id its own
        return self._scenes[id(model)][0]

    def recordFile(self):
        """Return the path of a file for the record of a race, of which there is one at a time."""
        return self._folder / "record"
