"""Notes on images and copies that do not count, with the clashes between periodic images."""

import numpy as np

from .covalent import nearPairs
from .images import isBox, nearestImage, pairsOfImages
from .notes import Note
from .plainspheres import PlainSpheres

_SEE = "which do not count (see --periodic)"


def noteOnImages(force, positions, box, names, spaceGroup=""):
    """Return a Note that images or copies do not count; it lists the pairs of atoms that clash across a periodic box.

    Parameters
    ----------
    force : StericExclusionForce
    positions : (n, 3) float64 array, nm, with molecules made whole
    box : (3, 3) array, nm, a vector a row; None without one
    names : list of AtomName
    spaceGroup : str, the space group of a crystal, empty if all its copies are periodic images

    Returns
    -------
    Note, or None without box and space group
    """
    clashes = [] if box is None or not isBox(box) else _clashesAcross(force, positions, box)
    if clashes:
        items = [f"{names[first]} – {names[second]}, {distance:.3f} nm" for first, second, distance in clashes]
        return Note(f"clashes with periodic images, {_SEE}", items)
    if spaceGroup:
        return Note(f"the file is of a crystal ({spaceGroup}), whose copies do not count (see clashes --symmetry)")
    return None if box is None else Note(f"the file has a periodic box, the images of {_SEE}")


def noteOnOtherCopies(spaceGroup):
    """Return a Note that only periodic images count of the copies in a crystal; spaceGroup : str"""
    return Note(f"of the copies of the crystal ({spaceGroup}), only images of its cell count (see clashes --symmetry)")


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
