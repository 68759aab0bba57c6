"""Positions in which the bonds of ball joints have given lengths."""

import numpy as np

from .graphs import connectedParts
from .openmmchaintree import StericExclusionForce
from .units import Array, inUnit, positionsInNm


def setBondLengths(force: StericExclusionForce, positions: Array, bondLength: Array) -> np.ndarray:
    """Return positions in which the bonds of ball joints have given lengths, and their directions.

    Trials keep the lengths of bonds, so harmonic bonds of beads have the length of the first positions. In a simulation
    their mean is larger than the length of least energy, by 0.7 % in CALVADOS 2:

        force = createStericExclusionForce(topology, positions, system=system)
        positions = setBondLengths(force, positions, 0.3825)

    Everything behind a joint is shifted, so beads may overlap afterwards. Fixed particles behind a joint are shifted,
    too, unless joints lead away from them, as `createStericExclusionForce` makes them.

    Parameters
    ----------
    force : StericExclusionForce
    positions : array of shape (n, 3) or Quantity
        nm; molecules must not be split over a periodic box
    bondLength : float, array of shape (m) or Quantity
        nm, one length for all ball joints of the force or one for each

    Returns
    -------
    numpy array of shape (n, 3)
        nm

    Raises
    ------
    ValueError
        if a length is not positive, their number is wrong, or two bonded particles are at one place
    """
    count = force.getNumParticles()
    positions = positionsInNm(positions, count)
    joints = np.array([force.getBallJointParticles(i) for i in range(force.getNumBallJoints())], dtype=int)
    joints = joints.reshape(-1, 2)
    lengths = np.asarray(inUnit(bondLength, "nm", "bondLength"), dtype=np.float64)
    if lengths.ndim > 0 and lengths.shape != (len(joints),):
        raise ValueError(f"bondLength must be a number or have the shape ({len(joints)},), not {lengths.shape}")
    if not (lengths > 0).all():
        raise ValueError("bondLength must be above 0")
    vectors = positions[joints[:, 1]] - positions[joints[:, 0]]
    present = np.linalg.norm(vectors, axis=1)
    if not (present > 0).all():
        pair = joints[np.argmin(present)].tolist()
        raise ValueError(
            f"particles {pair[0]} and {pair[1]} are bonded, but at one place, so that the bond has no direction"
        )
    changes = (lengths / present - 1)[:, np.newaxis] * vectors
    turning = {frozenset(pair) for pair in joints.tolist()}
    bonds = [force.getBondParticles(i) for i in range(force.getNumBonds())]
    linkOf = connectedParts(count, [pair for pair in bonds if frozenset(pair) not in turning])
    return positions + _sumsAlongChains(linkOf, joints, changes)[linkOf]


def _sumsAlongChains(linkOf, joints, changes):
    """Return for each link the sum of the changes of the joints between it and the root of its molecule."""
    parents, links = linkOf[joints].T.tolist()
    above = {link: (parent, joint) for joint, (parent, link) in enumerate(zip(parents, links, strict=True))}
    sums = np.zeros((int(linkOf.max(initial=-1)) + 1, 3))
    isDone = set()
    for link in above:
        path = []
        while link in above and link not in isDone:
            path.append(link)
            link = above[link][0]
        for each in reversed(path):
            parent, joint = above[each]
            sums[each] = sums[parent] + changes[joint]
            isDone.add(each)
    return sums
