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

# Settings that a resumed run may change.
FREE_SETTINGS = ("workers", "checkpoint-interval", "json", "notes")


class ReplicaRun:
    """The replicas of a Sampling, and their output files.

    Attributes
    ----------
    plan : RunPlan
    state : RunState
    interrupts : Interrupts, or False before it runs
    reports : list of str
        the digests of the reports written at the end
    """

    def __init__(self, sampling, plan, choice, settings, outputs, model, workers):
        """Take a Sampling at its start, a RunPlan, a ReplicaChoice, settings, Outputs, and the workers.

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
        """Resume a SavedRun.

        Raises
        ------
        InputError
            if it has another structure or force field, or cannot be extended to the trials of the plan
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
        """Begin the files, or open them to resume."""
        byTemperature, round, isNew = self._choice.filesByTemperature, self.state.round, self._indexMark is None
        self._files = ReplicaFiles(self._outputs, self.plan, byTemperature, self._sampling, round, self._indexMark)
        try:
            self._sync()
            self._save()
        except BaseException:
            self._files.close()
            if isNew:
                self._files.remove()
                self._outputs["checkpoint"].removeFormer()  # written by this run
            raise

    def run(self):
        """Run to the end, or until the user interrupts.

        Raises
        ------
        OutputError
            if a file cannot be written, OpenMM fails, or a cluster is lost; --resume continues from the last checkpoint
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
        """Run rounds for some seconds, at least one round; an interrupt keeps the rounds that all have completed."""
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
        """Stop immediately; called by a signal handler."""
        if self._coordinator is not None:
            self._coordinator.stop()
        self._workers.stop()

    def noteReport(self, content):
        """Record the digest of a report before it is written, so that a resumed run may replace the report."""
        self.reports = sorted({*self.reports, sha256(content).hexdigest()})
        self._save()

    def _sync(self):
        """Wait until all written data is on disk, and record the mark of the index."""
        self._files.sync()
        self._indexMark = self._files.index.mark

    def _save(self):
        """Write the checkpoint; all data that it counts must be on disk."""
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
        return f"--resume {name} continues the run from its last checkpoint"


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
        self._refuse(findWrong(self.header))

    def _refuse(self, wrong):
        if wrong is not None:
            raise InputError(f"{self.path}: is no checkpoint of this command: {wrong} is missing or wrong in it")

    def checkState(self, plan, moves):
        """Refuse a state that does not match a RunPlan with `moves` moves, or its replicas."""
        state = self.header["state"]
        self._refuse(findWrongState(state, plan, moves))
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
            raise InputError(f"{self.path}: another run has written it meanwhile")

    @property
    def settings(self):
        """The settings of the run."""
        return self.header["settings"]

    def checkSettings(self, settings):
        """Refuse settings that differ from those of the run, except the number of trials."""
        names = {*self.settings, *settings}.difference(FREE_SETTINGS, ("trials",))
        for name in sorted(names):
            if self.settings.get(name) != settings.get(name):
                option = name if name == "structure" else f"--{name}"
                raise InputError(f"--resume {self.path}: a resumed run keeps its settings, so not another {option}")

    def framesOf(self, trials):
        """Return the number of frames for a number of trials, with the interval between frames of the run.

        Raises
        ------
        InputError
            if it is less than the trials of the run, or not a multiple of the interval
        """
        former, interval = self.settings["trials"], self._schedule.interval
        if trials == former:
            return self.settings["frames"]
        if trials < former:
            raise InputError(
                f"--resume {self.path}: a run of {former:,} trials can be continued to more, not to {trials:,}"
            )
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
        begins = [each.trialsBefore(round) for each in (former, schedule)]
        frames = [each.trialsOfFrame(each.framesBefore(round)) for each in (former, schedule)]
        steps = [trialsOfAStep(each.interval, 1 + each.frames) for each in (former, schedule)]
        reasons = {
            f"its last round ended after fewer than {schedule.trialsPerRound:,} of them": begins[0] != begins[1],
            f"its last frame came after fewer than {former.interval:,} of them": frames[0] != frames[1],
            "its trajectories cannot count them": steps[0] != steps[1],
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


class NotedReport:
    """A report of a ReplicaRun: an Output whose digest is in the checkpoint before it is written."""

    def __init__(self, output, run):
        """Take the Output and the ReplicaRun."""
        self._output = output
        self._run = run
        self.name = output.name
        self.isStandardOutput = output.isStandardOutput

    def write(self, content):
        """Record the digest of a text or bytes, and write them as `Output.write` does."""
        content = content if isinstance(content, bytes) else encoded(content)
        if not self.isStandardOutput:
            self._run.noteReport(content)
        self._output.write(content)
