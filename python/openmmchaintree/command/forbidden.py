"""The share of a force field's conformations that hard spheres forbid."""

import copy

import numpy as np
import openmm

# A short run without spheres: the first half equilibrates, the second half gives this number of frames.
_FRAMES = 50
_TRIALS_PER_FRAME = 400


def measureForbidden(sampling, trials, interrupts):
    """Find the share of frames that hard spheres forbid, by a short run without spheres from a Sampling's positions.

    These are the positions after a run of a number of trials.

    Return None if there is no force field, or if there are no hard spheres. Otherwise return a dictionary with the
    number of "frames", the number "forbidden" (None if unknown), and a "text" on it. Interrupts end the run, too.
    """
    if sampling.energies is None or not sampling.isHard:
        return None
    if any(entry.kind == "foreign" for entry in sampling.energies.plan):
        return _unknown("OpenMM evaluates a force, which would take too long")
    if trials < _FRAMES * _TRIALS_PER_FRAME:
        return _unknown(f"that takes a run of {_FRAMES * _TRIALS_PER_FRAME:,} trials or more")
    forbidden = sum(len(sampling.check(positions).beyond.pairs) > 0 for positions in _runWithout(sampling, interrupts))
    if interrupts:
        return _unknown("the run was interrupted")
    return {
        "frames": _FRAMES,
        "forbidden": forbidden,
        "text": f"they forbid {100 * forbidden / _FRAMES:.0f} % of {_FRAMES} frames of a short run without them",
    }


def _unknown(reason):
    return {"frames": 0, "forbidden": None, "text": f"which share of conformations they forbid is not known: {reason}"}


def _runWithout(sampling, interrupts):
    """Yield positions (nm) of a run without spheres, until Interrupts come."""
    if interrupts:
        return
    integrator = copy.copy(sampling.integrator)
    integrator.setStericMode(integrator.Off)
    integrator.setTrialsPerStep(_TRIALS_PER_FRAME)
    platform = sampling.context.getPlatform()
    context = openmm.Context(sampling.context.getSystem(), integrator, platform)
    context.setPositions(sampling.context.getState(positions=True).getPositions(asNumpy=True))
    for number in range(2 * _FRAMES):
        interrupts.runStep(lambda: integrator.step(1))
        if interrupts:
            return
        if number >= _FRAMES:
            yield np.asarray(context.getState(positions=True).getPositions(asNumpy=True)._value)
