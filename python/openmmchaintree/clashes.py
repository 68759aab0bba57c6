"""Finding the clashes of structures and trajectories."""

import os
from typing import NamedTuple, TypeAlias

import numpy as np
import openmm
from openmm import unit

from .bonds import BondGraph
from .bondsearch import LONGEST_BOND, boxOf
from .errors import InputError
from .imageclashes import WITH_IMAGES, noteOnImages
from .images import leastWidth, makeWhole
from .naming import AtomName, nameAtom
from .notes import Note, found, warnOf
from .radii import defaultRadii, describeSets
from .sterics import makeForce
from .structure import checkPositions, readModels, selectSolute, tornError, villinPath
from .torsions import searchTorsions
from .trajectory import Trajectory

Path: TypeAlias = str | os.PathLike[str]


class Clash(NamedTuple):
    """Two atoms that overlap by more than is tolerated.

    particle1, particle2 : int, the lower index first; atom1, atom2 : AtomName; overlap : float, nm
    """

    particle1: int
    particle2: int
    atom1: AtomName
    atom2: AtomName
    overlap: float


class FrameClashes(NamedTuple):
    """The clashes of a model or a frame.

    number : int, from 0; clashes : list of Clash; clashesPer1000Atoms : float
    """

    number: int
    clashes: list[Clash]
    clashesPer1000Atoms: float


class FrameOverlaps(NamedTuple):
    """The clashes of a model or a frame as arrays, which take less memory than a FrameClashes.

    number : int, from 0; pairs : (n, 2) int32 array; overlaps : (n,) float64 array, nm; clashesPer1000Atoms : float
    """

    number: int
    pairs: np.ndarray
    overlaps: np.ndarray
    clashesPer1000Atoms: float


def findClashes(
    structure: Path, trajectory: Path | None = None, radii: str | None = None, water: bool = False, ions: bool = False
) -> list[FrameClashes]:
    """Find the clashes of all models of a structure, or of all frames of a trajectory.

    A clash is what `StericExclusionForce` calls so, with the force that `createStericExclusionForce` makes of the
    structure: atoms more than three bonds apart that overlap by more than 0.04 nm, or 0.1 nm where one may donate a
    hydrogen bond to the other. Molecules split over the periodic box are made whole along their bonds; clashes with
    images do not count, but a warning tells those of the first frame. Bonds are those of the structure and its
    chemistry, never of a frame. An atom of an element without a known radius is not looked at; a warning tells it.

    Parameters
    ----------
    structure : str or Path
        a PDB, mmCIF or BinaryCIF file, plain or compressed; of alternate conformers that of highest occupancy counts
    trajectory : str or Path, optional
        a DCD or XTC file with the same atoms, in place of the models of the structure
    radii : str, optional
        "all-atom" or "united-atom". Default: "all-atom" for molecules that show their hydrogens, "united-atom" for
        others.
    water, ions : bool
        look at water, and at ions that nothing binds, too

    Returns
    -------
    list of FrameClashes
        Particles are numbered from 0 in the order of the structure, including atoms that are not looked at.

    Raises
    ------
    InputError
        a ValueError, if a file cannot be read or is damaged, or a molecule is split and there is no box; what was found
        before that frame is its `frames`
    """
    search = ClashSearch(structure, trajectory, radii, water, ions)
    frames: list[FrameClashes] = []
    try:
        frames.extend(search)
    except InputError as error:
        error.frames = frames
        raise
    finally:
        warnOf(search.notes, stacklevel=2)
    return frames


class ClashSearch:
    """The search that `findClashes` does, frame by frame: iterate it once, or ask for parts of it.

    Iteration gives a FrameClashes for each frame, `overlaps` a FrameOverlaps. At a damaged frame both raise an
    InputError.

    Attributes
    ----------
    structure, trajectory : str or Path, or None
    finder : ClashFinder
    frameCount : int or None
        how many frames there are, if that is known
    notes : list of Note
        what the user should know of the input; complete after the iteration
    madeWhole : list of int
        frames in which molecules were made whole, so far
    imageClashes : list of str
        clashes with periodic images in the first frame, once it was looked at
    """

    def __init__(self, structure=None, trajectory=None, radii=None, water=False, ions=False):
        """Read the structure, or the villin headpiece of OpenMM's package; arguments are those of `findClashes`."""
        self.structure = villinPath() if structure is None else structure
        self.trajectory = trajectory
        # Its reader starts while we look at the structure.
        self._trajectory = None if trajectory is None else Trajectory(trajectory)
        try:
            self._readStructure(radii, water, ions)
            if trajectory is not None:
                self._readHeader()
        except BaseException:
            self.close()
            raise
        self.madeWhole = []
        self.imageClashes = []

    def _readStructure(self, radii, water, ions):
        self._models = readModels(self.structure)
        topology, positions = self._models.topology, self._models.positions[0]
        self._box = boxOf(topology)
        self._word = "model" if self.trajectory is None else "frame"
        self.finder = ClashFinder(topology, positions, self.structure, radii, water, ions)
        self.notes = [*self._models.notes, *self.finder.notes]
        self.frameCount = len(self._models.positions)

    def _readHeader(self):
        self._trajectory.readHeader()
        self.frameCount = self._trajectory.frameCount
        announced, held = self._trajectory.announced, self.frameCount
        if announced is not None and held is not None and announced > held:
            counts = f"its header tells of {announced:,} frames, but it holds {held:,}"
            self.notes.append(Note(f"{self.trajectory}: {counts}"))

    def __iter__(self):
        try:
            for number, pairs, overlaps, score in self.overlaps():
                yield FrameClashes(number, nameClashes(pairs, overlaps, self.finder.names), score)
        finally:
            self.noteBoxes()
            self.close()

    def overlaps(self, begin=0, end=None):
        """Yield a FrameOverlaps for each frame from one to another, which is not among them; None: to the last.

        Where there is more to ask for, it has to come to its end first.
        """
        frames = self._modelFrames(begin, end) if self.trajectory is None else self._trajectoryFrames(begin, end)
        for number, (positions, box) in enumerate(frames, begin):
            source = f"{self.trajectory or self.structure}: {self._word} {number} (from 0)"
            whole = self.finder.makeWhole(positions, box, source)
            if whole is not positions:
                self.madeWhole.append(number)
            if number == 0:
                self.imageClashes = self.finder.noteImages(whole, box).items
            pairs, overlaps = self.finder.findOverlaps(whole)
            yield FrameOverlaps(number, pairs, overlaps, 1000 * len(pairs) / self.finder.checkedCount)

    def noteBoxes(self):
        """Add to the notes what `madeWhole` and `imageClashes` tell."""
        kind = f"{self._word}s in which molecules were split over the periodic box, and made whole"
        images = WITH_IMAGES if self.frameCount == 1 else f"{WITH_IMAGES}, in {self._word} 0 (from 0)"
        self.notes += found(
            [
                Note(kind, [f"{self._word} {number} (from 0)" for number in self.madeWhole]),
                Note(images, self.imageClashes),
            ]
        )

    def close(self):
        """Close the trajectory."""
        if self._trajectory is not None:
            self._trajectory.close()

    def _modelFrames(self, begin, end):
        for positions in self._models.positions[begin:end]:
            yield positions, self._box
        if end in (None, self.frameCount) and self._models.damage is not None:
            raise self._models.damage

    def _trajectoryFrames(self, begin, end):
        topology = self._models.topology
        for index, (positions, box) in enumerate(self._trajectory.frames(begin, -1 if end is None else end), begin):
            if len(positions) != topology.getNumAtoms():
                counts = f"has {len(positions):,} atoms, but {self.structure} has {topology.getNumAtoms():,}"
                raise InputError(f"{self.trajectory}: {counts}")
            checkPositions(positions, topology, f"{self.trajectory}: frame {index} (from 0)")
            yield positions, box


class ClashFinder:
    """Finds the clashes of a Topology at any positions, in a Context of its own.

    Attributes
    ----------
    names : list of AtomName
        the atoms of the Topology
    atoms : (n,) int array
        those of them that are looked at
    checkedCount : int
        the number of those that have a radius
    radii : str
        the set of radii, or both, in words
    force : StericExclusionForce
        has the atoms that are looked at as particles
    notes : list of str
        gaps, and atoms whose radius is not known
    """

    def __init__(self, topology, positions, source, radii=None, water=False, ions=False):
        """Choose the atoms, and make their force; positions are (n, 3) in nm, source is for messages.

        Raises
        ------
        InputError
            if there is no atom to look at
        """
        self.names = [nameAtom(atom) for atom in topology.atoms()]
        solute = selectSolute(source, topology, positions, water, ions)
        self.atoms = solute.atoms
        self._graph = BondGraph(solute.topology, solute.positions)
        self.radii = describeSets(defaultRadii(self._graph)) if radii is None else radii
        self._bonds = np.array(self._graph.bonds, dtype=int).reshape(-1, 2).T.copy()
        # Torsions do not change what clashes; with them, the engine has less to compute anew at other positions.
        torsions = searchTorsions(self._graph, solute.topology, ("phi", "psi", "chi")).torsions
        self.force = makeForce(self._graph, torsions, radii, unknownRadius=0)
        self.notes = [*solute.notes, *found([self._findUnknownRadii()])]
        if self.checkedCount == 0:
            raise InputError(f"{source}: there is no atom with a known radius")
        self._makeContext()

    def _findUnknownRadii(self):
        unknown = []
        self.checkedCount = 0
        for number, atom in enumerate(self.atoms):
            radius, _ = self.force.getParticleParameters(number)
            if radius > 0 * unit.nanometer:
                self.checkedCount += 1
            elif self._graph.elementNumber(number) > 1:
                unknown.append(f"{self.names[atom]}, {self._graph.atoms[number].element.name}")
        return Note("atoms not looked at, since no radius is known for their elements", unknown)

    def _makeContext(self):
        system = openmm.System()
        for _ in self.atoms:
            system.addParticle(1.0)
        system.addForce(self.force)
        platform = openmm.Platform.getPlatformByName("Reference")
        self._context = openmm.Context(system, openmm.VerletIntegrator(0.001), platform)

    def makeWhole(self, positions, box, source):
        """Make molecules whole that a periodic box tears apart, along their bonds.

        positions : (n, 3) float64 array, nm, of all atoms of the Topology; box : (3, 3) array, nm, or None

        Return the positions given, if nothing is torn apart.

        Raises
        ------
        InputError
            if bonded atoms are far apart all the same; source says where
        """
        first, second = self._bonds
        chosen = positions.take(self.atoms, axis=0)
        vectors = chosen.take(first, axis=0) - chosen.take(second, axis=0)
        longest = np.sqrt(np.einsum("ij,ij->i", vectors, vectors).max(initial=0))
        # Less than half a width has no shorter image; rounding could not make up for the rest.
        if longest <= LONGEST_BOND and (box is None or longest < 0.49 * leastWidth(box)):
            return positions
        whole = chosen if box is None else makeWhole(chosen, self._bonds.T, box)
        lengths = np.linalg.norm(whole[first] - whole[second], axis=1)
        torn = np.flatnonzero(lengths > LONGEST_BOND)
        if len(torn):
            names = [self.names[atom] for atom in self.atoms]
            pairs = [f"{names[first[i]]} – {names[second[i]]}, {lengths[i]:.3f} nm" for i in torn]
            raise tornError(source, pairs, box is not None)
        if whole is chosen:
            return positions
        positions = positions.copy()
        positions[self.atoms] = whole
        return positions

    def noteImages(self, positions, box):
        """Return a Note on clashes across a box, (3, 3) in nm or None, at positions as for `find`, made whole."""
        names = [self.names[atom] for atom in self.atoms]
        return noteOnImages(self.force, positions.take(self.atoms, axis=0), box, names)

    def find(self, positions):
        """Return the list of Clash at positions of all atoms of the Topology, a float64 array of shape (n, 3) in nm."""
        return nameClashes(*self.findOverlaps(positions), self.names)

    def findOverlaps(self, positions):
        """Return the pairs that clash, an (n, 2) int32 array, and their overlaps; positions as for `find`."""
        self._context.setPositions(positions.take(self.atoms, axis=0))
        pairs, overlaps = self.force.getClashes(self._context)
        return self.atoms[pairs].astype(np.int32), overlaps


def nameClashes(pairs, overlaps, names):
    """Return pairs of atoms and their overlaps as a list of Clash."""
    return [
        Clash(particle1, particle2, names[particle1], names[particle2], overlap)
        for (particle1, particle2), overlap in zip(pairs.tolist(), overlaps.tolist(), strict=True)
    ]
