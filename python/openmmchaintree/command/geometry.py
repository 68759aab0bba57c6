"""Dihedrals and radius of gyration, computed from positions."""

import numpy as np


def dihedrals(positions, particles):
    """Return the IUPAC dihedrals, in (−π, π] rad, of m quadruples of particles.

    positions : (n, 3) float64 array, nm; particles : (m, 4) int array
    """
    first, second, third, fourth = (positions[particles[:, k]] for k in range(4))
    axis = third - second
    normal1 = np.cross(second - first, axis)
    normal2 = np.cross(axis, fourth - third)
    sine = np.einsum("ij,ij->i", np.linalg.norm(axis, axis=1)[:, None] * (second - first), normal2)
    return np.arctan2(sine, np.einsum("ij,ij->i", normal1, normal2))


def radiusOfGyration(positions, masses):
    """Return the mass-weighted radius of gyration (nm) of n particles."""
    centred = positions - np.average(positions, axis=0, weights=masses)
    return float(np.sqrt(np.average((centred**2).sum(axis=1), weights=masses)))
