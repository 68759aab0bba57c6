"""Ranks clashing residues and pairs of atoms, frame by frame."""

from typing import NamedTuple

import numpy as np

# Number of clashes sorted together: enough for efficiency, and little memory.
_BATCH = 100000


class ClashRanking:
    """Counts how often residues and pairs of atoms clash. It keeps the counts, not the frames."""

    def __init__(self, names):
        """Take the AtomName of each atom."""
        self._names = names
        numbers = {}
        self._residueOf = np.array([numbers.setdefault(name.describeResidue(), len(numbers)) for name in names])
        self._residueNames = list(numbers)
        self.clear()

    def clear(self):
        """Forget all clashes."""
        self._residues = _Tally()
        self._pairs = _Tally()
        self._waiting = []  # frames
        self._waitingClashes = 0

    def add(self, frame):
        """Count the clashes of a FrameOverlaps. Frame numbers must increase."""
        self._waiting.append(frame)
        self._waitingClashes += len(frame.pairs)
        if self._waitingClashes >= _BATCH:
            self._countWaiting()

    def rankResidues(self):
        """Return the clashing residues as plain dictionaries, most clashes first."""
        self._countWaiting()
        ranked = self._residues.rank()
        return [
            {"residue": self._residueNames[key], **counted}
            for key, counted in zip(ranked.keys.tolist(), _describe(ranked), strict=True)
        ]

    def rankPairs(self):
        """Return the clashing pairs of atoms as plain dictionaries, most frames first."""
        self._countWaiting()
        ranked = self._pairs.rank()
        pairs = np.stack(np.divmod(ranked.keys, len(self._names)), axis=1).tolist()
        return [
            {"particles": pair, "atoms": [str(self._names[atom]) for atom in pair], **counted}
            for pair, counted in zip(pairs, _describe(ranked), strict=True)
        ]

    def _countWaiting(self):
        if self._waitingClashes > 0:
            frames = np.repeat([frame.number for frame in self._waiting], [len(frame.pairs) for frame in self._waiting])
            pairs, overlaps = (np.concatenate([frame[field] for frame in self._waiting]) for field in (1, 2))
            first, second = pairs.astype(np.int64).T
            self._pairs.add(first * len(self._names) + second, frames, overlaps)
            residues = self._residueOf[pairs]
            # Both residues of a clash in turn; a residue that clashes with itself counts once.
            counts = np.ones(residues.shape, dtype=bool)
            counts[:, 1] = residues[:, 0] != residues[:, 1]
            counts = counts.ravel()
            self._residues.add(residues.ravel()[counts], np.repeat(frames, 2)[counts], np.repeat(overlaps, 2)[counts])
        self._waiting, self._waitingClashes = [], 0


class _Rows(NamedTuple):
    """Counts for each key, in arrays.

    keys : each once; clashes, frames : numbers of clashes, and of frames with clashes; worst, worstFrame : the largest
    overlap, and the first frame with it; places : the position of the first clash among all clashes
    """

    keys: np.ndarray
    clashes: np.ndarray
    frames: np.ndarray
    worst: np.ndarray
    worstFrame: np.ndarray
    places: np.ndarray


class _Tally:
    """Counts clashes by key."""

    def __init__(self):
        self._rows = None
        self._met = 0

    def add(self, keys, frames, overlaps):
        """Count one or more clashes by key, in the order of frames, whose numbers must increase."""
        order = np.argsort(keys, kind="stable")
        keys, frames = keys[order], frames[order]
        isNewFrame = np.ones(len(keys), dtype=np.int64)
        isNewFrame[1:] = (keys[1:] != keys[:-1]) | (frames[1:] != frames[:-1])
        rows = _Rows(keys, np.ones(len(keys), dtype=np.int64), isNewFrame, overlaps[order], frames, self._met + order)
        self._met += len(keys)
        if self._rows is not None:
            rows = _Rows(*map(np.concatenate, zip(self._rows, _joinEqual(rows), strict=True)))
            order = np.argsort(rows.keys, kind="stable")
            rows = _Rows(*(column[order] for column in rows))
        self._rows = _joinEqual(rows)

    def rank(self):
        """Return the _Rows, sorted by most clashes, then by largest overlap, then by first place."""
        if self._rows is None:
            return _Rows(*(np.empty(0, dtype=np.int64) for _ in _Rows._fields))
        order = np.lexsort((self._rows.places, -self._rows.worst, -self._rows.clashes))
        return _Rows(*(column[order] for column in self._rows))


def _joinEqual(rows):
    """Merge equal keys of _Rows that are sorted by key, then by frame."""
    isFirst = np.ones(len(rows.keys), dtype=bool)
    isFirst[1:] = rows.keys[1:] != rows.keys[:-1]
    begins = np.flatnonzero(isFirst)
    clashes, frames = (np.add.reduceat(column, begins) for column in (rows.clashes, rows.frames))
    worst = np.maximum.reduceat(rows.worst, begins)
    group = np.cumsum(isFirst) - 1
    holders = np.flatnonzero(rows.worst == worst[group])
    holders = holders[np.searchsorted(group[holders], np.arange(len(begins)))]  # the first of each group
    return _Rows(rows.keys[begins], clashes, frames, worst, rows.worstFrame[holders], rows.places[begins])


def _describe(rows):
    """Return the reported counts of each key as dictionaries."""
    names = ("clashes", "frames", "worstOverlap", "worstFrame")
    columns = (rows.clashes, rows.frames, rows.worst, rows.worstFrame)
    return [dict(zip(names, row, strict=True)) for row in zip(*(column.tolist() for column in columns), strict=True)]
