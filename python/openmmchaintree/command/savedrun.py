"""The saved state of a run of replicas, checked before its use, since anybody may have written the file."""

import os
import re
from hashlib import sha256

from ..errors import InputError
from ..replicas.checkpointfile import readCheckpoint
from ..replicas.coordinator import RunState
from ..replicas.schedule import Schedule
from .outputs.outputfiles import checkOutputs

# The kinds of outputs that are written at the end.
REPORTS = ("picture", "weights", "notes", "json", "report")

# Settings that a resumed run may change.
FREE_SETTINGS = ("workers", "time", "until-ess", "checkpoint-interval", "json", "notes", "report")

_VERSION_WITHOUT_HISTORY = 2

_LARGEST_COUNT = 10**15
_LONGEST_TIME = 1e12  # s


class SavedRun:
    """The content of a checkpoint file. path : str; header : dict; checkpoints : dict of bytes by replica."""

    def __init__(self, path):
        """Read a file.

        Raises
        ------
        InputError
            if it is not a checkpoint
        """
        self.path = path
        self.header, self.checkpoints = readCheckpoint(path)
        self._refuse(_findWrong(self.header))

    def _refuse(self, wrong):
        if wrong is not None:
            raise InputError(f"{self.path}: is not a checkpoint of this command: {wrong} is missing or wrong in it")

    def checkState(self, plan, moves):
        """Refuse a state that does not match a RunPlan with `moves` moves and the former trials, or its replicas."""
        state = self.header["state"]
        plan = plan._replace(schedule=self._schedule._replace(trialsPerRound=plan.schedule.trialsPerRound))
        if self.header["version"] == _VERSION_WITHOUT_HISTORY:
            state = {**state, "stages": [], "history": []}
        self._refuse(_findWrongState(state, plan, moves))
        if sorted(self.checkpoints) != list(range(len(plan.seeds) if state["round"] > 0 else 0)):
            self._refuse("the checkpoint of a replica")

    def checkPath(self, name, path):
        """Refuse a file named by settings that is not in the checkpoint's folder."""
        folders = [os.path.dirname(os.path.realpath(each)) for each in (self.path, str(path))]
        if folders[0] != folders[1]:
            raise InputError(
                f"{self.path}: {name} {path} is outside of its folder; give --{name} once more to write there"
            )

    def checkUnchanged(self):
        """Refuse to resume if the file has changed since it was read: another run has resumed, or begun.

        Raises
        ------
        InputError
            if it has changed, or cannot be read
        """
        if readCheckpoint(self.path) != (self.header, self.checkpoints):
            raise InputError(f"{self.path}: another run has written it in the meantime")

    @property
    def settings(self):
        """The settings of the run."""
        return self.header["settings"]

    def checkSettings(self, settings):
        """Refuse settings that differ from the run's, except the number of trials."""
        names = {*self.settings, *settings}.difference(FREE_SETTINGS, ("trials",))
        for name in sorted(names):
            if self.settings.get(name) != settings.get(name):
                option = name if name == "structure" else f"--{name}"
                raise InputError(f"--resume {self.path}: a resumed run keeps its settings, also {option}")

    def framesOf(self, trials):
        """Return the number of frames for a number of trials, with the interval between frames of the run.

        Raises
        ------
        InputError
            if it is not a multiple of the interval
        """
        interval = self._schedule.interval
        if trials == self.settings["trials"]:
            return self.settings["frames"]
        if trials % interval != 0:
            raise InputError(f"--resume {self.path}: --trials has to be a multiple of the {interval:,} between frames")
        return trials // interval

    @property
    def _schedule(self):
        """The Schedule of the run, without its rounds."""
        trials = self.settings["trials"]
        return Schedule(trials, 1, -(-trials // self.settings["frames"]))

    def checkSchedule(self, schedule, round):
        """Refuse a Schedule that differs from the run's before a round."""
        former = self._schedule._replace(trialsPerRound=schedule.trialsPerRound)
        made = former.trialsBefore(round)
        if schedule.trials < made:
            raise InputError(
                f"--resume {self.path}: the run has made {made:,} trials, and cannot end after {schedule.trials:,}"
            )
        begins = [each.trialsBefore(round) for each in (former, schedule)]
        frames = [each.trialsOfFrame(each.framesBefore(round)) for each in (former, schedule)]
        reasons = {
            f"its last round ended after fewer than {schedule.trialsPerRound:,} of them": begins[0] != begins[1],
            f"its last frame came after fewer than {former.interval:,} of them": frames[0] != frames[1],
        }
        for reason, isSo in reasons.items():
            if isSo:
                raise InputError(f"--resume {self.path}: the run cannot be continued to more trials, since {reason}")

    def checkOutputs(self, names, inputs, overwrite):
        """Return the Outputs of a resumed run, as `checkOutputs` does; files that the run has written may exist."""
        if os.path.realpath(self.path) != os.path.realpath(names["checkpoint"]):
            raise InputError(f"--resume {self.path}: the run writes its checkpoints to {names['checkpoint']}")
        ours = {kind: name for kind, name in names.items() if kind not in REPORTS or self._hasWritten(name)}
        others = {kind: name for kind, name in names.items() if kind not in ours}
        return {**checkOutputs(ours, inputs, True), **checkOutputs(others, inputs, overwrite)}

    def _hasWritten(self, name):
        """Whether a file is an unchanged report of the run."""
        if name is None or not os.path.isfile(name):
            return False
        with open(name, "rb") as file:
            return sha256(file.read()).hexdigest() in self.header["reports"]


# ---- Checks of the header ----


def _whole(least, largest):
    return lambda value: isinstance(value, int) and not isinstance(value, bool) and least <= value <= largest


def _text(pattern):
    return lambda value: isinstance(value, str) and re.fullmatch(pattern, value) is not None


def _all(check, count=None):
    """Return a check for a list of `count` items, or of any number."""
    return lambda value: isinstance(value, list) and count in (None, len(value)) and all(map(check, value))


def _isScalar(value):
    return isinstance(value, (str, int, float))


def _isSetting(value):
    return _isScalar(value) or _all(_isScalar)(value)


def _isTime(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and 0 <= value <= _LONGEST_TIME


def _isBoolOrNone(value):
    return value is None or isinstance(value, bool)


_count = _whole(0, _LARGEST_COUNT)
_digest = _text("[0-9a-f]{64}")

_HEADER = {
    "version": _count,
    "digests": lambda value: isinstance(value, dict) and all(map(_digest, value.values())),
    "model": _digest,
    "madeBy": _text(r"[\w.+-]{1,50}"),
    "settings": lambda value: isinstance(value, dict) and all(map(_isSetting, value.values())),
    "index": lambda value: _all(_count, 2)(value) and value[1] < 2**32,
    "reports": _all(_digest),
    "state": lambda value: isinstance(value, dict),
    "temporary": _text(r"\.[0-9a-f]{16}\.part"),
}
# Settings that are needed before the parser checks all of them.
_SETTINGS = {"trials": _whole(1, _LARGEST_COUNT), "frames": _whole(1, _LARGEST_COUNT), "seed": _whole(1, 2**31 - 1)}


def _findWrong(header):
    """Return the name of the first wrong entry of a header, or None."""
    return _firstWrong(header, _HEADER, "") or _firstWrong(header["settings"], _SETTINGS, "settings.", others=True)


def _findWrongState(state, plan, moves):
    """Return the name of the first wrong entry in the state of a RunPlan with `moves` moves, or None."""
    replicas, temperatures = len(plan.seeds), len(plan.temperatures)
    checks = {
        "round": _whole(0, plan.schedule.rounds),
        "temperatureOf": _all(_whole(0, temperatures - 1), replicas),
        "wasHotLast": _all(_isBoolOrNone, replicas),
        "roundTrips": _all(_count, replicas),
        "attempted": _all(_count, temperatures - 1),
        "accepted": _all(_count, temperatures - 1),
        "seconds": _isTime,
        "secondsInSteps": _isTime,
        "wallSeconds": _isTime,
        "counts": _table(temperatures, moves, 4),
        "countsOfReplica": _table(replicas, moves, 4),
        "outerTests": _table(temperatures, 3),
        "stages": _all(_table(2)),
        "history": _all(_isPoint(moves)),
    }
    assert checks.keys() == RunState(plan, moves).asPlain().keys()
    wrong = _firstWrong(state, checks, "state.")
    if wrong is None and plan.isExchange and sorted(state["temperatureOf"]) != list(range(temperatures)):
        return "state.temperatureOf"
    if wrong is None and state["round"] > 0 and state["wallSeconds"] == 0:
        return "state.wallSeconds"
    return wrong


def _isPoint(moves):
    """Return a check for an entry of the history."""
    return lambda value: _all(lambda _: True, 2)(value) and _count(value[0]) and _table(moves, 2)(value[1])


def _table(*shape):
    check = _count
    for count in reversed(shape):
        check = _all(check, count)
    return check


def _firstWrong(values, checks, prefix, others=False):
    """Return the name of the first value that is missing, fails its check, or has no check unless `others` is true."""
    if not isinstance(values, dict):
        return prefix.removesuffix(".") or "run.json"
    for name, check in checks.items():
        if name not in values or not check(values[name]):
            return prefix + name
    return None if others else next((prefix + repr(name) for name in values if name not in checks), None)
