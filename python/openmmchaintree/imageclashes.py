"""Clashes between periodic images, which nothing counts: so that they can be told."""

from itertools import product

import numpy as np
from openmm import unit

from .images import isBox
from .notes import Note
from .openmmchaintree import StericExclusionForce

# So many boxes away images are looked at, at most: a molecule that is wider than that has a wrong box.
_FARTHEST = 2

_DONOR, _ACCEPTOR = StericExclusionForce.Donor, StericExclusionForce.Acceptor


def noteOnImages(force, positions, box, names):
    """Return a Note on pairs of atoms that clash across a periodic box.

    Parameters
    ----------
    force : StericExclusionForce
    positions : (n, 3) float64 array, nm, with molecules made whole
    box : (3, 3) array, nm, a vector a row; None without one
    names : list of AtomName
    """
    clashes = [] if box is None or not isBox(box) else _clashesAcross(force, positions, box)
    items = [f"{names[first]} – {names[second]}, {distance:.3f} nm" for first, second, distance in clashes]
    return Note("clashes with periodic images, which do not count", items)


def _clashesAcross(force, positions, box):
    """Return (atom, atom, distance) of the pairs that would clash if images counted."""
    parameters = [force.getParticleParameters(particle) for particle in range(force.getNumParticles())]
    radii = np.array([radius.value_in_unit(unit.nanometer) for radius, _ in parameters])
    roles = np.array([role for _, role in parameters])
    tolerance = force.getOverlapTolerance().value_in_unit(unit.nanometer)
    allowance = force.getHydrogenBondAllowance().value_in_unit(unit.nanometer)
    modelled = np.flatnonzero(radii > 0)
    reach = 2 * radii.max(initial=0) - tolerance
    found = []
    for shift in _shifts(positions[modelled], box, reach):
        first, second = (modelled[ends] for ends in _nearPairs(positions[modelled], positions[modelled] + shift, reach))
        distances = np.linalg.norm(positions[second] + shift - positions[first], axis=1)
        mayBond = _canDonate(roles[first], roles[second]) | _canDonate(roles[second], roles[first])
        clashes = radii[first] + radii[second] - distances > tolerance + np.where(mayBond, allowance, 0)
        found += zip(first[clashes].tolist(), second[clashes].tolist(), distances[clashes].tolist(), strict=True)
    if not found:
        return []
    excluded = {tuple(sorted(force.getExclusionParticles(i))) for i in range(force.getNumExclusions())}
    ordered = sorted((min(first, second), max(first, second), distance) for first, second, distance in found)
    return [clash for clash in ordered if clash[:2] not in excluded]


def _canDonate(donors, acceptors):
    return ((donors & _DONOR) != 0) & ((acceptors & _ACCEPTOR) != 0)


def _shifts(positions, box, reach):
    """Return the box vectors, one of each pair of opposite ones, by which images come near."""
    if len(positions) == 0:
        return []
    inverse = np.linalg.inv(box)
    fractions = positions @ inverse
    spans = np.ptp(fractions, axis=0) + reach * np.linalg.norm(inverse, axis=0)
    most = np.minimum(np.floor(spans), _FARTHEST).astype(int)
    turns = [turn for turn in product(*(range(-count, count + 1) for count in most)) if turn > (0, 0, 0)]
    return [np.array(turn) @ box for turn in turns]


def _nearPairs(positions, images, reach):
    """Return the indices of positions and images that are within a reach of each other, as two int arrays."""
    near = _within(positions, images, reach), _within(images, positions, reach)
    if not (len(near[0]) and len(near[1])):
        return near[0][:0], near[1][:0]
    from scipy.spatial import cKDTree

    pairs = cKDTree(positions[near[0]]).sparse_distance_matrix(
        cKDTree(images[near[1]]), reach, output_type="coo_matrix"
    )
    return near[0][pairs.row], near[1][pairs.col]


def _within(points, others, reach):
    """Return the indices of the points that are no farther than a reach from the box around others."""
    low, high = others.min(axis=0) - reach, others.max(axis=0) + reach
    return np.flatnonzero(((low <= points) & (points <= high)).all(axis=1))
