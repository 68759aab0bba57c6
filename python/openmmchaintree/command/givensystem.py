"""A System that the user brings, and the structure that belongs to it."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import openmm
from openmm import app, unit

from ..beadnetwork import BeadNetwork
from ..bondsearch import BondSearch
from ..errors import InputError
from ..images import boxOf, vectorsOf
from ..naming import describeAtom
from ..notes import listFirst
from ..residues import isPolymer
from ..structures.coordinatefile import hasCoordinatesOnly, readCoordinates
from ..structures.structure import Structure, checkPositions, readModels, spaceGroupOf
from ..systemreading import bondsOf, bondsOfBareAtoms, drudeParticles, isPeriodic
from .energymodel import minimizeSystem, notesOnForces
from .energysettings import EnergySettings
from .misfits import firstSentence
from .systemfiles import asVectors, checkFiles, kindOf

_BAROSTAT = "Barostat"

# Masses (Da) of an element differ by less among force fields. Hydrogens may get more mass, from their heavy atoms.
_MASS_TOLERANCE = 0.3
_HEAVIEST_HYDROGEN = 4.5
_MOST_MOVED = 3 * (_HEAVIEST_HYDROGEN - 1)


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

    def __init__(self, path, temperature, cutoff=None, options=SystemOptions(), **settings):  # noqa: B008 (a tuple)
        """Find out what kind of file it is.

        settings : as for EnergySettings

        Raises
        ------
        InputError
            if it is of no known kind, or an option belongs to other files
        """
        super().__init__([path, *(options.parameters or [])], temperature, cutoff, **settings)
        self._path = path
        self._options = options
        self._reader = kindOf(path)
        for name in ("parameters", "include", "implicit"):
            if getattr(options, name) is not None and name not in self._reader.options:
                raise InputError(f"--{name} does not apply to {path}, {self._reader.kind} file")
        if cutoff is not None and self._reader.isSerialized:
            raise InputError(f"--nonbonded-cutoff does not apply to {path}: a serialized System has its own cutoff")
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
            self._system = opened.createSystem(self.argumentsOf(topology, self.cutoff))
        except InputError:
            raise
        except Exception as error:  # OpenMM passes on any exception of its parsers
            raise InputError(self._explain(error)) from error
        _compareAtoms(path, found, len(positions), self._path, topology, self._system)
        if self._isSerialized:
            box = self._boxOfSystem(path, box)
        checkPositions(positions, topology, path)
        self._checkForces()
        whole, positions = self._completeBonds(path, topology, positions, box)
        return Structure(Path(path).stem, whole, positions, alternates, notes, box, spaceGroup)

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
        """Return a Topology with all bonds and with polymers as chains, and positions of whole molecules."""
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
        whole = _withChains(topology, search.bonds)
        topology.setPeriodicBoxVectors(None)
        return whole, search.positions


def _compareAtoms(path, found, count, systemPath, topology, system):
    """Refuse a structure whose atoms differ from those of a System; name the first that differs.

    found : the Topology of the structure, or None; topology : the Topology of the System, or `found`
    """
    particles = system.getNumParticles()
    difference = None
    if found is topology:
        difference = _differenceOfMasses(list(found.atoms()), system)
    elif found is not None:
        difference = _differenceOfElements(list(found.atoms()), list(topology.atoms()))
    if count == particles and difference is None:
        return
    counts = f"{count:,} atoms" if count == particles else f"{count:,} atoms, not {particles:,}"
    first = "" if difference is None else f"; the first that differs is number {difference}"
    raise InputError(f"{path}: does not fit {systemPath}: it has {counts}{first}")


def _differenceOfElements(atoms, others):
    for atom, other in zip(atoms, others, strict=False):
        if None not in (atom.element, other.element) and atom.element is not other.element:
            return f"{atom.index} (from 0), {describeAtom(atom)}, there {describeAtom(other)}"
    return None


def _differenceOfMasses(atoms, system):
    """Compare elements with masses, up to masses that move from heavy atoms to their hydrogens."""
    for atom, particle in zip(atoms, range(system.getNumParticles()), strict=False):
        mass = system.getParticleMass(particle).value_in_unit(unit.dalton)
        if mass == 0 or atom.element is None:  # fixed, or a virtual site
            continue
        expected = atom.element.mass.value_in_unit(unit.dalton)
        isLight = mass < _HEAVIEST_HYDROGEN
        isTooHeavy = mass > expected + _MASS_TOLERANCE
        if (isTooHeavy and not (atom.element is app.element.hydrogen and isLight)) or (
            mass < expected - _MOST_MOVED - _MASS_TOLERANCE
        ):
            return f"{atom.index} (from 0), {describeAtom(atom)}, there of {mass:g} Da"
    return None


def _withChains(topology, bonds):
    """Return a copy of a Topology with these bonds, in which another chain begins where no bond joins residues."""
    joined = set()
    atoms = list(topology.atoms())
    for first, second in bonds:
        joined.add((atoms[first].residue.index, atoms[second].residue.index))
    copy = app.Topology()
    copies, last, newChain = [], None, None
    for residue in topology.residues():
        isPart = last is not None and residue.chain is last.chain and isPolymer(residue) == isPolymer(last)
        if not isPart or (isPolymer(residue) and (last.index, residue.index) not in joined):
            newChain = copy.addChain(residue.chain.id)
        newResidue = copy.addResidue(residue.name, newChain, residue.id, residue.insertionCode)
        copies += [copy.addAtom(atom.name, atom.element, newResidue, atom.id) for atom in residue.atoms()]
        last = residue
    orders = {frozenset(atom.index for atom in bond[:2]): (bond.type, bond.order) for bond in topology.bonds()}
    for first, second in bonds:
        copy.addBond(copies[first], copies[second], *orders.get(frozenset((first, second)), (None, None)))
    return copy
