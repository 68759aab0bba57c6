"""Properties of a model that its System holds: pair energies, images, fixed particles, bonds the Topology lacks."""

import re

import numpy as np
import openmm
from openmm import unit

# The name of the class of a Force between all pairs of particles has one of these.
_PAIR_FORCES = ("Nonbonded", "GayBerne", "Vdw", "Multipole")

# The text of a harmonic energy of bonds: a product of names and numbers, times the square of r less a length.
_FACTOR = r"[A-Za-z_0-9.]+(?:[*/][A-Za-z_0-9.]+)*"
_HARMONIC = re.compile(rf"(?:{_FACTOR}\*)?\(r-[A-Za-z_0-9.]+\)\^2(?:[*/]{_FACTOR})?")


def checkParticles(topology, system):
    """Raise a ValueError if a System does not have the particles of a Topology."""
    particles, atoms = system.getNumParticles(), topology.getNumAtoms()
    if particles != atoms:
        raise ValueError(f"the System has {particles:,} particles, but the Topology {atoms:,} atoms")


def hasPairEnergies(system):
    """Whether a Force of a System gives pairs of particles an energy, as a force field does."""
    return any(word in type(force).__name__ for force in system.getForces() for word in _PAIR_FORCES)


def isPeriodic(system):
    """Whether a Force of a System uses periodic boundary conditions."""
    return any(map(_usesImages, system.getForces()))


def _usesImages(force):
    try:
        return force.usesPeriodicBoundaryConditions()
    except openmm.OpenMMException:  # not every Force can tell
        return False


def fixedParticles(system):
    """Return the particles of mass 0, without virtual sites, as an int array."""
    massless = [i for i in range(system.getNumParticles()) if system.getParticleMass(i).value_in_unit(unit.dalton) == 0]
    return np.array([i for i in massless if not system.isVirtualSite(i)], dtype=int)


def bondsOfBareAtoms(topology, system, bonds):
    """Return the System's bonds of atoms that have no bond in the Topology, such as Drude particles.

    They are taken from its `bonds`, as `bondsOf` returns them. A CustomBondForce, which may be a restraint,
    counts only for atoms without any other bond. Virtual sites need no bonds.

    Returns
    -------
    list of (int, int), lower index first, sorted
    """
    bonded = {atom.index for bond in topology.bonds() for atom in bond}
    bonded |= {particle for particle in range(system.getNumParticles()) if system.isVirtualSite(particle)}
    found = set()
    for pairs in ([bond[:2] for bond in bonds], customBondsOf(system)):
        new = {(min(pair), max(pair)) for pair in pairs if pair[0] not in bonded or pair[1] not in bonded}
        found |= new
        bonded |= {particle for pair in new for particle in pair}
    return sorted(found)


def bondsOf(system):
    """Return the bonds of the HarmonicBondForces, constraints and DrudeForces of a System.

    Returns
    -------
    list of (int, int, float, bool)
        two particles, a length in nm, and whether the bond is harmonic
    """
    bonds = [(*system.getConstraintParameters(i), False) for i in range(system.getNumConstraints())]
    for force in system.getForces():
        if isinstance(force, openmm.HarmonicBondForce):
            bonds += [(*force.getBondParameters(i)[:3], True) for i in range(force.getNumBonds())]
    bonds += [(drude, parent, 0 * unit.nanometer, False) for drude, parent in drudeParticles(system)]
    return [
        (first, second, length.value_in_unit(unit.nanometer), isSpring) for first, second, length, isSpring in bonds
    ]


def drudeParticles(system):
    """Return (Drude particle, parent) of the DrudeForces of a System."""
    forces = [force for force in system.getForces() if isinstance(force, openmm.DrudeForce)]
    return [tuple(force.getParticleParameters(i)[:2]) for force in forces for i in range(force.getNumParticles())]


def customBondsOf(system):
    """Return the pairs of particles of the CustomBondForces of a System."""
    return [pair for force in _customBondForces(system) for pair in _pairsOf(force)]


def harmonicCustomBondsOf(system):
    """Return the pairs, lower index first, of CustomBondForces whose energy is harmonic, as in elastic networks."""
    forces = [force for force in _customBondForces(system) if _HARMONIC.fullmatch(_withoutSpaces(force))]
    return [(min(pair), max(pair)) for force in forces for pair in _pairsOf(force)]


def _customBondForces(system):
    return [force for force in system.getForces() if isinstance(force, openmm.CustomBondForce)]


def _pairsOf(force):
    return [tuple(force.getBondParameters(i)[:2]) for i in range(force.getNumBonds())]


def _withoutSpaces(force):
    return "".join(force.getEnergyFunction().split()).rstrip(";")
