"""A System that the user brings, and the structure that belongs to it."""

import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np
import openmm
from openmm import unit

from ..beadnetwork import BeadNetwork
from ..bondsearch import BondSearch
from ..errors import InputError
from ..images import boxOf, vectorsOf
from ..notes import Note, listFirst
from ..solute import subset
from ..structures.coordinatefile import hasCoordinatesOnly, readCoordinates
from ..structures.structure import Structure, checkPositions, readModels, spaceGroupOf
from ..systemreading import bondsOf, bondsOfBareAtoms, drudeParticles, isPeriodic
from .atomfit import compareAtoms
from .energymodel import minimizeSystem, notesOnForces
from .energysettings import EnergySettings
from .misfits import firstSentence
from .systemfiles import asVectors, checkFiles, kindOf

_BAROSTAT = "Barostat"


class SystemOptions(NamedTuple):
    """The user's options that define how a file of a System is read.

    parameters : list of str or None, files of CHARMM; include : str or None, a folder of GROMACS's files
    implicit : str or None, one of IMPLICIT_SOLVENTS; periodic : bool, whether pairs count in all images of the box
    """

    parameters: list[str] | None = None
    include: str | None = None
    implicit: str | None = None
    periodic: bool = False


class GivenSystem(EnergySettings):
    """The System of a file, and the settings of a run. All its particles are sampled or stand still: none is left out.

    Call `read` first.
    """

    def __init__(self, path, temperature, options, cutoff=None, periodicMethod=None, **settings):
        """Find out what kind of file it is.

        options : SystemOptions; periodicMethod : None for PME; settings : as for EnergySettings

        Raises
        ------
        InputError
            if it is of no known kind, or an option belongs to other files
        """
        method = periodicMethod or "PME"
        super().__init__([path, *(options.parameters or [])], temperature, cutoff, periodicMethod=method, **settings)
        self._path = path
        self._options = options
        self._reader = kindOf(path)
        for name in ("parameters", "include", "implicit"):
            if getattr(options, name) is not None and name not in self._reader.options:
                raise InputError(f"--{name} does not apply to {path}, {self._reader.kind} file")
        for option, value in (("--nonbonded-cutoff", cutoff), ("--nonbonded-method", periodicMethod)):
            if value is not None and self._reader.isSerialized:
                raise InputError(f"{option} does not apply to {path}: a serialized System has its own")
        checkFiles(options.parameters or ())

    def __str__(self):
        files = ", ".join([*self.files, *([self._options.implicit] if self._options.implicit else [])])
        return self.describe(files, "pairs as in the file" if self._isSerialized else None)

    @property
    def _isSerialized(self):
        return self._reader.isSerialized

    def checkPeriodic(self):
        """Raise an InputError if this energy cannot be sampled in a periodic box."""
        if not self._isSerialized:
            super().checkPeriodic()

    def read(self, path, model):
        """Read the structure that belongs to the System: all its atoms, in their order.

        Returns
        -------
        Structure

        Raises
        ------
        InputError
            if the structure, or the System, cannot be read, or they do not fit
        """
        if path is None:
            raise InputError(f"--system {self._path}: name the structure, too, before this option")
        if hasCoordinatesOnly(path):
            if self._isSerialized:
                raise InputError(f"{path}: has no names of atoms, which {self._path} lacks, too: name a PDB file")
            if model > 0:
                raise InputError(f"{path}: there is no model {model} (from 0), but 1 in all")
            found, (positions, box), notes, alternates, spaceGroup = None, readCoordinates(path), [], [], ""
        else:
            models = readModels(path, model)
            found, positions, box = models.topology, models.positions[0], boxOf(models.topology)
            notes, alternates, spaceGroup = models.notes, models.alternates, spaceGroupOf(models)
        topology = found
        try:
            opened = self._reader(self._path, asVectors(box), self._options)
            if not self._isSerialized:
                topology = opened.topology
                box = boxOf(topology)
                if not self._options.periodic:
                    topology.setPeriodicBoxVectors(None)
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                self._system = opened.createSystem(self.argumentsOf(topology, self.cutoff))
        except InputError:
            raise
        except Exception as error:  # OpenMM passes on any exception of its parsers
            raise InputError(self._explain(error)) from error
        compareAtoms(path, found, len(positions), self._path, topology, self._system)
        if self._isSerialized:
            box = self._boxOfSystem(path, box)
        checkPositions(positions, topology, path)
        self._checkForces()
        whole, positions, more = self._completeBonds(path, topology, positions, box)
        name = Path(Path(path).name.removesuffix(".gz")).stem
        return Structure(name, whole, positions, alternates, [*notes, *_asNotes(caught), *more], box, spaceGroup)

    def makeSystem(self, structure):
        """Return the System and a list of Note."""
        notes = notesOnForces(self._system, structure.topology, f"--system {self._path}")
        # In a periodic box, any molecules may be the solvent.
        return openmm.XmlSerializer.clone(self._system), [] if self._options.periodic else notes

    def minimize(self, structure, atoms):
        """Minimize the energy as EnergyModel.minimize does."""
        system, _ = self.makeSystem(structure)
        if self._options.periodic:
            system.setDefaultPeriodicBoxVectors(*vectorsOf(structure.box))
        return minimizeSystem(system, structure.positions, atoms)

    def _explain(self, error):
        text = firstSentence(error)
        if "#include" in text:
            text += "; --include names the folder that has it"
        return f"--system {self._path}: OpenMM cannot read {self._reader.kind} file like this ({text})"

    def _boxOfSystem(self, path, box):
        """Return the box of a serialized System whose Forces use images: that of the structure, or else its own."""
        if isPeriodic(self._system) != self._options.periodic:
            uses, option = ("needs --periodic", "use") if not self._options.periodic else ("cannot have it", "use no")
            raise InputError(f"--system {self._path}: {uses}, since its Forces {option} periodic images")
        if box is None and self._options.periodic:
            vectors = self._system.getDefaultPeriodicBoxVectors()
            box = np.array([vector.value_in_unit(unit.nanometer) for vector in vectors])
        return box

    def _checkForces(self):
        """Refuse Forces that a run by the command cannot sample."""
        for force in self._system.getForces():
            if _BAROSTAT in type(force).__name__:
                raise InputError(f"--system {self._path}: {type(force).__name__} changes the box: leave it out")
        if drudeParticles(self._system):
            raise InputError(f"--system {self._path}: has Drude particles, whose response torsion moves do not sample")

    def _completeBonds(self, path, topology, positions, box):
        """Return a Topology with all bonds, positions of whole molecules, and a list of Note."""
        topology.setPeriodicBoxVectors(asVectors(box))
        known = bondsOf(self._system)
        try:
            search = BondSearch(topology, positions, bondsOfBareAtoms(topology, self._system, known))
        except InputError as error:
            raise InputError(f"{path}: {error}") from error
        pairs = search.coinciding or search.overlong
        if pairs:
            how = "at one place" if search.coinciding else "far apart"
            names = listFirst(map(search.describePair, pairs), "; ")
            raise InputError(f"{path}: atoms bonded in {self._path} are {how} ({names}): do the files belong together?")
        if BeadNetwork(topology, self._system, known, search.positions).beads:
            raise InputError(f"--system {self._path}: has beads, which only the Python package samples")
        topology.setPeriodicBoxVectors(None)
        return subset(topology, list(topology.atoms()), search.bonds), search.positions, search.notes


def _asNotes(caught):
    """Return the warnings of OpenMM's readers as a list of Note, without repeats."""
    return [Note(f"OpenMM warns: {text}") for text in dict.fromkeys(str(warning.message) for warning in caught)]
