"""Backbones of proteins as the program reads them that solves closures."""

import numpy as np

_ATOMS = ("N", "CA", "C")
_LONGEST_BOND = 0.2  # nm


def describeBackbones(topology, positions):
    """Return a line for each residue, of its atoms' places and of whether phi and psi are free; empty ones part chains.

    Parameters
    ----------
    topology : openmm.app.Topology
    positions : (n, 3) array, nm
    """
    lines, former = [], None
    for residue in topology.residues():
        places = {atom.name: positions[atom.index] for atom in residue.atoms()}
        if not set(_ATOMS) <= places.keys():
            former = None
            continue
        backbone = np.array([places[name] for name in _ATOMS])
        isBound = former is not None and np.linalg.norm(backbone[0] - former) < _LONGEST_BOND
        if not isBound:
            lines.append("")
        phi = int(isBound and residue.name != "PRO")  # that of a proline is in a ring
        lines.append(" ".join([*(f"{x:.17g}" for x in backbone.ravel()), f"{phi} 1"]))
        former = backbone[2]
    return "\n".join(lines) + "\n"
