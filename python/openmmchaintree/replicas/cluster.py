"""Connects to workers on other machines by Dask distributed, checks them, and runs functions on them."""

import logging
import pickle
import sys
import warnings
from queue import Empty, SimpleQueue
from threading import Thread
from uuid import uuid4

import openmm

from .. import __version__
from ..errors import ClusterError, InputError, firstLine
from ..extras import importExtra
from .segment import runSegment

_CONNECT_SECONDS = 10
_ANSWER_SECONDS = 3  # longer than a Client needs to report that it cannot connect

# Exceptions of a Client that cannot connect, with a reason.
_REASONS = (OSError, ValueError, TypeError, ImportError, RuntimeError)

# Text, since the worker that evaluates it may lack the package or have another version.
_VERSIONS = (
    "(__import__('openmmchaintree').__version__, __import__('openmm').__version__, "
    "'.'.join(map(str, __import__('sys').version_info[:2])))"
)
_NAMES = ("openmm-chaintree", "OpenMM", "Python")


def _ownVersions():
    return __version__, openmm.__version__, ".".join(map(str, sys.version_info[:2]))


class Cluster:
    """The workers of a Dask scheduler.

    Submitted functions must be pure: if a worker is lost, the scheduler repeats its work, and results that it has not
    delivered, on another worker.
    """

    def __init__(self, address):
        """Connect to the scheduler at an address, such as tcp://host:8786, and check its workers.

        Raises
        ------
        InputError
            if the scheduler cannot be reached
        ClusterError
            if it has no workers, or one with another version
        """
        Client = importExtra("distributed", "--scheduler", raising=InputError).Client
        # Errors are reported once, in our words.
        logging.getLogger("distributed").setLevel(logging.CRITICAL + 1)
        self.address = address
        self._run = uuid4().hex[:12]  # distinguishes our tasks on a shared scheduler
        self._tasks = 0
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                self._client = _connect(Client, address)
        except _REASONS as error:
            raise InputError(f"--scheduler {address}: cannot be reached ({firstLine(error)})") from error
        try:
            self.checkWorkers()
        except BaseException:
            self.close()
            raise

    def checkWorkers(self):
        """Refuse a cluster without workers, or with workers of another version."""
        versions = self._asking(lambda: self._client.run(eval, _VERSIONS, on_error="return"))
        if not versions:
            raise ClusterError(f"--scheduler {self.address}: there are no workers")
        for worker, found in sorted(versions.items()):
            if isinstance(found, BaseException):
                raise ClusterError(f"worker {worker}: cannot run openmm-chaintree ({firstLine(found)})")
            for name, theirs, ours in zip(_NAMES, found, _ownVersions(), strict=True):
                if theirs != ours:
                    raise ClusterError(f"worker {worker}: has {name} {theirs}, but here is {ours}")

    def countThreads(self):
        """Return the number of functions that the workers can run at a time."""
        return sum(self._asking(self._client.nthreads).values())

    def submit(self, function, *arguments, worker=None, receive=None):
        """Submit a function; return its Task. It preferably runs on `worker`, an address.

        receive : a function that makes the Task's result from what the submitted function has returned
        """
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
        return Task(self, future, receive)

    def close(self):
        """Close the connection and drop all tasks."""
        try:
            self._client.close(timeout=2)
        except Exception:  # from a lost connection
            pass

    def _asking(self, ask):
        """Return the result of a function that calls the scheduler; convert its errors to ClusterError."""
        try:
            return ask()
        except Exception as error:
            raise ClusterError(f"--scheduler {self.address}: {firstLine(error)}") from error

    def _explain(self, error):
        """Return the exception to raise in place of Dask's."""
        if "CancelledError" in type(error).__name__:
            return ClusterError(f"--scheduler {self.address}: was lost, or restarted")
        try:
            self.checkWorkers()  # perhaps a later worker has another version
        except ClusterError as reason:
            return reason
        return ClusterError(f"--scheduler {self.address}: {type(error).__name__}: {firstLine(error)}")


class Task:
    """A function that a worker runs, with the methods of a future that `Coordinator` needs."""

    def __init__(self, cluster, future, receive):
        self._cluster = cluster
        self._future = future
        self._receive = receive

    @property
    def asArgument(self):
        """Stands for the result in the arguments of another submitted function."""
        return self._future

    def add_done_callback(self, callback):
        """Call a function with this Task when the Task has ended."""
        self._future.add_done_callback(lambda _: callback(self))

    def result(self):
        """Wait; return the result, or raise the function's exception.

        Raises
        ------
        ClusterError
            if the workers or the scheduler failed
        """
        try:
            answer = self._future.result()
        except (InputError, openmm.OpenMMException, KeyboardInterrupt):
            raise
        except BaseException as error:  # asyncio's CancelledError is not an Exception
            raise self._cluster._explain(error) from error
        return answer if self._receive is None else self._receive(answer)


class ClusterReplicas:
    """Runs the Segments of a Model on a Cluster; `count` is its initial number of threads."""

    # More than one, so that no worker waits for its next Segment.
    _SEGMENTS_PER_THREAD = 2

    def __init__(self, cluster, model):
        """Take a Cluster and a Model.

        The scheduler keeps the Model, so the Model outlives any worker, and each worker receives it once.
        """
        self._cluster = cluster
        self._model = cluster.submit(pickle.loads, pickle.dumps(model))
        self.count = cluster.countThreads()
        self._workers = {}  # the worker of each replica's last segment

    def callAfterSteps(self, noteTrials):
        """Do nothing: workers report whole Segments."""

    def slots(self):
        """Return the number of Segments to submit at a time, which depends on the current workers."""
        return max(1, self._SEGMENTS_PER_THREAD * self._cluster.countThreads())

    def submit(self, segment):
        """Submit a Segment, preferably to the worker that ran its replica last; return a future."""
        worker = self._workers.get(segment.replica)
        arguments = _ownVersions(), self._model.asArgument, segment
        return self._cluster.submit(_runThere, *arguments, worker=worker, receive=self._receive)

    def _receive(self, answer):
        """Record the worker in the answer of `_runThere`; return the SegmentResult."""
        worker, result = answer
        self._workers[result.replica] = worker
        return result

    def stop(self):
        """Do nothing: workers finish their Segments, whose results are ignored."""

    def close(self):
        """Close the Cluster."""
        self._cluster.close()


def _connect(Client, address):
    """Return a Client of a scheduler, or raise the reason why it cannot connect.

    It connects in a separate thread, since it would wait forever for a server that is not a scheduler, such as a
    dashboard. A failed Client is marked as closed, or Python would wait for it at exit.
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
    if end is None or isinstance(end, BaseException):  # such as MemoryError, from bytes misread as a length
        raise ConnectionError("the program at this address is not a scheduler") from end
    return end


def _runThere(versions, model, segment):
    """Run a Segment on a worker of these versions; return the worker's address and the SegmentResult."""
    from distributed import get_worker

    address = get_worker().address
    for name, theirs, ours in zip(_NAMES, _ownVersions(), versions, strict=True):
        if theirs != ours:  # a worker that joined after the check
            raise InputError(f"worker {address}: has {name} {theirs}, but {ours} is needed")
    return address, runSegment(model, segment)
