"""The results of a clash search, as tables for people and as CSV and JSON for programs."""

import csv
import io

import numpy as np
from openmm import unit

from ...clashes import eachClash
from ..terminal import printable
from .clashranking import ClashRanking
from .noteoutput import asPlain, printNotes
from .tables import makeTable

# Number of residues named per frame.
_WORST_OF_A_FRAME = 5


def summarize(search, frames, ranking, damage, interrupted):
    """Return the results of a ClashSearch without its frames as plain dictionaries and lists, in nm.

    Parameters
    ----------
    search : ClashSearch
    frames : list of FrameOverlaps, at least one
    ranking : ClashRanking that has counted them
    damage : InputError or None
        the reason why frames are missing
    interrupted : bool
        whether the user interrupted the search
    """
    return {
        "structure": str(search.structure),
        "trajectory": None if search.trajectory is None else str(search.trajectory),
        "atoms": len(search.finder.names),
        "atomsLookedAt": search.finder.checkedCount,
        "radii": search.finder.radii,
        "overlapTolerance": search.finder.force.getOverlapTolerance().value_in_unit(unit.nanometer),
        "hydrogenBondAllowance": search.finder.force.getHydrogenBondAllowance().value_in_unit(unit.nanometer),
        "notes": asPlain(search.notes),
        "damage": None if damage is None else str(damage),
        "interrupted": interrupted,
        "spaceGroup": None if search.crystal is None else search.crystal.spaceGroup,
        "clashesPerFrame": sum(len(frame.pairs) for frame in frames) / len(frames),
        "clashesPer1000Atoms": sum(frame.clashesPer1000Atoms for frame in frames) / len(frames),
        "residues": ranking.rankResidues(),
        "pairs": ranking.rankPairs(),
    }


def plainFrames(search, frames):
    """Yield each of the FrameOverlaps of a ClashSearch, with all clashes, as plain dictionaries and lists."""
    names = [name._asdict() for name in search.finder.names]
    ranking = ClashRanking(search.finder.names)
    for frame in frames:
        ranking.clear()
        ranking.add(frame)
        yield {
            "index": frame.number,
            "clashesPer1000Atoms": frame.clashesPer1000Atoms,
            "worstResidues": [entry["residue"] for entry in ranking.rankResidues()[:_WORST_OF_A_FRAME]],
            "clashes": [_describeClash(*clash, names) for clash in _clashesOf(frame)],
        }


def _clashesOf(frame):
    """Return the pair, the overlap and the operator of each clash of a FrameOverlaps."""
    return eachClash(frame.pairs, frame.overlaps, frame.operators)


def _describeClash(pair, overlap, operator, names):
    first, second = pair
    return {
        "particle1": first,
        "particle2": second,
        "atom1": names[first],
        "atom2": names[second],
        "overlap": overlap,
        **({"operator": operator} if operator else {}),
    }


def asCSV(search, frames):
    """Yield CSV of the FrameOverlaps of a ClashSearch, in pieces: a heading, and a line for every clash.

    The last column are the operators, if copies in a crystal count.
    """
    names = [[printable(part) for part in name] for name in search.finder.names]
    atoms = [f"{word}{number}" for number in (1, 2) for word in ("particle", "chain", "residue", "atom")]
    last = [] if search.crystal is None else ["operator"]
    yield _asLines([["frame", *atoms, "overlap_nm", *last]])
    for frame in frames:
        yield _asLines(
            [frame.number, first, *names[first], second, *names[second], f"{overlap:.6f}", *[operator for _ in last]]
            for (first, second), overlap, operator in _clashesOf(frame)
        )


def _asLines(rows):
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def printReport(summary, search, frames, files, rows, console, isVerbose):
    """Print a summary of FrameOverlaps on a rich Console, with tables of up to `rows` rows; all notes if verbose."""
    tolerance = summary["overlapTolerance"]
    console.print(
        f"{summary['trajectory'] or summary['structure']}: {summary['atomsLookedAt']:,} of {summary['atoms']:,} atoms "
        f"looked at, {summary['radii']} radii; a clash is an overlap above {tolerance:g} nm, "
        f"{tolerance + summary['hydrogenBondAllowance']:g} nm where a hydrogen bond is possible"
    )
    if search.crystal is not None:
        console.print(f"copies in the crystal count ({search.crystal.spaceGroup}): their operators are in brackets")
    printNotes(summary["notes"], console, isVerbose)
    if len(frames) == 1:
        _printFrame(summary, search, frames[0], rows, console)
    else:
        _printFrames(summary, search, frames, rows, console)
    if summary["interrupted"]:
        console.print("interrupted: these are the clashes of the frames before")
    if files:
        console.print(f"wrote {', '.join(map(str, files))}")


def _printFrame(summary, search, frame, rows, console):
    names = search.finder.names
    clashes = sorted(_clashesOf(frame), key=lambda clash: clash[1], reverse=True)
    console.print(f"{countClashes(len(clashes))}, {frame.clashesPer1000Atoms:.1f} per 1,000 atoms")

    def describeClash(clash):
        (first, second), overlap, operator = clash
        return f"{overlap:.4f}", *_nameAtoms(names, first, second, operator)

    def describeResidue(entry):
        return entry["clashes"], f"{entry['worstOverlap']:.4f}", entry["residue"]

    _printTable("worst clashes", ["overlap (nm)"], ["between", "and"], clashes, describeClash, rows, console)
    headings = ["clashes", "worst overlap (nm)"], ["residue"]
    _printTable("residues with most clashes", *headings, summary["residues"], describeResidue, rows, console)


def _printFrames(summary, search, frames, rows, console):
    frames = sorted(frames, key=lambda frame: len(frame.pairs), reverse=True)
    count, names = len(frames), search.finder.names
    word = "model" if summary["trajectory"] is None else "frame"
    console.print(
        f"{count:,} {word}s: {countClashes(summary['clashesPerFrame'], '.1f')} a {word} "
        f"({len(frames[-1].pairs):,} to {len(frames[0].pairs):,}), "
        f"{summary['clashesPer1000Atoms']:.1f} per 1,000 atoms"
    )

    def describeFrame(frame):
        worst = np.argmax(frame.overlaps)
        counts = frame.number, len(frame.pairs), f"{frame.clashesPer1000Atoms:.1f}"
        operator = "" if frame.operators is None else frame.operators[worst]
        return *counts, f"{frame.overlaps[worst]:.4f}", *_nameAtoms(names, *frame.pairs[worst], operator)

    def describeShare(entry):
        return f"{100 * entry['frames'] / count:.0f}", f"{entry['worstOverlap']:.4f}", entry["worstFrame"]

    def describePair(entry):
        return *describeShare(entry), *entry["atoms"]

    def describeResidue(entry):
        return f"{entry['clashes'] / count:.2f}", *describeShare(entry), entry["residue"]

    clashing = [frame for frame in frames if len(frame.pairs) > 0]
    headings = [word, "clashes", "per 1,000 atoms", "worst (nm)"], ["between", "and"]
    _printTable(f"{word}s with most clashes", *headings, clashing, describeFrame, rows, console)
    shares = [f"% of {word}s", "worst (nm)", f"in {word}"]
    headings = shares, ["between", "and"]
    _printTable("most frequent clashes", *headings, summary["pairs"], describePair, rows, console)
    headings = [f"a {word}", *shares], ["residue"]
    _printTable("residues with most clashes", *headings, summary["residues"], describeResidue, rows, console)


def _nameAtoms(names, first, second, operator):
    """Return two atoms in words, the second one with the operator of its copy."""
    return str(names[first]), f"{names[second]} ({operator})" if operator else str(names[second])


def countClashes(count, form=","):
    """Return a number of clashes in words."""
    return f"{count:{form}} {'clash' if count == 1 else 'clashes'}"


def _printTable(heading, numbers, words, entries, describe, rows, console):
    """Print a table of the first `rows` entries, whose cells the function `describe` returns; none without entries.

    numbers, words : the headings of its columns
    """
    if not entries:
        return
    table = makeTable([], numbers, words)
    for entry in entries[:rows]:
        table.add_row(*(f"{cell:,}" if isinstance(cell, int) else cell for cell in describe(entry)))
    left = len(entries) - rows
    console.print()
    console.print(f"{heading}{f' ({left:,} more not shown)' if left > 0 else ''}:")
    console.print(table)
