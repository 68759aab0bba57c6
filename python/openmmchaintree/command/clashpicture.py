"""The picture of a search for clashes: of one frame its residues and overlaps, of several frames their course."""

import logging
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

# Its word on building a font cache, on a first run, is not for those who run a command.
logging.getLogger("matplotlib").setLevel(logging.ERROR)

_COLOR = "#1f5f8b"

# So many residues are named, if they are at least this part of the axis apart.
_NAMED_RESIDUES = 10
_LABEL_WIDTH = 0.015

# Chains that take less than this part of an axis are not named there.
_NARROWEST_CHAIN = 0.03

# A map with more rows or columns than one can see shows the largest number of several.
_LARGEST_MAP = 500


def savePicture(path, search, frames):
    """Save the picture of the FrameClashes that a ClashSearch found, in the format that the file's name tells."""
    figure = Figure(figsize=(10, 7), layout="constrained")
    FigureCanvasAgg(figure)
    source = Path(search.structure if search.trajectory is None else search.trajectory).name
    score = sum(frame.clashesPer1000Atoms for frame in frames) / len(frames)
    average = " on average" if len(frames) > 1 else ""
    figure.suptitle(f"{source}: {score:.1f} clashes per 1,000 atoms{average}")
    residues = _Residues(search)
    upper, lower = figure.subplots(2, 1, sharex=len(frames) > 1)
    if len(frames) == 1:
        _drawResidues(upper, frames[0], residues)
        _drawOverlaps(lower, frames[0])
    else:
        word = "model" if search.trajectory is None else "frame"
        _drawCourse(upper, frames, f"{word.capitalize()}s")
        _drawMap(lower, frames, word, residues)
    figure.savefig(path, dpi=150)


class _Residues:
    """The residues that are looked at, numbered chain by chain: heterogens come after the polymer of their chain.

    labels : list of str; chains : list of (name, first residue, residue after the last)
    """

    def __init__(self, search):
        names = {atom: search.finder.names[atom] for atom in search.finder.atoms.tolist()}
        chains = {}
        for name in names.values():
            chains.setdefault(name.chain, {}).setdefault(name.describeResidue())
        self.labels = [label for residues in chains.values() for label in residues]
        numbers = {label: number for number, label in enumerate(self.labels)}
        self._ofParticle = {atom: numbers[name.describeResidue()] for atom, name in names.items()}
        self.chains = []
        end = 0
        for chain, residues in chains.items():
            first, end = end, end + len(residues)
            self.chains.append((chain, first, end))

    def countClashes(self, frame):
        """Return the number of clashes of each residue in a frame, as an int array."""
        counts = np.zeros(len(self.labels), dtype=int)
        for clash in frame.clashes:
            for residue in {self._ofParticle[clash.particle1], self._ofParticle[clash.particle2]}:
                counts[residue] += 1
        return counts


def _drawResidues(axis, frame, residues):
    counts = residues.countClashes(frame)
    numbers = np.flatnonzero(counts)
    axis.vlines(numbers, 0, counts[numbers], color=_COLOR, linewidth=1.5)
    named = []
    # A single clash is nothing to name a residue for, unless none has more.
    notable = numbers[counts[numbers] >= min(2, counts.max(initial=0))]
    for residue in notable[np.argsort(-counts[notable], kind="stable")][:_NAMED_RESIDUES]:
        if all(abs(residue - other) > _LABEL_WIDTH * len(counts) for other in named):
            named.append(residue)
            place = {"xytext": (0, 5), "textcoords": "offset points", "rotation": 90, "ha": "center"}
            box = {"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none"}
            axis.annotate(residues.labels[residue], (residue, counts[residue]), fontsize="small", bbox=box, **place)
    margin = _LABEL_WIDTH * len(counts)
    axis.set(title="Residues", ylabel="clashes", xlim=(-margin, len(counts) - 1 + margin))
    axis.set_ylim(0, 1.6 * max(counts.max(initial=0), 1))
    axis.yaxis.set_major_locator(MaxNLocator(integer=True))
    _markChains(axis.xaxis, residues)


def _drawOverlaps(axis, frame):
    overlaps = [clash.overlap for clash in frame.clashes]
    bins = np.arange(0.04, max([0.14, *overlaps]) + 0.01, 0.005)
    counts, *_ = axis.hist(overlaps, bins=bins, color=_COLOR, edgecolor="white")
    axis.set(title="Overlaps", xlabel="overlap (nm)", ylabel="clashes", ylim=(0, 1.05 * max(counts.max(), 1)))
    axis.yaxis.set_major_locator(MaxNLocator(integer=True))


def _drawCourse(axis, frames, title):
    scores = [frame.clashesPer1000Atoms for frame in frames]
    axis.plot(range(len(scores)), scores, color=_COLOR, linewidth=1)
    axis.set(title=title, ylabel="clashes per 1,000 atoms", ylim=(0, 1.1 * max(max(scores), 1)))


def _drawMap(axis, frames, word, residues):
    rowCount, columnCount = min(len(residues.labels), _LARGEST_MAP), min(len(frames), _LARGEST_MAP)
    counts = np.zeros((rowCount, columnCount), dtype=int)
    rows = np.arange(len(residues.labels)) * rowCount // len(residues.labels)
    for number, frame in enumerate(frames):
        column = counts[:, number * columnCount // len(frames)]
        np.maximum.at(column, rows, residues.countClashes(frame))
    most = max(counts.max(), 1)
    image = axis.imshow(
        np.ma.masked_equal(counts, 0),
        aspect="auto",
        interpolation="nearest",
        cmap=colormaps["viridis_r"].resampled(most),
        vmin=0.5,
        vmax=most + 0.5,
        extent=(-0.5, len(frames) - 0.5, len(residues.labels) - 0.5, -0.5),
    )
    axis.set(title="Residues", xlabel=f"{word} (from 0)")
    axis.xaxis.set_major_locator(MaxNLocator(integer=True))
    ticks = MaxNLocator(integer=True, nbins=6)
    axis.figure.colorbar(image, ax=axis, label="clashes", ticks=ticks)
    _markChains(axis.yaxis, residues)


def _markChains(axis, residues):
    """Name chains along an axis of residues; a single one by some of its residues."""
    count = len(residues.labels)
    if len(residues.chains) == 1:
        numbers = np.unique(np.linspace(0, count - 1, min(count, 8)).astype(int))
        axis.set_ticks(numbers, [residues.labels[number] for number in numbers], fontsize="small")
        return
    wide = [(name, first, end) for name, first, end in residues.chains if end - first >= _NARROWEST_CHAIN * count]
    axis.set_ticks([(first + end - 1) / 2 for _, first, end in wide], [f"chain {name}" for name, *_ in wide])
    axis.set_tick_params(length=0)
    axis.set_ticks([first - 0.5 for _, first, _ in residues.chains[1:]], minor=True)
    axis.set_tick_params(which="minor", length=10)
    axis.grid(which="minor", color="0.8", linewidth=0.8)
