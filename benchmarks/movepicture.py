"""What single moves do to folded proteins, and how many more independent samples the default moves give than pivots."""

from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter, PercentFormatter
from measure import OURS
from movetables import DEFAULTS, PIVOTS
from report import racesOf

_KINDS = {"pivot": "#d55e00", "closed": "#1f5f8b", "local": "#009e73", "χ": "#7a5195", "side": "#e69f00"}
_MARKERS = ("o", "s", "^", "D")
# What bars stand for.
_BARS = {
    "phi": ("φ", "#1f5f8b"),
    "psi": ("ψ", "#56b4e9"),
    "chi1": ("χ1", "#e69f00"),
    "slow": ("slow torsions", "#d55e00"),
}
_FONT = 8.5


def draw(machine, entries):
    """Return the Figure of entries, or None if there is nothing to draw."""
    panels = []
    for group, drawPanel in (("moves", _drawMoves), ("stationary", _drawRatios)):
        ofGroup = [race[OURS] for race in racesOf(entries, group)]
        if ofGroup:
            panels.append((drawPanel, ofGroup))
    if not panels:
        return None
    figure = Figure(figsize=(5.6 * len(panels), 4.4), layout="constrained")
    figure.suptitle(f"AMBER14 with GBn2 at 300 K, folded; {machine['processor']}", fontsize="medium")
    for axis, (drawPanel, ofGroup) in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        drawPanel(axis, ofGroup)
        axis.tick_params(labelsize=_FONT - 1.5)
        axis.grid(color="0.9", linewidth=0.8)
        axis.set_axisbelow(True)
    return figure


def _drawMoves(axis, entries):
    proteins = list(dict.fromkeys(entry["chain"] for entry in entries))
    for entry in entries:
        if entry["shift"] > 0 and entry["accepted"] > 0:
            kind = entry["moves"].replace(",", " ").split()[0]
            x, y = entry["accepted"] / entry["attempted"], 1e3 * entry["shift"] / entry["microseconds"]
            marker = _MARKERS[proteins.index(entry["chain"]) % len(_MARKERS)]
            axis.plot([x], [y], marker, color=_KINDS[kind], markersize=6)
    for kind, color in _KINDS.items():
        if any(entry["moves"].startswith(kind) for entry in entries):
            axis.plot([], [], "o", color=color, label={"side": "side chains drawn"}.get(kind, kind))
    for protein, marker in zip(proteins, _MARKERS, strict=False):
        axis.plot([], [], marker, color="0.4", label=protein)
    axis.set_yscale("log")
    axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.yaxis.set_minor_formatter(NullFormatter())
    axis.xaxis.set_major_formatter(PercentFormatter(1))
    axis.set_xlim(0, 1)
    axis.set_xlabel("accepted before outer tests", fontsize=_FONT)
    axis.set_ylabel("Σdr² of all atoms, nm² a ms", fontsize=_FONT)
    axis.legend(fontsize=_FONT - 1, frameon=False, ncols=2)


def _drawRatios(axis, entries):
    """Draw a group of bars for each protein: what default moves give at least, to pivots alone."""
    pivots = {entry["chain"]: entry for entry in entries if entry["moves"] == PIVOTS}
    lines = [entry for entry in entries if entry["moves"] == DEFAULTS and entry["chain"] in pivots]
    height = 0.8 / len(_BARS)
    for place, entry in enumerate(lines):
        for number, (key, (words, color)) in enumerate(_BARS.items()):
            if key in entry["rate"]:
                ratio, y = (
                    entry["rate"][key] / pivots[entry["chain"]]["rate"][key],
                    place - 0.4 + (number + 0.5) * height,
                )
                axis.barh(y, ratio, 0.9 * height, color=color, label=None if place > 0 else words)
    axis.set_xscale("log")
    axis.set_yticks(range(len(lines)), [entry["chain"] for entry in lines])
    axis.invert_yaxis()
    axis.set_xlabel("independent samples a second by default moves,\nat least, to pivots alone", fontsize=_FONT)
    axis.legend(fontsize=_FONT - 1, frameon=False)
