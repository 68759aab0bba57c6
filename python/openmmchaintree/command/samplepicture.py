"""The picture of a sampling run: Ramachandran plots before and after, radius of gyration and acceptance along it."""

import logging

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

# Its word on building a font cache, on a first run, is not for those who run a command.
logging.getLogger("matplotlib").setLevel(logging.ERROR)

_BINS = np.linspace(-180, 180, 37)
_COLOR = "#1f5f8b"


def savePicture(path, title, frames, moveNames):
    """Save the picture of frames, the start and at least one more, as PNG, PDF or SVG by the name of the file."""
    figure = Figure(figsize=(10, 8), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    axes = figure.subplots(2, 2)
    _drawRamachandranStart(axes[0, 0], frames[0])
    _drawRamachandranSampled(axes[0, 1], frames[1:])
    _drawRadiusOfGyration(axes[1, 0], frames)
    _drawAcceptance(axes[1, 1], frames, moveNames)
    figure.savefig(path, dpi=150)


def _drawRamachandranStart(axis, frame):
    phi, psi = np.degrees(frame.phiPsi).T
    axis.scatter(phi, psi, s=14, color=_COLOR)
    _finishRamachandran(axis, f"Start: {len(phi)} residues")


def _drawRamachandranSampled(axis, frames):
    phi, psi = np.degrees(np.concatenate([frame.phiPsi for frame in frames])).T
    image = None
    if len(phi):
        *_, image = axis.hist2d(phi, psi, bins=(_BINS, _BINS), norm=LogNorm(), cmap="viridis_r", rasterized=True)
    _finishRamachandran(axis, f"Sampled: {len(frames)} frames")
    if image is not None:
        axis.figure.colorbar(image, ax=axis, label="residues in 10° × 10°", shrink=0.85, format="%g")


def _finishRamachandran(axis, title):
    axis.set(title=title, xlabel="φ (°)", ylabel="ψ (°)", xlim=(-180, 180), ylim=(-180, 180), aspect="equal")
    axis.set_xticks(range(-180, 181, 90))
    axis.set_yticks(range(-180, 181, 90))
    axis.axhline(0, color="0.8", linewidth=0.8, zorder=0)
    axis.axvline(0, color="0.8", linewidth=0.8, zorder=0)


def _drawRadiusOfGyration(axis, frames):
    trials = [frame.trials for frame in frames]
    axis.plot(trials, [frame.radiusOfGyration for frame in frames], color=_COLOR)
    axis.set(title="Radius of gyration", xlabel="trials", ylabel="nm", xlim=(0, trials[-1]))
    _groupThousands(axis)


def _drawAcceptance(axis, frames, moveNames):
    trials = np.array([frame.trials for frame in frames])
    # Several frames together where a single one holds too few trials for a smooth line.
    edges = np.unique(np.linspace(0, len(frames) - 1, min(len(frames), 41)).astype(int))
    counts = np.diff(np.array([frames[edge].counts for edge in edges]), axis=0)
    middles = (trials[edges[1:]] + trials[edges[:-1]]) / 2
    for move, name in enumerate(moveNames):
        attempted, accepted = counts[:, move, 0], counts[:, move, 3]
        drawn = attempted > 0
        axis.plot(middles[drawn], 100 * accepted[drawn] / attempted[drawn], label=name)
    axis.set(title="Acceptance", xlabel="trials", ylabel="% of the move's trials", xlim=(0, trials[-1]), ylim=(0, 100))
    axis.legend(fontsize="small", loc="best")
    _groupThousands(axis)


def _groupThousands(axis):
    axis.xaxis.set_major_formatter("{x:,.0f}")
    axis.locator_params(axis="x", nbins=5)
