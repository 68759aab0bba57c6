"""Tables of races."""

import statistics

from .races import FULL_GRID, LAZY_GRID, OURS, SIMD_GRID, VERLET
from .rows import CHOSEN, GROUPS, PAPER_TRIALS, WAYS
from .steps import ALONE, BESIDE_REST, WITH_FAR_ATOMS, WITH_WATERS, WITHIN_WHOLE
from .table import Table, exponent, groupBy, number, sizeOf

# Of contestants, in the order of columns; others follow.
NAMES = {
    FULL_GRID: "full grid",
    LAZY_GRID: "lazy grid",
    SIMD_GRID: "SIMD grid",
    VERLET: "Verlet list",
    "fullgrid-plain": "full grid, plain",
    "lazygrid-plain": "lazy grid, plain",
    "obbtree1": "1-OBBTree",
    "obbtree1-leaves": "1-OBBTree, 8 a leaf",
    "kobbtree": "K-OBBTree",
    "kobbtree-leaves": "K-OBBTree, 8 a leaf",
    "published": "ChainTree 2002",
    "published-selves-first": "ChainTree 2002, self tests first",
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

_TIMES = "µs, median over chains (range)"

# What each table compares; the first, or the least of several, is divided by the second, or the least of several.
_WITH_OTHERS = ((LAZY_GRID, OURS), ((FULL_GRID, LAZY_GRID, SIMD_GRID, VERLET), OURS))
_RATIOS = {
    "simd": (("avx2", "avx512"), ("portable", "avx512"), ("portable", "avx2")),
    "ways": ((CHOSEN, WAYS),),
    "calls": (("ours from Python", OURS), ("Simulation.step", OURS)),
    "python": (("SciPy", "ours from Python"), ("FCL", "ours from Python"), ("OpenMM CPU", "ours from Python")),
    "needs": (
        (WITH_WATERS, ALONE),
        (WITH_FAR_ATOMS, ALONE),
        (WITHIN_WHOLE, BESIDE_REST),
    ),
    "forces": (("CustomNonbondedForce, CPU", "force, Reference"), ("CustomNonbondedForce, CPU", "force, CPU")),
    "pairs": (("cells", OURS), ("cells-sorted", "ours-sorted"), ("SciPy", "getNeighborPairs")),
    "nearest": (("brute", OURS),),
}

# Table 1 of the paper: box tests a query, of compact chains of so many spheres and of backbones of proteins.
PAPER_TESTS: dict[str, dict[int | str, int]] = {
    "ChainTree": {1000: 703, 2500: 715, 5000: 905, 10000: 964, "1SHG": 242, "1B4E": 664, "1LOX": 747},
    "K-OBBTree": {1000: 114, 2500: 131, 5000: 163, 10000: 178, "1SHG": 73, "1B4E": 113, "1LOX": 146},
}

_ABOUT_CHAINS = (
    "The paper's chains: spheres of radius 1, 4 apart, in a compact cube. The paper does not say how a chain runs "
    "through the cube, nor by which angles torsions turn. Our chains: the same spheres on a random path through a "
    "cubic lattice, where each bond goes straight on or turns by 90°; each chain has a path of its own; torsions turn "
    "by any angle."
)
_ABOUT_PROTEINS = (
    "The paper's proteins are 1SHG, 1B4E and 1LOX. Of these only 1SHG can be here. The paper gives no radii and no "
    "excluded pairs, so our model may differ from its own. It counts, for 1B4E, 664 tests by its ChainTree and 113 by "
    "its K-OBBTree, and 747 and 146 for 1LOX. The other proteins here do not stand for these two."
)


def makeTables(entries):
    """Return the tables of what the rows gave, on however many chains."""
    combined = combineChains(entries)
    tables = []
    for group in GROUPS:
        ofGroup = [entry for entry in combined if entry["group"] == group]
        if ofGroup:
            tables += _MAKERS.get(group, _makeRace)(group, ofGroup)
    withBytes = [entry for entry in combined if entry.get("bytes", -1) >= 0]
    return [*tables, _makeMemory(withBytes)] if withBytes else tables


def combineChains(entries):
    """Return one entry for all chains of a contestant in a row.

    It has the median of their times, their range as `least` and `most`, the means of counts, and how many `chains`. A
    measurement that did not run all trials that it was asked for is left out.
    """
    complete = [entry for entry in entries if entry["trials"] == entry["asked"]]
    runs = groupBy(complete, lambda entry: (*_rowOf(entry), entry["contestant"]))
    return [_combine(ofOne) for ofOne in runs.values()]


def _rowOf(entry):
    return tuple(entry.get(key) for key in ("group", "chain", "particles", "moves", "asked"))


def _combine(entries):
    times = [entry["microseconds"] for entry in entries]
    combined = {**entries[0], "microseconds": statistics.median(times), "least": min(times), "most": max(times)}
    for key in ("accepted", "volumeTests", "particleTests", "updates", "rgOfScene", "rgEnd", "bytes"):
        if key in combined:
            combined[key] = statistics.fmean(entry[key] for entry in entries)
    if "disagreements" in combined:
        combined["disagreements"] = sum(entry["disagreements"] for entry in entries)
    return {**combined, "chains": len(entries)}


# ---- Times of contestants, a line a row ----


def _makeRace(group, entries):
    races = groupBy(entries, _rowOf)
    contestants = contestantsOf(entries)
    columns = {"chain": lambda race: _anyOf(race)["chain"]}
    if any("moves" in entry for entry in entries):
        columns["moves"] = lambda race: _anyOf(race)["moves"]
    words = len(columns)
    columns["N"] = lambda race: f"{_anyOf(race)['particles']:,}"
    columns["trials"] = lambda race: _trials(_anyOf(race))
    if any("rgOfScene" in entry for entry in entries):
        columns["Rg"] = lambda race: _gyration(_anyOf(race))
    if any("accepted" in entry for entry in entries):
        columns["accepted"] = lambda race: _share(_anyOf(race))
    for contestant in contestants:
        columns[nameOf(contestant)] = lambda race, contestant=contestant: _time(race.get(contestant))
    for first, second in _RATIOS.get(group, _WITH_OTHERS):
        ofFirst, ofSecond = (
            tuple(name for name in ([names] if isinstance(names, str) else names) if name in contestants)
            for names in (first, second)
        )
        if ofFirst and ofSecond:
            heading = f"{_nameOfSome(first)} / {_nameOfSome(second)}"
            columns[heading] = lambda race, pair=(ofFirst, ofSecond): _ratio(race, *pair)
    rows = [
        [cellOf(race) for cellOf in columns.values()]
        for race in ({entry["contestant"]: entry for entry in ofRace} for ofRace in races.values())
    ]
    notes = [*_growth(entries), *_disagreements(entries)]
    return [Table(f"{GROUPS[group]}: {_TIMES}", list(columns), rows, words, notes)]


def _anyOf(race):
    """Return an entry of a race, for what all have in common."""
    return next(iter(race.values()))


def nameOf(contestant):
    """Return what tables call a contestant."""
    return NAMES.get(contestant, contestant)


def _nameOfSome(names):
    return nameOf(names) if isinstance(names, str) else "best of the others"


def _trials(entry):
    chains = entry["chains"]
    return f"{entry['trials']:,}" if chains == 1 else f"{chains} × {entry['trials']:,}"


def _gyration(entry):
    return f"{number(entry['rgOfScene'])} → {number(entry['rgEnd'])}" if "rgOfScene" in entry else "–"


def _share(entry):
    return f"{entry['accepted']:.2f}" if "accepted" in entry else "–"


def _time(entry):
    if entry is None:
        return "–"
    if entry["chains"] == 1:
        return number(entry["microseconds"])
    return f"{number(entry['microseconds'])} ({number(entry['least'])}–{number(entry['most'])})"


def _ratio(race, firsts, seconds):
    times = [[race[name]["microseconds"] for name in names if name in race] for names in (firsts, seconds)]
    return number(min(times[0]) / min(times[1])) if all(times) else "–"


def _growth(entries):
    """Say how the engine's time grows with the length of chains that differ in nothing else."""
    ofOurs = [entry for entry in entries if entry["contestant"] == OURS]
    chains = groupBy(ofOurs, lambda entry: ", ".join(filter(None, (entry["chain"], entry.get("moves")))))
    growths = []
    for chain, ofChain in chains.items():
        times = {entry["particles"]: entry["microseconds"] for entry in ofChain}
        if len(times) > 1:
            growths.append(f"N^{exponent(times):.2f} ({chain}, {min(times):,} to {max(times):,})")
    return [f"Our time grows as {', '.join(growths)}, by a fit to the logarithms of all sizes."] if growths else []


def _disagreements(entries):
    return [
        f"{entry['contestant']} differs in {entry['disagreements']} of {entry['chains'] * entry['trials']} verdicts on "
        f"{entry['chain']}."
        for entry in entries
        if entry.get("disagreements")
    ]


# ---- The paper's figures and its table ----


def _makeFigures(group, entries):
    chains = [entry for entry in entries if entry["chain"] == "random compact"]
    proteins = [entry for entry in entries if entry["chain"] != "random compact"]
    tables = []
    for heading, ofFigure, keyOf, note in (
        ("Figure 7, compact chains", chains, sizeOf, _ABOUT_CHAINS),
        ("Figure 8, backbones of proteins", proteins, proteinOf, _ABOUT_PROTEINS),
    ):
        if ofFigure:
            tables.append(_makeFigure(f"{heading}: {_TIMES}", ofFigure, keyOf, [note, *_growth(ofFigure)]))
    return [*tables, _makeTestTable(chains, proteins)]


def _makeFigure(heading, entries, keyOf, notes):
    races = groupBy(entries, keyOf)
    rows = []
    for contestant in contestantsOf(entries):
        times = [{entry["contestant"]: entry for entry in ofRace}.get(contestant) for ofRace in races.values()]
        rows.append([nameOf(contestant), *map(_time, times)])
    firsts = [max(ofRace, key=lambda entry: entry["chains"]) for ofRace in races.values()]
    for name, cellOf in (("trials", _trials), ("accepted", _share), ("Rg", _gyration)):
        rows.append([name, *map(cellOf, firsts)])
    if any(entry["chains"] != firsts[0]["chains"] for entry in entries):
        notes = ["Times without a range, and their counts of tests, are of the first chain only.", *notes]
    return Table(heading, ["", *map(_nameColumn, races)], rows, 1, notes)


def _makeTestTable(chains, proteins):
    races = {**groupBy(chains, sizeOf), **groupBy(proteins, proteinOf)}
    rows = []
    for contestant in contestantsOf([*chains, *proteins]):
        tests = [{e["contestant"]: e["volumeTests"] for e in ofRace}.get(contestant, 0) for ofRace in races.values()]
        if any(tests):
            rows.append([nameOf(contestant), *(f"{count:,.0f}" for count in tests)])
    for name, tests in PAPER_TESTS.items():
        cells = [tests.get(nameInPaper(column)) for column in races]
        rows.append([f"{name} in the paper", *("–" if count is None else f"{count:,}" for count in cells)])
    columns = ["", *map(_nameColumn, races)]
    notes = [
        f"Means over all trials. The paper ran {PAPER_TRIALS:,} from each start. With fewer, the chains are more "
        "compact on average, and take more tests."
    ]
    return Table("Table 1, tests of bounding volumes a query", columns, rows, 1, notes)


def _nameColumn(column):
    return f"{column:,}" if isinstance(column, int) else column.removesuffix(" backbone")


# ---- The worst case ----


def _makeWorst(group, entries):
    races = groupBy(entries, sizeOf)
    tests = {
        contestant: {
            size: e["volumeTests"] for size, race in races.items() for e in race if e["contestant"] == contestant
        }
        for contestant in contestantsOf([entry for entry in entries if entry["volumeTests"]])
    }
    rows = [
        [f"{size:,}", *(f"{ofOne[size]:,.0f} ({ofOne[size] / size ** (4 / 3):.3f})" for ofOne in tests.values())]
        for size in races
    ]
    rows.append(["growth", *(f"N^{exponent(ofOne):.2f}" if len(ofOne) > 1 else "–" for ofOne in tests.values())])
    columns = ["N", *map(nameOf, tests)]
    clashes = [f"{size:,}" for size, ofRace in races.items() if any(entry["clash"] for entry in ofRace)]
    notes = [f"All find clashes at N = {', '.join(clashes)}." if clashes else "All find no clash."]
    return [Table(f"{GROUPS[group]}, tests of bounding volumes (divided by N^(4/3))", columns, rows, 0, notes)]


_MAKERS = {"figures": _makeFigures, "worst": _makeWorst}


# ---- Memory ----


def _makeMemory(entries):
    largest = {}
    for entry in entries:
        sizes = largest.setdefault((entry["chain"], entry["particles"]), {})
        name = entry["contestant"]
        sizes[name] = max(sizes.get(name, 0), entry["bytes"] / entry["particles"])
    contestants = contestantsOf(entries)
    rows = [
        [chain, f"{size:,}", *(number(ofRow[name]) if ofRow.get(name) else "–" for name in contestants)]
        for (chain, size), ofRow in largest.items()
    ]
    columns = ["chain", "N", *map(nameOf, contestants)]
    return Table("Memory, bytes a sphere, most of all rows with such a chain", columns, rows, 1, [])


# ---- What pictures need, too ----


def proteinOf(entry):
    """Return the name of a protein's model."""
    return entry["chain"]


def nameInPaper(column):
    """Return the column of the paper's table 1 that has a number of spheres or a protein's model, if there is one."""
    if isinstance(column, int):
        return column
    return "1SHG" if column.lower() == "1shg backbone" else None


def contestantsOf(entries):
    """Return the names of all contestants, in the order of columns."""
    found = dict.fromkeys(entry["contestant"] for entry in entries)
    return sorted(found, key=lambda name: _ORDER.index(name) if name in _ORDER else len(_ORDER))
