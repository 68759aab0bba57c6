"""Functions for all pictures: new figures, titles, legends, scales of counts, and files."""

import io
import logging
import warnings
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from ..terminal import printable

# Hide Matplotlib's message on building a font cache on its first run.
logging.getLogger("matplotlib").setLevel(logging.ERROR)

_DPI = 150
_WIDEST_TITLE = 0.96  # of the figure's width
_LEGEND_COLUMNS = 5
_COUNTS = np.outer(10 ** np.arange(15), (1, 2, 5)).ravel()


def makeFigure(width, height):
    """Return an empty Figure of a size in inches, whose layout makes room for all labels."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def setTitle(figure, name, words):
    """Put a file's name and some words above a Figure, without the middle of a name that is too long."""
    name = printable(name)
    title = figure.suptitle(f"{name}{words}", parse_math=False)
    widest = _WIDEST_TITLE * figure.bbox.width
    kept = len(name)
    while title.get_window_extent().width > widest and kept > 2:
        kept -= max(1, kept // 20)
        title.set_text(f"{name[: kept - kept // 2]}…{name[len(name) - kept // 2 :]}{words}")


def addLegendBelow(axis):
    """Add a legend of an axis below its Figure, in the largest number of columns that fit."""
    figure = axis.figure
    for columns in range(_LEGEND_COLUMNS, 0, -1):
        legend = figure.legend(
            *axis.get_legend_handles_labels(),
            loc="outside lower center",
            ncols=columns,
            fontsize="small",
            frameon=False,
        )
        if columns == 1 or legend.get_window_extent().width <= figure.bbox.width:
            return
        legend.remove()


def countNorm(counts):
    """Return a logarithmic scale of colours for whole numbers up to the largest of `counts`."""
    return LogNorm(1, max(2, np.max(counts)))


def addCountBar(image, axis, label):
    """Add a colour bar with the scale of `countNorm` and whole numbers."""
    ticks = _COUNTS[_COUNTS <= image.norm.vmax]
    bar = axis.figure.colorbar(image, ax=axis, label=label, shrink=0.85, ticks=ticks, format="{x:,.0f}")
    bar.minorticks_off()


def groupThousands(axis):
    """Write large numbers along an axis of trials with commas, and few of them."""
    axis.xaxis.set_major_formatter("{x:,.0f}")
    axis.locator_params(axis="x", nbins=5)


def writeFigure(figure, output):
    """Write a Figure to an Output, in the format of its file extension."""
    content = io.BytesIO()
    form = Path(output.name).suffix.lower()[1:]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about letters that the font lacks
        if form == "png":
            # The same as savefig, which would draw everything twice.
            figure.set_dpi(_DPI)
            figure.canvas.print_png(content)
        else:
            figure.savefig(content, dpi=_DPI, format=form)
    output.write(content.getvalue())
