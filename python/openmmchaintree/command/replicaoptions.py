"""The options of replicas, checkpoints and resumed runs."""

from typing import NamedTuple

from ..errors import InputError
from ..replicas.coordinator import RunPlan
from ..replicas.ladder import REPLICAS, deriveSeeds, readLadder
from ..replicas.schedule import Schedule
from ..structures.limits import checkMemory
from .arguments import addScheduler, checkWorkers, numberIn, positive, positiveUpTo, refuseWithout, usableCores
from .outputs.trajectories import FORMATS

_TRIALS_PER_EXCHANGE = 4000
_TRIALS_PER_ROUND = 10000  # without exchange
_CHECKPOINT_INTERVAL = 60.0  # s
_FORMAT = "dcd"
_BYTES_PER_ATOM = 24  # in a stored frame

# Rounds of a single run end with a frame, unless there are more trials between frames, and hold few frames in memory.
_MOST_FRAMES_PER_ROUND = 20
_LONGEST_FRAME = 50000  # trials

_NEED_REPLICAS = ("workers", "scheduler", "trajectories")


class ReplicaChoice(NamedTuple):
    """The options of replicas and checkpoints that the user chose.

    isSingle : bool, whether this is a single run, which is the run of one replica with the seed of the run
    temperatures : list of float, K, to exchange, or None
    replicas, workers : int
    trialsPerRound : int, or None for that of a single run
    filesByTemperature : bool, whether each temperature has a trajectory, instead of each replica
    checkpointInterval : float, s
    scheduler : str, the address of a Dask scheduler whose workers run replicas, or None
    format : str, of trajectories
    """

    isSingle: bool
    temperatures: list[float] | None
    replicas: int
    workers: int
    trialsPerRound: int | None
    filesByTemperature: bool
    checkpointInterval: float
    scheduler: str | None
    format: str


def addCheckpointOptions(parser):
    """Add the options of checkpoints, and of resumed runs, to a parser."""
    parser.add_argument(
        "--checkpoint-interval",
        type=numberIn(0, 1e9),
        metavar="S",
        help=f"seconds between checkpoints (default: {_CHECKPOINT_INTERVAL:g}); 0: after each round",
    )
    parser.add_argument(
        "--resume",
        metavar="FILE",
        help="resume a run from its checkpoint, PREFIX.checkpoint, with all its settings; with --trials, extend it",
    )
    parser.add_argument(
        "--trials-per-round",
        type=positive,
        metavar="M",
        help="trials of each replica per round, without exchange; a run can be resumed only from the end of a round "
        f"(default: {_TRIALS_PER_ROUND}, or about that for a single run); longer rounds lower the load of a scheduler "
        "with many workers",
    )


def addFormat(parser):
    """Add the option for the format of trajectories."""
    parser.add_argument(
        "--format",
        choices=tuple(FORMATS),
        help=f"the format of trajectories (default: {_FORMAT}); xtc rounds coordinates to 0.001 nm and takes less room",
    )


def addReplicaOptions(parser):
    """Add the options of replicas to a parser."""
    parser.add_argument(
        "--replicas",
        type=positiveUpTo(REPLICAS),
        metavar="N",
        help="run N replicas from the same start, each with all trials and frames, and different random numbers",
    )
    parser.add_argument(
        "--temperatures",
        metavar="LOW:HIGH:N",
        help="exchange N temperatures (K) in geometric progression among N replicas, or a list of temperatures "
        "separated by commas; needs --forcefield or --system",
    )
    parser.add_argument(
        "--trials-per-exchange",
        type=positive,
        metavar="M",
        help=f"trials of each replica between exchanges (default: {_TRIALS_PER_EXCHANGE})",
    )
    parser.add_argument(
        "--workers",
        type=positive,
        metavar="W",
        help="number of replicas that run at a time (default: the number of cores)",
    )
    addScheduler(parser, "replicas")
    parser.add_argument(
        "--trajectories",
        choices=("replica", "temperature"),
        help="write a trajectory per replica or per temperature (default: temperature with exchange, else replica)",
    )


def readReplicaOptions(options):
    """Return the ReplicaChoice of the options.

    Raises
    ------
    InputError
        if an option needs another one, or contradicts it
    """
    temperatures = None
    if options.temperatures is not None:
        try:
            temperatures = readLadder(options.temperatures)
        except InputError as error:
            raise InputError(f"--temperatures {error}") from error
        if options.forcefield is None and options.system is None:
            needed = "--forcefield or --system"
            raise InputError(f"--temperatures needs {needed}: hard spheres alone have no energy to exchange by")
        if options.temperature is not None:
            raise InputError("--temperature and --temperatures cannot be used together")
        if options.trials_per_round is not None:
            raise InputError("--trials-per-round and --temperatures cannot be used together: see --trials-per-exchange")
        if options.replicas not in (None, len(temperatures)):
            raise InputError(
                f"--replicas {options.replicas}: there is one replica for each of {len(temperatures)} temperatures"
            )
    else:
        refuseWithout(options, "--temperatures", "trials_per_exchange")
        if options.trajectories == "temperature":
            raise InputError("--trajectories temperature needs --temperatures")
    isSingle = temperatures is None and options.replicas is None
    if isSingle:
        refuseWithout(options, "--replicas or --temperatures", *_NEED_REPLICAS)
    checkWorkers(options)
    workers = 1 if isSingle else options.workers or usableCores()
    interval = _CHECKPOINT_INTERVAL if options.checkpoint_interval is None else options.checkpoint_interval
    if temperatures is None:
        trialsPerRound = options.trials_per_round or (None if isSingle else _TRIALS_PER_ROUND)
    else:
        trialsPerRound = options.trials_per_exchange or _TRIALS_PER_EXCHANGE
    return ReplicaChoice(
        isSingle,
        temperatures,
        (options.replicas or 1) if temperatures is None else len(temperatures),
        workers,
        trialsPerRound,
        options.trajectories != "replica" if temperatures is not None else False,
        interval,
        options.scheduler,
        options.format or _FORMAT,
    )


def makePlan(choice, options, energyModel, seed, atoms):
    """Return the RunPlan of a ReplicaChoice for replicas with `atoms` atoms.

    Raises
    ------
    InputError
        if the frames of a round, which stay in memory until its end, need too much memory
    """
    temperatures = choice.temperatures or [300.0 if energyModel is None else energyModel.temperature]
    interval = -(-options.trials // options.frames)
    perRound = choice.trialsPerRound or _roundOfSingleRun(interval)
    framesPerRound = -(-min(perRound, options.trials) // interval)
    what = f"{framesPerRound:,} frames of each round of {perRound:,} trials"
    checkMemory(framesPerRound * _BYTES_PER_ATOM * atoms, f"--frames {options.frames}: the {what} take")
    seeds = [seed] if choice.isSingle else deriveSeeds(seed, choice.replicas)
    return RunPlan(Schedule(options.trials, perRound, interval), temperatures, seeds, seed)


def _roundOfSingleRun(interval):
    """Return the trials of a round of a single run with a number of trials between frames."""
    if interval > _LONGEST_FRAME:
        return _TRIALS_PER_ROUND
    return interval * min(max(1, _TRIALS_PER_ROUND // interval), _MOST_FRAMES_PER_ROUND)
