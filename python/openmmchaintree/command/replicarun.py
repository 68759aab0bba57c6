"""Runs replicas for the command: from the start or from a checkpoint, to the end or until the user interrupts."""

import os
from hashlib import sha256
from time import monotonic

import openmm

from .. import __version__
from ..errors import ClusterError, InputError
from ..replicas.checkpointfile import nameTemporary, readCheckpoint, writeCheckpoint
from ..replicas.coordinator import Coordinator, RunState
from ..replicas.schedule import Schedule
from .outputs.outputfiles import OutputError, checkOutputs, encoded
from .outputs.replicafiles import ReplicaFiles
from .outputs.trajectoryfile import trialsOfAStep
from .savedheader import findWrong, findWrongState
from .terminal import interruptFlag, printError, progress

# The kinds of outputs that are written at the end.
REPORTS = ("picture", "notes", "json")

# Settings that a run may go on with in another way.
FREE_SETTINGS = ("workers", "checkpoint-interval", "json", "notes")


class ReplicaRun:
    """Replicas of a Sampling, and the files that they write.

    Attributes
    ----------
    plan : RunPlan
    state : RunState
    interrupts : Interrupts, or False before it runs
    reports : list of str
        the digests of what was written at the end, so far
    """

    def __init__(self, sampling, plan, choice, settings, outputs, model, workers):
        """Take a Sampling that has not moved, a RunPlan, a ReplicaChoice, settings, Outputs, and who runs Segments.

        outputs : dict of "checkpoint" and "index", Outputs, and "trajectories", a list of them
        model : Model, of the Sampling; workers : ThreadReplicas or ClusterReplicas of that Model
        """
        self._sampling = sampling
        self._model = model
        self._workers = workers
        self._choice = choice
        self._settings = settings
        self._outputs = outputs
        self._indexMark = None
        self._temporaryName = nameTemporary()
        self.plan = plan
        self.state = RunState(plan, len(sampling.moves))
        self.interrupts = False
        self._coordinator = None
        self.reports = []

    def goOn(self, saved):
        """Go on from a SavedRun.

        Raises
        ------
        InputError
            if it is of another structure or force field, or cannot go on to as many trials
        """
        if saved.header["model"] != self._model.key:
            raise InputError(
                f"{saved.path}: is of a run from another structure, force field or version "
                f"(that was openmm-chaintree {saved.header['madeBy']}, this is {__version__})"
            )
        saved.checkState(self.plan, len(self._sampling.moves))
        checkpoints = [saved.checkpoints.get(replica) for replica in range(len(self.plan.seeds))]
        self.state.restore(saved.header["state"], checkpoints)
        saved.checkSchedule(self.plan.schedule, self.state.round)
        self._indexMark = tuple(saved.header["index"])
        self._temporaryName = saved.header["temporary"]
        self.reports = saved.header["reports"]

    def begin(self):
        """Begin the files, or open them to go on."""
        byTemperature, round, isNew = self._choice.filesByTemperature, self.state.round, self._indexMark is None
        self._files = ReplicaFiles(self._outputs, self.plan, byTemperature, self._sampling, round, self._indexMark)
        try:
            self._sync()
            self._save()
        except BaseException:
            self._files.close()
            if isNew:
                self._files.remove()
                self._outputs["checkpoint"].removeFormer()  # of which there was none
            raise

    def run(self):
        """Run to the end, or until the user interrupts.

        Raises
        ------
        OutputError
            if a file cannot be written, OpenMM refuses, or a cluster is lost; the run goes on from its last checkpoint
        """
        plan, state = self.plan, self.state
        total = plan.schedule.trials * len(plan.seeds)
        with self._files:
            try:
                with interruptFlag(self._stop) as self.interrupts, progress(total) as advance:
                    while state.round < plan.schedule.rounds and not self.interrupts:
                        self._runFor(self._choice.checkpointInterval, advance)
                        self._sync()
                        self._save()
            except (OutputError, ClusterError, openmm.OpenMMException) as error:
                raise OutputError(f"{error}; {self._whereItStopped()}") from error
            except KeyboardInterrupt:
                printError(f"interrupted; {self._whereItStopped()}")
                raise

    def _runFor(self, seconds, advance):
        """Run rounds for so many seconds, at least one; an interrupt ends it with the last that all have ended."""
        self._coordinator = coordinator = Coordinator(self.plan, self.state, self._files.add)
        begun = monotonic()

        def shouldHold():
            advance(coordinator.trials)
            return monotonic() >= begun + seconds

        if not self.interrupts:
            coordinator.run(self._workers.submit, self._workers.slots(), shouldHold)
        if self.interrupts:
            self._files.shorten(self.state.round)
        self.state.wallSeconds += monotonic() - begun

    def _stop(self):
        """Stop at once; a handler of signals calls it."""
        if self._coordinator is not None:
            self._coordinator.stop()
        self._workers.stop()

    def noteReport(self, content):
        """Note bytes that are about to be written at the end: a run that goes on from here may replace them."""
        self.reports = sorted({*self.reports, sha256(content).hexdigest()})
        self._save()

    def _sync(self):
        """Wait until all that was written is on the disk, and take the mark of the index."""
        self._files.sync()
        self._indexMark = self._files.index.mark

    def _save(self):
        """Write the checkpoint; all that it counts is on the disk."""
        header = {
            "model": self._model.key,
            "madeBy": __version__,
            "settings": self._settings,
            "index": self._indexMark,
            "temporary": self._temporaryName,
            "reports": self.reports,
            "state": self.state.asPlain(),
        }
        output = self._outputs["checkpoint"]
        with output.explainingErrors():
            writeCheckpoint(output.path, header, self.state.checkpoints, self._temporaryName)

    def _whereItStopped(self):
        name = self._outputs["checkpoint"].name
        return f"the run goes on from its last checkpoint by --resume {name}"


class SavedRun:
    """What a checkpoint file holds. path : str; header : dict; checkpoints : dict of bytes by replica."""

    def __init__(self, path):
        """Read a file.

        Raises
        ------
        InputError
            if it is no checkpoint
        """
        self.path = path
        self.header, self.checkpoints = readCheckpoint(path)
        self._refuse(findWrong(self.header))

    def _refuse(self, wrong):
        if wrong is not None:
            raise InputError(f"{self.path}: is no checkpoint of this command: {wrong} is missing or wrong in it")

    def checkState(self, plan, moves):
        """Refuse a state that is none of a RunPlan with so many moves, or has other replicas than it."""
        state = self.header["state"]
        self._refuse(findWrongState(state, plan, moves))
        if sorted(self.checkpoints) != list(range(len(plan.seeds) if state["round"] > 0 else 0)):
            self._refuse("the checkpoint of a replica")

    def checkPath(self, name, path):
        """Refuse a file that settings name and that would be written elsewhere than beside the checkpoint."""
        folders = [os.path.dirname(os.path.realpath(each)) for each in (self.path, str(path))]
        if folders[0] != folders[1]:
            raise InputError(
                f"{self.path}: {name} {path} is outside of its folder; give --{name} once more to write there"
            )

    def checkUnchanged(self):
        """Refuse to go on if the file is another one by now: another run has gone on, or begun.

        Raises
        ------
        InputError
            if it is, or cannot be read
        """
        if readCheckpoint(self.path) != (self.header, self.checkpoints):
            raise InputError(f"{self.path}: another run has written it meanwhile")

    @property
    def settings(self):
        """The settings of the run."""
        return self.header["settings"]

    def checkSettings(self, settings):
        """Refuse settings that are not those of the run; it may go on to more trials."""
        names = {*self.settings, *settings}.difference(FREE_SETTINGS, ("trials",))
        for name in sorted(names):
            if self.settings.get(name) != settings.get(name):
                option = name if name == "structure" else f"--{name}"
                raise InputError(f"--resume {self.path}: a run goes on with its own settings, without another {option}")

    def framesOf(self, trials):
        """Return the number of frames of so many trials, as far apart as those of the run.

        Raises
        ------
        InputError
            if these are fewer trials than the run has, or no multiple of those between frames
        """
        former, interval = self.settings["trials"], self._schedule.interval
        if trials == former:
            return self.settings["frames"]
        if trials < former:
            raise InputError(
                f"--resume {self.path}: a run of {former:,} trials goes on to more of them, not to {trials:,}"
            )
        if trials % interval != 0:
            raise InputError(f"--resume {self.path}: --trials has to be a multiple of the {interval:,} between frames")
        return trials // interval

    @property
    def _schedule(self):
        """The Schedule of the run, but for its rounds."""
        trials = self.settings["trials"]
        return Schedule(trials, 1, -(-trials // self.settings["frames"]))

    def checkSchedule(self, schedule, round):
        """Refuse a Schedule that is another one than that of the run before a round."""
        former = self._schedule._replace(trialsPerRound=schedule.trialsPerRound)
        begins = [each.trialsBefore(round) for each in (former, schedule)]
        frames = [each.trialsOfFrame(each.framesBefore(round)) for each in (former, schedule)]
        steps = [trialsOfAStep(each.interval, 1 + each.frames) for each in (former, schedule)]
        reasons = {
            f"its last round ended after fewer than {schedule.trialsPerRound:,} of them": begins[0] != begins[1],
            f"its last frame came after fewer than {former.interval:,} of them": frames[0] != frames[1],
            "its trajectories cannot count so many": steps[0] != steps[1],
        }
        for reason, isSo in reasons.items():
            if isSo:
                raise InputError(f"--resume {self.path}: the run cannot go on to more trials, since {reason}")

    def checkOutputs(self, names, inputs, overwrite):
        """Return the Outputs of the run that goes on, as `checkOutputs` does: what the run has written is there."""
        if os.path.realpath(self.path) != os.path.realpath(names["checkpoint"]):
            raise InputError(f"--resume {self.path}: the run writes its checkpoints to {names['checkpoint']}")
        ours = {kind: name for kind, name in names.items() if kind not in REPORTS or self._hasWritten(name)}
        others = {kind: name for kind, name in names.items() if kind not in ours}
        return {**checkOutputs(ours, inputs, True), **checkOutputs(others, inputs, overwrite)}

    def _hasWritten(self, name):
        """Whether a file is a report of the run, as it was written."""
        if name is None or not os.path.isfile(name):
            return False
        with open(name, "rb") as file:
            return sha256(file.read()).hexdigest() in self.header["reports"]


class NotedReport:
    """A report of a ReplicaRun: an Output whose content the checkpoint knows before it is written."""

    def __init__(self, output, run):
        """Take the Output and the ReplicaRun."""
        self._output = output
        self._run = run
        self.name = output.name
        self.isStandardOutput = output.isStandardOutput

    def write(self, content):
        """Note a text or bytes, and write them, as `Output.write` does."""
        content = content if isinstance(content, bytes) else encoded(content)
        if not self.isStandardOutput:
            self._run.noteReport(content)
        self._output.write(content)
