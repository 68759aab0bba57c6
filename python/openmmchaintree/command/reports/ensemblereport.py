"""What the command ensemble reports: files of a protein, a line of its averages, and the table of all proteins."""

import csv
import io

from ..outputs.output import Output
from ..outputs.outputfiles import asJSON

_COLUMNS = ("protein", "residues", "conformers", "Rg (nm)", "ends (nm)", "ν")


def writeFiles(folder, job, result):
    """Write the files of a protein; the averages are the last, so a protein that has them is complete."""
    for end, content in {**result.files, ".json": asJSON(result.summary)}.items():
        Output(str(folder / f"{job.name}{end}"), overwrite=True).write(content)


def heading():
    return f"{_COLUMNS[0]:24} {_COLUMNS[1]:>8} {_COLUMNS[2]:>10} {_COLUMNS[3]:>15} {_COLUMNS[4]:>15} {_COLUMNS[5]:>13}"


def rowOf(summary):
    """Return a line for a protein that is finished."""
    shown = f"{summary['name'][:24]:24} {summary['residues']:8,} {summary['conformers']:10,}"
    for name in ("radius of gyration", "end-to-end distance"):
        one = summary["estimates"][name]
        shown += f" {_withError(one['mean'], one['standardError'], 3):>15}"
    shown += f" {_withError(summary['scalingExponent'], summary['scalingExponentError'], 3):>13}"
    if not summary["isComplete"]:
        shown += f"  only {summary['effectiveSampleSize']:.0f} are independent"
    return shown


def _withError(mean, error, digits):
    if mean is None:
        return "–"
    return f"{mean:.{digits}f}" if error is None else f"{mean:.{digits}f} ± {error:.{digits}f}"


def asCSV(summaries):
    """Return the table of all proteins."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    names = ("radius of gyration", "end-to-end distance", "asphericity")
    headings = [f"{name}{word}" for name in names for word in ("", " error")]
    writer.writerow(
        [
            "protein",
            "residues",
            "conformers",
            "effective sample size",
            *headings,
            "scaling exponent",
            "scaling exponent error",
        ]
    )
    for one in summaries:
        values = [one["estimates"][name][kind] for name in names for kind in ("mean", "standardError")]
        values += [one["scalingExponent"], one["scalingExponentError"]]
        described = ["" if value is None else f"{value:.6g}" for value in values]
        writer.writerow([one["name"], one["residues"], one["conformers"], one["effectiveSampleSize"], *described])
    return text.getvalue()
