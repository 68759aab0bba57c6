"""Watching the clashes of a running simulation."""

import csv
from typing import Any, TextIO

import openmm
from openmm import app, unit

from .clashes import Clash, ClashFinder, Path, nameClashes
from .naming import nameAtom
from .notes import warnOf
from .openmmchaintree import StericExclusionForce
from .reporterfile import ReporterFile
from .systemreading import isPeriodic
from .units import Number, inUnit

_TOPOLOGY = "the simulation's Topology"  # in messages

_COLUMNS = ("step", "time_ps", "clashes", "worst_overlap_nm", "atom1", "atom2")


class ClashError(openmm.OpenMMException):
    """Ends a simulation in which atoms overlap too much.

    step : int; clash : Clash, the worst one
    """

    def __init__(self, message: str, step: int, clash: Clash) -> None:
        super().__init__(message)
        self.step = step
        self.clash = clash


class ClashReporter:
    """A reporter for `openmm.app.Simulation` that writes how many clashes there are, and the worst, as lines of CSV.

    If the System has a StericExclusionForce, it defines what a clash is. Otherwise the reporter makes one by
    `createStericExclusionForce`, for all atoms except water and unbound ions, and leaves the System
    unchanged; periodic images then count if the System is periodic, in the box of each report.

    The columns are step, time_ps, clashes, worst_overlap_nm, atom1, atom2; the last three are empty without a clash.
    """

    def __init__(
        self, file: Path | TextIO, reportInterval: int, maxOverlap: Number | None = None, append: bool = False
    ) -> None:
        """Create a ClashReporter.

        Parameters
        ----------
        file : str, Path or file
            the file to write to, by its name or open for text
        reportInterval : int
            the number of steps between reports
        maxOverlap : float or Quantity, optional
            nm. The simulation ends with a ClashError at the first report in which a clash overlaps by more; 0: at the
            first clash. Reporters after this one in the list do not write that step.
        append : bool
            add to an existing file, without another heading

        Raises
        ------
        ValueError
            if the interval is not above 0, or maxOverlap is negative
        TypeError
            if maxOverlap has a unit that is not a length
        """
        if reportInterval < 1:
            raise ValueError(f"reportInterval must be above 0, not {reportInterval}")
        self._reportInterval = reportInterval
        self._maxOverlap = None if maxOverlap is None else inUnit(maxOverlap, "nm", "maxOverlap")
        if self._maxOverlap is not None and not self._maxOverlap >= 0:
            raise ValueError(f"maxOverlap must be at least 0, not {self._maxOverlap}")
        self._look: _Look | None = None
        self._file = ReporterFile(file, append)
        self._lines = csv.writer(self._file.text, lineterminator="\n")
        if self._file.needsHeading:
            self._lines.writerow(_COLUMNS)

    def describeNextReport(self, simulation: app.Simulation) -> dict[str, Any]:
        """Return when to report next, and which data the State must hold, as `openmm.app.Simulation` asks."""
        steps = self._reportInterval - simulation.currentStep % self._reportInterval
        return {"steps": steps, "periodic": False, "include": self._lookAt(simulation).include}

    def report(self, simulation: app.Simulation, state: openmm.State) -> None:
        """Write a line, and end the simulation if the worst clash overlaps by too much.

        Raises
        ------
        ClashError
            if a clash overlaps by more than maxOverlap
        """
        clashes = self._lookAt(simulation).find(simulation, state)
        worst = max(clashes, key=lambda clash: clash.overlap, default=None)
        time = state.getTime().value_in_unit(unit.picosecond)
        about = [""] * 3 if worst is None else [f"{worst.overlap:.6f}", worst.atom1, worst.atom2]
        self._lines.writerow([simulation.currentStep, f"{time:.6g}", len(clashes), *about])
        self._file.text.flush()
        if worst is not None and self._maxOverlap is not None and worst.overlap > self._maxOverlap:
            raise ClashError(
                f"step {simulation.currentStep}: {worst.atom1} and {worst.atom2} overlap by {worst.overlap:.4f} nm, "
                f"more than the {self._maxOverlap:g} nm that ClashReporter is to stop at",
                simulation.currentStep,
                worst,
            )

    def _lookAt(self, simulation):
        if self._look is None:
            self._look = _Look(simulation)
        return self._look


class _Look:
    """Finds the clashes of a Simulation: by the System's force, which knows the positions, or by a separate force.

    include : the data of a State that it needs
    """

    def __init__(self, simulation):
        forces = [force for force in simulation.system.getForces() if StericExclusionForce.isinstance(force)]
        if len(forces) > 1:
            raise ValueError("the System has more than one StericExclusionForce")
        self._force = StericExclusionForce.cast(forces[0]) if forces else None
        self._names = [nameAtom(atom) for atom in simulation.topology.atoms()] if forces else []
        self._finder = None
        self.include = () if forces else ("positions",)

    def find(self, simulation, state):
        if self._force is not None:
            return nameClashes(self._names, *self._force.getClashes(simulation.context))
        positions = state.getPositions(asNumpy=True).value_in_unit(unit.nanometer)
        if self._finder is None:
            periodic = isPeriodic(simulation.system)
            self._finder = ClashFinder(simulation.topology, positions, _TOPOLOGY, periodic=periodic)
            warnOf(self._finder.notes, stacklevel=2)
        return self._finder.find(positions, state.getPeriodicBoxVectors(asNumpy=True) / unit.nanometer, _TOPOLOGY)
