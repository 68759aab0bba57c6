"""The long-double oracle (oracle/oracle.h) for tests in Python, and its links, found by flood fills.

The plugin contributes only the user's input in the force, so that its own processing is tested, too. Numbers are in nm,
rad and kJ/mol.
"""

import ctypes
import os

import numpy as np
from openmm import unit
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

_FIXED, _FREE, _TORSION = 0, 1, 2
_CHANGE_SIZE = 10
STATE, TRIAL = 0, 1


def _components(count, edges):
    """Return a number for each of `count` vertices, the same for vertices that edges join."""
    edges = np.array(edges, dtype=int).reshape(-1, 2)
    graph = coo_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
    return connected_components(graph, directed=False)[1]


class Links:
    """The rigid links of a force, without virtual sites.

    Attributes
    ----------
    molecules, particleLinks : array of shape (particles)
        numbers of the molecule and the link of each particle
    parents, joints : array of shape (links)
    torsions : array of shape (links, 4)
        the particles of the torsion at which a link hangs
    torsionLinks : array of shape (torsions)
        the link that each torsion moves
    roots : array of shape (molecules)
        the link of each molecule that is placed in space
    """

    def __init__(self, system, force):
        count = force.getNumParticles()
        bonds = [frozenset(force.getBondParticles(i)) for i in range(force.getNumBonds())]
        torsions = [force.getTorsionParticles(i) for i in range(force.getNumTorsions())]
        axes = {frozenset(torsion[1:3]) for torsion in torsions}
        self.molecules = _components(count, [tuple(bond) for bond in bonds])
        self.particleLinks = _components(count, [tuple(bond) for bond in bonds if bond not in axes])

        linkCount = self.particleLinks.max() + 1
        self.parents = np.full(linkCount, -1, dtype=np.intc)
        self.joints = np.full(linkCount, _FREE, dtype=np.uint8)
        self.torsions = np.full((linkCount, 4), -1, dtype=np.intc)
        self.torsionLinks = np.full(len(torsions), -1)
        self.roots = self._findRoots(system)

        torsionsAt = [[] for _ in range(linkCount)]
        for torsion, particles in enumerate(torsions):
            for particle in particles[1:3]:
                torsionsAt[self.particleLinks[particle]].append(torsion)
        reached = list(self.roots)
        for link in reached:
            for torsion in torsionsAt[link]:
                if self.torsionLinks[torsion] == -1:
                    (child,) = {self.particleLinks[particle] for particle in torsions[torsion][1:3]} - {link}
                    self.parents[child] = link
                    self.joints[child] = _TORSION
                    self.torsions[child] = torsions[torsion]
                    self.torsionLinks[torsion] = child
                    reached.append(child)
        assert len(reached) == linkCount

    def _findRoots(self, system):
        roots = []
        for molecule in range(self.molecules.max() + 1):
            members = np.flatnonzero(self.molecules == molecule)
            fixed = [i for i in members if system.getParticleMass(int(i)) == 0 * unit.dalton]
            roots.append(self.particleLinks[fixed[0] if fixed else members[0]])
            if fixed:
                self.joints[roots[-1]] = _FIXED
        return np.array(roots)

    def isFixed(self, molecule):
        """Whether a molecule has fixed particles."""
        return self.joints[self.roots[molecule]] == _FIXED


class OracleScene:
    """The scene of a force and a System at given positions, judged by the oracle.

    Pairs come as int arrays of shape (n, 2), sorted.
    """

    def __init__(self, system, force, positions):
        self.links = Links(system, force)
        self._count = force.getNumParticles()
        parameters = [force.getParticleParameters(i) for i in range(self._count)]
        exclusions = [force.getExclusionParticles(i) for i in range(force.getNumExclusions())]
        library = ctypes.CDLL(os.environ["CHAINTREE_ORACLE"])
        for name in ("oracleWorstTrialMargin", "oracleMinimumDistance", "oracleDistance", "oracleEnergy"):
            getattr(library, name).restype = ctypes.c_double
        library.oracleCreate.restype = ctypes.c_void_p
        self._library = library
        self._scene = ctypes.c_void_p(
            library.oracleCreate(
                ctypes.c_int(self._count),
                _doubles(positions),
                _doubles([radius.value_in_unit(unit.nanometer) for radius, _ in parameters]),
                _bytes([role for _, role in parameters]),
                _ints(self.links.particleLinks),
                ctypes.c_int(len(self.links.parents)),
                _ints(self.links.parents),
                _bytes(self.links.joints),
                _ints(self.links.torsions),
                ctypes.c_int(len(exclusions)),
                _ints(exclusions),
                ctypes.c_double(force.getOverlapTolerance().value_in_unit(unit.nanometer)),
                ctypes.c_double(force.getHydrogenBondAllowance().value_in_unit(unit.nanometer)),
            )
        )

    def __del__(self):
        if hasattr(self, "_scene"):
            self._library.oracleDestroy(self._scene)

    def setPositions(self, positions):
        self._library.oracleSetPositions(self._scene, _doubles(positions))

    def positions(self, which=STATE):
        """Return the positions of the state or the trial, rounded to double: (particles, 3)."""
        positions = np.empty((self._count, 3))
        self._library.oracleGetPositions(self._scene, ctypes.c_int(which), _doubles(positions))
        return positions

    def setLimits(self, pairs, limits):
        """Make these the only pairs whose limit is not their tolerance."""
        self._library.oracleSetLimits(self._scene, ctypes.c_int(len(pairs)), _ints(pairs), _doubles(limits))

    def proposeTorsions(self, torsions, changes):
        values = np.zeros((len(torsions), _CHANGE_SIZE))
        values[:, 0] = changes
        self._propose(self.links.torsionLinks[torsions], values)

    def proposeRigidMotion(self, particle, rotation, translation):
        molecule = self.links.molecules[particle]
        values = np.zeros((1, _CHANGE_SIZE))
        values[0, 1:4] = rotation
        values[0, 4:7] = self.positions()[self.links.molecules == molecule].mean(axis=0)
        values[0, 7:10] = translation
        self._propose(self.links.roots[[molecule]], values)

    def _propose(self, links, values):
        self._library.oraclePropose(self._scene, ctypes.c_int(len(links)), _ints(links), _doubles(values))

    def worstTrialMargin(self):
        """Return by how much the worst pair of the trial is beyond its limit (negative: within it), and the pair."""
        pair = np.empty(2, dtype=np.intc)
        return self._library.oracleWorstTrialMargin(self._scene, _ints(pair)), pair.tolist()

    def accept(self):
        self._library.oracleAccept(self._scene)

    def changedPairs(self, cutoff):
        """Return pairs, distances before, distances after."""
        return self._list(self._library.oracleListChangedPairs, cutoff, 2)

    def clashes(self, slack):
        """Return pairs that overlap by more than tolerance - slack, overlaps, overlaps - tolerances."""
        return self._list(self._library.oracleListClashes, slack, 2)

    def beyondLimits(self, slack):
        """Return pairs that overlap by more than limit - slack, overlaps, overlaps - limits."""
        return self._list(self._library.oracleListBeyondLimits, slack, 2)

    def neighborPairs(self, cutoff):
        """Return pairs, distances."""
        return self._list(self._library.oracleListNeighborPairs, cutoff, 1)

    def clashesWith(self, position, radius, slack):
        """Return particles that a sphere overlaps by more than tolerance - slack, overlaps, overlaps - tolerance."""
        particles = np.empty(self._count, dtype=np.intc)
        values = np.empty((2, self._count))
        count = self._library.oracleListClashesWith(
            self._scene,
            _doubles(position),
            ctypes.c_double(radius),
            ctypes.c_double(slack),
            ctypes.c_int(self._count),
            _ints(particles),
            _doubles(values[0]),
            _doubles(values[1]),
        )
        return particles[:count], values[0, :count], values[1, :count]

    def distance(self, particle1, particle2):
        return self._library.oracleDistance(
            self._scene, ctypes.c_int(STATE), ctypes.c_int(particle1), ctypes.c_int(particle2)
        )

    def minimumDistance(self, particles1, particles2):
        """Return the least distance between different particles of two sets, infinity if there are none."""
        return self._library.oracleMinimumDistance(
            self._scene,
            ctypes.c_int(len(particles1)),
            _ints(particles1),
            ctypes.c_int(len(particles2)),
            _ints(particles2),
        )

    def _list(self, function, length, valueCount):
        capacity = 1000
        while True:
            pairs = np.empty((capacity, 2), dtype=np.intc)
            values = [np.empty(capacity) for _ in range(valueCount)]
            arguments = [_ints(pairs)] + [_doubles(value) for value in values]
            count = function(self._scene, ctypes.c_double(length), ctypes.c_int(capacity), *arguments)
            if count <= capacity:
                return pairs[:count], *(value[:count] for value in values)
            capacity = count

    def energy(self, forceConstant):
        """Return the energy and the forces: (particles, 3)."""
        forces = np.empty((self._count, 3))
        energy = self._library.oracleEnergy(self._scene, ctypes.c_double(forceConstant), _doubles(forces))
        return energy, forces


# The arrays are made to fit, or passed as they are where the oracle is to write to them.


def _pointer(values, dtype):
    return np.ascontiguousarray(values, dtype=dtype).ctypes.data_as(ctypes.c_void_p)


def _doubles(values):
    return _pointer(values, np.float64)


def _ints(values):
    return _pointer(values, np.intc)


def _bytes(values):
    return _pointer(values, np.uint8)
