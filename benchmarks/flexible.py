"""Measure how far moves with rigid and with flexible links, and dynamics, take a protein; see docs/benchmark.md.

PYTHONPATH=build/package python benchmarks/flexible.py --csv flexible.csv --markdown flexible.md --picture flexible.png
"""

import sys

import mdtraj
import numpy as np
import openmm
from flexibletables import CONSTRAINED, RIGID, UNCONSTRAINED, makeTables, nameOfShare
from measure import CPU, Row, hasCPU, makeParser, medianTime, positive, run, timed
from moves import heavyAtoms
from openmm import app, unit
from openmmchaintree import TorsionMonteCarloIntegrator, addDefaultMoves
from openmmchaintree.command.flexible import LARGEST_SIZE, findScales
from proteins import IMPLICIT_SOLVENT, TEMPERATURE, positionsOf, prepare

GROUPS = {"travel": "how far the Cα atoms are after seconds of a processor's time"}

_FILES = ("1l2y.pdb", "1ubi_h.pdb")
_RUNS, _WARM_TRIALS, _QUICK_TRIALS = 4, 200000, 800
_SECONDS, _QUICK_SECONDS = 60, 2

_SHARES = (0.3, 0.5, 0.7)  # of atom moves, by weight
_TRIALS_PER_STEP, _STEPS_OF_DYNAMICS = 400, 10
_FRICTION = 1 / unit.picosecond
_EQUILIBRATION = 0.2  # of all seconds, before what is measured
_LOOK = 0.1  # s, between looks at the positions
_STARTS_APART = 5  # looks between the starts of two displacements that are averaged
LAGS = (1, 3, 10, 30)  # s


class _Contestant:
    """A Context that starts at a protein's positions, and its Cα atoms at equal intervals of processor time."""

    def __init__(self, protein, system, integrator, steps, unitsPerStep):
        """Begin; a turn is `steps` of the integrator, each of which is `unitsPerStep` trials or steps."""
        self.integrator = integrator
        self.context = openmm.Context(system, integrator, *_platform())
        self.context.setPositions(protein.positions * unit.nanometer)
        self._steps, self._units = steps, steps * unitsPerStep
        self._atoms = _insideAlphas(protein.topology)
        self.spent, self.times, self.looks = 0.0, [], []

    def runTo(self, seconds):
        """Run until this much of its time is spent, counted from the last call of begin()."""
        while self.spent < seconds:
            time = timed(self.integrator.step, self._steps)[1]
            self.times.append(time / self._units)
            self.spent += 1e-6 * time

    def begin(self):
        """Count from here."""
        self.spent, self.times = 0.0, []

    def look(self):
        """Keep where the atoms are."""
        self.looks.append(positionsOf(self.context)[self._atoms])


def _platform():
    """Return the platform and its properties."""
    name, properties = (CPU, [{"Threads": "1"}]) if hasCPU() else ("Reference", [])
    return openmm.Platform.getPlatformByName(name), *properties


def _insideAlphas(topology):
    """Return the indices of Cα atoms that are not at an end of a long chain."""
    trajectory = mdtraj.Topology.from_openmm(topology)
    inside = set(heavyAtoms(trajectory)[1])
    return [atom for atom in trajectory.select("name CA") if atom in inside]


def _makeContestants(protein, seed):
    """Return the contestants by their names."""

    def makeSystem(constraints):
        return protein.makeSystem(IMPLICIT_SOLVENT, sterics=False, constraints=constraints)

    contestants = {}
    for name, share in {RIGID: 0.0, **{nameOfShare(share): share for share in _SHARES}}.items():
        system = makeSystem(None)
        system.addForce(protein.makeForce())
        integrator = TorsionMonteCarloIntegrator(TEMPERATURE * unit.kelvin)
        integrator.setTrialsPerStep(_TRIALS_PER_STEP)
        integrator.setRandomNumberSeed(seed)
        default = addDefaultMoves(integrator, protein.topology, system)  # the sum of their weights is 1
        if share > 0:
            integrator.addAtomMove(share / (1 - share), LARGEST_SIZE * unit.nanometer)
            scales = findScales(integrator, system, protein.positions * unit.nanometer, _platform())
            integrator.setMoveScales(len(default), scales)
        contestants[name] = _Contestant(protein, system, integrator, 1, _TRIALS_PER_STEP)
    for name, constraints, femtoseconds in ((UNCONSTRAINED, None, 1), (CONSTRAINED, app.HBonds, 2)):
        integrator = openmm.LangevinMiddleIntegrator(
            TEMPERATURE * unit.kelvin, _FRICTION, femtoseconds * unit.femtoseconds
        )
        integrator.setRandomNumberSeed(seed)
        one = _Contestant(protein, makeSystem(constraints), integrator, _STEPS_OF_DYNAMICS, 1)
        one.context.applyConstraints(1e-6)
        one.context.setVelocitiesToTemperature(TEMPERATURE * unit.kelvin, seed)
        contestants[name] = one
    return contestants


def travel(looks, lag):
    """Return the mean square displacement (Å²) of atoms between looks that are `lag` apart, each pair superposed.

    looks : (n, atoms, 3) array, nm
    """
    frames = mdtraj.Trajectory(np.asarray(looks, dtype=np.float32), None)
    starts = range(0, len(looks) - lag, _STARTS_APART)
    apart = [mdtraj.rmsd(frames[start + lag], frames, start)[0] for start in starts]
    return 100 * float(np.mean(np.square(apart)))


def _travelRow(name, protein, seconds):
    def measure(course, seed):
        one = protein()
        contestants = _makeContestants(one, seed)
        for contestant in contestants.values():
            contestant.runTo(_EQUILIBRATION * seconds)
            contestant.begin()
        for count in range(round(seconds / _LOOK) + 1):
            for contestant in contestants.values():
                contestant.runTo(count * _LOOK)
                contestant.look()
        entries = []
        for key, contestant in contestants.items():
            lags = [lag for lag in LAGS if lag <= 0.6 * seconds]
            far = {str(lag): travel(contestant.looks, round(lag / _LOOK)) for lag in lags}
            described = {"chain": name, "method": IMPLICIT_SOLVENT.name, "particles": len(one.positions)}
            entries.append({**described, "contestant": key, **medianTime(contestant.times), "travel": far})
        return entries

    return Row("travel", name, measure)


def _plan(options):
    proteins, skipped = prepare(options, _FILES, _QUICK_TRIALS, IMPLICIT_SOLVENT)
    seconds = options.seconds or (_QUICK_SECONDS if options.quick else _SECONDS)
    return [_travelRow(*one, seconds) for one in proteins.items() if "travel" in options.rows], skipped


def main(arguments=None):
    """Run the script; return its exit status."""
    about = "Compare moves with rigid and flexible links and dynamics of proteins in AMBER14 with GBn2 at 300 K."
    parser = makeParser("flexible.py", about, GROUPS, _RUNS, _FILES, _WARM_TRIALS)
    parser.add_argument("--seconds", type=positive, help=f"of each run and contestant (default: {_SECONDS})")
    return run(parser, arguments, _plan, makeTables, "flexiblepicture")


if __name__ == "__main__":
    sys.exit(main())
