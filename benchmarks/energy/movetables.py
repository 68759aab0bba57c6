"""Tables of what moves do, and of independent samples a second by mixtures of moves."""

import numpy as np
from racing.table import Table, groupBy, number

from .coilrows import COILS, LOCAL
from .moverows import MIXTURES, MOVES, PIVOTS
from .stationaryrows import STATIONARY

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
    makers = {MOVES: _makeMoves, MIXTURES: _makeMixtures, STATIONARY: _makeStationary, COILS: _makeCoils}
    return [
        makers[group]([entry for entry in entries if entry["group"] == group])
        for group in makers
        if any(entry["group"] == group for entry in entries)
    ]


def combine(entries):
    """Return the entries of runs that differ in nothing but the seed as one: medians of times, sums of counts."""
    counts = ("attempted", "clashed", "rejected", "accepted", "trials")
    combined = []
    for same in groupBy(entries, lambda entry: (entry["chain"], entry["moves"])).values():
        one = dict(same[0])
        for key, value in one.items():
            values = [entry[key] for entry in same]
            if key in counts:
                one[key] = sum(values)
            elif isinstance(value, dict):
                one[key] = {name: float(np.median([each[name] for each in values])) for name in value}
            elif isinstance(value, float):
                one[key] = float(np.median(values))
        combined.append(one)
    return combined


def _makeMoves(entries):
    lag = f"{max(entry['lag'] for entry in entries):,}"
    columns = [
        "protein",
        "move",
        "accepted",
        "clashed",
        "Σdr² a trial, nm²",
        "µs a trial",
        "Σdr², nm² a ms",
        f"1 − ρ, {lag} trials",
        "1 − ρ a second",
    ]
    lines = []
    for entry in combine(entries):
        attempted = max(1, entry["attempted"])
        lines.append(
            [
                entry["chain"],
                entry["moves"],
                f"{entry['accepted'] / attempted:.3f}",
                f"{entry['clashed'] / attempted:.3f}",
                f"{entry['shift']:.2g}",
                number(entry["microseconds"]),
                f"{1e3 * entry['shift'] / entry['microseconds']:.2g}",
                f"{1 - entry['autocorrelation']:.2g}",
                f"{1e6 * (1 - entry['autocorrelation']) / (entry['lag'] * entry['microseconds']):.2g}",
            ]
        )
    notes = [
        "AMBER14 with GBn2 at 300 K, hard spheres, from the folded state after trials. Accepted: by what trials see, "
        "before outer tests. Σdr²: of all atoms, over all trials, each with an outer test of its own. µs: an outer "
        "test after 400 trials is in it. ρ: the autocorrelation ⟨cos Δθ⟩ of the torsions that the move turns, "
        f"{lag} trials apart, the mean over them."
    ]
    return Table("Moves from the folded state", columns, lines, 2, notes)


def _makeMixtures(entries):
    keys = [key for key in _OBSERVED if key != "slowest" and any(key in entry["rate"] for entry in entries)]
    columns = ["protein", "mixture", "µs a trial", "outer tests kept", *(_OBSERVED[key] for key in keys), "to pivots"]
    combined = combine(entries)
    lines = []
    for entry in combined:
        pivots = next((e for e in combined if e["chain"] == entry["chain"] and e["moves"] == PIVOTS), entry)
        ratios = [entry["rate"][key] / pivots["rate"][key] for key in ("slow", "rmsd")]
        lines.append(
            [
                entry["chain"],
                entry["moves"],
                number(entry["microseconds"]),
                f"{entry['kept']:.2f}",
                *(f"{entry['rate'][key]:.3g}" if key in entry["rate"] else "–" for key in keys),
                f"{ratios[0]:.2g}, {ratios[1]:.2g}",
            ]
        )
    notes = [
        "AMBER14 with GBn2 at 300 K from the folded state. Independent samples a second of the processor's time, from "
        "the autocorrelation of cosines and sines of torsions (medians over those of a kind; slow: that which nine "
        "tenths of torsions exceed) and of the heavy atoms' RMSD from the start, also without five residues at either "
        "end. To pivots: slow torsions and the RMSD by those of pivots alone. A chain that is not much longer than its "
        "correlations tells too little: look for rates well above a few in the time of the chain."
    ]
    return Table("Independent samples a second by mixtures of moves", columns, lines, 2, notes)


def _makeStationary(entries):
    keys = [key for key in _OBSERVED if any(key in entry["rate"] for entry in entries)]
    columns = ["protein", "mixture", "trials", "µs a trial", "outer tests kept", *(_OBSERVED[key] for key in keys)]
    lines = []
    for ofOne in groupBy(combine(entries), lambda entry: entry["chain"]).values():
        pivots, ours = (next(entry for entry in ofOne if (entry["moves"] == PIVOTS) == isPivots) for isPivots in (1, 0))
        for entry, limit in ((pivots, "≤ "), (ours, "")):
            lines.append(
                [
                    entry["chain"],
                    entry["moves"],
                    f"{entry['trials']:,}",
                    number(entry["microseconds"]),
                    f"{entry['kept']:.2f}",
                    *(f"{limit}{entry['rate'][key]:.3g}" if key in entry["rate"] else "–" for key in keys),
                ]
            )
        ratios = (f"≥ {ours['rate'][key] / pivots['rate'][key]:.2g}" if key in ours["rate"] else "–" for key in keys)
        lines.append([ours["chain"], "ratio", "", "", "", *ratios])
    lag = f"{max(entry['lag'] for entry in entries):,}"
    notes = [
        "AMBER14 with GBn2 at 300 K. Independent samples a second of the processor's time. Of the default moves by the "
        "autocorrelation along one chain, without its first quarter. Of pivots alone at most, by chains that begin "
        f"with states of that one: from how far they come in {lag} trials, and the variances of the long chain. "
        "Torsions: medians over those of a kind; slow: that which nine tenths exceed; the slowest of each mixture."
    ]
    return Table("Independent samples a second from states of the ensemble", columns, lines, 2, notes)


def _makeCoils(entries):
    columns = [
        "protein",
        "moves",
        "µs a trial",
        "radius of gyration, nm",
        "independent ones a second",
        "to local moves",
    ]
    lines = []
    combined = combine(entries)
    for entry in combined:
        local = next((e for e in combined if e["chain"] == entry["chain"] and e["moves"] == LOCAL), entry)
        lines.append(
            [
                entry["chain"],
                entry["moves"],
                number(entry["microseconds"]),
                f"{entry['rg']:.2f}",
                f"{entry['rate']['rg']:.3g}",
                f"{entry['rate']['rg'] / local['rate']['rg']:.2g}",
            ]
        )
    notes = ["Hard spheres without energy, unfolded by trials that draw a torsion of the backbone anew."]
    return Table("A loose chain of hard spheres", columns, lines, 2, notes)
