"""The files that grow during a run: trajectories, and an index of their frames."""

from contextlib import ExitStack

from .indexfile import IndexFile, IndexRow, checkIndex
from .trajectories import FORMATS


def trajectoryNames(prefix, replicas, temperatures, byTemperature, form="dcd"):
    """Return the names of the trajectories of `replicas` replicas, or of temperatures (K), in a format."""
    if not byTemperature:
        width = len(str(replicas - 1))
        return [f"{prefix}-replica-{replica:0{width}}.{form}" for replica in range(replicas)]
    for digits in range(10):
        names = [f"{temperature:.{digits}f}" for temperature in temperatures]
        isExact = all(float(name) == temperature for name, temperature in zip(names, temperatures, strict=True))
        if isExact or digits >= 1 and len({*names}) == len(names):
            break
    return [f"{prefix}-{name}K.{form}" for name in names]


class ReplicaFiles:
    """The trajectories and the index of a run; a context manager that closes them.

    Attributes
    ----------
    trajectories : list of TrajectoryFile
    index : IndexFile
    """

    def __init__(self, outputs, plan, choice, start, round=0, indexMark=None):
        """Begin all files with the start, or resume them at the beginning of a round. On failure, remove new files.

        Parameters
        ----------
        outputs : dict
            "index": an Output; "trajectories": a list of them
        plan : RunPlan
        choice : ReplicaChoice
        start : Sampling
            at its start
        round : int
        indexMark : (int, int) or None
            the mark of the index when that round began; None for a new run
        """
        self._plan = plan
        self._byTemperature = choice.filesByTemperature
        self._start = start
        self._rows = {}
        self.trajectories = []
        self.index = None
        isNew = indexMark is None
        topology, positions, schedule = start.structure.topology, start.structure.positions, plan.schedule
        frames = 0 if isNew else 1 + schedule.framesBefore(round)
        self._nextFrame = max(1, frames)
        begin = [self._row(0, *place, positions, start.startEnergy) for place in self._startPlaces()]
        if not isNew:
            checkIndex(outputs["index"], choice.isSingle, begin[0], indexMark, frames * len(plan.seeds))
        try:
            for output in outputs["trajectories"]:
                place = schedule.interval, 1 + schedule.frames, frames
                self.trajectories.append(FORMATS[choice.format](output, topology, positions, *place))
            self.index = IndexFile(outputs["index"], choice.isSingle, begin[0], indexMark)
            if isNew:
                self.index.write(begin)
        except BaseException:
            self.close()
            if isNew:
                self.remove()
            raise

    def remove(self):
        """Remove the files, after they were closed."""
        for file in (*self.trajectories, self.index):
            if file is not None:
                file.remove()

    def add(self, frame, replica, temperature, kept):
        """Add a KeptFrame of a replica, which has the temperature of this number."""
        self.trajectories[temperature if self._byTemperature else replica].write(kept.positions)
        attempted, _, _, accepted = kept.counts.sum(axis=0).tolist()
        row = self._row(frame, replica, temperature, kept.positions, kept.energy, attempted, accepted)
        self._rows.setdefault(frame, {})[replica] = row
        while len(self._rows.get(self._nextFrame, ())) == len(self._plan.seeds):
            rows = self._rows.pop(self._nextFrame)
            self.index.write([rows[replica] for replica in sorted(rows)])
            self._nextFrame += 1

    def shorten(self, round):
        """Remove the frames of a round and of later ones; nothing can be added afterwards."""
        for trajectory in self.trajectories:
            trajectory.shorten(1 + self._plan.schedule.framesBefore(round))

    def sync(self):
        """Wait until all written data is on disk."""
        for file in (*self.trajectories, self.index):
            file.sync()

    def close(self):
        """Close all files."""
        with ExitStack() as stack:
            for file in (*self.trajectories, self.index):
                if file is not None:
                    stack.callback(file.close)

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()

    def _startPlaces(self):
        count = len(self._plan.seeds)
        return [(replica, replica if self._plan.isExchange else 0) for replica in range(count)]

    def _row(self, frame, replica, temperature, positions, energy, attempted=0, accepted=0):
        kelvin = None if energy is None else self._plan.temperatures[temperature]
        trials, shape = self._plan.schedule.trialsOfFrame(frame), self._start.shape.measure(positions)
        return IndexRow(frame, trials, replica, kelvin, energy, shape, attempted, accepted)
