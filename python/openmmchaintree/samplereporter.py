"""Reporting the progress of Monte Carlo in a Simulation."""

from typing import Any, TextIO

import numpy as np
import openmm
from openmm import app, unit

from .clashes import Path
from .openmmchaintree import StericExclusionForce, TorsionMonteCarloIntegrator
from .reporterfile import ReporterFile
from .samplecolumns import headerOf, lineOf
from .shape import Shape
from .units import Array, positionsInNm


class SampleReporter:
    """A reporter for `openmm.app.Simulation` with a TorsionMonteCarloIntegrator, which writes lines of CSV.

    The columns are the same as in the table of `openmm-chaintree sample`: the number of trials; the sampled potential
    energy, kJ/mol, if there is any; radius of gyration, end-to-end distance and RMSD to the start, nm; accepted trials
    so far, %.

    Shapes are computed of molecules with torsions or ball joints. The radius of gyration is weighted by mass. The other
    two columns are about Cα atoms, C4′ atoms or beads: the ends of the longest chain, and the RMSD of all chains after
    superposition. Without three such atoms, the RMSD is over all heavy atoms. A line takes 0.6 ms with 600 atoms.
    """

    def __init__(
        self, file: Path | TextIO, reportInterval: int, reference: Array | None = None, append: bool = False
    ) -> None:
        """Create a SampleReporter.

        Parameters
        ----------
        file : str, Path or file
            the file to write to, by its name or open for text
        reportInterval : int
            the number of steps between reports
        reference : (n, 3) array or Quantity, optional
            nm; positions of all particles to which the RMSD is measured; default: those before the first step
        append : bool
            add to an existing file, without another heading

        Raises
        ------
        ValueError
            if the interval is not above 0
        """
        if reportInterval < 1:
            raise ValueError(f"reportInterval must be above 0, not {reportInterval}")
        self._reportInterval = reportInterval
        self._reference = reference
        self._look: _Look | None = None
        self._file = ReporterFile(file, append)

    def describeNextReport(self, simulation: app.Simulation) -> dict[str, Any]:
        """Return when to report next, and which data the State must hold, as `openmm.app.Simulation` asks.

        Raises
        ------
        ValueError
            if the Simulation has no TorsionMonteCarloIntegrator, or the reference has another number of positions
        """
        self._lookAt(simulation)
        steps = self._reportInterval - simulation.currentStep % self._reportInterval
        return {"steps": steps, "periodic": False, "include": ["positions"]}

    def report(self, simulation: app.Simulation, state: openmm.State) -> None:
        """Write a line."""
        look = self._lookAt(simulation)
        if self._file.needsHeading:
            self._file.text.write(headerOf(look.hasEnergy, look.shape.ends is not None))
            self._file.needsHeading = False
        self._file.text.write(look.line(simulation, state))
        self._file.text.flush()

    def _lookAt(self, simulation):
        if self._look is None:
            self._look = _Look(simulation, self._reference)
        return self._look


class _Look:
    """What a SampleReporter knows of its Simulation. shape : Shape; hasEnergy : bool"""

    def __init__(self, simulation, reference):
        self._integrator = _integratorOf(simulation)
        count = simulation.system.getNumParticles()
        if reference is None:
            start = _positionsOf(simulation.context.getState(positions=True))
        else:
            start = positionsInNm(reference, count)
        masses = [simulation.system.getParticleMass(particle) for particle in range(count)]
        elements = [atom.element for atom in simulation.topology.atoms()]
        masses = [own if element is None else element.mass for own, element in zip(masses, elements, strict=True)]
        masses = np.array([mass.value_in_unit(unit.dalton) for mass in masses])
        self.shape = Shape(simulation.topology, start, masses, _movingMolecules(simulation))
        plan = self._integrator.getEnergyPlan(simulation.context)
        self.hasEnergy = any(entry.kind != "not sampled" for entry in plan)
        # Steps of other lengths may have come before.
        self._step, self._trials = simulation.currentStep, simulation.currentStep * self._integrator.getTrialsPerStep()

    def line(self, simulation, state):
        self._trials += (simulation.currentStep - self._step) * self._integrator.getTrialsPerStep()
        self._step = simulation.currentStep
        moves = range(self._integrator.getNumMoves())
        counts = np.array([self._integrator.getMoveStatistics(move) for move in moves]).sum(axis=0)
        energy = self._integrator.getPotentialEnergy(simulation.context) if self.hasEnergy else None
        return lineOf(self._trials, energy, self.shape.measure(_positionsOf(state)), int(counts[0]), int(counts[3]))


def _integratorOf(simulation):
    """Return the TorsionMonteCarloIntegrator of a Simulation."""
    if TorsionMonteCarloIntegrator.isinstance(simulation.integrator):
        return TorsionMonteCarloIntegrator.cast(simulation.integrator)
    raise ValueError("SampleReporter needs a TorsionMonteCarloIntegrator; for dynamics, use StateDataReporter")


def _positionsOf(state):
    return state.getPositions(asNumpy=True).value_in_unit(unit.nanometer)


def _movingMolecules(simulation):
    """Return whether each particle is in a molecule with torsions or ball joints, or in any if none has."""
    forces = [force for force in simulation.system.getForces() if StericExclusionForce.isinstance(force)]
    joined = set()
    for force in map(StericExclusionForce.cast, forces):
        joined |= {force.getTorsionParticles(torsion)[1] for torsion in range(force.getNumTorsions())}
        joined |= {force.getBallJointParticles(joint)[0] for joint in range(force.getNumBallJoints())}
    isMoving = np.zeros(simulation.system.getNumParticles(), dtype=bool)
    for molecule in simulation.context.getMolecules():
        isMoving[list(molecule)] = not joined.isdisjoint(molecule)
    return isMoving if isMoving.any() else ~isMoving
