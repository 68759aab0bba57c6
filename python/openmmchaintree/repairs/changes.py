"""What a repair changed: shifts by residue, and rotamers."""

from typing import NamedTuple

import numpy as np

from ..naming import describeResidue
from ..residues import polymerBackbone
from .angles import dihedral, turnBetween

# A rotamer has changed if χ1 or χ2 has turned by more than this, rad.
_OTHER_ROTAMER = np.radians(40)
_HYDROGEN = 1


class ResidueShift(NamedTuple):
    """How far a residue has moved, nm.

    residue : str, its name; trace : float, of Cα or P, nan without one
    rms, largest : float, of its heavy atoms; isOtherRotamer : bool
    """

    residue: str
    trace: float
    rms: float
    largest: float
    isOtherRotamer: bool


class Changes(NamedTuple):
    """The changes of a model.

    residues : list of ResidueShift; traceRms, traceLargest, rms, largest : float, nm, of Cα or P and of heavy atoms
    rotamersChanged, rotamers : int
    """

    residues: list[ResidueShift]
    traceRms: float
    traceLargest: float
    rms: float
    largest: float
    rotamersChanged: int
    rotamers: int


def describeChanges(topology, before, after, torsions):
    """Return the Changes of a Topology from positions before to positions after, (n, 3) in nm.

    torsions : list of Torsion, whose χ1 and χ2 are compared
    """
    shifts = np.linalg.norm(after - before, axis=1)
    changed, withRotamer = set(), set()
    for torsion in torsions:
        if torsion.kind in ("chi1", "chi2"):
            atoms = list(torsion.particles)
            withRotamer.add(torsion.residue.index)
            if turnBetween(dihedral(before[atoms]), dihedral(after[atoms])) > _OTHER_ROTAMER:
                changed.add(torsion.residue.index)
    rows, traces, heavy = [], [], []
    for residue in topology.residues():
        atoms = [a for a in residue.atoms() if a.element is not None and a.element.atomic_number > _HYDROGEN]
        if not atoms:
            continue
        own = shifts[[atom.index for atom in atoms]]
        trace = [atom.index for atom in atoms if atom.name in ("CA", "P")] if polymerBackbone(residue) else []
        ofTrace = float(shifts[trace[0]]) if trace else float("nan")
        traces += trace[:1]
        heavy += [atom.index for atom in atoms]
        isOther = residue.index in changed
        rms = float(np.sqrt((own**2).mean()))
        rows.append(ResidueShift(describeResidue(residue), ofTrace, rms, float(own.max()), isOther))
    ofTraces, ofHeavy = _rmsAndLargest(shifts[traces]), _rmsAndLargest(shifts[heavy])
    return Changes(rows, *ofTraces, *ofHeavy, len(changed), len(withRotamer))


def _rmsAndLargest(values):
    if len(values) == 0:
        return 0.0, 0.0
    return float(np.sqrt((values**2).mean())), float(values.max())
