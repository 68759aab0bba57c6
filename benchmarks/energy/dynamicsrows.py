"""What is measured beside dynamics: one protein by trials and by Langevin dynamics, for the same processor time."""

import time
from typing import NamedTuple

import mdtraj
import numpy as np
import openmm
from openmm import app, unit
from racing.course import Course
from racing.races import OURS

from .proteins import (
    IMPLICIT_SOLVENT,
    SIDE_CHAINS,
    TEMPERATURE,
    TRIALS_PER_OUTER_TEST,
    SampledProtein,
    choosePlatform,
    positionsOf,
)

GROUP = "dynamics"  # of rows
LANGEVIN = "Langevin dynamics"  # the contestant

TIMESTEP = 0.004  # ps, with heavier hydrogens
_HYDROGEN_MASS = 1.5 * unit.amu
_FRICTION = 1 / unit.picosecond
_STIFF = 7  # the force group of bonds and angles
_STIFF_FORCES = (openmm.HarmonicBondForce, openmm.HarmonicAngleForce)
_ANOTHER_ROTAMER = np.pi / 3  # how far from where it began


class Pair:
    """A protein after a minimization, and two runs that begin there: ours and Langevin dynamics."""

    def __init__(self, read, iterations):
        """Take a function that returns the SampledProtein, and the most iterations of the minimization."""
        self._read = read
        self._iterations = iterations
        self.runs = {}

    def begin(self, seed):
        """Minimize and make both runs."""
        protein = self._read()
        dynamics = _makeDynamics(protein, seed)
        dynamics.minimizeEnergy(maxIterations=self._iterations)
        protein = SampledProtein(protein.name, protein.topology, positionsOf(dynamics.context))
        observer = _Observer(protein)
        self.protein = protein
        self.runs = {OURS: _Trials(protein, seed, observer), LANGEVIN: _Dynamics(dynamics, seed, observer)}


class TurnRow(NamedTuple):
    """A turn of both runs; the first of all is their start.

    turn : int; turns : int, of how many; seconds : float, processor time of a turn
    """

    name: str
    pair: Pair
    turn: int
    turns: int
    seconds: float
    group: str = GROUP
    mostChains: int = 1

    def __str__(self) -> str:
        return f"{self.name}, turn {self.turn}"

    def run(self, course: Course, seed: int):
        """Return an entry for each run: what it has come to."""
        if self.turn == 0:
            self.pair.begin(seed)
        entries = []
        for name, run in self.pair.runs.items():
            spent, done = run.advance(self.seconds) if self.turn > 0 else (0.0, 0)
            entries.append(
                {
                    "group": self.group,
                    "chain": self.name,
                    "method": IMPLICIT_SOLVENT.name,
                    "particles": len(self.pair.protein.positions),
                    "seed": seed,
                    "asked": self.turns,
                    "contestant": name,
                    "turn": self.turn,
                    "microseconds": 1e6 * spent / max(1, done),
                    "seconds": run.seconds,
                    "trials": run.done,
                    **run.describe(),
                }
            )
        return entries


class _Run:
    """A Simulation that is advanced by processor time.

    seconds : float, spent; done : int, trials or steps of dynamics
    """

    def __init__(self, simulation, observer, perStep):
        self._simulation = simulation
        self._observer = observer
        self._perStep = perStep
        self._turned = np.zeros(observer.sideChainCount, dtype=bool)
        self.seconds = 0.0
        self.done = 0

    def advance(self, seconds):
        """Go on for so much processor time; return what it was, and how many trials or steps were done."""
        start, done = time.process_time(), 0
        while done == 0 or time.process_time() - start < seconds:
            self._simulation.step(1)
            done += self._perStep
        spent = time.process_time() - start
        self.seconds += spent
        self.done += done
        return spent, done

    def describe(self):
        """Return what an entry says of the present state."""
        described, isElsewhere = self._observer.describe(positionsOf(self._simulation.context))
        self._turned |= isElsewhere
        share = float(self._turned.mean()) if len(self._turned) > 0 else 0.0
        return {"energy": self._energy(), **described, "turned": share}


class _Trials(_Run):
    """Ours, by the moves of the example."""

    def __init__(self, protein, seed, observer):
        system = protein.makeSystem(IMPLICIT_SOLVENT)
        _separateStiff(system)
        simulation = protein.makeSimulationOf(system, seed)
        integrator = simulation.integrator
        integrator.setTrialsPerStep(1)
        simulation.step(1)  # compares our energies with OpenMM's
        simulation.context.setPositions(protein.positions)
        integrator.setTrialsPerStep(TRIALS_PER_OUTER_TEST)
        self._constant = _energyOf(simulation.context, {_STIFF})
        super().__init__(simulation, observer, TRIALS_PER_OUTER_TEST)

    def _energy(self):
        integrator, context = self._simulation.integrator, self._simulation.context
        return integrator.getPotentialEnergy(context) - self._constant


class _Dynamics(_Run):
    """Langevin dynamics."""

    def __init__(self, simulation, seed, observer):
        simulation.context.setVelocitiesToTemperature(TEMPERATURE * unit.kelvin, seed)
        super().__init__(simulation, observer, 1)

    def _energy(self):
        return _energyOf(self._simulation.context, set(range(32)) - {_STIFF})


def _makeDynamics(protein, seed):
    """Make the Simulation of Langevin dynamics of a SampledProtein."""
    system = protein.makeSystem(
        IMPLICIT_SOLVENT, sterics=False, constraints=app.HBonds, hydrogenMass=_HYDROGEN_MASS, removeCMMotion=False
    )
    _separateStiff(system)
    integrator = openmm.LangevinMiddleIntegrator(TEMPERATURE * unit.kelvin, _FRICTION, TIMESTEP * unit.picosecond)
    integrator.setRandomNumberSeed(seed)
    simulation = app.Simulation(protein.topology, system, integrator, *choosePlatform())
    simulation.context.setPositions(protein.positions)
    return simulation


def _separateStiff(system):
    """Put bonds and angles into a force group of their own."""
    for force in system.getForces():
        if isinstance(force, _STIFF_FORCES):
            force.setForceGroup(_STIFF)


def _energyOf(context, groups):
    return context.getState(getEnergy=True, groups=groups).getPotentialEnergy()._value


class _Observer:
    """What is looked at, by MDTraj: how far the alpha carbons are from the start, how compact all is, side chains.

    sideChainCount : int, of torsions of side chains
    """

    def __init__(self, protein):
        """Take the SampledProtein at the start."""
        self._topology = mdtraj.Topology.from_openmm(protein.topology)
        self._carbons = self._topology.select("name CA")
        ofSideChains = [protein.torsions[number].particles for number in protein.torsionsOf(SIDE_CHAINS)]
        self.sideChainCount = len(ofSideChains)
        self._sideChains = np.array(ofSideChains, dtype=int).reshape(-1, 4)
        self._start = self._frame(protein.positions)
        self._startAngles = self._angles(self._start)

    def describe(self, positions):
        """Return what an entry says of positions, and which torsions of side chains are far from their start."""
        frame = self._frame(positions)
        away = np.abs(np.angle(np.exp(1j * (self._angles(frame) - self._startAngles))))
        return {
            "rmsd": float(mdtraj.rmsd(frame, self._start, atom_indices=self._carbons)[0]),
            "rg": float(mdtraj.compute_rg(frame)[0]),
        }, away > _ANOTHER_ROTAMER

    def _frame(self, positions):
        return mdtraj.Trajectory(positions[np.newaxis].astype(np.float32), self._topology)

    def _angles(self, frame):
        return mdtraj.compute_dihedrals(frame, self._sideChains)[0] if self.sideChainCount > 0 else np.zeros(0)
