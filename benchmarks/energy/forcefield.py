"""A System as the contestants' program reads it: what a force field says of each particle, pair and bond."""

from typing import NamedTuple

import numpy as np
import openmm
from openmm import unit
from openmmchaintree.errors import InputError

# Kinds of terms by the program's numbers.
_BOND, _ANGLE, _TORSION, _RYCKAERT_BELLEMANS, _EXCEPTION = 0, 1, 2, 3, 5

_NO_ENERGY = (openmm.CMMotionRemover,)


class TermSet(NamedTuple):
    """Terms of one kind.

    kind : int; particles : (n, k) int array; parameters : (n, m) float64 array, in nm, rad, kJ/mol
    """

    kind: int
    particles: np.ndarray
    parameters: np.ndarray


class ForceFieldTerms(NamedTuple):
    """The energy of a System.

    cutoff, switching : float, nm, 0 if there is none; dielectric : float; particles : (n, 3) float64 array, charges,
    sigmas, epsilons; exclusions : (m, 2) int array; termSets : list of TermSet
    """

    cutoff: float
    switching: float
    dielectric: float
    particles: np.ndarray
    exclusions: np.ndarray
    termSets: list[TermSet]

    def write(self, path):
        """Write it as a file for the program."""
        with open(path, "w", encoding="ascii") as file:
            counts = f"particles {len(self.particles)} exclusions {len(self.exclusions)} sets {len(self.termSets)}"
            print(f"chaintree-energy 1\n{counts}", file=file)
            print(repr(self.cutoff), repr(self.switching), repr(self.dielectric), file=file)
            for row in self.particles.tolist():
                print(*map(repr, row), file=file)
            for pair in self.exclusions.tolist():
                print(*pair, file=file)
            for kind, particles, parameters in self.termSets:
                print(kind, len(particles), particles.shape[1], parameters.shape[1], file=file)
                for ofTerm, values in zip(particles.tolist(), parameters.tolist(), strict=True):
                    print(*ofTerm, *map(repr, values), file=file)


def readSystem(system):
    """Return the ForceFieldTerms of a System with one NonbondedForce and bonded Forces.

    Raises
    ------
    InputError
        if it has a Force that the program has no terms for
    """
    nonbonded, termSets = None, []
    for force in system.getForces():
        if isinstance(force, openmm.NonbondedForce):
            nonbonded = force
        elif type(force) in _BONDED:
            termSets.append(_BONDED[type(force)](force))
        elif not isinstance(force, _NO_ENERGY):
            raise InputError(f"the benchmark knows no terms of a {force.getName()}")
    if nonbonded is None:
        raise InputError("the System has no NonbondedForce")
    return _readNonbonded(nonbonded, termSets)


def _readNonbonded(force, termSets):
    hasCutoff = force.getNonbondedMethod() == openmm.NonbondedForce.CutoffNonPeriodic
    if not hasCutoff and force.getNonbondedMethod() != openmm.NonbondedForce.NoCutoff:
        raise InputError("the benchmark knows no periodic NonbondedForce")
    particles = [_values(force.getParticleParameters(i)) for i in range(force.getNumParticles())]
    exceptions = [_values(force.getExceptionParameters(i)) for i in range(force.getNumExceptions())]
    active = [values for values in exceptions if values[2] != 0 or values[4] != 0]
    hasSwitch = hasCutoff and force.getUseSwitchingFunction()
    return ForceFieldTerms(
        cutoff=_values([force.getCutoffDistance()])[0] if hasCutoff else 0.0,
        switching=_values([force.getSwitchingDistance()])[0] if hasSwitch else 0.0,
        dielectric=float(force.getReactionFieldDielectric()),
        particles=np.array(particles, dtype=np.float64).reshape(-1, 3),
        exclusions=np.array([values[:2] for values in exceptions], dtype=int).reshape(-1, 2),
        termSets=[*termSets, _makeSet(_EXCEPTION, active, 2)],
    )


def _makeSet(kind, rows, count):
    """Make the TermSet of rows of so many particles and of parameters."""
    particles = np.array([row[:count] for row in rows], dtype=int).reshape(len(rows), count)
    parameters = np.array([row[count:] for row in rows], dtype=np.float64).reshape(len(rows), -1)
    return TermSet(kind, particles, parameters)


def _values(quantities):
    """Return numbers in OpenMM's units."""
    return [
        value.value_in_unit_system(unit.md_unit_system) if unit.is_quantity(value) else value for value in quantities
    ]


def _readBonds(force):
    return _makeSet(_BOND, [_values(force.getBondParameters(i)) for i in range(force.getNumBonds())], 2)


def _readAngles(force):
    return _makeSet(_ANGLE, [_values(force.getAngleParameters(i)) for i in range(force.getNumAngles())], 3)


def _readTorsions(force):
    return _makeSet(_TORSION, [_values(force.getTorsionParameters(i)) for i in range(force.getNumTorsions())], 4)


def _readRyckaertBellemans(force):
    rows = [_values(force.getTorsionParameters(i)) for i in range(force.getNumTorsions())]
    return _makeSet(_RYCKAERT_BELLEMANS, rows, 4)


_BONDED = {
    openmm.HarmonicBondForce: _readBonds,
    openmm.HarmonicAngleForce: _readAngles,
    openmm.PeriodicTorsionForce: _readTorsions,
    openmm.RBTorsionForce: _readRyckaertBellemans,
}
