"""Trials that the program ran, for contestants in Python to run again."""

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np
from openmmchaintree import StericExclusionForce


class Trial(NamedTuple):
    """A turn of one torsion by an angle (rad), and whether it makes a clash."""

    torsion: int
    angle: float
    clash: bool


class Recording(NamedTuple):
    """A scene, and trials from its first state on; each that makes no clash was taken over.

    positions : (n, 3) float64 array, nm
    radii : (n,) float64 array, nm
    names : (n,) int array, the numbers that the particles have in the scene's source
    torsions : (m, 4) int array, rows of near, far, first, last: a torsion turns the particles first … last - 1 about
        the line from particle near to particle far
    exclusions : (k, 2) int array
    trials : list of Trial
    """

    positions: np.ndarray
    radii: np.ndarray
    names: np.ndarray
    torsions: np.ndarray
    exclusions: np.ndarray
    trials: list[Trial]


def readRecording(path):
    """Read what the program wrote of trials of single torsions."""
    scene, *trials = [json.loads(line) for line in Path(path).read_text(encoding="ascii").splitlines()]
    particles = np.array(scene["particles"], dtype=np.float64)
    return Recording(
        positions=np.ascontiguousarray(particles[:, :3]),
        radii=particles[:, 3].copy(),
        names=np.array(scene["names"], dtype=int),
        torsions=np.array(scene["torsions"], dtype=int),
        exclusions=np.array(scene["exclusions"], dtype=int).reshape(-1, 2),
        trials=[Trial(*trial["turns"][0], trial["clash"]) for trial in trials],
    )


def makeForce(recording):
    """Return the StericExclusionForce of a Recording, whose torsions have the numbers that they have there."""
    force = StericExclusionForce()
    for radius in recording.radii.tolist():
        force.addParticle(radius)
    force.setOverlapTolerance(0)
    force.setHydrogenBondAllowance(0)
    neighbors = [[] for _ in recording.radii]

    def bond(particle1, particle2):
        force.addBond(particle1, particle2)
        neighbors[particle1].append(particle2)
        neighbors[particle2].append(particle1)

    # A particle belongs to the link of the last torsion, in the order of their first particles, that turns it.
    links = np.full(len(recording.radii), -1)
    torsions = recording.torsions
    for torsion in np.lexsort((-torsions[:, 3], torsions[:, 2])).tolist():
        links[slice(*torsions[torsion, 2:])] = torsion
    for link in np.unique(links):
        members = np.flatnonzero(links == link).tolist()
        for pair in zip(members, members[1:], strict=False):
            bond(*pair)
    for near, far, _, _ in torsions.tolist():
        bond(near, far)
    for near, far, _, _ in torsions.tolist():
        before = next(particle for particle in neighbors[near] if particle != far)
        after = next(particle for particle in neighbors[far] if particle != near)
        force.addTorsion(before, near, far, after)
    for pair in recording.exclusions.tolist():
        force.addExclusion(*pair)
    return force
