"""Time of a trial by protein and force field, OpenMM's beside ours; and error by time."""

from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from openmmchaintree.command.figures import makeFigure, writeFigure
from racing.races import OURS
from racing.table import groupBy

from .rows import FOREIGN, MOVE_NAMES, ONE_ENERGY, STAGES, TRIALS, TWO_ENERGIES, WORK
from .tables import anyOf, combineRuns, widest

_COLORS = {"ours": "#1f5f8b", "until refused": "#56b4e9", "1 energy": "#999999", "2 energies": "#d55e00"}
_MARKERS = ("o", "s", "^", "D", "v")
_FONT = 8.5
_LEAST = 1e-8  # kJ/mol: where those stand who make no error


def hasPicture(entries):
    """Return whether there is anything to draw."""
    return any(entry["group"] in (WORK, TRIALS) for entry in entries)


def savePicture(output, machine, entries):
    """Write the picture of entries to an Output."""
    rows = combineRuns(entries)
    work = groupBy((row for row in rows if anyOf(row)["group"] == WORK), lambda row: anyOf(row)["method"])
    trials = [row for row in rows if anyOf(row)["group"] == TRIALS]
    panels = [
        (lambda axis, ofPanel=ofPanel, name=name: _drawWork(axis, name, ofPanel)) for name, ofPanel in work.items()
    ]
    if trials:
        panels.append(lambda axis: _drawTrials(axis, trials))
    if work:
        panels.append(lambda axis: _drawErrors(axis, [row for ofOne in work.values() for row in ofOne]))
    figure = makeFigure(5.2 * len(panels), 5.2)
    figure.suptitle(f"{machine['processor']}, {machine['instruction sets of the engine']}", fontsize="medium")
    for draw, axis in zip(panels, figure.subplots(1, len(panels), squeeze=False).flat, strict=True):
        draw(axis)
    writeFigure(figure, output)


def _drawWork(axis, method, rows):
    labels = [_label(row) for row in rows]
    bars = {
        "ours": [_value(widest(row)) for row in rows],
        "until refused": [_value(row.get(STAGES), "mean") for row in rows],
        "1 energy": [_value(row.get(ONE_ENERGY)) for row in rows],
        "2 energies": [_value(row.get(TWO_ENERGIES)) for row in rows],
    }
    _drawBars(axis, labels, bars)
    axis.set_title(f"Energy work of a trial, {method}", fontsize=_FONT + 1)


def _drawTrials(axis, rows):
    bars = {
        "ours": [_value(row.get(OURS)) for row in rows],
        "1 energy": [_value(row.get(FOREIGN)) for row in rows],
        "2 energies": [_value(row.get(TWO_ENERGIES)) for row in rows],
    }
    _drawBars(axis, [anyOf(row)["chain"] for row in rows], bars)
    axis.set_title("Whole trials, Simulation.step", fontsize=_FONT + 1)


def _label(row):
    entry = anyOf(row)
    return f"{entry['chain']}\n{MOVE_NAMES[entry['moves']]}"


def _value(entry, key="microseconds"):
    return None if entry is None else entry[key]


def _drawBars(axis, labels, bars):
    """Draw horizontal bars, the first row on top."""
    drawn = {name: values for name, values in bars.items() if any(value is not None for value in values)}
    height = 0.8 / max(1, len(drawn))
    for number, (name, values) in enumerate(drawn.items()):
        places = [place + number * height for place, value in enumerate(values) if value is not None]
        widths = [value for value in values if value is not None]
        axis.barh(places, widths, 0.9 * height, color=_COLORS[name], label=name)
        for place, width in zip(places, widths, strict=True):
            axis.text(
                width, place, f" {width:,.3g}" if width < 1000 else f" {width:,.0f}", va="center", fontsize=_FONT - 3
            )
    axis.set_yticks([place + 0.4 - height / 2 for place in range(len(labels))], labels, fontsize=_FONT - 2)
    axis.invert_yaxis()
    _finish(axis)
    axis.legend(fontsize=_FONT - 1, frameon=False, loc="lower right")


def _drawErrors(axis, rows):
    proteins = list(dict.fromkeys(anyOf(row)["chain"] for row in rows))
    for name, color, entryOf in (
        ("ours", _COLORS["ours"], widest),
        ("OpenMM CPU", _COLORS["1 energy"], lambda row: row.get(ONE_ENERGY)),
    ):
        for protein, marker in zip(proteins, _MARKERS * len(proteins), strict=False):
            points = [
                (entry["microseconds"], max(_LEAST, entry["changeError"]["rms"]))
                for entry in (entryOf(row) for row in rows if anyOf(row)["chain"] == protein)
                if entry is not None and "changeError" in entry
            ]
            if points:
                label = f"{name}, {protein}"
                axis.plot(*zip(*points, strict=True), marker, color=color, linestyle="none", markersize=5, label=label)
    axis.set_yscale("log")
    axis.set_ylabel("RMS error of ΔU, kJ/mol", fontsize=_FONT)
    axis.set_title("Error and time of a trial", fontsize=_FONT + 1)
    _finish(axis)
    axis.legend(fontsize=_FONT - 2, frameon=False)


def _finish(axis):
    axis.set_xscale("log")
    axis.xaxis.set_major_locator(LogLocator())
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.6g}"))
    axis.set_xlabel("µs a trial", fontsize=_FONT)
    axis.tick_params(labelsize=_FONT - 2)
    axis.grid(axis="x", color="0.9", linewidth=0.8)
    axis.set_axisbelow(True)
