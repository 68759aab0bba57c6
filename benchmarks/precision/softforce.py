"""Energy and forces of spheres in a crowd, against sums in long double."""

import copy
import itertools
from typing import NamedTuple

import numpy as np
from openmm import unit
from openmmchaintree import StericExclusionForce
from racing.course import measure, summarizeTimes
from racing.interface import makeCustomForce
from racing.platforms import CPU, makeContext, whyNot

# Spheres stand on a cubic lattice, each shifted along each axis by up to so much (nm).
_SPACING, _SHIFT = 0.25, 0.05
_RADII = 0.1, 0.2
_REPEATS = 5


class Crowd(NamedTuple):
    """Spheres, many of which overlap.

    positions : (n, 3) float64 array, nm; radii : (n,) float64 array, nm; force : StericExclusionForce
    pairs : (m, 2) int array, all pairs that may overlap, and others
    """

    positions: np.ndarray
    radii: np.ndarray
    force: StericExclusionForce
    pairs: np.ndarray


def whyNoReference():
    """Return why there are no numbers that are longer than double; None if there are."""
    if np.finfo(np.longdouble).nmant <= np.finfo(np.float64).nmant:
        return "the long double of this machine is no longer than its double"
    return None


def makeCrowd(size, seed):
    """Make a Crowd of so many spheres."""
    generator = np.random.default_rng(seed)
    side = int(np.ceil(size ** (1 / 3)))
    sites = np.stack(np.unravel_index(np.arange(size), (side, side, side)), axis=1)
    positions = _SPACING * sites + generator.uniform(-_SHIFT, _SHIFT, (size, 3))
    radii = generator.uniform(*_RADII, size)
    force = StericExclusionForce()
    for radius in radii:
        force.addParticle(radius)
    return Crowd(positions, radii, force, _findPairs(sites, side))


def _findPairs(sites, side):
    """Return the pairs of sites whose spheres can reach each other."""
    reach = (2 * max(_RADII) + 2 * _SHIFT * np.sqrt(3)) / _SPACING
    steps = range(-int(reach), int(reach) + 1)
    indices = np.full((side, side, side), -1)
    indices[tuple(sites.T)] = np.arange(len(sites))
    found = []
    for offset in itertools.product(steps, repeat=3):
        if offset <= (0, 0, 0) or np.linalg.norm(offset) > reach:  # of two opposite steps one
            continue
        others = sites + offset
        isInside = np.all((others >= 0) & (others < side), axis=1)
        second = np.where(isInside, indices[tuple(np.where(isInside[:, None], others, 0).T)], -1)
        first = np.flatnonzero(second >= 0)
        found.append(np.stack([first, second[first]], axis=1))
    return np.concatenate(found)


def exactForces(crowd):
    """Return the energy (kJ/mol) and the (n, 3) forces (kJ/mol/nm) in long double."""
    k = np.longdouble(_plain(crowd.force.getForceConstant()))
    tolerance = np.longdouble(_plain(crowd.force.getOverlapTolerance()))
    x = crowd.positions.astype(np.longdouble)
    r = crowd.radii.astype(np.longdouble)
    first, second = crowd.pairs.T
    apart = x[first] - x[second]
    distances = np.sqrt((apart**2).sum(axis=1))
    depths = np.maximum(r[first] + r[second] - distances - tolerance, 0)
    pulls = apart * (k * depths / distances)[:, None]
    forces = np.zeros_like(x)
    np.add.at(forces, first, pulls)
    np.subtract.at(forces, second, pulls)
    return k / 2 * (depths**2).sum(), forces


def measureForces(size, seed):
    """Return an entry for each force on each platform: its time, and its errors.

    Errors of energies are relative to the energy, those of forces to the root mean square of a sphere's force.
    """
    crowd = makeCrowd(size, seed)
    energy, forces = exactForces(crowd)
    scale = np.sqrt((forces**2).sum(axis=1).mean())
    entries = []
    for name, platform, force in _contestants(crowd.force):
        context = makeContext(platform, size, force)
        times = []
        for _ in range(_REPEATS):
            context.setPositions(crowd.positions)
            state, time = measure(lambda: context.getState(energy=True, forces=True))  # noqa: B023
            times.append(time)
        found = state.getForces(asNumpy=True).value_in_unit(unit.kilojoule_per_mole / unit.nanometer)
        errors = np.sqrt(((found.astype(np.longdouble) - forces) ** 2).sum(axis=1)) / scale
        entries.append(
            {
                "particles": size,
                "contestant": name,
                **summarizeTimes(times),
                "energy": float(energy),
                "energyError": float(abs(_plain(state.getPotentialEnergy()) - energy) / energy),
                "forceError": {"largest": float(errors.max()), "rms": float(np.sqrt((errors**2).mean()))},
            }
        )
    return entries


def _contestants(force):
    """Yield (name, platform, force)."""
    for platform in ("Reference", CPU):
        if platform != CPU or whyNot(CPU) is None:
            yield f"ours, {platform}", platform, copy.copy(force)
            yield f"CustomNonbondedForce, {platform}", platform, makeCustomForce(force)


def _plain(quantity):
    return quantity.value_in_unit(quantity.unit)
