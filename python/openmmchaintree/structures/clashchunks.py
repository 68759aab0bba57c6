"""Searching long trajectories for clashes in chunks, by processes of this machine or of a cluster.

The result of a chunk depends only on the files and the numbers of its frames. Each process reads these frames from the
file, so that processes exchange no positions, and none holds more than one frame.
"""

import os
import signal
from collections import deque
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from multiprocessing import get_context, parent_process
from queue import SimpleQueue
from threading import Thread, local
from typing import NamedTuple

import numpy as np

from ..errors import ClusterError, InputError
from ..notes import Note
from .clashsearch import ClashSearch, FrameOverlaps
from .structure import villinPath

# Chunks are short, so that the last one does not take long, but long enough to make requests negligible.
_LONGEST_CHUNK = 2000
_CHUNKS_PER_WORKER = 8

# The number of chunks that are requested ahead for each worker.
_CHUNKS_AHEAD = 3


class SearchedFiles(NamedTuple):
    """The input and options of a ClashSearch; sizes show whether another machine has other files.

    structure, trajectory : str, or None; radii, …, symmetry : as for a ClashSearch; sizes : tuple of int
    """

    structure: str
    trajectory: str | None
    radii: str | None
    water: bool
    ions: bool
    periodic: bool
    symmetry: bool
    sizes: tuple[int, ...]


class ChunkOverlaps(NamedTuple):
    """The clashes of a chunk, as a few arrays.

    counts : (frames,) int array, of the clashes of each frame
    pairs, overlaps, operators : of all frames, as in FrameOverlaps
    madeWhole : list of int, frames in which molecules were made whole; damage : str, why frames are missing, or None
    imageNote : Note on images that do not count, in the chunk with the first frame; None in others
    """

    counts: np.ndarray
    pairs: np.ndarray
    overlaps: np.ndarray
    operators: np.ndarray | None
    madeWhole: list[int]
    damage: str | None
    imageNote: Note | None


def describeFiles(structure, trajectory, radii, water, ions, periodic=False, symmetry=False):
    """Return the SearchedFiles of a ClashSearch with these arguments; OSError: a file is missing."""
    given = (villinPath() if structure is None else structure, trajectory)
    paths = [os.path.abspath(path) for path in given if path is not None]
    sizes = tuple(os.path.getsize(path) for path in paths)
    trajectory = paths[1] if len(paths) > 1 else None
    return SearchedFiles(paths[0], trajectory, radii, water, ions, periodic, symmetry, sizes)


_ofThread = local()


def searchChunk(files, begin, end):
    """Search frames begin to end - 1 of SearchedFiles; return a ChunkOverlaps. Each thread keeps its last search.

    Raises
    ------
    ClusterError
        if this machine does not have these files
    """
    search, frames, damage = _searchOf(files), [], None
    search.madeWhole.clear()
    search.imageNote = None
    try:
        for frame in search.overlaps(begin, end):
            frames.append(frame)
            if _isStopped is not None and _isStopped.is_set():
                break
    except InputError as error:
        damage = str(error)
        _close()
    return ChunkOverlaps(
        np.array([len(frame.pairs) for frame in frames], dtype=np.int32),
        np.concatenate([np.empty((0, 2), dtype=np.int32), *(frame.pairs for frame in frames)]),
        np.concatenate([np.empty(0), *(frame.overlaps for frame in frames)]),
        np.concatenate([np.empty(0, dtype=str), *(frame.operators for frame in frames)]) if files.symmetry else None,
        list(search.madeWhole),
        damage,
        search.imageNote,
    )


def _searchOf(files):
    """Return the ClashSearch of SearchedFiles, which this thread keeps."""
    if getattr(_ofThread, "files", None) != files:
        _close()
        _ofThread.search = _open(files)
        _ofThread.files = files
    return _ofThread.search


def _open(files):
    for path, size in zip((files.structure, files.trajectory), files.sizes, strict=False):
        try:
            found = os.path.getsize(path)
        except OSError as error:
            raise ClusterError(f"{path}: cannot be read by a worker ({error.strerror})") from error
        if found != size:
            raise ClusterError(f"{path}: a worker finds another file there, of {found:,} bytes, not {size:,}")
    return ClashSearch(*files[:-1])


def _close():
    if getattr(_ofThread, "files", None) is not None:
        _ofThread.search.close()
        _ofThread.files = None


class ChunkStop:
    """Ends a search in chunks; a handler of signals may call it."""

    def __init__(self):
        """Begin without a call."""
        self._isCalled = False
        self._arrived = SimpleQueue()

    def call(self):
        """End the search at once."""
        self._isCalled = True
        self._arrived.put(None)

    def waitFor(self, future):
        """Wait for a future or a call; return False if the search was called to end."""
        self._arrived = arrived = SimpleQueue()
        future.add_done_callback(arrived.put)
        if not self._isCalled:
            arrived.get()
        return not self._isCalled


class ProcessChunks:
    """Searches chunks in processes of this machine; count is their number."""

    def __init__(self, count, files):
        """Start count processes, which begin to open SearchedFiles."""
        self.count = count
        # Processes forked from a process with threads may hang.
        context = get_context("spawn")
        self._endsChunks = context.Event()
        self._pool = ProcessPoolExecutor(count, context, _beginProcess, (files, self._endsChunks))
        # Start all now: a pool that starts one process while another is killed can wait for it forever.
        for _ in range(count):
            self._pool.submit(os.getpid)

    def submit(self, *arguments):
        """Have `searchChunk` called; return a future."""
        return self._pool.submit(searchChunk, *arguments)

    def close(self):
        """End all processes after their current frames."""
        self._endsChunks.set()
        self._pool.shutdown(cancel_futures=True)


class ClusterChunks:
    """Searches chunks by the workers of a Cluster; count is their number of threads at the start."""

    def __init__(self, cluster):
        """Take a Cluster."""
        self._cluster = cluster
        self.count = cluster.countThreads()

    def submit(self, *arguments):
        """Have `searchChunk` called; return a Task."""
        return self._cluster.submit(searchChunk, *arguments)

    def close(self):
        """Close the Cluster."""
        self._cluster.close()


_isStopped = None  # in a process that ProcessChunks started: an Event


def _beginProcess(files, isStopped):
    """Open SearchedFiles; ignore Ctrl-C, which the parent process handles, and end when the parent ends."""
    global _isStopped
    _isStopped = isStopped
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_endWithParent, daemon=True).start()
    with suppress(Exception):  # the parent process opens the files, too, and reports errors
        _searchOf(files)


def _endWithParent():
    parent_process().join()
    os._exit(1)


def searchInChunks(search, files, workers, stop=None):
    """Yield the results of `search.overlaps()` of a ClashSearch, found by workers if the number of frames is known.

    files : SearchedFiles, of the search; workers : ProcessChunks or ClusterChunks; stop : ChunkStop, or None

    Raises
    ------
    InputError
        at a damaged frame, after the results of all frames before it
    ClusterError
        if a worker is lost for good
    """
    count = search.frameCount
    if count is None:
        yield from search.overlaps()
        return
    length = max(1, min(_LONGEST_CHUNK, -(-count // (_CHUNKS_PER_WORKER * workers.count))))
    begins, asked = iter(range(0, max(1, count), length)), deque()
    while True:
        with _explainingLostProcesses():
            while len(asked) < _CHUNKS_AHEAD * workers.count and (begin := next(begins, None)) is not None:
                asked.append((begin, workers.submit(files, begin, min(begin + length, count))))
            if not asked:
                return
            begin, future = asked.popleft()
            if stop is not None and not stop.waitFor(future):
                return
            chunk = future.result()
        search.madeWhole += chunk.madeWhole
        search.imageNote = search.imageNote or chunk.imageNote
        ends = np.cumsum(chunk.counts)
        for number, (end, size) in enumerate(zip(ends.tolist(), chunk.counts.tolist(), strict=True), begin):
            pairs, overlaps = chunk.pairs[end - size : end], chunk.overlaps[end - size : end]
            operators = None if chunk.operators is None else chunk.operators[end - size : end]
            yield FrameOverlaps(number, pairs, overlaps, 1000 * size / search.finder.checkedCount, operators)
        if chunk.damage is not None:
            raise InputError(_withOurPaths(chunk.damage, search, files))


@contextmanager
def _explainingLostProcesses():
    try:
        yield
    except BrokenProcessPool as error:
        raise ClusterError("a process that looked for clashes was ended from outside") from error


def _withOurPaths(text, search, files):
    """Return a message with the files named as the user named them."""
    for theirs, ours in ((files.trajectory, search.trajectory), (files.structure, search.structure)):
        if theirs is not None:
            text = text.replace(theirs, str(ours))
    return text
