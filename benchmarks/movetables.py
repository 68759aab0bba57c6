"""Tables of what moves do, and of independent samples a second by mixtures of moves."""

from measure import OURS
from report import number, racesOf, tabulate

# Contestants.
PIVOTS, DEFAULTS, LOCAL = "pivots alone", "addDefaultMoves", "local moves alone"

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
    makers = {"moves": _makeMoves, "mixtures": _makeMixtures, "stationary": _makeStationary, "coils": _makeCoils}
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


def _observed(entries, limitOf=lambda entry: ""):
    """Return the columns of rates."""
    keys = [key for key in _OBSERVED if any(key in entry["rate"] for entry in entries)]
    return {
        _OBSERVED[key]: lambda e, key=key: f"{limitOf(e)}{e['rate'][key]:.3g}" if key in e["rate"] else "–"
        for key in keys
    }


def _makeMixtures(entries):
    def toPivots(entry):
        pivots = _find(entries, entry, PIVOTS)
        return ", ".join(f"{entry['rate'][key] / pivots['rate'][key]:.2g}" for key in ("slow", "rmsd"))

    columns = {
        "protein": lambda e: e["chain"],
        "mixture": lambda e: e["moves"],
        "µs a trial": lambda e: number(e["microseconds"]),
        "outer tests kept": lambda e: f"{e['keptShare']:.2f}",
        **_observed(entries),
        "to pivots": toPivots,
    }
    columns.pop(_OBSERVED["slowest"], None)
    note = (
        "AMBER14 with GBn2 at 300 K from the folded state. Independent samples a second of the processor's time, from "
        "the autocorrelation of cosines and sines of torsions (medians over those of a kind; slow: nine tenths of "
        "torsions are faster) and of the heavy atoms' RMSD from the start, also without five residues at either end. "
        "To pivots: slow torsions and the RMSD by those of pivots alone. Rates below a few in the time of the chain "
        "are rough."
    )
    return tabulate("Independent samples a second by mixtures of moves", entries, columns, 2, note)


def _find(entries, entry, moves):
    """Return the entry of the same chain by other moves, or else the entry itself."""
    return next((e for e in entries if e["chain"] == entry["chain"] and e["moves"] == moves), entry)


def _makeStationary(entries):
    columns = {
        "protein": lambda e: e["chain"],
        "mixture": lambda e: e["moves"],
        "trials": lambda e: f"{e['trials']:,}",
        "µs a trial": lambda e: number(e["microseconds"]),
        "outer tests kept": lambda e: f"{e['keptShare']:.2f}",
        **_observed(entries, lambda e: "≤ " if e["moves"] == PIVOTS else ""),
    }
    note = (
        "AMBER14 with GBn2 at 300 K. Independent samples a second of the processor's time. Default moves: by the "
        "autocorrelation along one chain, without its first quarter. Pivots alone: at most, by chains that begin with "
        "states of that one, from their changes over up to the lag (0.75 of their length) and the variances of the "
        "long chain. Torsions: medians over those of a kind; slow: nine tenths are faster."
    )
    return tabulate("Independent samples a second from states of the ensemble", entries, columns, 2, note)


def _makeCoils(entries):
    columns = {
        "protein": lambda e: e["chain"],
        "moves": lambda e: e["moves"],
        "µs a trial": lambda e: number(e["microseconds"]),
        "radius of gyration, nm": lambda e: f"{e['rg']:.2f}",
        "independent ones a second": lambda e: f"{e['rate']['rg']:.3g}",
        "to local moves": lambda e: f"{e['rate']['rg'] / _find(entries, e, LOCAL)['rate']['rg']:.2g}",
    }
    note = "Hard spheres without energy, unfolded by trials that draw a torsion of the backbone."
    return tabulate("A loose chain of hard spheres", entries, columns, 2, note)
