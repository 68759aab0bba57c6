"""Means of a run with their errors, and whether they may be quoted, as plain dictionaries and lists."""

import math

import numpy as np

from ..naming import describeResidue
from ..statistics.equilibration import findEquilibration
from ..statistics.estimates import LARGEST_RHAT, LEAST_SAMPLE, estimate, estimateAngle
from ..torsions import KINDS

_UNITS = {"potentialEnergy": "kJ/mol", "radiusOfGyration": "nm", "endToEndDistance": "nm", "rmsd": "nm"}

_ROUNDING = 1e-9  # kJ/mol, nm

# Kinds of which a residue can have several.
_NAMED_BY_AXIS = ("rotor", "planar", "other")


def estimateGroups(series, torsions, resolution):
    """Return the estimates of each Group of a Series as dictionaries.

    Times are in trials, energies in kJ/mol, lengths in nm, angles in degrees. Torsions of one kind share an entry,
    which names the slowest of them, and has the largest R-hat of all.

    torsions : list of Torsion; resolution : float, rad, changes of angles that are rounding
    """
    names = list(map(_nameTorsion, torsions))
    return [_estimateGroup(group, torsions, names, resolution, series) for group in series.groups]


def _estimateGroup(group, torsions, names, resolution, series):
    averages = [np.mean(chains, axis=0) for chains in group.measured.values()]
    left, isEnough = findEquilibration([average for average in averages if np.isfinite(average).all()])
    measured = {
        name: estimate([chain[left:] for chain in chains], _ROUNDING) for name, chains in group.measured.items()
    }
    angles = [chain[left:] for chain in group.angles]
    turned = [estimateAngle([chain[:, column] for chain in angles], resolution) for column in range(len(torsions))]
    kinds = {}
    for torsion, name, found in zip(torsions, names, turned, strict=True):
        kinds.setdefault(torsion.kind, []).append((name, found))
    judged = [(name, found) for name, found in measured.items() if found.verdict != "constant"]
    verdict, least, largest = _judge([*judged, *zip(names, turned, strict=True)], isEnough)
    return {
        "temperature": group.temperature,
        "chains": len(group.rows),
        "values": sum(len(rows) - left for rows in group.rows),
        "interval": series.interval,
        "equilibration": {"frames": left * series.frames, "trials": left * series.interval, "isEnough": isEnough},
        "observables": [
            {"name": name, "unit": _UNITS[name], **_plain(found, series.interval)} for name, found in measured.items()
        ],
        "torsions": [_describeKind(kind, kinds[kind], series.interval) for kind in KINDS if kind in kinds],
        "leastSampleSize": least,
        "largestRhat": largest,
        "verdict": verdict,
    }


def _nameTorsion(torsion):
    """Return the name of a Torsion, such as "chi1 of A:LEU 42"."""
    kind = torsion.kind
    if kind in _NAMED_BY_AXIS:
        names = {atom.index: atom.name for atom in torsion.residue.atoms()}
        kind += " " + "–".join(names.get(particle, "…") for particle in torsion.particles[1:3])
    return f"{kind} of {describeResidue(torsion.residue)}"


def _describeKind(kind, found, interval):
    """Return the entry of torsions of one kind, (name, Estimate) pairs."""
    name, slowest = min(found, key=_sampleSize)
    verdict, _, largest = _judge(found, True)
    about = {"kind": kind, "count": len(found), "slowest": name, "unit": "degrees"}
    return {**about, **_plain(slowest, interval, math.degrees(1)), "rhat": largest, "verdict": verdict}


def _judge(found, isEnough):
    """Return the verdict on all of some (name, Estimate) pairs, their least sample size, and their largest R-hat.

    isEnough : whether equilibration was found to end
    """
    if not found:
        return "nothing varies", 0.0, None
    name, slowest = min(found, key=_sampleSize)
    worst, apart = max(found, key=lambda one: one[1].rhat or 0)
    verdict = None
    if slowest.verdict == "constant":
        verdict = f"too short: {name} has not turned"
    elif _sampleSize((name, slowest)) < LEAST_SAMPLE:
        verdict = f"{slowest.verdict} ({name})"
    elif (apart.rhat or 0) > LARGEST_RHAT:
        verdict = f"{apart.verdict} ({worst})"
    elif not isEnough:
        verdict = "not equilibrated: half of the run is left out, and that is not enough"
    return verdict, slowest.effectiveSampleSize, _finite(apart.rhat)


def _sampleSize(named):
    return named[1].effectiveSampleSize or 0.0


def _plain(found, interval, factor=1.0):
    """Return an Estimate as a dictionary for JSON, times in trials, means times a factor."""
    time = found.autocorrelationTime
    return {
        "mean": None if found.mean is None else factor * found.mean,
        "standardError": None if found.standardError is None else factor * found.standardError,
        "autocorrelationTime": None if time is None else time * interval,
        "effectiveSampleSize": found.effectiveSampleSize,
        "rhat": _finite(found.rhat),
        "verdict": found.verdict,
    }


def _finite(value):
    return value if value is not None and math.isfinite(value) else None
