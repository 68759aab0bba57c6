"""Error by time: of positions that turns lead to, and of verdicts where spheres all but touch."""

import math
import textwrap
from typing import NamedTuple

from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
from openmmchaintree.command.pictures.figures import makeFigure, writeFigure
from racing.races import INSTRUCTION_SETS
from racing.table import groupBy, sizeOf

from .goals import LARGEST_ERROR, SIGMA
from .tables import isOurs, nameOf, relativeError, stationsOf

_OURS, _DOUBLE, _SINGLE = "#1f5f8b", "#d55e00", "#999999"
_SIZE = 10000  # of chains, spheres, that are drawn if they are there
_FONT = 8.5
_NEAR = 25  # pixels
_WIDTH = 22  # of labels, letters
_BAND = SIGMA / 10  # where those stand who make no mistake


def hasPicture(entries):
    """Return whether there is anything to draw."""
    return any(entry["group"] in ("drift", "touch") for entry in entries)


def savePicture(output, machine, entries):
    """Write the picture of entries, with positions or verdicts, to an Output."""
    drift = _ofOneSize([entry for entry in entries if entry["group"] == "drift"])
    touch = _ofOneSize([entry for entry in entries if entry["group"] == "touch"])
    panels = [(draw, ofPanel) for draw, ofPanel in ((_drawDrift, drift), (_drawTouch, touch)) if ofPanel]
    figure = makeFigure(6.6 * len(panels), 5.4)
    words = "blue: the engine; other ways, orange: in double, grey: in single precision"
    figure.suptitle(f"{machine['processor']}; {words}", fontsize=_FONT, color="0.4")
    axes = list(figure.subplots(1, len(panels), squeeze=False).flat)
    labels = [
        draw(axis, [entry for entry in ofPanel if _isDrawn(entry["contestant"])])
        for axis, (draw, ofPanel) in zip(axes, panels, strict=True)
    ]
    figure.draw_without_rendering()  # which lays the axes out; what stands beside what is known from then on
    for axis, ofAxis in zip(axes, labels, strict=True):
        _write(axis, ofAxis)
    writeFigure(figure, output)


def _isDrawn(contestant):
    """Leave out ways of testing trials that the engine would not take by itself."""
    return not contestant.startswith("ours-") or contestant.removeprefix("ours-") in INSTRUCTION_SETS


def _ofOneSize(entries):
    sizes = groupBy(entries, sizeOf)
    return sizes.get(_SIZE) or (sizes[max(sizes)] if sizes else [])


def _colorOf(entry):
    if isOurs(entry):
        return _OURS
    return _SINGLE if "single" in entry["contestant"] else _DOUBLE


# ---- Positions ----


def _drawDrift(axis, entries):
    """Draw a trail for each path, and return the labels."""
    labels = []
    size = sizeOf(entries[0])
    turns = sorted({entry["turns"] for entry in entries})
    # Before that, most torsions are where they were.
    turns = [n for n in turns if n >= size] or turns
    for contestant, stations in stationsOf(entries).items():
        shown = [stations[n] for n in turns if n in stations]
        if shown:
            x = [entry["microseconds"] for entry in shown]
            y = [relativeError(entry) for entry in shown]
            color = _colorOf(shown[0])
            axis.plot(x, y, color=color, linewidth=2, alpha=0.45)
            axis.plot(x[:1], y[:1], "o", color=color, markersize=5.5, markerfacecolor="white")
            axis.plot(x[-1:], y[-1:], "o", color=color, markersize=7)
            words = "ours, with its volumes" if isOurs(shown[0]) else nameOf(contestant)
            labels.append(_Label(words, x[-1], y[-1], color))
    axis.set(
        title=f"Positions after {turns[0]:,} turns (ring), and up to {turns[-1]:,} (dot)",
        xlabel=f"µs a turn, chain of {size:,} spheres",
        ylabel="largest error of a distance / size of the chain",
    )
    _finish(axis, labels)
    _drawLine(axis, LARGEST_ERROR, "goal")
    return labels


# ---- Verdicts ----


def _drawTouch(axis, entries):
    """Draw the mistakes of each contestant, and return the labels."""
    labels = []
    for entry in entries:
        color, x = _colorOf(entry), entry["microseconds"]
        missed, invented = entry["largestMissed"], entry["largestInvented"]
        if missed > 0 or invented == 0:
            axis.plot(x, missed or _BAND, "o", color=color, markersize=7)
        if invented > 0:
            axis.plot(x, invented, "o", color=color, markersize=5.5, markerfacecolor="white")
        labels.append(_Label(nameOf(entry["contestant"]), x, max(missed, invented) or _BAND, color))
    axis.set(
        title="Verdicts where spheres all but touch",
        xlabel=f"µs a trial, chain of {sizeOf(entries[0]):,} spheres",
        ylabel="worst overlap missed (dot), gap called a clash (ring), nm",
    )
    _finish(axis, labels)
    axis.set_ylim(_BAND / 30, 10 * max([_BAND, *(label.y for label in labels)]))
    ticks = [tick for tick in axis.get_yticks() if SIGMA < tick <= axis.get_ylim()[1]]
    axis.set_yticks([_BAND, *ticks], ["none", *(f"$10^{{{round(math.log10(tick))}}}$" for tick in ticks)])
    _drawLine(axis, SIGMA, "no trial stops nearer to touching")
    return labels


# ---- What panels share ----


class _Label(NamedTuple):
    words: str
    x: float
    y: float
    color: str


def _finish(axis, labels):
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_xlim(min(label.x for label in labels) / 6, 4 * max(label.x for label in labels))
    axis.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.xaxis.set_minor_locator(NullLocator())
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.6g}"))
    axis.yaxis.set_major_locator(LogLocator(numticks=20, base=100))
    axis.yaxis.set_minor_locator(NullLocator())
    axis.grid(color="0.93", linewidth=0.8)
    axis.set_axisbelow(True)
    axis.spines[["top", "right"]].set_visible(False)


def _drawLine(axis, value, words):
    axis.axhline(value, color="0.5", linewidth=1, linestyle=":")
    axis.annotate(
        words, (1, value), xycoords=("axes fraction", "data"), xytext=(-2, 3), textcoords="offset points",
        ha="right", fontsize=_FONT, color="0.4",
    )  # fmt: skip


# Where a label can stand: how far from its point (in points), and which of its sides is there.
_PLACES = (
    (8, 0, "left", "center"),
    (-8, 0, "right", "center"),
    (0, 8, "center", "bottom"),
    (0, -8, "center", "top"),
    (6, 6, "left", "bottom"),
    (6, -6, "left", "top"),
    (-6, 6, "right", "bottom"),
    (-6, -6, "right", "top"),
    (0, 22, "center", "bottom"),
    (0, -22, "center", "top"),
)


def _write(axis, labels):
    """Write labels beside their points, those of points that fall together in one, where nothing else stands."""
    renderer = axis.figure.canvas.get_renderer()
    taken = [line.get_window_extent(renderer).padded(3) for line in axis.lines]
    taken += [text.get_window_extent(renderer) for text in axis.texts]
    for words, place in _gather(axis, labels):
        best = None
        for dx, dy, ha, va in _PLACES:
            text = axis.annotate(
                words, (place.x, place.y), xytext=(dx, dy), textcoords="offset points", ha=ha, va=va, fontsize=_FONT,
                color="0.4" if place.color == _SINGLE else place.color,
                fontweight="bold" if place.color == _OURS else "normal",
            )  # fmt: skip
            box = text.get_window_extent(renderer)
            inside = axis.get_window_extent(renderer)
            isWithin = box.x0 >= inside.x0 and box.x1 <= inside.x1 and box.y0 >= inside.y0 and box.y1 <= inside.y1
            collisions = box.count_overlaps(taken) + (0 if isWithin else 100)
            if best is None or collisions < best[0]:
                if best is not None:
                    best[1].remove()
                best = collisions, text, box
            else:
                text.remove()
        taken.append(best[2])


def _gather(axis, labels):
    """Return (words, label) of labels whose points are not a dot apart, joined; of several the last is the place."""
    gathered = []
    for label in sorted(labels, key=lambda label: (label.color, label.x)):
        x, y = axis.transData.transform((label.x, label.y))
        for group in gathered:
            if math.hypot(group[1][0] - x, group[1][1] - y) < _NEAR and group[2].color == label.color:
                if label.words not in group[0]:
                    group[0].append(label.words)
                group[1:] = [(x, y), label]
                break
        else:
            gathered.append([[label.words], (x, y), label])
    return [("\n".join(textwrap.fill(ofOne, _WIDTH) for ofOne in words), label) for words, _, label in gathered]
