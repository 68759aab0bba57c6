"""The picture of a run of replicas: energies and sizes, exchange rates, and paths through temperatures."""

import numpy as np

from ...notes import countOf
from .figures import groupThousands, makeFigure, setTitle, writeFigure

_BINS = 40
_WAYS = 4  # number of replicas whose paths are highlighted
_SKIPPED = 0.25  # share of initial frames to skip


def savePicture(output, summary, table):
    """Write the picture to an Output.

    Parameters
    ----------
    output : Output
    summary : dict
        from `summarizeReplicas`
    table : dict of arrays
        from `readIndex`
    """
    isExchange = bool(summary["exchanges"])
    hasEnergy = not np.isnan(table["potentialEnergy"][0])
    figure = makeFigure(10, 8 if isExchange else 4)
    replicas = countOf(summary["replicas"], "replica")
    setTitle(figure, summary["structure"], f", {replicas}, {countOf(summary['trials'], 'trial')} of each")
    grid = figure.add_gridspec(2 if isExchange else 1, 2)
    if hasEnergy:
        _drawHistograms(figure.add_subplot(grid[0, 0]), table, isExchange)
    else:
        _drawSizeHistograms(figure.add_subplot(grid[0, 0]), table)
    _drawSizes(figure.add_subplot(grid[0, 1]), table, isExchange)
    if isExchange:
        _drawRates(figure.add_subplot(grid[1, 0]), summary)
        _drawWays(figure.add_subplot(grid[1, 1]), table, summary)
    writeFigure(figure, output)


def _settled(table):
    """Whether rows belong to frames after the first quarter."""
    return table["frame"] > _SKIPPED * table["frame"].max()


def _groups(table, isExchange):
    """Return the rows of each temperature, or of each replica."""
    column = table["temperature" if isExchange else "replica"]
    return [(value, column == value) for value in np.unique(column)]


def _colors(count):
    from matplotlib import colormaps

    return colormaps["plasma"](np.linspace(0, 0.9, count))


def _drawHistograms(axis, table, isExchange):
    energies, settled = table["potentialEnergy"], _settled(table)
    edges = np.linspace(energies[settled].min(), energies[settled].max() + 1e-9, _BINS + 1)
    groups = _groups(table, isExchange)
    for (_, rows), color in zip(groups, _colors(len(groups)), strict=True):
        axis.hist(energies[rows & settled], edges, histtype="step", color=color)
    axis.set(title="Potential energy, last three quarters", xlabel="kJ/mol", ylabel="frames")
    axis.xaxis.set_major_formatter("{x:,.0f}")


def _drawSizeHistograms(axis, table):
    settled = _settled(table)
    axis.hist(table["radiusOfGyration"][settled], _BINS, histtype="step", color="#1f5f8b")
    axis.set(title="Radius of gyration of all replicas, last three quarters", xlabel="nm", ylabel="frames")


def _drawSizes(axis, table, isExchange):
    groups = _groups(table, isExchange)
    for (value, rows), color in zip(groups, _colors(len(groups)), strict=True):
        label = f"{value:.0f} K" if isExchange and value in (groups[0][0], groups[-1][0]) else None
        axis.plot(table["trials"][rows], table["radiusOfGyration"][rows], color=color, linewidth=0.8, label=label)
    axis.set(title="Radius of gyration", xlabel="trials", ylabel="nm")
    groupThousands(axis)
    if isExchange:
        axis.legend(fontsize="small", frameon=False)


def _drawRates(axis, summary):
    middles = [sum(exchange["temperatures"]) / 2 for exchange in summary["exchanges"]]
    rates = [100 * exchange["accepted"] / max(1, exchange["attempted"]) for exchange in summary["exchanges"]]
    axis.plot(middles, rates, marker="o", color="#1f5f8b")
    axis.set(title="Exchanges of neighbouring temperatures", xlabel="K", ylabel="% accepted", ylim=(0, 101))


def _drawWays(axis, table, summary):
    temperatures = [entry["temperature"] for entry in summary["temperatures"]]
    shown = np.unique(np.linspace(0, summary["replicas"] - 1, _WAYS).astype(int))
    for replica, color in zip(shown, _colors(len(shown)), strict=True):
        rows = table["replica"] == replica
        numbers = np.searchsorted(temperatures, table["temperature"][rows])
        axis.step(table["trials"][rows], numbers, where="mid", color=color, linewidth=0.9, label=f"replica {replica}")
    trips = sum(summary["roundTrips"])
    axis.set(title=f"Ways of {len(shown)} replicas; {countOf(trips, 'round trip')} of all", xlabel="trials", ylabel="K")
    places = np.unique(np.linspace(0, len(temperatures) - 1, min(len(temperatures), 7)).astype(int))
    axis.set_yticks(places, [f"{temperatures[place]:.0f}" for place in places])
    groupThousands(axis)
