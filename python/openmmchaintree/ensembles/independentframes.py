"""Frames of a run, until they hold enough independent conformers."""

from typing import NamedTuple

import numpy as np
from openmm import unit

from ..statistics.equilibration import findEquilibration
from ..statistics.estimates import estimate

_FIRST_FRAMES = 200
_LARGEST_GROWTH = 2  # of the number of frames, from one estimate to the next
_MOST_FRAMES_PER_CONFORMER = 16  # beyond it every second frame is dropped
_LEAST_CHANGE = 1e-4  # nm, or without a unit: what changes by less is rigid and does not decide
_MARGIN = 1.1  # of the frames that an estimate asks for


class IndependentFrames(NamedTuple):
    """Independent conformers of a run, and averages over its equilibrated part.

    frames : (conformers, n, 3) float32 array, as the run's function of positions returned them, equally spaced
    values : dict of arrays of a value for each conformer, by name
    estimates : dict of Estimate by name; effectiveSampleSize : float, the least of the deciding ones
    trials : int; isComplete : bool, whether the requested number was reached
    """

    frames: np.ndarray
    values: dict
    estimates: dict
    effectiveSampleSize: float
    trials: int
    isComplete: bool


class IndependentRun:
    """A Context that samples, and its frames: every `stride` trials one, some of the first ones left out."""

    def __init__(self, context, integrator, stride, frameOf, valuesOf, deciding):
        """Begin at the Context's positions.

        Parameters
        ----------
        context : openmm.Context; integrator : TorsionMonteCarloIntegrator, the Context's
        stride : int
            trials between frames at first, less than one independent conformer needs
        frameOf : callable
            takes positions (nm), returns the array that is kept of them
        valuesOf : callable
            takes an array of frames, returns a dict of arrays of a value for each
        deciding : list of str
            the names of the values of which the least effective sample size counts
        """
        self._context, self._integrator = context, integrator
        self._frameOf, self._valuesOf, self._deciding = frameOf, valuesOf, deciding
        self._setStride(stride)
        self._frames, self._trials = [], 0
        self._values, self._valued = {}, 0  # of how many frames

    def sample(self, conformers, maxTrials):
        """Run until there are enough independent conformers, and return IndependentFrames."""
        wanted = _FIRST_FRAMES
        while True:
            while len(self._frames) < wanted and self._trials < maxTrials:
                self._addFrame()
            values = self._allValues()
            deciding = [name for name in self._deciding if np.ptp(values[name]) > _LEAST_CHANGE]
            start, isEquilibrated = findEquilibration([values[name] for name in deciding])
            estimates = {name: estimate([series[start:]]) for name, series in values.items()}
            sizes = [estimates[name].effectiveSampleSize or 0.0 for name in deciding]
            sample = min(sizes, default=0.0) if isEquilibrated else 0.0
            isComplete = sample >= conformers
            if isComplete or self._trials >= maxTrials:
                break
            if len(self._frames) > _MOST_FRAMES_PER_CONFORMER * max(conformers, _FIRST_FRAMES):
                self._thin()
            factor = _MARGIN * conformers / max(sample, 1e-9)
            wanted = int(len(self._frames) * min(max(factor, _MARGIN), _LARGEST_GROWTH)) + 1
        chosen = np.unique(np.linspace(start, len(self._frames) - 1, conformers).round().astype(int))
        frames = np.array([self._frames[i] for i in chosen])
        ofChosen = {name: series[chosen] for name, series in values.items()}
        return IndependentFrames(frames, ofChosen, estimates, sample, self._trials, isComplete)

    def _addFrame(self):
        self._integrator.step(1)
        self._trials += self._stride
        positions = self._context.getState(positions=True).getPositions(asNumpy=True)
        self._frames.append(self._frameOf(positions.value_in_unit(unit.nanometer)))

    def _allValues(self):
        """Return the values of all frames by name; only those of new frames are computed."""
        if self._valued < len(self._frames):
            found = self._valuesOf(np.array(self._frames[self._valued :]))
            former = self._values or {name: series[:0] for name, series in found.items()}
            self._values = {name: np.concatenate((former[name], series)) for name, series in found.items()}
            self._valued = len(self._frames)
        return self._values

    def _thin(self):
        """Drop every second frame, and take half as many from now on."""
        self._frames = self._frames[1::2]
        self._values = {name: series[1::2] for name, series in self._values.items()}
        self._valued = len(self._frames)
        self._setStride(2 * self._stride)

    def _setStride(self, stride):
        self._stride = stride
        self._integrator.setTrialsPerStep(stride)
