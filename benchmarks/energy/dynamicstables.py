"""What trials and Langevin dynamics have come to in the same processor time."""

import numpy as np
from racing.races import OURS
from racing.table import Table, groupBy, number

from .dynamicsrows import GROUP, LANGEVIN, TIMESTEP


def ofContestants(entries):
    """Return the entries of each contestant, in the order of turns."""
    return groupBy([entry for entry in entries if entry["group"] == GROUP], lambda entry: entry["contestant"])


def describeWork(entry):
    """Return how much a run has done by an entry: trials, or ps."""
    if entry["contestant"] == OURS:
        return f"{entry['trials']:,} trials"
    return f"{entry['trials'] * TIMESTEP:,.3g} ps"


def makeTables(entries):
    """Return the table of entries."""
    columns = ["", "done", "processor time, minutes", "µs a trial or step", "U but bonds and angles, kJ/mol"]
    columns += ["RMSD, nm", "Rg, nm", "χ that left their rotamer"]
    lines = []
    for name, ofOne in ofContestants(entries).items():
        last, half = ofOne[-1], ofOne[len(ofOne) // 2 :]
        times = [entry["microseconds"] for entry in ofOne if entry["turn"] > 0]
        lines.append(
            [
                name,
                describeWork(last),
                f"{last['seconds'] / 60:.2f}",
                number(float(np.median(times))) if times else "–",
                _meanOf(half, "energy", ",.0f"),
                _meanOf(half, "rmsd", ".3f"),
                _meanOf(half, "rg", ".3f"),
                f"{100 * last['turned']:.0f} %",
            ]
        )
    notes = [
        "U, RMSD and Rg: mean over the second half of the run, and in brackets the standard deviation within it. RMSD: "
        "of alpha carbons, from the start. χ: share of torsions of side chains that some point had more than "
        f"60° from the start. {LANGEVIN}: LangevinMiddleIntegrator, {1000 * TIMESTEP:g} fs, hydrogens of 1.5 amu, "
        "bonds to hydrogens constrained."
    ]
    chain = entries[0]["chain"] if entries else ""
    return [Table(f"{chain} by trials and by dynamics", columns, lines, 1, notes)] if lines else []


def _meanOf(entries, key, form):
    values = np.array([entry[key] for entry in entries])
    return f"{values.mean():{form}} ({values.std():{form}})"
