"""Signals while steps run: Ctrl-C reaches the caller, handlers find a complete Context, and the run continues."""

import os
import signal
from contextlib import contextmanager
from threading import Event, Thread

import numpy as np
import openmm
import pytest
import scenes
from openmmchaintree import TorsionMonteCarloIntegrator, createStericExclusionForce
from scenes import positionsOf

pytestmark = pytest.mark.skipif(os.name == "nt", reason="Windows sends no signals to a process")

ENDLESS = 2_000_000_000  # trials, which would take an hour


def makeContext(villin, integrator=None, seed=3):
    sampler = TorsionMonteCarloIntegrator(300)
    sampler.setRandomNumberSeed(seed)
    sampler.addTorsionMove(1, 0.3)
    if integrator is not None:
        integrator.addIntegrator(sampler)
    force = createStericExclusionForce(villin.topology, villin.positions)
    return scenes.makeContext(villin, force, integrator or sampler), sampler


@contextmanager
def signalsWhile(number, interval):
    """Send this process a signal again and again, first after some time."""
    over = Event()

    def send():
        while not over.wait(interval):
            os.kill(os.getpid(), number)

    thread = Thread(target=send)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


@contextmanager
def handled(number, handler):
    former = signal.signal(number, handler)
    try:
        yield
    finally:
        signal.signal(number, former)


@pytest.mark.parametrize("steps", [1, ENDLESS])
def test_interrupt(villin, steps):
    """In the midst of one long step, and of many short ones."""
    context, integrator = makeContext(villin)
    integrator.step(1)
    integrator.setTrialsPerStep(ENDLESS if steps == 1 else 100)
    begin = positionsOf(context)
    with handled(signal.SIGINT, signal.default_int_handler):
        with pytest.raises(KeyboardInterrupt), signalsWhile(signal.SIGINT, 0.2):
            integrator.step(steps)
    counts = integrator.getMoveStatistics(0)
    assert counts.accepted > 0
    assert not np.array_equal(positionsOf(context), begin)
    assert context.getStepCount() == (1 if steps == 1 else counts.attempted / 100)

    # It continues from there, like a checkpoint.

    checkpoint = context.createCheckpoint()
    integrator.setTrialsPerStep(100)
    integrator.step(2)
    fresh, sampler = makeContext(villin, seed=9)
    fresh.loadCheckpoint(checkpoint)
    sampler.step(2)
    assert np.array_equal(positionsOf(context), positionsOf(fresh))


def test_compoundIntegrator(villin):
    context, sampler = makeContext(villin, openmm.CompoundIntegrator())
    sampler.setTrialsPerStep(ENDLESS)
    with handled(signal.SIGINT, signal.default_int_handler):
        with pytest.raises(KeyboardInterrupt), signalsWhile(signal.SIGINT, 0.2):
            context.getIntegrator().step(1)
    assert context.getStepCount() == 0


def test_handlerSavesCheckpoint(villin):
    """As a batch system's warning of the end asks for it."""
    context, integrator = makeContext(villin)
    integrator.setTrialsPerStep(ENDLESS)
    saved = []

    def stop(number, frame):
        saved.append(context.createCheckpoint())
        raise SystemExit("the time is over")

    with handled(signal.SIGTERM, stop):
        with pytest.raises(SystemExit, match="the time is over"), signalsWhile(signal.SIGTERM, 0.2):
            integrator.step(1)
    fresh, sampler = makeContext(villin)
    fresh.loadCheckpoint(saved[0])
    assert np.array_equal(positionsOf(context), positionsOf(fresh))
    assert sampler.getMoveStatistics(0) == integrator.getMoveStatistics(0)


def test_handlersThatReturn(villin):
    """They see whole steps, and change nothing: neither the trajectory nor who else is told of signals."""
    quiet, sampler = makeContext(villin)
    context, integrator = makeContext(villin)
    seen = []
    ends = os.pipe()
    for end in ends:
        os.set_blocking(end, False)
    former = signal.set_wakeup_fd(ends[1])
    try:
        with handled(signal.SIGUSR1, lambda number, frame: seen.append(integrator.getMoveStatistics(0).attempted)):
            with signalsWhile(signal.SIGUSR1, 0.03):
                while len(seen) < 5:
                    integrator.step(300)
    finally:
        assert signal.set_wakeup_fd(former) == ends[1]
    told = os.read(ends[0], 1000)
    assert set(told) == {signal.SIGUSR1}
    assert len(told) >= len(seen)
    assert all(count % 100 == 0 for count in seen)
    sampler.step(context.getStepCount())
    assert np.array_equal(positionsOf(context), positionsOf(quiet))
