"""Tables of what implicit solvent costs, how exact it is, and how near stand-ins are."""

from energytables import FOREIGN, ONE_ENERGY, makeStages
from measure import OURS
from proteins import KT, TRIALS_PER_OUTER_TEST
from report import anyOf, number, racesOf, ratioOf, tabulate, timeRange

OUTER_TEST = f"{OURS}, an outer test"
NO_SOLVENT = f"{OURS}, without solvent"

CUTOFFS = ((0.45, 0.7), (0.55, 0.7), (0.55, 0.8), (0.65, 0.9), (1.0, 1.2))  # of Born sums and of pairs, nm
BLOCKS = (50, 100, 400)  # trials of an outer test

_LABELS = {
    "protein": lambda race: anyOf(race)["chain"],
    "N": lambda race: f"{anyOf(race)['particles']:,}",
}


def makeTables(entries):
    """Return the tables of entries."""
    trials, whole = racesOf(entries, "solvent"), racesOf(entries, "whole")
    standIns = [entry for race in racesOf(entries, "standins") for entry in race.values()]
    return [*_makeTrials(trials, whole), *makeStages(trials), *_makeWhole(whole), *_makeStandIns(standIns)]


def keptOf(entry):
    """Return the share of outer tests that kept their trials."""
    return entry["outer"]["kept"] / max(1, entry["outer"]["tests"])


def _makeTrials(races, whole):
    outerTests = {anyOf(race)["chain"]: race[OUTER_TEST]["microseconds"] for race in whole}

    def shareOf(race):
        time = outerTests.get(anyOf(race)["chain"])
        return "–" if time is None else f"{100 * time / (TRIALS_PER_OUTER_TEST * race[OURS]['microseconds']):.0f} %"

    columns = {
        **_LABELS,
        "ours": lambda race: timeRange(race[OURS]),
        "without solvent": lambda race: timeRange(race[NO_SOLVENT]),
        "OpenMM for each free trial": lambda race: timeRange(race[FOREIGN]),
        "OpenMM / ours": lambda race: ratioOf(race[FOREIGN], race[OURS]),
        "outer tests kept": lambda race: f"{keptOf(race[OURS]):.2f} of {race[OURS]['outer']['tests']:,}",
        "difference, kT": lambda race: f"{race[OURS]['outer']['deviation'] / KT:.2f}",
        "outer tests' share of the time": shareOf,
    }
    note = (
        "AMBER14 with GBn2, no cutoff, by Simulation.step with the moves of examples/sample_protein.py, an outer test "
        f"after {TRIALS_PER_OUTER_TEST} trials; hard spheres and outer tests are in it. Medians over turns, and over "
        "runs (with their range). Without solvent: the same without GBn2. OpenMM for each free trial: "
        "setNativeEnergies(False), on the CPU platform with one thread."
    )
    return tabulate("Whole trials in implicit solvent, µs", races, columns, 1, note)


def _makeWhole(races):
    columns = {
        **_LABELS,
        "ours": lambda race: timeRange(race[OUTER_TEST]),
        "OpenMM": lambda race: timeRange(race[ONE_ENERGY]),
        "OpenMM / ours": lambda race: ratioOf(race[ONE_ENERGY], race[OUTER_TEST]),
        "U, kJ/mol": lambda race: f"{race[OUTER_TEST]['energy']:,.0f}",
        "error, ours": lambda race: f"{race[OUTER_TEST]['energyError']:.1e}",
        "error, OpenMM CPU": lambda race: f"{race[ONE_ENERGY]['energyError']:.1e}",
    }
    note = (
        "Ours: an outer test, which is one whole energy, and copies of what it may take back. OpenMM: positions set "
        "and one energy, CPU platform, one thread. Errors: from OpenMM's Reference platform."
    )
    return tabulate("One whole energy in implicit solvent, µs", races, columns, 1, note)


def _makeStandIns(entries):
    columns = {
        "protein": lambda entry: entry["chain"],
        "cutoffs: Born sums / pairs, nm": lambda entry: f"{entry['bornCutoff']} / {entry['pairCutoff']}",
        "m": lambda entry: str(entry["block"]),
        "µs a trial": timeRange,
        "difference, kJ/mol": lambda entry: f"{entry['outer']['deviation']:.2f}",
        "kT": lambda entry: f"{entry['outer']['deviation'] / KT:.2f}",
        "outer tests kept": lambda entry: f"{keptOf(entry):.2f} of {entry['outer']['tests']:,}",
        "µs a kept trial": lambda entry: number(entry["microseconds"] / keptOf(entry)) if keptOf(entry) > 0 else "–",
    }
    note = (
        "Difference: standard deviation of the change of U − U1 over m trials. Kept: by the outer tests, whose time "
        "is in that of the trials."
    )
    return tabulate("Stand-ins by cutoffs and trials of an outer test", entries, columns, 2, note)
