"""Tables of what was measured of the accuracy."""

from racing.races import LAZY_GRID, OURS
from racing.table import Table, groupBy, number, sizeOf

# Of contestants, in the order of lines.
NAMES = {
    "ours-avx512": "ours, AVX-512",
    "ours-avx2": "ours, AVX2",
    "ours-portable": "ours, portable",
    "ours-tree": "ours, by tree",
    "ours-boxes": "ours, by boxes",
    "ours-clearances": "ours, by clearances",
    "ours-whole": "ours, the whole chain",
    "shortcuts": "shortcuts from absolute angles",
    "shortcuts-single": "shortcuts from absolute angles, single",
    "sequential": "sequential kinematics",
    "sequential-single": "sequential kinematics, single",
    "multiplied": "joint matrices multiplied on",
    "multiplied-single": "joint matrices multiplied on, single",
    "cartesian": "Cartesian rotation",
    "cartesian-single": "Cartesian rotation, single",
    "volumes-double-margin": "double volumes, margin",
    "volumes-double": "double volumes",
    "volumes-single-margin": "single volumes, margin",
    "volumes-single": "single volumes",
    "all-single": "single volumes, which decide",
    LAZY_GRID: "Cartesian positions",
    "lazygrid-single": "Cartesian positions, single",
}

_ORDER = list(NAMES)


def makeTables(entries):
    """Return the tables of entries."""
    tables = []
    for group, maker in (("drift", _makeDrift), ("touch", _makeTouch), ("force", _makeForce)):
        ofGroup = [entry for entry in entries if entry["group"] == group]
        if ofGroup:
            tables += maker(ofGroup)
    return tables


def nameOf(contestant):
    """Return what tables call a contestant."""
    return NAMES.get(contestant, contestant)


def isOurs(entry):
    """Whether an entry is the engine's."""
    return entry["contestant"].startswith(OURS)


def errorsOf(entry):
    """Return the errors of positions from those that the contestant's own angles, or else the turns, lead to."""
    return entry.get("ofAngles", entry["ofTurns"])


def relativeError(entry, of=errorsOf):
    """Return the largest error of a distance, as a part of the chain's size."""
    return of(entry)["distances"]["largest"] / entry["size"]


def stationsOf(entries):
    """Return entries by contestant in the order of lines, each a dictionary by the number of turns."""
    groups = groupBy(entries, lambda entry: entry["contestant"])
    return {
        contestant: {entry["turns"]: entry for entry in groups[contestant]}
        for contestant in sorted(groups, key=_rankOf)
    }


def _rankOf(contestant):
    return _ORDER.index(contestant) if contestant in _ORDER else len(_ORDER)


def _makeDrift(entries):
    tables = []
    for size, ofSize in groupBy(entries, sizeOf).items():
        paths = stationsOf(ofSize)
        turns = sorted({entry["turns"] for entry in ofSize})
        rows = []
        for contestant, stations in paths.items():
            last = stations[max(stations)]
            errors = errorsOf(last)
            rows.append(
                [
                    nameOf(contestant),
                    number(last["microseconds"]),
                    *(error(relativeError(stations[n])) if n in stations else "–" for n in turns),
                    error(errors["distances"]["rms"] / last["size"]),
                    error(relativeError(last, lambda entry: entry["ofTurns"])),
                    *(error(errors[kind]["largest"]) for kind in ("bonds", "angles", "torsions")),
                ]
            )
        columns = ["path", "µs a turn", *(f"{n:,}" for n in turns), "RMS", "of turns", "bonds", "angles", "torsions"]
        heading = f"Largest error of a distance after so many turns, by the size of the chain, {size:,} spheres"
        tables.append(Table(heading, columns, rows, 1, []))
    tables[-1].notes.append(
        'From positions that the angles a path keeps lead to exactly; of paths that keep none, and under "of turns" '
        "of all, from those that all turns lead to. The last five columns: after the last turns of the path; bonds in "
        "nm, angles and torsions in rad."
    )
    return tables


def _makeTouch(entries):
    tables = []
    for size, ofSize in groupBy(entries, sizeOf).items():
        rows = []
        for entry in sorted(ofSize, key=lambda entry: _rankOf(entry["contestant"])):
            rows.append(
                [
                    nameOf(entry["contestant"]),
                    number(entry["microseconds"]),
                    f"{entry['missed']:,} of {entry['clashes']:,}",
                    _extent(entry["largestMissed"]),
                    f"{entry['invented']:,} of {entry['gaps']:,}",
                    _extent(entry["largestInvented"]),
                ]
            )
        columns = ["path", "µs a trial", "missed", "up to, nm", "invented", "up to, nm"]
        tables.append(Table(f"Clashes where spheres all but touch, {size:,} spheres", columns, rows, 1, []))
    return tables


def _makeForce(entries):
    rows = [
        [
            entry["contestant"],
            f"{entry['particles']:,}",
            number(entry["microseconds"]),
            error(entry["energyError"]),
            error(entry["forceError"]["largest"]),
            error(entry["forceError"]["rms"]),
        ]
        for entry in entries
    ]
    columns = ["force", "N", "µs", "energy", "force, largest", "force, RMS"]
    return [Table("Relative errors of energy and forces", columns, rows, 1, [])]


def error(value):
    """Return an error with two digits."""
    return f"{value:.1e}" if value > 0 else "0"


def _extent(value):
    return error(value) if value > 0 else "–"
