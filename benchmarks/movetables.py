"""Tables of what moves do, and of independent samples a second."""

from measure import OURS
from report import number, racesOf, tabulate

# Contestants.
PIVOTS, DEFAULTS = "pivots alone", "addDefaultMoves"

RMSDS = ("rmsd", "rmsdWithoutEnds")

# What samples are of, by the keys of entries.
_OBSERVED = {
    "phi": "φ",
    "psi": "ψ",
    "chi1": "χ1",
    "backbone": "α–ζ",
    "bases": "χ of bases",
    "slow": "slow torsions",
    "slowest": "slowest torsion",
    "rmsd": "RMSD",
    "rmsdWithoutEnds": "RMSD without ends",
}


def makeTables(entries):
    """Return the tables of entries."""
    makers = {"moves": _makeMoves, "stationary": _makeStationary}
    tables = []
    for group, make in makers.items():
        ofGroup = [race[OURS] for race in racesOf(entries, group)]
        tables += make(ofGroup) if ofGroup else []
    return tables


def _makeMoves(entries):
    lag = f"{max(entry['lag'] for entry in entries):,}"
    columns = {
        "protein": lambda e: e["chain"],
        "move": lambda e: e["moves"],
        "accepted": lambda e: f"{e['accepted'] / max(1, e['attempted']):.3f}",
        "clashed": lambda e: f"{e['clashed'] / max(1, e['attempted']):.3f}",
        "Σdr² a trial, nm²": lambda e: f"{e['shift']:.2g}",
        "µs a trial": lambda e: number(e["microseconds"]),
        "Σdr², nm² a ms": lambda e: f"{1e3 * e['shift'] / e['microseconds']:.2g}",
        f"1 − ρ, {lag} trials": lambda e: f"{1 - e['autocorrelation']:.2g}",
        "1 − ρ a second": lambda e: f"{1e6 * (1 - e['autocorrelation']) / (e['lag'] * e['microseconds']):.2g}",
    }
    note = (
        "AMBER14 with GBn2 at 300 K, hard spheres, from the folded state. Accepted: before outer tests. Σdr²: of all "
        "atoms, over all trials, each with an outer test of its own. µs: an outer test after 400 trials is in it. ρ: "
        f"the autocorrelation ⟨cos Δθ⟩ of the torsions that the move turns, {lag} trials apart, the mean over them."
    )
    return tabulate("Moves from the folded state", entries, columns, 2, note)


def _makeStationary(entries):
    keys = [key for key in _OBSERVED if any(key in entry["rate"] for entry in entries)]
    columns = {
        "protein": lambda e: e["chain"],
        "mixture": lambda e: e["moves"],
        "trials": lambda e: f"{e['trials']:,}",
        "µs a trial": lambda e: number(e["microseconds"]),
        "outer tests kept": lambda e: f"{e['keptShare']:.2f}",
    }
    for key in keys:
        columns[_OBSERVED[key]] = lambda e, key=key: (
            f"{'≤ ' if e['moves'] == PIVOTS else ''}{e['rate'][key]:.3g}" if key in e["rate"] else "–"
        )
    note = (
        "AMBER14 with GBn2 at 300 K. Independent samples a second of the processor's time. Default moves: by the "
        "autocorrelation along one chain, without its first quarter. Pivots alone: at most, by chains that begin with "
        "states of that one, from their changes over up to the lag (0.75 of their length) and the variances of the "
        "long chain. Torsions: medians over all torsions of a kind; slow: nine tenths are faster."
    )
    return tabulate("Independent samples a second from states of the ensemble", entries, columns, 2, note)
