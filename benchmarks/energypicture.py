"""Time of a trial by protein and force field, OpenMM's beside ours; and error by time."""

from energytables import FOREIGN, ONE_ENERGY, STAGES, TWO_ENERGIES, widest
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from measure import OURS
from report import anyOf, groupBy, racesOf

_COLORS = {
    "ours": "#1f5f8b",
    "ours, until refused": "#56b4e9",
    "OpenMM CPU, 1 energy": "#999999",
    "OpenMM CPU, 2 energies": "#d55e00",
}
_NUMBERED = ("ours", "OpenMM CPU, 1 energy")
_MARKERS = ("o", "s", "^", "D", "v")
_FONT = 8.5


def draw(machine, entries):
    """Return the Figure of entries, or None if there is nothing to draw."""
    work, trials = racesOf(entries, "work"), racesOf(entries, "trials")
    methods = groupBy(work, lambda race: anyOf(race)["method"])
    panels = [lambda axis, ofOne=ofOne, name=name: _drawWork(axis, name, ofOne) for name, ofOne in methods.items()]
    panels += [lambda axis: _drawTrials(axis, trials)] if trials else []
    panels += [lambda axis: _drawErrors(axis, work)] if work else []
    if not panels:
        return None
    columns, lines = min(2, len(panels)), (len(panels) + 1) // 2
    most = max([3, *map(len, methods.values())])
    figure = Figure(figsize=(6.2 * columns, 1.6 + (1.2 + 0.28 * most) * lines), layout="constrained")
    figure.suptitle(machine["processor"], fontsize="medium")
    axes = list(figure.subplots(lines, columns, squeeze=False).flat)
    for drawPanel, axis in zip(panels, axes, strict=False):
        drawPanel(axis)
    for axis in axes[len(panels) :]:
        axis.set_axis_off()
    handles = {label: handle for axis in axes for handle, label in zip(*axis.get_legend_handles_labels(), strict=True)}
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=5, fontsize=_FONT, frameon=False)
    return figure


def _drawWork(axis, method, races):
    dots = {
        "ours": [widest(race)["microseconds"] for race in races],
        "ours, until refused": [race[STAGES]["mean"] for race in races],
        "OpenMM CPU, 1 energy": [race[ONE_ENERGY]["microseconds"] for race in races if ONE_ENERGY in race],
        "OpenMM CPU, 2 energies": [race[TWO_ENERGIES]["microseconds"] for race in races if TWO_ENERGIES in race],
    }
    _drawDots(axis, [f"{anyOf(race)['chain']}, {anyOf(race)['moves']}" for race in races], dots)
    axis.set_title(f"Energy work of a trial, {method}", fontsize=_FONT + 1)


def _drawTrials(axis, races):
    contestants = {"ours": OURS, "OpenMM CPU, 1 energy": FOREIGN, "OpenMM CPU, 2 energies": TWO_ENERGIES}
    dots = {name: [race[key]["microseconds"] for race in races] for name, key in contestants.items()}
    _drawDots(axis, [anyOf(race)["chain"] for race in races], dots)
    axis.set_title("Whole trials, Simulation.step, reaction field", fontsize=_FONT + 1)


def _drawDots(axis, labels, dots):
    """Draw a line of dots for each label, the first on top."""
    dots = {name: values for name, values in dots.items() if len(values) == len(labels)}
    ofLabels = list(zip(*dots.values(), strict=True))
    axis.hlines(range(len(labels)), [*map(min, ofLabels)], [*map(max, ofLabels)], color="0.85", linewidth=1)
    for name, values in dots.items():
        axis.plot(values, range(len(labels)), "o", color=_COLORS[name], markersize=5, label=name)
        for place, value in enumerate(values if name in _NUMBERED else []):
            text = f"{value:,.3g}" if value < 1000 else f"{value:,.0f}"
            axis.annotate(text, (value, place), (0, 4), textcoords="offset points", ha="center", fontsize=_FONT - 2.5)
    axis.set_yticks(range(len(labels)), labels, fontsize=_FONT - 1)
    axis.set_ylim(len(labels) - 0.5, -0.7)
    _finish(axis)


def _drawErrors(axis, races):
    proteins = groupBy(races, lambda race: anyOf(race)["chain"])
    for (protein, ofOne), marker in zip(proteins.items(), _MARKERS * len(proteins), strict=False):
        ours = [widest(race) for race in ofOne]
        others = [race[ONE_ENERGY] for race in ofOne if ONE_ENERGY in race]
        for entries, color in ((ours, _COLORS["ours"]), (others, _COLORS["OpenMM CPU, 1 energy"])):
            times, errors = [e["microseconds"] for e in entries], [e["changeError"]["rms"] for e in entries]
            axis.plot(times, errors, marker, color=color, markersize=5)
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
