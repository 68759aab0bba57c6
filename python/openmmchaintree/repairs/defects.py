"""Defects that torsions cannot mend: broken bonds, bonds that pierce rings, and twisted peptides."""

from typing import NamedTuple

import numpy as np

from ..naming import describeResidue, nameAtom
from ..scoring.covalentfaults import covalentFaults
from .angles import dihedral

BROKEN, PIERCED, TWISTED = "broken bond", "pierced ring", "twisted peptide"
_TWISTED = 30  # degrees from cis or trans


class Defect(NamedTuple):
    """A defect. kind : str, BROKEN, PIERCED or TWISTED; atoms : tuple of int, that define it; text : str, in words"""

    kind: str
    atoms: tuple[int, ...]
    text: str


def findDefects(topology, positions, torsions):
    """Return the list of Defect of a Topology at positions (nm), (n, 3). torsions : list of Torsion"""
    faults = covalentFaults(topology, positions)
    atoms = list(topology.atoms())
    found = []
    for first, second, length in faults.brokenBonds:
        found.append(Defect(BROKEN, (first, second), f"{_pairName(atoms, first, second)}, {length:.3f} nm"))
    for ring, first, second in faults.piercedRings:
        text = f"{_pairName(atoms, first, second)} through the ring of {describeResidue(atoms[ring[0]].residue)}"
        found.append(Defect(PIERCED, (first, second, *ring), text))
    for torsion in torsions:
        if torsion.kind == "omega":
            angle = np.degrees(dihedral(positions[list(torsion.particles)]))
            if _TWISTED < abs(angle) < 180 - _TWISTED:
                bond = torsion.particles[1:3]
                found.append(Defect(TWISTED, bond, f"{_pairName(atoms, *bond)}, {angle:.0f}°"))
    return found


def _pairName(atoms, first, second):
    return f"{nameAtom(atoms[first])} – {nameAtom(atoms[second])}"
