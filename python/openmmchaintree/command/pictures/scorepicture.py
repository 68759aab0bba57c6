"""The picture of scores: which residues of a model clash with which, or the course of models or frames."""

from pathlib import Path

import numpy as np
from matplotlib import colormaps

from ...residues import isWater
from ...structures.clashsearch import FrameOverlaps
from .clashpicture import Residues, drawCourse, drawMap, markChains
from .figures import makeFigure, setTitle, writeFigure

# A larger map merges residues, and shows the sum of their clashes.
_LARGEST_MAP = 600


def savePicture(output, search, models, definition, word):
    """Write the picture of plain scores to an Output.

    search : ScoreSearch; models : list of dict, its plain scores; definition : "molprobity" or "own", whose clashes are
    drawn; word : "frame" or "model"
    """
    frames = [_framesOf(model, definition) for model in models]
    residues = Residues(search.names, _drawnAtoms(search.topology, frames))
    figure = makeFigure(10, 7 if len(frames) > 1 else 9)
    name = Path(search.source).name
    if len(frames) == 1:
        setTitle(figure, name, f": {frames[0].clashesPer1000Atoms:.1f} clashes per 1,000 atoms")
        _drawPairs(figure.subplots(), frames[0], residues)
    else:
        average = np.mean([frame.clashesPer1000Atoms for frame in frames])
        setTitle(figure, name, f": {average:.1f} clashes per 1,000 atoms on average")
        upper, lower = figure.subplots(2, 1, sharex=True)
        drawCourse(upper, frames, f"{word.capitalize()}s")
        drawMap(lower, frames, word, residues)
    writeFigure(figure, output)


def _drawnAtoms(topology, frames):
    """Return the atoms of residues that are drawn: all but water, and water that clashes."""
    clashing = set(np.concatenate([frame.pairs.ravel() for frame in frames]).tolist())
    drawn = []
    for residue in topology.residues():
        own = [atom.index for atom in residue.atoms()]
        if not isWater(residue) or not clashing.isdisjoint(own):
            drawn += own
    return drawn


def _framesOf(model, definition):
    score = model[definition]
    pairs = np.array([(pair["particle1"], pair["particle2"]) for pair in score["pairs"]], dtype=int).reshape(-1, 2)
    overlaps = np.array([pair["overlap"] for pair in score["pairs"]])
    per1000 = score["clashscore"] if "clashscore" in score else score["per1000Atoms"]
    return FrameOverlaps(model["model"], pairs, overlaps, per1000)


def _drawPairs(axis, frame, residues):
    """Draw the number of clashes of each two residues, the first along both axes."""
    count = len(residues.labels)
    size = min(count, _LARGEST_MAP)
    counts = np.zeros((size, size), dtype=int)
    first, second = residues.ofParticle[frame.pairs].T * size // count
    np.add.at(counts, (first, second), 1)
    np.add.at(counts, (second[first != second], first[first != second]), 1)
    most = max(counts.max(), 1)
    # Points, since single residues of a long chain would be too small to be seen.
    rows, columns = np.nonzero(counts)
    places = (rows + 0.5) * count / size - 0.5, (columns + 0.5) * count / size - 0.5
    points = axis.scatter(
        *places, c=counts[rows, columns], s=max(4.0, (400 / count) ** 2), marker="s", cmap=colormaps["viridis_r"],
        vmin=1, vmax=max(most, 2), zorder=3,
    )  # fmt: skip
    axis.plot((-0.5, count - 0.5), (-0.5, count - 0.5), color="0.8", linewidth=0.8)
    axis.set(title="Residues", xlim=(-0.5, count - 0.5), ylim=(count - 0.5, -0.5), aspect="equal")
    axis.figure.colorbar(points, ax=axis, label="clashes", format="{x:,.0f}")
    markChains(axis.xaxis, residues)
    markChains(axis.yaxis, residues)
