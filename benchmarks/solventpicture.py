"""How near stand-ins are to U, and how many outer tests keep their trials, by the time of a trial."""

from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MultipleLocator
from report import anyOf, racesOf
from solventtables import BLOCKS, CUTOFFS, keptOf

_COLORS = ("#d55e00", "#e69f00", "#1f5f8b", "#009e73", "#7a5195")
_MARKERS = ("^", "s", "o")
_FONT = 8.5


def draw(machine, entries):
    """Return the Figure of entries, or None if there is nothing to draw."""
    races = racesOf(entries, "standins")
    if not races:
        return None
    figure = Figure(figsize=(3.9 * max(2, len(races)), 6.4), layout="constrained")
    figure.suptitle(f"AMBER14 with GBn2; {machine['processor']}", fontsize="medium")
    axes = figure.subplots(2, len(races), squeeze=False, sharex="col", sharey="row")
    for column, race in enumerate(races):
        entry = anyOf(race)
        axes[0][column].set_title(f"{entry['chain']}, {entry['particles']:,} atoms", fontsize=_FONT + 1)
        _draw(axes[0][column], race, lambda entry: entry["outer"]["deviation"])
        _draw(axes[1][column], race, keptOf)
        axes[1][column].set_xlabel("µs a trial, outer tests included", fontsize=_FONT)
    axes[0][0].set_ylabel("difference of an outer test,\nstandard deviation, kJ/mol", fontsize=_FONT)
    axes[0][0].set_ylim(bottom=0)
    axes[1][0].set_ylabel("outer tests that kept their trials", fontsize=_FONT)
    axes[1][0].set_ylim(0, 1)
    axes[1][0].yaxis.set_major_locator(MultipleLocator(0.2))
    for cutoffs, color in zip(CUTOFFS, _COLORS, strict=True):
        axes[0][0].plot([], [], color=color, label=f"Born sums {cutoffs[0]} nm, pairs {cutoffs[1]} nm")
    for block, marker in zip(BLOCKS, _MARKERS, strict=True):
        axes[0][0].plot([], [], marker, color="0.4", label=f"m = {block}")
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=_FONT, frameon=False)
    return figure


def _draw(axis, race, valueOf):
    for cutoffs, color in zip(CUTOFFS, _COLORS, strict=True):
        ofOne = [entry for entry in race.values() if (entry["bornCutoff"], entry["pairCutoff"]) == cutoffs]
        axis.plot([e["microseconds"] for e in ofOne], [*map(valueOf, ofOne)], color=color, linewidth=1)
        for entry in ofOne:
            marker = _MARKERS[BLOCKS.index(entry["block"])]
            axis.plot([entry["microseconds"]], [valueOf(entry)], marker, color=color, markersize=6)
    axis.set_xlim(left=0)
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.6g}"))
    axis.tick_params(labelsize=_FONT - 1.5)
    axis.grid(color="0.9", linewidth=0.8)
    axis.set_axisbelow(True)
