"""Samples of chains, the errors of their means by blocks, and the comparison of two samples."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import ttest_ind_from_stats

BLOCKS = 64  # of all chains together, at least
RESAMPLES = 500


@dataclass
class Samples:
    """Frames of chains of one molecule, as `save` writes them."""

    molecule: str
    method: str
    temperature: float
    positions: np.ndarray  # (chains, frames, atoms, 3), nm
    energies: np.ndarray  # (chains, frames, forces), kJ/mol
    forces: np.ndarray  # their names
    seconds: float

    def save(self, path):
        np.savez(path, **vars(self))

    @classmethod
    def load(cls, path):
        with np.load(path) as file:
            return cls(**{name: value if value.ndim else value.item() for name, value in file.items()})

    def inBlocks(self, values):
        """Return values (chains × frames, …) in blocks of one chain each, (blocks, length, …)."""
        chains, frames = self.positions.shape[:2]
        count = min(-(-BLOCKS // chains), frames)
        length = frames // count
        ofChains = values.reshape(chains, frames, *values.shape[1:])[:, : count * length]
        return ofChains.reshape(chains * count, length, *values.shape[1:])


@dataclass
class Estimate:
    """A number and its standard error in each of two samples, and how likely they are that far apart."""

    first: tuple[float, float]
    second: tuple[float, float]
    pValue: float

    @property
    def difference(self):
        return self.second[0] - self.first[0]

    @property
    def errors(self):
        """The difference in standard errors."""
        return self.difference / max(np.hypot(self.first[1], self.second[1]), 1e-30)


def compareMeans(first, second):
    """Return the Estimate for the means of two samples, by the means of their blocks (Welch's test)."""
    summaries = [(float(of.mean()), float(of.std(ddof=1)), len(of)) for of in (first, second)]
    estimates = [(mean, deviation / np.sqrt(count)) for mean, deviation, count in summaries]
    if max(error for _, error in estimates) == 0:
        return Estimate(*estimates, float(estimates[0] == estimates[1]))
    return Estimate(*estimates, float(ttest_ind_from_stats(*summaries[0], *summaries[1], equal_var=False).pvalue))


def compareWidths(first, second):
    """Return the Estimate for the roots of the means, which are positive."""
    found = compareMeans(first, second)
    rooted = [(np.sqrt(mean), error / (2 * np.sqrt(max(mean, 1e-30)))) for mean, error in (found.first, found.second)]
    return Estimate(*rooted, found.pValue)


def effectiveSize(share, error):
    """Return the number of independent samples that give a share this error; 0 if it is unknown."""
    return share * (1 - share) / error**2 if error > 0 else 0.0


def totalVariation(first, second, seed=1):
    """Return the total variation between two histograms, and mean and 95 % quantile for samples of one distribution.

    `first` and `second` are histograms of blocks, (blocks, cells), which sum to 1. Blocks are drawn with replacement:
    the means of the drawn ones vary about the mean of all as histograms of such samples vary about the truth.
    """
    random = np.random.default_rng(seed)
    variations = []
    for _ in range(RESAMPLES):
        drawn = [of[random.integers(len(of), size=len(of))].mean(axis=0) - of.mean(axis=0) for of in (first, second)]
        variations.append(0.5 * np.abs(drawn[0] - drawn[1]).sum())
    seen = 0.5 * np.abs(first.mean(axis=0) - second.mean(axis=0)).sum()
    return seen, float(np.mean(variations)), float(np.quantile(variations, 0.95))
