"""What a search for clashes found, as tables for people and as CSV and JSON for programs."""

import csv
import io
from collections import defaultdict

from openmm import unit
from rich.table import Table

from ..naming import AtomName
from .noteoutput import asPlain, printNotes

# So many residues are named for each frame.
_WORST_OF_A_FRAME = 5


def summarize(search, frames, damage, interrupted):
    """Return everything that a ClashSearch found as plain dictionaries and lists, for JSON. Lengths are in nm.

    Parameters
    ----------
    search : ClashSearch
    frames : list of FrameClashes, at least one
    damage : InputError or None
        why there are not more frames
    interrupted : bool
        whether the user did not wait for more of them
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
        "clashesPerFrame": sum(len(frame.clashes) for frame in frames) / len(frames),
        "clashesPer1000Atoms": sum(frame.clashesPer1000Atoms for frame in frames) / len(frames),
        "residues": _rankResidues(frames),
        "pairs": _rankPairs(frames),
        "frames": [_describeFrame(frame) for frame in frames],
    }


def _describeFrame(frame):
    return {
        "index": frame.number,
        "clashesPer1000Atoms": frame.clashesPer1000Atoms,
        "worstResidues": [entry["residue"] for entry in _rankResidues([frame])[:_WORST_OF_A_FRAME]],
        "clashes": [
            {**clash._asdict(), "atom1": clash.atom1._asdict(), "atom2": clash.atom2._asdict()}
            for clash in frame.clashes
        ],
    }


def _rankResidues(frames):
    """Return the residues that clash, those with most clashes first."""
    met = defaultdict(list)
    for frame in frames:
        for clash in frame.clashes:
            for residue in dict.fromkeys((clash.atom1.describeResidue(), clash.atom2.describeResidue())):
                met[residue].append((frame.number, clash.overlap))
    return _rank({"residue": residue, **_count(found)} for residue, found in met.items())


def _rankPairs(frames):
    """Return the pairs of atoms that clash, those that do so in most frames first."""
    met = defaultdict(list)
    for frame in frames:
        for clash in frame.clashes:
            met[clash[:4]].append((frame.number, clash.overlap))
    return _rank(
        {"particles": pair[:2], "atoms": [str(name) for name in pair[2:]], **_count(found)}
        for pair, found in met.items()
    )


def _count(found):
    """Return what is told of the (frame, overlap) of some clashes."""
    overlap, frame = max((overlap, -frame) for frame, overlap in found)
    frames = {frame for frame, _ in found}
    return {"clashes": len(found), "frames": len(frames), "worstOverlap": overlap, "worstFrame": -frame}


def _rank(entries):
    return sorted(entries, key=lambda entry: (-entry["clashes"], -entry["worstOverlap"]))


def asCSV(frames):
    """Return CSV: a heading, and a line for every clash."""
    text = io.StringIO()
    lines = csv.writer(text, lineterminator="\n")
    atoms = [f"{word}{number}" for number in (1, 2) for word in ("particle", "chain", "residue", "atom")]
    lines.writerow(["frame", *atoms, "overlap_nm"])
    for frame in frames:
        for clash in frame.clashes:
            atoms = [clash.particle1, *clash.atom1, clash.particle2, *clash.atom2]
            lines.writerow([frame.number, *atoms, f"{clash.overlap:.6f}"])
    return text.getvalue()


def printReport(summary, files, rows, console, isVerbose):
    """Print a summary on a rich Console, with tables of up to a number of rows; all notes, if that is to be verbose."""
    tolerance = summary["overlapTolerance"]
    console.print(
        f"{summary['trajectory'] or summary['structure']}: {summary['atomsLookedAt']:,} of {summary['atoms']:,} atoms "
        f"looked at, {summary['radii']} radii; a clash is an overlap above {tolerance:g} nm, "
        f"{tolerance + summary['hydrogenBondAllowance']:g} nm where a hydrogen bond may be"
    )
    printNotes(summary["notes"], console, isVerbose)
    if len(summary["frames"]) == 1:
        _printFrame(summary, rows, console)
    else:
        _printFrames(summary, rows, console)
    if summary["interrupted"]:
        console.print("interrupted: this is what was found so far")
    if files:
        console.print(f"wrote {', '.join(map(str, files))}")


def _printFrame(summary, rows, console):
    (frame,) = summary["frames"]
    clashes = sorted(frame["clashes"], key=_overlapOf, reverse=True)
    console.print(f"{_countClashes(len(clashes))}, {frame['clashesPer1000Atoms']:.1f} per 1,000 atoms")
    table = _Table("worst clashes", ["overlap (nm)"], ["between", "and"])
    for clash in clashes:
        table.add(f"{clash['overlap']:.4f}", _name(clash["atom1"]), _name(clash["atom2"]))
    table.print(rows, console)
    table = _Table("residues with most clashes", ["clashes", "worst overlap (nm)"], ["residue"])
    for entry in summary["residues"]:
        table.add(entry["clashes"], f"{entry['worstOverlap']:.4f}", entry["residue"])
    table.print(rows, console)


def _printFrames(summary, rows, console):
    frames = sorted(summary["frames"], key=lambda frame: len(frame["clashes"]), reverse=True)
    count = len(frames)
    word = "model" if summary["trajectory"] is None else "frame"
    console.print(
        f"{count:,} {word}s: {_countClashes(summary['clashesPerFrame'], '.1f')} a {word} "
        f"({len(frames[-1]['clashes']):,} to {len(frames[0]['clashes']):,}), "
        f"{summary['clashesPer1000Atoms']:.1f} per 1,000 atoms"
    )
    table = _Table(f"{word}s with most clashes", [word, "clashes", "per 1,000 atoms", "worst (nm)"], ["between", "and"])
    for frame in frames:
        if frame["clashes"]:
            worst = max(frame["clashes"], key=_overlapOf)
            numbers = [frame["index"], len(frame["clashes"]), f"{frame['clashesPer1000Atoms']:.1f}"]
            table.add(*numbers, f"{worst['overlap']:.4f}", _name(worst["atom1"]), _name(worst["atom2"]))
    table.print(rows, console)
    table = _Table("most frequent clashes", [f"% of {word}s", "worst (nm)", f"in {word}"], ["between", "and"])
    for entry in summary["pairs"]:
        table.add(*_shareAndWorst(entry, count), *entry["atoms"])
    table.print(rows, console)
    numbers = [f"a {word}", f"% of {word}s", "worst (nm)", f"in {word}"]
    table = _Table("residues with most clashes", numbers, ["residue"])
    for entry in summary["residues"]:
        table.add(f"{entry['clashes'] / count:.2f}", *_shareAndWorst(entry, count), entry["residue"])
    table.print(rows, console)


def _shareAndWorst(entry, frameCount):
    return f"{100 * entry['frames'] / frameCount:.0f}", f"{entry['worstOverlap']:.4f}", entry["worstFrame"]


def _countClashes(count, form=","):
    return f"{count:{form}} {'clash' if count == 1 else 'clashes'}"


def _overlapOf(clash):
    return clash["overlap"]


def _name(atom):
    return str(AtomName(**atom))


class _Table:
    """A table with a heading: columns of numbers, then columns of words. Without rows, it is not printed."""

    def __init__(self, heading, numbers, words):
        self._heading = heading
        self._numbers = numbers
        self._words = words
        self._rows = []

    def add(self, *cells):
        self._rows.append([f"{cell:,}" if isinstance(cell, int) else cell for cell in cells])

    def print(self, rows, console):
        if not self._rows:
            return
        table = Table(box=None, pad_edge=False, header_style="bold")
        for heading in self._numbers:
            table.add_column(heading, justify="right")
        for heading in self._words:
            table.add_column(heading)
        for row in self._rows[:rows]:
            table.add_row(*row)
        left = len(self._rows) - rows
        console.print()
        console.print(f"{self._heading}{f' ({left:,} more not shown)' if left > 0 else ''}:")
        console.print(table)
