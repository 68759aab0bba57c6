"""The results of a sampling run, as tables for people and as JSON for programs."""

from collections import Counter

from ...naming import nameAtom
from ...notes import countOf
from ...openmmchaintree import MoveStatistics
from ...torsions import KINDS
from ..energymodel import HARD
from .convergencereport import printEstimates
from .energyreport import printEnergies, summarizeEnergies
from .noteoutput import asPlain, printNotes
from .planreport import describePlan
from .tables import makeTable, percent

# Outcomes of trials: keys of JSON, and headings of the table. Each trial has one outcome.
_FATES = {"notMade": "not made", "clashed": "clashed", "rejectedByEnergy": "rejected", "accepted": "accepted"}

# Longer lists of tolerated pairs or changed bonds appear only in the JSON file.
_LONGEST_LIST = 10


def summarize(sampling, plan, state, index, *, seed, interrupted, endedBy, addedHydrogens):
    """Return all results of a single run as plain dictionaries and lists, for JSON.

    Lengths are in nm, times in s, energies in kJ/mol. The Sampling's Context has the last state.

    Parameters
    ----------
    sampling : Sampling
    plan : RunPlan
        of one replica
    state : RunState
        at the end
    index : dict of arrays
        from `readIndex`
    """
    trials, seconds = plan.schedule.trialsBefore(state.round), state.secondsInSteps
    energy = None
    if sampling.energies is not None:
        along = index["potentialEnergy"].tolist()
        # Loading a checkpoint recomputes energies in single precision, which changes their last digits.
        last = along[-1] if index["trials"][-1] == trials else sampling.energies.held()
        energy = summarizeEnergies(sampling.energies, along, last, state.stages, sampling.positions())
    return {
        **describeScene(sampling, addedHydrogens),
        "seed": seed,
        "interrupted": interrupted,
        "endedBy": endedBy,
        "trials": trials,
        "frames": len(index["frame"]),
        "trialsPerRound": plan.schedule.trialsPerRound,
        "secondsInSteps": seconds,
        "wallSeconds": state.wallSeconds,
        "microsecondsPerTrial": 1e6 * seconds / trials if trials else None,
        "trialsPerSecond": trials / seconds if trials else None,
        "moves": describeMoves(sampling, state.counts[0]),
        "energy": energy,
        "radiusOfGyration": index["radiusOfGyration"].tolist(),
        "stericMode": sampling.stericMode,
        "clashesAtStart": len(sampling.startOverlaps.pairs),
        **describeVerdict(sampling),
    }


def describeScene(sampling, addedHydrogens):
    """Return a description of the structure and its moving parts as plain dictionaries and lists."""
    kinds = Counter(torsion.kind for torsion in sampling.torsions)
    return {
        "structure": sampling.structure.name,
        "atoms": sampling.structure.topology.getNumAtoms(),
        "addedHydrogens": addedHydrogens,
        "fixedAtoms": sampling.fixedAtoms,
        "torsions": {kind: kinds[kind] for kind in KINDS if kinds[kind]},
        "plan": describePlan(sampling.plan),
        "cutDisulfides": sampling.plan.cutDisulfides,
        "cutMetals": sampling.plan.cutMetals,
        "closed": sampling.plan.closed,
        "notes": asPlain(sampling.notes),
    }


def describeVerdict(sampling):
    """Compare all pairs and bonds at the Context's positions with the start; return the results."""
    names = [str(nameAtom(atom)) for atom in sampling.structure.topology.atoms()]
    if sampling.isFlexible:
        return {**_describeOverlaps(sampling, names), "largestBondChange": None, "changedBonds": []}
    bonds = sampling.checkBonds(sampling.positions())
    return {
        **_describeOverlaps(sampling, names),
        "largestBondChange": bonds.largestChange,
        "changedBonds": [
            {"particles": [first, second], "atoms": [names[first], names[second]], "change": float(change)}
            for (first, second), change in zip(bonds.changed.tolist(), bonds.changes, strict=True)
        ],
    }


def _describeOverlaps(sampling, names):
    """Return the pairs that overlap at the end; without hard spheres there are no limits, and only the count."""
    if not sampling.isHard:
        count = len(sampling.overlaps(sampling.positions()).pairs)
        return {"clashesAtEnd": count, "toleratedPairs": [], "pairsBeyondLimit": []}
    verdict = sampling.check(sampling.positions())
    return {
        "clashesAtEnd": len(verdict.tolerated.pairs) + len(verdict.beyond.pairs),
        "toleratedPairs": _describePairs(verdict.tolerated, names),
        "pairsBeyondLimit": _describePairs(verdict.beyond, names, verdict.beyondLimits),
    }


def describeMoves(sampling, counts):
    """Return a dictionary for each move of a Sampling, from outcomes as in MoveStatistics: (moves, 4).

    It also has the number of trials that were impossible.
    """
    return [_describeMove(move, *row) for move, row in zip(sampling.moves, counts.tolist(), strict=True)]


def _describeMove(move, attempted, *decided):
    counts = MoveStatistics(attempted, *decided)._asdict()
    return {"name": move.name, "weight": move.weight, "notMade": attempted - sum(decided), **counts}


def _describePairs(overlaps, names, limits=None):
    pairs = []
    for number, (first, second) in enumerate(overlaps.pairs.tolist()):
        pair = {
            "particles": [first, second],
            "atoms": [names[first], names[second]],
            "overlap": float(overlaps.overlaps[number]),
            "tolerance": float(overlaps.tolerances[number]),
        }
        if limits is not None:
            pair["limit"] = float(limits[number])
        pairs.append(pair)
    return pairs


def printReport(summary, console, isVerbose):
    """Print a summary on a rich Console; all notes if verbose."""
    printScene(summary, console, isVerbose)
    _printTrials(summary, console)
    printEnding(summary, console)
    if summary["energy"] is not None:
        printEnergies(summary["energy"], console)
    if summary["frames"] > 1:
        printEstimates(summary["estimates"][0], console)
    _printVerdict(summary, console)
    count = summary["frames"]
    frames = f"{count:,} frames, the first of them the start" if count > 1 else "a single frame, the start"
    console.print(f"wrote {', '.join(summary['files'])}; {frames}")


def printScene(summary, console, isVerbose):
    """Print the description of the structure, and the notes."""
    kinds = ", ".join(f"{count:,} {kind}" for kind, count in summary["torsions"].items())
    fixed = f", {summary['fixedAtoms']:,} of them fixed" if summary["fixedAtoms"] else ""
    added = f", {summary['addedHydrogens']:,} of them added hydrogens" if summary["addedHydrogens"] else ""
    if summary["addedHydrogens"] == 1:
        added = ", one of them an added hydrogen"
    console.print(
        f"{summary['structure']}: {countOf(summary['atoms'], 'atom')}{added}{fixed}; "
        f"{countOf(sum(summary['torsions'].values()), 'torsion')} ({kinds}); seed {summary['seed']}"
    )
    printNotes(summary["notes"], console, isVerbose)


def printEnding(summary, console):
    """Print why a run ended before its last trial."""
    if summary["interrupted"]:
        console.print("interrupted: the files hold the frames before the interrupt, and --resume continues")
    elif summary["endedBy"] is not None:
        console.print(f"ended by {summary['endedBy']}; --resume continues")


def printMoves(moves, console):
    """Print a table of the outcomes of the trials of each move."""
    console.print(_moveTable(moves))
    if any(move["notMade"] for move in moves):
        console.print("not made: impossible, since a window did not close, in the trial itself or in the reverse trial")


def _printTrials(summary, console):
    printMoves(summary["moves"], console)
    if summary["trials"]:
        console.print(
            f"{countOf(summary['trials'], 'trial')} in {summary['secondsInSteps']:.3f} s: "
            f"{summary['microsecondsPerTrial']:.2f} µs a trial, {summary['trialsPerSecond']:,.0f} trials a second"
        )


def _moveTable(moves):
    """Make a table of the outcomes of each move's trials, with a column for impossible trials if there are any."""
    fates = [fate for fate in _FATES if fate != "notMade" or any(move["notMade"] for move in moves)]
    table = makeTable(["move"], ["attempted", *(_FATES[fate] for fate in fates), "%"])
    rows = [(move["name"], *(move[key] for key in ("attempted", *fates))) for move in moves]
    if len(rows) > 1:
        rows.append(("all", *(sum(column) for column in list(zip(*rows, strict=True))[1:])))
    for name, attempted, *counts in rows:
        table.add_row(name, f"{attempted:,}", *(f"{count:,}" for count in counts), percent(counts[-1], attempted))
    return table


def describeBondChange(change):
    """Return the end of a sentence on the largest change of a bond's length in nm; None: they are flexible."""
    return "" if change is None else f"; largest change of a bond's length: {change:.1g} nm"


def _printVerdict(summary, console):
    tolerated, beyond, bonds = summary["toleratedPairs"], summary["pairsBeyondLimit"], summary["changedBonds"]
    if summary["stericMode"] == HARD:
        count = f"{len(beyond)} beyond their limit" if beyond else "none beyond its limit"
        overlaps = f"{count}, {len(tolerated)} tolerated ({summary['clashesAtStart']} clashed at the start)"
    else:
        overlaps = (
            f"{_overlapping(summary['clashesAtEnd'])} by more than hard spheres may ({summary['clashesAtStart']} at "
            "the start), which trials ignore"
        )
    console.print(f"last positions, all pairs compared: {overlaps}{describeBondChange(summary['largestBondChange'])}")
    if summary["forbiddenBySpheres"] is not None:
        console.print(f"hard spheres: {summary['forbiddenBySpheres']['text']}")
    for pair in beyond:
        _printPair("beyond its limit", pair, f"limit {pair['limit']:.9f} nm", console)
    for bond in bonds[:_LONGEST_LIST]:
        console.print(f"  bond changed: {bond['atoms'][0]} – {bond['atoms'][1]}, by {bond['change']:.3g} nm")
    if len(bonds) > _LONGEST_LIST:
        console.print(f"  and {len(bonds) - _LONGEST_LIST:,} more bonds")
    if tolerated:
        console.print("tolerated pairs clashed at the start: they may still overlap, but never by more")
    if len(tolerated) <= _LONGEST_LIST:
        for pair in tolerated:
            _printPair("tolerated", pair, f"tolerance {pair['tolerance']:.9f} nm", console)


def _overlapping(count):
    return f"{count} overlap{'s' if count == 1 else ''}"


def _printPair(word, pair, bound, console):
    console.print(f"  {word}: {pair['atoms'][0]} – {pair['atoms'][1]}, overlap {pair['overlap']:.9f} nm, {bound}")
