"""OpenMM's replica exchange, with replicas in parallel."""

import copy
import math
from concurrent.futures import ThreadPoolExecutor
from threading import Lock
from typing import Any

import numpy as np
import openmm
from openmm import app, unit

from .openmmchaintree import StericExclusionForce, TorsionMonteCarloIntegrator

# OpenMM's conversions between numbers and text, which States of integrators need, share memory among all threads.
_serializing = Lock()

_Base: Any = getattr(app, "ReplicaExchangeSampler", object)


class ParallelReplicaExchangeSampler(_Base):
    """A ReplicaExchangeSampler of OpenMM (8.6 or newer) that runs replicas in parallel, in threads.

    It has the arguments and methods of that class, and works with its ReplicaExchangeReporter. Each replica has its own
    Context, which it keeps from one iteration to the next, and its own random numbers, so that its trajectory depends
    neither on other replicas nor on the number of workers. Exchanges are drawn by Python's `random`, as in the base
    class: seed that to make a run reproducible.

        states = [{"temperature": t * unit.kelvin} for t in np.geomspace(300.0, 450.0, 12)]
        sampler = ParallelReplicaExchangeSampler(states, simulation, stepsPerIteration=10, workers=4)
        sampler.reporters.append(app.ReplicaExchangeReporter("exchange", 1, sampler, trajectoryPerState=True))
        sampler.simulate(1000)

    Any integrator can be used that releases Python's lock in its steps, as all integrators of OpenMM do. On a GPU
    platform all Contexts share the device, and little time is gained. On the Reference platform OpenMM's integrators
    share one sequence of random numbers among all Contexts of a process: there trajectories depend on the order in
    which threads run.

    Parameters
    ----------
    states : list of dict
        the states to sample, as in ReplicaExchangeSampler
    simulation : openmm.app.Simulation
        the System, Integrator and Platform of the replicas, and their starting positions
    stepsPerIteration : int
        as in ReplicaExchangeSampler
    reinitializeVelocities : bool
        as in ReplicaExchangeSampler
    workers : int, optional
        the number of replicas that run at the same time; default: all
    seed : int, optional
        the seed of the replicas' random numbers; default: the seed of the simulation's integrator, or a new one

    Raises
    ------
    RuntimeError
        if OpenMM is older than 8.6, which has no ReplicaExchangeSampler
    """

    def __init__(
        self,
        states: list[dict],
        simulation: app.Simulation,
        stepsPerIteration: int,
        reinitializeVelocities: bool = False,
        workers: int | None = None,
        seed: int | None = None,
    ) -> None:
        if _Base is object:
            version = openmm.Platform.getOpenMMVersion()
            raise RuntimeError(
                f"ParallelReplicaExchangeSampler needs OpenMM 8.6 or newer, and this is OpenMM {version}"
            )
        if workers is not None and workers < 1:
            raise ValueError(f"workers must be at least 1, and is {workers}")
        super().__init__(states, simulation, stepsPerIteration, reinitializeVelocities)
        self.workers = workers or len(states)
        self._start = self.replicaConformation[0]
        random = np.random.default_rng(seed or _seedOf(simulation.integrator))
        seeds = random.choice(2**31 - 1, len(states), replace=False) + 1
        self._replicas = [_Replica(states, simulation, self._start, int(number)) for number in seeds]

    def simulate(self, iterations: int) -> None:
        """Run a number of iterations, as in ReplicaExchangeSampler."""
        with ThreadPoolExecutor(self.workers) as pool:
            for _ in range(iterations):
                self.replicaStateEnergy = None
                energies = [] * unit.kilojoules_per_mole
                for row in pool.map(self._simulateAndLook, range(len(self.states))):
                    energies.append(row)
                self.replicaStateEnergy = energies
                self.currentIteration += 1
                context = self._replicas[-1].context
                self.simulation.context.setStepCount(context.getStepCount())
                self.simulation.context.setTime(context.getTime())
                for reporter in self.reporters:
                    reporter(self)
                self.exchangeReplicas()

    def simulateReplica(self, index: int, steps: int | None = None) -> None:
        """Simulate one replica, as in ReplicaExchangeSampler."""
        replica, state = self._replicas[index], self.replicaStateIndex[index]
        previous = self._previousReplicaStateIndex[index]
        conformation = self.replicaConformation[index]
        replica.takeUp(conformation)
        if previous != state and replica.hasVelocities:
            self._changeVelocities(replica.context, conformation, previous, state)
        self._previousReplicaStateIndex[index] = state
        replica.sampler.applyState(state)
        replica.context.getIntegrator().step(self.stepsPerIteration if steps is None else steps)
        self.replicaConformation[index] = replica.look()

    def _simulateAndLook(self, index):
        self.simulateReplica(index)
        return self._replicas[index].energies()

    def _changeVelocities(self, context, conformation, previous, state):
        """Draw new velocities of a replica, or scale them, for its new state."""
        if self.reinitializeVelocities:
            temperature = self.states[state].get("temperature", None)
            context.setVelocitiesToTemperature(
                self.simulation.integrator.getTemperature() if temperature is None else temperature
            )
        elif self._kT is not None:
            scale = math.sqrt(self._kT[state] / self._kT[previous])
            context.setVelocities(conformation.getVelocities(asNumpy=True) * scale)


class _Replica:
    """A replica, with its own Context.

    context : openmm.Context; sampler : OpenMM's MultistateSampler, which knows the states; hasVelocities : bool
    """

    def __init__(self, states, simulation, start, seed):
        """Start at a State, with random numbers of another seed."""
        from openmm.app.internal.multistatesampler import MultistateSampler

        integrator = copy.copy(simulation.integrator)
        if hasattr(integrator, "setRandomNumberSeed"):
            integrator.setRandomNumberSeed(seed)
        platform = simulation.context.getPlatform()
        properties = {name: platform.getPropertyValue(simulation.context, name) for name in platform.getPropertyNames()}
        self.context = openmm.Context(simulation.system, integrator, platform, properties)
        # Do not use setState, which would give all replicas the random numbers of the State.
        if simulation.system.usesPeriodicBoundaryConditions():
            self.context.setPeriodicBoxVectors(*start.getPeriodicBoxVectors())
        self.context.setPositions(start.getPositions(asNumpy=True))
        self.context.setVelocities(start.getVelocities(asNumpy=True))
        for name, value in start.getParameters().items():
            self.context.setParameter(name, value)
        self.context.setTime(start.getTime())
        self.context.setStepCount(start.getStepCount())
        self.sampler = MultistateSampler(states, self.context)
        self._states = states
        self._ours = integrator if isinstance(integrator, TorsionMonteCarloIntegrator) else None
        self.hasVelocities = self._ours is None
        self._stericGroup = None if self._ours is None else _stericGroup(simulation.system, self._ours, states)
        self._conformation = start

    def takeUp(self, conformation):
        """Go to a State, unless this replica is there already."""
        if conformation is not self._conformation:
            with _serializing:
                self.context.setState(conformation)

    def look(self):
        """Return the State."""
        with _serializing:
            self._conformation = self.context.getState(
                positions=True, velocities=True, parameters=True, integratorParameters=True
            )
        return self._conformation

    def energies(self):
        """Return the energies in all states, without the energy of hard spheres, which trials ignore."""
        if self._ours is None:
            return self.sampler.computeAllEnergies()
        if _differInTemperature(self._states):
            energy = self._ours.getPotentialEnergy(self.context)
            return [energy] * len(self._states) * unit.kilojoules_per_mole
        energies = self.sampler.computeAllEnergies()
        if self._stericGroup is None:
            return energies
        steric = self.context.getState(energy=True, groups={self._stericGroup}).getPotentialEnergy()
        kilojoules = unit.kilojoules_per_mole
        return [(energy - steric).value_in_unit(kilojoules) for energy in energies] * kilojoules


def _differInTemperature(states):
    """Whether the states differ in their temperatures alone."""
    return {*states[0]} == {"temperature"}


def _stericGroup(system, integrator, states):
    """Return the force group of hard spheres if their energy must be subtracted from energies of states, else None."""
    hasNoLimits = integrator.getStericMode() == integrator.Soft or integrator.hasSpheresOff()
    if hasNoLimits or _differInTemperature(states) or "groups" in states[0]:
        return None
    forces = list(system.getForces())
    (steric,) = [force for force in forces if StericExclusionForce.isinstance(force)]
    group = steric.getForceGroup()
    if [force.getForceGroup() for force in forces].count(group) > 1:
        raise ValueError(
            f"force group {group}: where states have parameters, StericExclusionForce needs a separate one"
        )
    return group


def _seedOf(integrator):
    """Return the seed of an integrator, or None for a new one."""
    return (hasattr(integrator, "getRandomNumberSeed") and integrator.getRandomNumberSeed()) or None
