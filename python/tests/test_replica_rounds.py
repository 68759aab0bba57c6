"""Rounds of replicas, without a System: schedules, ladders, seeds, and exchanges of temperatures."""

import json
import math
from concurrent.futures import Future, ThreadPoolExecutor
from random import Random
from threading import Lock
from time import sleep

import numpy as np
import pytest
from openmmchaintree.errors import InputError
from openmmchaintree.replicas import ladder
from openmmchaintree.replicas.coordinator import Coordinator, RunPlan, RunState
from openmmchaintree.replicas.ladder import Exchanges, deriveSeeds, geometricLadder, readLadder
from openmmchaintree.replicas.schedule import Schedule
from openmmchaintree.replicas.segment import KeptFrame, SegmentResult
from scipy.stats import ttest_1samp

SIGNIFICANCE = 1e-3


@pytest.mark.parametrize("trials", [1, 7, 60, 100])
@pytest.mark.parametrize("perRound", [1, 4, 7, 1000])
@pytest.mark.parametrize("interval", [1, 3, 10, 60, 100])
def test_scheduleLosesNothing(trials, perRound, interval):
    schedule = Schedule(trials, perRound, interval)
    done, frames = 0, [0]
    for round in range(schedule.rounds):
        assert schedule.trialsBefore(round) == done and schedule.framesBefore(round) == len(frames) - 1
        assert 0 < sum(stop.trials for stop in schedule.stops(round)) <= perRound
        for stop in schedule.stops(round):
            assert stop.trials > 0
            done += stop.trials
            if stop.keepsFrame:
                frames.append(done)
    assert done == trials and frames == [*range(0, trials, interval), trials]
    assert frames == [schedule.trialsOfFrame(frame) for frame in range(schedule.frames + 1)]


def test_ladders():
    assert readLadder("300:450:12") == geometricLadder(300, 450, 12)
    steps = np.diff(np.log(readLadder("300:450:12")))
    assert len(steps) == 11 and steps == pytest.approx(math.log(1.5) / 11, rel=1e-12)
    assert readLadder("300:450:2") == [300, 450] and readLadder("300,310.5,400") == [300, 310.5, 400]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("300", "at least 2"),
        ("300:450", "neither LOWEST:HIGHEST:COUNT"),
        ("300:450:x", "neither"),
        ("300:450:1", "at least 2"),
        ("450:300:4", "above the first"),
        ("0:300:4", "above 0"),
        ("300:inf:4", "above the first"),
        ("300:nan:4", "above the first"),
        ("300,300", "each above the one before"),
        ("300,,400", "neither"),
        ("-5,300", "above 0"),
    ],
)
def test_noLadders(text, words):
    with pytest.raises(InputError, match=words):
        readLadder(text)


def test_seedsDiffer():
    seeds = deriveSeeds(1, 5000)
    assert len({*seeds}) == 5000 and min(seeds) >= 1 and max(seeds) < 2**31
    assert deriveSeeds(1, 10) == seeds[:10] and deriveSeeds(2, 10) != seeds[:10]


def test_pairs():
    """Each temperature meets the next one after every other round; the ends have nobody in the others."""
    exchanges = Exchanges([300, 310, 320, 330, 340], 1)
    assert [exchanges.lowerOfPair(0, k) for k in range(5)] == [0, 0, 2, 2, None]
    assert [exchanges.lowerOfPair(1, k) for k in range(5)] == [None, 1, 1, 3, 3]


def test_certainExchanges():
    """Where the hotter replica has the lower energy, they always exchange; energies that are no numbers never do."""
    exchanges = Exchanges([300, 400], 1)
    assert all(exchanges.decide(round, 0, 5, 4) for round in range(100))
    assert not any(exchanges.decide(round, 0, math.nan, 4) for round in range(100))
    assert not any(exchanges.decide(round, 0, 4, math.inf) for round in range(100))


# ---- Whole runs of replicas that are numbers ----

DIMENSIONS = 30  # of harmonic oscillators: U/kT has a gamma distribution
KEPT = 0.95  # the probability that a replica stays where it is in a round, so that exchanges matter
GAS_CONSTANT = 8.31446261815324e-3
TEMPERATURES = readLadder("300:450:5")
NONE, ONE_STAGE = np.zeros(3, dtype=int), np.array([[2, 1]])


def runOscillators(segment):
    """Run a Segment of a replica whose state, and checkpoint, is its energy."""
    random = Random(10007 * segment.seed + segment.round)
    energy = segment.checkpoint
    if energy is None or random.random() > KEPT:
        energy = random.gammavariate(DIMENSIONS / 2, GAS_CONSTANT * segment.temperature)
    counts = np.array([[sum(stop.trials for stop in segment.stops), 0, 0, 0]])
    before = np.array([[10 * segment.round, 0, 0, 0]])
    frames = [KeptFrame(np.array([energy]), energy, before + counts) for stop in segment.stops if stop.keepsFrame]
    return SegmentResult(segment.replica, segment.round, energy, energy, frames, counts, NONE, ONE_STAGE, 1, 1)


def submitHere(segment):
    future = Future()
    future.set_result(runOscillators(segment))
    return future


def run(rounds, submit=submitHere, slots=5, holds=()):
    """Return the replica and the energy of each frame and temperature, and the RunState.

    holds : the number of segments after which all replicas reach the same round, where the run continues
    """
    plan = RunPlan(Schedule(10 * rounds, 10, 10), TEMPERATURES, deriveSeeds(1, len(TEMPERATURES)), 1)
    state, frames, holds = RunState(plan, 1), {}, list(holds)

    def add(frame, replica, temperature, kept):
        assert (frame, temperature) not in frames
        frames[frame, temperature] = replica, kept.energy

    while state.round < rounds:
        left = holds.pop(0) if holds else math.inf

        def shouldHold():
            nonlocal left
            left -= 1
            return left <= 0

        Coordinator(plan, state, add).run(submit, slots, shouldHold)
        begun, state = state, RunState(plan, 1)
        state.restore(json.loads(json.dumps(begun.asPlain())), begun.checkpoints)  # as in another process
    assert len(frames) == rounds * len(TEMPERATURES)
    return frames, state


def withoutTimes(state):
    return {name: value for name, value in state.asPlain().items() if "econds" not in name}


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_whoeverComesFirst(workers):
    """Workers of any speed, and pauses at any time, change nothing."""
    expected, expectedState = run(200)
    delays = np.random.default_rng(workers)

    def slowly(segment):
        sleep(delays.exponential(1e-4))
        return runOscillators(segment)

    with ThreadPoolExecutor(workers) as pool:
        submit = lambda segment: pool.submit(slowly, segment)  # noqa: E731
        frames, state = run(200, submit, slots=2 * workers, holds=[1, 37, 250])
    assert frames == expected
    assert withoutTimes(state) == withoutTimes(expectedState)


def test_noMoreSegmentsThanSlots():
    running, most = 0, 0
    lock = Lock()

    def counted(segment):
        nonlocal running, most
        with lock:
            running += 1
            most = max(most, running)
        sleep(1e-3)
        with lock:
            running -= 1
        return runOscillators(segment)

    with ThreadPoolExecutor(8) as pool:
        run(20, lambda segment: pool.submit(counted, segment), slots=3)
    assert 1 < most <= 3


def test_anErrorEndsTheRun():
    def fail(segment):
        if segment.round == 3 and segment.replica == 2:
            raise RuntimeError("no more")
        return runOscillators(segment)

    with ThreadPoolExecutor(2) as pool, pytest.raises(RuntimeError, match="no more"):
        run(20, lambda segment: pool.submit(fail, segment))


def test_countsAddUp():
    frames, state = run(101)
    assert state.counts[:, 0, 0].tolist() == [1010] * 5 and state.countsOfReplica[:, 0, 0].tolist() == [1010] * 5
    assert state.attempted.tolist() == [51, 50, 51, 50]
    for frame in range(1, 102):
        assert sorted(frames[frame, k][0] for k in range(5)) == list(range(5))
    places = np.array([[frames[frame, k][0] for k in range(5)] for frame in range(1, 102)])
    changes = [int((places[1:, k] != places[:-1, k]).sum()) for k in range(5)]
    assert changes[0] in (state.accepted[0], state.accepted[0] - 1)  # the last exchange is in no frame
    assert [sorted(state.temperatureOf)] == [list(range(5))]
    # Round trips, recounted from the frames.
    trips = [0] * 5
    ends = {places[0, 0]: False}
    for row in np.vstack([places, np.argsort(state.temperatureOf)]):
        trips[row[0]] += ends.get(row[0]) is True
        ends[row[0]] = False
        if ends.get(row[-1]) is False:
            ends[row[-1]] = True
    assert trips == state.roundTrips and sum(trips) > 3


def pValues(rounds=5000, block=100):
    """Return p-values of the means of the energy and of its square, at each temperature, by means of blocks."""
    frames, state = run(rounds)
    assert state.accepted.min() > 0.1 * rounds / 2
    energies = np.array([[frames[frame, k][1] for k in range(len(TEMPERATURES))] for frame in range(1, rounds + 1)])
    reduced = energies[block:] / (GAS_CONSTANT * np.array(TEMPERATURES))
    blocks = [(reduced**power).reshape(-1, block, len(TEMPERATURES)).mean(axis=1) for power in (1, 2)]
    shape = DIMENSIONS / 2
    return np.array([ttest_1samp(blocks[0], shape).pvalue, ttest_1samp(blocks[1], shape * (shape + 1)).pvalue])


def test_exchangesKeepTheDistributions():
    assert pValues().min() > SIGNIFICANCE / (2 * len(TEMPERATURES))


@pytest.mark.parametrize("factor", [-1, 2])
def test_aWrongExponentIsNoticed(monkeypatch, factor):
    honest = ladder.logExchangeRatio
    monkeypatch.setattr(ladder, "logExchangeRatio", lambda *values: factor * honest(*values))
    assert pValues().min() < SIGNIFICANCE / (2 * len(TEMPERATURES)) / 100
