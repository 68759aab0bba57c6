"""A StericExclusionForce as the contestants' program reads it: spheres in rigid links that hang on each other."""

import copy
from collections import deque
from typing import NamedTuple

import numpy as np
import openmm


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
        """Return the number of torsions of side chains, or of backbones."""
        return sum(link.parent >= 0 and link.isSideChain == ofSideChains for link in self.links)

    def movedBy(self):
        """Return the axis of each torsion, and the particles that it turns."""
        children = [[] for _ in self.links]
        for number, link in enumerate(self.links):
            if link.parent >= 0:
                children[link.parent].append(number)
        moved = []
        for number, link in enumerate(self.links):
            if link.parent >= 0:
                behind = [number]
                for other in behind:
                    behind += children[other]
                moved.append(((link.near, link.far), np.flatnonzero(np.isin(self.particleLinks, behind))))
        return moved

    def write(self, path):
        """Write the scene as a file for the program: depth-first, the heaviest branch last."""
        order, ends = self._walk()
        ranks = np.argsort(order)  # of links
        particles = np.argsort(ranks[self.particleLinks], kind="stable")
        places = np.argsort(particles)
        begins = np.searchsorted(ranks[self.particleLinks][particles], np.arange(len(order) + 1))
        with open(path, "w", encoding="ascii") as file:
            counts = f"particles {len(self.spheres)} links {len(self.links)} exclusions {len(self.exclusions)}"
            print(f"chaintree-scene 2\n{counts}", file=file)
            for name in particles.tolist():
                print(*map(repr, self.spheres[name].tolist()), ranks[self.particleLinks[name]], name, file=file)
            for rank, number in enumerate(order):
                parent, near, far, isSideChain = self.links[number]
                if parent < 0:
                    print("-1 -1 -1 0 0 0", file=file)
                else:
                    interval = begins[rank], begins[ends[rank]]
                    print(ranks[parent], places[near], places[far], *interval, int(isSideChain), file=file)
            for pair in self.exclusions:
                print(*places[pair], file=file)

    def _walk(self):
        """Return the links in the order of a walk, and where in it each link ends, with all that hangs on it."""
        children = [[] for _ in self.links]
        weights = np.bincount(self.particleLinks, minlength=len(self.links))
        for number in reversed(range(len(self.links))):  # parents have lower numbers
            parent = self.links[number].parent
            if parent >= 0:
                children[parent].append(number)
                weights[parent] += weights[number]
        order, pending = [], [number for number, link in enumerate(self.links) if link.parent < 0][::-1]
        while pending:
            order.append(pending.pop())
            # The heaviest, which comes last, is the deepest in the stack.
            pending += sorted(children[order[-1]], key=lambda child: -weights[child])
        sizes = np.ones(len(order), dtype=int)  # in links
        for number in reversed(range(len(self.links))):
            if self.links[number].parent >= 0:
                sizes[self.links[number].parent] += sizes[number]
        return order, np.arange(len(order)) + sizes[order]


def makeContext(platformName, particleCount, *forces):
    """Make a Context, for one thread, of particles with some forces."""
    system = openmm.System()
    for _ in range(particleCount):
        system.addParticle(1.0)
    for force in forces:
        system.addForce(force)
    properties = {"Threads": "1"} if platformName == "CPU" else {}
    platform = openmm.Platform.getPlatformByName(platformName)
    return openmm.Context(system, openmm.VerletIntegrator(0.001), platform, properties)


def excludeClashes(force, positions):
    """Return a copy of a force without the roles of atoms in hydrogen bonds, in which pairs that clash are excluded."""
    force = copy.copy(force)
    force.setHydrogenBondAllowance(0)
    probe = copy.copy(force)
    context = makeContext("Reference", len(positions), probe)
    context.setPositions(positions)
    for pair in probe.getClashes(context)[0].tolist():
        force.addExclusion(*pair)
    return force


def makeScene(force, positions, sideChains):
    """Make the Scene of a force in which every pair has the same tolerance.

    A pair clashes in it if it clashes for the force: its spheres are smaller by half the tolerance.

    Parameters
    ----------
    positions : (n, 3) float64 array, nm
    sideChains : list of bool, of each torsion of the force, whether it belongs to a side chain
    """
    tolerance = force.getOverlapTolerance()
    radii = [force.getParticleParameters(i)[0] for i in range(force.getNumParticles())]
    radii = np.array([radius._value for radius in radii]) - tolerance._value / 2
    exclusions = [force.getExclusionParticles(i) for i in range(force.getNumExclusions())]
    particleLinks, links = findLinks(force, sideChains)
    return Scene(np.column_stack([positions, radii]), particleLinks, links, np.array(exclusions).reshape(-1, 2))


def findLinks(force, sideChains):
    """Return the link of each particle, as an int array, and the Links of a StericExclusionForce without fixed ones.

    This walks over the bonds from the lowest-numbered particle of each molecule; a torsion leads to the next link.
    """
    neighbors = [[] for _ in range(force.getNumParticles())]
    for one, other in map(force.getBondParticles, range(force.getNumBonds())):
        neighbors[one].append(other)
        neighbors[other].append(one)
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
