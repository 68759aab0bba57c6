"""Real structures in force fields, for tests: as OpenMM's package ships them, or from the folder of real structures.

Energies are given as OpenMM's Reference platform has them, and as the sum of all pairs in long double.
"""

import functools
import os
import random
import warnings
from pathlib import Path

import numpy as np
import openmm
import openmm.app as app
import pytest
from openmm import unit
from openmmchaintree import TorsionMonteCarloIntegrator, createStericExclusionForce

# Arguments of createSystem for each method of NonbondedForce.
METHODS = {
    "no cutoff": {"nonbondedMethod": app.NoCutoff},
    "reaction field": {"nonbondedMethod": app.CutoffNonPeriodic, "nonbondedCutoff": 1.0},
    "switch": {"nonbondedMethod": app.CutoffNonPeriodic, "nonbondedCutoff": 1.0, "switchDistance": 0.8},
}

# Residues that the force fields have no template for.
WITHOUT_TEMPLATE = ("HEM", "PO4", "HOH", "Cl", "CL")

# Structures whose hydrogens are added, in the manner of the force field.
BARE = ("1bna", "4hhb")

COULOMB = np.longdouble("138.93545764438198")  # kJ nm / (mol e^2)


def dataFile(name):
    """Return the path of a structure of the folder of real structures; the test is skipped without it."""
    folder = os.environ.get("CHAINTREE_TEST_DATA")
    if not folder:
        pytest.skip("CHAINTREE_TEST_DATA, the folder of real structures, is not set")
    return Path(folder) / f"{name}.pdb"


def alanineDipeptide():
    """Return ACE-ALA-NME, extended, built from internal coordinates: topology and positions."""
    # name, element, the three atoms that it is placed by, distance (nm), angle and dihedral (degrees)
    rows = [
        ("HH31", "H", (), 0, 0, 0),
        ("CH3", "C", ("HH31",), 0.109, 0, 0),
        ("HH32", "H", ("CH3", "HH31"), 0.109, 109.5, 0),
        ("HH33", "H", ("CH3", "HH31", "HH32"), 0.109, 109.5, 120),
        ("C", "C", ("CH3", "HH31", "HH32"), 0.1522, 109.5, -120),
        ("O", "O", ("C", "CH3", "HH31"), 0.1229, 120.4, 0),
        ("N", "N", ("C", "CH3", "O"), 0.1335, 116.6, 180),
        ("H", "H", ("N", "C", "O"), 0.101, 119.8, 180),
        ("CA", "C", ("N", "C", "CH3"), 0.1449, 121.9, 180),
        ("HA", "H", ("CA", "N", "C"), 0.109, 109.5, 45),
        ("CB", "C", ("CA", "N", "C"), 0.1526, 109.7, 165),
        ("HB1", "H", ("CB", "CA", "N"), 0.109, 109.5, 60),
        ("HB2", "H", ("CB", "CA", "N"), 0.109, 109.5, 180),
        ("HB3", "H", ("CB", "CA", "N"), 0.109, 109.5, 300),
        ("C2", "C", ("CA", "N", "C"), 0.1522, 110.1, -75),
        ("O2", "O", ("C2", "CA", "N"), 0.1229, 120.4, -30),
        ("N2", "N", ("C2", "CA", "N"), 0.1335, 116.6, 150),
        ("H2", "H", ("N2", "C2", "O2"), 0.101, 119.8, 180),
        ("C3", "C", ("N2", "C2", "CA"), 0.1449, 121.9, 180),
        ("H31", "H", ("C3", "N2", "C2"), 0.109, 109.5, 60),
        ("H32", "H", ("C3", "N2", "C2"), 0.109, 109.5, 180),
        ("H33", "H", ("C3", "N2", "C2"), 0.109, 109.5, 300),
    ]
    places = {}
    for name, _, anchors, distance, angle, dihedral in rows:
        places[name] = placeAtom([places[anchor] for anchor in anchors], distance, angle, dihedral)
    residues = {
        "ACE": "HH31 CH3 HH32 HH33 C O",
        "ALA": "N H CA HA CB HB1 HB2 HB3 C2 O2",
        "NME": "N2 H2 C3 H31 H32 H33",
    }
    official = {"C2": "C", "O2": "O", "N2": "N", "H2": "H", "C3": "CH3", "H31": "HH31", "H32": "HH32", "H33": "HH33"}
    elements = {name: element for name, element, *_ in rows}
    topology = app.Topology()
    chain = topology.addChain()
    atoms, order = {}, []
    for residueName, names in residues.items():
        residue = topology.addResidue(residueName, chain)
        for name in names.split():
            isLater = residueName != "ACE" and name in official
            element = app.Element.getBySymbol(elements[name])
            atoms[name] = topology.addAtom(official[name] if isLater else name, element, residue)
            order.append(name)
    for name, _, anchors, *_ in rows[1:]:
        topology.addBond(atoms[anchors[0]], atoms[name])
    return topology, np.array([places[name] for name in order])


def placeAtom(anchors, distance, angle, dihedral):
    """Return a position by its distance, angle and dihedral (degrees) from up to three others."""
    if not anchors:
        return np.zeros(3)
    if len(anchors) == 1:
        return anchors[0] + np.array([distance, 0, 0])
    angle, dihedral = np.radians(angle), np.radians(dihedral)
    axis = anchors[0] - anchors[1]
    axis = axis / np.linalg.norm(axis)
    third = anchors[2] if len(anchors) == 3 else anchors[1] + np.array([0.1, 1, 0])
    normal = np.cross(anchors[1] - third, axis)
    normal = normal / np.linalg.norm(normal)
    side = np.cross(normal, axis)
    offset = -axis * np.cos(angle) + np.sin(angle) * (side * np.cos(dihedral) + normal * np.sin(dihedral))
    return anchors[0] + distance * offset


forceFieldOf = functools.cache(app.ForceField)  # from its files: reading them takes as long as some tests


@functools.cache
def readSystem(name, forceField):
    """Return the topology and positions (nm) of a structure, complete for a force field."""
    if name == "alanine dipeptide":
        return alanineDipeptide()
    path = Path(app.__file__).parent / "data" / "test.pdb" if name == "villin" else dataFile(name)
    pdb = app.PDBFile(str(path))
    modeller = app.Modeller(pdb.topology, pdb.positions)
    modeller.delete([residue for residue in pdb.topology.residues() if residue.name in WITHOUT_TEMPLATE])
    if name in BARE:
        random.seed(1)  # they are placed at random
        modeller.addHydrogens(forceFieldOf(forceField), platform=openmm.Platform.getPlatform("CPU"))
    return modeller.topology, np.array(modeller.positions.value_in_unit(unit.nanometer))


def makeSystem(
    name, forceField="amber14-all.xml", method="no cutoff", steric=True, solvent=None, options=None, **choice
):
    """Return a System, its topology and positions. Without steric, no particle has a radius. The file of an implicit
    solvent can have options. The positions are the caller's to change.
    """
    topology, positions = readSystem(name, forceField)
    positions = positions.copy()
    files = [forceField] if solvent is None else [forceField, solvent]
    settings = {key: value * unit.nanometer if "utoff" in key else value for key, value in METHODS[method].items()}
    system = forceFieldOf(*files).createSystem(topology, **settings, **(options or {}))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about omitted parts
        force = createStericExclusionForce(topology, positions, **choice)
    if not steric:
        for particle in range(force.getNumParticles()):
            force.setParticleParameters(particle, 0)
    system.addForce(force)
    return system, topology, positions


def isSteric(force):
    return force.getName() == "StericExclusionForce"


class Reference:
    """OpenMM's energies of a System without its StericExclusionForce."""

    def __init__(self, system, platform="Reference"):
        copy = openmm.XmlSerializer.clone(system)
        for index in reversed(range(copy.getNumForces())):
            if isSteric(copy.getForce(index)):
                copy.removeForce(index)
            else:
                copy.getForce(index).setForceGroup(index)
        self.names = {copy.getForce(i).getForceGroup(): copy.getForce(i).getName() for i in range(copy.getNumForces())}
        self.context = openmm.Context(copy, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatform(platform))

    def energy(self, positions, groups=-1):
        self.context.setPositions(positions)
        energy = self.context.getState(energy=True, groups=groups).getPotentialEnergy()
        return energy.value_in_unit(unit.kilojoule_per_mole)

    def gradient(self, positions):
        """Return the length of the vector of all forces of pairs, kJ/mol/nm."""
        self.context.setPositions(positions)
        pairs = [1 << group for group, name in self.names.items() if name == "NonbondedForce"]
        forces = self.context.getState(forces=True, groups=pairs[0]).getForces(asNumpy=True)
        return np.linalg.norm(forces.value_in_unit(unit.kilojoule_per_mole / unit.nanometer))

    def energies(self, positions):
        """Return the energy of each Force."""
        return np.array([self.energy(positions, 1 << group) for group in self.names])


# Weights, largest angles and numbers of torsions.
MOVES = ((1, 0.02, 1), (1, 0.5, 1))


class Run:
    """A System under a TorsionMonteCarloIntegrator."""

    def __init__(
        self,
        system,
        positions,
        seed=1,
        native=True,
        temperature=300,
        moves=MOVES,
        rigid=None,
        torsions=None,
        platform="Reference",
    ):
        self.integrator = TorsionMonteCarloIntegrator(temperature)
        self.integrator.setStericMode(TorsionMonteCarloIntegrator.Hard)
        self.integrator.setRandomNumberSeed(seed)
        self.integrator.setNativeEnergies(native)
        for weight, angle, count in moves:
            self.integrator.addTorsionMove(weight, angle, torsions, count)
        if rigid is not None:
            self.integrator.addRigidBodyMove(1, *rigid)
        self.system = system
        self.context = openmm.Context(system, self.integrator, openmm.Platform.getPlatform(platform))
        self.context.setPositions(positions)
        self.context.computeVirtualSites()

    def run(self, trials):
        steps = max(1, trials // 1000)
        self.integrator.setTrialsPerStep(trials // steps)
        self.integrator.step(steps)

    @property
    def energy(self):
        return self.integrator.getPotentialEnergy(self.context)

    @property
    def positions(self):
        return positionsOf(self.context)

    @property
    def accepted(self):
        integrator = self.integrator
        return sum(integrator.getMoveStatistics(move).accepted for move in range(integrator.getNumMoves()))

    @property
    def softEnergy(self):
        """The energy of the spheres, if they were soft."""
        for force in self.system.getForces():
            if isSteric(force):
                state = self.context.getState(energy=True, groups={force.getForceGroup()})
                return state.getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)
        return 0

    @property
    def clashes(self):
        """Whether spheres overlap by more than they may: then they would have an energy, if they were soft."""
        return self.softEnergy > 0

    @property
    def torsions(self):
        """The angles of all torsions, rad."""
        return np.array(self.integrator.getTorsionAngles(self.context))


def positionsOf(context):
    return context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)


class PairSum:
    """Lennard-Jones and Coulomb of all pairs of a NonbondedForce in long double, from the formulas of its manual."""

    def __init__(self, force):
        count = force.getNumParticles()
        values = [force.getParticleParameters(i) for i in range(count)]
        charge, sigma, epsilon = (
            np.array([row[column].value_in_unit_system(unit.md_unit_system) for row in values], dtype=np.longdouble)
            for column in range(3)
        )
        self.charges = COULOMB * np.outer(charge, charge)
        self.sigmas = (sigma[:, None] + sigma[None, :]) / 2
        self.epsilons = np.sqrt(np.outer(epsilon, epsilon))
        self.counts = np.triu(np.ones((count, count), dtype=bool), 1)
        self.exceptions = []
        for index in range(force.getNumExceptions()):
            p1, p2, *parameters = force.getExceptionParameters(index)
            self.counts[min(p1, p2), max(p1, p2)] = False
            product, s, e = (np.longdouble(p.value_in_unit_system(unit.md_unit_system)) for p in parameters)
            if product != 0 or e != 0:
                self.exceptions.append((p1, p2, product, s, e))
        self.cutoff = None
        if force.getNonbondedMethod() == openmm.NonbondedForce.CutoffNonPeriodic:
            self.cutoff = np.longdouble(force.getCutoffDistance().value_in_unit(unit.nanometer))
            dielectric = np.longdouble(force.getReactionFieldDielectric())
            self.k = (dielectric - 1) / (2 * dielectric + 1) / self.cutoff**3
            self.c = 3 * dielectric / (2 * dielectric + 1) / self.cutoff
            self.switch = None
            if force.getUseSwitchingFunction():
                self.switch = np.longdouble(force.getSwitchingDistance().value_in_unit(unit.nanometer))

    def energy(self, positions):
        x = np.asarray(positions, dtype=np.longdouble)
        first, second = np.nonzero(self.counts)
        r = np.sqrt(((x[first] - x[second]) ** 2).sum(axis=1))
        if self.cutoff is not None:
            within = r < self.cutoff
            first, second, r = first[within], second[within], r[within]
        ratio6 = (self.sigmas[first, second] / r) ** 6
        lennardJones = 4 * self.epsilons[first, second] * ratio6 * (ratio6 - 1)
        coulomb = 1 / r
        if self.cutoff is not None:
            coulomb = coulomb + self.k * r**2 - self.c
            if self.switch is not None:
                t = np.maximum(0, (r - self.switch) / (self.cutoff - self.switch))
                lennardJones = lennardJones * (1 - 10 * t**3 + 15 * t**4 - 6 * t**5)
        total = lennardJones.sum() + (self.charges[first, second] * coulomb).sum()
        for p1, p2, product, sigma, epsilon in self.exceptions:
            distance = np.sqrt(((x[p1] - x[p2]) ** 2).sum())
            s6 = (sigma / distance) ** 6
            total += 4 * epsilon * s6 * (s6 - 1) + COULOMB * product / distance
        return total
