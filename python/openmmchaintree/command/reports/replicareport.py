"""The results of a run of replicas, as tables for people and as JSON for programs."""

import numpy as np

from ...notes import countOf
from ..energymodel import HARD
from .convergencereport import printEstimates
from .samplereport import (
    describeBondChange,
    describeMoves,
    describeScene,
    describeVerdict,
    printEnding,
    printMoves,
    printScene,
)
from .tables import makeTable, percent


def summarizeReplicas(sampling, plan, state, index, *, seed, workers, interrupted, endedBy, addedHydrogens):
    """Return all results of a run of replicas as plain dictionaries and lists, for JSON.

    Lengths are in nm, times in s, energies in kJ/mol, temperatures in K. The Sampling's Context loads the last state of
    each replica to check it.

    Parameters
    ----------
    sampling : Sampling
    plan : RunPlan
    state : RunState
        at the end
    index : dict of arrays
        from `readIndex`
    """
    trials = plan.schedule.trialsBefore(state.round)
    allTrials = trials * len(plan.seeds)
    counts = state.counts.sum(axis=0)
    return {
        **describeScene(sampling, addedHydrogens),
        "seed": seed,
        "interrupted": interrupted,
        "endedBy": endedBy,
        "replicas": len(plan.seeds),
        "workers": workers,
        "trials": trials,
        "frames": 1 + plan.schedule.framesBefore(state.round),
        "trialsPerRound": plan.schedule.trialsPerRound,
        "secondsInSteps": state.secondsInSteps,
        "secondsInSegments": state.seconds,
        "wallSeconds": state.wallSeconds,
        "microsecondsPerTrial": 1e6 * state.secondsInSteps / allTrials if allTrials else None,
        "trialsPerSecond": allTrials / state.wallSeconds if allTrials else None,
        "busy": state.seconds / (workers * state.wallSeconds) if allTrials else None,
        "moves": describeMoves(sampling, counts),
        "temperatures": [_describeTemperature(sampling, plan, state, index, k) for k in range(len(plan.temperatures))],
        "exchanges": [
            {
                "temperatures": plan.temperatures[lower : lower + 2],
                "attempted": int(state.attempted[lower]),
                "accepted": int(state.accepted[lower]),
            }
            for lower in range(len(state.attempted))
        ],
        "roundTrips": state.roundTrips if plan.isExchange else None,
        "stericMode": sampling.stericMode,
        "clashesAtStart": len(sampling.startOverlaps.pairs),
        "ends": [_describeEnd(sampling, plan, state, replica) for replica in range(len(plan.seeds))],
    }


def _describeTemperature(sampling, plan, state, index, number):
    temperature = plan.temperatures[number]
    attempted, accepted, takenBack = state.outerTests[number].tolist()
    rows = index["frame"] > 0
    if plan.isExchange:
        rows &= index["temperature"] == temperature
    description = {
        "temperature": temperature if sampling.energies is not None else None,
        "frames": int(rows.sum()),
        "moves": describeMoves(sampling, state.counts[number]),
        "outerTests": {"attempted": attempted, "accepted": accepted, "trialsTakenBack": takenBack},
        "radiusOfGyration": _describeValues(index["radiusOfGyration"][rows]),
    }
    if sampling.energies is not None:
        description["potentialEnergy"] = _describeValues(index["potentialEnergy"][rows])
    return description


def _describeValues(values):
    if len(values) == 0:
        return {"mean": None, "standardDeviation": None}
    return {"mean": float(np.mean(values)), "standardDeviation": float(np.std(values))}


def _describeEnd(sampling, plan, state, replica):
    """Return the last state of a replica, and the checks of all its pairs and bonds."""
    checkpoint = state.checkpoints[replica]
    sampling.takeUp(checkpoint)
    end = {
        "replica": replica,
        "seed": plan.seeds[replica],
        "temperature": plan.temperatures[state.temperatureOf[replica]] if sampling.energies is not None else None,
        "accepted": int(state.countsOfReplica[replica, :, 3].sum()),
        **describeVerdict(sampling),
    }
    if sampling.energies is not None:
        end["potentialEnergy"] = sampling.energies.held()
        end["potentialEnergyByOpenMM"] = sampling.energyByOpenMM()
    return end


def isBeyond(summary):
    """Whether a replica ended with pairs beyond their limit, or with changed bonds."""
    return any(end["pairsBeyondLimit"] or end["changedBonds"] for end in summary["ends"])


def printReplicaReport(summary, console, isVerbose):
    """Print the result of `summarizeReplicas` on a rich Console; all notes if verbose."""
    printScene(summary, console, isVerbose)
    printMoves(summary["moves"], console)
    if summary["trials"]:
        console.print(
            f"{countOf(summary['replicas'], 'replica')}, {countOf(summary['trials'], 'trial')} of each, by "
            f"{countOf(summary['workers'], 'worker')} in "
            f"{summary['wallSeconds']:.1f} s: {summary['microsecondsPerTrial']:.2f} µs a trial on one core, "
            f"{summary['trialsPerSecond']:,.0f} trials a second in all; workers were busy "
            f"{100 * summary['busy']:.0f} % of the time"
        )
    printEnding(summary, console)
    if any("potentialEnergy" in temperature for temperature in summary["temperatures"]):
        console.print(_temperatureTable(summary))
    if summary["roundTrips"] is not None:
        trips = countOf(sum(summary["roundTrips"]), "round trip")
        console.print(f"{trips} between the lowest temperature and the highest")
    if summary["frames"] > 1:
        printEstimates(summary["estimates"][0], console, summary.get("atLowestTemperature"))
    _printEnds(summary, console)
    number = summary["frames"]
    frames = f"{number:,} frames each, the first of them the start" if number > 1 else "a single frame each, the start"
    console.print(f"wrote {', '.join(summary['files'])}; {frames}")


def _temperatureTable(summary):
    """Make a table with a row for each temperature."""
    hasOuterTests = any(temperature["outerTests"]["attempted"] for temperature in summary["temperatures"])
    headings = ["U (kJ/mol)", "±", "nm", "sample size", "accepted %"]
    headings += ["outer tests kept %"] if hasOuterTests else []
    table = makeTable(["K"], [*headings, *(["exchanged with the next %"] if summary["exchanges"] else [])])
    for number, temperature in enumerate(summary["temperatures"]):
        energy, radius, outer = (temperature[key] for key in ("potentialEnergy", "radiusOfGyration", "outerTests"))
        attempted, accepted = (sum(move[key] for move in temperature["moves"]) for key in ("attempted", "accepted"))
        cells = [
            f"{temperature['temperature']:.1f}",
            _format(energy["mean"], ",.1f"),
            _format(energy["standardDeviation"], ",.1f"),
            _format(radius["mean"], ".3f"),
            _format(summary["estimates"][number]["leastSampleSize"], ",.0f"),
            percent(accepted, attempted),
        ]
        if hasOuterTests:
            cells.append(percent(outer["accepted"], outer["attempted"]))
        if number < len(summary["exchanges"]):
            exchange = summary["exchanges"][number]
            cells.append(percent(exchange["accepted"], exchange["attempted"]))
        table.add_row(*cells)
    return table


def _format(value, form):
    return "–" if value is None else f"{value:{form}}"


def _printEnds(summary, console):
    ends = summary["ends"]
    beyond = sum(len(end["pairsBeyondLimit"]) for end in ends)
    if summary["stericMode"] == HARD:
        clashes = f"{beyond} beyond their limit" if beyond else "none beyond its limit"
    else:
        clashes = f"{max(end['clashesAtEnd'] for end in ends)} at most overlap by more than hard spheres may"
    changes = [end["largestBondChange"] for end in ends]
    console.print(
        f"last positions of all replicas, all pairs compared: {clashes} "
        f"({summary['clashesAtStart']} clashed at the start)"
        f"{describeBondChange(None if None in changes else max(changes))}"
    )
    for end in ends:
        for pair in end["pairsBeyondLimit"]:
            names = " – ".join(pair["atoms"])
            console.print(f"  beyond its limit: replica {end['replica']}, {names}, overlap {pair['overlap']:.9f} nm")
        for bond in end["changedBonds"][:1]:
            console.print(
                f"  bonds changed: replica {end['replica']}, {len(end['changedBonds']):,}, such as "
                f"{' – '.join(bond['atoms'])}, by {bond['change']:.3g} nm"
            )
    if "potentialEnergy" in ends[0]:
        difference = max(abs(end["potentialEnergy"] - end["potentialEnergyByOpenMM"]) for end in ends)
        console.print(f"U of last positions: OpenMM's Reference platform differs by {difference:.1g} kJ/mol at most")
