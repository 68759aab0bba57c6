"""Tables of what energies of trials cost and how exact they are."""

import statistics

from racing.races import OURS
from racing.table import Table, exponent, groupBy, number

from .rows import FOREIGN, GROWTH, MOVE_NAMES, ONE_ENERGY, STAGES, TRIALS, TWO_ENERGIES, WORK

AVX512, AVX2, PORTABLE = (f"{OURS}-{name}" for name in ("avx512", "avx2", "portable"))
_WAYS = {AVX512: "AVX-512", AVX2: "AVX2", PORTABLE: "portable"}
_PARTS = {"terms": "terms", "near": "near pairs", "other": "other pairs"}

# What can be asked for.
TABLES = ("times", "errors")

# Whose numbers are medians over runs, under whatever name; the counts are those of all runs.
_COUNTS = ("free", "attempted", "clashed", "tests", "kept")


def makeTables(entries, wanted="all"):
    """Return the tables of entries: of one of TABLES, or all."""
    rows = combineRuns(entries)
    tables = []
    if wanted != "errors":
        tables += _makeTimes(rows)
    work = [row for row in rows if anyOf(row)["group"] == WORK]
    if wanted != "times" and work:
        tables.append(_makeErrors(work))
    return tables


def _makeTimes(rows):
    ofGroup = {group: [row for row in rows if anyOf(row)["group"] == group] for group in (WORK, TRIALS, GROWTH)}
    tables = []
    if ofGroup[WORK]:
        tables += [_makeWork(ofGroup[WORK]), _makeParts(ofGroup[WORK])]
    if ofGroup[TRIALS]:
        tables += [_makeTrials(ofGroup[TRIALS]), describeStages(ofGroup[TRIALS])]
    if ofGroup[GROWTH]:
        tables.append(_makeGrowth(ofGroup[GROWTH]))
    memory = [row for row in rows if widest(row) is not None and widest(row).get("bytes", -1) >= 0]
    if memory:
        tables.append(_makeMemory(memory))
    return tables


def combineRuns(entries):
    """Return rows: dictionaries with one entry for each contestant, which has medians over all runs.

    `least` and `most` are the range of its times over runs.
    """
    rows = groupBy(entries, lambda e: (e["group"], e["chain"], e["particles"], e["method"], e["moves"], e["asked"]))
    return [
        {name: _combine(runs) for name, runs in groupBy(ofRow, lambda entry: entry["contestant"]).items()}
        for ofRow in rows.values()
    ]


def _combine(runs):
    combined = _medians(runs)
    times = [run["microseconds"] for run in runs]
    return {**combined, "least": min(times), "most": max(times), "runs": len(runs)}


def _medians(runs):
    """Return medians of numbers, sums of counts, and what is the same in all."""
    combined = dict(runs[0])
    for key, value in runs[0].items():
        values = [run[key] for run in runs if key in run]
        if isinstance(value, dict):
            combined[key] = _medians(values)
        elif key in ("reached", "refused", "computed", *_COUNTS):
            combined[key] = sum(values)
        elif key in ("largest", "energyError"):
            combined[key] = max(values)
        elif isinstance(value, float):
            combined[key] = statistics.median(values)
    return combined


def anyOf(row):
    """Return an entry of a row, for what all have in common."""
    return next(iter(row.values()))


def widest(row):
    """Return the engine's entry by the widest instructions, or None."""
    return next((row[name] for name in (OURS, *_WAYS) if name in row), None)


def _labels(row):
    entry = anyOf(row)
    return [entry["chain"], entry["method"], MOVE_NAMES.get(entry["moves"], entry["moves"]), f"{entry['particles']:,}"]


_LABELS = ["protein", "U", "move", "N"]


def _time(entry, key="microseconds"):
    if entry is None:
        return "–"
    return number(entry[key])


def ratio(row, first, second, key="microseconds"):
    """Return by how much the first contestant of a row takes longer than the second, or None."""
    second = widest(row) if second == OURS else row.get(second)
    if first not in row or second is None:
        return None
    return row[first]["microseconds"] / second[key]


def _ratio(*arguments):
    value = ratio(*arguments)
    return "–" if value is None else number(value)


# ---- The energy work of a trial ----


def _makeWork(rows):
    columns = [*_LABELS, "trials", *_WAYS.values(), "until refused", "OpenMM, 1 energy", "OpenMM, 2", "1 / ours"]
    columns += ["2 / until refused"]
    lines = []
    for row in rows:
        ours = widest(row)
        lines.append(
            [
                *_labels(row),
                f"{ours['free']:,}",
                *(timeRange(row.get(name)) for name in _WAYS),
                _time(row.get(STAGES), "mean"),
                *(_time(row.get(name)) for name in (ONE_ENERGY, TWO_ENERGIES)),
                _ratio(row, ONE_ENERGY, OURS),
                _ratio(row, TWO_ENERGIES, STAGES, "mean"),
            ]
        )
    notes = [
        "Of trials that pass the hard spheres: computing all parts of the change of energy and, if one is accepted, "
        "making them those of the state. Medians over trials, and over runs (with their range). Until refused: part by "
        "part, mean over trials. OpenMM: positions set and one energy, or two, on the CPU platform with one thread."
    ]
    return Table("Energy work of a trial, µs", columns, lines, 3, notes)


def timeRange(entry):
    """Return the median of an entry, with its range over runs."""
    if entry is None or entry["runs"] == 1:
        return _time(entry)
    return f"{number(entry['microseconds'])} ({number(entry['least'])}–{number(entry['most'])})"


def _makeParts(rows):
    columns = [*_LABELS, "accepted"]
    for name in _PARTS.values():
        columns += [f"{name}, µs", "refused"]
    columns += ["accepting, µs", "all anew, µs"]
    lines = []
    for row in rows:
        ours = widest(row)
        parts = []
        for part in _PARTS:
            parts += [number(max(ours[part]["microseconds"], 0.01)), _share(ours[part]["refused"], ours["free"])]
        lines.append(
            [
                *_labels(row),
                _share(ours["accepted"], ours["free"]),
                *parts,
                _time(ours, "acceptance"),
                _time(ours, "refresh"),
            ]
        )
    notes = ["Medians over trials that came to the part; refused: share of all that pass the hard spheres, at 300 K."]
    return Table("Parts of that work", columns, lines, 3, notes)


def _share(count, whole):
    return f"{100 * count / whole:.0f} %" if whole else "–"


# ---- Whole trials ----


def _makeTrials(rows):
    columns = ["protein", "U", "N", "ours", "OpenMM for each free trial", "two energies a trial"]
    columns += ["OpenMM / ours", "two / ours"]
    lines = []
    for row in rows:
        chain, method, _, particles = _labels(row)
        lines.append(
            [
                chain,
                method,
                particles,
                timeRange(row.get(OURS)),
                *(_time(row.get(name)) for name in (FOREIGN, TWO_ENERGIES)),
                _ratio(row, FOREIGN, OURS),
                _ratio(row, TWO_ENERGIES, OURS),
            ]
        )
    notes = [
        "By Simulation.step, with the moves of examples/sample_protein.py: the backbone by up to 1°, side chains by up "
        "to 10° and, half as often, by up to 180°. OpenMM for each free trial: setNativeEnergies(False), so OpenMM "
        "evaluates the trials that pass the hard spheres. Two energies a trial: all torsions by up to 1°, without hard "
        "spheres. CPU platform, one thread."
    ]
    return Table("Whole trials, µs", columns, lines, 2, notes)


def describeStages(rows):
    """Return the table of where whole trials end."""
    stages = list(
        dict.fromkeys(
            stage
            for row in rows
            if OURS in row
            for stage, counts in row[OURS].get("stages", {}).items()
            if counts["computed"] > 0
        )
    )
    columns = ["protein", "clash"]
    for stage in stages:
        columns += [f"{stage}: asked", "refused"]
    columns.append("accepted")
    lines = []
    for row in rows:
        ours = row[OURS]
        cells = []
        for stage in stages:
            counts = ours["stages"].get(stage)
            cells += (
                ["–", "–"]
                if counts is None
                else [
                    _share(counts["computed"], ours["attempted"]),
                    _share(counts["refused"], counts["computed"]),
                ]
            )
        lines.append(
            [ours["chain"], _share(ours["clashed"], ours["attempted"]), *cells, f"{100 * ours['accepted']:.0f} %"]
        )
    notes = ["Asked: share of all trials; refused: share of those that were asked about."]
    return Table("What each stage decides", columns, lines, 1, notes)


# ---- Growth and memory ----


def _makeGrowth(rows):
    columns = ["copies of", "move", "N", "trials", "ours", "until refused", "terms", "near pairs", "other pairs"]
    lines = []
    for row in rows:
        ours = widest(row)
        chain, _, move, particles = _labels(row)
        parts = [number(max(ours[part]["microseconds"], 0.01)) for part in _PARTS]
        lines.append(
            [chain, move, particles, f"{ours['free']:,}", timeRange(ours), _time(row.get(STAGES), "mean"), *parts]
        )
    growths = [f"{move} N^{value:.2f}" for move, value in growthOf(rows).items()]
    notes = [
        "Copies packed in a lattice and linked to one chain: a pivot moves all that follows. Reaction field 1.0 nm.",
        *([f"Growth, by a fit to the logarithms of all sizes: {', '.join(growths)}."] if growths else []),
    ]
    return Table("Energy work of a trial as chains grow, µs", columns, lines, 2, notes)


def growthOf(rows):
    """Return by moves the x where times go as N^x."""
    growths = {}
    for moves, ofMoves in groupBy(rows, lambda row: anyOf(row)["moves"]).items():
        times = {anyOf(row)["particles"]: widest(row)["microseconds"] for row in ofMoves}
        if len(times) > 1:
            growths[MOVE_NAMES.get(moves, moves)] = exponent(times)
    return growths


def _makeMemory(rows):
    lines = []
    for (chain, method, particles), ofOne in groupBy(rows, lambda row: (*_labels(row)[:2], _labels(row)[3])).items():
        size = anyOf(ofOne[0])["particles"]
        energy, tree = (max(widest(row)[key] for row in ofOne) / size for key in ("bytes", "treeBytes"))
        lines.append([chain, method, particles, number(energy), number(tree), number(energy + tree)])
    columns = ["protein", "U", "N", "energy", "engine", "both"]
    return Table("Memory, bytes a particle, most of all rows", columns, lines, 2, [])


# ---- Errors ----


def _makeErrors(rows):
    columns = [*_LABELS, "U, kJ/mol"]
    for name in ("ours", "OpenMM CPU"):
        columns += [f"{name}, µs", "U", "ΔU, RMS", "ΔU, largest"]
    lines = []
    for row in rows:
        line = _labels(row)
        line.append(f"{widest(row)['energy']:,.0f}")
        for entry in (widest(row), row.get(ONE_ENERGY)):
            if entry is None or "changeError" not in entry:
                line += ["–"] * 4
                continue
            change = entry["changeError"]
            line += [_time(entry), *(f"{e:.1e}" for e in (entry["energyError"], change["rms"], change["largest"]))]
        lines.append(line)
    notes = ["Differences from OpenMM's Reference platform in kJ/mol, over the first trials of each run."]
    return Table("Error and time", columns, lines, 3, notes)
