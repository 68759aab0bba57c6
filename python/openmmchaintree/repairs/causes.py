"""Why clashes remain after a repair."""

from collections import Counter
from typing import NamedTuple

import numpy as np

from ..naming import nameAtom
from .defects import BROKEN, PIERCED, TWISTED

# Two chains that still clash so often pass through one another.
_MANY = 20

THROUGH, HELD, RIGID, NO_ROOM = "chains through one another", "held", "no torsion between them", "no room"


class RemainingClash(NamedTuple):
    """A pair of atoms that still clashes. atoms : str, their names; overlap : float, nm; cause : str"""

    atoms: str
    overlap: float
    cause: str


def explainClashes(score, topology, scene, indices, defects):
    """Return the list of RemainingClash of a Clashscore, largest overlaps first.

    topology : openmm.app.Topology that the score is of; scene : Scene
    indices : (n,) int array, the atom of the scene for each of its atoms, -1 for atoms that the scene lacks
    defects : list of Defect of the scene
    """
    atoms = list(topology.atoms())
    byKind = {kind: _residuesOf(scene, defects, kind) for kind in (BROKEN, PIERCED, TWISTED)}
    betweenChains = Counter(_chains(atoms, pair) for pair in score.pairs.tolist())
    found = []
    for pair, overlap in zip(score.pairs.tolist(), score.overlaps.tolist(), strict=True):
        names = f"{nameAtom(atoms[pair[0]])} – {nameAtom(atoms[pair[1]])}"
        chains = _chains(atoms, pair)
        isThrough = len(chains) == 2 and betweenChains[chains] >= _MANY
        found.append(RemainingClash(names, overlap, _causeOf(indices[pair], atoms, pair, scene, byKind, isThrough)))
    return sorted(found, key=lambda clash: -clash.overlap)


def _causeOf(indices, atoms, pair, scene, byKind, isThrough):
    residues = {atoms[atom].residue.index for atom in pair}
    for kind in (BROKEN, PIERCED, TWISTED):
        if not residues.isdisjoint(byKind[kind]) and (kind != BROKEN or max(residues) - min(residues) <= 1):
            return kind
    if isThrough:
        return THROUGH
    known = indices[indices >= 0]
    if len(known) == 2:
        if scene.isFixed[known].all():
            return HELD
        if scene.links[known[0]] == scene.links[known[1]]:
            return RIGID
    return NO_ROOM


def _chains(atoms, pair):
    return frozenset(atoms[atom].residue.chain.index for atom in pair)


def _residuesOf(scene, defects, kind):
    chosen = [atom for defect in defects if defect.kind == kind for atom in defect.atoms]
    return set(scene.residueOf[chosen].tolist())


def sceneIndices(model, protonated):
    """Return for each atom of a Protonated the atom of a RepairModel that is the same given atom, -1 for others."""
    place = np.full(len(model.atoms), -1)
    kept = model.origins >= 0
    place[model.origins[kept]] = np.flatnonzero(kept)
    # Hydrogens stand where the atoms that bear them are.
    return place[protonated.bearers]
