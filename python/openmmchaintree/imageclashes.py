"""Clashes between periodic images. They do not count as clashes, but a note lists them."""

from itertools import product

import numpy as np

from .covalent import nearPairs
from .images import isBox
from .notes import Note
from .plainspheres import PlainSpheres

# Images are searched up to this number of boxes away: a molecule that is wider has a wrong box.
_FARTHEST = 2

WITH_IMAGES = "clashes with periodic images, which do not count"


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
    return Note(WITH_IMAGES, items)


def _clashesAcross(force, positions, box):
    """Return (atom, atom, distance) of each pair that would clash if images counted."""
    spheres = PlainSpheres(force)
    radii, modelled, reach = spheres.radii, spheres.modelled, spheres.reach
    found = []
    for shift in _shifts(positions[modelled], box, reach):
        first, second = (modelled[ends] for ends in _nearPairs(positions[modelled], shift, reach))
        distances = np.linalg.norm(positions[second] + shift - positions[first], axis=1)
        clashes = radii[first] + radii[second] - distances > spheres.tolerances(first, second)
        found += zip(first[clashes].tolist(), second[clashes].tolist(), distances[clashes].tolist(), strict=True)
    if not found:
        return []
    ordered = sorted((min(first, second), max(first, second), distance) for first, second, distance in found)
    areExcluded = spheres.areExcluded(np.array([clash[:2] for clash in ordered]))
    return [clash for clash, isExcluded in zip(ordered, areExcluded, strict=True) if not isExcluded]


def _shifts(positions, box, reach):
    """Return the shifts to images that come near, one of each pair of opposite shifts."""
    if len(positions) == 0:
        return []
    inverse = np.linalg.inv(box)
    fractions = positions @ inverse
    spans = np.ptp(fractions, axis=0) + reach * np.linalg.norm(inverse, axis=0)
    most = np.minimum(np.floor(spans), _FARTHEST).astype(int)
    turns = [turn for turn in product(*(range(-count, count + 1) for count in most)) if turn > (0, 0, 0)]
    return [np.array(turn) @ box for turn in turns]


def _nearPairs(positions, shift, reach):
    """Return the positions, and the positions shifted, that are within a reach of each other, as two int arrays."""
    images = positions + shift
    near, nearImages = _within(positions, images, reach), _within(images, positions, reach)
    pairs = nearPairs(np.concatenate([positions[near], images[nearImages]]), reach)
    first, second = pairs[(pairs[:, 0] < len(near)) & (pairs[:, 1] >= len(near))].T
    return near[first], nearImages[second - len(near)]


def _within(points, others, reach):
    """Return the indices of the points within a reach of the box around other points."""
    low, high = others.min(axis=0) - reach, others.max(axis=0) + reach
    return np.flatnonzero(((low <= points) & (points <= high)).all(axis=1))
