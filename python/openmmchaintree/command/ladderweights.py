"""Averages at the lowest temperature of a ladder from the frames at all temperatures."""

import csv
import io

import numpy as np

from ..statistics.pymbarimport import timeseries
from ..statistics.reweighting import reweight


def weighLadder(series, estimates):
    """Return averages at the lowest temperature as a dictionary, and rows of the index with their weights.

    Frames before equilibration, and those within the largest autocorrelation time of energy and shapes, are left out.

    Parameters
    ----------
    series : Series
        of a run with exchange
    estimates : list of dict
        from `estimateGroups`

    Returns
    -------
    dict or None, int array, float64 array
        None without an answer
    """
    chosen = [_independent(group, found, series.frames) for group, found in zip(series.groups, estimates, strict=True)]
    measured = [
        {name: chains[0][places] for name, chains in group.measured.items()}
        for group, places in zip(series.groups, chosen, strict=True)
    ]
    together = {name: np.concatenate([one[name] for one in measured]) for name in measured[0]}
    temperatures = [group.temperature for group in series.groups]
    found = reweight([one["potentialEnergy"] for one in measured], temperatures, list(together.values()))
    rows = np.concatenate([group.rows[0][places] for group, places in zip(series.groups, chosen, strict=True)])
    if found is None:
        return None, rows[:0], np.empty(0)
    units = {entry["name"]: entry["unit"] for entry in estimates[0]["observables"]}
    summary = {
        "temperature": temperatures[0],
        "samples": len(rows),
        "effectiveSampleSize": found.sampleSize,
        "observables": [
            {"name": name, "unit": units[name], "mean": float(mean), "standardError": float(error)}
            for name, mean, error in zip(together, found.means, found.errors, strict=True)
        ],
    }
    return summary, rows, found.weights


def _independent(group, estimates, frames):
    """Return the places of independent values in the chain of a Group."""
    left = estimates["equilibration"]["frames"] // frames
    times = [entry["autocorrelationTime"] or 0 for entry in estimates["observables"]]
    inefficiency = 1 + 2 * max(times) / estimates["interval"]
    kept = np.arange(left, len(group.rows[0]))
    return kept[np.array(timeseries().subsample_correlated_data(kept, g=inefficiency), dtype=int)]


def asTable(index, rows, weights):
    """Return rows of the index with their weights as text (CSV), sorted as they are in the index."""
    text = io.StringIO()
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow(("frame", "replica", "temperature", "weight"))
    for place in np.argsort(rows):
        row = rows[place]
        lines.writerow((index["frame"][row], index["replica"][row], index["temperature"][row], weights[place]))
    return text.getvalue()
