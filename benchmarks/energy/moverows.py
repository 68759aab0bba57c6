"""What single moves do from a folded start, and how many independent samples a second mixtures of them give."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from openmm import unit
from openmmchaintree import StericExclusionForce, addDefaultMoves, rotamerDensities
from racing.course import Course, measure, summarizeTimes
from racing.races import ALL_CHAINS, OURS

from .autocorrelation import statisticalInefficiency
from .chain import RMSDS, Chain
from .proteins import BACKBONE, IMPLICIT_SOLVENT, NUCLEOTIDE_BACKBONE, SIDE_CHAINS, positionsOf
from .rows import Prepared

MOVES, MIXTURES = "moves", "mixtures"  # groups of rows

MOVE_TRIALS, MIXTURE_TRIALS = 80000, 400000
STEP = 400  # trials, and an outer test
_LAG = 8000  # trials, after which it is seen how far torsions have turned
_LEAST_SHIFTED, _MOST_SHIFTED = 10, 400  # trials whose shift is measured, each with an outer test of its own
_SHIFTED = 20  # the part of trials that they are in between
_TURN, _LEAST = 25, 2  # steps
_LEFT_OUT = 10  # the first of so many parts of a chain
_SLOW = 0.9  # the quantile of torsions that stands for the slow ones


class Move(NamedTuple):
    """A move of a protein: add(integrator, weight, protein, system) adds it.

    name : str, for tables; turns : BACKBONE, SIDE_CHAINS, or None for all
    """

    name: str
    add: Callable
    turns: str | None = None


def turn(which, degrees):
    """Return the Move that turns one torsion of BACKBONE or SIDE_CHAINS."""
    name = f"{'pivot' if which == BACKBONE else 'χ'}, {degrees}°"
    angle = degrees * unit.degrees
    return Move(
        name, lambda i, weight, protein, system: i.addTorsionMove(weight, angle, protein.torsionsOf(which)), which
    )


def close(degrees, hop=0.2):
    """Return the closed Move of backbones."""
    angle = degrees * unit.degrees
    name = f"closed, {degrees}°" + ("" if hop == 0.2 else f", hop {hop}")
    return Move(
        name,
        lambda i, weight, protein, system: i.addClosedMove(weight, angle, protein.torsionsOf(BACKBONE), hop),
        BACKBONE,
    )


def bend(degrees, stiffness, window=8):
    """Return the local Move of backbones."""
    sigma = degrees * unit.degrees
    name = f"local, {degrees}°, {stiffness} nm⁻²" + ("" if window == 8 else f", window {window}")
    return Move(
        name,
        lambda i, weight, protein, system: i.addLocalMove(
            weight, sigma, stiffness, protein.torsionsOf(BACKBONE), window
        ),
        BACKBONE,
    )


def _draw(integrator, weight, protein, system):
    """Draw side chains from rotamers; bases, which have none, uniformly."""
    if any(torsion.kind == "chi1" for torsion in protein.torsions):
        integrator.addDrawnMove(weight, *rotamerDensities(protein.topology, _forceOf(system)))
    else:
        integrator.addTorsionMove(weight, np.pi, protein.torsionsOf(SIDE_CHAINS))


ROTAMERS = Move("side chains drawn", _draw, SIDE_CHAINS)

DEFAULTS = Move("addDefaultMoves", lambda i, weight, protein, system: addDefaultMoves(i, protein.topology, system))

SINGLE_MOVES = (
    *(turn(BACKBONE, degrees) for degrees in (0.5, 1, 2)),
    *(close(degrees) for degrees in (4, 8, 12)),
    close(8, hop=0.0),
    *(bend(*sizes) for sizes in ((2, 1000), (2, 10000), (4, 3000), (4, 10000))),
    turn(SIDE_CHAINS, 10),
    turn(SIDE_CHAINS, 30),
    ROTAMERS,
)

# Moves by their weights.
PIVOTS = "pivots alone"
ALL_MIXTURES = {
    PIVOTS: ((1.0, turn(BACKBONE, 1)), (1.0, turn(SIDE_CHAINS, 10)), (0.5, turn(SIDE_CHAINS, 180))),
    "pivots, rotamers": ((1.0, turn(BACKBONE, 1)), (0.5, turn(SIDE_CHAINS, 10)), (0.5, ROTAMERS)),
    "closed": ((1.0, close(8)), (0.5, turn(SIDE_CHAINS, 10)), (0.5, ROTAMERS), (0.1, turn(BACKBONE, 1))),
    "local": ((1.0, bend(2, 1000)), (0.5, turn(SIDE_CHAINS, 10)), (0.5, ROTAMERS), (0.1, turn(BACKBONE, 1))),
    "closed, local": (
        (0.7, close(8)),
        (0.4, bend(4, 3000)),
        (0.5, turn(SIDE_CHAINS, 10)),
        (0.5, ROTAMERS),
        (0.1, turn(BACKBONE, 1)),
    ),
    DEFAULTS.name: ((1.0, DEFAULTS),),
}

# Torsions that are looked at together, by their kinds: those of proteins, and of nucleic acids.
WATCHED = {"phi": ("phi",), "psi": ("psi",), "chi1": ("chi1",), "backbone": NUCLEOTIDE_BACKBONE, "bases": ("chi",)}


def _forceOf(system):
    return next(StericExclusionForce.cast(one) for one in system.getForces() if StericExclusionForce.isinstance(one))


def makeChain(protein, system, seed, name, steps=1):
    """Make a Chain of the mixture of that name, with so many steps between looks."""
    kinds = [kind for ofOne in WATCHED.values() for kind in ofOne]
    return Chain(protein, makeSimulation(protein, system, seed, ALL_MIXTURES[name]), kinds, steps)


def describeChains(name, chains, inefficiencies):
    """Return what an entry says of Chains of the mixture of that name, whose looks are so often worth a sample."""
    times = summarizeTimes([time for chain in chains for time in chain.times])
    apart = summarize(chains[0].trialsPerLook * inefficiencies, chains[0].kinds)
    return {
        "moves": name,
        "trials": sum(chain.count * chain.trialsPerLook for chain in chains),
        **times,
        "kept": float(np.mean([chain.outerTestsKept() for chain in chains])),
        "apart": apart,
        "rate": {key: 1e6 / (times["microseconds"] * value) for key, value in apart.items()},
    }


def makeSimulation(protein, system, seed, moves):
    """Make a Simulation of a SampledProtein and its System with (weight, Move) pairs."""
    simulation = protein.makeSimulationOf(system, seed, moves=())
    for weight, move in moves:
        move.add(simulation.integrator, weight, protein, system)
    simulation.integrator.setTrialsPerStep(STEP)
    return simulation


class MoveRow(NamedTuple):
    """One move alone, from a folded start: its acceptance, how far it moves atoms, its time."""

    name: str
    prepared: Prepared
    moves: Sequence[Move] = SINGLE_MOVES
    trials: int = MOVE_TRIALS
    group: str = MOVES
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return self.name

    def run(self, course: Course, seed: int):
        """Return an entry for each move."""
        trials, protein = course.trials or self.trials, self.prepared.protein
        system = protein.makeSystem(IMPLICIT_SOLVENT)
        return [
            {**describe(self, trials, seed), **_runMove(protein, system, seed, move, trials)} for move in self.moves
        ]


def autocorrelation(angles, lag):
    """Return the mean of cos(θ(t + lag) − θ(t)) over samples t and angles θ: 1 as long as nothing turns.

    It needs no mean of the ensemble, so that a chain tells it long before it has independent samples.

    Parameters
    ----------
    angles : (n, k) float64 array, rad
    lag : int, samples, less than n
    """
    return float(np.cos(angles[lag:] - angles[:-lag]).mean())


def describe(row, trials, seed):
    """Return what entries of a row have in common."""
    return {
        "group": row.group,
        "chain": row.name,
        "method": IMPLICIT_SOLVENT.name,
        "particles": len(row.prepared.protein.positions),
        "seed": seed,
        "asked": trials,
        "contestant": OURS,
    }


def _runMove(protein, system, seed, move, trials):
    simulation = makeSimulation(protein, system, seed, [(1.0, move)])
    integrator, context = simulation.integrator, simulation.context
    simulation.step(1)  # compares energies with OpenMM's
    integrator.resetMoveStatistics()
    turned = slice(None) if move.turns is None else protein.torsionsOf(move.turns)
    times, angles = [], []
    for _ in range(max(_LEAST, trials // STEP)):
        _, microseconds = measure(simulation.step, 1)
        times.append(microseconds / STEP)
        angles.append(integrator.getTorsionAngles(context)[turned])
    lag = min(_LAG // STEP, len(angles) - 1)
    statistics = integrator.getMoveStatistics(0)
    integrator.setTrialsPerStep(1)
    shifts, before = [], positionsOf(context)
    for _ in range(min(_MOST_SHIFTED, max(_LEAST_SHIFTED, trials // _SHIFTED))):
        simulation.step(1)
        after = positionsOf(context)
        shifts.append(float(((after - before) ** 2).sum()))
        before = after
    return {
        "moves": move.name,
        "trials": len(times) * STEP,
        **summarizeTimes(times),
        "attempted": statistics.attempted,
        "clashed": statistics.clashed,
        "rejected": statistics.rejectedByEnergy,
        "accepted": statistics.accepted,
        "shift": float(np.mean(shifts)),
        "lag": lag * STEP,
        "autocorrelation": autocorrelation(np.array(angles), lag),
    }


class MixtureRow(NamedTuple):
    """Chains of mixtures of moves from a folded start, in turns, and how far apart their samples are independent."""

    name: str
    prepared: Prepared
    names: Sequence[str] = tuple(ALL_MIXTURES)
    trials: int = MIXTURE_TRIALS
    group: str = MIXTURES
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return self.name

    def run(self, course: Course, seed: int):
        """Return an entry for each mixture."""
        trials, protein = course.trials or self.trials, self.prepared.protein
        system = protein.makeSystem(IMPLICIT_SOLVENT)
        chains = {name: makeChain(protein, system, seed, name) for name in self.names}
        count = max(_LEAST, min(_TURN, trials // STEP))
        for _ in range(max(1, trials // (count * STEP))):
            for chain in chains.values():
                chain.sample(count)
        kept = {name: chain.values()[chain.count // _LEFT_OUT :] for name, chain in chains.items()}
        mean = np.mean([values.mean(axis=0) for values in kept.values()], axis=0)  # all sample the same
        return [
            {
                **describe(self, trials, seed),
                **describeChains(name, [chain], statisticalInefficiency(kept[name], mean)),
            }
            for name, chain in chains.items()
        ]


def summarize(inefficiencies, kinds):
    """Return how many samples are worth one, for each of WATCHED that there are, slow and slowest torsions, RMSDs.

    Of a torsion that is the worse of cosine and sine; of those of a kind the median.

    Parameters
    ----------
    inefficiencies : (2 + 2k,) float64 array, of RMSDS, of cosines, of sines
    kinds : (k,) array of str
    """
    rmsds = dict(zip(RMSDS, map(float, inefficiencies), strict=False))
    ofTorsions = inefficiencies[len(RMSDS) :].reshape(2, -1).max(axis=0)
    found = {
        name: float(np.median(ofTorsions[np.isin(kinds, ofName)]))
        for name, ofName in WATCHED.items()
        if np.isin(kinds, ofName).any()
    }
    found |= {"slow": float(np.quantile(ofTorsions, _SLOW)), "slowest": float(ofTorsions.max())}
    return {**found, **rmsds}
