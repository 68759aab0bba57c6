"""Runs the rounds of all replicas: submits segments, decides exchanges, passes on frames."""

import heapq
from queue import SimpleQueue
from typing import NamedTuple

import numpy as np

from .ladder import Exchanges
from .schedule import Schedule
from .segment import Segment

# Twice the points of a curve.
_LONGEST_HISTORY = 80


class RunPlan(NamedTuple):
    """The definition of a run, apart from the Model.

    schedule : Schedule
    temperatures : list of float, K, in increasing order; one for all replicas, or one per replica, to be exchanged
    seeds : list of int, one per replica
    exchangeSeed : int, for the random numbers of exchanges
    """

    schedule: Schedule
    temperatures: list[float]
    seeds: list[int]
    exchangeSeed: int

    @property
    def isExchange(self):
        """Whether replicas exchange temperatures."""
        return len(self.temperatures) > 1


class RunState:
    """The states of all replicas between two rounds, and all counts.

    Attributes
    ----------
    round : int
        the next round
    checkpoints : list of bytes
        of each replica, None before the first round
    temperatureOf : list of int
        the index of each replica's temperature
    wasHotLast : list of bool or None
        for each replica, whether it has been at the highest temperature since its last time at the lowest; None before
    roundTrips : list of int
        the number of times each replica went from the lowest temperature to the highest and back
    attempted, accepted : (temperatures - 1,) int arrays
        exchanges between neighbouring temperatures
    counts : (temperatures, moves, 4) int array
        outcomes of the trials of each move, as in MoveStatistics
    countsOfReplica : (replicas, moves, 4) int array
    outerTests : (temperatures, 3) int array
        outer tests attempted and accepted, and trials undone
    stages : list
        for each stage: trials that it has decided, and refused
    history : list
        for some frames at equal distances: the frame, and a list of [attempted, accepted] of each move before it, over
        all replicas
    seconds, secondsInSteps, wallSeconds : float
        total time of segments; their time in integrators; elapsed time, set by the caller
    """

    def __init__(self, plan, moves):
        """Begin a RunPlan with a number of moves."""
        replicas, temperatures = len(plan.seeds), len(plan.temperatures)
        self.round = 0
        self.checkpoints = [None] * replicas
        self.temperatureOf = list(range(replicas)) if plan.isExchange else [0] * replicas
        self.wasHotLast = [None] * replicas
        if plan.isExchange:
            self.wasHotLast[0] = False
        self.roundTrips = [0] * replicas
        self.attempted = np.zeros(temperatures - 1, dtype=np.int64)
        self.accepted = np.zeros(temperatures - 1, dtype=np.int64)
        self.counts = np.zeros((temperatures, moves, 4), dtype=np.int64)
        self.countsOfReplica = np.zeros((replicas, moves, 4), dtype=np.int64)
        self.outerTests = np.zeros((temperatures, 3), dtype=np.int64)
        self.stages = []
        self.history = []
        self.seconds = 0.0
        self.secondsInSteps = 0.0
        self.wallSeconds = 0.0

    def asPlain(self):
        """Return everything except the checkpoints as a dictionary of plain numbers and lists."""
        plain = {name: value for name, value in vars(self).items() if name != "checkpoints"}
        return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in plain.items()}

    def restore(self, plain, checkpoints):
        """Restore the result of `asPlain`, and the checkpoints."""
        for name, value in plain.items():
            isArray = isinstance(getattr(self, name), np.ndarray)
            setattr(
                self, name, np.array(value, dtype=np.int64).reshape(getattr(self, name).shape) if isArray else value
            )
        self.checkpoints = list(checkpoints)

    def noteCounts(self, frame, counts):
        """Add the counts before a frame, of shape (moves, 4), to the history, and thin it if it becomes long."""
        distance = self.history[0][0] if self.history else 1
        if frame % distance == 0:
            self.history.append([frame, counts[:, [0, 3]].tolist()])
        if len(self.history) > _LONGEST_HISTORY:
            self.history = self.history[1::2]


class Coordinator:
    """Runs a RunPlan from a RunState.

    Replicas exchange temperatures after each round. An exchange waits only for its two replicas, so replicas can be
    several rounds apart. The RunState is the state after the last round that all replicas have completed; later results
    are counted later. `run` returns when no replica is ahead, unless it is stopped.

    trials : int, trials made by all replicas
    """

    def __init__(self, plan, state, addFrame):
        """Take a RunPlan, the RunState to advance, and a function that receives frames.

        Its arguments are the numbers of the frame, the replica and its temperature, and a KeptFrame. For each replica,
        and for each temperature, frames come in order.
        """
        self._plan = plan
        self._state = state
        self._addFrame = addFrame
        self._temperatureOf = list(state.temperatureOf)
        self._checkpoints = list(state.checkpoints)
        # Of rounds that some replicas have not completed, by round.
        self._results = {}  # by replica: the result, and the index of its temperature
        self._ends = {}  # by replica: the temperature after the exchange
        self._decided = {}  # the lower temperature of each attempted exchange, and whether it was accepted
        self._finished = SimpleQueue()
        self.trials = plan.schedule.trialsBefore(state.round) * len(plan.seeds)
        self._exchanges = Exchanges(plan.temperatures, plan.exchangeSeed) if plan.isExchange else None

    def run(self, submit, slots, shouldHold, until=None):
        """Run all remaining rounds; once shouldHold() returns true, begin no further round.

        Parameters
        ----------
        submit : function
            takes a Segment; returns a future of its SegmentResult, with `result` and `add_done_callback`
        slots : int
            the number of segments submitted at a time
        shouldHold : function
            called after each segment
        until : int, optional
            the round before which to return
        """
        state = self._state
        hold = min(self._plan.schedule.rounds, self._plan.schedule.rounds if until is None else until)
        ready = [
            (state.round, replica) for replica in range(len(self._plan.seeds))
        ]  # a heap: replicas in earlier rounds come first
        latest = state.round
        waiting = {}  # by (round, lower temperature): the replica that waits for its partner, and its energy
        running = 0
        while True:
            while ready and ready[0][0] < hold and running < slots:
                round, replica = heapq.heappop(ready)
                latest = max(latest, round)
                submit(self._segment(round, replica)).add_done_callback(self._finished.put)
                running += 1
            if running == 0:
                break
            future = self._finished.get()
            if future is None:
                return
            result = future.result()
            running -= 1
            self._take(result)
            for replica in self._exchange(result, waiting):
                heapq.heappush(ready, (result.round + 1, replica))
            if shouldHold():
                hold = min(hold, latest + 1)

    def stop(self):
        """Make `run` return without waiting for running segments; a signal handler may call this."""
        self._finished.put(None)

    def _segment(self, round, replica):
        temperature = self._plan.temperatures[self._temperatureOf[replica]]
        stops = self._plan.schedule.stops(round)
        return Segment(replica, round, self._plan.seeds[replica], temperature, self._checkpoints[replica], stops)

    def _take(self, result):
        """Store the result of a replica, and pass on its frames."""
        temperature = self._temperatureOf[result.replica]
        self._checkpoints[result.replica] = result.checkpoint
        kept = result._replace(frames=[frame.counts for frame in result.frames])
        self._results.setdefault(result.round, {})[result.replica] = kept, temperature
        schedule = self._plan.schedule
        self.trials += schedule.trialsBefore(result.round + 1) - schedule.trialsBefore(result.round)
        first = schedule.framesBefore(result.round) + 1
        for frame, kept in enumerate(result.frames, first):
            self._addFrame(frame, result.replica, temperature, kept)

    def _exchange(self, result, waiting):
        """Attempt the exchange of a replica after a round; return the replicas that can begin the next one."""
        round, temperatureOf = result.round, self._temperatureOf
        lower = None
        if self._exchanges is not None:
            lower = self._exchanges.lowerOfPair(round, temperatureOf[result.replica])
        pair = [(result.replica, result.energy)]
        if lower is not None:
            if (round, lower) not in waiting:
                waiting[round, lower] = pair[0]
                return []
            pair.append(waiting.pop((round, lower)))
            pair.sort(key=lambda entry: temperatureOf[entry[0]])
            (cold, coldEnergy), (hot, hotEnergy) = pair
            isAccepted = self._exchanges.decide(round, lower, coldEnergy, hotEnergy)
            self._decided.setdefault(round, []).append((lower, isAccepted))
            if isAccepted:
                temperatureOf[cold], temperatureOf[hot] = lower + 1, lower
        ends = self._ends.setdefault(round, {})
        for replica, _ in pair:
            ends[replica] = temperatureOf[replica]
        if len(ends) == len(temperatureOf):
            self._count(round)
        return [replica for replica, _ in pair]

    def _count(self, round):
        """Add a round that all replicas have completed to the RunState."""
        state = self._state
        results = self._results.pop(round)
        for replica, (result, temperature) in results.items():
            state.checkpoints[replica] = result.checkpoint
            state.counts[temperature] += result.counts
            state.countsOfReplica[replica] += result.counts
            state.outerTests[temperature] += result.outerTests
            state.stages = (result.stages + (state.stages or 0)).tolist()
            state.seconds += result.seconds
            state.secondsInSteps += result.secondsInSteps
        countsOfFrames = zip(*(result.frames for result, _ in results.values()), strict=True)
        for frame, counts in enumerate(countsOfFrames, self._plan.schedule.framesBefore(round) + 1):
            state.noteCounts(frame, sum(counts))
        for lower, isAccepted in self._decided.pop(round, ()):
            state.attempted[lower] += 1
            state.accepted[lower] += isAccepted
        for replica, temperature in self._ends.pop(round).items():
            state.temperatureOf[replica] = temperature
            if self._exchanges is not None:
                self._noteEnds(replica)
        state.round = round + 1

    def _noteEnds(self, replica):
        """Count a round trip if one is complete."""
        state, temperature = self._state, self._state.temperatureOf[replica]
        if temperature == 0:
            state.roundTrips[replica] += state.wasHotLast[replica] is True
            state.wasHotLast[replica] = False
        elif temperature == len(self._plan.temperatures) - 1 and state.wasHotLast[replica] is False:
            state.wasHotLast[replica] = True
