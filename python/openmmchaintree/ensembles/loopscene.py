"""A loop between fixed parts: its System, its spheres, and its growth."""

import copy
import warnings
from typing import NamedTuple

import numpy as np
import openmm

from ..coil import coilDensities, createCoilForce
from ..densities import rotamerDensities
from ..errors import InputError
from ..loopnames import findLoop
from ..notes import NoteWarning
from ..openmmchaintree import LoopGrowth, StericExclusionForce, TorsionDensity
from ..sterics import createStericExclusionForce

BACKBONE = ("N", "CA", "C", "O")


class LoopScene(NamedTuple):
    """A System in which only a loop moves.

    system : openmm.System, with masses of 0 for all other atoms; its Forces are the energies of the model
    force : StericExclusionForce, which the System does not have yet
    growth : LoopGrowth
    backbone : array of int, the atoms N, CA, C and O of the loop; moving : array of int, all its atoms
    chis : list of int, torsions of side chains; rotamers : DrawnTorsions of these, or None
    """

    system: openmm.System
    force: StericExclusionForce
    growth: LoopGrowth
    backbone: np.ndarray
    moving: np.ndarray
    chis: list
    rotamers: object


def makeLoopScene(topology, positions, name, model, temperature, forceField=None):
    """Make the LoopScene of a loop (str, as for `findLoop`).

    model : str, "coil" or "spheres", at a temperature (K); or None, for the energies of a forceField, a System
    """
    loop = findLoop(topology, positions, name)
    moving = np.array([atom.index for residue in loop for atom in residue.atoms()])
    backbone = np.array([atom.index for residue in loop for atom in residue.atoms() if atom.name in BACKBONE])
    isFixed = np.ones(topology.getNumAtoms(), dtype=bool)
    isFixed[moving] = False
    system = openmm.System() if forceField is None else copy.deepcopy(forceField)
    for index, fixed in enumerate(isFixed):
        if forceField is None:
            system.addParticle(0 if fixed else 1)
        elif fixed and not system.isVirtualSite(index):
            system.setParticleMass(index, 0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NoteWarning)
        force = createStericExclusionForce(
            topology, positions, fixed=isFixed, closures="loops", system=None if forceField is None else system
        )
    if model == "coil":
        system.addForce(createCoilForce(topology, temperature, positions, ~isFixed))
    atoms = list(topology.atoms())
    chis = [index for index in range(force.getNumTorsions()) if not _isOfBackbone(force, index, atoms)]
    rotamers = _rotamersOf(topology, force)
    sets, densities = _drawnSets(topology, force, positions, rotamers, model)
    try:
        growth = LoopGrowth(system, force, positions, sets, densities)
    except openmm.OpenMMException as error:
        raise InputError(f"{name}: {str(error).removeprefix('LoopGrowth: ')}") from error
    return LoopScene(system, force, growth, backbone, moving, chis, rotamers)


def _isOfBackbone(force, index, atoms):
    return {atoms[particle].name for particle in force.getTorsionParticles(index)[1:3]} <= {"N", "CA", "C"}


def _rotamersOf(topology, force):
    try:
        return rotamerDensities(topology, force, parts=False)
    except ValueError:  # glycines and alanines only
        return None


def _drawnSets(topology, force, positions, rotamers, model):
    """Return the sets of torsions that growth draws, and their densities."""
    named = _NamedTorsions(topology, force)
    backbone = coilDensities(topology, named)
    sets = list(backbone.torsions) + (rotamers.torsions if rotamers else [])
    densities = [
        _turned(density, torsions, named.turns(positions)) for torsions, density in zip(*backbone, strict=True)
    ] + (rotamers.density if rotamers else [])
    if model is None:
        return sets, densities
    if model == "spheres":
        densities = [_uniform(len(torsions)) for torsions in sets]
    known = {torsion for torsions in sets for torsion in torsions}
    others = [index for index in range(force.getNumTorsions()) if index not in known]
    return sets + [(index,) for index in others], densities + [_uniform(1)] * len(others)


def _uniform(count):
    return TorsionDensity.fromTable(np.ones((1,) * count))


class _NamedTorsions:
    """The torsions of a force with the particles of ψ: the last ψ of a loop ends in O, since a closure follows it."""

    def __init__(self, topology, force):
        following = {}
        for atom1, atom2 in topology.bonds():
            for carbon, nitrogen in ((atom1, atom2), (atom2, atom1)):
                if carbon.name == "C" and nitrogen.name == "N" and carbon.residue is not nitrogen.residue:
                    following[carbon.index] = nitrogen.index
        self._particles, self._ends = [], {}
        names = [atom.name for atom in topology.atoms()]
        for index in range(force.getNumTorsions()):
            particles = tuple(force.getTorsionParticles(index))
            carbon = particles[2]
            isLast = [names[particle] for particle in particles[:3]] == ["N", "CA", "C"] and carbon in following
            if isLast and particles[3] != following[carbon]:
                self._ends[index] = particles[3]
                particles = (*particles[:3], following[carbon])
            self._particles.append(particles)

    def getNumTorsions(self):
        return len(self._particles)

    def getTorsionParticles(self, index):
        return self._particles[index]

    def turns(self, positions):
        """Return by how much the force's torsion exceeds ψ, by its index: constant, since C is planar."""
        found = {}
        for index, end in self._ends.items():
            first, second, third, fourth = (positions[particle] for particle in self._particles[index])
            found[index] = _dihedral(first, second, third, positions[end]) - _dihedral(first, second, third, fourth)
        return found


def _dihedral(a, b, c, d):
    axis = c - b
    before, after = np.cross(b - a, axis), np.cross(axis, d - c)
    return np.arctan2(np.cross(before, after) @ axis / np.linalg.norm(axis), before @ after)


def _turned(density, torsions, turns):
    """Return a table of a density of torsions that exceed those of the table by constants, to whole bins."""
    table = density.getTable()
    for axis, torsion in enumerate(torsions):
        if torsion in turns:
            bins = round(turns[torsion] / (2 * np.pi) * table.shape[axis])
            table = np.roll(table, bins, axis)
            density = TorsionDensity.fromTable(table, density.getFloor())
    return density
