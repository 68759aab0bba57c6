"""Grows closed loops without clashes, one after the other, each from random numbers of its own."""

import math

from ..errors import InputError

# How many loops grow together, and how often sets of the backbone and side chains are drawn. Of some tried values,
# these gave the most loops a second.
_POPULATION, _BACKBONE_DRAWS, _SIDE_DRAWS = 64, 16, 8
_MOST_FAILURES = 200  # before the first loop, after which larger populations are tried
_MOST_POPULATION = 4096


class LoopGrower:
    """A loop that grows.

    runs : int, attempts so far; grown : int, loops so far
    """

    def __init__(self, growth, name, generator):
        """Take a LoopGrowth, the name of the loop for errors, and a numpy.random.Generator for seeds."""
        self._growth, self._name, self._generator = growth, name, generator
        self._population = _POPULATION
        self.runs, self.grown = 0, 0

    def attempt(self):
        """Return a GrownLoop, or None if no member of the population was left.

        Raises
        ------
        InputError
            if too many attempts have failed, and none has not
        """
        if self.grown == 0 and self.runs > 0 and self.runs % _MOST_FAILURES == 0:
            if self._population >= _MOST_POPULATION:
                raise InputError(
                    f"{self._name}: no loop was found that closes without a clash, in {self.runs:,} attempts; the "
                    "fixed part leaves it no room"
                )
            self._population *= 4
        self.runs += 1
        seed = int(self._generator.integers(1, 2**31 - 1))
        found = self._growth.grow(seed, self._population, _BACKBONE_DRAWS, _SIDE_DRAWS)
        if not math.isfinite(found.logWeight):
            return None
        self.grown += 1
        return found

    def next(self):
        """Attempt until there is a loop."""
        while (found := self.attempt()) is None:
            pass
        return found
