"""Shows how far a run is: trials, trials a second, acceptance, time left, and conditions that end it."""

from threading import Lock
from time import monotonic

_LONGEST_TIME = 1e8  # s, that is shown


class RunProgress:
    """The progress of a ReplicaRun on a terminal. Any thread may call it."""

    def __init__(self, show, total, state, stopping):
        """Take a function that shows a number of trials and a text, all trials or None, a RunState and a Stopping."""
        self._show = show
        self._total = total
        self._state = state
        self._stopping = stopping
        self._begun = monotonic()
        self._first = self._done = None
        self._lock = Lock()

    def reach(self, trials):
        """Note that replicas have made a number of trials in all."""
        with self._lock:
            if self._first is None:
                self._first = self._done = trials
            self._done = max(self._done, trials)
            self._show(self._done, ", ".join(self._describe()))

    def add(self, trials):
        """Note that a replica has made more trials."""
        self.reach(self._done + trials)

    def _describe(self):
        seconds, trials = monotonic() - self._begun, self._done - self._first
        left = self._stopping.secondsLeft()
        if trials > 0 and self._total is not None:
            left = min(left, (self._total - self._done) * seconds / trials)
        if left < _LONGEST_TIME:
            minutes, rest = divmod(max(0, round(left)), 60)
            yield f"{minutes // 60}:{minutes % 60:02}:{rest:02} left"
        yield from self._stopping.describe()
        if trials > 0 and seconds > 0:
            yield f"{trials / seconds:,.0f} trials/s"
        attempted, *_, accepted = self._state.counts.sum(axis=(0, 1)).tolist()
        if attempted:
            yield f"{100 * accepted / attempted:.0f} % accepted"
