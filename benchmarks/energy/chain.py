"""A chain of states of a protein, and what is looked at of them."""

import mdtraj
import numpy as np
from openmm import unit
from racing.course import measure

from .proteins import positionsOf

RMSDS = ("rmsd", "rmsdWithoutEnds")  # what of them columns of a Chain begin with

_ENDS = 5  # residues at either end of a chain that may hang loose


class Chain:
    """A Simulation, and what is looked at of it after some steps: torsions of some kinds, and RMSDs of the heavy
    atoms: of all, and without the ends of chains, which may hang loose and turn by far more than what is folded.

    kinds : (k,) array of str, of the torsions
    times : list of float, µs a trial, of the steps between looks
    trialsPerLook, count : int, trials from one look to the next, and looks
    """

    def __init__(self, protein, simulation, kinds, steps):
        """Take a SampledProtein, from whose positions RMSDs are counted, a Simulation of it, kinds of torsions, and how
        many steps lie between looks."""
        self._simulation, self._steps = simulation, steps
        self.trialsPerLook = steps * simulation.integrator.getTrialsPerStep()
        all_ = np.array([torsion.kind for torsion in protein.torsions])
        self._watched = np.isin(all_, kinds)
        self.kinds = all_[self._watched]
        self._topology = mdtraj.Topology.from_openmm(protein.topology)
        self._parts = heavyAtoms(self._topology)
        self._start = self._frame(protein.positions)
        self.times, self._samples = [], []

    @property
    def count(self):
        return len(self._samples)

    def begin(self, positions):
        """Go to positions, an (n, 3) array in nm."""
        self._simulation.context.setPositions(positions * unit.nanometer)

    def sample(self, count):
        """Time the steps to so many looks at the state."""
        for _ in range(count):
            _, microseconds = measure(self._simulation.step, self._steps)
            self.times.append(microseconds / self.trialsPerLook)
            self._samples.append(self._look())

    def values(self):
        """Return what was looked at: an (n, 2 + 2k) array of RMSDS (nm), cosines, sines."""
        return np.array(self._samples)

    def positions(self):
        """Return where all atoms are, an (n, 3) array in nm."""
        return positionsOf(self._simulation.context)

    def outerTestsKept(self):
        """Return the part of outer tests that kept what trials had made."""
        statistics = self._simulation.integrator.getOuterStatistics()
        return statistics.accepted / max(1, statistics.attempted)

    def _look(self):
        context = self._simulation.context
        angles = self._simulation.integrator.getTorsionAngles(context)[self._watched]
        frame = self._frame(positionsOf(context))
        rmsds = [mdtraj.rmsd(frame, self._start, atom_indices=part) for part in self._parts]
        return np.concatenate([*rmsds, np.cos(angles), np.sin(angles)])

    def _frame(self, positions):
        return mdtraj.Trajectory(positions[np.newaxis].astype(np.float32), self._topology)


def heavyAtoms(topology):
    """Return the indices of all heavy atoms of an mdtraj.Topology, and of those that are of no end of a chain."""
    heavy = topology.select("element != H")
    return heavy, np.array([atom for atom in heavy if not _isOfEnd(topology.atom(atom).residue)])


def _isOfEnd(residue):
    """Whether a residue is at an end of a chain of some length."""
    count = residue.chain.n_residues
    place = residue.index - residue.chain.residue(0).index
    return count > 4 * _ENDS and not _ENDS <= place < count - _ENDS
