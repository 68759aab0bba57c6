"""Pictures of the command: none has an empty plot, counts are whole numbers, and all words are inside."""

import numpy as np
import pytest
from openmm import app, unit
from openmmchaintree.command.outputs.output import Output
from openmmchaintree.command.pictures import clashpicture, samplepicture
from openmmchaintree.command.sampling import ShownAngles
from openmmchaintree.structures.clashsearch import ClashSearch
from scenes import writeDCD

LONG_NAME = "W$_" * 80
MOVES = [f"{name} ±{angle}°" for name in ("φ/ψ", "χ", "sugar and phosphate") for angle in (5, 30, 180)]
NUCLEIC = ["alpha", "beta", "gamma", "epsilon", "zeta", "chi"]


@pytest.fixture
def draw(tmp_path, monkeypatch):
    """A function that has a module save a picture, and returns its Figure."""

    def draw(module, *arguments):
        figures = []
        monkeypatch.setattr(module, "writeFigure", lambda figure, output: figures.append(figure))
        module.savePicture(Output(str(tmp_path / "a.png")), *arguments)
        return figures[0]

    return draw


def assertSound(figure):
    """No plot without anything in it, no word that is cut off, no fraction on a scale of counts."""
    figure.canvas.draw()
    words, inside = figure.get_tightbbox(), figure.bbox_inches
    assert inside.x0 <= words.x0 and words.x1 <= inside.x1, words
    assert inside.y0 <= words.y0 and words.y1 <= inside.y1, words
    for axis in figure.axes:
        assert [*axis.lines, *axis.collections, *axis.images, *axis.patches]
        for scale, label in ((axis.xaxis, axis.get_xlabel()), (axis.yaxis, axis.get_ylabel())):
            if label in ("clashes", "residues in 10° × 10°", "torsions in 10°"):
                low, high = scale.get_view_interval()
                ticks = [tick for tick in scale.get_majorticklocs() if low <= tick <= high]
                assert ticks and all(tick == round(tick) for tick in ticks), (label, ticks)


def drawRun(draw, name, count, residues, torsionKinds, moves=MOVES, energies=None):
    """Return the Figure of a run with a number of frames."""
    random = np.random.default_rng(1)

    def angles(*shape):
        return random.uniform(-np.pi, np.pi, shape)

    frames = np.arange(count)
    table = {"frame": frames, "trials": 100 * frames, "radiusOfGyration": random.random(count)}
    table["potentialEnergy"] = np.full(count, np.nan) if energies is None else energies
    summary = {
        "structure": name,
        "trials": 100 * (count - 1),
        "energy": energies,
        "moves": [{"name": move, "attempted": 9 * (count - 1), "accepted": 9 * (count - 1)} for move in moves],
    }
    torsions = 0 if residues else len(torsionKinds)
    shown = [ShownAngles(angles(residues, 2), angles(torsions)) for _ in frames]
    history = [[int(frame), [[9 * int(frame)] * 2] * len(moves)] for frame in frames[1:]]
    return draw(samplepicture, summary, table, shown, torsionKinds, history)


# ---- Sampling ----


@pytest.mark.parametrize(("count", "residues"), [(2, 1), (30, 500)])
def test_ramachandran(draw, count, residues):
    figure = drawRun(draw, "villin", count, residues, ["phi", "psi"])
    assertSound(figure)
    start, sampled = figure.axes[:2]
    assert start.get_title() == f"Start: {residues} residue{'s' if residues > 1 else ''}"
    assert (start.get_xlabel(), sampled.get_xlabel()) == ("φ (°)", "φ (°)")
    assert len(start.collections[0].get_offsets()) == residues


@pytest.mark.parametrize("start", [-40.0, 1e7])
@pytest.mark.parametrize("count", [2, 30])
def test_energy(draw, start, count):
    """A start with clashes does not dwarf the rest, and is told."""
    energies = np.array([start, *(-100.0 - np.arange(1, count))])
    figure = drawRun(draw, "villin", count, 5, ["phi", "psi"], energies=energies)
    assertSound(figure)
    (axis,) = [axis for axis in figure.axes if axis.get_ylabel() == "kJ/mol"]
    low, high = axis.get_ylim()
    assert low < energies.min() and energies[1:].max() < high
    if start < 0 or count == 2:  # of two frames one is the start
        assert axis.get_title() == "Potential energy" and start < high
    else:
        assert "from 10,000,000 kJ/mol down" in axis.get_title() and high < 1000


@pytest.mark.parametrize(("kinds", "letters"), [(["psi", "phi"], "φψ"), (3 * NUCLEIC, "αβγεζχ"), (["chi1"], ["χ1"])])
def test_torsionsByKindWhereNoResidueHasBoth(draw, kinds, letters):
    figure = drawRun(draw, "1bna", 5, 0, kinds)
    assertSound(figure)
    start, sampled = figure.axes[:2]
    for axis in (start, sampled):
        assert [label.get_text() for label in axis.get_xticklabels()] == list(letters)
    assert len(start.collections[0].get_offsets()) == len(kinds)
    assert sampled.collections[0].get_array().sum() == 4 * len(kinds)


def test_noTorsions(draw):
    """As where molecules move only as a whole."""
    figure = drawRun(draw, "ligand", 5, 0, [], MOVES[:1])
    assertSound(figure)
    assert [axis.get_title() for axis in figure.axes] == ["Radius of gyration", "Acceptance"]


def test_longNames(draw):
    figure = drawRun(draw, LONG_NAME, 3, 5, ["phi", "psi"], [f"{move} {'long' * 5}" for move in MOVES])
    assertSound(figure)
    title = figure.get_suptitle()
    assert title.startswith("W$_") and "…" in title and title.endswith(", 200 trials")


# ---- Clashes ----


def search(tmp_path, villin, frames, name="run"):
    with open(tmp_path / f"{name}.pdb", "w") as file:
        app.PDBFile.writeFile(villin.topology, villin.positions * unit.nanometer, file)
    return ClashSearch(tmp_path / f"{name}.pdb", writeDCD(tmp_path / name, villin.topology, frames))


@pytest.mark.parametrize("scales", [(1,), (3,), (1, 3, 1), (3, 3), (1, 0.5, 0.97)])
def test_clashes(draw, tmp_path, villin, scales):
    """Of one frame or several, with none, one or thousands of clashes."""
    found = search(tmp_path, villin, [scale * villin.positions for scale in scales])
    assertSound(draw(clashpicture, found, list(found.overlaps())))


def test_longNamesOfClashes(draw, tmp_path, villin, monkeypatch):
    found = search(tmp_path, villin, [villin.positions, villin.positions], "W" * 200)
    finder = found.finder
    finder.names = [
        name._replace(chain=f"Chain-{number // 200}", residue=f"{name.residue} and more")
        for number, name in enumerate(finder.names)
    ]
    frames = list(found.overlaps())
    for shown in (frames, frames[:1]):
        figure = draw(clashpicture, found, shown)
        assertSound(figure)
        assert "…" in figure.get_suptitle() and "1.7 clashes per 1,000 atoms" in figure.get_suptitle()


def test_manyChains(draw, tmp_path, villin):
    """Their names do not run into each other."""
    found = search(tmp_path, villin, [0.9 * villin.positions])
    found.finder.names = [
        name._replace(chain=f"{number // 12:03}", residue=f"GLY {number}")
        for number, name in enumerate(found.finder.names)
    ]
    figure = draw(clashpicture, found, list(found.overlaps()))
    assertSound(figure)
    boxes = [label.get_window_extent() for label in figure.axes[0].get_xticklabels() if label.get_text()]
    assert len(boxes) > 3
    boxes.sort(key=lambda box: box.x0)
    assert all(first.x1 < second.x0 for first, second in zip(boxes, boxes[1:], strict=False))
