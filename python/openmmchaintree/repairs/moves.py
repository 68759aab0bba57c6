"""The moves of a repair, for chosen residues of a Scene."""

from itertools import pairwise

import numpy as np
import openmm
from openmm import unit

from ..densities import rotamerDensities
from ..graphs import growTrees
from ..openmmchaintree import StericExclusionForce, TorsionDensity
from ..residues import polymerBackbone
from .angles import dihedral
from .scene import BACKBONES

_DEGREE = unit.degree
_END = 5  # residues at the ends of chains, whose torsions turn freely
_WINDOW = 7  # torsions that a closed move needs at least
_HOME_WIDTH, _HOME_FLOOR = 8, 0.05  # degrees about the angles at the start, and the share drawn uniformly


class RepairMoves:
    """Adds moves to the integrator of a Scene."""

    def __init__(self, scene):
        """Sort the torsions, and find the densities of rotamers."""
        self._scene = scene
        self._inRings = _torsionsInRings(scene)
        self._isBackbone = np.isin(scene.kinds, BACKBONES)
        self._isPeptide = scene.kinds == "omega"
        self._isSideChain = ~self._isBackbone & ~self._isPeptide
        self._isEnd = self._findEnds()
        self._findDrawn()

    def _findEnds(self):
        """Return whether each torsion belongs to a residue near the end of its molecule."""
        scene, rows = self._scene, {}
        for residue in scene.residues:
            for atom in polymerBackbone(residue)[1:2]:
                rows.setdefault(int(scene.molecules[atom]), []).append(residue.index)
        ends = [residue for row in rows.values() for residue in {*row[:_END], *row[-_END:]}]
        return np.isin(scene.residueOfTorsion, ends)

    def _findDrawn(self):
        scene, plain = self._scene, StericExclusionForce()
        for torsion in scene.torsions:
            plain.addTorsion(*torsion.particles)
        try:
            found = rotamerDensities(scene.topology, plain)
        except ValueError:
            found = [], []
        sets = [pair for pair in zip(*found, strict=True) if self._inRings.isdisjoint(pair[0])]
        self._rotamers = [(int(scene.residueOfTorsion[pair[0][0]]), *pair) for pair in sets]
        self._homes = []
        for residue in np.unique(scene.residueOfTorsion[self._isSideChain]).tolist():
            chosen = [t for t in self._sideChains([residue]) if scene.kinds[t].startswith("chi")]
            if chosen:
                widths = [np.radians([_HOME_WIDTH] * len(chosen))]
                atoms = np.array([scene.torsions[t].particles for t in chosen])
                means = [dihedral(scene.anchors[atoms])]
                density = TorsionDensity.fromRotamers([1.0], means, widths, _HOME_FLOOR)
                self._homes.append((residue, tuple(chosen), density))

    def _sideChains(self, residues):
        chosen = self._isSideChain & np.isin(self._scene.residueOfTorsion, list(residues))
        return [t for t in np.flatnonzero(chosen).tolist() if t not in self._inRings]

    def clear(self):
        """Remove all moves; return this object."""
        integrator = self._scene.integrator
        while integrator.getNumMoves() > 0:
            integrator.removeMove(0)
        return self

    def addSideChains(self, residues, turn, rotamers=1.0, anywhere=0.3, homes=0.5):
        """Add moves of side chains: small turns (degrees), rotamers, any angle, and the start, by weights.

        Return the number of torsions.
        """
        integrator, torsions = self._scene.integrator, self._sideChains(residues)
        if torsions:
            integrator.addTorsionMove(1.0, turn * _DEGREE, torsions)
            if anywhere > 0:
                integrator.addTorsionMove(anywhere, np.pi, torsions)
        for weight, drawn in ((rotamers, self._rotamers), (homes, self._homes)):
            chosen = [pair for pair in drawn if pair[0] in residues]
            if chosen and weight > 0:
                integrator.addDrawnMove(weight, [pair[1] for pair in chosen], [pair[2] for pair in chosen])
        return len(torsions)

    def addBackbones(self, residues, turn, turnOfPeptides, turnOfEnds):
        """Add moves of backbones: closed ones without and with ω, and of chain ends, by angles in degrees.

        Return the number of torsions.
        """
        scene, integrator = self._scene, self._scene.integrator
        isNear = np.isin(scene.residueOfTorsion, list(residues))
        torsions = np.flatnonzero(isNear & self._isBackbone).tolist()
        withPeptides = np.flatnonzero(isNear & (self._isBackbone | self._isPeptide)).tolist()
        for weight, angle, chosen in ((1.0, turn, torsions), (0.3, turnOfPeptides, withPeptides)):
            if len(chosen) >= _WINDOW:
                self._addClosed(weight, angle, chosen)
        ends = [t for t in np.flatnonzero(isNear & self._isBackbone & self._isEnd).tolist() if t not in self._inRings]
        if ends:
            integrator.addTorsionMove(0.1, turnOfEnds * _DEGREE, ends)
        return len(torsions)

    def _addClosed(self, weight, angle, torsions):
        integrator = self._scene.integrator
        try:
            integrator.addClosedMove(weight, angle * _DEGREE, torsions)
        except openmm.OpenMMException as error:
            if "window" not in str(error):
                raise

    def addMolecules(self, shift, turn, weight=0.02):
        """Add a move of whole molecules, without the largest; shift in nm, turn in degrees. Return their number."""
        molecules = self._scene.rootsOfMovable()[0 if self._scene.isFixed.any() else 1 :]
        if molecules:
            self._scene.integrator.addRigidBodyMove(weight, shift, turn * _DEGREE, molecules)
        return len(molecules)


def _torsionsInRings(scene):
    """Return the torsions in rings of closures, which only closed moves turn."""
    axes = {frozenset(torsion.particles[1:3]): number for number, torsion in enumerate(scene.torsions)}
    neighbors = [list(near) for near in scene.graph.neighbors]
    held = np.flatnonzero(scene.isFixed).tolist()
    for first, second in pairwise(held):  # all fixed atoms are one part
        neighbors[first].append(second)
        neighbors[second].append(first)
    found = set()
    for _, start, end, _ in scene.graph.closures:
        parents = dict(growTrees(neighbors, [start]))
        while end in parents:
            found.add(axes.get(frozenset((end, parents[end]))))
            end = parents[end]
    return found - {None}
