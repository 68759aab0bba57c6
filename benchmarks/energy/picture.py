"""Time of a trial by protein and force field, OpenMM's beside ours; and error by time."""

from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from openmmchaintree.command.pictures.figures import makeFigure, writeFigure
from racing.races import OURS
from racing.table import groupBy

from .rows import FOREIGN, MOVE_NAMES, ONE_ENERGY, STAGES, TRIALS, TWO_ENERGIES, WORK
from .tables import anyOf, combineRuns, widest

_COLORS = {
    "ours": "#1f5f8b",
    "ours, until refused": "#56b4e9",
    "OpenMM CPU, 1 energy": "#999999",
    "OpenMM CPU, 2 energies": "#d55e00",
}
_NUMBERED = ("ours", "OpenMM CPU, 1 energy")
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
    columns = min(2, len(panels))
    lines = (len(panels) + 1) // 2
    most = max([3, *(len(ofOne) for ofOne in work.values())])
    figure = makeFigure(6.2 * columns, 1.6 + (1.2 + 0.28 * most) * lines)
    figure.suptitle(
        ", ".join(filter(None, map(machine.get, ("processor", "instruction sets of the engine")))), fontsize="medium"
    )
    axes = list(figure.subplots(lines, columns, squeeze=False).flat)
    for draw, axis in zip(panels, axes, strict=False):
        draw(axis)
    for axis in axes[len(panels) :]:
        axis.set_axis_off()
    handles = {label: handle for axis in axes for handle, label in zip(*axis.get_legend_handles_labels(), strict=True)}
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=5, fontsize=_FONT, frameon=False)
    writeFigure(figure, output)


def _drawWork(axis, method, rows):
    dots = {
        "ours": [_value(widest(row)) for row in rows],
        "ours, until refused": [_value(row.get(STAGES), "mean") for row in rows],
        "OpenMM CPU, 1 energy": [_value(row.get(ONE_ENERGY)) for row in rows],
        "OpenMM CPU, 2 energies": [_value(row.get(TWO_ENERGIES)) for row in rows],
    }
    _drawDots(axis, [_label(row) for row in rows], dots)
    axis.set_title(f"Energy work of a trial, {method}", fontsize=_FONT + 1)


def _drawTrials(axis, rows):
    dots = {
        "ours": [_value(row.get(OURS)) for row in rows],
        "OpenMM CPU, 1 energy": [_value(row.get(FOREIGN)) for row in rows],
        "OpenMM CPU, 2 energies": [_value(row.get(TWO_ENERGIES)) for row in rows],
    }
    _drawDots(axis, [anyOf(row)["chain"] for row in rows], dots)
    axis.set_title("Whole trials, Simulation.step, reaction field", fontsize=_FONT + 1)


def _label(row):
    entry = anyOf(row)
    return f"{entry['chain']}, {MOVE_NAMES[entry['moves']]}"


def _value(entry, key="microseconds"):
    return None if entry is None else entry[key]


def _drawDots(axis, labels, dots):
    """Draw a line of dots for each label, the first on top."""
    places = range(len(labels))
    known = [[values[place] for values in dots.values() if values[place] is not None] for place in places]
    axis.hlines(places, [min(ofOne) for ofOne in known], [max(ofOne) for ofOne in known], color="0.85", linewidth=1)
    for name, values in dots.items():
        points = [(value, place) for place, value in enumerate(values) if value is not None]
        if points:
            axis.plot(*zip(*points, strict=True), "o", color=_COLORS[name], markersize=5, label=name)
        for value, place in points:
            if name in _NUMBERED:
                text = f"{value:,.3g}" if value < 1000 else f"{value:,.0f}"
                axis.annotate(
                    text, (value, place), (0, 4), textcoords="offset points", ha="center", fontsize=_FONT - 2.5
                )
    axis.set_yticks(places, labels, fontsize=_FONT - 1)
    axis.set_ylim(len(labels) - 0.5, -0.7)
    _finish(axis)


def _drawErrors(axis, rows):
    proteins = list(dict.fromkeys(anyOf(row)["chain"] for row in rows))
    for _, color, entryOf in (
        ("ours", _COLORS["ours"], widest),
        ("OpenMM CPU, 1 energy", _COLORS["OpenMM CPU, 1 energy"], lambda row: row.get(ONE_ENERGY)),
    ):
        for protein, marker in zip(proteins, _MARKERS * len(proteins), strict=False):
            points = [
                (entry["microseconds"], max(_LEAST, entry["changeError"]["rms"]))
                for entry in (entryOf(row) for row in rows if anyOf(row)["chain"] == protein)
                if entry is not None and "changeError" in entry
            ]
            if points:
                axis.plot(*zip(*points, strict=True), marker, color=color, markersize=5)
                if color == _COLORS["ours"]:
                    axis.plot([], [], marker, color="0.3", fillstyle="none", markersize=5, label=protein)
    axis.set_yscale("log")
    axis.set_ylabel("RMS error of ΔU, kJ/mol", fontsize=_FONT)
    axis.set_title("Error and time of a trial", fontsize=_FONT + 1)
    _finish(axis)


def _finish(axis):
    axis.set_xscale("log")
    axis.xaxis.set_major_locator(LogLocator())
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.6g}"))
    axis.set_xlabel("µs a trial", fontsize=_FONT)
    axis.tick_params(labelsize=_FONT - 2)
    axis.grid(axis="x", color="0.9", linewidth=0.8)
    axis.set_axisbelow(True)
