"""Runs Segments in threads of this process."""

from concurrent.futures import ThreadPoolExecutor

from .segment import Workplace

# More than one, so that no thread waits for its next Segment.
_SEGMENTS_PER_THREAD = 2


class ThreadReplicas:
    """Runs the Segments of a Model in `count` threads."""

    def __init__(self, model, threads):
        """Take a Model and the number of threads."""
        self._workplace = Workplace(model)
        self.count = threads
        self._pool = ThreadPoolExecutor(threads)

    def callAfterSteps(self, noteTrials):
        """Call a function with the number of trials after each step, in the step's thread."""
        self._workplace.noteTrials = noteTrials

    def slots(self):
        """Return the number of Segments to submit at a time."""
        return _SEGMENTS_PER_THREAD * self.count

    def submit(self, segment):
        """Submit a Segment; return a future of its SegmentResult."""
        return self._pool.submit(self._workplace.run, segment)

    def stop(self):
        """Stop running Segments, which raise Stopped, and prevent others from beginning."""
        self._workplace.stop()

    def close(self):
        """End all Segments."""
        self.stop()
        self._pool.shutdown(cancel_futures=True)
