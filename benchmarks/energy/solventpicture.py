"""How near stand-ins are and how many outer tests keep their trials, by the time of a trial; independent samples."""

from matplotlib.ticker import FuncFormatter, MultipleLocator
from openmmchaintree.command.pictures.figures import makeFigure, writeFigure

from .samplepicture import drawSamples
from .samplerows import SAMPLES
from .solventrows import BLOCKS, CUTOFFS, STAND_INS
from .solventtables import acceptance
from .tables import anyOf, combineRuns

_COLORS = ("#d55e00", "#e69f00", "#1f5f8b", "#009e73", "#7a5195")
_MARKERS = ("^", "s", "o")
_FONT = 8.5


def hasPicture(entries):
    """Return whether there is anything to draw."""
    return any(entry["group"] in (STAND_INS, SAMPLES) for entry in entries)


def savePicture(output, machine, entries):
    """Write the picture of entries to an Output."""
    rows = [row for row in combineRuns(entries) if anyOf(row)["group"] == STAND_INS]
    sampled = {(entry["chain"], entry["asked"]) for entry in entries if entry["group"] == SAMPLES}
    heights = [*([6.0] if rows else []), *([0.7 + 2.0 * len(sampled)] if sampled else [])]
    figure = makeFigure(3.9 * max(2, len(rows)), 0.4 + sum(heights))
    figure.suptitle(f"AMBER14 with GBn2; {machine['processor']}", fontsize="medium")
    parts = list(figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False).flat)
    if sampled:
        drawSamples(parts.pop(), entries)
    if rows:
        _drawStandIns(parts.pop(), rows)
    writeFigure(figure, output)


def _drawStandIns(figure, rows):
    axes = figure.subplots(2, len(rows), squeeze=False, sharex="col", sharey="row")
    for column, row in enumerate(rows):
        entry = anyOf(row)
        axes[0][column].set_title(f"{entry['chain']}, {entry['particles']:,} atoms", fontsize=_FONT + 1)
        _draw(axes[0][column], row, lambda entry: entry["outer"]["deviation"])
        _draw(axes[1][column], row, acceptance)
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


def _draw(axis, row, valueOf):
    for cutoffs, color in zip(CUTOFFS, _COLORS, strict=True):
        points = [
            (entry["microseconds"], valueOf(entry), _MARKERS[BLOCKS.index(entry["block"])])
            for entry in row.values()
            if (entry["bornCutoff"], entry["pairCutoff"]) == cutoffs
        ]
        axis.plot(*zip(*(point[:2] for point in points), strict=True), color=color, linewidth=1)
        for time, value, marker in points:
            axis.plot([time], [value], marker, color=color, markersize=6)
    axis.set_xlim(left=0)
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.6g}"))
    axis.tick_params(labelsize=_FONT - 1.5)
    axis.grid(color="0.9", linewidth=0.8)
    axis.set_axisbelow(True)
