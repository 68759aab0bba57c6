"""The series of a run: energies, shapes and torsion angles along its chains, read from its files."""

from typing import NamedTuple

import numpy as np

from .geometry import dihedrals
from .outputs.trajectories import readPositions

_MEASURED = ("potentialEnergy", "radiusOfGyration", "endToEndDistance", "rmsd")

# Longer series are thinned: estimates of all torsions would take longer than the run.
_LONGEST, _MOST_VALUES, _SHORTEST = 2000, 8000, 500  # of one chain, of all chains; of one of many chains


class Group(NamedTuple):
    """The chains of one distribution: those of independent replicas, or one of a temperature.

    temperature : float, K; None without exchange
    rows : list of int arrays, rows of the index, of each chain
    measured : dict, lists of arrays, a chain each; energies in kJ/mol, lengths in nm
    angles : list of float32 arrays, (values, torsions), rad, a chain each
    """

    temperature: float | None
    rows: list[np.ndarray]
    measured: dict[str, list[np.ndarray]]
    angles: list[np.ndarray]


class Series(NamedTuple):
    """All series of a run, without its start.

    groups : list of Group; interval : int, trials between values; frames : int, frames between values
    """

    groups: list[Group]
    interval: int
    frames: int


def readSeries(sampling, plan, index, trajectories, byTemperature, longest=0):
    """Return the Series of a run.

    Parameters
    ----------
    sampling : Sampling
    plan : RunPlan
    index : dict of arrays
        from `readIndex`
    trajectories : list of path
        of each temperature if byTemperature is true, else of each replica
    longest : int
        the least number of values up to which a chain is not thinned
    """
    replicas = len(plan.seeds)
    frames = len(index["frame"]) // replicas
    longest = max(longest, _SHORTEST, min(_LONGEST, _MOST_VALUES // replicas))
    step = max(1, -(-(frames - 1) // longest))
    kept = np.arange(step, frames, step)
    particles = np.array([torsion.particles for torsion in sampling.torsions], dtype=int).reshape(-1, 4)
    topology = sampling.structure.topology
    angles = [_readAngles(path, topology, frames, step, particles) for path in trajectories]
    # Rows of the index are sorted by frame, then by replica.
    table = np.arange(frames * replicas).reshape(frames, replicas)[kept]
    if not plan.isExchange:
        groups = [_group(None, index, list(table.T), angles)]
        return Series(groups, step * plan.schedule.interval, step)
    groups = []
    for number, temperature in enumerate(plan.temperatures):
        places = index["temperature"][table] == temperature
        rows, replica = table[places], np.nonzero(places)[1]
        if byTemperature:
            chain = angles[number]
        else:
            chain = np.array([angles[one][place] for place, one in enumerate(replica)]).reshape(len(kept), -1)
        groups.append(_group(temperature, index, [rows], [chain]))
    return Series(groups, step * plan.schedule.interval, step)


def _group(temperature, index, rows, angles):
    measured = {name: [index[name][chain] for chain in rows] for name in _MEASURED if not np.isnan(index[name]).all()}
    return Group(temperature, rows, measured, angles)


def _readAngles(path, topology, frames, step, particles):
    positions = readPositions(path, topology, frames, step)
    next(positions, None)  # the start
    angles = [dihedrals(frame, particles) for frame in positions]
    return np.array(angles, dtype=np.float32).reshape(len(angles), len(particles))
