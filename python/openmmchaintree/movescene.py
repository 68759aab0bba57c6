"""The torsions of a System sorted by kind, rings that closures keep, and molecules, to choose moves for."""

import copy
import warnings
from itertools import pairwise

import numpy as np
import openmm
from openmm import unit

from .graphs import connectedParts, growTrees, neighborLists
from .openmmchaintree import StericExclusionForce, TorsionMonteCarloIntegrator
from .residues import isWater, polymerBackbone
from .systemreading import checkParticles, drudeParticles, fixedParticles, hasPairEnergies
from .torsions import KINDS, findTorsions

_END = 5  # residues

# The groups of torsions, with their kinds; the last group holds all other kinds.
_KINDS_OF = {
    "peptide backbones": ("phi", "psi"),
    "side chains": ("chi1", "chi2", "chi3", "chi4"),
    "nucleotide backbones": ("alpha", "beta", "gamma", "delta", "epsilon", "zeta"),
    "bases": ("chi",),
    "peptide bonds": ("omega",),
    "rotors": ("rotor",),
    "planar groups": ("planar",),
    "others": None,
}


class MoveScene:
    """The torsions, rings and molecules that moves can be added for.

    topology : openmm.app.Topology; force : StericExclusionForce; moleculeCount : int
    hasEnergies : bool, whether there are energies beside hard spheres
    torsions : dict of lists of int, by group
    """

    def __init__(self, topology, system, torsions=None):
        """Sort the torsions of a System's force, by their kinds in a list of Torsion; default: of `findTorsions`."""
        checkParticles(topology, system)
        forces = [force for force in system.getForces() if StericExclusionForce.isinstance(force)]
        if len(forces) != 1:
            raise ValueError(f"the System must have one StericExclusionForce, but has {len(forces)}")
        self.topology = topology
        self.force = StericExclusionForce.cast(forces[0])
        self._system = system
        self.hasEnergies = hasPairEnergies(system)
        self._bonds = [self.force.getBondParticles(index) for index in range(self.force.getNumBonds())]
        self._closures = [self.force.getClosureParticles(index)[1:3] for index in range(self.force.getNumClosures())]
        self._parts = connectedParts(system.getNumParticles(), self._bonds + self._tiesOfVirtualSites())
        self._checkDrudeParticles()
        self.moleculeCount = len(np.unique(self._parts))
        self._residues = []  # of torsions, None where it is not known
        if torsions is None:
            bonds = {frozenset((bond[0].index, bond[1].index)) for bond in topology.bonds()}
            closures = [bond for bond in self._closures if frozenset(bond) in bonds]
            torsions = findTorsions(topology, None, KINDS, True, True, closures=closures).torsions
        self.torsions = self._sortTorsions(torsions)

    def _tiesOfVirtualSites(self):
        """Return the pairs of a virtual site and a particle that it depends on, which belong to one molecule."""
        ties = []
        for particle in range(self._system.getNumParticles()):
            if self._system.isVirtualSite(particle):
                site = self._system.getVirtualSite(particle)
                ties += [(particle, site.getParticle(index)) for index in range(site.getNumParticles())]
        return ties

    def _checkDrudeParticles(self):
        """Raise a ValueError if moves would part a Drude particle from its parent."""
        for drude, parent in drudeParticles(self._system):
            if self._parts[drude] != self._parts[parent]:
                raise ValueError(
                    f"particle {drude} is the Drude particle of particle {parent}, but moves would part them: add a "
                    "bond between them to the StericExclusionForce, as createStericExclusionForce does if it is given "
                    "the System"
                )

    def _sortTorsions(self, torsions):
        known = {frozenset(torsion.particles[1:3]): torsion for torsion in torsions}
        found = {name: [] for name in _KINDS_OF}
        for index in range(self.force.getNumTorsions()):
            torsion = known.get(frozenset(self.force.getTorsionParticles(index)[1:3]))
            self._residues.append(torsion and torsion.residue)
            kind = torsion and torsion.kind
            found[next(name for name, ofName in _KINDS_OF.items() if ofName is None or kind in ofName)].append(index)
        return found

    def endsOf(self, torsions):
        """Return the torsions of residues near the first or the last residue of their chain."""
        bounds = {}
        for residue in self.topology.residues():
            if polymerBackbone(residue):
                bounds.setdefault(residue.chain.index, []).append(residue.index)
        ends = []
        for torsion in torsions:
            residue = self._residues[torsion]
            chain = bounds.get(residue.chain.index, [residue.index])
            if residue.index < chain[0] + _END or residue.index > chain[-1] - _END:
                ends.append(torsion)
        return ends

    def findRings(self):
        """Return the torsions in rings of closures: on the path from one end of a closure's bond to the other."""
        if not self._closures:
            return set()
        # All fixed particles are one part.
        bonds = [*self._bonds, *pairwise(fixedParticles(self._system).tolist())]
        neighbors = neighborLists(self._system.getNumParticles(), bonds)
        axes = {}
        for index in range(self.force.getNumTorsions()):
            axes[frozenset(self.force.getTorsionParticles(index)[1:3])] = index
        found = set()
        for start, end in self._closures:
            parents = dict(growTrees(neighbors, [start]))
            while end in parents:
                found.add(axes.get(frozenset((end, parents[end]))))
                end = parents[end]
        return found - {None}

    def freeMolecules(self):
        """Return a particle of each molecule without fixed particles, in a box of water without water and ions."""
        isFixed = np.zeros(self.moleculeCount, dtype=bool)
        isFixed[self._parts[fixedParticles(self._system)]] = True
        first = np.unique(self._parts, return_index=True)[1]
        free = [int(particle) for particle, fixed in zip(first, isFixed, strict=True) if not fixed]
        if not self.force.usesPeriodicBoundaryConditions():
            return free
        waters = set(filter(isWater, self.topology.residues()))
        residues = [atom.residue for atom in self.topology.atoms()]
        solute = [particle for particle in free if len(residues[particle]) > 1 and residues[particle] not in waters]
        return solute if waters and solute else free

    @property
    def boxLength(self):
        """The longest edge (nm) of the periodic box, 0 without one."""
        if not self.force.usesPeriodicBoundaryConditions():
            return 0.0
        vectors = self._system.getDefaultPeriodicBoxVectors()
        return max(float(np.linalg.norm(vector.value_in_unit(unit.nanometer))) for vector in vectors)

    def canClose(self, torsions):
        """Return whether closed moves find windows among torsions."""
        return self._canAdd(lambda integrator: integrator.addClosedMove(1, 0.1, torsions), "window")

    def canTurnPieces(self):
        """Return whether crankshaft moves find pieces of chains between ball joints."""
        return self._canAdd(lambda integrator: integrator.addCrankshaftMove(1, 0.1), "no three of its ball joints")

    def _canAdd(self, addMove, complaint):
        """Return whether a Context of hard spheres alone takes a move, or complains in words with `complaint`."""
        bare = openmm.System()
        for particle in range(self._system.getNumParticles()):
            isVirtual = self._system.isVirtualSite(particle)
            bare.addParticle(1 if isVirtual else self._system.getParticleMass(particle))
        bare.addForce(copy.copy(self.force))
        integrator = TorsionMonteCarloIntegrator(0)
        addMove(integrator)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # those of the force come again with the user's Context
            try:
                openmm.Context(bare, integrator, openmm.Platform.getPlatformByName("Reference"))
            except openmm.OpenMMException as error:
                if complaint not in str(error):
                    raise
                return False
        return True
