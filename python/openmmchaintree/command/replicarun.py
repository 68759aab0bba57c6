"""Runs replicas for the command: from the start or from a checkpoint, to the end or until the user interrupts."""

from hashlib import sha256
from time import monotonic

import openmm

from .. import __version__
from ..errors import ClusterError, InputError
from ..replicas.checkpointfile import nameTemporary, writeCheckpoint
from ..replicas.coordinator import Coordinator, RunState
from .outputs.output import OutputError, encoded
from .outputs.replicafiles import ReplicaFiles
from .runprogress import RunProgress
from .terminal import interruptFlag, printError, progress


class ReplicaRun:
    """The replicas of a Sampling, and their output files.

    Attributes
    ----------
    plan : RunPlan
    state : RunState
    interrupts : Interrupts, or False before it runs
    endedBy : str
        the option that ended the run before its last trial, or None
    reports : list of str
        the digests of the reports written at the end
    """

    def __init__(self, sampling, plan, choice, stopping, settings, outputs, model, workers):
        """Take a Sampling at its start, a RunPlan, a ReplicaChoice, a Stopping, settings, Outputs, and the workers.

        outputs : dict of "checkpoint" and "index", Outputs, and "trajectories", a list of them
        model : Model, of the Sampling; workers : ThreadReplicas or ClusterReplicas of that Model
        """
        self._sampling = sampling
        self._model = model
        self._workers = workers
        self._choice = choice
        self._stopping = stopping
        self._settings = settings
        self._outputs = outputs
        self._indexMark = None
        self._temporaryName = nameTemporary()
        self.plan = plan
        self.state = RunState(plan, len(sampling.moves))
        self.interrupts = False
        self.endedBy = None
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
        round, isNew = self.state.round, self._indexMark is None
        self._files = ReplicaFiles(self._outputs, self.plan, self._choice, self._sampling, round, self._indexMark)
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
        """Run to the end, or until Stopping ends the run or the user interrupts.

        Raises
        ------
        OutputError
            if a file cannot be written, OpenMM fails, or a cluster is lost; --resume continues from the last checkpoint
        """
        plan, state, stopping = self.plan, self.state, self._stopping
        total = stopping.totalOf(plan)
        with self._files:
            try:
                with interruptFlag(self._stop) as self.interrupts, progress(total, hasText=True) as show:
                    stopping.begin()
                    shown = RunProgress(show, total, state, stopping)
                    self._workers.callAfterSteps(shown.add)
                    isOver = self._isOver()
                    due = monotonic() + self._choice.checkpointInterval
                    while not isOver:
                        self._runFor(min(due - monotonic(), stopping.secondsLeft()), shown)
                        isOver = self._isOver()
                        if isOver or monotonic() >= due:
                            self._sync()
                            self._save()
                            due = monotonic() + self._choice.checkpointInterval
            except (OutputError, ClusterError, openmm.OpenMMException) as error:
                raise OutputError(f"{error}; {self._whereItStopped()}") from error
            except KeyboardInterrupt:
                printError(f"interrupted; {self._whereItStopped()}")
                raise

    def _isOver(self):
        """Whether the run ends now; ask what may end it early."""
        if self.state.round >= self.plan.schedule.rounds or self.interrupts:
            return True
        self.endedBy = self._stopping.reason(self)
        return self.endedBy is not None

    def _runFor(self, seconds, shown):
        """Run rounds for some seconds, at least one round; an interrupt keeps the rounds that all have completed."""
        self._coordinator = coordinator = Coordinator(self.plan, self.state, self._files.add)
        begun = monotonic()
        shown.reach(coordinator.trials)

        def shouldHold():
            shown.reach(coordinator.trials)
            return monotonic() >= begun + seconds

        if not self.interrupts:
            until = self._stopping.nextRound(self.state.round)
            coordinator.run(self._workers.submit, self._workers.slots(), shouldHold, until)
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
