"""The steps of a repair: side chains, then backbones where needed, then the way back to the start.

Temperatures, weights and numbers of trials are from measurements (benchmarks/repair.py).
"""

import numpy as np
from scipy.spatial import cKDTree

from ..residues import polymerBackbone
from .scene import HARD_TOLERANCE, TOLERANCE

_NEAR = 0.4  # nm from a clash
_SPRINGS, _WEAKEST = 600, 5  # kJ/mol/nm² in the first round, and how often they are halved
_MANY = 8  # clashes of the backbones of two molecules that pass through one another
_TRIALS_OF_MOLECULES = 20000
_ROUNDS, _LATER_ROUNDS, _PATIENCE = 9, 3, 2


class RepairSteps:
    """Repairs the clashes of a Scene with RepairMoves."""

    def __init__(self, scene, moves, allowed=None, weakening=0):
        """Choose the residues that may move: a set of indices, or all.

        weakening : int, how often springs are halved before backbones move; after a run, how often they were
        """
        self._scene = scene
        self._moves = moves
        self._allowed = set(range(len(scene.residues))) if allowed is None else set(allowed)
        self.weakening = weakening

    def run(self, sideChainsOnly=False, isFirst=True):
        """Repair: side chains first, backbones near clashes that remain, and a last step back to the start.

        isFirst : whether no earlier pass has turned the side chains; else only what is near clashes moves at all
        """
        pairs, _ = self._scene.clashes()
        if len(pairs) == 0 and not isFirst:
            return
        if isFirst and not sideChainsOnly:
            self._partMolecules(pairs)
        if isFirst or sideChainsOnly:
            self._repairSideChains()
        if not sideChainsOnly:
            self._repairBackbones(_ROUNDS if isFirst else _LATER_ROUNDS)
        self._returnToStart(sideChainsOnly)

    def _targets(self, pairs):
        return set(self._scene.residueOf[pairs.ravel()].tolist()) & self._allowed

    def _neighborsOf(self, residues):
        """Return these residues and those within some distance of them that may move."""
        scene, positions = self._scene, self._scene.positions
        heavy = np.flatnonzero(scene.isHeavy)
        chosen = heavy[np.isin(scene.residueOf[heavy], list(residues))]
        hits = cKDTree(positions[heavy]).query_ball_point(positions[chosen], _NEAR)
        near = {int(residue) for hit in hits for residue in scene.residueOf[heavy[hit]]}
        return sorted((near | residues) & self._allowed)

    def _alongChain(self, residues, reach):
        """Return the residues up to some places before or after given ones in their chains."""
        scene, found = self._scene, set()
        for residue in residues:
            chain = scene.residues[residue].chain
            for other in range(max(0, residue - reach), min(len(scene.residues), residue + reach + 1)):
                if scene.residues[other].chain is chain:
                    found.add(other)
        return sorted(found & self._allowed)

    def _partMolecules(self, pairs):
        """Move molecules that pass through one another apart, as rigid bodies that side chains follow."""
        backbone = {atom for residue in self._scene.residues for atom in polymerBackbone(residue)}
        ofBackbones = np.isin(pairs, sorted(backbone)).all(axis=1)
        between = self._scene.molecules[pairs[ofBackbones]]
        between = np.sort(between[between[:, 0] != between[:, 1]], axis=1)
        _, counts = np.unique(between, axis=0, return_counts=True)
        if counts.max(initial=0) < _MANY:
            return
        moves = self._moves.clear()
        count = moves.addMolecules(0.05, 3, weight=1.0)
        if count > 0:
            moves.addSideChains(self._neighborsOf(self._targets(pairs)), turn=20)
            self._scene.anneal(3000, 30, _TRIALS_OF_MOLECULES * count, springs=2, stages=30)

    def _repairSideChains(self):
        pairs, _ = self._scene.clashes()
        residues = self._neighborsOf(self._targets(pairs))
        count = self._moves.clear().addSideChains(residues, turn=20)
        if len(pairs) > 0 and count > 0:
            self._scene.anneal(3000, 5, 100 * count, springs=60, stages=30)

    def _repairBackbones(self, rounds):
        scene = self._scene
        pairs, overlaps = scene.clashes()
        best, bestPositions, stale = (len(pairs), overlaps.sum()), scene.positions, 0
        for number in range(rounds):
            if len(pairs) == 0 or stale >= _PATIENCE:
                break
            targets = self._targets(pairs)
            moves = self._moves.clear()
            count = moves.addSideChains(self._neighborsOf(targets), turn=10)
            count += moves.addBackbones(self._alongChain(targets, 3 + number // 2), 3, 2, 5)
            count += moves.addMolecules(0.01, 1)
            if count == 0:
                break
            scene.anneal(600, 1, 60 * count, springs=_SPRINGS / 2 ** min(self.weakening, _WEAKEST), stages=16)
            self.weakening += 1
            pairs, overlaps = scene.clashes()
            stale = 0 if len(pairs) < best[0] else stale + 1
            if (len(pairs), overlaps.sum()) < best:
                best, bestPositions = (len(pairs), overlaps.sum()), scene.positions
        if len(pairs) > best[0]:
            scene.positions = bestPositions

    def _returnToStart(self, sideChainsOnly):
        """Pull moved residues back to the start as far as hard spheres allow."""
        scene = self._scene
        moved = np.abs(scene.positions - scene.start).max(axis=1) > 1e-6
        backbone = [t.particles[1] for t in scene.torsions if t.kind in ("psi", "beta")]
        bent = {int(scene.residueOf[atom]) for atom in backbone if moved[atom]}
        moves = self._moves.clear()
        residues = sorted(set(scene.residueOf[moved].tolist()) & self._allowed)
        count = moves.addSideChains(residues, turn=10, rotamers=0, anywhere=0, homes=1.0)
        if not sideChainsOnly and bent:
            count += moves.addBackbones(sorted(bent & self._allowed), 2, 2, 2)
        if count > 0:
            scene.setTolerance(HARD_TOLERANCE, isHard=True)
            scene.anneal(300, 1, 200 * count, springs=2000, stages=12)
            scene.setTolerance(TOLERANCE, isHard=False)
