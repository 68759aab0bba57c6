"""Tables and shares as all reports print them."""

from rich.table import Table


def makeTable(words, numbers, more=()):
    """Return a Table with columns of words, then of numbers, then of more words, by their headings."""
    table = Table(*words, box=None, pad_edge=False, header_style="bold")
    for heading in numbers:
        table.add_column(heading, justify="right")
    for heading in more:
        table.add_column(heading)
    return table


def percent(part, whole):
    """Return a share in percent, without the sign; a dash of nothing."""
    return f"{100 * part / whole:.1f}" if whole else "–"


def alignedLines(rows, numbers):
    """Return rows of texts as lines, which are not wrapped as a Table is.

    numbers : for each column, whether it is aligned to the right
    """
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    forms = [f"{'>' if isNumber else '<'}{width}" for width, isNumber in zip(widths, numbers, strict=True)]
    return ["  ".join(map(format, row, forms)).rstrip() for row in rows]
