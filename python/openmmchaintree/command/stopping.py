"""When a run ends: after its trials, after some time, or when a condition holds, whichever comes first."""

import math
from time import monotonic
from typing import Protocol

from ..errors import InputError
from ..statistics.estimates import LARGEST_RHAT
from .arguments import duration, frameCount, positive, sampleSize

_TRIALS, _FRAMES = 100000, 200  # by default

# Where nothing limits the trials.
_TRIALS_PER_FRAME = 10000
_UNLIMITED = 10**12  # and more

_MOST_TRIALS, _MOST_FRAMES = 10**15, 10**9

# Conditions are asked after rounds of the run whose numbers grow by this factor, so that asking takes little of a run.
_GROWTH = 1.2


class StopCondition(Protocol):
    """Ends a run when it holds.

    Conditions are asked after fixed rounds, whatever the time and the number of workers. Thus a run that was resumed
    ends where an uninterrupted one ends.

    Attributes
    ----------
    option : str
        as the user gave it, for the report
    """

    option: str

    def holds(self, run) -> bool:
        """Whether a ReplicaRun shall end now. Its files hold all frames before the round `run.state.round`."""

    def describe(self) -> str:
        """Return words on the last answer for the progress bar, such as "effective sample size 57"; "" before."""


def addStopping(parser):
    """Add the options that end a run, and choose its frames, to a parser."""
    parser.add_argument(
        "--trials",
        type=positive,
        metavar="N",
        help=f"number of trials, such as 1e6 (default: {_TRIALS}; no limit with --time or --until-ess)",
    )
    parser.add_argument(
        "--time",
        type=duration,
        metavar="TIME",
        help="end the run after this time, such as 30min, 1.5h or 90 (seconds), at the end of a round; --resume "
        "continues it, for the same time unless another one is given",
    )
    parser.add_argument(
        "--until-ess",
        type=sampleSize,
        metavar="N",
        help="end the run when the least effective sample size of energy, shapes and torsions is N, and R-hat at most "
        f"{LARGEST_RHAT}; with --temperatures, those at the lowest",
    )
    parser.add_argument(
        "--frames", type=frameCount, metavar="N", help=f"frames to write after the start (default: {_FRAMES})"
    )
    parser.add_argument(
        "--trials-per-frame",
        type=positive,
        metavar="M",
        help=f"trials between frames, instead of --frames (default without a limit on trials: {_TRIALS_PER_FRAME})",
    )


def settleTrials(options):
    """Set the trials and frames of the options that the user did not choose.

    Raises
    ------
    InputError
        if an option contradicts another one
    """
    isLimited = options.trials is not None or (options.time is None and options.until_ess is None)
    if options.frames is not None and options.trials_per_frame is not None:
        raise InputError("--frames and --trials-per-frame cannot be used together")
    if not isLimited:
        if options.frames is not None:
            raise InputError("--frames needs --trials; without a limit on trials, use --trials-per-frame")
        perFrame = options.trials_per_frame or _TRIALS_PER_FRAME
        options.frames = min(_MOST_FRAMES, _MOST_TRIALS // perFrame)
        options.trials = options.frames * perFrame
    else:
        options.trials = options.trials or _TRIALS
        if options.trials_per_frame is None:
            options.frames = options.frames or _FRAMES
        elif options.trials % options.trials_per_frame != 0:
            raise InputError("--trials has to be a multiple of --trials-per-frame")
        else:
            options.frames = frames = options.trials // options.trials_per_frame
            if frames > _MOST_FRAMES:
                raise InputError(f"--trials-per-frame: {frames:,} frames are more than the {_MOST_FRAMES:,} of a file")
    options.trials_per_frame = None  # the settings of a run have trials and frames


class Stopping:
    """Decides when a ReplicaRun ends before its last trial.

    Attributes
    ----------
    conditions : list of StopCondition
    """

    def __init__(self, seconds=None, conditions=()):
        """Take the time that the run may take from `begin` on, if there is a limit, and conditions."""
        self._seconds = math.inf if seconds is None else seconds
        self._deadline = math.inf
        self.conditions = list(conditions)

    def begin(self):
        """Start the time."""
        self._deadline = monotonic() + self._seconds

    def totalOf(self, plan):
        """Return the trials of all replicas of a RunPlan; None if these are no limit."""
        mayEndBefore = self.conditions or self._seconds < math.inf
        return None if mayEndBefore and plan.schedule.trials >= _UNLIMITED else plan.schedule.trials * len(plan.seeds)

    def secondsLeft(self):
        """Return the time that is left; infinity without a limit."""
        return self._deadline - monotonic()

    def nextRound(self, round):
        """Return the first round after a given one before which conditions are asked; None without conditions."""
        if not self.conditions:
            return None
        asked = 0
        while asked <= round:
            asked = max(asked + 1, int(_GROWTH * asked))
        return asked

    def reason(self, run):
        """Return the option that ends a ReplicaRun now, or None."""
        if self.secondsLeft() <= 0:
            return f"--time {self._seconds:g} s"
        round = run.state.round
        if round > 0 and self.nextRound(round - 1) == round:
            return next((condition.option for condition in self.conditions if condition.holds(run)), None)
        return None

    def describe(self):
        """Return words on the conditions for the progress bar."""
        return list(filter(None, (condition.describe() for condition in self.conditions)))
