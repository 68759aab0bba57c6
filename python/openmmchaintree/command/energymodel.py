"""The energy that a run samples with: files of OpenMM's ForceField, a temperature, a cutoff."""

import os
from pathlib import Path

import numpy as np
import openmm
import openmm.app
from openmm import unit
from openmm.app import element

from ..bonds import BondGraph
from ..errors import InputError
from ..naming import describeResidue, nameAtom
from ..nearnames import didYouMean
from ..notes import Note, found
from ..openmmchaintree import StericExclusionForce
from ..residues import isMirrored, isWater
from ..solute import subset
from ..structures.filekinds import rootOfXML
from ..structures.structure import readStructure
from .energysettings import EnergySettings
from .misfits import describeMisfits, firstSentence, templatesOf
from .templatenames import nameByTemplates

# Steric modes.
OFF, HARD = "off", "hard"

# The class name of an implicit solvent Force contains one of these.
_SOLVENTS = ("GB", "Kirkwood")

# Cutoff (nm) and largest number of iterations for relaxing added hydrogens.
_RELAXING_CUTOFF = 1.0
_RELAXING_ITERATIONS = 100

# The energy (kJ/mol) of dihedrals that are imposed on added atoms.
_IMPOSED = "2000*(1-cos(theta-wanted))"

# The largest number of iterations of --minimize.
_MINIMIZING_ITERATIONS = 1000


class EnergyModel(EnergySettings):
    """The force field, temperature and options that define the energy of a run."""

    def __init__(
        self,
        files,
        temperature,
        cutoff=None,
        hydrogensAreAdded=False,
        someAreLeftOut=False,
        isPrepared=False,
        **settings,
    ):
        """Read the files. Errors give other advice if hydrogens are added, atoms omitted, or structures prepared.

        settings : as for EnergySettings

        Raises
        ------
        InputError
            if one of them cannot be read, or is not a force field
        """
        super().__init__(files, temperature, cutoff, **settings)
        self._done = hydrogensAreAdded, someAreLeftOut, isPrepared
        for file in self.files:
            if os.path.isfile(file):
                _checkForceField(file)
        try:
            self._forceField = openmm.app.ForceField(*self.files)
        except Exception as error:  # OpenMM passes on any exception of its parsers
            near = next(filter(None, map(_nearFile, self.files)), "")
            raise InputError(f"--forcefield {' '.join(self.files)}: {firstSentence(error)}{near}") from error

    def __str__(self):
        return self.describe(", ".join(self.files))

    def read(self, path, model):
        """Read a model of a structure file, without water and ions: a Structure."""
        return readStructure(path, model)

    def makeSystem(self, structure):
        """Make the System of a Structure; return it with a list of Note.

        Raises
        ------
        InputError
            if the force field does not fit
        """
        system, notes = self._fitSystem(structure, self.cutoff)
        notes += notesOnForces(system, structure.topology, f"--forcefield {' '.join(self.files)}")
        if any(isinstance(force, openmm.CMAPTorsionForce) for force in system.getForces()):
            mirrored = [residue for residue in structure.topology.residues() if isMirrored(residue.name)]
            kind = "D-amino acids that the force field's maps of φ and ψ (CMAP) take for L-amino acids"
            notes += found([Note(kind, map(describeResidue, mirrored))])
        return system, notes

    def hasTemplateOf(self, residue):
        """Whether the force field has a template that the name of a residue, or the element of an ion, suggests."""
        return bool(templatesOf(self._forceField, residue))

    def hydrogensOf(self, name):
        """Return the hydrogens of the template of a name, with the atoms that bind them, as pairs of names."""
        template = self._forceField._templates.get(name)
        if template is None:
            return []
        bonds = [pair for bond in template.bonds for pair in (bond, bond[::-1])]
        pairs = [(template.atoms[first], template.atoms[second]) for first, second in bonds]
        return [(atom.name, parent.name) for atom, parent in pairs if atom.element == element.hydrogen]

    def hasPhosphateEnds(self):
        """Whether the force field has nucleotides, or patches of them, with a phosphate at the 5' end."""
        templates = self._forceField._templates.values()
        names = [[atom.name for atom in template.atoms] for template in templates]
        return any(patch.upper().startswith("5P") for patch in self._forceField._patches) or any(
            {"P", "O5'", "C5'"} <= set(atoms) and atoms.index("P") not in template.externalBonds
            for atoms, template in zip(names, templates, strict=True)
        )

    def relax(self, structure, atoms, iterations=_RELAXING_ITERATIONS, shapes=()):
        """Return the positions of a Structure with some of its atoms, such as added hydrogens, relaxed.

        The solvent is omitted: it takes most of the time and matters little here. Shapes, if given, are first imposed.

        Raises
        ------
        InputError
            if the force field does not fit
        """
        system, _ = self._fitSystem(structure, _RELAXING_CUTOFF)
        for index in reversed(range(system.getNumForces())):
            if isSolvent(system.getForce(index)):
                system.removeForce(index)
        positions = structure.positions
        if shapes:
            imposing = openmm.CustomTorsionForce(_IMPOSED)
            imposing.addPerTorsionParameter("wanted")
            for shape in shapes:
                imposing.addTorsion(*shape.particles, [shape.angle])
            index = system.addForce(imposing)
            positions, _ = _minimize(system, positions, atoms, iterations)
            system.removeForce(index)
        return _minimize(system, positions, atoms, iterations)[0]

    def minimize(self, structure, atoms):
        """Minimize the energy of a Structure by moving some of its atoms, an int array.

        Returns
        -------
        (n, 3) float64 array, nm
            the positions
        (float, float), kJ/mol
            the energy before and after

        Raises
        ------
        InputError
            if the force field does not fit, or the energy is not a number
        """
        system, _ = self._fitSystem(structure, self.cutoff)
        return minimizeSystem(system, structure.positions, atoms)

    def _fitSystem(self, structure, cutoff):
        """Make a System, without bonds of metals if necessary; return it with a list of Note."""
        try:
            return self._createSystem(structure.topology, cutoff), []
        except Exception as first:  # OpenMM passes on any exception of scripts in these files
            error = first
        topology, names = _withoutMetalBonds(structure)
        if names:  # most force fields have metals as free ions
            try:
                system = self._createSystem(topology, cutoff)
                return system, [Note("bonds of metals that the force field does not have", names)]
            except Exception as second:
                error = second
        raise InputError(describeMisfits(self._forceField, self.files, topology, error, *self._done)) from error

    def _createSystem(self, topology, cutoff):
        named = nameByTemplates(self._forceField, topology)
        return self._forceField.createSystem(named, **self.argumentsOf(topology, cutoff))


def minimizeSystem(system, positions, atoms):
    """Do the work of EnergyModel.minimize on a System, whose masses change."""
    positions, energies = _minimize(system, positions, atoms, _MINIMIZING_ITERATIONS)
    if not np.isfinite([*energies, *positions.ravel()]).all():
        raise InputError("--minimize: the energy is not a number; are two atoms at the same place?")
    return positions, energies


def _minimize(system, positions, atoms, iterations):
    """Return positions (nm) at which the energy of a System is lower, and this energy before and after (kJ/mol).

    atoms : the atoms that move, an int array; iterations : the largest number
    """
    moving = set(atoms.tolist())
    for particle in range(system.getNumParticles()):
        if particle not in moving:
            system.setParticleMass(particle, 0)
    context = openmm.Context(system, openmm.VerletIntegrator(0.001), *repeatablePlatform())
    context.setPositions(positions)
    before = context.getState(energy=True).getPotentialEnergy()
    openmm.LocalEnergyMinimizer.minimize(context, maxIterations=iterations)
    state = context.getState(positions=True, energy=True)
    found = positions.copy()
    found[atoms] = state.getPositions(asNumpy=True).value_in_unit(unit.nanometer)[atoms]
    energies = before, state.getPotentialEnergy()
    return found, tuple(energy.value_in_unit(unit.kilojoule_per_mole) for energy in energies)


def _nearFile(name):
    """Return the end of an error on a file of a force field: a name that was probably meant, if there is none."""
    folders = openmm.app.forcefield._getDataDirectories()
    if any(os.path.isfile(os.path.join(folder, name)) for folder in ("", *folders)):
        return ""
    known = {str(path.relative_to(folder)) for folder in folders for path in Path(folder).rglob("*.xml")}
    known |= {str(path) for path in Path(os.path.dirname(name)).glob("*.xml")}
    # A name without its folder or its ending, or the beginning of a name.
    alone = [each for each in sorted(known) if os.path.basename(each).removesuffix(".xml") == name.removesuffix(".xml")]
    alone += [each for each in sorted(known, key=len) if name and os.path.basename(each).startswith(name)]
    return f"; did you mean {alone[0]}?" if alone else didYouMean(name, known)


def repeatablePlatform():
    """Return the fastest platform that every machine has, with properties that make it reproducible.

    The order of sums varies with several threads.
    """
    return openmm.Platform.getPlatformByName("CPU"), {"Threads": "1"}


def _checkForceField(file):
    """Refuse a file that is not one of a ForceField, with what it seems to be."""
    if rootOfXML(file) == "System":
        raise InputError(f"--forcefield {file}: is a serialized System, which --system reads")
    if not file.lower().endswith(".xml"):
        raise InputError(f"--forcefield {file}: is not an XML file; name the structure before this option")


def isSolvent(force):
    """Whether a Force is an implicit solvent."""
    return any(name in type(force).__name__ for name in _SOLVENTS)


def notesOnForces(system, topology, source):
    """Return a list of Note on the Forces of a System; source names it in messages.

    Raises
    ------
    InputError
        if it has a StericExclusionForce
    """
    if any(StericExclusionForce.isinstance(force) for force in system.getForces()):
        raise InputError(f"{source}: the command adds its own StericExclusionForce")
    if any(map(isSolvent, system.getForces())) or any(map(isWater, topology.residues())):
        return []
    return [Note("the energy is computed in vacuum: there is no water, and no file adds a solvent")]


def _withoutMetalBonds(structure):
    """Return the Topology of a Structure without bonds between metals and other residues, and the names of these."""
    topology = structure.topology
    metalBonds = set(BondGraph(topology, structure.positions).metalBonds)
    if not metalBonds:
        return topology, []
    atoms = list(topology.atoms())
    bonds = [(bond[0].index, bond[1].index) for bond in topology.bonds()]
    names = [" – ".join(str(nameAtom(atoms[atom])) for atom in bond) for bond in sorted(metalBonds)]
    return subset(topology, atoms, [bond for bond in bonds if tuple(sorted(bond)) not in metalBonds]), names
