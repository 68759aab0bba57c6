"""The command openmm-chaintree sample after its preparation: names the files, runs one or many replicas, reports."""

from contextlib import closing

from ..notes import countOf
from ..replicas.threads import ThreadReplicas
from .config import asTOML
from .convergence import estimateGroups
from .ending import endRun, writeReports
from .enoughsamples import EnoughSamples
from .ladderweights import asTable, weighLadder
from .outputs.indexfile import readIndex
from .outputs.outputfiles import Writing, beginning
from .outputs.replicafiles import trajectoryNames
from .outputs.scenefiles import removeScene, renewSettings, writeScene
from .outputs.trajectories import FORMATS, readPositions
from .replicaoptions import makePlan
from .replicarun import NotedReport, ReplicaRun
from .reports.planreport import printPlan
from .runkinds import ManyReplicas, SingleRun
from .savedrun import FREE_SETTINGS, REPORTS
from .series import readSeries
from .stopping import Stopping

_TRAJECTORY = "trajectory "


def namesOfRun(prefix, choice):
    """Return the names of the files that grow during the run of a ReplicaChoice, and of its checkpoint, by kind."""
    checkpoint = f"{prefix}.checkpoint"
    if choice.isSingle:
        return {f"{_TRAJECTORY}0": f"{prefix}.{choice.format}", "index": f"{prefix}.csv", "checkpoint": checkpoint}
    names = trajectoryNames(prefix, choice.replicas, choice.temperatures, choice.filesByTemperature, choice.format)
    numbered = {f"{_TRAJECTORY}{number}": name for number, name in enumerate(names)}
    weights = {} if choice.temperatures is None else {"weights": f"{prefix}-weights.csv"}
    return {"index": f"{prefix}-index.csv", "checkpoint": checkpoint, **numbered, **weights}


def sampleReplicas(prepared, choice, saved):
    """Run the replicas of a ReplicaChoice, resuming a SavedRun if given; return the exit status."""
    model = prepared.sampling.model()
    with closing(_makeWorkers(choice, model)) as workers:
        return _sampleBy(workers, model, prepared, choice._replace(workers=workers.count), saved)


def _makeWorkers(choice, model):
    """Return the workers that run Segments of a Model."""
    if choice.scheduler is None:
        return ThreadReplicas(model, choice.workers)
    from ..replicas.cluster import Cluster, ClusterReplicas  # Dask takes long to import

    return ClusterReplicas(Cluster(choice.scheduler), model)


def _sampleBy(workers, model, prepared, choice, saved):
    options, settings, outputs, console, sampling, energyModel, seed, added = prepared
    trajectories = [output for kind, output in outputs.items() if kind.startswith(_TRAJECTORY)]
    files = {"trajectories": trajectories, "index": outputs["index"], "checkpoint": outputs["checkpoint"]}
    plan = makePlan(choice, options, energyModel, seed, len(sampling.structure.positions))
    conditions = []
    if options.until_ess is not None:
        conditions.append(EnoughSamples(options.until_ess, sampling, choice, outputs["index"], trajectories))
    run = ReplicaRun(sampling, plan, choice, Stopping(options.time, conditions), settings, files, model, workers)
    if saved is not None:
        run.goOn(saved)
    writing = Writing()
    try:
        with beginning(outputs.values()):
            _beginFiles(run, outputs, sampling.structure, settings, saved)
        printPlan(sampling, console)
        for line in _describeRun(run, choice):
            console.print(line)
        run.run()

        index = readIndex(outputs["index"].path)
        kind = SingleRun(run, sampling) if choice.isSingle else ManyReplicas(run, sampling, choice.workers)
        summary = kind.summarize(index, seed=seed, addedHydrogens=added)
        series = readSeries(sampling, plan, index, [file.path for file in trajectories], choice.filesByTemperature)
        summary["estimates"] = estimateGroups(series, sampling.torsions, FORMATS[choice.format].resolution)
        written = ["topology", "settings", "index", "checkpoint"]
        writing.files = [
            *(outputs[kind].name for kind in written if kind in outputs),
            *(file.name for file in trajectories),
        ]
        reports = {kind: NotedReport(outputs[kind], run) for kind in REPORTS if kind in outputs}
        if summary["frames"] > 1:
            writing.write(reports["picture"], lambda output: kind.savePicture(output, summary, index, trajectories))
        if plan.isExchange:
            summary["atLowestTemperature"], *weighed = weighLadder(series, summary["estimates"])
            writing.write(reports["weights"], lambda output: output.write(asTable(index, *weighed)))
        summary["files"] = writing.files
        writeReports(
            writing,
            reports,
            sampling.notes,
            summary,
            lambda: _makePage(summary, settings, outputs["picture"], trajectories[0], sampling.structure.topology),
        )
    finally:
        outputs["topology"].release()
    kind.printReport(summary, console, options.verbose)
    return endRun(writing, kind.isBeyond(summary), kind.interrupts)


def _makePage(summary, settings, picture, trajectory, topology):
    """Return the page of a run; picture, trajectory : Outputs that were written, the latter of what it shows."""
    from .reports.htmlreport import MOST_FRAMES, asHTML  # which few runs need

    image = picture.path.read_bytes() if summary["frames"] > 1 else None
    step = -(-summary["frames"] // MOST_FRAMES)
    frames = list(readPositions(trajectory.path, topology, summary["frames"], step))
    return asHTML(summary, image, asTOML(settings), topology, frames)


def _beginFiles(run, outputs, structure, settings, saved):
    """Begin the files of a ReplicaRun, or resume a SavedRun's. If one fails, remove the files of a new run."""
    if saved is not None:
        saved.checkUnchanged()
        outputs["topology"].hold()
        run.begin()
        renewSettings(outputs, settings, FREE_SETTINGS)
        return
    outputs["checkpoint"].removeFormer()  # the former run's files are replaced now
    writeScene(outputs, structure, settings)
    try:
        run.begin()
    except BaseException:
        removeScene(outputs)
        raise


def _describeRun(run, choice):
    """Return lines on the replicas of a ReplicaRun, and where it resumes."""
    plan, trials = run.plan, run.plan.schedule.trialsBefore(run.state.round)
    if choice.isSingle:
        return [f"resumed after {countOf(trials, 'trial')}"] if trials else []
    words = f"replicas: {len(plan.seeds)} by {countOf(choice.workers, 'worker')}"
    if choice.scheduler is not None:
        words += f" of {choice.scheduler}"
    if plan.isExchange:
        kelvins = ", ".join(f"{temperature:.1f}" for temperature in plan.temperatures)
        words += f", which exchange the temperatures {kelvins} K every {plan.schedule.trialsPerRound:,} trials"
    return [f"{words}; resumed after {countOf(trials, 'trial')} of each" if trials else words]
