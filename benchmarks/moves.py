"""Measure what moves do to folded proteins, and how many independent samples mixtures give; see docs/benchmark.md.

PYTHONPATH=build/package python benchmarks/moves.py --csv moves.csv --markdown moves.md --picture moves.png
"""

import sys
from collections.abc import Callable
from typing import NamedTuple

import mdtraj
import numpy as np
from autocorrelation import leastInefficiency, statisticalInefficiency
from measure import OURS, Row, makeParser, medianTime, run, timed
from movetables import DEFAULTS, PIVOTS, RMSDS, makeTables
from openmm import unit
from openmmchaintree import StericExclusionForce, addDefaultMoves, rotamerDensities
from proteins import (
    BACKBONE,
    IMPLICIT_SOLVENT,
    NUCLEOTIDE_BACKBONE,
    SIDE_CHAINS,
    positionsOf,
    prepare,
)

GROUPS = {
    "moves": "acceptance, shift and time of each move alone",
    "stationary": "independent samples a second by the default moves, and the most that pivots alone can give",
}

_FILES = ("1bna.pdb", "1ubi_h.pdb", "5dfr_h.pdb")
_RUNS, _WARM_TRIALS, _QUICK_TRIALS = 3, 200000, 800
_TRIALS = {"moves": 80000, "stationary": 4000000}

_STEP = 400  # trials, and an outer test
_LEAST = 2  # steps

# Of a single move: trials after which turns of torsions are measured; trials whose shift is measured.
_LAG = 8000
_LEAST_SHIFTED, _MOST_SHIFTED, _SHIFTED_SHARE = 10, 400, 20

_SLOW = 0.9  # the quantile of torsions that stands for the slow ones

# Of the long chain: steps from one look to the next, an even number, as leastInefficiency needs it; the first quarter
# is left out. Chains of pivots begin with states that are evenly spaced in the rest; each is shorter by a factor; their
# changes are looked at up to a share of their length.
_STEPS, _LEFT_OUT, _STARTS, _PART, _LAG_SHARE, _LEAST_LOOKS = 8, 4, 4, 2.5, 0.75, 8

_ENDS = 5  # residues at either end of a chain that may hang loose


class Move(NamedTuple):
    """A move of a protein: add(integrator, weight, protein, system) adds it; `turns` is which torsions it turns."""

    name: str
    add: Callable
    turns: str | None = None


def turn(which, degrees):
    """Return the Move that turns one torsion of BACKBONE or SIDE_CHAINS."""
    name, angle = f"{'pivot' if which == BACKBONE else 'χ'}, {degrees}°", degrees * unit.degrees
    return Move(name, lambda i, weight, one, system: i.addTorsionMove(weight, angle, one.torsionsOf(which)), which)


def close(degrees, hop=0.2):
    """Return the closed Move of backbones."""

    def add(integrator, weight, protein, system):
        integrator.addClosedMove(weight, degrees * unit.degrees, protein.torsionsOf(BACKBONE), hop)

    return Move(f"closed, {degrees}°" + ("" if hop == 0.2 else f", hop {hop}"), add, BACKBONE)


def bend(degrees, stiffness):
    """Return the local Move of backbones."""

    def add(integrator, weight, protein, system):
        integrator.addLocalMove(weight, degrees * unit.degrees, stiffness, protein.torsionsOf(BACKBONE))

    return Move(f"local, {degrees}°, {stiffness} nm⁻²", add, BACKBONE)


def _draw(integrator, weight, protein, system):
    """Draw side chains from rotamers; bases, which have none, uniformly."""
    if any(torsion.kind == "chi1" for torsion in protein.torsions):
        forces = filter(StericExclusionForce.isinstance, system.getForces())
        force = StericExclusionForce.cast(next(forces))
        integrator.addDrawnMove(weight, *rotamerDensities(protein.topology, force))
    else:
        integrator.addTorsionMove(weight, np.pi, protein.torsionsOf(SIDE_CHAINS))


_ROTAMERS = Move("side chains drawn", _draw, SIDE_CHAINS)
SINGLE_MOVES = (
    *(turn(BACKBONE, degrees) for degrees in (0.5, 1, 2)),
    *(close(degrees) for degrees in (4, 8, 12)),
    close(8, hop=0.0),
    *(bend(*sizes) for sizes in ((2, 1000), (2, 10000), (4, 3000), (4, 10000))),
    turn(SIDE_CHAINS, 10),
    turn(SIDE_CHAINS, 30),
    _ROTAMERS,
)

# Moves by their weights.
_MIXTURES = {
    PIVOTS: ((1.0, turn(BACKBONE, 1)), (1.0, turn(SIDE_CHAINS, 10)), (0.5, turn(SIDE_CHAINS, 180))),
    DEFAULTS: ((1.0, Move("", lambda i, weight, one, system: addDefaultMoves(i, one.topology, system))),),
}

# Kinds of torsions that are averaged together, in proteins and in nucleic acids.
_WATCHED = {"phi": ("phi",), "psi": ("psi",), "chi1": ("chi1",), "backbone": NUCLEOTIDE_BACKBONE, "bases": ("chi",)}


def _simulate(protein, system, seed, moves):
    """Return a Simulation of a System with (weight, Move) pairs."""
    simulation = protein.makeSimulation(system, seed, moves=())
    for weight, move in moves:
        move.add(simulation.integrator, weight, protein, system)
    simulation.integrator.setTrialsPerStep(_STEP)
    return simulation


# ---- Each move alone ----


def _moveRow(name, protein, move):
    def measure(course, seed):
        trials, one = course.trials or _TRIALS["moves"], protein()
        simulation = _simulate(one, one.makeSystem(IMPLICIT_SOLVENT), seed, [(1.0, move)])
        integrator, context = simulation.integrator, simulation.context
        simulation.step(1)  # compares energies with OpenMM's
        integrator.resetMoveStatistics()
        turned = one.torsionsOf(move.turns)
        times, angles = [], []
        for _ in range(max(_LEAST, trials // _STEP)):
            times.append(timed(simulation.step, 1)[1] / _STEP)
            angles.append(integrator.getTorsionAngles(context)[turned])
        lag = min(_LAG // _STEP, len(angles) - 1)
        statistics = integrator.getMoveStatistics(0)
        integrator.setTrialsPerStep(1)
        shifts, before = [], positionsOf(context)
        for _ in range(min(_MOST_SHIFTED, max(_LEAST_SHIFTED, trials // _SHIFTED_SHARE))):
            simulation.step(1)
            after = positionsOf(context)
            shifts.append(float(((after - before) ** 2).sum()))
            before = after
        counts = {key: getattr(statistics, key) for key in ("attempted", "clashed", "accepted")}
        found = {"shift": float(np.mean(shifts)), "lag": lag * _STEP}
        found["autocorrelation"] = autocorrelation(np.array(angles), lag)
        return [{**_describe(name, one, move.name), **medianTime(times), **counts, **found}]

    return Row("moves", f"{name}, {move.name}", measure)


def _describe(name, protein, moves):
    method, particles = IMPLICIT_SOLVENT.name, len(protein.positions)
    return {"chain": name, "method": method, "moves": moves, "particles": particles, "contestant": OURS}


def autocorrelation(angles, lag):
    """Return the mean of cos(θ(t + lag) − θ(t)) over samples t and angles θ, an (n, k) array in rad.

    It needs no mean of the ensemble, so that a chain tells it long before it has independent samples.
    """
    return float(np.cos(angles[lag:] - angles[:-lag]).mean())


# ---- Chains from states of the ensemble ----


class Chain:
    """A Simulation of a mixture, and what is looked at of it: torsions of some kinds, and RMSDs of the heavy atoms,
    of all and without the ends of chains, which may hang loose and turn by far more than what is folded.

    kinds : (k,) array of str, of the torsions
    times : list of float, µs a trial, of the steps between looks
    """

    def __init__(self, protein, system, seed, mixture, steps=1):
        """Begin at the positions of a protein, from which RMSDs are counted; `steps` lie between looks."""
        self._simulation, self._steps = _simulate(protein, system, seed, _MIXTURES[mixture]), steps
        self.trialsPerLook = steps * _STEP
        kinds = np.array([torsion.kind for torsion in protein.torsions])
        self._watched = np.isin(kinds, [kind for ofOne in _WATCHED.values() for kind in ofOne])
        self.kinds = kinds[self._watched]
        self._topology = mdtraj.Topology.from_openmm(protein.topology)
        self._parts = heavyAtoms(self._topology)
        self._start = self._frame(protein.positions)
        self.times, self.samples = [], []

    def begin(self, positions):
        """Go to positions, an (n, 3) array in nm."""
        self._simulation.context.setPositions(positions * unit.nanometer)

    def sample(self, count):
        """Time the steps to `count` looks at the state: an RMSD of each part (nm), cosines, sines."""
        context = self._simulation.context
        for _ in range(count):
            self.times.append(timed(self._simulation.step, self._steps)[1] / self.trialsPerLook)
            angles = self._simulation.integrator.getTorsionAngles(context)[self._watched]
            frame = self._frame(self.positions())
            rmsds = [mdtraj.rmsd(frame, self._start, atom_indices=part) for part in self._parts]
            self.samples.append(np.concatenate([*rmsds, np.cos(angles), np.sin(angles)]))

    def positions(self):
        """Return where all atoms are, an (n, 3) array in nm."""
        return positionsOf(self._simulation.context)

    def outerTestsKept(self):
        """Return the share of outer tests that kept their trials."""
        statistics = self._simulation.integrator.getOuterStatistics()
        return statistics.accepted / max(1, statistics.attempted)

    def _frame(self, positions):
        return mdtraj.Trajectory(positions[np.newaxis].astype(np.float32), self._topology)


def heavyAtoms(topology):
    """Return the indices of all heavy atoms of an mdtraj.Topology, and of all that are not at an end of a chain."""

    def isOfEnd(residue):
        count = residue.chain.n_residues
        place = residue.index - residue.chain.residue(0).index
        return count > 4 * _ENDS and not _ENDS <= place < count - _ENDS

    heavy = topology.select("element != H")
    return heavy, np.array([atom for atom in heavy if not isOfEnd(topology.atom(atom).residue)])


def _describeChains(name, protein, mixture, chains, inefficiencies):
    """Return the entry of Chains of a mixture, by how many of their looks are worth an independent sample."""
    time = medianTime([time for chain in chains for time in chain.times])
    apart = summarize(chains[0].trialsPerLook * inefficiencies, chains[0].kinds)
    return {
        **_describe(name, protein, mixture),
        "trials": sum(len(chain.samples) * chain.trialsPerLook for chain in chains),
        **time,
        "keptShare": float(np.mean([chain.outerTestsKept() for chain in chains])),
        "rate": {key: 1e6 / (time["microseconds"] * value) for key, value in apart.items()},
    }


def summarize(inefficiencies, kinds):
    """Return how many samples are worth one, for torsions of each kind, slow and slowest torsions, and RMSDs.

    For a torsion this is the worse of cosine and sine, for a kind the median over its torsions.

    Parameters
    ----------
    inefficiencies : (2 + 2k,) float64 array, of RMSDS, of cosines, of sines
    kinds : (k,) array of str
    """
    ofTorsions = inefficiencies[len(RMSDS) :].reshape(2, -1).max(axis=0)
    found = {
        name: float(np.median(ofTorsions[np.isin(kinds, ofName)]))
        for name, ofName in _WATCHED.items()
        if np.isin(kinds, ofName).any()
    }
    found |= {"slow": float(np.quantile(ofTorsions, _SLOW)), "slowest": float(ofTorsions.max())}
    return found | dict(zip(RMSDS, map(float, inefficiencies), strict=False))


def _stationaryRow(name, protein):
    """Return the Row of a long chain of the default moves, and of chains of pivots from its states."""

    def measure(course, seed):
        trials, one = course.trials or _TRIALS["stationary"], protein()
        system = one.makeSystem(IMPLICIT_SOLVENT)
        looks = max(_LEAST_LOOKS, trials // (_STEPS * _STEP))
        leftOut = looks // _LEFT_OUT
        long = Chain(one, system, seed, DEFAULTS, _STEPS)
        long.sample(leftOut)
        starts = []
        for _ in range(_STARTS):
            long.sample((looks - leftOut) // _STARTS)
            starts.append(long.positions())
        values = np.array(long.samples[leftOut:])
        chains = []
        for number, start in enumerate(starts):
            chain = Chain(one, system, seed + number, PIVOTS, _STEPS)
            chain.begin(start)
            chain.sample(max(_LEAST_LOOKS, int(looks / _PART)))
            chains.append(chain)
        lag = int(_LAG_SHARE * len(chains[0].samples))
        ofLong = statisticalInefficiency(values)
        ofPivots = leastInefficiency([np.array(chain.samples) for chain in chains], values.var(axis=0), lag)
        isKept = _isSlower(ofLong)
        ofLong, ofPivots = np.where(isKept, ofLong, 0), np.where(isKept, ofPivots, 0)
        lag *= long.trialsPerLook
        return [
            {**_describeChains(name, one, PIVOTS, chains, ofPivots), "lag": lag},
            {**_describeChains(name, one, DEFAULTS, [long], ofLong), "lag": lag},
        ]

    return Row("stationary", name, measure)


def _isSlower(inefficiencies):
    """Return which of the cosine and the sine of each torsion is slower in the long chain; RMSDs stay.

    The worse of two estimates from the chains of pivots would be too large.
    """
    cosines, sines = inefficiencies[len(RMSDS) :].reshape(2, -1)
    return np.concatenate([[True] * len(RMSDS), cosines >= sines, cosines < sines])


# ---- The script ----


def _plan(options):
    proteins, skipped = prepare(options, _FILES, _QUICK_TRIALS, IMPLICIT_SOLVENT)
    moves = SINGLE_MOVES[::6] if options.quick else SINGLE_MOVES
    rows = []
    if "moves" in options.rows:
        rows += [_moveRow(*one, move) for one in proteins.items() for move in moves]
    if "stationary" in options.rows:
        rows += [_stationaryRow(*one) for one in proteins.items()]
    return rows, skipped


def main(arguments=None):
    """Run the script; return its exit status."""
    about = "Measure moves of proteins in AMBER14 with GBn2 at 300 K from the folded state."
    parser = makeParser("moves.py", about, GROUPS, _RUNS, _FILES, _WARM_TRIALS)
    return run(parser, arguments, _plan, makeTables, "movepicture")


if __name__ == "__main__":
    sys.exit(main())
