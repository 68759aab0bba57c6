"""Finding the clashes of structure files and trajectories."""

from typing import NamedTuple

import numpy as np

from ..clashes import ClashFinder, FrameClashes, nameClashes
from ..errors import InputError
from ..imageclashes import noteOnOtherCopies
from ..images import boxOf
from ..notes import Note, found
from .crystal import Crystal
from .structure import checkPositions, readModels, spaceGroupOf, villinPath
from .trajectory import Trajectory


class FrameOverlaps(NamedTuple):
    """The clashes of a model or a frame as arrays, which take less memory than a FrameClashes.

    number : int, from 0; pairs : (n, 2) int32 array; overlaps : (n,) float64 array, nm; clashesPer1000Atoms : float
    operators : (n,) array of str, as in Clash; None where copies do not count
    """

    number: int
    pairs: np.ndarray
    overlaps: np.ndarray
    clashesPer1000Atoms: float
    operators: np.ndarray | None = None


class ClashSearch:
    """The search of `findClashes`, frame by frame: iterate it once, or ask for parts of it.

    Iteration yields a FrameClashes for each frame, `overlaps` a FrameOverlaps. At a damaged frame both raise an
    InputError.

    Attributes
    ----------
    structure, trajectory : str or Path, or None
    models : Models
        the content of the structure file
    finder : ClashFinder
    crystal : Crystal whose copies count, or None
    frameCount : int or None
        the number of frames, if it is known
    notes : list of Note
        on the input; complete after the iteration
    madeWhole : list of int
        the searched frames in which molecules were made whole
    imageNote : Note or None
        on images or copies of the first frame that do not count, after it was searched
    """

    def __init__(
        self, structure=None, trajectory=None, radii=None, water=False, ions=False, periodic=False, symmetry=False
    ):
        """Read the structure, or the villin headpiece of OpenMM's package; arguments are those of `findClashes`."""
        self.structure = villinPath() if structure is None else structure
        self.trajectory = trajectory
        if symmetry and periodic:
            raise InputError("symmetry copies include periodic images: choose one of them")
        if symmetry and trajectory is not None:
            raise InputError(f"{trajectory}: symmetry copies are made of the models of a structure, of no trajectory")
        # The reader of the trajectory starts while the structure is read.
        self._trajectory = None if trajectory is None else Trajectory(trajectory)
        try:
            self._readStructure(radii, water, ions, periodic, symmetry)
            if trajectory is not None:
                self._readHeader()
        except BaseException:
            self.close()
            raise
        self.madeWhole = []
        self.imageNote = None

    def _readStructure(self, radii, water, ions, periodic, symmetry):
        self.models = readModels(self.structure)
        topology, positions = self.models.topology, self.models.positions[0]
        self._box = boxOf(topology)
        self._areNoted = not periodic and not symmetry
        self._spaceGroup = spaceGroupOf(self.models) if self.trajectory is None else ""
        self._word = "model" if self.trajectory is None else "frame"
        self.crystal = Crystal(self.structure, self.models) if symmetry else None
        self.finder = ClashFinder(topology, positions, self.structure, radii, water, ions, periodic, self.crystal)
        self.notes = [*self.models.notes, *self.finder.notes, *(self.crystal.notes if symmetry else ())]
        if periodic and self._spaceGroup:
            self.notes.append(noteOnOtherCopies(self._spaceGroup))
        self.frameCount = len(self.models.positions)

    def _readHeader(self):
        self._trajectory.readHeader()
        self.frameCount = self._trajectory.frameCount
        announced, held = self._trajectory.announced, self.frameCount
        if announced is not None and held is not None and announced > held:
            counts = f"its header tells of {announced:,} frames, but it holds {held:,}"
            self.notes.append(Note(f"{self.trajectory}: {counts}"))

    def __iter__(self):
        try:
            for number, pairs, overlaps, score, operators in self.overlaps():
                yield FrameClashes(number, nameClashes(self.finder.names, pairs, overlaps, operators), score)
        finally:
            self.noteBoxes()
            self.close()

    def overlaps(self, begin=0, end=None):
        """Yield a FrameOverlaps for each frame from begin to end - 1; end=None: to the last frame.

        Exhaust one iterator before the next call.
        """
        for number, whole, box in self.wholeFrames(begin, end):
            if number == 0 and self._areNoted:
                self.imageNote = self.finder.noteImages(whole, box, self._spaceGroup)
            pairs, overlaps, operators = self.finder.findOverlaps(whole, box, self._describe(number))
            yield FrameOverlaps(number, pairs, overlaps, 1000 * len(pairs) / self.finder.checkedCount, operators)

    def wholeFrames(self, begin=0, end=None):
        """Yield the number, the positions with whole molecules, and the box of each frame; as for `overlaps`."""
        frames = self._modelFrames(begin, end) if self.trajectory is None else self._trajectoryFrames(begin, end)
        for number, (positions, box) in enumerate(frames, begin):
            whole = self.finder.makeWhole(positions, box, self._describe(number))
            if whole is not positions:
                self.madeWhole.append(number)
            yield number, whole, self._box if box is None else box

    def _describe(self, number):
        return f"{self.trajectory or self.structure}: {self._word} {number} (from 0)"

    def noteBoxes(self):
        """Add `madeWhole` and `imageNote` to the notes."""
        kind = f"{self._word}s in which molecules were split over the periodic box, and made whole"
        self.notes += found([Note(kind, [f"{self._word} {number} (from 0)" for number in self.madeWhole])])
        if self.imageNote is not None:
            place = f", in {self._word} 0 (from 0)" if self.imageNote.items and self.frameCount != 1 else ""
            self.notes.append(Note(self.imageNote.kind + place, self.imageNote.items))

    def close(self):
        """Close the trajectory."""
        if self._trajectory is not None:
            self._trajectory.close()

    def _modelFrames(self, begin, end):
        yield from zip(self.models.positions[begin:end], self.models.boxes[begin:end], strict=True)
        if end in (None, self.frameCount) and self.models.damage is not None:
            raise self.models.damage

    def _trajectoryFrames(self, begin, end):
        topology = self.models.topology
        for index, (positions, box) in enumerate(self._trajectory.frames(begin, -1 if end is None else end), begin):
            if len(positions) != topology.getNumAtoms():
                counts = f"has {len(positions):,} atoms, but {self.structure} has {topology.getNumAtoms():,}"
                raise InputError(f"{self.trajectory}: {counts}")
            checkPositions(positions, topology, f"{self.trajectory}: frame {index} (from 0)")
            yield positions, box
