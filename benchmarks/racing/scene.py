"""A StericExclusionForce as the contestants' program reads it: spheres in rigid links that hang on each other."""

from collections import deque
from typing import NamedTuple

import numpy as np
from openmmchaintree.bonds import neighborLists


class Link(NamedTuple):
    """A rigid set of particles.

    parent : int, the link that it hangs on; near, far : the particles, of the parent and its own, on the axis that
    turns it; isSideChain : bool; -1, -1, -1, False for a link at rest
    """

    parent: int
    near: int
    far: int
    isSideChain: bool


class Scene(NamedTuple):
    """What the program's contestants move.

    spheres : (n, 4) float64 array, positions and radii, nm; particleLinks : (n,) int array; links : list of Link;
    exclusions : (m, 2) int array
    """

    spheres: np.ndarray
    particleLinks: np.ndarray
    links: list[Link]
    exclusions: np.ndarray

    def countTorsions(self, ofSideChains):
        """Return the number of torsions of side chains, or of those of the backbone."""
        return sum(link.parent >= 0 and link.isSideChain == ofSideChains for link in self.links)

    def write(self, path):
        """Write the scene as a file for the program."""
        with open(path, "w", encoding="ascii") as file:
            counts = f"particles {len(self.spheres)} links {len(self.links)} exclusions {len(self.exclusions)}"
            print(f"chaintree-scene 1\n{counts}", file=file)
            for sphere, link in zip(self.spheres.tolist(), self.particleLinks.tolist(), strict=True):
                print(*map(repr, sphere), link, file=file)
            for link in self.links:
                print(link.parent, link.near, link.far, int(link.isSideChain), file=file)
            for pair in self.exclusions.tolist():
                print(*pair, file=file)


def makeScene(force, positions, sideChains):
    """Make the Scene of a force in which every pair has the same tolerance, and every particle a radius above it.

    Parameters
    ----------
    force : StericExclusionForce
    positions : (n, 3) float64 array
        nm
    sideChains : list of bool
        of each torsion of the force, whether it belongs to a side chain

    Returns
    -------
    Scene
        with the indices of particles that the force has. A pair clashes in it if it does for the force: its spheres are
        smaller by half the tolerance.
    """
    tolerance = force.getOverlapTolerance()
    parameters = [force.getParticleParameters(i) for i in range(force.getNumParticles())]
    radii = np.array([radius.value_in_unit(radius.unit) for radius, _ in parameters])
    radii -= tolerance.value_in_unit(tolerance.unit) / 2
    exclusions = [force.getExclusionParticles(i) for i in range(force.getNumExclusions())]
    particleLinks, links = findLinks(force, sideChains)
    return Scene(np.column_stack([positions, radii]), particleLinks, links, np.array(exclusions).reshape(-1, 2))


def findLinks(force, sideChains):
    """Return the link of each particle, as an int array, and the Links of a StericExclusionForce without fixed ones.

    This walks over the bonds from the lowest-numbered particle of each molecule; a torsion leads to the next link.
    """
    neighbors = neighborLists(force.getNumParticles(), map(force.getBondParticles, range(force.getNumBonds())))
    axes = [force.getTorsionParticles(i)[1:3] for i in range(force.getNumTorsions())]
    torsions = {frozenset(axis): isSideChain for axis, isSideChain in zip(axes, sideChains, strict=True)}
    particleLinks = np.full(force.getNumParticles(), -1)
    links = []
    for root in range(force.getNumParticles()):
        if particleLinks[root] >= 0:
            continue
        particleLinks[root] = len(links)
        links.append(Link(-1, -1, -1, False))
        pending = deque([root])
        while pending:
            particle = pending.popleft()
            for other in neighbors[particle]:
                if particleLinks[other] >= 0:
                    continue
                axis = frozenset((particle, other))
                if axis in torsions:
                    particleLinks[other] = len(links)
                    links.append(Link(int(particleLinks[particle]), particle, other, torsions[axis]))
                else:
                    particleLinks[other] = particleLinks[particle]
                pending.append(other)
    return particleLinks, links
