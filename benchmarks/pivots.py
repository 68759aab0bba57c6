"""Time pivots of bead chains, and sample a coarse-grained disordered protein by them and by dynamics.

PYTHONPATH=build/package python benchmarks/pivots.py --csv pivots.csv --markdown pivots.md
"""

import sys
import time

import numpy as np
import openmm
from autocorrelation import statisticalInefficiency
from disordered import BOND, makeDynamicsSystem, makePairForces, makeSequence
from measure import CPU, OURS, Row, hasCPU, makeParser, medianTime, run, timed
from openmmchaintree import StericExclusionForce, TorsionMonteCarloIntegrator
from proteins import TEMPERATURE, positionsOf
from report import anyOf, number, racesOf, tabulate, timeRange

GROUPS = {
    "pivots": "whole trials of the integrator, hard spheres",
    "disordered": "a coarse-grained disordered protein, by pivots and by Langevin dynamics",
}

COMPACT, COIL, LANGEVIN = "random compact", "coil", "Langevin dynamics"

_RUNS = 5
_SIZES, _QUICK_SIZES = (1000, 10000), (300,)
_ANGLES = {COMPACT: (180, 5, 1), COIL: (180, 5)}  # degrees, the largest; 180: all rotations
_SPACING, _RADIUS = 0.4, 0.1  # nm: the spheres of the race, in another unit
_TRIALS, _BLOCK = 20000, 2000  # in a step, after which positions reach the Context
_EQUILIBRATION = 30  # trials a bead of a coil
_BACKBITES = 12  # a site

_LENGTH, _QUICK_LENGTH = 300, 30  # beads of the protein
_HARD_RADIUS = 0.17  # nm: below 0.34 nm all pairs have 30 kT at least
_MIXTURES = {"pivots": ((1, np.pi),), "pivots and small ones": ((0.7, np.pi), (0.3, 0.3))}
_TIMESTEP, _FRICTION = 0.01, 0.01  # ps, 1/ps
_LEFT_OUT = 10  # the first of so many parts of a run
_TRIALS_PER_SAMPLE, _STEPS_PER_SAMPLE = 100, 1000
_MINUTES, _QUICK_MINUTES, _OUR_SHARE = 10, 0.02, 0.1  # of dynamics, and what part of that ours takes

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


def _makeContext(positions, radius, moves, seed, forces=()):
    """Return a Context of a chain with pivot moves, (weight, largest angle) pairs, and its integrator."""
    system = openmm.System()
    for _ in positions:
        system.addParticle(1)
    for force in (makeForce(len(positions), radius), *forces):
        system.addForce(force)
    integrator = TorsionMonteCarloIntegrator(TEMPERATURE)
    integrator.setRandomNumberSeed(seed)
    for weight, angle in moves:
        integrator.addPivotMove(weight, angle)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(positions)
    return context, integrator


def _acceptedShare(integrator):
    counts = [integrator.getMoveStatistics(move) for move in range(integrator.getNumMoves())]
    return sum(one.accepted for one in counts) / max(1, sum(one.attempted for one in counts))


def _gyration(context):
    return float(np.sqrt(positionsOf(context).var(axis=0).sum()))


# ---- Rows ----


def _pivotRow(chain, size, degrees):
    def begin(seed):
        if chain == COMPACT:
            return compactWalk(size, _SPACING, np.random.default_rng(seed))
        context, integrator = _makeContext(stairs(size, _SPACING), _RADIUS, [(1, np.pi)], seed)
        integrator.setTrialsPerStep(_EQUILIBRATION * size)
        integrator.step(1)
        return positionsOf(context)

    def measure(course, seed):
        trials = course.trials or _TRIALS
        context, integrator = _makeContext(begin(seed), _RADIUS, [(1, np.radians(degrees))], seed)
        integrator.setTrialsPerStep(1)
        integrator.step(1)  # which makes the scene
        start = _gyration(context)
        integrator.resetMoveStatistics()
        block = min(_BLOCK, trials)
        integrator.setTrialsPerStep(block)
        times = [timed(integrator.step, 1)[1] / block for _ in range(trials // block)]
        found = {"accepted": _acceptedShare(integrator), "startRg": start, "rg": _gyration(context)}
        rotations = "all" if degrees == 180 else f"up to {degrees}°"
        common = {"chain": chain, "particles": size, "moves": rotations, "contestant": OURS, "trials": trials}
        return [{**common, **medianTime(times), **found}]

    return Row("pivots", f"{chain}, {size:,} beads, {degrees}°", measure)


def _disorderedRow(length, seconds):
    def measure(course, seed):
        sequence, entries = makeSequence(length), []
        for name, moves in _MIXTURES.items():
            start, forces = stairs(length, BOND), makePairForces(sequence)
            context, integrator = _makeContext(start, _HARD_RADIUS, moves, seed, forces)
            integrator.setTrialsPerStep(_TRIALS_PER_SAMPLE)
            found = _sample(context, integrator, _OUR_SHARE * seconds, 1, _TRIALS_PER_SAMPLE)
            entries.append({"contestant": name, "accepted": _acceptedShare(integrator), **found})
        dynamics = openmm.LangevinMiddleIntegrator(TEMPERATURE, _FRICTION, _TIMESTEP)
        dynamics.setRandomNumberSeed(seed)
        name, properties = (CPU, {"Threads": "1"}) if hasCPU() else ("Reference", {})
        platform = openmm.Platform.getPlatformByName(name)
        ofDynamics = openmm.Context(makeDynamicsSystem(sequence), dynamics, platform, properties)
        ofDynamics.setPositions(positionsOf(context))  # equilibrated
        openmm.LocalEnergyMinimizer.minimize(ofDynamics, maxIterations=100)
        ofDynamics.setVelocitiesToTemperature(TEMPERATURE, seed)
        found = _sample(ofDynamics, dynamics, seconds, _STEPS_PER_SAMPLE, _STEPS_PER_SAMPLE)
        entries.append({"contestant": LANGEVIN, **found})
        return [{"chain": "disordered protein", "particles": length, **entry} for entry in entries]

    return Row("disordered", f"{length} beads", measure, 1)


def _sample(context, integrator, seconds, steps, perSample):
    """Sample radii of gyration for a processor time; return what an entry says about them."""
    radii, start = [], time.process_time()
    while len(radii) < 2 * _LEFT_OUT or time.process_time() - start < seconds:
        integrator.step(steps)
        radii.append(_gyration(context))
    each = (time.process_time() - start) / len(radii)
    kept = np.array(radii[len(radii) // _LEFT_OUT :])
    apart = float(statisticalInefficiency(kept[:, np.newaxis])[0])
    return {
        "microseconds": 1e6 * each / perSample,
        "trials": perSample * len(radii),
        "rate": 1 / (each * apart),
        "rg": float(kept.mean()),
        "rgError": float(kept.std() * np.sqrt(apart / len(kept))),
        "independent": len(kept) / apart,
    }


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
    tables = tabulate("Pivots of bead chains", racesOf(entries, "pivots"), pivots, 2, note)
    found = [entry for race in racesOf(entries, "disordered") for entry in race.values()]
    dynamics = next((entry["rate"] for entry in found if entry["contestant"] == LANGEVIN), None)
    disordered = {
        "": lambda entry: entry["contestant"],
        "µs a trial or step": lambda entry: number(entry["microseconds"]),
        "accepted": lambda entry: f"{entry['accepted']:.2f}" if "accepted" in entry else "–",
        "Rg, nm": lambda entry: f"{entry['rg']:.3f} ± {entry['rgError']:.3f}",
        "trials or steps": lambda entry: f"{entry['trials']:,}",
        "independent": lambda entry: number(entry["independent"]),
        "independent Rg a second": lambda entry: number(entry["rate"]),
        "ratio": lambda entry: number(entry["rate"] / dynamics) if dynamics else "–",
    }
    note = (
        "One bead a residue, CALVADOS 2 (Ashbaugh-Hatch to 2 nm, Debye-Hückel to 4 nm, 300 K), by processor time of "
        "one core. Pivots: both pair forces native, hard cores of 0.34 nm in addition. Langevin dynamics: "
        "LangevinMiddleIntegrator, 10 fs, 0.01/ps, OpenMM's CPU platform with one thread, harmonic bonds. Independent: "
        "by the autocorrelation of the radius of gyration."
    )
    return tables + tabulate("A disordered protein by pivots and by dynamics", found, disordered, 1, note)


def _plan(options):
    sizes, length = (_QUICK_SIZES, _QUICK_LENGTH) if options.quick else (_SIZES, _LENGTH)
    rows = []
    if "pivots" in options.rows:
        rows += [_pivotRow(chain, size, angle) for chain, ofOne in _ANGLES.items() for size in sizes for angle in ofOne]
    if "disordered" in options.rows:
        minutes = options.minutes or (_QUICK_MINUTES if options.quick else _MINUTES)
        rows.append(_disorderedRow(length, 60 * minutes))
    return rows, []


def main(arguments=None):
    """Run the script; return its exit status."""
    about = "Time pivots of bead chains, and compare how many independent radii of gyration they and dynamics give."
    parser = makeParser("pivots.py", about, GROUPS, _RUNS)
    parser.add_argument("--minutes", type=float, help=f"processor time of dynamics (default: {_MINUTES})")
    return run(parser, arguments, _plan, makeTables)


if __name__ == "__main__":
    sys.exit(main())
