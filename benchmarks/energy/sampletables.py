"""Tables of independent samples a second."""

import numpy as np
from racing.table import Table, groupBy, number

from .samplerows import OBSERVABLES, SAMPLES

OBSERVABLE_NAMES = {"chi": "χ", "backbone": "φ, ψ", "energy": "U", "rg": "Rg"}


def combineSamples(entries):
    """Return by protein and size the settings in their order: cutoffs and m, each with what all of its runs say."""
    proteins = groupBy([entry for entry in entries if entry["group"] == SAMPLES], lambda e: (e["chain"], e["asked"]))
    return {
        key: [_combine(runs) for runs in groupBy(ofOne, lambda entry: entry["contestant"]).values()]
        for key, ofOne in proteins.items()
    }


def _combine(runs):
    """Return geometric means over runs; of the rates also the values of each run."""
    rates = {key: np.array([run["rate"][key] for run in runs]) for key in OBSERVABLES}
    first = runs[0]
    return {
        **{key: first[key] for key in ("chain", "particles", "bornCutoff", "pairCutoff", "block", "trials")},
        "microseconds": _mean([run["microseconds"] for run in runs]),
        "kept": sum(run["outer"]["kept"] for run in runs) / max(1, sum(run["outer"]["tests"] for run in runs)),
        "apart": {key: _mean([run["apart"][key] for run in runs]) for key in OBSERVABLES},
        "rate": {key: _mean(values) for key, values in rates.items()},
        "rates": rates,
    }


def _mean(values):
    return float(np.exp(np.mean(np.log(values))))


def relativeError(settings, key):
    """Return the standard error of a rate's logarithm, as the runs of all settings tell it together, or None."""
    runs = [len(setting["rates"][key]) for setting in settings]
    if min(runs) < 2:
        return None
    variances = [np.var(np.log(setting["rates"][key]), ddof=1) for setting in settings]
    return float(np.sqrt(np.mean(np.divide(variances, runs))))


def makeSampleTables(entries):
    """Return the tables of entries."""
    columns = ["cutoffs: Born sums / pairs, nm", "m", "µs a trial", "outer tests kept", "trials between independent χ"]
    columns += [f"{OBSERVABLE_NAMES[key]}, a second" for key in OBSERVABLES]
    return [
        Table(
            f"Independent samples a second, {chain}, {settings[0]['particles']:,} atoms",
            columns,
            [_line(setting) for setting in settings],
            1,
            _describe(settings),
        )
        for (chain, _), settings in combineSamples(entries).items()
    ]


def _line(setting):
    return [
        f"{setting['bornCutoff']} / {setting['pairCutoff']}",
        str(setting["block"]),
        number(setting["microseconds"]),
        f"{setting['kept']:.2f}",
        number(setting["apart"]["chi"]),
        *(number(setting["rate"][key]) for key in OBSERVABLES),
    ]


def _describe(settings):
    runs, trials = len(settings[0]["rates"]["chi"]), settings[0]["trials"]
    longest = {key: max(setting["apart"][key] for setting in settings) for key in OBSERVABLES}
    notes = [
        f"{runs} × {trials:,} trials a line, without their first tenth. Samples are independent if they are 1 + 2 Σ ρ "
        "trials apart, ρ being the autocorrelation of the cosine of a torsion (the median over torsions), of U, and of "
        "the radius of gyration, about the mean of all lines. Geometric means over runs, by processor time.",
        "Trials between independent samples, at most: "
        + ", ".join(f"{OBSERVABLE_NAMES[key]} {value:,.0f}" for key, value in longest.items())
        + ". Where that is not far below the length of a chain, it is too small, and samples a second are too many.",
    ]
    errors = {key: relativeError(settings, key) for key in OBSERVABLES}
    if errors["chi"] is not None:
        words = ", ".join(f"{OBSERVABLE_NAMES[key]} {100 * error:.0f} %" for key, error in errors.items())
        notes.append(f"Standard error of a number in its column, from the runs of all lines: {words}.")
    return [*notes, _describeMeans(settings)]


def _describeMeans(settings):
    """Return the rates of torsions of side chains by cutoffs alone and by m alone: their errors are smaller."""
    cutoffs = groupBy(settings, lambda setting: f"{setting['bornCutoff']} / {setting['pairCutoff']} nm")
    blocks = groupBy(settings, lambda setting: f"m = {setting['block']}")
    parts = []
    for groups in (cutoffs, blocks):
        means = {name: _mean([setting["rate"]["chi"] for setting in ofOne]) for name, ofOne in groups.items()}
        errors = [relativeError(ofOne, "chi") for ofOne in groups.values()]
        if None in errors:
            error = ""
        else:
            pooled = np.sqrt(np.mean(np.square(errors)) / np.mean([len(ofOne) for ofOne in groups.values()]))
            error = f" (± {100 * pooled:.0f} %)"
        parts.append(", ".join(f"{name}: {number(value)}" for name, value in means.items()) + error)
    return f"χ, a second, in the mean over all m: {parts[0]}; over all cutoffs: {parts[1]}."
