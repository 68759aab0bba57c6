"""Workers on other machines, by Dask distributed: reached, checked, and asked to run functions."""

import logging
import pickle
import sys
import warnings
from queue import Empty, SimpleQueue
from threading import Thread
from uuid import uuid4

import openmm

from .. import __version__
from ..errors import ClusterError, InputError
from .segment import runSegment

_CONNECT_SECONDS = 10
_ANSWER_SECONDS = 3  # more than a Client takes to say that it cannot connect

# What a Client raises that cannot connect, and says why.
_REASONS = (OSError, ValueError, TypeError, ImportError, RuntimeError)

# Evaluated by a worker that may lack the package, or have another one: so it is text.
_VERSIONS = (
    "(__import__('openmmchaintree').__version__, __import__('openmm').__version__, "
    "'.'.join(map(str, __import__('sys').version_info[:2])))"
)
_NAMES = ("openmm-chaintree", "OpenMM", "Python")


def _ownVersions():
    return __version__, openmm.__version__, ".".join(map(str, sys.version_info[:2]))


class Cluster:
    """The workers of a Dask scheduler. As a context manager it closes the connection.

    Whatever is submitted has to be a pure function: where a worker is lost, the scheduler has another one run what that
    one was to do, or has done and not handed over.
    """

    def __init__(self, address):
        """Connect to the scheduler at an address, such as tcp://host:8786, and check its workers.

        Raises
        ------
        InputError
            if the scheduler cannot be reached
        ClusterError
            if it has no workers, or one of another version
        """
        try:
            from distributed import Client
        except ImportError as error:
            raise InputError(f"--scheduler needs Dask distributed (pip install distributed): {error}") from error
        # What goes wrong is told once, in words of ours.
        logging.getLogger("distributed").setLevel(logging.CRITICAL + 1)
        self.address = address
        self._run = uuid4().hex[:12]  # tells what is ours on a scheduler that others use, too
        self._tasks = 0
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                self._client = _connect(Client, address)
        except _REASONS as error:
            raise InputError(f"--scheduler {address}: cannot be reached ({_firstLine(error)})") from error
        try:
            self.checkWorkers()
        except BaseException:
            self.close()
            raise

    def checkWorkers(self):
        """Refuse a cluster without workers, and workers of another version."""
        versions = self._asking(lambda: self._client.run(eval, _VERSIONS, on_error="return"))
        if not versions:
            raise ClusterError(f"--scheduler {self.address}: there are no workers")
        for worker, found in sorted(versions.items()):
            if isinstance(found, BaseException):
                raise ClusterError(f"worker {worker}: cannot run openmm-chaintree ({_firstLine(found)})")
            for name, theirs, ours in zip(_NAMES, found, _ownVersions(), strict=True):
                if theirs != ours:
                    raise ClusterError(f"worker {worker}: has {name} {theirs}, but here is {ours}")

    def countThreads(self):
        """Return how many functions the workers can run at a time."""
        return sum(self._asking(self._client.nthreads).values())

    def submit(self, function, *arguments, worker=None):
        """Have a function run; return its Task. A worker's address says who runs it, if that one has time."""
        self._tasks += 1
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a Model can be larger than Dask advises
            future = self._asking(
                lambda: self._client.submit(
                    function,
                    *arguments,
                    key=f"openmm-chaintree-{self._run}-{self._tasks}",
                    workers=worker,
                    allow_other_workers=worker is not None,
                )
            )
        return Task(self, future)

    def close(self):
        """Close the connection; what was submitted is forgotten."""
        try:
            self._client.close(timeout=2)
        except Exception:  # of a connection that is gone
            pass

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()

    def _asking(self, ask):
        """Return what a function returns that asks the scheduler; make what goes wrong a ClusterError."""
        try:
            return ask()
        except Exception as error:
            raise ClusterError(f"--scheduler {self.address}: {_firstLine(error)}") from error

    def _explain(self, error):
        """Return what is to be raised in place of an error of Dask's."""
        if "CancelledError" in type(error).__name__:
            return ClusterError(f"--scheduler {self.address}: was lost, or restarted")
        try:
            self.checkWorkers()  # perhaps one that came later is of another version
        except ClusterError as reason:
            return reason
        return ClusterError(f"--scheduler {self.address}: {type(error).__name__}: {_firstLine(error)}")


class Task:
    """A function that a worker runs: what `Coordinator` asks of a future."""

    def __init__(self, cluster, future):
        self._cluster = cluster
        self._future = future

    @property
    def asArgument(self):
        """What stands for the result where it is an argument of another function that workers run."""
        return self._future

    def add_done_callback(self, callback):
        """Call a function with this Task when it has ended."""
        self._future.add_done_callback(lambda _: callback(self))

    def result(self):
        """Wait; return what the function returned, or raise what it raised.

        Raises
        ------
        ClusterError
            if the workers, or the scheduler, did not bring it to its end
        """
        try:
            return self._future.result()
        except (InputError, openmm.OpenMMException, KeyboardInterrupt):
            raise
        except BaseException as error:  # asyncio's CancelledError is no Exception
            raise self._cluster._explain(error) from error


class ClusterReplicas:
    """Runs the Segments of a Model on a Cluster, of count threads at first."""

    # Segments are handed out so that no worker waits for the next one to come.
    _SEGMENTS_PER_THREAD = 2

    def __init__(self, cluster, model):
        """Take a Cluster and a Model.

        The scheduler keeps the Model, so that it outlives any worker, and each worker gets it once.
        """
        self._cluster = cluster
        self._model = cluster.submit(pickle.loads, pickle.dumps(model))
        self.count = cluster.countThreads()
        self._workers = {}  # who ran the last segment of each replica

    def slots(self):
        """Return how many Segments there should be at a time; workers can come and go."""
        return max(1, self._SEGMENTS_PER_THREAD * self._cluster.countThreads())

    def submit(self, segment):
        """Have a Segment run, by the worker that has its replica, if that one has time; return a future."""
        worker = self._workers.get(segment.replica)
        task = self._cluster.submit(_runThere, _ownVersions(), self._model.asArgument, segment, worker=worker)
        return _SegmentTask(task, self._workers)

    def stop(self):
        """Do nothing: workers end what they do, and nobody takes it."""

    def close(self):
        """Close the Cluster."""
        self._cluster.close()


class _SegmentTask:
    """A Task of `_runThere`, as a future of a SegmentResult. It notes who has run it."""

    def __init__(self, task, workers):
        self._task = task
        self._workers = workers

    def add_done_callback(self, callback):
        self._task.add_done_callback(lambda _: callback(self))

    def result(self):
        worker, result = self._task.result()
        self._workers[result.replica] = worker
        return result


def _connect(Client, address):
    """Return a Client of a scheduler, or raise what keeps it from connecting.

    It connects in a thread of its own, since it would wait forever for what is no scheduler, such as a dashboard. A
    Client that fails counts as closed: else Python would wait for it, in vain.
    """
    ends = SimpleQueue()

    def connect():
        client = Client.__new__(Client)
        try:
            client.__init__(address, timeout=_CONNECT_SECONDS, set_as_default=False, name="openmm-chaintree")
        except BaseException as error:
            client.status = "closed"
            ends.put(error)
        else:
            ends.put(client)

    Thread(target=connect, daemon=True).start()
    try:
        end = ends.get(timeout=_CONNECT_SECONDS + _ANSWER_SECONDS)
    except Empty:
        end = None
    if isinstance(end, _REASONS):
        raise end
    if end is None or isinstance(end, BaseException):  # such as MemoryError, by what it took for a length
        raise ConnectionError("what is there does not answer as a scheduler does") from end
    return end


def _runThere(versions, model, segment):
    """Run a Segment on a worker, if it is of these versions; return the worker's address and the SegmentResult."""
    from distributed import get_worker

    address = get_worker().address
    for name, theirs, ours in zip(_NAMES, _ownVersions(), versions, strict=True):
        if theirs != ours:  # a worker that came after the others were checked
            raise InputError(f"worker {address}: has {name} {theirs}, but {ours} is needed")
    return address, runSegment(model, segment)


def _firstLine(error):
    return (str(error).strip() or type(error).__name__).splitlines()[0]
