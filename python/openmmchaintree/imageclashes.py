"""Clashes between periodic images. They do not count as clashes, but a note lists them."""

import numpy as np

from .covalent import nearPairs
from .images import isBox, nearestImage, pairsOfImages
from .notes import Note
from .plainspheres import PlainSpheres

WITH_IMAGES = "clashes with periodic images, which do not count (see --periodic)"


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
    modelled, radii = spheres.modelled, spheres.radii
    pairs = modelled[pairsOfImages(positions[modelled], box, spheres.reach, nearPairs)]
    first, second = pairs.T
    direct = positions[second] - positions[first]
    nearest = nearestImage(direct, box)
    distances = np.linalg.norm(nearest, axis=1)
    clashes = radii[first] + radii[second] - distances > spheres.tolerances(first, second)
    clashes &= (nearest != direct).any(axis=1)
    if not clashes.any():
        return []  # reading exclusions takes long
    clashes[clashes] = ~spheres.areExcluded(pairs[clashes])
    return list(zip(*pairs[clashes].T.tolist(), distances[clashes].tolist(), strict=True))
