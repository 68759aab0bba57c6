"""The picture of a sampling run: torsions before and after; radius of gyration, acceptance and energy along it.

Torsions are shown as Ramachandran plots if a residue has both φ and ψ, otherwise by kind; without torsions, not shown.
"""

import numpy as np

from ...notes import countOf
from .figures import addCountBar, addLegendBelow, countNorm, groupThousands, makeFigure, setTitle, writeFigure

_BIN = 10  # degrees
_EDGES = np.arange(-180, 181, _BIN)
_COLOR = "#1f5f8b"
_FEWEST_TRIALS = 20  # trials of a move between points of the acceptance curve
_FEWEST_INTERVALS, _MOST_INTERVALS = 10, 40
_LARGEST_START = 5  # times the range of later energies

# In the order of the picture.
_LETTERS = {
    "phi": "φ", "psi": "ψ", "omega": "ω", "chi1": "χ1", "chi2": "χ2", "chi3": "χ3", "chi4": "χ4",
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ε", "zeta": "ζ", "chi": "χ", "rotor": "rotor",
    "planar": "planar", "other": "other",
}  # fmt: skip


def savePicture(output, summary, table, angles, torsionKinds, history):
    """Write the picture of at least two frames, including the start, to an Output.

    Parameters
    ----------
    output : Output
    summary : dict
        from `summarize`
    table : dict of arrays
        from `readIndex`
    angles : list of ShownAngles
        of each frame
    torsionKinds : list of str
        the kind of each rotating torsion, in the order of `ShownAngles.torsions`, used if no residue has both φ and ψ
    history : list
        of the RunState
    """
    hasEnergy = summary["energy"] is not None
    rows = 1 + bool(torsionKinds) + hasEnergy
    figure = makeFigure(10, 4 * rows)
    setTitle(figure, summary["structure"], f", {countOf(summary['trials'], 'trial')}")
    grid = figure.add_gridspec(rows, 2)
    row = 0
    if torsionKinds:
        drawTorsions = _drawRamachandran if len(angles[0].phiPsi) else _drawKinds
        drawTorsions([figure.add_subplot(grid[0, column]) for column in range(2)], angles, torsionKinds)
        row = 1
    if hasEnergy:
        _drawEnergy(figure.add_subplot(grid[row, :]), table)
    _drawRadiusOfGyration(figure.add_subplot(grid[-1, 0]), table)
    _drawAcceptance(figure.add_subplot(grid[-1, 1]), table, summary["moves"], history)
    writeFigure(figure, output)


def _drawRamachandran(axes, angles, torsionKinds):
    phi, psi = np.degrees(angles[0].phiPsi).T
    axes[0].scatter(phi, psi, s=14, color=_COLOR, clip_on=False)
    _finishRamachandran(axes[0], f"Start: {countOf(len(phi), 'residue')}")

    phi, psi = np.degrees(np.concatenate([frame.phiPsi for frame in angles[1:]])).T
    _drawCounts(axes[1], phi, psi, _EDGES, "residues in 10° × 10°")
    _finishRamachandran(axes[1], f"Sampled: {countOf(len(angles) - 1, 'frame')}")


def _drawKinds(axes, angles, torsionKinds):
    """Draw the angles of all torsions, a column per kind."""
    kinds = [kind for kind in _LETTERS if kind in torsionKinds]
    columns = np.array([kinds.index(kind) for kind in torsionKinds])
    axes[0].scatter(columns, np.degrees(angles[0].torsions), s=14, color=_COLOR, clip_on=False)
    _finishKinds(axes[0], f"Start: {countOf(len(columns), 'torsion')}", kinds)

    turned = np.degrees(np.concatenate([frame.torsions for frame in angles[1:]]))
    edges = np.arange(len(kinds) + 1) - 0.5
    _drawCounts(axes[1], np.tile(columns, len(angles) - 1), turned, edges, "torsions in 10°")
    _finishKinds(axes[1], f"Sampled: {countOf(len(angles) - 1, 'frame')}", kinds)


def _drawCounts(axis, x, angles, edges, label):
    counts, *_ = np.histogram2d(x, angles, bins=(edges, _EDGES))
    shown = np.ma.masked_equal(counts.T, 0)
    image = axis.pcolormesh(edges, _EDGES, shown, norm=countNorm(counts), cmap="viridis_r", rasterized=True)
    addCountBar(image, axis, label)


def _finishKinds(axis, title, kinds):
    axis.set(title=title, ylabel="angle (°)", xlim=(-0.5, len(kinds) - 0.5), ylim=(-180, 180))
    axis.set_xticks(range(len(kinds)), [_LETTERS[kind] for kind in kinds])
    axis.set_yticks(range(-180, 181, 90))
    axis.axhline(0, color="0.8", linewidth=0.8, zorder=0)


def _finishRamachandran(axis, title):
    axis.set(title=title, xlabel="φ (°)", ylabel="ψ (°)", xlim=(-180, 180), ylim=(-180, 180), aspect="equal")
    axis.set_xticks(range(-180, 181, 90))
    axis.set_yticks(range(-180, 181, 90))
    axis.axhline(0, color="0.8", linewidth=0.8, zorder=0)
    axis.axvline(0, color="0.8", linewidth=0.8, zorder=0)


def _drawRadiusOfGyration(axis, table):
    trials = table["trials"]
    axis.plot(trials, table["radiusOfGyration"], color=_COLOR)
    axis.set(title="Radius of gyration", xlabel="trials", ylabel="nm", xlim=(0, trials[-1]))
    groupThousands(axis)


def _drawEnergy(axis, table):
    """Draw U along the run, without the start if its clashes would dominate the scale."""
    trials, energies = table["trials"], table["potentialEnergy"]
    axis.plot(trials, energies, color=_COLOR)
    title = "Potential energy"
    settled = energies[len(energies) // 4 :]
    low, high = energies.min(), settled.max()
    room = max(high - low, 1.0)
    if energies.max() > high + _LARGEST_START * room:
        axis.set_ylim(low - 0.05 * room, high + room)
        title += f" (not shown: the beginning, from {energies.max():,.0f} kJ/mol down)"
    axis.set(title=title, xlabel="trials", ylabel="kJ/mol", xlim=(0, trials[-1]))
    axis.yaxis.set_major_formatter("{x:,.0f}")
    groupThousands(axis)


def _drawAcceptance(axis, table, moves, history):
    """Draw the acceptance of each move between frames of the history."""
    final = [[move["attempted"], move["accepted"]] for move in moves]
    kept = [[0, np.zeros_like(final).tolist()], *history]
    if kept[-1][0] < table["frame"][-1]:
        kept.append([table["frame"][-1], final])
    trials = table["trials"][[frame for frame, _ in kept]]
    counts = np.array([rows for _, rows in kept])
    # Merge frames if one has too few trials of the rarest move for a smooth line.
    intervals = np.clip(counts[-1, :, 0].min() // _FEWEST_TRIALS, _FEWEST_INTERVALS, _MOST_INTERVALS)
    edges = np.unique(np.linspace(0, len(kept) - 1, min(len(kept), intervals + 1)).astype(int))
    counts = np.diff(counts[edges], axis=0)
    middles = (trials[edges[1:]] + trials[edges[:-1]]) / 2
    marker = "o" if len(middles) == 1 else None
    for move, name in enumerate(move["name"] for move in moves):
        attempted, accepted = counts[:, move].T
        drawn = attempted > 0
        axis.plot(middles[drawn], 100 * accepted[drawn] / attempted[drawn], marker=marker, label=name)
    axis.set(title="Acceptance", xlabel="trials", ylabel="% of the move's trials", xlim=(0, trials[-1]), ylim=(0, 101))
    addLegendBelow(axis)
    groupThousands(axis)
