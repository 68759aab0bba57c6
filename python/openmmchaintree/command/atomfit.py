"""Comparing the atoms of a structure with the particles of a System."""

from openmm import app, unit

from ..errors import InputError
from ..naming import describeAtom

# Masses in Da. Those of an element differ by less among force fields.
_MASS_TOLERANCE = 0.3

# Some Systems move mass from heavy atoms to their hydrogens, up to three; in others, united atoms have theirs.
_HYDROGEN = 1.008
_HEAVIEST_HYDROGEN = 4.5
_MOST_MOVED = 3 * (_HEAVIEST_HYDROGEN - 1)
_UNITED_TOLERANCE = 0.015  # nitrogen is only 0.02 lighter than CH2


def compareAtoms(path, found, count, systemPath, topology, system):
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
    """Compare the elements of atoms with the masses of particles."""
    masses = [system.getParticleMass(i).value_in_unit(unit.dalton) for i in range(system.getNumParticles())]
    pairs = [(atom, mass) for atom, mass in zip(atoms, masses, strict=False) if atom.element is not None and mass > 0]
    lightest = min((mass for atom, mass in pairs if _isHydrogen(atom)), default=_HYDROGEN)
    areMoved = _HYDROGEN + _MASS_TOLERANCE < lightest < _HEAVIEST_HYDROGEN
    for atom, mass in pairs:
        if not _fits(atom, mass, areMoved):
            return f"{atom.index} (from 0), {describeAtom(atom)}, there of {mass:g} Da"
    return None


def _isHydrogen(atom):
    return atom.element is app.element.hydrogen


def _fits(atom, mass, areMoved):
    """Whether a mass may be that of an atom, in a System in which heavy atoms have given mass to hydrogens or not."""
    excess = mass - atom.element.mass.value_in_unit(unit.dalton)
    if abs(excess) < _MASS_TOLERANCE:
        return True
    if _isHydrogen(atom):
        return areMoved and mass < _HEAVIEST_HYDROGEN
    isUnited = any(abs(excess - count * _HYDROGEN) < _UNITED_TOLERANCE for count in (1, 2, 3))
    return isUnited or (areMoved and -_MOST_MOVED < excess < 0)
