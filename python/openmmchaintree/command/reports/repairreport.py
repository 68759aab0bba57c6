"""What a repair did, for people, and as CSV and JSON."""

import csv
import io

from ..terminal import printable
from .noteoutput import asPlain, printNotes
from .tables import makeTable


def summarize(path, repaired, output):
    """Return the results of a RepairedFile as plain dictionaries and lists, in nm."""
    return {
        "structure": str(path),
        "output": output,
        "isClean": all(repair.isClean for repair in repaired.repairs),
        "models": [_summarizeModel(repair) for repair in repaired.repairs],
        "notes": asPlain(repaired.notes),
    }


def _summarizeModel(repair):
    changes = repair.changes
    return {
        "isClean": repair.isClean,
        "clashscoreBefore": repair.clashscoreBefore,
        "clashscoreAfter": repair.clashscoreAfter,
        "clashesBefore": repair.clashesBefore,
        "clashesAfter": repair.clashesAfter,
        "ownClashesBefore": repair.ownBefore,
        "ownClashesAfter": repair.ownAfter,
        "traceShiftRms": changes.traceRms,
        "traceShiftLargest": changes.traceLargest,
        "heavyAtomShiftRms": changes.rms,
        "heavyAtomShiftLargest": changes.largest,
        "rotamersChanged": changes.rotamersChanged,
        "rotamers": changes.rotamers,
        "remaining": [clash._asdict() for clash in repair.remaining],
        "defectsBefore": repair.defectsBefore,
        "defects": repair.defects,
        "mendedBonds": repair.mendedBonds,
        "disulfides": repair.disulfides,
    }


def asCSV(repaired):
    """Return the shifts of all residues as CSV, in nm."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["model", "residue", "CA or P (nm)", "rms (nm)", "largest (nm)", "rotamer changed"])
    for number, repair in enumerate(repaired.repairs):
        for row in repair.changes.residues:
            trace = "" if row.trace != row.trace else f"{row.trace:.4f}"
            numbers = [trace, f"{row.rms:.4f}", f"{row.largest:.4f}", int(row.isOtherRotamer)]
            writer.writerow([number, printable(row.residue), *numbers])
    return text.getvalue()


def printReport(summary, files, rowCount, console, isVerbose):
    """Print a summary on a ReportConsole. files : list of str, that were written"""
    for number, model in enumerate(summary["models"]):
        name = summary["structure"] if len(summary["models"]) == 1 else f"{summary['structure']}, model {number}"
        _printModel(name, model, rowCount, console)
    printNotes(summary["notes"], console, isVerbose)
    console.print(f"written: {', '.join(files)}")


def _printModel(name, model, rowCount, console):
    console.print(f"{name}: {'clean' if model['isClean'] else 'not clean'}")
    table = makeTable([""], ["before", "after"])
    table.add_row("clashscore", *(f"{model[f'clashscore{when}']:.1f}" for when in ("Before", "After")))
    table.add_row("clashes", *(f"{model[f'clashes{when}']:,}" for when in ("Before", "After")))
    table.add_row("overlaps beyond the repair's margin", *(f"{model[f'ownClashes{w}']:,}" for w in ("Before", "After")))
    console.print(table)
    table = makeTable(["shift (nm)"], ["rms", "largest"])
    table.add_row("Cα or P", f"{model['traceShiftRms']:.3f}", f"{model['traceShiftLargest']:.3f}")
    table.add_row("heavy atoms", f"{model['heavyAtomShiftRms']:.3f}", f"{model['heavyAtomShiftLargest']:.3f}")
    console.print(table)
    if model["rotamers"]:
        console.print(f"rotamers changed: {model['rotamersChanged']} of {model['rotamers']}")
    _printList("broken bonds that were mended", model["mendedBonds"], rowCount, console)
    _printList("disulfides whose length was mended", model["disulfides"], rowCount, console)
    _printList("defects that torsions cannot mend", model["defects"], rowCount, console)
    rest = [f"{c['atoms']}, overlap {c['overlap']:.3f} nm: {c['cause']}" for c in model["remaining"]]
    _printList("clashes that remain", rest, rowCount, console)


def _printList(heading, items, rowCount, console):
    if not items:
        return
    console.print(f"{heading} ({len(items):,}):")
    for item in items[:rowCount]:
        console.print(f"  {item}")
    if len(items) > rowCount:
        console.print(f"  and {len(items) - rowCount:,} more")
