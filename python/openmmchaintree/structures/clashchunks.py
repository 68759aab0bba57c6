"""The clashes of long trajectories, in chunks that processes look at: of this machine, or of a cluster.

A chunk is a pure function of the files and of the numbers of its frames. Each process reads these frames by itself, so
that no positions go from one to another, and nobody holds more than one frame.
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
from .clashsearch import ClashSearch, FrameOverlaps
from .structure import villinPath

# Chunks are short enough that nobody waits long for the last one, and long enough that asking for them takes no time.
_LONGEST_CHUNK = 2000
_CHUNKS_PER_WORKER = 8

# So many chunks of each worker are asked for at a time.
_CHUNKS_AHEAD = 3


class SearchedFiles(NamedTuple):
    """What a ClashSearch reads, and how; sizes tell files of other machines from ours.

    structure, trajectory : str, or None; radii, water, ions : as for a ClashSearch; sizes : tuple of int
    """

    structure: str
    trajectory: str | None
    radii: str | None
    water: bool
    ions: bool
    sizes: tuple[int, ...]


class ChunkOverlaps(NamedTuple):
    """What was found in a chunk, as few arrays.

    counts : (frames,) int array, of the clashes of each frame; pairs, overlaps : of all frames, as in FrameOverlaps
    madeWhole : list of int, frames in which molecules were made whole; damage : str, why frames are missing, or None
    imageClashes : list of str, clashes with periodic images, in the chunk with the first frame
    """

    counts: np.ndarray
    pairs: np.ndarray
    overlaps: np.ndarray
    madeWhole: list[int]
    damage: str | None
    imageClashes: list[str]


def describeFiles(structure, trajectory, radii, water, ions):
    """Return the SearchedFiles of a ClashSearch with these arguments, with absolute paths; OSError: one is missing."""
    given = (villinPath() if structure is None else structure, trajectory)
    paths = [os.path.abspath(path) for path in given if path is not None]
    sizes = tuple(os.path.getsize(path) for path in paths)
    return SearchedFiles(paths[0], paths[1] if len(paths) > 1 else None, radii, water, ions, sizes)


_ofThread = local()


def searchChunk(files, begin, end):
    """Search frames from one to another of SearchedFiles; return a ChunkOverlaps. Each thread keeps its last search.

    Raises
    ------
    ClusterError
        if these files are not here
    """
    search, frames, damage = _searchOf(files), [], None
    search.madeWhole.clear()
    search.imageClashes = []
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
        list(search.madeWhole),
        damage,
        list(search.imageClashes),
    )


def _searchOf(files):
    """Return the ClashSearch that this thread keeps, of these SearchedFiles."""
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
    return ClashSearch(files.structure, files.trajectory, files.radii, files.water, files.ions)


def _close():
    if getattr(_ofThread, "files", None) is not None:
        _ofThread.search.close()
        _ofThread.files = None


class ChunkStop:
    """Ends a search in chunks, which a handler of signals can call."""

    def __init__(self):
        """Begin with nobody who has called."""
        self._isCalled = False
        self._arrived = SimpleQueue()

    def call(self):
        """Have the search end at once."""
        self._isCalled = True
        self._arrived.put(None)

    def waitFor(self, future):
        """Wait for a future; return whether it has ended, and nobody has called."""
        self._arrived = arrived = SimpleQueue()
        future.add_done_callback(arrived.put)
        if not self._isCalled:
            arrived.get()
        return not self._isCalled


class ProcessChunks:
    """Searches chunks by a number of processes, its count."""

    def __init__(self, count, files):
        """Start so many processes, which open SearchedFiles meanwhile."""
        self.count = count
        # Processes that are forked from one with threads may hang.
        context = get_context("spawn")
        self._endsChunks = context.Event()
        self._pool = ProcessPoolExecutor(count, context, _beginProcess, (files, self._endsChunks))
        # All begin now: a pool that starts one while another is killed can wait for it for ever.
        for _ in range(count):
            self._pool.submit(os.getpid)

    def submit(self, *arguments):
        """Have `searchChunk` called; return a future."""
        return self._pool.submit(searchChunk, *arguments)

    def close(self):
        """End all processes, after the frames that they look at."""
        self._endsChunks.set()
        self._pool.shutdown(cancel_futures=True)


class ClusterChunks:
    """Searches chunks by the workers of a Cluster, of count threads at first."""

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


_isStopped = None  # in a process of ours: an Event


def _beginProcess(files, isStopped):
    """Open SearchedFiles. Leave Ctrl-C, which a terminal sends to all processes, to the one that asked; end with it."""
    global _isStopped
    _isStopped = isStopped
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_endWithParent, daemon=True).start()
    with suppress(Exception):  # the one that asked opens them, too, and tells
        _searchOf(files)


def _endWithParent():
    parent_process().join()
    os._exit(1)


def searchInChunks(search, files, workers, stop=None):
    """Yield what `search.overlaps()` would, of a ClashSearch, found by workers if the number of frames is known.
    files : SearchedFiles, of the search; workers : ProcessChunks or ClusterChunks; stop : ChunkStop, or None

    Raises
    ------
    InputError
        as `search.overlaps()` would, after all frames before a damaged one
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
        search.imageClashes += chunk.imageClashes
        ends = np.cumsum(chunk.counts)
        for number, (end, size) in enumerate(zip(ends.tolist(), chunk.counts.tolist(), strict=True), begin):
            pairs, overlaps = chunk.pairs[end - size : end], chunk.overlaps[end - size : end]
            yield FrameOverlaps(number, pairs, overlaps, 1000 * size / search.finder.checkedCount)
        if chunk.damage is not None:
            raise InputError(_withOurPaths(chunk.damage, search, files))


@contextmanager
def _explainingLostProcesses():
    try:
        yield
    except BrokenProcessPool as error:
        raise ClusterError("a process that looked for clashes was ended from outside") from error


def _withOurPaths(text, search, files):
    """Return a message that names files as the user did."""
    for theirs, ours in ((files.trajectory, search.trajectory), (files.structure, search.structure)):
        if theirs is not None:
            text = text.replace(theirs, str(ours))
    return text
