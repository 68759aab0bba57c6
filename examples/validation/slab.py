"""A slab: chains that form a dense phase in a long box, from a dense and a dilute start, by moves or by dynamics.

    python slab.py [--chains 100] [--box 15 15 150] [--seconds 3600] [--starts dense dilute] [--samplers moves dynamics]

The chains are the low-complexity domain of hnRNPA1 in CALVADOS 2 at 293 K. For each start and sampler it prints the
concentrations of both phases, whose profiles must meet, and independent samples for each hour of CPU time: of Rg, from
the autocorrelation of each chain's squared Rg, and of the profile, from that of the concentrations in all bins.
Dynamics is Langevin dynamics of the same System by OpenMM's CPU platform, with the step and friction of CALVADOS. Both
samplers use one thread. The first half of a run is not counted.
"""

import argparse
import time
import warnings

import numpy as np
import openmm
from openmm import unit
from openmmchaintree import (
    TorsionMonteCarloIntegrator,
    addDefaultMoves,
    createCalvadosSystem,
    createStericExclusionForce,
    setBondLengths,
)

A1_LCD = (
    "GSMASASSSQRGRSGSGNFGGGRGGGFGGNDNFGRGGNFSGRGGFGGSRGGGGYGGSGDGYNGFGNDGSNFGGGGSYNDFGNYNNQSSNFGPMKGGNFGGRSSGG"
    "SGGGGQYFAKPRNQGGYGGSSSSSSYGSGRRF"
)
TEMPERATURE = 293.0  # K
BOND = 0.3825  # nm, the mean length of a bond in dynamics
_BIN = 1.0  # nm
_CORE, _EDGE = (
    0.1,
    0.35,
)  # half the dense phase, and where the dilute phase begins, in lengths of the box from the middle
_MILLIMOLAR = 0.602214076e-3  # chains/nm³
_DENSE = 18.0  # mM, in the dense start
_RELAXATION = 200  # steps of moves before a run


# ---- The System ----


def drawShapes(sequence, count, seed):
    """Return `count` independent shapes of a chain alone, an (count, beads, 3) array around the origin."""
    sampler = Moves(*createCalvadosSystem(sequence, TEMPERATURE), seed)
    shapes = []
    for _ in range(count):
        sampler.integrator.step(10)
        shapes.append(getPositions(sampler.context))
    return np.array(shapes) - np.mean(shapes, axis=1, keepdims=True)


def place(shapes, box, isDense):
    """Return positions of chains of these shapes in the whole box, or as a dense phase in its middle: they overlap."""
    random = np.random.default_rng(len(shapes))
    height = len(shapes) / (box[0] * box[1] * _DENSE * _MILLIMOLAR) if isDense else box[2]
    levels = 0.5 * box[2] + ((np.arange(len(shapes)) + 0.5) / len(shapes) - 0.5) * height
    middles = np.column_stack([box[0] * random.random(len(shapes)), box[1] * random.random(len(shapes)), levels])
    return (middles[:, np.newaxis] + shapes).reshape(-1, 3)


class Moves:
    """Samples by the default moves for beads."""

    def __init__(self, topology, system, positions, seed):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that bonds are rigid
            force = createStericExclusionForce(topology, positions, system=system)
        system.addForce(force)
        self.integrator = TorsionMonteCarloIntegrator(TEMPERATURE)
        self.integrator.setRandomNumberSeed(seed)
        self.integrator.setTrialsPerStep(1000)
        addDefaultMoves(self.integrator, topology, system)
        self.context = makeContext(system, self.integrator, setBondLengths(force, positions, BOND))

    def describe(self):
        lines = []
        for move in range(self.integrator.getNumMoves()):
            counts = self.integrator.getMoveStatistics(move)
            share = counts.accepted / max(1, counts.attempted)
            lines.append(f"  {self.integrator.getMoveDescription(move)}: {share:.3f} accepted")
        return lines


class Dynamics:
    """Samples by Langevin dynamics."""

    def __init__(self, system, positions, seed):
        self.integrator = openmm.LangevinIntegrator(TEMPERATURE, 0.01, 0.01)  # 1/ps, ps
        self.integrator.setRandomNumberSeed(seed)
        self.context = makeContext(system, self.integrator, positions)
        openmm.LocalEnergyMinimizer.minimize(self.context, maxIterations=100)
        self.context.setVelocitiesToTemperature(TEMPERATURE, seed)

    def describe(self):
        time = self.context.getState().getTime().value_in_unit(unit.nanosecond)
        return [f"  {time:.3f} ns"]


def begin(options, isDense):
    """Return Moves of chains that have the shapes of single chains, after trials that remove overlaps."""
    shapes = drawShapes(options.sequence, options.chains, options.seed)
    topology, system, _ = createCalvadosSystem([options.sequence] * options.chains, TEMPERATURE, box=options.box)
    sampler = Moves(topology, system, place(shapes, options.box, isDense), options.seed)
    sampler.integrator.step(_RELAXATION)
    return sampler


def makeContext(system, integrator, positions):
    platform = openmm.Platform.getPlatformByName("CPU")
    context = openmm.Context(system, integrator, platform, {"Threads": "1"})
    context.setPositions(positions)
    return context


def getPositions(context):
    return context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)


# ---- Samples ----


class Run:
    """Samples of one run: the time of each, the heights of all beads, and the squared Rg of each chain."""

    def __init__(self, sampler, chains, seconds, samples):
        sampler.integrator.step(1)  # the first step prepares the energies
        start = time.process_time()
        self.heights, self.squares = [], []
        while (spent := time.process_time() - start) < seconds:
            sampler.integrator.step(1)
            if spent * samples < len(self.heights) * seconds:
                continue
            molecules = getPositions(sampler.context).reshape(chains, -1, 3)
            self.heights.append(molecules[:, :, 2].ravel())
            centred = molecules - molecules.mean(axis=1, keepdims=True)
            self.squares.append(np.mean(np.sum(centred**2, axis=2), axis=1))
        half = len(self.heights) // 2
        self.interval = (time.process_time() - start) / len(self.heights)  # s
        self.heights, self.squares = np.array(self.heights[half:]), np.array(self.squares[half:])


def profilesOf(run, box, length):
    """Return the concentration (mM) in each bin of each sample, and the bins' distances from the middle of the slab."""
    bins = max(1, round(box[2] / _BIN))
    distances = (np.arange(bins) + 0.5) * box[2] / bins - 0.5 * box[2]
    profiles = []
    for heights in run.heights:
        angles = 2 * np.pi * heights / box[2]
        middle = np.arctan2(np.sin(angles).sum(), np.cos(angles).sum()) / (2 * np.pi) * box[2]
        shifted = (heights - middle + 0.5 * box[2]) % box[2]
        counts = np.histogram(shifted, bins, (0, box[2]))[0]
        profiles.append(counts / length / (box[0] * box[1] * box[2] / bins) / _MILLIMOLAR)
    return np.array(profiles), distances


def correlationTime(values):
    """Return the integrated autocorrelation time of several series, in samples: of the sum of their covariances."""
    values = values - values.mean(axis=0)
    count = len(values)
    transform = np.fft.rfft(values, 2 * count, axis=0)
    covariance = np.fft.irfft(np.abs(transform) ** 2, axis=0)[:count].sum(axis=1) / (count - np.arange(count))
    total = 1.0
    for lag in range(1, count // 2):
        total += 2 * covariance[lag] / covariance[0]
        if lag > 5 * total:  # the usual window
            break
    return max(1.0, total)


def report(name, run, box, length):
    profiles, distances = profilesOf(run, box, length)
    core, edge = np.abs(distances) < _CORE * box[2], np.abs(distances) > _EDGE * box[2]
    hours = run.interval / 3600
    text = f"{name:<16} dense {profiles[:, core].mean():6.2f} mM, dilute {profiles[:, edge].mean():7.4f} mM"
    text += f", Rg {np.sqrt(run.squares.mean()):.3f} nm; independent in a CPU hour:"
    for what, values in (("Rg", run.squares), ("profile", profiles)):
        time = correlationTime(values)
        text += f" {what} {1 / (time * hours):.4g}" + ("*" if time * 20 > len(values) else "")
    print(text, flush=True)
    return profiles.mean(axis=0), distances


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--chains", type=int, default=100)
    parser.add_argument("--box", type=float, nargs=3, default=(15, 15, 150), help="nm")
    parser.add_argument("--sequence", default=A1_LCD)
    parser.add_argument("--seconds", type=float, default=3600, help="CPU time of each run")
    parser.add_argument("--samples", type=int, default=400, help="of each run")
    parser.add_argument("--starts", nargs="+", choices=("dense", "dilute"), default=("dense", "dilute"))
    parser.add_argument("--samplers", nargs="+", choices=("moves", "dynamics"), default=("moves", "dynamics"))
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    length = len(options.sequence)
    columns = {}
    for start in options.starts:
        for sampler in options.samplers:
            made = begin(options, start == "dense")
            if sampler == "dynamics":
                sequences = [options.sequence] * options.chains
                system = createCalvadosSystem(sequences, TEMPERATURE, box=options.box).system
                made = Dynamics(system, getPositions(made.context), options.seed)
            run = Run(made, options.chains, options.seconds, options.samples)
            columns[f"{start}, {sampler}"], distances = report(f"{start}, {sampler}", run, options.box, length)
            print("\n".join(made.describe()), flush=True)
    print("* fewer than 20 correlation times: an estimate from too short a run")
    print("\nnm from the middle, mM:", *columns, sep="  ")
    for index in np.argsort(np.abs(distances), kind="stable")[::2]:  # both sides of the middle are alike
        pair = [0.5 * (column[index] + column[::-1][index]) for column in columns.values()]
        print(f"{abs(distances[index]):6.1f}", *(f"{value:8.3f}" for value in pair))


if __name__ == "__main__":
    main()
