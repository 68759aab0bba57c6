"""The columns of tables of frames, written as OpenMM's StateDataReporter writes its table."""

import csv
import io

_TRIAL = "Trial"
_ENERGY = "Potential Energy (kJ/mole)"
_RADIUS = "Radius of Gyration (nm)"
_DISTANCE = "End-to-End Distance (nm)"
_RMSD = "RMSD (nm)"
_ACCEPTANCE = "Acceptance (%)"
COLUMNS = (_TRIAL, _ENERGY, _RADIUS, _DISTANCE, _RMSD, _ACCEPTANCE)


def headerOf(hasEnergy, hasEnds):
    """Return the first line of a table; a run without energies, or without chains, lacks a column."""
    absent = {_ENERGY: not hasEnergy, _DISTANCE: not hasEnds}
    return "#" + ",".join(f'"{name}"' for name in COLUMNS if not absent.get(name)) + "\n"


def lineOf(trial, energy, shape, attempted, accepted):
    """Return a line of a table.

    Parameters
    ----------
    trial : int
        the number of trials before the frame
    energy : float or None
        kJ/mol
    shape : ShapeValues
    attempted, accepted : int
        trials so far; without any, the last cell is empty
    """
    cells = [trial, energy, shape.radiusOfGyration, shape.endToEndDistance, shape.rmsd]
    acceptance = 100 * accepted / attempted if attempted else ""
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow([*(cell for cell in cells if cell is not None), acceptance])
    return line.getvalue()
