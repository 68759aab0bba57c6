"""Finding the clashes of structures and trajectories."""

import warnings
from typing import NamedTuple

import numpy as np
import openmm

from .bonds import BondGraph
from .naming import AtomName, nameAtom
from .radii import defaultRadii
from .sterics import createStericExclusionForce
from .structure import InputError, checkFinite, readModels, select, villinPath
from .torsions import searchTorsions
from .trajectory import Trajectory


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

    index : int, from 0; clashes : list of Clash; clashesPer1000Atoms : float
    """

    index: int
    clashes: list[Clash]
    clashesPer1000Atoms: float


def findClashes(structure, trajectory=None, radii=None, water=False, ions=False):
    """Find the clashes of all models of a structure, or of all frames of a trajectory.

    A clash is what `StericExclusionForce` calls so, with the force that `createStericExclusionForce` makes of the
    structure: atoms more than three bonds apart that overlap by more than 0.04 nm, or 0.1 nm where one may donate a
    hydrogen bond to the other. Positions are taken as they are, without periodic images. An atom of an element without
    a known radius is not looked at; a warning tells it.

    Parameters
    ----------
    structure : str or Path
        a PDB or mmCIF file; of alternate conformers the first counts
    trajectory : str or Path, optional
        a DCD or XTC file with the same atoms, in place of the models of the structure
    radii : str, optional
        "all-atom" or "united-atom". Default: "all-atom" if the structure has hydrogens, else "united-atom".
    water, ions : bool
        look at water and at ions (residues of a single atom), too

    Returns
    -------
    list of FrameClashes
        Particles are numbered from 0 in the order of the structure, including atoms that are not looked at.

    Raises
    ------
    InputError
        a ValueError, if a file cannot be read or is damaged; what was found before a damaged frame is its `frames`
    """
    search = ClashSearch(structure, trajectory, radii, water, ions)
    for note in search.notes:
        warnings.warn(note, stacklevel=2)
    frames = []
    try:
        frames.extend(search)
    except InputError as error:
        error.frames = frames
        raise
    return frames


class ClashSearch:
    """The search that `findClashes` does, frame by frame: iterate it once.

    Iteration gives a FrameClashes for each frame, and raises an InputError at a damaged one.

    Attributes
    ----------
    structure, trajectory : str or Path, or None
    names : list of AtomName
        the atoms of the structure
    atoms : (n,) int array
        those of them that are looked at
    checkedCount : int
        the number of those that have a radius
    frameCount : int or None
        how many frames there are, if that is known
    radii : str
        the set of radii
    force : StericExclusionForce
    notes : list of str
        what the user should know of the input
    """

    def __init__(self, structure=None, trajectory=None, radii=None, water=False, ions=False):
        """Read the structure, or the villin headpiece of OpenMM's package; arguments are those of `findClashes`."""
        self.structure = villinPath() if structure is None else structure
        self.trajectory = trajectory
        self._models = readModels(self.structure)
        selection = select(self.structure, self._models.topology, water, ions)
        self.atoms = selection.atoms
        self.names = [nameAtom(atom) for atom in self._models.topology.atoms()]
        self.notes = []
        self._makeForce(selection.topology, self._models.positions[0][self.atoms], radii)
        self._finder = ClashFinder(self.force)
        self.frameCount = len(self._models.positions)
        if trajectory is not None:
            self._openTrajectory()

    def _makeForce(self, topology, positions, radii):
        graph = BondGraph(topology, positions)
        self.radii = defaultRadii(graph) if radii is None else radii
        # Torsions do not change what clashes; with them, the engine has less to compute anew for each frame.
        torsions = searchTorsions(graph, topology, ("phi", "psi", "chi")).torsions
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            self.force = createStericExclusionForce(topology, positions, self.radii, torsions, unknownRadius=0)
        self.notes += [str(warning.message) for warning in caught]
        radiusZero = ~(radiiOf(self.force) > 0)
        self.checkedCount = int((~radiusZero).sum())
        if self.checkedCount == 0:
            raise InputError(f"{self.structure}: there is no atom with a known radius")
        for number in np.flatnonzero(radiusZero):
            if graph.elementNumber(number) > 1:
                name = self.names[self.atoms[number]]
                self.notes.append(f"{name} is not looked at: no radius is known for {graph.atoms[number].element.name}")

    def _openTrajectory(self):
        self._trajectory = Trajectory(self.trajectory)
        self.frameCount = self._trajectory.frameCount
        announced, held = self._trajectory.announced, self.frameCount
        if announced is not None and held is not None and announced > held:
            self.notes.append(f"{self.trajectory}: its header tells of {announced:,} frames, but it holds {held:,}")

    def __iter__(self):
        frames = self._modelPositions() if self.trajectory is None else self._trajectoryPositions()
        for index, positions in enumerate(frames):
            clashes = self._finder.find(positions[self.atoms], self.names, self.atoms)
            yield FrameClashes(index, clashes, 1000 * len(clashes) / self.checkedCount)

    def _modelPositions(self):
        yield from self._models.positions
        if self._models.damage is not None:
            raise self._models.damage

    def _trajectoryPositions(self):
        with self._trajectory as frames:
            for index, positions in enumerate(frames):
                if len(positions) != len(self.names):
                    raise InputError(
                        f"{self.trajectory}: has {len(positions):,} atoms, but {self.structure} has {len(self.names):,}"
                    )
                checkFinite(positions, self.names, f"{self.trajectory}: frame {index} (from 0)")
                yield positions


class ClashFinder:
    """Finds the clashes by a StericExclusionForce at any positions, in a Context of its own."""

    def __init__(self, force):
        system = openmm.System()
        for _ in range(force.getNumParticles()):
            system.addParticle(1.0)
        system.addForce(force)
        self._force = force
        platform = openmm.Platform.getPlatformByName("Reference")
        self._context = openmm.Context(system, openmm.VerletIntegrator(0.001), platform)

    def find(self, positions, names, particles=None):
        """Return the list of Clash at positions, a float64 array of shape (n, 3) in nm.

        names : list of AtomName; particles : for each particle of the force its index among the names, if not the same
        """
        self._context.setPositions(positions)
        return nameClashes(*self._force.getClashes(self._context), names, particles)


def nameClashes(pairs, overlaps, names, particles=None):
    """Return what StericExclusionForce.getClashes() gives as a list of Clash."""
    if particles is not None:
        pairs = particles[pairs]
    return [
        Clash(particle1, particle2, names[particle1], names[particle2], overlap)
        for (particle1, particle2), overlap in zip(pairs.tolist(), overlaps.tolist(), strict=True)
    ]


def radiiOf(force):
    """Return the radii (nm) of the particles of a StericExclusionForce as a float64 array."""
    parameters = [force.getParticleParameters(particle) for particle in range(force.getNumParticles())]
    return np.array([radius.value_in_unit(openmm.unit.nanometer) for radius, _ in parameters], dtype=np.float64)
