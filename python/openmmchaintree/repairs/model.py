"""A model made ready for repair: with the hydrogens that scores count, and the way back to the given atoms."""

import numpy as np

from ..bonds import BondGraph
from ..residues import aminoAcid
from ..scoring.clashscore import clashscore
from ..scoring.protonation import withHydrogens
from ..solute import subset
from .carrying import carryAlong

# nm: sulfurs of cysteines that are this near and bind nothing else belong to a disulfide.
_NEAR_SULFURS = 0.36
_HYDROGEN = 1
_ROUNDING = 1e-9  # nm


class RepairModel:
    """A Topology with Reduce's hydrogens, at positions that a repair changes.

    topology : openmm.app.Topology
    start, anchors : (n, 3) float64 arrays, nm, where atoms are, and where the repair began; of hydrogens both are alike
    origins : (n,) int array, the particle of the given Topology that each atom is, -1 for an added hydrogen
    disulfides : list of (int, int), pairs of sulfurs that the Topology's bonds lack and that are near
    """

    def __init__(self, topology, positions, anchors, protonated):
        """Take positions and anchors, (n, 3) float64 arrays, nm, of whole molecules, and the positions' Protonated.

        Hydrogens of amino acids, nucleotides and hemes are replaced, as in MolProbity. Other residues keep theirs.
        """
        self._given = topology
        self._positions = positions
        self.atoms = list(topology.atoms())
        self.disulfides = _nearSulfurs(protonated.topology, protonated.positions)
        self.topology, kept = _withoutThiols(protonated.topology, self.disulfides)
        self.start = protonated.positions[kept]
        self.origins = protonated.origins[kept]
        isGiven = self.origins >= 0
        self.anchors = self.start.copy()
        self.anchors[isGiven] = anchors[self.origins[isGiven]]
        place = np.full(len(protonated.positions), -1)
        place[kept] = np.arange(len(kept))
        self.disulfides = [(int(place[first]), int(place[second])) for first, second in self.disulfides]

    def placeGiven(self, positions):
        """Return positions (nm) of the given atoms for positions of the model's, both (n, 3).

        Given hydrogens that were replaced follow the atoms that bear them. Atoms that do not move keep all their bits.
        """
        placed = self._positions.copy()
        kept = self.origins >= 0
        moved = kept & _differ(positions, self.start)
        placed[self.origins[moved]] = positions[moved]
        replaced = np.setdiff1d(np.arange(len(placed)), self.origins[kept])
        parents = self._bearers(replaced)
        hasParent = parents >= 0
        replaced, parents = replaced[hasParent], parents[hasParent]
        graph = BondGraph(self.topology, self.start)
        carried = carryAlong(graph.neighbors, self.start, positions, parents, self._positions[replaced])
        moved = _differ(carried, self._positions[replaced])
        placed[replaced[moved]] = carried[moved]
        return placed

    def _bearers(self, replaced):
        """Return for some given atoms the nearest heavy atom of their residue, as the model's index, -1 without one."""
        place = np.full(len(self.atoms), -1)
        place[self.origins[self.origins >= 0]] = np.flatnonzero(self.origins >= 0)
        bearers = []
        for atom in replaced.tolist():
            heavy = [
                other.index
                for other in self.atoms[atom].residue.atoms()
                if other.element is not None and other.element.atomic_number != _HYDROGEN and place[other.index] >= 0
            ]
            if not heavy:
                bearers.append(-1)
                continue
            distances = np.linalg.norm(self._positions[heavy] - self._positions[atom], axis=1)
            bearers.append(int(place[heavy[int(distances.argmin())]]))
        return np.array(bearers, dtype=int)


def scoreStructure(topology, positions):
    """Return the Clashscore of a Topology at positions (nm), with hydrogens placed for it, and the Protonated."""
    protonated = withHydrogens(topology, positions)
    return clashscore(protonated.topology, protonated.positions), protonated


def _differ(first, second):
    """Return whether each of some points has moved by more than rounding."""
    return np.abs(first - second).max(axis=1, initial=0) > _ROUNDING


def _nearSulfurs(topology, positions):
    """Return pairs of sulfurs of cysteines that bind nothing else and lie near each other, nearest pairs first."""
    sulfurs = [atom.index for atom in topology.atoms() if atom.name == "SG" and aminoAcid(atom.residue.name) == "CYS"]
    bound = set(sulfurs)
    taken = set()
    for bond in topology.bonds():
        for atom, other in (bond, bond[::-1]):
            isHydrogen = other.element is not None and other.element.atomic_number == _HYDROGEN
            if atom.index in bound and not isHydrogen and other.residue is not atom.residue:
                taken.add(atom.index)
    free = [atom for atom in sulfurs if atom not in taken]
    pairs = [(first, second) for number, first in enumerate(free) for second in free[number + 1 :]]
    lengths = [float(np.linalg.norm(positions[first] - positions[second])) for first, second in pairs]
    chosen = []
    for _, pair in sorted(zip(lengths, pairs, strict=True)):
        if np.linalg.norm(positions[pair[0]] - positions[pair[1]]) > _NEAR_SULFURS:
            break
        if taken.isdisjoint(pair):
            chosen.append(pair)
            taken.update(pair)
    return chosen


def _withoutThiols(topology, disulfides):
    """Return a Topology with bonds between some sulfurs in place of their hydrogens, and the atoms that it keeps."""
    sulfurs = {atom for pair in disulfides for atom in pair}
    atoms = list(topology.atoms())
    loose = set()
    for bond in topology.bonds():
        for atom, other in (bond, bond[::-1]):
            if atom.index in sulfurs and other.element is not None and other.element.atomic_number == _HYDROGEN:
                loose.add(other.index)
    bonds = [(bond[0].index, bond[1].index) for bond in topology.bonds()]
    kept = [atom for atom in atoms if atom.index not in loose]
    made = subset(topology, kept, [*bonds, *disulfides])
    return made, np.array([atom.index for atom in kept], dtype=int)
