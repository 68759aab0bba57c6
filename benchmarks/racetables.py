"""Tables of races."""

from measure import OURS
from report import anyOf, exponent, groupBy, racesOf, ratioOf, tabulate, timeRange

# Of contestants, in the order of columns.
NAMES = {
    "fullgrid": "full grid",
    "lazygrid": "lazy grid",
    "simdgrid": "SIMD grid",
    "verletlist": "Verlet list",
    "obbtree1": "1-OBBTree",
    "kobbtree": "K-OBBTree",
    "published": "ChainTree 2002",
    "improved": "ChainTree 2002, improved",
    "cells": "cell grid",
    OURS: "ours",
    **{name: name for name in ("ours from Python", "SciPy", "FCL", "OpenMM CPU", "Simulation.step")},
}
_GRIDS = ("fullgrid", "lazygrid", "simdgrid", "verletlist")

_HEADINGS = {
    "chains": "Compact chains, one torsion a trial",
    "large": "Large chains, one torsion a trial",
    "proteins": "Proteins, one torsion of the backbone a trial",
    "windows": "Eight consecutive torsions of the backbone a trial",
    "sidechains": "One torsion of a side chain a trial",
    "python": "Our calls from Python, and what one could call instead",
    "pairs": "Pairs within 0.8 nm",
}
_TIMES = "µs, median over chains (range)"

# Table 1 of the paper: tests of boxes a query, of compact chains by their number of spheres, and of a protein.
PAPER_TESTS: dict[str, dict[int | str, int]] = {
    "ChainTree": {1000: 703, 2500: 715, 5000: 905, 10000: 964, "1shg": 242},
    "K-OBBTree": {1000: 114, 2500: 131, 5000: 163, 10000: 178, "1shg": 73},
}


def makeTables(entries):
    """Return the tables of entries."""
    tables = _makeFigures(racesOf(entries, "figures"))
    for group in _HEADINGS:
        tables += _makeRace(group, racesOf(entries, group))
    return tables


def _makeRace(group, races):
    """Return the table of a group, a line for each race."""
    contestants = contestantsOf(races)
    columns = {"chain": lambda race: anyOf(race)["chain"]}
    if group != "pairs":
        columns["moves"] = lambda race: anyOf(race)["moves"]
    words = len(columns)
    columns["N"] = lambda race: f"{anyOf(race)['particles']:,}"
    columns["trials"] = lambda race: trialsOf(race)
    if group != "pairs":
        columns["accepted"] = lambda race: f"{anyOf(race)['accepted']:.2f}"
    for name in contestants:
        columns[NAMES[name]] = lambda race, name=name: timeRange(race.get(name))
    if group == "python":
        for name in ("SciPy", "FCL", "OpenMM CPU"):
            columns[f"{name} / ours from Python"] = lambda race, name=name: ratioOf(
                race.get(name), race.get("ours from Python")
            )
    elif group == "pairs":
        columns["cell grid / ours"] = lambda race: ratioOf(race["cells"], race[OURS])
    else:
        columns["lazy grid / ours"] = lambda race: ratioOf(race["lazygrid"], race[OURS])
        columns["best of the others / ours"] = lambda race: ratioOf(
            min((race[name] for name in _GRIDS if name in race), key=lambda entry: entry["microseconds"]), race[OURS]
        )
    return tabulate(f"{_HEADINGS[group]}: {_TIMES}", races, columns, words, *_describeGrowth(races))


def contestantsOf(races):
    """Return the names of all contestants, in the order of columns."""
    found = {name for race in races for name in race}
    return [name for name in NAMES if name in found]


def trialsOf(race):
    """Return the number of trials of a race by runs."""
    entry = max(race.values(), key=lambda entry: entry["runs"])
    each = entry["trials"] // entry["runs"]
    return f"{each:,}" if entry["runs"] == 1 else f"{entry['runs']} × {each:,}"


def _describeGrowth(races):
    """Say how the engine's time grows with the length of chains that differ in nothing else."""
    growths = []
    chains = groupBy(races, lambda race: (anyOf(race)["chain"], anyOf(race).get("moves")))
    for (chain, moves), ofChain in chains.items():
        times = {race[OURS]["particles"]: race[OURS]["microseconds"] for race in ofChain if OURS in race}
        if len(times) > 1:
            growths.append(f"N^{exponent(times):.2f} ({chain}, {moves})")
    return [f"Our time grows as {', '.join(growths)}, by a fit to the logarithms of all sizes."] if growths else []


# ---- The paper's figures and its table ----


def _makeFigures(races):
    chains = [race for race in races if anyOf(race)["chain"] == "random compact"]
    proteins = [race for race in races if anyOf(race)["chain"] != "random compact"]
    contestants = contestantsOf(races)
    tables = []
    for heading, ofFigure in (("Figure 7, compact chains", chains), ("Figure 8, backbones of proteins", proteins)):
        cells = {NAMES[name]: lambda race, name=name: timeRange(race.get(name)) for name in contestants}
        cells["trials"] = trialsOf
        cells["accepted"] = lambda race: f"{anyOf(race)['accepted']:.2f}"
        tables += _transpose(f"{heading}: {_TIMES}", ofFigure, cells, *_describeGrowth(ofFigure))
    tests = {
        NAMES[name]: lambda race, name=name: f"{race[name]['volumeTests']:,.0f}" if name in race else "–"
        for name in contestants
        if any(race[name]["volumeTests"] > 0 for race in races if name in race)
    }
    for name, ofPaper in PAPER_TESTS.items():
        tests[f"{name} in the paper"] = lambda race, ofPaper=ofPaper: str(ofPaper.get(columnOf(race), "–"))
    note = "Means over all trials."
    return [*tables, *_transpose("Table 1, tests of bounding volumes a query", [*chains, *proteins], tests, note)]


def columnOf(race):
    """Return what names a race of the figures: its number of spheres, or its protein."""
    entry = anyOf(race)
    return entry["particles"] if entry["chain"] == "random compact" else entry["chain"].removesuffix(" backbone")


def _transpose(heading, races, cells, *notes):
    """Return the table with a line for each cell, and a column for each race."""
    columns = {"": lambda name: name}
    for race in races:
        name = columnOf(race)
        columns[f"{name:,}" if isinstance(name, int) else name] = lambda cell, race=race: cells[cell](race)
    return tabulate(heading, list(cells) if races else [], columns, 1, *notes)
