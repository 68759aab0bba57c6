"""Runs the rounds of all replicas: hands out segments, decides exchanges, hands on frames."""

import heapq
from queue import SimpleQueue
from typing import NamedTuple

import numpy as np

from .ladder import Exchanges
from .schedule import Schedule
from .segment import Segment


class RunPlan(NamedTuple):
    """What a run is made of, but for the Model.

    schedule : Schedule
    temperatures : list of float, K, from low to high; one for all replicas, or one for each, which they exchange
    seeds : list of int, one for each replica
    exchangeSeed : int, of what decides exchanges
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
    """Where all replicas are between two rounds, and what has been counted so far.

    Attributes
    ----------
    round : int
        the round that begins
    checkpoints : list of bytes
        of each replica, None before the first round
    temperatureOf : list of int
        which temperature each replica has
    wasHotLast : list of bool or None
        for each replica, whether it was at the highest temperature since it was last at the lowest; None before it was
    roundTrips : list of int
        how often each replica went from the lowest temperature to the highest and back
    attempted, accepted : (temperatures - 1,) int arrays
        exchanges between each temperature and the next
    counts : (temperatures, moves, 4) int array
        what became of the trials of each move, as in MoveStatistics
    countsOfReplica : (replicas, moves, 4) int array
    outerTests : (temperatures, 3) int array
        outer tests attempted and accepted, and trials taken back
    seconds, secondsInSteps, wallSeconds : float
        that segments took together, and integrators of it; that passed meanwhile, as whoever runs it says
    """

    def __init__(self, plan, moves):
        """Begin a RunPlan with so many moves."""
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
        self.seconds = 0.0
        self.secondsInSteps = 0.0
        self.wallSeconds = 0.0

    def asPlain(self):
        """Return all but the checkpoints as a dictionary of plain numbers and lists."""
        plain = {name: value for name, value in vars(self).items() if name != "checkpoints"}
        return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in plain.items()}

    def restore(self, plain, checkpoints):
        """Take over what `asPlain` returned, and the checkpoints."""
        for name, value in plain.items():
            isArray = isinstance(getattr(self, name), np.ndarray)
            setattr(
                self, name, np.array(value, dtype=np.int64).reshape(getattr(self, name).shape) if isArray else value
            )
        self.checkpoints = list(checkpoints)


class Coordinator:
    """Runs a RunPlan from a RunState on.

    Replicas exchange temperatures after each round. An exchange waits for its two replicas alone, so replicas can be
    some rounds apart. The RunState is always where all have come to the same round: what some have done beyond counts
    later. `run` returns where none has, unless it is stopped.

    trials : int, of all replicas so far
    """

    def __init__(self, plan, state, addFrame):
        """Take a RunPlan, the RunState that changes from now on, and a function that takes frames.

        It is called with the number of the frame, the replica, its temperature's number and a KeptFrame; for each file
        by replica or temperature in the order of frames.
        """
        self._plan = plan
        self._state = state
        self._addFrame = addFrame
        self._temperatureOf = list(state.temperatureOf)
        self._checkpoints = list(state.checkpoints)
        # Of rounds that not all replicas have ended, by round.
        self._results = {}  # by replica: the result, and the temperature that it had
        self._ends = {}  # by replica: the temperature after the exchange
        self._decided = {}  # the lower temperatures of exchanges that were tried, and whether they took place
        self._finished = SimpleQueue()
        self.trials = plan.schedule.trialsBefore(state.round) * len(plan.seeds)
        self._exchanges = Exchanges(plan.temperatures, plan.exchangeSeed) if plan.isExchange else None

    def run(self, submit, slots, shouldHold):
        """Run all rounds that are left, or, once shouldHold() says so, no more than have begun.

        Parameters
        ----------
        submit : function
            takes a Segment, returns a future of its SegmentResult, with `result` and `add_done_callback`
        slots : int
            so many segments are handed out at a time
        shouldHold : function
            asked after each segment
        """
        state = self._state
        hold = self._plan.schedule.rounds
        ready = [
            (state.round, replica) for replica in range(len(self._plan.seeds))
        ]  # a heap: who is behind comes first
        latest = state.round
        waiting = {}  # the replica and its energy that wait for the other one of their pair after a round
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
        """Have `run` return without what replicas do now; a handler of signals may call it."""
        self._finished.put(None)

    def _segment(self, round, replica):
        temperature = self._plan.temperatures[self._temperatureOf[replica]]
        stops = self._plan.schedule.stops(round)
        return Segment(replica, round, self._plan.seeds[replica], temperature, self._checkpoints[replica], stops)

    def _take(self, result):
        """Keep what a replica has done, and hand on its frames."""
        temperature = self._temperatureOf[result.replica]
        self._checkpoints[result.replica] = result.checkpoint
        self._results.setdefault(result.round, {})[result.replica] = result._replace(frames=()), temperature
        schedule = self._plan.schedule
        self.trials += schedule.trialsBefore(result.round + 1) - schedule.trialsBefore(result.round)
        first = schedule.framesBefore(result.round) + 1
        for frame, kept in enumerate(result.frames, first):
            self._addFrame(frame, result.replica, temperature, kept)

    def _exchange(self, result, waiting):
        """Try the exchange of a replica that has ended a round; return the replicas that can go on."""
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
        """Take a round that all have ended over to the RunState."""
        state = self._state
        for replica, (result, temperature) in self._results.pop(round).items():
            state.checkpoints[replica] = result.checkpoint
            state.counts[temperature] += result.counts
            state.countsOfReplica[replica] += result.counts
            state.outerTests[temperature] += result.outerTests
            state.seconds += result.seconds
            state.secondsInSteps += result.secondsInSteps
        for lower, isAccepted in self._decided.pop(round, ()):
            state.attempted[lower] += 1
            state.accepted[lower] += isAccepted
        for replica, temperature in self._ends.pop(round).items():
            state.temperatureOf[replica] = temperature
            if self._exchanges is not None:
                self._noteEnds(replica)
        state.round = round + 1

    def _noteEnds(self, replica):
        """Count a round trip where one ends."""
        state, temperature = self._state, self._state.temperatureOf[replica]
        if temperature == 0:
            state.roundTrips[replica] += state.wasHotLast[replica] is True
            state.wasHotLast[replica] = False
        elif temperature == len(self._plan.temperatures) - 1 and state.wasHotLast[replica] is False:
            state.wasHotLast[replica] = True
