"""Tables of how far a protein travels with rigid and with flexible links, and by dynamics."""

from report import number, racesOf, tabulate

# Contestants.
RIGID, UNCONSTRAINED, CONSTRAINED = "rigid", "dynamics, 1 fs", "dynamics, 2 fs, bonds of H rigid"


def nameOfShare(share):
    """Return the contestant with a share of atom moves."""
    return f"flexible, {100 * share:.0f} % atom moves"


def makeTables(entries):
    """Return the tables of entries."""
    rows = [entry for race in racesOf(entries, "travel") for entry in race.values()]
    if not rows:
        return []
    columns = {
        "protein": lambda e: e["chain"],
        "by": lambda e: e["contestant"],
        "µs a trial or step": lambda e: number(e["microseconds"]),
    }
    for lag in sorted({lag for entry in rows for lag in entry["travel"]}, key=float):
        columns[f"{lag} s, Å²"] = lambda e, lag=lag: f"{e['travel'][lag]:.3g}" if lag in e["travel"] else "–"
    note = (
        f"AMBER14 with GBn2 at 300 K from the folded state, in turns in one process; medians of {rows[0]['runs']} "
        "runs with seeds of their own. Å²: the mean square displacement of Cα atoms, superposed, without the five "
        "residues at either end of longer chains, after seconds of a processor's time. Within a basin it has a limit."
    )
    return tabulate("How far Cα atoms are after seconds", rows, columns, 2, note)
