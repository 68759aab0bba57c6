"""The command openmm-chaintree sample with replicas: names their files, runs them, reports."""

from contextlib import closing

from ..replicas.threads import ThreadReplicas
from .ending import endRun, writeReports
from .outputs.outputfiles import Writing, beginning
from .outputs.replicafiles import readIndex, trajectoryNames
from .outputs.scenefiles import removeScene, renewSettings, writeScene
from .pictures import savePicture
from .replicaoptions import makePlan
from .replicarun import NotedReport, ReplicaRun
from .reports.planreport import printPlan
from .reports.replicareport import isBeyond, printReplicaReport, summarizeReplicas
from .savedrun import FREE_SETTINGS, REPORTS

_TRAJECTORY = "trajectory "


def replicaNames(prefix, choice):
    """Return the names of the files of a ReplicaChoice by kind."""
    names = trajectoryNames(prefix, choice.replicas, choice.temperatures, choice.filesByTemperature)
    numbered = {f"{_TRAJECTORY}{number}": name for number, name in enumerate(names)}
    return {"index": f"{prefix}-index.csv", "checkpoint": f"{prefix}.checkpoint", **numbered}


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
    run = ReplicaRun(sampling, plan, choice, settings, files, model, workers)
    if saved is not None:
        run.goOn(saved)
    writing = Writing()
    try:
        with beginning(outputs.values()):
            _beginFiles(run, outputs, sampling.structure, settings, saved)
        printPlan(sampling, console)
        console.print(_describeRun(run, choice))
        run.run()

        index = readIndex(outputs["index"].path)
        summary = summarizeReplicas(
            sampling,
            run.plan,
            run.state,
            index,
            seed=seed,
            workers=choice.workers,
            interrupted=bool(run.interrupts),
            addedHydrogens=added,
        )
        written = ["topology", "settings", "index", "checkpoint"]
        writing.files = [
            *(outputs[kind].name for kind in written if kind in outputs),
            *(file.name for file in trajectories),
        ]
        reports = {kind: NotedReport(outputs[kind], run) for kind in REPORTS if kind in outputs}
        if summary["frames"] > 1:
            writing.write(reports["picture"], lambda output: savePicture("replicapicture", output, summary, index))
        summary["files"] = writing.files
        writeReports(writing, reports, sampling.notes, summary)
    finally:
        outputs["topology"].release()
    printReplicaReport(summary, console, options.verbose)
    return endRun(writing, isBeyond(summary), run.interrupts)


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
    """Return a line on the replicas of a ReplicaRun."""
    plan, trials = run.plan, run.plan.schedule.trialsBefore(run.state.round)
    words = f"replicas: {len(plan.seeds)} by {choice.workers} worker{'' if choice.workers == 1 else 's'}"
    if choice.scheduler is not None:
        words += f" of {choice.scheduler}"
    if plan.isExchange:
        kelvins = ", ".join(f"{temperature:.1f}" for temperature in plan.temperatures)
        words += f", which exchange the temperatures {kelvins} K every {plan.schedule.trialsPerRound:,} trials"
    return f"{words}; going on after {trials:,} trials of each" if trials else words
