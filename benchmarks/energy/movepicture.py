"""What single moves do to folded proteins, and how much more independent samples mixtures of them give than pivots."""

from matplotlib.ticker import FuncFormatter, NullFormatter, PercentFormatter
from openmmchaintree.command.pictures.figures import makeFigure, writeFigure

from .moverows import MIXTURES, MOVES, PIVOTS
from .movetables import combine

_KINDS = {"pivot": "#d55e00", "closed": "#1f5f8b", "local": "#009e73", "χ": "#7a5195", "side": "#e69f00"}
_MARKERS = ("o", "s", "^", "D")
# What bars stand for; not the RMSD, of which chains of minutes have too few independent ones.
_BARS = {
    "phi": ("φ", "#1f5f8b"),
    "psi": ("ψ", "#56b4e9"),
    "chi1": ("χ1", "#e69f00"),
    "slow": ("slow torsions", "#d55e00"),
}
_FONT = 8.5


def hasPicture(entries):
    """Return whether there is anything to draw."""
    return any(entry["group"] in (MOVES, MIXTURES) for entry in entries)


def savePicture(output, machine, entries):
    """Write the picture of entries to an Output."""
    drawn = []
    for group, draw in ((MOVES, _drawMoves), (MIXTURES, _drawMixtures)):
        some = [entry for entry in entries if entry["group"] == group]
        if some:
            drawn.append((draw, some))
    figure = makeFigure(5.6 * len(drawn), 4.4)
    figure.suptitle(f"AMBER14 with GBn2 at 300 K, folded; {machine['processor']}", fontsize="medium")
    for axis, (draw, some) in zip(figure.subplots(1, len(drawn), squeeze=False)[0], drawn, strict=True):
        draw(axis, combine(some))
        axis.tick_params(labelsize=_FONT - 1.5)
        axis.grid(color="0.9", linewidth=0.8)
        axis.set_axisbelow(True)
    writeFigure(figure, output)


def _drawMoves(axis, entries):
    proteins = list(dict.fromkeys(entry["chain"] for entry in entries))
    for entry in entries:
        if entry["shift"] > 0 and entry["accepted"] > 0:
            kind = entry["moves"].replace(",", " ").split()[0]
            axis.plot(
                [entry["accepted"] / entry["attempted"]],
                [1e3 * entry["shift"] / entry["microseconds"]],
                _MARKERS[proteins.index(entry["chain"]) % len(_MARKERS)],
                color=_KINDS[kind],
                markersize=6,
            )
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
    axis.set_xlabel("accepted by what trials see", fontsize=_FONT)
    axis.set_ylabel("Σdr² of all atoms, nm² a ms", fontsize=_FONT)
    axis.legend(fontsize=_FONT - 1, frameon=False, ncols=2)


def _drawMixtures(axis, entries):
    lines = [entry for entry in entries if entry["moves"] != PIVOTS]
    height = 0.8 / len(_BARS)
    for place, entry in enumerate(lines):
        pivots = next((one for one in entries if one["chain"] == entry["chain"] and one["moves"] == PIVOTS), None)
        if pivots is None:
            continue
        for number, (key, (_, color)) in enumerate(_BARS.items()):
            if key in entry["rate"]:
                top = place - 0.4 + (number + 0.5) * height
                axis.barh(top, entry["rate"][key] / pivots["rate"][key], 0.9 * height, color=color)
    for words, color in _BARS.values():
        axis.barh([0], [0], color=color, label=words)
    axis.axvline(1, color="0.3", linewidth=1)
    axis.set_yticks(range(len(lines)), [f"{entry['chain']}: {entry['moves']}" for entry in lines])
    axis.invert_yaxis()
    axis.set_xlabel("independent samples a second, by those of pivots alone", fontsize=_FONT)
    axis.legend(fontsize=_FONT - 1, frameon=False)
