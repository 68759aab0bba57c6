"""Ends a run when its means are known well enough."""

from ..statistics.estimates import LARGEST_RHAT
from .convergence import estimateGroups
from .outputs.indexfile import readIndex
from .outputs.trajectories import FORMATS
from .series import readSeries

_FEWEST_VALUES = 20  # of one chain, for a first estimate


class EnoughSamples:
    """The StopCondition of --until-ess: the least effective sample size over all observables, and R-hat.

    With exchange, those at the lowest temperature count.

    Attributes
    ----------
    option : str
    """

    def __init__(self, least, sampling, choice, index, trajectories):
        """Take the effective sample size to reach, the Sampling, its ReplicaChoice, and the Outputs of its frames."""
        self.option = f"--until-ess {least}"
        self._least = least
        self._sampling = sampling
        self._choice = choice
        self._index = index.path
        self._trajectories = [output.path for output in trajectories]
        self._found = None

    def holds(self, run):
        """Whether a ReplicaRun shall end."""
        plan = run.plan
        if plan.schedule.framesBefore(run.state.round) < _FEWEST_VALUES:
            return False
        index = readIndex(self._index)
        byTemperature, longest = self._choice.filesByTemperature, 4 * self._least
        series = readSeries(self._sampling, plan, index, self._trajectories, byTemperature, longest)
        series = series._replace(groups=series.groups[:1])
        resolution = FORMATS[self._choice.format].resolution
        (found,) = estimateGroups(series, self._sampling.torsions, resolution)
        self._found = found["leastSampleSize"] or 0.0
        isAlike = found["largestRhat"] is not None and found["largestRhat"] <= LARGEST_RHAT
        return self._found >= self._least and isAlike and found["equilibration"]["isEnough"]

    def describe(self):
        """Return the last effective sample size in words."""
        return "" if self._found is None else f"effective sample size {self._found:.0f} of {self._least}"
