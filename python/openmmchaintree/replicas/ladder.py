"""Temperatures of replicas, seeds, and exchanges, which are decided from energies alone."""

import math

import numpy as np

from ..errors import InputError
from ..structures.limits import Limit

REPLICAS = Limit("CHAINTREE_MAX_REPLICAS", 10000)

_GAS_CONSTANT = 8.31446261815324e-3  # kJ/mol/K

# Distinguish the random numbers of seeds and of exchanges.
_SEEDS, _EXCHANGES = 0, 1

_SHOWN = 60  # letters of a wrong text in an error


def geometricLadder(lowest, highest, count):
    """Return temperatures (K) in geometric progression from the lowest to the highest."""
    if count == 1:
        return [lowest]
    factor = (highest / lowest) ** (1 / (count - 1))
    return [lowest, *(lowest * factor**i for i in range(1, count - 1)), highest]


def readLadder(text):
    """Return the temperatures (K) of a text: LOWEST:HIGHEST:COUNT, or a list separated by commas.

    Raises
    ------
    InputError
        if the text is wrong
    """
    try:
        if ":" in text:
            lowest, highest, count = text.split(":")
            first, last, number = float(lowest), float(highest), int(count)
            if number < 2:
                raise InputError(f"{text!r}: an exchange needs at least 2 temperatures")
            _checkCount(text, number)
            if not 0 < first < last < math.inf:
                raise InputError(f"{text!r}: the first temperature must be above 0, and the last one above the first")
            temperatures = geometricLadder(first, last, number)
        else:
            _checkCount(text, text.count(","))
            temperatures = [float(part) for part in text.split(",")]
    except InputError:
        raise
    except (ValueError, OverflowError):
        raise InputError(
            f"{text[:_SHOWN]!r} is neither LOWEST:HIGHEST:COUNT, such as 300:450:12, "
            "nor temperatures with commas between them"
        ) from None
    if len(temperatures) < 2:
        raise InputError(f"{text!r}: an exchange needs at least 2 temperatures")
    isRising = all(low < high for low, high in zip(temperatures, temperatures[1:], strict=False))
    if not (isRising and temperatures[0] > 0 and temperatures[-1] < math.inf):
        raise InputError(f"{text[:_SHOWN]!r}: temperatures must be above 0, and each above the one before")
    return temperatures


def _checkCount(text, count):
    REPLICAS.check(count, f"{text[:_SHOWN]!r}: temperatures are")


def deriveSeeds(seed, count):
    """Return `count` different seeds of random number generators, from 1 to 2147483647.

    A smaller count gives the first seeds of a larger one.
    """
    random = np.random.default_rng((seed, _SEEDS))
    seeds = {}
    while len(seeds) < count:
        seeds[int(random.integers(1, 2**31))] = None
    return list(seeds)


def logExchangeRatio(temperature1, energy1, temperature2, energy2):
    """Return the logarithm of the acceptance ratio for exchanging the temperatures of two replicas.

    That is ln of exp(-U2/kT1 - U1/kT2) / exp(-U1/kT1 - U2/kT2), with U in kJ/mol and T in K.
    """
    return (1 / temperature1 - 1 / temperature2) * (energy1 - energy2) / _GAS_CONSTANT


class Exchanges:
    """Decides which replicas exchange their temperatures after each round.

    After even rounds the pairs of temperatures 0 and 1, 2 and 3, … are attempted, after odd ones 1 and 2, 3 and 4, ….
    A decision depends only on the seed, the round, the pair and the two energies, not on the order of results.
    """

    def __init__(self, temperatures, seed):
        """Take temperatures in K, in increasing order, and the seed of the run."""
        self.temperatures = list(temperatures)
        self._seed = seed
        self._drawn = {}

    def lowerOfPair(self, round, index):
        """Return the lower index of the attempted pair that contains the temperature `index`, or None."""
        lower = index - (index + round) % 2
        return lower if 0 <= lower and lower + 1 < len(self.temperatures) else None

    def decide(self, round, lower, lowerEnergy, upperEnergy):
        """Whether the replicas at the temperatures `lower` and `lower + 1` exchange them; energies are in kJ/mol.

        Replicas whose energies are NaN do not exchange.
        """
        temperature1, temperature2 = self.temperatures[lower : lower + 2]
        logRatio = logExchangeRatio(temperature1, lowerEnergy, temperature2, upperEnergy)
        return bool(math.log(self._draw(round, lower)) < logRatio)

    def _draw(self, round, lower):
        """Return the random number in (0, 1] for a pair after a round."""
        if round not in self._drawn:
            random = np.random.default_rng((self._seed, _EXCHANGES, round))
            self._drawn[round] = 1 - random.random(len(self.temperatures) - 1)
            self._drawn.pop(round - len(self.temperatures) - 1, None)
        return self._drawn[round][lower]
