"""Tables of what implicit solvent costs, how exact it is, and how near stand-ins are."""

from racing.races import OURS
from racing.table import Table, exponent, groupBy, number

from .rows import FOREIGN, ONE_ENERGY
from .sampletables import makeSampleTables
from .solventrows import EXPRESSION, EXPRESSIONS, KT, NO_SOLVENT, OUTER_TEST, SIZES, SOLVENT, STAND_INS, WHOLE
from .solventrows import TRIALS_PER_OUTER_TEST as USUAL
from .tables import anyOf, combineRuns, describeStages, timeRange


def makeTables(entries):
    """Return the tables of entries."""
    rows = combineRuns(entries)
    ofGroup = {
        group: [row for row in rows if anyOf(row)["group"] == group]
        for group in (SOLVENT, WHOLE, STAND_INS, SIZES, EXPRESSIONS)
    }
    tables = []
    if ofGroup[SOLVENT]:
        tables += [_makeTrials(ofGroup[SOLVENT], ofGroup[WHOLE]), describeStages(ofGroup[SOLVENT])]
    if ofGroup[WHOLE]:
        tables.append(_makeWhole(ofGroup[WHOLE]))
    if ofGroup[STAND_INS]:
        tables.append(_makeStandIns(ofGroup[STAND_INS]))
    tables += makeSampleTables(entries)
    if ofGroup[SIZES]:
        tables.append(_makeSizes(ofGroup[SIZES]))
    if ofGroup[EXPRESSIONS]:
        tables.append(_makeExpressions(ofGroup[EXPRESSIONS]))
    return tables


def acceptance(entry):
    """Return the share of outer tests that kept their trials."""
    return entry["outer"]["kept"] / max(1, entry["outer"]["tests"])


def outerShare(row, wholeRows):
    """Return the share of the time of whole trials that outer tests take, or None."""
    for whole in wholeRows:
        if anyOf(whole)["chain"] == anyOf(row)["chain"] and OUTER_TEST in whole:
            return whole[OUTER_TEST]["microseconds"] / (USUAL * row[OURS]["microseconds"])
    return None


def sizeGrowth(rows):
    """Return x by the kind of moves, where trials cost N^x; those of rows of one size have none."""
    kinds = groupBy(rows, lambda row: anyOf(row)["moves"])
    times = {
        moves: {anyOf(row)["particles"]: row[OURS]["microseconds"] for row in ofOne} for moves, ofOne in kinds.items()
    }
    return {moves: exponent(ofOne) for moves, ofOne in times.items() if len(ofOne) > 1}


def _labels(row):
    entry = anyOf(row)
    return [entry["chain"], f"{entry['particles']:,}"]


def _times(first, second):
    return "–" if first is None or second is None else number(first["microseconds"] / second["microseconds"])


def _makeTrials(rows, wholeRows):
    columns = ["protein", "N", "ours", "without solvent", "OpenMM for each free trial", "OpenMM / ours"]
    columns += ["outer tests kept", "difference, kT", "outer tests' share of the time"]
    lines = []
    for row in rows:
        ours, foreign = row[OURS], row.get(FOREIGN)
        share = outerShare(row, wholeRows)
        lines.append(
            [
                *_labels(row),
                timeRange(ours),
                timeRange(row.get(NO_SOLVENT)),
                timeRange(foreign),
                _times(foreign, ours),
                f"{acceptance(ours):.2f} of {ours['outer']['tests']:,}",
                f"{ours['outer']['deviation'] / KT:.2f}",
                "–" if share is None else f"{100 * share:.0f} %",
            ]
        )
    notes = [
        f"AMBER14 with GBn2, no cutoff, by Simulation.step with the moves of examples/sample_protein.py, an outer test "
        f"after {USUAL} trials; hard spheres and outer tests are in it. Medians over turns, and over runs (with their "
        "range). Without solvent: the same without GBn2. OpenMM for each free trial: setNativeEnergies(False), on the "
        "CPU platform with one thread."
    ]
    return Table("Whole trials in implicit solvent, µs", columns, lines, 1, notes)


def _makeWhole(rows):
    columns = ["protein", "N", "ours", "OpenMM", "OpenMM / ours", "U, kJ/mol", "error, ours", "error, OpenMM CPU"]
    lines = []
    for row in rows:
        ours, other = row[OUTER_TEST], row.get(ONE_ENERGY)
        lines.append(
            [
                *_labels(row),
                timeRange(ours),
                timeRange(other),
                _times(other, ours),
                f"{ours['energy']:,.0f}",
                f"{ours['energyError']:.1e}",
                "–" if other is None else f"{other['energyError']:.1e}",
            ]
        )
    notes = [
        "Ours: an outer test, which is one whole energy, and copies of what it may take back. OpenMM: positions set "
        "and one energy, CPU platform, one thread. Errors: from OpenMM's Reference platform."
    ]
    return Table("One whole energy in implicit solvent, µs", columns, lines, 1, notes)


def _makeStandIns(rows):
    columns = ["protein", "cutoffs: Born sums / pairs, nm", "m", "µs a trial", "difference, kJ/mol", "kT"]
    columns += ["outer tests kept", "µs a kept trial"]
    lines = []
    for row in rows:
        for entry in row.values():
            kept = acceptance(entry)
            deviation = entry["outer"]["deviation"]
            lines.append(
                [
                    entry["chain"],
                    f"{entry['bornCutoff']} / {entry['pairCutoff']}",
                    str(entry["block"]),
                    timeRange(entry),
                    f"{deviation:.2f}",
                    f"{deviation / KT:.2f}",
                    f"{kept:.2f} of {entry['outer']['tests']:,}",
                    number(entry["microseconds"] / kept) if kept > 0 else "–",
                ]
            )
    notes = [
        "Difference: standard deviation of that by which m trials change U - U1. Kept: by the outer tests, whose time "
        "is in that of the trials."
    ]
    return Table("Stand-ins by cutoffs and trials of an outer test", columns, lines, 2, notes)


def _makeSizes(rows):
    columns = ["protein", "move", "N", "a trial", "accepted", "an outer test"]
    lines = []
    for row in rows:
        chain, particles = _labels(row)
        ours = row[OURS]
        accepted = f"{100 * ours['accepted']:.0f} %"
        lines.append([chain, ours["moves"], particles, timeRange(ours), accepted, timeRange(row[OUTER_TEST])])
    notes = [
        "Whole trials in GBn2, but for outer tests. End of a chain: φ and ψ of its last eight residues. Outer tests: "
        "by a difference, rough below 2,000 µs.",
        *(
            f"Trials grow as N^{growth:.2f} ({moves}), by a fit to the logarithms of all sizes."
            for moves, growth in sizeGrowth(rows).items()
        ),
    ]
    return Table("Trials that move few atoms in implicit solvent, as proteins grow, µs", columns, lines, 2, notes)


def _makeExpressions(rows):
    columns = ["protein", "move", "N", "NonbondedForce", "CustomNonbondedForce", "ratio", "the same, of a free trial"]
    columns += ["accepted"]
    lines = []
    for row in rows:
        chain, particles = _labels(row)
        native, custom = row[OURS], row[EXPRESSION]
        free = 1 - custom["clashed"] / custom["attempted"]
        lines.append(
            [
                chain,
                custom["moves"],
                particles,
                timeRange(native),
                timeRange(custom),
                _times(custom, native),
                number(custom["microseconds"] / free),
                f"{100 * custom['accepted']:.0f} %",
            ]
        )
    notes = [
        "Whole trials: Lennard-Jones with a reaction field at 1.0 nm by the kernels of NonbondedForce, and as the "
        "expression of a CustomNonbondedForce. Of a free trial: all of the time of the latter, by trials without a "
        "clash."
    ]
    return Table("Pairs by an expression, µs", columns, lines, 2, notes)
