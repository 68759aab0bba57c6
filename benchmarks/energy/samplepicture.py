"""Independent samples a second by the trials of an outer test."""

from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from .samplerows import OBSERVABLES, SAMPLE_BLOCKS, SAMPLE_CUTOFFS
from .sampletables import OBSERVABLE_NAMES, combineSamples, relativeError

_COLORS = ("#e69f00", "#1f5f8b", "#009e73", "#7a5195")
_FONT = 8.5


def drawSamples(figure, entries):
    """Draw into a figure or a part of one: a line of panels for each protein."""
    proteins = list(combineSamples(entries).values())
    axes = figure.subplots(len(proteins), len(OBSERVABLES), squeeze=False, sharex=True)
    for line, settings in zip(axes, proteins, strict=True):
        for axis, key in zip(line, OBSERVABLES, strict=True):
            _draw(axis, settings, key)
        line[0].set_ylabel(f"{settings[0]['chain']}: independent\nsamples a second", fontsize=_FONT)
    for axis in axes[-1]:
        axis.set_xlabel("m, trials of an outer test", fontsize=_FONT)
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize=_FONT, frameon=False)


def _draw(axis, settings, key):
    error = relativeError(settings, key) or 0.0
    for number, (cutoffs, color) in enumerate(zip(SAMPLE_CUTOFFS, _COLORS, strict=True)):
        points = [
            (setting["block"] * (0.95 + 0.033 * number), setting["rate"][key])
            for setting in settings
            if (setting["bornCutoff"], setting["pairCutoff"]) == cutoffs
        ]
        if points:
            blocks, rates = zip(*points, strict=True)
            label = (
                f"{cutoffs[0]} / {cutoffs[1]} nm" if number > 0 else f"Born sums {cutoffs[0]} / pairs {cutoffs[1]} nm"
            )
            bars = [error * rate for rate in rates]
            axis.errorbar(blocks, rates, bars, color=color, marker="o", markersize=3, linewidth=1, label=label)
    axis.set_title(OBSERVABLE_NAMES[key], fontsize=_FONT + 1)
    axis.set_xscale("log")
    axis.xaxis.set_major_locator(FixedLocator(SAMPLE_BLOCKS))
    axis.xaxis.set_minor_locator(NullLocator())
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_ylim(bottom=0)
    axis.tick_params(labelsize=_FONT - 1.5)
    axis.grid(color="0.9", linewidth=0.8)
    axis.set_axisbelow(True)
