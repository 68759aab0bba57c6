"""Finding the clashes of files, and of a Topology at given positions."""

import os
from typing import NamedTuple, TypeAlias

import numpy as np
import openmm
from openmm import unit

from .bonds import BondGraph
from .bondsearch import LONGEST_BOND
from .errors import InputError
from .imageclashes import noteOnImages
from .images import leastWidth, makeWhole
from .naming import AtomName, nameAtom
from .notes import Note, found, warnOf
from .radii import defaultRadii, describeSets
from .solute import selectSolute, tornError
from .sterics import makeForce
from .torsions import searchTorsions

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
    # It reads files, which needs more packages than the other modules beside this one.
    from .structures.clashsearch import ClashSearch

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
