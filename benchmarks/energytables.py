"""Tables of what energies of trials cost and how exact they are."""

from measure import OURS
from report import anyOf, number, percent, racesOf, ratioOf, tabulate, timeOf, timeRange

# Contestants.
STAGES = f"{OURS}-stages"
ONE_ENERGY, TWO_ENERGIES = "OpenMM CPU, one energy", "OpenMM CPU, two energies"
FOREIGN = "OpenMM CPU, energies of free trials"

SETS = {f"{OURS}-avx512": "AVX-512", f"{OURS}-avx2": "AVX2", f"{OURS}-portable": "portable"}
_PARTS = {"terms": "terms", "near": "near pairs", "other": "other pairs"}

# Of U and of its changes, kJ/mol: energies that differ by ten times this from OpenMM's are wrong.
_RELATIVE, _ABSOLUTE, _CHANGE, _WRONG = 1e-6, 5e-3, 1e-3, 10


def makeTables(entries):
    """Return the tables of entries."""
    work, trials = racesOf(entries, "work"), racesOf(entries, "trials")
    return [*_makeWork(work), *_makeParts(work), *_makeTrials(trials), *makeStages(trials), *_makeErrors(work)]


def findWrong(entries):
    """Return a line about each of our energies that is wrong."""
    lines = []
    for entry in entries:
        if entry["contestant"].startswith(OURS) and "energyError" in entry:
            bound = _WRONG * (_ABSOLUTE + _RELATIVE * abs(entry["energy"]))
            change = entry.get("changeError", {"largest": 0})["largest"]
            if not (entry["energyError"] <= bound and change <= _WRONG * _CHANGE):
                error = f"{entry['energyError']:.1e} and {change:.1e} kJ/mol"
                lines.append(f"{entry['chain']}, {entry['method']}: U and its changes differ from OpenMM's by {error}")
    return lines


def widest(race):
    """Return the engine's entry by the widest instructions."""
    return next(race[name] for name in (OURS, *SETS) if name in race)


_LABELS = {
    "protein": lambda race: anyOf(race)["chain"],
    "U": lambda race: anyOf(race)["method"],
    "move": lambda race: anyOf(race)["moves"],
    "N": lambda race: f"{anyOf(race)['particles']:,}",
}


def _makeWork(races):
    columns = {**_LABELS, "trials": lambda race: f"{widest(race)['free']:,}"}
    for name, words in SETS.items():
        columns[words] = lambda race, name=name: timeRange(race.get(name))
    columns["until refused"] = lambda race: timeOf(race[STAGES], "mean")
    columns["OpenMM, 1 energy"] = lambda race: timeOf(race.get(ONE_ENERGY))
    columns["OpenMM, 2"] = lambda race: timeOf(race.get(TWO_ENERGIES))
    columns["1 / ours"] = lambda race: ratioOf(race.get(ONE_ENERGY), widest(race))
    columns["2 / until refused"] = lambda race: ratioOf(race.get(TWO_ENERGIES), race[STAGES], "mean")
    note = (
        "Trials without a clash: all parts of the change of energy, and accepting it. Medians over trials, and over "
        "runs (with their range). Until refused: part by part, mean over trials. OpenMM: positions set and one "
        "energy, or two, on the CPU platform with one thread."
    )
    return tabulate("Energy work of a trial, µs", races, columns, 3, note)


def _makeParts(races):
    columns = {**_LABELS, "accepted": lambda race: percent(widest(race)["accepted"], widest(race)["free"])}
    for part, words in _PARTS.items():
        columns[f"{words}, µs"] = lambda race, part=part: number(max(widest(race)[part]["microseconds"], 0.01))
        columns[f"{words}: refused"] = lambda race, part=part: percent(
            widest(race)[part]["refused"], widest(race)["free"]
        )
    note = "Medians over trials that came to the part. Shares of all trials without a clash, at 300 K."
    return tabulate("Parts of that work", races, columns, 3, note)


def _makeTrials(races):
    columns = {key: cellOf for key, cellOf in _LABELS.items() if key in ("protein", "N")}
    columns["ours"] = lambda race: timeRange(race[OURS])
    columns["OpenMM for each free trial"] = lambda race: timeOf(race[FOREIGN])
    columns["two energies a trial"] = lambda race: timeOf(race[TWO_ENERGIES])
    columns["OpenMM / ours"] = lambda race: ratioOf(race[FOREIGN], race[OURS])
    columns["two / ours"] = lambda race: ratioOf(race[TWO_ENERGIES], race[OURS])
    note = (
        "Reaction field 1.0 nm, by Simulation.step, with the moves of examples/sample_protein.py. OpenMM for each "
        "free trial: setNativeEnergies(False). Two energies a trial: all torsions by up to 1°, without hard spheres. "
        "CPU platform, one thread."
    )
    return tabulate("Whole trials, µs", races, columns, 1, note)


def makeStages(races):
    """Return the table of what each stage decides in whole trials."""
    ours = [race[OURS] for race in races]
    stages = dict.fromkeys(
        stage for entry in ours for stage, counts in entry["stages"].items() if counts["computed"] > 0
    )
    columns = {
        "protein": lambda entry: entry["chain"],
        "clash": lambda entry: percent(entry["clashed"], entry["attempted"]),
    }
    for stage in stages:
        columns[f"{stage}: asked"] = lambda entry, stage=stage: percent(
            entry["stages"][stage]["computed"], entry["attempted"]
        )
        columns[f"{stage}: refused"] = lambda entry, stage=stage: percent(
            entry["stages"][stage]["refused"], entry["stages"][stage]["computed"]
        )
    columns["accepted"] = lambda entry: percent(entry["accepted"], entry["attempted"])
    note = "Asked: share of all trials; refused: share of the trials asked about."
    return tabulate("What each stage decides", ours, columns, 1, note)


def _makeErrors(races):
    columns = {**_LABELS, "U, kJ/mol": lambda race: f"{widest(race)['energy']:,.0f}"}
    for name, entryOf in (("ours", widest), ("OpenMM CPU", lambda race: race.get(ONE_ENERGY))):
        for words, errorOf in (
            ("U", lambda entry: entry["energyError"]),
            ("ΔU, RMS", lambda entry: entry["changeError"]["rms"]),
            ("ΔU, largest", lambda entry: entry["changeError"]["largest"]),
        ):
            columns[f"{name}: {words}"] = lambda race, entryOf=entryOf, errorOf=errorOf: (
                "–" if entryOf(race) is None else f"{errorOf(entryOf(race)):.1e}"
            )
    note = "Differences from OpenMM's Reference platform in kJ/mol, over the first trials of each run."
    return tabulate("Errors", races, columns, 3, note)
