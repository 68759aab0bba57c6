"""The paper's figures 7 and 8 and its table 1, drawn from our races."""

from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator
from measure import OURS
from racetables import NAMES, PAPER_TESTS, columnOf
from report import anyOf, racesOf

# Those drawn, with colours that colour-blind people tell apart.
_STYLES = {
    "fullgrid": ("#999999", "s"),
    "lazygrid": ("#56b4e9", "s"),
    "simdgrid": ("#0072b2", "X"),
    "verletlist": ("#f0c000", "h"),
    "obbtree1": ("#e69f00", "^"),
    "kobbtree": ("#009e73", "v"),
    "published": ("#cc79a7", "D"),
    "improved": ("#d55e00", "P"),
    OURS: ("#1f5f8b", "o"),
}
_PAPER_STYLES = {"ChainTree": "published", "K-OBBTree": "kobbtree"}


def draw(machine, entries):
    """Return the Figure of entries, or None if there is nothing to draw."""
    races = racesOf(entries, "figures")
    chains = [race for race in races if anyOf(race)["chain"] == "random compact"]
    proteins = sorted((race for race in races if race not in chains), key=lambda race: anyOf(race)["particles"])
    parts = [(chains, "7: compact chains", "(a)"), (proteins, "8: backbones of proteins", "(b)")]
    parts = [part for part in parts if part[0]]
    if not parts:
        return None
    figure = Figure(figsize=(2 + 4.5 * len(parts), 8.5), layout="constrained")
    figure.suptitle(f"{machine['processor']}, {machine['instruction sets of the engine']}", fontsize="medium")
    axes = figure.subplots(2, len(parts), squeeze=False)
    for (upper, lower), (ofPart, words, letter) in zip(axes.T, parts, strict=True):
        _drawTimes(upper, ofPart)
        _finish(upper, ofPart, f"Figure {words}", "µs a trial")
        _drawTests(lower, ofPart)
        _finish(lower, ofPart, f"Table 1 {letter}: {words.partition(': ')[2]}", "tests of bounding volumes a query")
    handles = {
        label: handle for axis in axes.flat for handle, label in zip(*axis.get_legend_handles_labels(), strict=True)
    }
    figure.legend(
        handles.values(), handles.keys(), loc="outside lower center", ncols=5, fontsize="small", frameon=False
    )
    return figure


def _drawTimes(axis, races):
    for contestant, (color, marker) in _STYLES.items():
        places = [place for place, race in enumerate(races) if contestant in race]
        ofOne = [races[place][contestant] for place in places]
        if ofOne:
            width = 2.2 if contestant == OURS else 1.2
            times, label = [entry["microseconds"] for entry in ofOne], NAMES[contestant]
            axis.plot(places, times, color=color, marker=marker, markersize=5, linewidth=width, label=label)
            least, most = [entry["least"] for entry in ofOne], [entry["most"] for entry in ofOne]
            axis.vlines(places, least, most, color=color, linewidth=width)


def _drawTests(axis, races):
    for contestant, (color, marker) in _STYLES.items():
        tests = {place: race[contestant]["volumeTests"] for place, race in enumerate(races) if contestant in race}
        tests = {place: count for place, count in tests.items() if count > 0}
        if tests:
            label = NAMES[contestant]
            axis.plot(
                *zip(*tests.items(), strict=True), color=color, marker=marker, markersize=5, linewidth=1.2, label=label
            )
    for name, contestant in _PAPER_STYLES.items():
        color, marker = _STYLES[contestant]
        points = [(k, PAPER_TESTS[name].get(columnOf(race))) for k, race in enumerate(races)]
        points = [point for point in points if point[1] is not None]
        if points:
            style = {"markersize": 7, "fillstyle": "none", "linestyle": ":", "linewidth": 1.2}
            axis.plot(*zip(*points, strict=True), color=color, marker=marker, label=f"{name} in the paper", **style)


def _finish(axis, races, title, label):
    axis.set(title=title, ylabel=label, yscale="log", xlim=(-0.3, len(races) - 0.7))
    axis.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.yaxis.set_minor_formatter(NullFormatter())
    axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.6g}"))
    axis.grid(axis="y", color="0.9", linewidth=0.8)
    axis.xaxis.set_minor_locator(NullLocator())
    names = map(columnOf, races)
    sizes = (anyOf(race)["particles"] for race in races)
    labels = [f"{name:,}" if isinstance(name, int) else f"{name}\n{n:,}" for name, n in zip(names, sizes, strict=True)]
    axis.set_xticks(range(len(races)), labels)
    axis.set_xlabel("spheres" if isinstance(columnOf(races[0]), int) else "protein, atoms")
