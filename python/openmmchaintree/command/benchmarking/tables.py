"""Tables of what was measured."""

import math
from typing import NamedTuple

from .races import FULL_GRID, LAZY_GRID, OURS
from .rows import CHOSEN, GROUPS, WAYS
from .steps import ALONE, BESIDE_REST, FROM_C, STEP, WITH_FAR_ATOMS, WITH_WATERS, WITHIN_WHOLE

# Of contestants, in the order of columns; others follow.
NAMES = {
    FULL_GRID: "full grid",
    LAZY_GRID: "lazy grid",
    "fullgrid-plain": "full grid, plain",
    "lazygrid-plain": "lazy grid, plain",
    "obbtree1": "1-OBBTree",
    "kobbtree": "K-OBBTree",
    "published": "ChainTree 2002",
    "published-tight": "ChainTree 2002, tight boxes",
    "published-spheres": "ChainTree 2002, spheres",
    "published-capsules": "ChainTree 2002, capsules",
    "improved": "ChainTree 2002, improved",
    "brute": "all pairs",
    "cells": "cell grid",
    "cells-sorted": "cell grid, in order",
    OURS: "ours",
    "ours-sorted": "ours, in order",
}

_ORDER = list(NAMES)

_TIMES = "µs, median [quartiles]"

# What each table compares; the first is divided by the second, or by the least of several.
_GRID_RATIOS = ((LAZY_GRID, OURS), (FULL_GRID, OURS))
_RATIOS = {
    "simd": (("avx2", "avx512"), ("portable", "avx512"), ("portable", "avx2")),
    "ways": ((CHOSEN, WAYS),),
    "python": (("SciPy", OURS), ("FCL", OURS), ("OpenMM CPU", OURS)),
    "steps": ((STEP, FROM_C),),
    "needs": (
        (WITH_WATERS, ALONE),
        (WITH_FAR_ATOMS, ALONE),
        (WITHIN_WHOLE, BESIDE_REST),
    ),
    "forces": (("CustomNonbondedForce, CPU", "force, Reference"), ("CustomNonbondedForce, CPU", "force, CPU")),
    "pairs": (("cells", OURS), ("cells-sorted", "ours-sorted"), ("SciPy", "getNeighborPairs")),
    "nearest": (("brute", OURS),),
}

# Table 1 of the paper: box tests a query, of compact chains of so many spheres and of backbones of proteins; others
# stand in for two of these.
PAPER_TESTS: dict[str, dict[int | str, int]] = {
    "ChainTree": {1000: 703, 2500: 715, 5000: 905, 10000: 964, "1SHG": 242, "1B4E": 664, "1LOX": 747},
    "K-OBBTree": {1000: 114, 2500: 131, 5000: 163, 10000: 178, "1SHG": 73, "1B4E": 113, "1LOX": 146},
}
_IN_PAPER = {"1shg backbone": "1SHG", "1htb backbone": "1B4E", "2cas backbone": "1LOX"}


class Table(NamedTuple):
    """A table: the first columns, as many as `words`, are of words, the others of numbers."""

    heading: str
    columns: list[str]
    rows: list[list[str]]
    words: int
    notes: list[str]

    def print(self, console):
        """Print it on a rich Console, in lines as long as they are."""
        lines = [self.columns, *self.rows]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        console.print(f"\n{self.heading}:")
        for line in lines:
            cells = zip(line, widths, strict=True)
            padded = [
                cell.ljust(width) if n < self.words else cell.rjust(width) for n, (cell, width) in enumerate(cells)
            ]
            console.print("  ".join(padded).rstrip(), style="bold" if line is self.columns else None)
        for note in self.notes:
            console.print(note)

    def markdown(self):
        """Return it as Markdown."""
        marks = ["---" if number < self.words else "---:" for number in range(len(self.columns))]
        lines = [f"| {' | '.join(cells)} |" for cells in (self.columns, marks, *self.rows)]
        return "\n".join([f"**{self.heading}**\n", *lines, *(f"\n{note}" for note in self.notes)])


def makeTables(entries):
    """Return the tables of what the rows of a benchmark gave."""
    tables = []
    for group in GROUPS:
        ofGroup = [entry for entry in entries if entry["group"] == group]
        if ofGroup:
            tables += _MAKERS.get(group, _makeRace)(group, ofGroup)
    return tables


# ---- Times of contestants, a line a row ----


def _makeRace(group, entries):
    races = groupBy(entries, lambda entry: (entry["chain"], entry["particles"], entry.get("moves")))
    contestants = _contestants(entries)
    columns = {"chain": lambda race: _anyOf(race)["chain"]}
    if any("moves" in entry for entry in entries):
        columns["moves"] = lambda race: _anyOf(race)["moves"]
    words = len(columns)
    columns["N"] = lambda race: f"{_anyOf(race)['particles']:,}"
    columns["trials"] = lambda race: f"{_anyOf(race)['trials']:,}"
    if any("accepted" in entry for entry in entries):
        columns["accepted"] = lambda race: _share(_anyOf(race))
    for contestant in contestants:
        columns[_nameOf(contestant)] = lambda race, contestant=contestant: _time(race.get(contestant))
    for first, second in _RATIOS.get(group, _GRID_RATIOS):
        others = (second,) if isinstance(second, str) else second
        if {first, *others} <= {*contestants}:
            name = _nameOf(second) if isinstance(second, str) else "best of the others"
            columns[f"{_nameOf(first)} / {name}"] = lambda race, pair=(first, others): _ratio(race, *pair)
    rows = [
        [cellOf(race) for cellOf in columns.values()]
        for race in ({entry["contestant"]: entry for entry in ofRace} for ofRace in races.values())
    ]
    notes = [*_growth(entries), *_disagreements(entries)]
    return [Table(f"{GROUPS[group]}: {_TIMES}", list(columns), rows, words, notes)]


def _anyOf(race):
    """Return an entry of a race, for what all have in common."""
    return next(iter(race.values()))


def _nameOf(contestant):
    return NAMES.get(contestant, contestant)


def _share(entry):
    return f"{entry['accepted']:.2f}" if "accepted" in entry else "–"


def _time(entry):
    if entry is None:
        return "–"
    low, high = entry["quartiles"]
    return f"{number(entry['microseconds'])} [{number(low)}, {number(high)}]"


def _ratio(race, first, others):
    if not {first, *others} <= {*race}:
        return "–"
    return number(race[first]["microseconds"] / min(race[other]["microseconds"] for other in others))


def _growth(entries):
    """Say how the engine's time grows with the length of chains that differ in nothing else."""
    ofOurs = [entry for entry in entries if entry["contestant"] == OURS]
    chains = groupBy(ofOurs, lambda entry: ", ".join(filter(None, (entry["chain"], entry.get("moves")))))
    growths = []
    for chain, ofChain in chains.items():
        times = {entry["particles"]: entry["microseconds"] for entry in ofChain}
        if len(times) > 1:
            growths.append(f"N^{exponent(times):.2f} ({chain}, {min(times):,} to {max(times):,})")
    return [f"Our time grows as {', '.join(growths)}."] if growths else []


def _disagreements(entries):
    return [
        f"{entry['contestant']} differs in {entry['disagreements']} of {entry['trials']} verdicts on {entry['chain']}."
        for entry in entries
        if entry.get("disagreements")
    ]


# ---- The paper's figures and its table ----


def _makeFigures(group, entries):
    chains = [entry for entry in entries if entry["chain"] == "random compact"]
    proteins = [entry for entry in entries if entry["chain"] != "random compact"]
    tables = []
    for heading, ofFigure, nameOf in (
        ("Figure 7, compact chains", chains, sizeOf),
        ("Figure 8, backbones of proteins", proteins, proteinOf),
    ):
        if ofFigure:
            tables.append(_makeFigure(f"{heading}: {_TIMES}", ofFigure, nameOf))
    return [*tables, _makeTestTable(chains, proteins)]


def _makeFigure(heading, entries, nameOf):
    races = groupBy(entries, nameOf)
    rows = []
    for contestant in _contestants(entries):
        times = [{entry["contestant"]: entry for entry in ofRace}.get(contestant) for ofRace in races.values()]
        rows.append([_nameOf(contestant), *map(_time, times)])
    rows.append(["trials", *(f"{ofRace[0]['trials']:,}" for ofRace in races.values())])
    rows.append(["accepted", *(_share(ofRace[0]) for ofRace in races.values())])
    return Table(heading, ["", *map(_nameColumn, races)], rows, 1, [])


def _makeTestTable(chains, proteins):
    races = {**groupBy(chains, sizeOf), **groupBy(proteins, proteinOf)}
    rows = []
    for contestant in _contestants([*chains, *proteins]):
        tests = [{e["contestant"]: e["volumeTests"] for e in ofRace}.get(contestant, 0) for ofRace in races.values()]
        if any(tests):
            rows.append([_nameOf(contestant), *(f"{count:,.0f}" for count in tests)])
    for name, tests in PAPER_TESTS.items():
        rows.append([f"{name} in the paper", *(_paperCell(tests, column) for column in races)])
    columns = ["", *map(_nameColumn, races)]
    return Table("Table 1, tests of bounding volumes a query", columns, rows, 1, [])


def _paperCell(tests, column):
    name = nameInPaper(column)
    if name not in tests:
        return "–"
    return f"{tests[name]:,}" if name == column else f"{tests[name]:,} ({name})"


def _nameColumn(column):
    return f"{column:,}" if isinstance(column, int) else column.removesuffix(" backbone")


# ---- The worst case ----


def _makeWorst(group, entries):
    races = groupBy(entries, sizeOf)
    contestants = [c for c in _contestants(entries) if any(e["contestant"] == c and e["volumeTests"] for e in entries)]
    tests = {
        contestant: {
            size: e["volumeTests"] for size, race in races.items() for e in race if e["contestant"] == contestant
        }
        for contestant in contestants
    }
    rows = [
        [f"{size:,}", *(f"{ofOne[size]:,.0f} ({ofOne[size] / size ** (4 / 3):.3f})" for ofOne in tests.values())]
        for size in races
    ]
    rows.append(["growth", *(f"N^{exponent(ofOne):.2f}" if len(ofOne) > 1 else "–" for ofOne in tests.values())])
    columns = ["N", *(_nameOf(contestant) for contestant in contestants)]
    clashes = [f"{size:,}" for size, ofRace in races.items() if any(entry["clash"] for entry in ofRace)]
    notes = [f"All find clashes at N = {', '.join(clashes)}." if clashes else "All find no clash."]
    return [Table(f"{GROUPS[group]}, tests of bounding volumes (divided by N^(4/3))", columns, rows, 0, notes)]


_MAKERS = {"figures": _makeFigures, "worst": _makeWorst}


# ---- What pictures need, too ----


def groupBy(entries, keyOf):
    """Return entries by a key, in the order in which keys come."""
    groups = {}
    for entry in entries:
        groups.setdefault(keyOf(entry), []).append(entry)
    return groups


def sizeOf(entry):
    """Return the number of spheres."""
    return entry["particles"]


def proteinOf(entry):
    """Return the name of a protein's model."""
    return entry["chain"]


def nameInPaper(column):
    """Return the column of the paper's table 1 that stands for a number of spheres or a protein's model, if any."""
    return _IN_PAPER.get(column.lower()) if isinstance(column, str) else column


def exponent(values):
    """Return x if values, by size, grow as size^x from the smallest size to the largest."""
    small, large = min(values), max(values)
    return math.log(values[large] / values[small]) / math.log(large / small)


def number(value):
    """Return a positive number with about three digits."""
    return f"{value:,.0f}" if value >= 100 else f"{value:.1f}" if value >= 10 else f"{value:.2f}"


def _contestants(entries):
    """Return the names of all contestants, in the order of columns."""
    found = dict.fromkeys(entry["contestant"] for entry in entries)
    return sorted(found, key=lambda name: _ORDER.index(name) if name in _ORDER else len(_ORDER))
