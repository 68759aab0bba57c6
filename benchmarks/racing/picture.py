"""The paper's figures 7 and 8 and its table 1, drawn anew."""

from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator
from openmmchaintree.command.pictures.figures import makeFigure, writeFigure

from .races import FULL_GRID, LAZY_GRID, OURS, SIMD_GRID, VERLET
from .table import groupBy, sizeOf
from .tables import NAMES, PAPER_TESTS, combineChains, nameInPaper, proteinOf

# Those who are drawn, with colours that people tell apart who see few.
_STYLES = {
    FULL_GRID: ("#999999", "s"),
    LAZY_GRID: ("#56b4e9", "s"),
    SIMD_GRID: ("#0072b2", "X"),
    VERLET: ("#f0c000", "h"),
    "obbtree1": ("#e69f00", "^"),
    "kobbtree": ("#009e73", "v"),
    "published": ("#cc79a7", "D"),
    "improved": ("#d55e00", "P"),
    OURS: ("#1f5f8b", "o"),
}
_PAPER_STYLES = {"ChainTree": "published", "K-OBBTree": "kobbtree"}


def hasPicture(entries):
    """Return whether there is anything to draw."""
    return bool(findDrawn(entries))


def savePicture(output, machine, entries):
    """Write the picture of entries to an Output: of those that ran all their trials, on however many chains."""
    entries = findDrawn(entries)
    chains = [entry for entry in entries if entry["chain"] == "random compact"]
    proteins = sorted((entry for entry in entries if entry["chain"] != "random compact"), key=sizeOf)
    columns = [(ofOne, keyOf) for ofOne, keyOf in ((chains, sizeOf), (proteins, proteinOf)) if ofOne]
    figure = makeFigure(2 + 4.5 * len(columns), 8.5)
    figure.suptitle(_titleOf(machine, entries), fontsize="medium")
    axes = figure.subplots(2, len(columns), squeeze=False)
    for (upper, lower), (ofColumn, keyOf) in zip(axes.T, columns, strict=True):
        races = groupBy(ofColumn, keyOf)
        figureName = "Figure 7: compact chains" if keyOf is sizeOf else "Figure 8: backbones of proteins"
        tableName = "Table 1 (a): compact chains" if keyOf is sizeOf else "Table 1 (b): backbones of proteins"
        _drawTimes(upper, races, figureName)
        _drawTests(lower, races, tableName)
    handles = {
        label: handle for axis in axes.flat for handle, label in zip(*axis.get_legend_handles_labels(), strict=True)
    }
    figure.legend(
        handles.values(), handles.keys(), loc="outside lower center", ncols=5, fontsize="small", frameon=False
    )
    writeFigure(figure, output)


def findDrawn(entries):
    """Return what the picture shows of entries, one for all chains of a contestant."""
    drawn = [entry for entry in entries if entry["group"] == "figures" and entry["contestant"] in _STYLES]
    return combineChains(drawn)


def _titleOf(machine, entries):
    trials = ", ".join(f"{count:,}" for count in sorted({entry["trials"] for entry in entries}))
    chains = max(entry["chains"] for entry in entries)
    sets = machine["instruction sets of the engine"]
    spread = (
        "one chain of each kind" if chains == 1 else f"up to {chains} chains of each kind: medians, and their range"
    )
    return f"{machine['processor']}, {sets}\n{trials} trials from each start; {spread}"


def _drawTimes(axis, races, title):
    for contestant, (color, marker) in _STYLES.items():
        points = _pointsOf(races, contestant, lambda entry: entry["microseconds"])
        bars = _pointsOf(races, contestant, lambda entry: (entry["least"], entry["most"]))
        if points:
            places, values = zip(*points, strict=True)
            width = 2.2 if contestant == OURS else 1.2
            axis.plot(
                places, values, color=color, marker=marker, markersize=5, linewidth=width, label=NAMES[contestant]
            )
            axis.vlines(places, *zip(*(bar for _, bar in bars), strict=True), color=color, linewidth=width)
    axis.set(title=title, ylabel="µs a trial")
    _finish(axis, races)


def _drawTests(axis, races, title):
    for contestant, (color, marker) in _STYLES.items():
        points = [point for point in _pointsOf(races, contestant, lambda entry: entry["volumeTests"]) if point[1]]
        if points:
            axis.plot(
                *zip(*points, strict=True),
                color=color,
                marker=marker,
                markersize=5,
                linewidth=1.2,
                label=NAMES[contestant],
            )
    for name, contestant in _PAPER_STYLES.items():
        color, marker = _STYLES[contestant]
        tests = PAPER_TESTS[name]
        keys = [nameInPaper(key) for key in races]
        points = [(place, tests[key]) for place, key in enumerate(keys) if key in tests]
        if points:
            axis.plot(
                *zip(*points, strict=True),
                color=color,
                marker=marker,
                markersize=7,
                fillstyle="none",
                linestyle=":",
                linewidth=1.2,
                label=f"{name} in the paper",
            )
    axis.set(title=title, ylabel="tests of bounding volumes a query")
    _finish(axis, races)


def _pointsOf(races, contestant, valueOf):
    """Return the (place, value) of a contestant in the races that it runs in."""
    return [
        (place, valueOf(entry))
        for place, ofRace in enumerate(races.values())
        for entry in ofRace
        if entry["contestant"] == contestant
    ]


def _finish(axis, races):
    axis.set_yscale("log")
    axis.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.yaxis.set_minor_formatter(NullFormatter())
    axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.6g}"))
    axis.grid(axis="y", color="0.9", linewidth=0.8)
    axis.xaxis.set_minor_locator(NullLocator())
    labels = [
        f"{key:,}" if isinstance(key, int) else f"{key.removesuffix(' backbone')}\n{ofRace[0]['particles']:,}"
        for key, ofRace in races.items()
    ]
    axis.set_xticks(range(len(races)), labels)
    axis.set_xlim(-0.3, len(races) - 0.7)
    axis.set_xlabel("spheres" if isinstance(next(iter(races)), int) else "protein, atoms")
