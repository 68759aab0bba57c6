"""The shape of molecules: radius of gyration, end-to-end distance, and deviation from the start."""

from typing import NamedTuple

import numpy as np

from .residues import isPolymer

_TRACE = ("CA", "C4'")
_FEWEST_POINTS = 3  # that can be superposed


class ShapeValues(NamedTuple):
    """The shape of one conformation, in nm; endToEndDistance is None if there is no chain of two residues."""

    radiusOfGyration: float
    endToEndDistance: float | None
    rmsd: float


class Shape:
    """Measures the shape of a part of the atoms of a Topology.

    The radius of gyration is weighted by mass. The trace of a chain is its Cα or C4′ atoms, or beads; the ends are
    those of the longest trace. The RMSD is that of all traces, after superposition on the start; without three such
    atoms, that of all heavy atoms.

    Attributes
    ----------
    ends : (int, int) or None
        the atoms of the end-to-end distance
    compared : int array
        the atoms of the RMSD
    isTrace : bool
        whether these are traces
    """

    def __init__(self, topology, start, masses, isPart):
        """Take a Topology, its positions at the start, and its masses.

        start : (n, 3) float64 array, nm; masses : (n,) array; isPart : (n,) bool array, the atoms that count
        """
        self._masses = masses
        self._part = np.flatnonzero(isPart)
        traces = [_traceOf(chain, isPart) for chain in topology.chains()]
        longest = max(traces, key=len, default=[])
        self.ends = (longest[0], longest[-1]) if len(longest) > 1 else None
        self.compared = np.array([atom for trace in traces for atom in trace], dtype=int)
        self.isTrace = len(self.compared) >= _FEWEST_POINTS
        if not self.isTrace:
            atoms = [atom for atom in topology.atoms() if isPart[atom.index]]
            heavy = [atom.index for atom in atoms if atom.element is None or atom.element.symbol not in ("H", "D")]
            self.compared = np.array(heavy, dtype=int)
        self._start = _centred(start[self.compared])

    def measure(self, positions):
        """Return the ShapeValues of positions, a float64 array of shape (n, 3) in nm."""
        part, masses = positions[self._part], self._masses[self._part]
        squares = ((part - np.average(part, axis=0, weights=masses)) ** 2).sum(axis=1)
        radius = float(np.sqrt(np.average(squares, weights=masses)))
        distance = None
        if self.ends is not None:
            distance = float(np.linalg.norm(positions[self.ends[1]] - positions[self.ends[0]]))
        return ShapeValues(radius, distance, self._rmsd(positions[self.compared]))

    def _rmsd(self, positions):
        """Return the RMSD to the start after the rotation of Kabsch (1976)."""
        centred = _centred(positions)
        left, _, right = np.linalg.svd(centred.T @ self._start)
        left[:, -1] *= np.sign(np.linalg.det(left @ right))
        return float(np.sqrt(((centred @ left @ right - self._start) ** 2).sum(axis=1).mean()))


def _centred(positions):
    return positions - positions.mean(axis=0)


def _traceOf(chain, isPart):
    """Return an atom for each residue of a polymer, and each bead, of a chain."""
    trace = []
    for residue in chain.residues():
        atoms = [atom for atom in residue.atoms() if isPart[atom.index]]
        if len(atoms) == 1 and atoms[0].element is None:
            trace.append(atoms[0].index)
        elif isPolymer(residue):
            trace += [atom.index for atom in atoms if atom.name in _TRACE][:1]
    return trace
