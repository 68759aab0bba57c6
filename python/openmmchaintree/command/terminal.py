"""What a running command shows on a terminal, and what it does to Python while it runs."""

import gc
import re
import signal
import sys
import threading
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

# Letters: five lines of most terminals.
_LONGEST_ERROR = 600


# What a terminal takes for more than a letter: control characters but the end of a line, and directions of text.
_COMMANDS = re.compile(r"[\x00-\x09\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")


def printable(text):
    """Return a text with what a terminal would take for a command written as an escape: names come from files."""
    return _COMMANDS.sub(_escape, text)


def _escape(found):
    code = ord(found[0])
    return f"\\x{code:02x}" if code < 0x80 else f"\\u{code:04x}"  # as JSON has them, too


class ReportConsole(Console):
    """The console that reports are printed on, with lines as long as they are.

    It is standard output, or standard error if one of the outputs takes that.
    """

    def __init__(self, outputs):
        """Take the Outputs of the command."""
        isTaken = any(output.isStandardOutput for output in outputs)
        super().__init__(stderr=isTaken, highlight=False, markup=False, emoji=False, soft_wrap=True)

    def render_str(self, text, **options):
        """Make a text, be it printed or in a table, one that a terminal takes for nothing else."""
        return super().render_str(printable(text), **options)

    def on_broken_pipe(self):
        """Leave it to the command, where Console would end the process by itself."""
        raise BrokenPipeError


def printError(message, program="openmm-chaintree"):
    """Print what is wrong, in one line, the middle of which is left out if it is very long."""
    text = printable(str(message))
    if len(text) > _LONGEST_ERROR:
        text = f"{text[: _LONGEST_ERROR * 2 // 3]} … {text[-_LONGEST_ERROR // 3 :]}"
    print(f"{program}: {text}", file=sys.stderr)


class Terminated(KeyboardInterrupt):
    """The command was asked to end by a signal of the system."""


_SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def interruptible():
    """Let a signal that asks for the end (SIGTERM) interrupt as Ctrl-C does, if nobody else has a use for it."""
    isMain = threading.current_thread() is threading.main_thread()
    if not isMain or signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL:
        yield
        return

    def raiseTerminated(number, frame):
        raise Terminated

    signal.signal(signal.SIGTERM, raiseTerminated)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


class Interrupts:
    """The signals that were received: true once there is one. A step of the integrator may be ended by it at once."""

    def __init__(self, stop):
        """Take a function that is called at the first signal."""
        self._stop = stop
        self._numbers = []
        self._endsStep = False

    @property
    def number(self):
        """The number of the first one."""
        return self._numbers[0]

    def __bool__(self):
        return bool(self._numbers)

    def receive(self, number):
        """Take a signal."""
        self._numbers.append(number)
        self._stop()
        if self._endsStep:
            raise StepEnded

    def runStep(self, step):
        """Call a function that makes a step, which a signal ends after some of its trials, or before it begins."""
        try:
            try:
                self._endsStep = True
                if not self:
                    step()
            finally:
                self._endsStep = False
        except StepEnded:
            pass


class StepEnded(BaseException):
    """A signal came in the midst of a step."""


@contextmanager
def interruptFlag(stop=lambda: None):
    """Collect interrupts (Ctrl-C, SIGTERM) instead of stopping between two bytes of a file; a second one stops.

    Gives Interrupts. stop : function that is called at the first one
    """
    received = Interrupts(stop)
    previous = {number: signal.getsignal(number) for number in _SIGNALS}

    def restore():
        for number, handler in previous.items():
            signal.signal(number, handler)

    def note(number, frame):
        restore()
        received.receive(number)

    for number in _SIGNALS:
        signal.signal(number, note)
    try:
        yield received
    finally:
        restore()


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
