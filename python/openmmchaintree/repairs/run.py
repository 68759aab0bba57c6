"""The repair of one model, with what it changed and what still clashes."""

import numpy as np

from ..errors import InputError
from ..residues import isAlphaCarbonOnly, isPolymer, polymerBackbone
from ..scoring.protonation import withHydrogens
from ..selection import selectAtoms
from .causes import explainClashes, sceneIndices
from .changes import describeChanges
from .defects import PIERCED, findDefects
from .mending import mendBonds
from .model import RepairModel, scoreStructure
from .moves import RepairMoves
from .scene import Scene
from .steps import RepairSteps

_PASSES = 3
_INTERFACE = 0.6  # nm between heavy atoms of two chains


def repairModel(topology, positions, choices, seed):
    """Do the work of `repairStructure`; positions : (n, 3) float64 array, nm; choices : RepairChoices

    Return the arguments of a Repair.
    """
    _checkAtoms(topology)
    before, _ = scoreStructure(topology, positions)
    defectsBefore = findDefects(topology, positions, [])
    anchors, mended = mendBonds(topology, positions) if choices.mendsBonds else (positions, [])
    complete = withHydrogens(topology, anchors, areClashesBonds=False)
    first = best = _Pass(topology, anchors, anchors, complete, choices, seed)
    while best.score.pairs.size and best.number < _PASSES and best.canMove:
        following = _Pass(topology, best.placed, anchors, best.protonated, choices, seed, best)
        if len(following.score.pairs) >= len(best.score.pairs):
            break
        best = following
    scene, defects = best.scene, best.defects
    isClean = best.score.score <= choices.cleanBelow and all(defect.kind != PIERCED for defect in defects)
    indices = sceneIndices(best.model, best.protonated)
    return {
        "positions": best.placed,
        "clashscoreBefore": before.score,
        "clashscoreAfter": best.score.score,
        "clashesBefore": len(before.pairs),
        "clashesAfter": len(best.score.pairs),
        "ownBefore": first.ownBefore,
        "ownAfter": len(scene.clashes()[0]),
        "changes": describeChanges(topology, positions, best.placed, _ofGiven(scene.torsions, best.model)),
        "remaining": explainClashes(best.score, best.protonated.topology, scene, indices, defects),
        "defectsBefore": [f"{defect.kind}: {defect.text}" for defect in defectsBefore],
        "defects": [f"{defect.kind}: {defect.text}" for defect in defects],
        "mendedBonds": mended,
        "disulfides": _describeClosed(first, best.placed),
        "isClean": isClean,
        "protonated": best.protonated,
    }


class _Pass:
    """One pass of the repair: hydrogens placed by the present surroundings, all steps, and the score of the result.

    Groups that turn only hydrogens turn freely in the first pass. In later passes they stay where Reduce puts them,
    so that atoms make room for them.
    """

    def __init__(self, topology, positions, anchors, protonated, choices, seed, previous=None):
        self.number = number = 1 if previous is None else previous.number + 1
        self.weakening = 0 if previous is None else previous.weakening
        self.model = model = RepairModel(topology, positions, anchors, protonated)
        fixed, allowed = _chosenAtoms(topology, anchors, model, choices)
        self.scene = Scene(model, fixed, seed, choices.maxShift, choices.turnsLigands, holdsRotors=number > 1)
        self.ownBefore = len(self.scene.clashes()[0])
        self.canMove = len(self.scene.torsions) > 0
        if self.canMove:
            steps = RepairSteps(self.scene, RepairMoves(self.scene), allowed, max(0, self.weakening - 1))
            steps.run(choices.sideChainsOnly, isFirst=number == 1)
            self.weakening = steps.weakening
        self.placed = model.placeGiven(self.scene.positions)
        self.score, self.protonated = scoreStructure(topology, self.placed)
        self.defects = findDefects(model.topology, self.scene.positions, self.scene.torsions)


def _ofGiven(torsions, model):
    """Return the side-chain torsions of a RepairModel with the particles of the given Topology."""
    origins = model.origins.tolist()
    chosen = [torsion for torsion in torsions if torsion.kind.startswith("chi")]
    return [torsion._replace(particles=tuple(origins[atom] for atom in torsion.particles)) for torsion in chosen]


def _checkAtoms(topology):
    polymers = [residue for residue in topology.residues() if isPolymer(residue)]
    if not polymers:
        raise InputError("there is no protein and no nucleic acid to repair")
    if all(map(isAlphaCarbonOnly, polymers)):
        raise InputError("the model has only Cα atoms: build the other atoms first")
    names = {atom.name for residue in polymers for atom in residue.atoms()}
    amino = [r for r in polymers if polymerBackbone(r) and r.name not in ("GLY", "ALA")]
    if amino and not names - {"N", "CA", "C", "O", "OXT", "CB"} - {n for n in names if n.startswith("H")}:
        raise InputError("the model has no side chains: build them first")


def _chosenAtoms(topology, positions, model, choices):
    """Return the fixed atoms of the model, and the set of residues of it that may move or None."""
    place = np.full(topology.getNumAtoms(), -1)
    place[model.origins[model.origins >= 0]] = np.flatnonzero(model.origins >= 0)
    held = np.zeros(topology.getNumAtoms(), dtype=bool)
    if choices.move is not None:
        held[:] = True
        held[selectAtoms(topology, choices.move)] = False
    if choices.fixed is not None:
        held[selectAtoms(topology, choices.fixed)] = True
    if held.all():
        raise InputError("nothing may move: all atoms are fixed")
    fixed = place[np.flatnonzero(held)]
    allowed = None
    if choices.interface is not None:
        residueOf = {atom.index: atom.residue.index for atom in model.topology.atoms()}
        near = _interfaceAtoms(topology, positions, *choices.interface)
        allowed = {residueOf[atom] for atom in place[near].tolist() if atom >= 0}
    return fixed[fixed >= 0].tolist(), allowed


def _interfaceAtoms(topology, positions, first, second):
    """Return the atoms of residues of two chains, by name, that are near the other chain."""
    from scipy.spatial import cKDTree

    groups = []
    for name in (first, second):
        heavy = [
            atom
            for atom in topology.atoms()
            if atom.residue.chain.id.strip() == name and atom.element is not None and atom.element.atomic_number > 1
        ]
        if not heavy:
            known = sorted({chain.id.strip() or "one without a name" for chain in topology.chains()})
            raise InputError(f"there is no chain {name!r}; the chains are: {', '.join(known)}")
        groups.append(heavy)
    chosen = set()
    for own, other in (groups, groups[::-1]):
        tree = cKDTree(positions[[atom.index for atom in other]])
        distances, _ = tree.query(positions[[atom.index for atom in own]], distance_upper_bound=_INTERFACE)
        chosen |= {atom.residue for atom, distance in zip(own, distances, strict=True) if np.isfinite(distance)}
    if not chosen:
        raise InputError(f"chains {first} and {second} are nowhere within {_INTERFACE} nm of each other")
    return np.array([atom.index for residue in chosen for atom in residue.atoms()], dtype=int)


def _describeClosed(first, placed):
    """Return the open disulfides of the first pass with their lengths (nm) before and after, in words."""
    rows = []
    for pair in first.scene.open:
        ends = placed[first.model.origins[list(pair)]]
        rows.append(f"{first.scene.graph.describePair(pair)}, now {np.linalg.norm(ends[0] - ends[1]):.3f} nm")
    return rows
