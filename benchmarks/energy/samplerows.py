"""Independent samples a second, by cutoffs of the stand-in and trials of an outer test."""

from typing import NamedTuple

import numpy as np
from racing.course import Course, summarizeTimes
from racing.races import ALL_CHAINS

from .autocorrelation import statisticalInefficiency
from .proteins import BACKBONE, IMPLICIT_SOLVENT, SIDE_CHAINS, positionsOf
from .rows import Prepared
from .solventrows import Sampler, describeCommon, describeOuter, describeStandIn

SAMPLES = "samples"  # the group of rows

SAMPLE_CUTOFFS = ((0.55, 0.7), (0.55, 0.8), (0.65, 0.9), (1.0, 1.2))  # of Born sums and of pairs, nm
SAMPLE_BLOCKS = (50, 100, 200, 400, 800)  # trials of an outer test
SAMPLE_TRIALS = 80000  # a chain

# What is looked at: torsions of side chains, of the backbone, U, the radius of gyration.
OBSERVABLES = ("chi", "backbone", "energy", "rg")

_SAMPLE = max(SAMPLE_BLOCKS)  # trials between two samples
_TURN, _LEAST = 5, 2  # samples
_LEFT_OUT = 10  # the first of so many parts of a chain


class SampleRow(NamedTuple):
    """Chains with the moves of the example, by cutoffs of the stand-in and trials of an outer test, in turns."""

    name: str
    prepared: Prepared
    trials: int = SAMPLE_TRIALS
    method = IMPLICIT_SOLVENT
    group: str = SAMPLES
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return self.name

    def run(self, course: Course, seed: int):
        """Return an entry for each pair of cutoffs and each number of trials."""
        trials, protein = course.trials or self.trials, self.prepared.protein
        settings = [(cutoffs, block) for cutoffs in SAMPLE_CUTOFFS for block in SAMPLE_BLOCKS]
        chains = [_Chain(protein.makeSimulation(self.method, seed), *setting) for setting in settings]
        count = max(_LEAST, min(_TURN, trials // _SAMPLE))
        for _ in range(max(1, trials // (count * _SAMPLE))):
            for chain in chains:
                chain.sample(count)
        samples = np.array([chain.kept() for chain in chains])
        mean = samples.mean(axis=(0, 1))  # all chains sample the same, so they tell it together
        torsions = {"chi": protein.torsionsOf(SIDE_CHAINS), "backbone": protein.torsionsOf(BACKBONE)}
        entries = []
        for (cutoffs, block), chain, values in zip(settings, chains, samples, strict=True):
            times = summarizeTimes(chain.times)
            apart = _SAMPLE * summarize(statisticalInefficiency(values, mean), torsions)
            entries.append(
                {
                    **describeCommon(self, trials, seed),
                    **describeStandIn(cutoffs, block),
                    "trials": chain.trials,
                    **times,
                    "outer": describeOuter(chain.integrator.getOuterStatistics()),
                    "apart": dict(zip(OBSERVABLES, apart.tolist(), strict=True)),
                    "rate": dict(zip(OBSERVABLES, (1e6 / (times["microseconds"] * apart)).tolist(), strict=True)),
                }
            )
        return entries


class _Chain(Sampler):
    """A Simulation with a stand-in, and what is looked at of it after each step."""

    def __init__(self, simulation, cutoffs, block):
        simulation.integrator.setStandInCutoffs(*cutoffs)
        simulation.integrator.setTrialsPerOuterTest(block)
        super().__init__(simulation, _SAMPLE)
        self.samples = []

    def sample(self, count):
        """Time so many steps, and look at the state after each."""
        for _ in range(count):
            self.run(_SAMPLE)
            self.samples.append(self._look())

    def kept(self):
        """Return the samples without those of the beginning: an (n, k) array."""
        return np.array(self.samples[len(self.samples) // _LEFT_OUT :])

    def _look(self):
        context = self.simulation.context
        radius = np.sqrt(positionsOf(context).var(axis=0).sum())
        return [self.integrator.getPotentialEnergy(context), radius, *np.cos(self.integrator.getTorsionAngles(context))]


def summarize(inefficiencies, torsions):
    """Return one number for each of OBSERVABLES: of several torsions their median.

    Parameters
    ----------
    inefficiencies : (k,) float64 array, of U, of the radius of gyration, of the cosine of each torsion
    torsions : dict, the numbers of torsions
    """
    energy, radius, *ofTorsions = inefficiencies
    ofTorsions = np.array(ofTorsions)
    medians = [float(np.median(ofTorsions[torsions[kind]])) for kind in OBSERVABLES[:2]]
    return np.array([*medians, energy, radius])
