"""Runs Segments in threads of this process."""

from concurrent.futures import ThreadPoolExecutor

from .segment import Workplace

# Segments are handed out so that no thread waits for the next one.
_SEGMENTS_PER_THREAD = 2


class ThreadReplicas:
    """Runs the Segments of a Model in a number of threads, its count."""

    def __init__(self, model, threads):
        """Take a Model, and how many threads there are."""
        self._workplace = Workplace(model)
        self.count = threads
        self._pool = ThreadPoolExecutor(threads)

    def slots(self):
        """Return how many Segments there should be at a time."""
        return _SEGMENTS_PER_THREAD * self.count

    def submit(self, segment):
        """Have a Segment run; return a future of its SegmentResult."""
        return self._pool.submit(self._workplace.run, segment)

    def stop(self):
        """End Segments that run, which raise Stopped, and let no other one begin."""
        self._workplace.stop()

    def close(self):
        """End all Segments."""
        self.stop()
        self._pool.shutdown(cancel_futures=True)
