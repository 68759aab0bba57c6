"""Time pivots of bead chains, hard spheres; see docs/benchmark.md.

PYTHONPATH=build/package python benchmarks/pivots.py --csv pivots.csv --markdown pivots.md
"""

import sys

import numpy as np
import openmm
from measure import OURS, Row, makeParser, medianTime, run, timed
from openmmchaintree import StericExclusionForce, TorsionMonteCarloIntegrator
from proteins import TEMPERATURE, positionsOf
from report import anyOf, number, racesOf, tabulate, timeRange

GROUPS = {"pivots": "whole trials of the integrator, hard spheres"}

COMPACT, COIL = "random compact", "coil"

_RUNS = 5
_SIZES, _QUICK_SIZES = (1000, 10000), (300,)
_ANGLES = {COMPACT: (180, 5, 1), COIL: (180, 5)}  # degrees, the largest; 180: all rotations
_SPACING, _RADIUS = 0.4, 0.1  # nm: the spheres of the race, in another unit
_TRIALS, _BLOCK = 20000, 2000  # in a step, after which positions reach the Context
_EQUILIBRATION = 30  # trials a bead of a coil
_BACKBITES = 12  # a site

_STAIRS = np.array([[0.6, 0, 0.8], [0, 0.6, 0.8], [0.6, 0, 0.8], [0, -0.6, 0.8]])


# ---- Chains ----


def stairs(count, bond):
    """Return positions of `count` beads of which only neighbours are near each other: an (n, 3) array."""
    return bond * np.cumsum(np.resize(_STAIRS, (count, 3)), axis=0)


def compactWalk(count, spacing, random):
    """Return a random path through a cubic lattice: the serpentine after moves of an end to a neighbouring site.

    The path is threaded again from there. Moves to free sites, of which a cube that is not full has some, are left out.
    """
    side = int(np.ceil(count ** (1 / 3) - 1e-9))
    index = np.arange(count)
    row, layer = index // side, index // side**2
    x, y = index % side, row % side
    x, y = np.where(row % 2 == 0, x, side - 1 - x), np.where(layer % 2 == 0, y, side - 1 - y)
    strides = (1, side, side**2)
    sites = x + side * y + side**2 * layer
    places = np.full(side**3, -1)
    places[sites] = index
    moves = (random.integers(high, size=_BACKBITES * count) for high in (2, 3, 2))
    for atStart, axis, step in zip(*moves, strict=True):
        site = sites[0 if atStart else -1]
        along = site // strides[axis] % side + 2 * step - 1
        site += (2 * step - 1) * strides[axis]
        if not 0 <= along < side or places[site] < 0:
            continue
        turned = slice(0, places[site]) if atStart else slice(places[site] + 1, count)
        sites[turned] = sites[turned][::-1].copy()
        places[sites[turned]] = index[turned]
    return spacing * np.stack([sites // stride % side for stride in strides], axis=1)


def makeForce(count, radius):
    """Return a StericExclusionForce of a chain: each bead turns freely about the one before."""
    force = StericExclusionForce()
    force.setOverlapTolerance(0)
    force.setForceGroup(31)
    for bead in range(count):
        force.addParticle(radius)
        if bead > 0:
            force.addBond(bead - 1, bead)
            force.addBallJoint(bead - 1, bead)
    force.createExclusionsFromBonds(1)
    return force


def _makeContext(positions, angle, seed):
    """Return a Context of a chain with pivots up to an angle, rad, and its integrator."""
    system = openmm.System()
    for _ in positions:
        system.addParticle(1)
    system.addForce(makeForce(len(positions), _RADIUS))
    integrator = TorsionMonteCarloIntegrator(TEMPERATURE)
    integrator.setRandomNumberSeed(seed)
    integrator.addPivotMove(1, angle)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(positions)
    return context, integrator


def _gyration(context):
    return float(np.sqrt(positionsOf(context).var(axis=0).sum()))


# ---- Rows ----


def _pivotRow(chain, size, degrees):
    def begin(seed):
        if chain == COMPACT:
            return compactWalk(size, _SPACING, np.random.default_rng(seed))
        context, integrator = _makeContext(stairs(size, _SPACING), np.pi, seed)
        integrator.setTrialsPerStep(_EQUILIBRATION * size)
        integrator.step(1)
        return positionsOf(context)

    def measure(course, seed):
        trials = course.trials or _TRIALS
        context, integrator = _makeContext(begin(seed), np.radians(degrees), seed)
        integrator.setTrialsPerStep(1)
        integrator.step(1)  # which makes the scene
        start = _gyration(context)
        integrator.resetMoveStatistics()
        block = min(_BLOCK, trials)
        integrator.setTrialsPerStep(block)
        times = [timed(integrator.step, 1)[1] / block for _ in range(trials // block)]
        moves = integrator.getMoveStatistics(0)
        found = {"accepted": moves.accepted / max(1, moves.attempted), "startRg": start, "rg": _gyration(context)}
        rotations = "all" if degrees == 180 else f"up to {degrees}°"
        common = {"chain": chain, "particles": size, "moves": rotations, "contestant": OURS, "trials": trials}
        return [{**common, **medianTime(times), **found}]

    return Row("pivots", f"{chain}, {size:,} beads, {degrees}°", measure)


# ---- Tables ----


def makeTables(entries):
    """Return the tables of entries."""
    pivots = {
        "chain": lambda race: anyOf(race)["chain"],
        "rotations": lambda race: anyOf(race)["moves"],
        "beads": lambda race: f"{anyOf(race)['particles']:,}",
        "Rg, nm": lambda race: " → ".join(number(race[OURS][key]) for key in ("startRg", "rg")),
        "accepted": lambda race: f"{race[OURS]['accepted']:.2f}",
        "µs a trial": lambda race: timeRange(race[OURS]),
    }
    note = (
        "Whole trials of TorsionMonteCarloIntegrator with addPivotMove, hard spheres of radius 0.1 nm, bonds of "
        "0.4 nm; medians over chains (range). Random compact: a path through a cubic lattice at the start. Coil: after "
        "30 trials a bead."
    )
    return tabulate("Pivots of bead chains", racesOf(entries, "pivots"), pivots, 2, note)


def _plan(options):
    sizes = _QUICK_SIZES if options.quick else _SIZES
    return [_pivotRow(chain, size, angle) for chain, ofOne in _ANGLES.items() for size in sizes for angle in ofOne], []


def main(arguments=None):
    """Run the script; return its exit status."""
    parser = makeParser("pivots.py", "Time pivots of bead chains.", GROUPS, _RUNS)
    return run(parser, arguments, _plan, makeTables)


if __name__ == "__main__":
    sys.exit(main())
