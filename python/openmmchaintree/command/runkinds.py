"""The two kinds of runs, of one replica and of many: their results, pictures and reports."""

from .forbidden import measureForbidden
from .outputs.trajectories import readPositions
from .pictures import savePicture
from .reports import replicareport, samplereport
from .terminal import interruptFlag


class SingleRun:
    """A finished ReplicaRun of one replica, which has a trajectory with the name of the run.

    Attributes
    ----------
    interrupts : Interrupts
    """

    def __init__(self, run, sampling):
        """Take the ReplicaRun and its Sampling."""
        self._run = run
        self._sampling = sampling
        self.interrupts = run.interrupts

    def summarize(self, index, **about):
        """Return all results for JSON, from the table of frames; about : seed, addedHydrogens."""
        run, sampling = self._run, self._sampling
        sampling.takeUp(run.state.checkpoints[0])
        summary = samplereport.summarize(
            sampling, run.plan, run.state, index, interrupted=bool(run.interrupts), endedBy=run.endedBy, **about
        )
        summary["forbiddenBySpheres"] = self._measureForbidden(summary["trials"])
        return summary

    def _measureForbidden(self, trials):
        if self.interrupts:
            return measureForbidden(self._sampling, trials, self.interrupts)
        with interruptFlag() as self.interrupts:
            return measureForbidden(self._sampling, trials, self.interrupts)

    def savePicture(self, output, summary, index, trajectories):
        """Write the picture to an Output; trajectories : Outputs."""
        sampling = self._sampling
        frames = readPositions(trajectories[0].path, sampling.structure.topology, len(index["frame"]))
        angles = list(map(sampling.shownAngles, frames))
        kinds = [torsion.kind for torsion in sampling.torsions]
        savePicture("samplepicture", output, summary, index, angles, kinds, self._run.state.history)

    def printReport(self, summary, console, isVerbose):
        """Print the results."""
        samplereport.printReport(summary, console, isVerbose)

    def isBeyond(self, summary):
        """Whether the run ended with pairs beyond their limit, or with changed bonds."""
        return bool(summary["pairsBeyondLimit"] or summary["changedBonds"])


class ManyReplicas:
    """A finished ReplicaRun of many replicas, with the methods of SingleRun."""

    def __init__(self, run, sampling, workers):
        """Take the ReplicaRun, its Sampling, and the number of workers."""
        self._run = run
        self._sampling = sampling
        self._workers = workers
        self.interrupts = run.interrupts

    def summarize(self, index, **about):
        run = self._run
        about |= {"workers": self._workers, "interrupted": bool(run.interrupts), "endedBy": run.endedBy}
        return replicareport.summarizeReplicas(self._sampling, run.plan, run.state, index, **about)

    def savePicture(self, output, summary, index, trajectories):
        savePicture("replicapicture", output, summary, index)

    def printReport(self, summary, console, isVerbose):
        replicareport.printReplicaReport(summary, console, isVerbose)

    def isBeyond(self, summary):
        return replicareport.isBeyond(summary)
