"""A System as the contestants' program reads it: what a force field says of each particle, pair and bond."""

import numpy as np
import openmm
from openmm import unit
from openmmchaintree.errors import InputError

# Bonded Forces: the program's number of their kind of terms, the particles of a term, and what their methods end with.
_BONDED = {
    openmm.HarmonicBondForce: (0, 2, "Bond"),
    openmm.HarmonicAngleForce: (1, 3, "Angle"),
    openmm.PeriodicTorsionForce: (2, 4, "Torsion"),
    openmm.RBTorsionForce: (3, 4, "Torsion"),
}
_EXCEPTION = 5


def writeEnergy(path, system):
    """Write the energy of a System with one NonbondedForce and bonded Forces as a file for the program.

    An InputError tells of a Force that the program has no terms for.
    """
    nonbonded, sets = None, []
    for force in system.getForces():
        if isinstance(force, openmm.NonbondedForce):
            nonbonded = force
        elif type(force) in _BONDED:
            kind, size, name = _BONDED[type(force)]
            sets.append((kind, size, _readAll(force, name)))
        elif not isinstance(force, openmm.CMMotionRemover):
            raise InputError(f"the benchmark knows no terms of a {force.getName()}")
    if nonbonded is None:
        raise InputError("the System has no NonbondedForce")
    exceptions = _readAll(nonbonded, "Exception")
    sets.append((_EXCEPTION, 2, [values for values in exceptions if values[2] != 0 or values[4] != 0]))
    particles = _readAll(nonbonded, "Particle")
    with open(path, "w", encoding="ascii") as file:
        counts = f"particles {len(particles)} exclusions {len(exceptions)} sets {len(sets)}"
        print(f"chaintree-energy 1\n{counts}", file=file)
        print(*_readCutoffs(nonbonded), nonbonded.getReactionFieldDielectric(), file=file)
        for values in [*particles, *(values[:2] for values in exceptions)]:
            print(*map(repr, values), file=file)
        for kind, size, terms in sets:
            print(kind, len(terms), size, len(terms[0]) - size if terms else 0, file=file)
            for values in terms:
                print(*map(repr, values), file=file)


def _readCutoffs(force):
    """Return the cutoff and the switching distance, nm, 0 if there is none."""
    if force.getNonbondedMethod() == openmm.NonbondedForce.NoCutoff:
        return 0.0, 0.0
    if force.getNonbondedMethod() != openmm.NonbondedForce.CutoffNonPeriodic:
        raise InputError("the benchmark knows no periodic NonbondedForce")
    switching = force.getSwitchingDistance()._value if force.getUseSwitchingFunction() else 0.0
    return force.getCutoffDistance()._value, switching


def _readAll(force, name):
    """Return the parameters of all bonds, angles and so on, in OpenMM's units."""
    count, read = getattr(force, f"getNum{name}s")(), getattr(force, f"get{name}Parameters")
    return [[_plain(value) for value in read(i)] for i in range(count)]


def _plain(value):
    value = value.value_in_unit_system(unit.md_unit_system) if unit.is_quantity(value) else value
    return float(value) if isinstance(value, np.floating) else value
