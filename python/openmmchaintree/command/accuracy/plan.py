"""What is measured of the accuracy."""

from ...errors import InputError
from ..benchmarking.platforms import CPU, whyNot
from ..benchmarking.races import LAZY_GRID
from ..benchmarking.study import Study
from .report import makeReport
from .rows import DRIFT, TOUCH, DriftRow, ForceRow, TouchRow
from .softforce import whyNoReference

TURNS = 1000000  # after which accuracy is measured, beside powers of ten below

_SIZES = (100, 1000, 10000, 100000)
_QUICK_SIZES = (100, 1000)

_REFUSED = {"structures": "structures", "rows": "--rows", "contestants": "--contestants"}


def planAccuracy(options, program):
    """Return the Study of accuracy that the user wants.

    Raises
    ------
    InputError
        if an option belongs to races
    """
    for name, words in _REFUSED.items():
        if getattr(options, name):
            raise InputError(f"--accuracy goes without {words}: it is measured of chains and contestants of its own")
    sizes = _QUICK_SIZES if options.quick else _SIZES
    rows = [DriftRow(size, _namesOf(program, DRIFT)) for size in sizes]
    rows += [TouchRow(size, [*_namesOf(program, TOUCH), LAZY_GRID]) for size in sizes]
    skipped = []
    if whyNoReference() is None:
        rows += [ForceRow(size) for size in sizes]
        skipped.append(("forces on the CPU platform", whyNot(CPU)))
    else:
        skipped.append(("forces", whyNoReference()))
    skipped = [entry for entry in skipped if entry[1] is not None]

    def report(entries, course, failures, interrupted):
        return makeReport(entries, course, skipped, failures, interrupted)

    return Study(rows, TURNS, report, _hasPicture, _savePicture, _hasFailed)


def _namesOf(program, measure):
    return [contestant.name for contestant in program.contestants if contestant.measure == measure]


def _hasFailed(summary):
    return any(goal["reached"] is False for goal in summary["goals"])


def _hasPicture(summary):
    return any(entry["group"] in (DRIFT, TOUCH) for entry in summary["entries"])


def _savePicture(output, summary):
    # Matplotlib takes long to import.
    from .picture import savePicture

    savePicture(output, summary)
