"""Means, their errors and what they rest on, as a table for people."""

import math

from ...notes import countOf
from .tables import alignedLines

_WORDS = {
    "potentialEnergy": "U (kJ/mol)",
    "radiusOfGyration": "radius of gyration (nm)",
    "endToEndDistance": "end-to-end distance (nm)",
    "rmsd": "RMSD to the start (nm)",
}
_GREEK = {
    "phi": "φ", "psi": "ψ", "omega": "ω", "chi": "χ", "chi1": "χ1", "chi2": "χ2", "chi3": "χ3", "chi4": "χ4",
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ε", "zeta": "ζ",
}  # fmt: skip
_NOT_TURNED = "has not turned"
_SYMBOLS = {"degrees": "°"}


def printEstimates(estimates, console, weighed=None):
    """Print a result of `estimateGroups` on a rich Console, and the averages of `weighLadder` if given."""
    at = "" if estimates["temperature"] is None else f" at {estimates['temperature']:.1f} K"
    chains = "" if estimates["chains"] == 1 else f" of {estimates['chains']} replicas"
    left = estimates["equilibration"]["trials"]
    words = f"the first {countOf(left, 'trial')} left out as equilibration" if left else "nothing left out"
    console.print(f"means{at} over {countOf(estimates['values'], 'frame')}{chains}, {words}:")
    rows = rowsOf(estimates, weighed)
    heading, *lines = alignedLines(rows, (False, *(len(rows[0]) - 2) * (True,), False))
    console.print(heading, style="bold")
    for line in lines:
        console.print(line)
    if estimates["verdict"] is None:
        console.print(f"every effective sample size is {estimates['leastSampleSize']:,.0f} or more")
    else:
        console.print(f"do not quote these means: {estimates['verdict']}")


def rowsOf(estimates, weighed=None):
    """Return the cells of the table, as texts, its headings first."""
    byMBAR = {} if weighed is None else {entry["name"]: describeMean(entry) for entry in weighed["observables"]}
    rows = [("observable", "mean ± error", "all temperatures", "τ (trials)", "sample size", "R-hat", "")]
    for entry in estimates["observables"]:
        rows.append((_WORDS[entry["name"]], describeMean(entry), byMBAR.get(entry["name"], ""), *_quality(entry)))
    for entry in estimates["torsions"]:
        kind = _GREEK.get(entry["kind"], entry["kind"])
        where = entry["slowest"].removeprefix(entry["kind"]).removeprefix(" of").strip()
        name = f"slowest of {entry['count']:,} {kind}: {where}" if entry["count"] > 1 else f"{kind}: {where}"
        rows.append((name, describeMean(entry), "", *_quality(entry)))
    if not byMBAR:
        rows = [(*row[:2], *row[3:]) for row in rows]
    return rows


def _quality(entry):
    time, sample, rhat, verdict = (
        entry[key] for key in ("autocorrelationTime", "effectiveSampleSize", "rhat", "verdict")
    )
    return (
        "–" if time is None else f"{time:,.0f}",
        "–" if sample is None else f"{sample:,.0f}",
        "–" if rhat is None else f"{rhat:.2f}",
        "" if verdict is None else _NOT_TURNED if verdict.endswith(_NOT_TURNED) else verdict.split(":")[0],
    )


def describeMean(entry):
    """Return the mean of an entry with its error, which has two digits."""
    mean, error = entry["mean"], entry["standardError"]
    unit = _SYMBOLS.get(entry["unit"], "")
    if mean is None:
        return "–"
    if not error:
        return f"{mean:,.4g}{unit}"
    digits = max(0, 1 - math.floor(math.log10(error)))
    return f"{mean:,.{digits}f} ± {error:.{digits}f}{unit}"
