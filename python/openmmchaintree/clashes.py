"""Finding the clashes of files, and of a Topology at given positions."""

import os
from itertools import repeat
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import openmm
from openmm import unit

from .bonds import BondGraph
from .bondsearch import LONGEST_BOND
from .contexts import contextOf
from .errors import InputError
from .imageclashes import noteOnImages
from .images import engineBox, leastWidth, makeWhole, vectorsOf
from .naming import AtomName, nameAtom
from .notes import Note, found, warnOf
from .radii import defaultRadii, describeSets
from .solute import selectSolute, tornError
from .sterics import makeForce
from .symmetryclashes import SymmetryClashes
from .torsions import searchTorsions

Path: TypeAlias = str | os.PathLike[str]


class Clash(NamedTuple):
    """Two atoms that overlap by more than is tolerated.

    particle1, particle2 : int, the lower index first; atom1, atom2 : AtomName; overlap : float, nm
    operator : str, the symmetry operation that makes the copy of atom 2, in fractions of the cell, such as
    "-x+1,y+1/2,-z"; empty for an atom of the file
    """

    particle1: int
    particle2: int
    atom1: AtomName
    atom2: AtomName
    overlap: float
    operator: str = ""


class FrameClashes(NamedTuple):
    """The clashes of a model or a frame.

    number : int, from 0; clashes : list of Clash; clashesPer1000Atoms : float
    """

    number: int
    clashes: list[Clash]
    clashesPer1000Atoms: float


def findClashes(
    structure: Path,
    trajectory: Path | None = None,
    radii: str | None = None,
    water: bool = False,
    ions: bool = False,
    periodic: bool = False,
    symmetry: bool = False,
) -> list[FrameClashes]:
    """Find the clashes of all models of a structure, or of all frames of a trajectory.

    A clash is defined by the `StericExclusionForce` that `createStericExclusionForce` makes for the structure: atoms
    more than three bonds apart that overlap by more than 0.04 nm, or 0.1 nm where one may donate a hydrogen bond to the
    other. Molecules split over the periodic box are made whole along their bonds. Periodic images count only with
    `periodic`, copies in a crystal only with `symmetry`; otherwise a warning says so, and lists the clashes with images
    in the first frame. Bonds follow from the structure and its chemistry, never from a frame of the trajectory. Atoms
    of elements without a known radius are ignored, with a warning.

    Parameters
    ----------
    structure : str or Path
        a PDB, mmCIF, BinaryCIF, gro, SDF or Mol2 file, plain or compressed. Of alternate conformers, the one of
        highest occupancy is used.
    trajectory : str or Path, optional
        a DCD, XTC, TRR, NetCDF or HDF5 (MDTraj) file with the same atoms, searched instead of the structure's models
    radii : str, optional
        "all-atom" or "united-atom". Default: "all-atom" for molecules that show their hydrogens, "united-atom" for
        others.
    water, ions : bool
        include water, and unbound ions
    periodic : bool
        whether atoms count in all images of the periodic box, which each frame or else the structure has
    symmetry : bool
        whether copies in a crystal count, by all operations of its space group and vectors of its cell. Equivalent
        clashes are listed once, with the operation as `Clash.operator`. An atom on an axis does not clash with itself.
        Atoms whose occupancies are below 1 and add up to at most 1 do not clash with each other. Bonds with copies are
        found like other bonds. Not for trajectories.

    Returns
    -------
    list of FrameClashes
        Particles are numbered from 0 in the order of the structure, ignored atoms included.

    Raises
    ------
    InputError
        a ValueError, if a file cannot be read or is damaged, a molecule is split and there is no box, images count and
        there is no box, or one too narrow, or copies count and there is no cell or no known space group. Its attribute
        `frames` holds the results of earlier frames.
    """
    # It reads files, which needs more packages than the other modules beside this one.
    from .structures.clashsearch import ClashSearch

    search = ClashSearch(structure, trajectory, radii, water, ions, periodic, symmetry)
    return listFrames(search)


def listFrames(search: Any) -> list[Any]:
    """Return what a search yields for each frame, and warn of its notes; an InputError gets the earlier frames."""
    frames: list[Any] = []
    try:
        frames.extend(search)
    except InputError as error:
        error.frames = frames
        raise
    finally:
        warnOf(search.notes, stacklevel=3)
    return frames


class ClashFinder:
    """Finds the clashes of a Topology at any positions, in a separate Context.

    Attributes
    ----------
    names : list of AtomName
        all atoms of the Topology
    atoms : (n,) int array
        the atoms that are searched for clashes
    checkedCount : int
        the number of searched atoms that have a radius
    radii : str
        the set of radii, or both, in words
    force : StericExclusionForce
        its particles are the searched atoms
    notes : list of Note
        gaps, and atoms of unknown radius
    """

    def __init__(self, topology, positions, source, radii=None, water=False, ions=False, periodic=False, crystal=None):
        """Choose the atoms, and make their force; positions are (n, 3) in nm, source names the Topology in messages.

        periodic : whether pairs count in all images of the boxes given to `find`
        crystal : a Crystal whose copies count, or None

        Raises
        ------
        InputError
            if no atom can be searched
        """
        self.names = [nameAtom(atom) for atom in topology.atoms()]
        solute = selectSolute(source, topology, positions, water, ions)
        self.atoms = solute.atoms
        self._graph = BondGraph(solute.topology, solute.positions)
        self.radii = describeSets(defaultRadii(self._graph)) if radii is None else radii
        self._bonds = np.array(self._graph.bonds, dtype=int).reshape(-1, 2).T.copy()
        # Torsions do not change which atoms clash, but with them the engine recomputes less at new positions.
        torsions = searchTorsions(self._graph, solute.topology, ("phi", "psi", "chi")).torsions
        self.force = makeForce(self._graph, torsions, radii, unknownRadius=0)
        self.notes = [*solute.notes, *found([self._findUnknownRadii()])]
        if self.checkedCount == 0:
            raise InputError(f"{source}: there is no atom with a known radius")
        self.force.setUsesPeriodicBoundaryConditions(periodic)
        self._isPeriodic = periodic
        self._context = contextOf(self.force)
        self._copies = None
        if crystal is not None:
            names = [self.names[atom] for atom in self.atoms]
            self._copies = SymmetryClashes(self.force, self._graph, solute.topology, crystal, self.atoms, names)
            self.notes += self._copies.notes

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

    def makeWhole(self, positions, box, source):
        """Make molecules whole along their bonds if they are split over a periodic box.

        positions : (n, 3) float64 array, nm, of all atoms of the Topology; box : (3, 3) array, nm, or None

        Return the same positions if no molecule is split.

        Raises
        ------
        InputError
            if bonded atoms are still far apart; source names the frame
        """
        first, second = self._bonds
        chosen = positions.take(self.atoms, axis=0)
        vectors = chosen.take(first, axis=0) - chosen.take(second, axis=0)
        longest = np.sqrt(np.einsum("ij,ij->i", vectors, vectors).max(initial=0))
        # A vector shorter than half the box's width has no shorter image; 0.49 leaves room for rounding.
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

    def noteImages(self, positions, box, spaceGroup=""):
        """Return the result of `noteOnImages` for positions of all atoms, where images do not count."""
        names = [self.names[atom] for atom in self.atoms]
        return noteOnImages(self.force, positions.take(self.atoms, axis=0), box, names, spaceGroup)

    def find(self, positions, box=None, source="the positions"):
        """Return the list of Clash at positions of all atoms of the Topology.

        positions : (n, 3) float64 array, nm, of whole molecules; box : (3, 3) array, nm, or None, read only where
        images count; source names the positions in messages

        Raises
        ------
        InputError
            if images count, and there is no box or one too narrow
        """
        return nameClashes(self.names, *self.findOverlaps(positions, box, source))

    def findOverlaps(self, positions, box=None, source="the positions"):
        """Return the pairs that clash, their overlaps and operators, as in FrameOverlaps; arguments as for `find`."""
        if self._isPeriodic:
            self._context.setPeriodicBoxVectors(*vectorsOf(engineBox(box, source)))
        positions = positions.take(self.atoms, axis=0)
        self._context.setPositions(positions)
        try:
            pairs, overlaps = self.force.getClashes(self._context)
        except openmm.OpenMMException as error:  # a box that is too narrow
            raise InputError(f"{source}: {str(error).removeprefix('StericExclusionForce: ')}") from error
        operators = None
        if self._copies is not None:
            found = pairs, overlaps, np.full(len(pairs), "")
            others = self._copies.find(positions)
            pairs, overlaps, operators = map(np.concatenate, zip(found, others, strict=True))
        return self.atoms[pairs].astype(np.int32), overlaps, operators


def eachClash(pairs, overlaps, operators=None):
    """Return an iterator over the pair, the overlap and the operator of each clash; arguments as in FrameOverlaps."""
    operators = repeat("", len(pairs)) if operators is None else operators.tolist()
    return zip(pairs.tolist(), overlaps.tolist(), operators, strict=True)


def nameClashes(names, pairs, overlaps, operators=None):
    """Return clashes as a list of Clash, by the AtomName of all atoms."""
    return [
        Clash(first, second, names[first], names[second], overlap, operator)
        for (first, second), overlap, operator in eachClash(pairs, overlaps, operators)
    ]
