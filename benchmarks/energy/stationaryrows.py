"""Independent samples a second of the default moves, and the most that pivots alone can give from the same states."""

from typing import NamedTuple

import numpy as np
from racing.course import Course
from racing.races import ALL_CHAINS

from .autocorrelation import leastInefficiency, statisticalInefficiency
from .chain import RMSDS
from .moverows import DEFAULTS, PIVOTS, STEP, describe, describeChains, makeChain
from .proteins import IMPLICIT_SOLVENT
from .rows import Prepared

STATIONARY = "stationary"  # a group of rows

STATIONARY_TRIALS = 4000000
_STEPS = 8  # from one look to the next: even, for leastInefficiency
_LEFT_OUT = 4  # the first of so many parts of the long chain
_STARTS = 4  # chains of pivots, from states that are evenly spaced in the rest
_PART = 2.5  # each is the long chain's length by this
_LAG = 0.75  # of their length: up to there their changes are looked at
_LEAST = 8  # looks at the long chain


class StationaryRow(NamedTuple):
    """A long chain of the default moves, and chains of pivots from its states."""

    name: str
    prepared: Prepared
    trials: int = STATIONARY_TRIALS
    group: str = STATIONARY
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return self.name

    def run(self, course: Course, seed: int):
        """Return an entry for pivots and one for the default moves."""
        trials, protein = course.trials or self.trials, self.prepared.protein
        system = protein.makeSystem(IMPLICIT_SOLVENT)
        looks = max(_LEAST, trials // (_STEPS * STEP))
        long = makeChain(protein, system, seed, DEFAULTS.name, _STEPS)
        long.sample(looks // _LEFT_OUT)
        starts = []
        for _ in range(_STARTS):
            long.sample((looks - looks // _LEFT_OUT) // _STARTS)
            starts.append(long.positions())
        values = long.values()[looks // _LEFT_OUT :]
        ofLong = statisticalInefficiency(values)
        chains = []
        for number, start in enumerate(starts):
            chain = makeChain(protein, system, seed + number, PIVOTS, _STEPS)
            chain.begin(start)
            chain.sample(max(_LEAST, int(looks / _PART)))
            chains.append(chain)
        lag = int(_LAG * chains[0].count)
        ofPivots = leastInefficiency([chain.values() for chain in chains], values.var(axis=0), lag)
        ofLong, ofPivots = _chooseSlower(ofLong, ofPivots)
        common = describe(self, trials, seed)
        return [
            {**common, "lag": lag * long.trialsPerLook, **describeChains(PIVOTS, chains, ofPivots)},
            {**common, "lag": 0, **describeChains(DEFAULTS.name, [long], ofLong)},
        ]


def _chooseSlower(ofLong, ofPivots):
    """Return inefficiencies of which only those of cosines or of sines are left, as is slower in the long chain.

    Otherwise the pivots' would be the worse of two estimates, and the larger for it.
    """
    cosines, sines = ofLong[len(RMSDS) :].reshape(2, -1)
    isKept = np.concatenate([[True] * len(RMSDS), cosines >= sines, cosines < sines])
    return np.where(isKept, ofLong, 0), np.where(isKept, ofPivots, 0)
