"""Tables of what was measured of chains of beads."""

import numpy as np
from racing.table import Table, groupBy, number

from .rows import DISORDERED, LANGEVIN, PIVOTS

MOST_PIVOT = {("random compact", 10000): 3.0, ("coil", 10000): 1.5}  # µs, goals
LEAST_RATIO = 100  # a goal


def makeTables(entries):
    """Return the tables of entries."""
    return [table for table in (_pivots(entries), _disordered(entries)) if table.rows]


def _pivots(entries):
    columns = ["chain", "rotations", "beads", "trials", "Rg, nm", "accepted", "µs a trial", "goal"]
    lines = []
    ofRows = groupBy(
        [entry for entry in entries if entry["group"] == PIVOTS],
        lambda entry: (entry["chain"], entry["particles"], entry["angle"]),
    )
    for (chain, particles, angle), ofRow in ofRows.items():
        times = [entry["microseconds"] for entry in ofRow]
        isWhole = angle > 3
        goal = MOST_PIVOT.get((chain, particles)) if isWhole else None
        lines.append(
            [
                chain,
                "all" if isWhole else f"up to {np.degrees(angle):.0f}°",
                f"{particles:,}",
                f"{len(ofRow)} × {ofRow[0]['trials']:,}",
                " → ".join(number(float(np.mean([entry[key] for entry in ofRow]))) for key in ("startRg", "rg")),
                f"{np.mean([entry['accepted'] for entry in ofRow]):.2f}",
                f"{number(float(np.median(times)))} ({number(min(times))}–{number(max(times))})",
                "" if goal is None else f"≤ {goal:g}",
            ]
        )
    notes = [
        "Whole trials of TorsionMonteCarloIntegrator with addPivotMove, hard spheres of radius 0.1 nm, bonds of "
        "0.4 nm; median over chains (range). Random compact: a path through a cubic lattice at the start, which pivots "
        "by all rotations unfold. Coil: from 30 such trials a bead."
    ]
    return Table("Pivots of bead chains", columns, lines, 2, notes)


def _disordered(entries):
    columns = [
        "",
        "µs a trial or step",
        "accepted",
        "Rg, nm",
        "done",
        "independent",
        "independent Rg a second",
        "ratio",
    ]
    found = [entry for entry in entries if entry["group"] == DISORDERED]
    dynamics = [entry["rate"] for entry in found if entry["contestant"] == LANGEVIN]
    lines = []
    for entry in found:
        isDynamics = entry["contestant"] == LANGEVIN
        lines.append(
            [
                entry["contestant"],
                number(entry["microseconds"]),
                "–" if isDynamics else f"{entry['accepted']:.2f}",
                f"{entry['rg']:.3f} ± {entry['rgError']:.3f}",
                f"{entry['trials']:,} {'steps' if isDynamics else 'trials'}",
                number(entry["independent"]),
                number(entry["rate"]),
                number(entry["rate"] / dynamics[0]) if dynamics else "–",
            ]
        )
    notes = [
        "One bead a residue, CALVADOS 2 (Ashbaugh-Hatch to 2 nm, Debye-Hückel to 4 nm, 300 K), by processor time of "
        "one core. Pivots: both pair forces native, hard cores of 0.34 nm in addition. "
        f"{LANGEVIN}: LangevinMiddleIntegrator, 10 fs, 0.01/ps, OpenMM's CPU platform with one thread, harmonic "
        "bonds. Independent: by the autocorrelation of the radius of gyration. "
        f"Goal: a ratio of {LEAST_RATIO}."
    ]
    return Table("A coarse-grained disordered protein by pivots and by dynamics", columns, lines, 1, notes)
