"""The picture of a clash search: residues and overlaps of a single frame, or the course of several frames."""

from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.ticker import MaxNLocator

from .figures import makeFigure, setTitle, writeFigure

_COLOR = "#1f5f8b"

# Number of named residues, and their least distance as a fraction of the axis.
_NAMED_RESIDUES = 10
_LABEL_WIDTH = 0.015

# Sizes of a letter and a line as fractions of the axis; number of named residues along an axis.
_LETTER_WIDTH = 0.0105
_LETTER_HEIGHT = 0.024
_LINE_HEIGHT = 0.07
_RESIDUES_OF_A_CHAIN = 8

# A larger map merges rows or columns, and shows their maximum.
_LARGEST_MAP = 500


def savePicture(output, search, frames):
    """Write the picture of the FrameOverlaps of a ClashSearch to an Output."""
    figure = makeFigure(10, 7)
    source = Path(search.structure if search.trajectory is None else search.trajectory).name
    score = sum(frame.clashesPer1000Atoms for frame in frames) / len(frames)
    average = " on average" if len(frames) > 1 else ""
    setTitle(figure, source, f": {score:.1f} clashes per 1,000 atoms{average}")
    residues = Residues(search.finder.names, search.finder.atoms.tolist())
    upper, lower = figure.subplots(2, 1, sharex=len(frames) > 1)
    if len(frames) == 1:
        _drawResidues(upper, frames[0], residues)
        _drawOverlaps(lower, frames[0])
    else:
        word = "model" if search.trajectory is None else "frame"
        drawCourse(upper, frames, f"{word.capitalize()}s")
        drawMap(lower, frames, word, residues)
    writeFigure(figure, output)


class Residues:
    """The checked residues, numbered chain by chain; heterogens follow the polymer of their chain.

    labels : list of str; chains : list of (name, first residue, residue after the last); ofParticle : (n,) int array
    """

    def __init__(self, allNames, atoms):
        """Take the AtomName of every atom, and the indices of the checked atoms."""
        names = {atom: allNames[atom] for atom in atoms}
        chains = {}
        for name in names.values():
            chains.setdefault(name.chain, {}).setdefault(name.describeResidue())
        self.labels = [label for residues in chains.values() for label in residues]
        numbers = {label: number for number, label in enumerate(self.labels)}
        self.ofParticle = np.full(len(allNames), -1)
        for atom, name in names.items():
            self.ofParticle[atom] = numbers[name.describeResidue()]
        self.chains = []
        end = 0
        for chain, residues in chains.items():
            first, end = end, end + len(residues)
            self.chains.append((chain, first, end))

    def countClashes(self, frame):
        """Return the number of clashes of each residue in a frame, as an int array."""
        first, second = self.ofParticle[frame.pairs].T
        residues = np.concatenate([first, second[second != first]])
        return np.bincount(residues, minlength=len(self.labels))


def _drawResidues(axis, frame, residues):
    counts = residues.countClashes(frame)
    numbers = np.flatnonzero(counts)
    axis.vlines(numbers, 0, counts[numbers], color=_COLOR, linewidth=1.5)
    named = []
    # Residues with a single clash are named only if none has more.
    notable = numbers[counts[numbers] >= min(2, counts.max(initial=0))]
    for residue in notable[np.argsort(-counts[notable], kind="stable")][:_NAMED_RESIDUES]:
        if all(abs(residue - other) > _LABEL_WIDTH * len(counts) for other in named):
            named.append(residue)
            place = {"xytext": (0, 5), "textcoords": "offset points", "rotation": 90, "ha": "center"}
            box = {"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none"}
            axis.annotate(residues.labels[residue], (residue, counts[residue]), fontsize="small", bbox=box, **place)
    margin = _LABEL_WIDTH * len(counts)
    axis.set(title="Residues", ylabel="clashes", xlim=(-margin, len(counts) - 1 + margin))
    letters = max([len(residues.labels[residue]) for residue in named], default=0)
    axis.set_ylim(0, max(counts.max(initial=0), 1) / (1 - min(0.6, 0.05 + _LETTER_HEIGHT * letters)))
    axis.yaxis.set_major_locator(MaxNLocator(integer=True))
    markChains(axis.xaxis, residues)


def _drawOverlaps(axis, frame):
    overlaps = frame.overlaps.tolist()
    bins = np.arange(0.04, max([0.14, *overlaps]) + 0.01, 0.005)
    counts, *_ = axis.hist(overlaps, bins=bins, color=_COLOR, edgecolor="white")
    axis.set(title="Overlaps", xlabel="overlap (nm)", ylabel="clashes", ylim=(0, 1.05 * max(counts.max(), 1)))
    axis.yaxis.set_major_locator(MaxNLocator(integer=True))


def drawCourse(axis, frames, title):
    """Draw the clashes per 1,000 atoms of FrameOverlaps in their order."""
    scores = [frame.clashesPer1000Atoms for frame in frames]
    axis.plot(range(len(scores)), scores, color=_COLOR, linewidth=1)
    axis.set(title=title, ylabel="clashes per 1,000 atoms", ylim=(0, 1.1 * max(max(scores), 1)))


def drawMap(axis, frames, word, residues):
    """Draw the clashes of FrameOverlaps by frame and residue; word : "frame" or "model"."""
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
    ticks = MaxNLocator(integer=True, nbins=6).tick_values(0, most)
    ticks = ticks[(ticks >= 1) & (ticks <= most)]
    axis.figure.colorbar(image, ax=axis, label="clashes", ticks=ticks, format="{x:,.0f}")
    markChains(axis.yaxis, residues)


def markChains(axis, residues):
    """Name the chains along an axis of residues, or some residues of a single chain."""
    count = len(residues.labels)
    letterWidth = _LETTER_WIDTH if axis.axis_name == "x" else 0
    if len(residues.chains) == 1:
        longest = max(map(len, residues.labels))
        most = min(count, _RESIDUES_OF_A_CHAIN, max(2, int(1 / max(_LINE_HEIGHT, letterWidth * longest))))
        numbers = np.unique(np.linspace(0, count - 1, most).astype(int))
        axis.set_ticks(numbers, [residues.labels[number] for number in numbers], fontsize="small")
        return
    # (middle, half the width, label) of chains with room for a name, the longest first.
    named = []
    for name, first, end in sorted(residues.chains, key=lambda chain: chain[1] - chain[2]):
        label = f"chain {name}"
        middle, half = (first + end - 1) / 2, max(_LINE_HEIGHT, letterWidth * len(label)) * count / 2
        if all(abs(middle - other) >= half + otherHalf for other, otherHalf, _ in named):
            named.append((middle, half, label))
    axis.set_ticks([middle for middle, *_ in named], [label for *_, label in named])
    axis.set_tick_params(length=0, pad=11)  # below the marks between chains
    axis.set_ticks([first - 0.5 for _, first, _ in residues.chains[1:]], minor=True)
    axis.set_tick_params(which="minor", length=10)
    axis.grid(which="minor", color="0.8", linewidth=0.8)
