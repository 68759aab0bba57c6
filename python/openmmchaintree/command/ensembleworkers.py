"""The processes or Dask threads that do the jobs of the commands ensemble and repair."""

import signal
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context

from ..errors import ClusterError, InputError
from .arguments import usableCores
from .ensemblejob import runJob

_JOBS_AHEAD = 2  # for each worker


@contextmanager
def workers(options, count, run=runJob):
    """Start workers; yield a function that submits a job to them and returns its future, and their number.

    run : function of a job, which a module defines
    """
    if options.scheduler is not None:
        from ..replicas.cluster import Cluster  # Dask takes long to import

        cluster = Cluster(options.scheduler)
        try:
            yield lambda job: cluster.submit(run, job), cluster.countThreads()
        finally:
            cluster.close()
        return
    number = max(1, min(options.workers or usableCores(), count))
    pool = ProcessPoolExecutor(number, get_context("spawn"), _ignoreInterrupts)
    try:
        yield lambda job: pool.submit(run, job), number
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for process in list((pool._processes or {}).values()):
            process.terminate()


def _ignoreInterrupts():
    """Leave Ctrl-C to the parent process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def results(jobs, submit, count, arrived):
    """Yield each job with its result, or the InputError of its source, as they come.

    arrived : SimpleQueue of (job, future), which ends the work if it holds None
    """
    left, running = iter(jobs), 0
    while True:
        while running < _JOBS_AHEAD * count and (job := next(left, None)) is not None:
            submit(job).add_done_callback(lambda future, job=job: arrived.put((job, future)))
            running += 1
        if running == 0 or (found := arrived.get()) is None:
            return
        running -= 1
        job, future = found
        try:
            yield job, future.result()
        except ClusterError:
            raise
        except BrokenProcessPool as error:
            raise ClusterError(
                "a process was ended from outside; --resume does the jobs that are missing"
            ) from error
        except InputError as error:
            yield job, error
