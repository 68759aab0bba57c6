"""What a running command shows on a terminal, and what it does to Python while it runs."""

import gc
import signal
import sys
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn


# Letters: five lines of most terminals.
_LONGEST_ERROR = 600


class ReportConsole(Console):
    """The console that reports are printed on, with lines as long as they are.

    It is standard output, or standard error if one of the outputs takes that.
    """

    def __init__(self, outputs):
        """Take the Outputs of the command."""
        isTaken = any(output.isStandardOutput for output in outputs)
        super().__init__(stderr=isTaken, highlight=False, markup=False, emoji=False, soft_wrap=True)

    def on_broken_pipe(self):
        """Leave it to the command, where Console would end the process by itself."""
        raise BrokenPipeError


def printError(message, program="openmm-chaintree"):
    """Print what is wrong, in one line, the middle of which is left out if it is very long."""
    text = str(message)
    if len(text) > _LONGEST_ERROR:
        text = f"{text[: _LONGEST_ERROR * 2 // 3]} … {text[-_LONGEST_ERROR // 3 :]}"
    print(f"{program}: {text}", file=sys.stderr)


@contextmanager
def interruptFlag():
    """Collect interrupts (Ctrl-C) in a list instead of stopping between two bytes of a file; a second one stops."""
    received = []

    def note(signum, frame):
        received.append(signum)
        signal.signal(signal.SIGINT, previous)

    previous = signal.signal(signal.SIGINT, note)
    try:
        yield received
    finally:
        signal.signal(signal.SIGINT, previous)


@contextmanager
def collectionPaused():
    """Look for no garbage for a while: what is set up stays, and looking through it takes a third of the time."""
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


@contextmanager
def progress(total):
    """Show a progress bar on a terminal, nothing in a pipe; gives a function that takes what is done of the total.

    The total may be None, if nobody knows it.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda done: None
        return
    with Progress(BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), console=console, transient=True) as bar:
        task = bar.add_task("", total=total)
        yield lambda done: bar.update(task, completed=done)
