"""How far a protein travels with rigid and with flexible links, and by dynamics."""

from flexibletables import CONSTRAINED, RIGID, UNCONSTRAINED
from matplotlib.figure import Figure
from report import anyOf, racesOf

_COLORS = {RIGID: "#1f5f8b", UNCONSTRAINED: "#d55e00", CONSTRAINED: "#e69f00"}
_SHADES = ("#8fd0bb", "#009e73", "#00523c")  # of flexible links, by their shares of atom moves
_FONT = 8.5


def draw(machine, entries):
    """Return the Figure of entries, or None if there is nothing to draw."""
    races = [race for race in racesOf(entries, "travel") if any(entry["travel"] for entry in race.values())]
    if not races:
        return None
    figure = Figure(figsize=(4.6 * len(races), 4.4), layout="constrained")
    figure.suptitle(f"AMBER14 with GBn2 at 300 K, folded\n{machine['processor']}", fontsize="medium")
    for axis, race in zip(figure.subplots(1, len(races), squeeze=False)[0], races, strict=True):
        shades = iter(_SHADES)
        for name, entry in race.items():
            seconds = sorted(map(float, entry["travel"]))
            values = [entry["travel"][f"{lag:g}"] for lag in seconds]
            axis.loglog(seconds, values, "o-", color=_COLORS.get(name) or next(shades), label=name, markersize=4)
        axis.set_title(f"{anyOf(race)['chain']}, {anyOf(race)['particles']} atoms", fontsize=_FONT + 1)
        axis.set_xlabel("processor time, s", fontsize=_FONT)
        axis.set_ylabel("mean square displacement of Cα, Å²", fontsize=_FONT)
        axis.tick_params(labelsize=_FONT - 1.5)
        axis.grid(color="0.9", linewidth=0.8)
        axis.set_axisbelow(True)
        axis.legend(fontsize=_FONT - 1.5)
    return figure
