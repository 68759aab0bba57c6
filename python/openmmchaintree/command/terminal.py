"""Terminal output, exit statuses, signals and garbage collection of a running command."""

import gc
import re
import signal
import sys
import threading
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Column

# Exit statuses other than 0.
BEYOND_LIMIT = 1  # a sampling run ended with pairs beyond their limit
BAD_INPUT = 2
INTERRUPTED = 130
NOBODY_READS = 141  # the reader of the output has closed it
TERMINATED = 143

# Letters; about five lines of a terminal.
_LONGEST_ERROR = 600

# Characters that control a terminal: control characters except the line end, and directions of text.
_COMMANDS = re.compile(r"[\x00-\x09\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")


def printable(text):
    """Return a text with characters that control a terminal escaped, since names come from files."""
    return _COMMANDS.sub(_escape, text)


def _escape(found):
    code = ord(found[0])
    return f"\\x{code:02x}" if code < 0x80 else f"\\u{code:04x}"  # as in JSON


class ReportConsole(Console):
    """The console for reports, which does not wrap lines.

    It is standard output, or standard error if an output goes to standard output.
    """

    def __init__(self, outputs):
        """Take the Outputs of the command."""
        isTaken = any(output.isStandardOutput for output in outputs)
        super().__init__(stderr=isTaken, highlight=False, markup=False, emoji=False, soft_wrap=True)

    def render_str(self, text, **options):
        """Render a text, printed or in a table, without characters that control the terminal."""
        return super().render_str(printable(text), **options)

    def on_broken_pipe(self):
        """Let the command handle it; Console would exit the process."""
        raise BrokenPipeError


def printError(message, program="openmm-chaintree"):
    """Print an error in one line, without its middle if it is very long."""
    text = printable(str(message))
    if len(text) > _LONGEST_ERROR:
        text = f"{text[: _LONGEST_ERROR * 2 // 3]} … {text[-_LONGEST_ERROR // 3 :]}"
    print(f"{program}: {text}", file=sys.stderr)


def ofSignal(number):
    """Return the exit status for a signal, as shells report it."""
    return 128 + number


class Terminated(KeyboardInterrupt):
    """A signal asked the command to terminate."""


_SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def interruptible():
    """Let SIGTERM interrupt as Ctrl-C does, unless it has another handler."""
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
    """The signals received, true after the first one. A signal can end a step of the integrator immediately."""

    def __init__(self, stop):
        """Take a function to call at the first signal."""
        self._stop = stop
        self._numbers = []
        self._endsStep = False

    @property
    def number(self):
        """The number of the first signal."""
        return self._numbers[0]

    def __bool__(self):
        return bool(self._numbers)

    def receive(self, number):
        """Record a signal."""
        self._numbers.append(number)
        self._stop()
        if self._endsStep:
            raise StepEnded

    def runStep(self, step):
        """Call a function that makes a step; a signal prevents the step, or ends it after some of its trials."""
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
    """A signal interrupted a step."""


@contextmanager
def interruptFlag(stop=lambda: None):
    """Collect interrupts (Ctrl-C, SIGTERM) instead of stopping in the middle of a file; a second one stops.

    Yields Interrupts. stop : function, called at the first one
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
    """Pause garbage collection during setup, which makes no garbage; collecting would take a third of the time."""
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


@contextmanager
def progress(total, hasText=False):
    """Show a progress bar on a terminal, nothing in a pipe; yields a function to call with the amount done.

    The function's second argument is a text to show instead of the time left. The total may be None if it is unknown.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda done, text="": None
        return
    columns = BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    if hasText:  # which is cut on a narrow terminal, and not the numbers
        rest = Column(no_wrap=True, overflow="ellipsis", ratio=1)
        columns = BarColumn(12), MofNCompleteColumn(), TextColumn("{task.description}", table_column=rest)
    with Progress(*columns, console=console, transient=True, expand=hasText) as bar:
        task = bar.add_task("", total=total)
        yield lambda done, text="": bar.update(task, completed=done, description=text)
