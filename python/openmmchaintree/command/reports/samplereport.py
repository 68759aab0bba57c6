"""The results of a sampling run, as tables for people and as JSON for programs."""

from collections import Counter

from ...naming import nameAtom
from ...torsions import KINDS
from ..energymodel import HARD
from .energyreport import printEnergies
from .noteoutput import asPlain, printNotes
from .planreport import describePlan
from .tables import makeTable, percent

# Outcomes of trials: keys of JSON, and headings of the table. Each trial has one outcome.
_FATES = {"notMade": "not made", "clashed": "clashed", "rejectedByEnergy": "rejected", "accepted": "accepted"}

# Longer lists of tolerated pairs or changed bonds appear only in the JSON file.
_LONGEST_LIST = 10


def summarize(sampling, seed, files, interrupted, addedHydrogens, forbidden):
    """Return all results of a run as plain dictionaries and lists, for JSON.

    Lengths are in nm, times in s, energies in kJ/mol. forbidden : the result of `measureForbidden`
    """
    return {
        **describeScene(sampling, addedHydrogens),
        "seed": seed,
        "interrupted": interrupted,
        "trials": sampling.trials,
        "frames": len(sampling.frames),
        "secondsInSteps": sampling.seconds,
        "microsecondsPerTrial": 1e6 * sampling.seconds / sampling.trials if sampling.trials else None,
        "trialsPerSecond": sampling.trials / sampling.seconds if sampling.trials else None,
        "moves": [
            describeMove(move, statistics)
            for move, statistics in zip(sampling.moves, sampling.statistics(), strict=True)
        ],
        "energy": sampling.summarizeEnergies(),
        "radiusOfGyration": [frame.radiusOfGyration for frame in sampling.frames],
        "stericMode": sampling.stericMode,
        "forbiddenBySpheres": forbidden,
        "clashesAtStart": len(sampling.startOverlaps.pairs),
        **describeVerdict(sampling),
        "files": files,
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


def describeMove(move, statistics):
    """Return a NamedMove and its MoveStatistics as a dictionary, with the number of impossible trials."""
    attempted, *decided = statistics
    counts = {"attempted": attempted, "notMade": attempted - sum(decided), **statistics._asdict()}
    return {"name": move.name, "weight": move.weight, **counts}


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
    if summary["interrupted"]:
        console.print("interrupted: the files hold the frames before the interrupt")
    if summary["energy"] is not None:
        printEnergies(summary["energy"], console)
    _printVerdict(summary, console)
    count = summary["frames"]
    frames = f"{count:,} frames, the first of them the start" if count > 1 else "a single frame, the start"
    console.print(f"wrote {', '.join(summary['files'])}; {frames}")


def printScene(summary, console, isVerbose):
    """Print the description of the structure, and the notes."""
    kinds = ", ".join(f"{count:,} {kind}" for kind, count in summary["torsions"].items())
    fixed = f", {summary['fixedAtoms']:,} of them fixed" if summary["fixedAtoms"] else ""
    added = f", {summary['addedHydrogens']:,} of them added hydrogens" if summary["addedHydrogens"] else ""
    console.print(
        f"{summary['structure']}: {summary['atoms']:,} atoms{added}{fixed}; "
        f"{sum(summary['torsions'].values()):,} torsions ({kinds}); seed {summary['seed']}"
    )
    printNotes(summary["notes"], console, isVerbose)


def printMoves(moves, console):
    """Print a table of the outcomes of the trials of each move."""
    console.print(_moveTable(moves))
    if any(move["notMade"] for move in moves):
        console.print("not made: impossible, since a window did not close, in the trial itself or in the reverse trial")


def _printTrials(summary, console):
    printMoves(summary["moves"], console)
    if summary["trials"]:
        console.print(
            f"{summary['trials']:,} trials in {summary['secondsInSteps']:.3f} s: "
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
            f"{summary['clashesAtEnd']} overlap by more than hard spheres may ({summary['clashesAtStart']} at the "
            "start), which trials ignore"
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
        console.print("tolerated are pairs that clashed at the start: they may stay so, but never overlap by more")
    if len(tolerated) <= _LONGEST_LIST:
        for pair in tolerated:
            _printPair("tolerated", pair, f"tolerance {pair['tolerance']:.9f} nm", console)


def _printPair(word, pair, bound, console):
    console.print(f"  {word}: {pair['atoms'][0]} – {pair['atoms'][1]}, overlap {pair['overlap']:.9f} nm, {bound}")
