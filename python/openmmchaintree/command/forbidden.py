"""What hard spheres forbid of what a force field samples."""

import copy

import numpy as np
import openmm

# A short run without spheres: its first half equilibrates, in its second half so many frames are looked at.
_FRAMES = 50
_TRIALS_PER_FRAME = 400


def measureForbidden(sampling, interrupts):
    """Find which share of frames hard spheres forbid, by a short run without them from where a Sampling stands.

    Return None if there is no force field, or no hard spheres beside it. Else a dictionary with the number of "frames",
    how many of them are "forbidden" (None if that is not known), and a "text" that says so. Interrupts end the run.
    """
    if sampling.energies is None or not sampling.isHard:
        return None
    if any(entry.kind == "foreign" for entry in sampling.energies.plan):
        return _unknown("OpenMM evaluates a force, which would take too long")
    if sampling.trials < _FRAMES * _TRIALS_PER_FRAME:
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
