"""Proteins and nucleic acids in AMBER14: with hydrogens, as OpenMM's Systems, as hard spheres, after some sampling."""

import os
from functools import cache, cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
import openmm
from openmm import app, unit
from openmmchaintree import TorsionMonteCarloIntegrator
from openmmchaintree.command.allpairs import HardSpheres
from openmmchaintree.command.plan import DEFAULT_KINDS
from openmmchaintree.residues import aminoAcid, isNucleotide
from openmmchaintree.sterics import createStericExclusionForce
from openmmchaintree.structures.structure import readStructure
from openmmchaintree.torsions import findTorsions
from racing.platforms import CPU
from racing.scene import makeScene

from .forcefield import readSystem

FORCE_FIELD = "amber14-all.xml"
TEMPERATURE = 300  # K

_FOLDER = "CHAINTREE_TEST_DATA"
NUCLEOTIDE_BACKBONE = ("alpha", "beta", "gamma", "epsilon", "zeta")
_BACKBONE_KINDS = ("phi", "psi", *NUCLEOTIDE_BACKBONE)
_WARM_STEP = 100  # trials
TRIALS_PER_OUTER_TEST = 400  # the default


class Method(NamedTuple):
    """What U is but for bonded terms.

    name : str, for tables; cutoff : float, of a reaction field in nm, or None; solvent : str, the file of implicit
    solvent, or None
    """

    name: str
    cutoff: float | None
    solvent: str | None = None


REACTION_FIELD, NO_CUTOFF = Method("reaction field 1.0 nm", 1.0), Method("no cutoff", None)
METHODS = (REACTION_FIELD, NO_CUTOFF)
IMPLICIT_SOLVENT = Method("GBn2, no cutoff", None, "implicit/gbn2.xml")

# Which torsions a move turns. Those near an end of a chain that are meant move nothing but the residues behind them.
BACKBONE, SIDE_CHAINS, ENDS = "backbone", "side chains", "ends"
_END = 8  # residues

# The moves of examples/sample_protein.py: weight, largest angle in degrees, and which torsions.
EXAMPLE_MOVES = ((1.0, 1, BACKBONE), (1.0, 10, SIDE_CHAINS), (0.5, 180, SIDE_CHAINS))


@cache
def _readForceField(*files):
    return app.ForceField(FORCE_FIELD, *files)


class SampledProtein:
    """A protein with hydrogens.

    name : str; topology : openmm.app.Topology; positions : (n, 3) float64 array, nm
    """

    def __init__(self, name, topology, positions):
        """Take over what there is."""
        self.name = name
        self.topology = topology
        self.positions = positions

    @cached_property
    def torsions(self):
        """The Torsions that turn, as they are numbered in the force."""
        return findTorsions(self.topology, self.positions, DEFAULT_KINDS).torsions

    def isBackbone(self):
        """Return of each torsion whether it is one of the backbone."""
        return [torsion.kind in _BACKBONE_KINDS for torsion in self.torsions]

    def torsionsOf(self, which):
        """Return the numbers of BACKBONE, of SIDE_CHAINS, or of ENDS: the backbone of each chain's last residues."""
        wanted = [isOne != (which == SIDE_CHAINS) for isOne in self.isBackbone()]
        if which == ENDS:
            atoms = list(self.topology.atoms())
            residues = [atoms[torsion.particles[1]].residue for torsion in self.torsions]
            last = {chain: max(residue.index for residue in chain.residues()) for chain in self.topology.chains()}
            isNear = [last[residue.chain] - residue.index < _END for residue in residues]
            wanted = [one and near for one, near in zip(wanted, isNear, strict=True)]
        return [number for number, isWanted in enumerate(wanted) if isWanted]

    def makeSystem(self, method, sterics=True, **options):
        """Make the System of a Method, with or without hard spheres, with what other options createSystem takes."""
        if method.cutoff is None:
            nonbonded = {"nonbondedMethod": app.NoCutoff}
        else:
            nonbonded = {"nonbondedMethod": app.CutoffNonPeriodic, "nonbondedCutoff": method.cutoff * unit.nanometer}
        files = [] if method.solvent is None else [method.solvent]
        system = _readForceField(*files).createSystem(self.topology, **nonbonded, **options)
        if sterics:
            system.addForce(self.makeForce())
        return system

    def makeForce(self):
        """Make the StericExclusionForce."""
        return createStericExclusionForce(self.topology, self.positions, torsions=self.torsions)

    def makeSimulation(self, method, seed, native=True, moves=EXAMPLE_MOVES):
        """Make a Simulation on the CPU platform with one thread, if there is one, by default with the example's moves.

        These turn, as in examples/sample_protein.py, the backbone by up to 1 degree, side chains by up to 10 degrees
        and, half as often, by up to 180.
        """
        return self.makeSimulationOf(self.makeSystem(method), seed, native, moves)

    def makeSimulationOf(self, system, seed, native=True, moves=EXAMPLE_MOVES):
        """Make a Simulation of a System with hard spheres."""
        integrator = TorsionMonteCarloIntegrator(TEMPERATURE * unit.kelvin)
        integrator.setRandomNumberSeed(seed)
        integrator.setNativeEnergies(native)
        for weight, angle, which in moves:
            integrator.addTorsionMove(weight, angle * unit.degree, self.torsionsOf(which))
        simulation = app.Simulation(self.topology, system, integrator, *choosePlatform())
        simulation.context.setPositions(self.positions)
        return simulation

    def relaxed(self, trials, seed=1, method=REACTION_FIELD):
        """Return the protein after so many trials of these moves, by default with a reaction field.

        A crystal's hydrogens lie anywhere; what trials are refused by depends on that.
        """
        if trials < _WARM_STEP:
            return self
        simulation = self.makeSimulation(method, seed)
        perStep = _WARM_STEP if method.solvent is None else min(trials, TRIALS_PER_OUTER_TEST)
        simulation.integrator.setTrialsPerStep(perStep)
        simulation.step(trials // perStep)
        return SampledProtein(self.name, self.topology, positionsOf(simulation.context))

    def makeScene(self):
        """Make the Scene of hard spheres for the program: without roles, and pairs that overlap are excluded."""
        force = self.makeForce()
        force.setHydrogenBondAllowance(0)
        for pair in HardSpheres(force).overlaps(self.positions).pairs.tolist():
            force.addExclusion(*pair)
        return makeScene(force, self.positions, [not isBackbone for isBackbone in self.isBackbone()])

    def readTerms(self, method):
        """Return the ForceFieldTerms of a Method."""
        return readSystem(self.makeSystem(method, sterics=False))


class Evaluator:
    """OpenMM's energy of positions, on a platform: the CPU platform has one thread."""

    def __init__(self, system, platformName):
        """Make a Context of a System."""
        properties = {"Threads": "1"} if platformName == CPU else {}
        platform = openmm.Platform.getPlatformByName(platformName)
        self._context = openmm.Context(system, openmm.VerletIntegrator(0.001), platform, properties)

    def energy(self, positions):
        """Return the energy of (n, 3) positions in nm, kJ/mol."""
        self._context.setPositions(positions)
        return self._context.getState(getEnergy=True).getPotentialEnergy()._value


def choosePlatform():
    """Return the CPU platform with one thread as a Simulation takes it, or the Reference platform."""
    try:
        return openmm.Platform.getPlatformByName(CPU), {"Threads": "1"}
    except openmm.OpenMMException:
        return (openmm.Platform.getPlatformByName("Reference"),)


def positionsOf(context):
    """Return the positions of a Context as an (n, 3) float64 array, nm."""
    return context.getState(getPositions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)


def _isKnown(name):
    return aminoAcid(name) is not None or isNucleotide(name)


def readSampled(path=None):
    """Read what is a polymer in a structure, by default the villin headpiece, and add hydrogens if there are none."""
    structure = readStructure(path)
    modeller = app.Modeller(structure.topology, structure.positions * unit.nanometer)
    modeller.delete([residue for residue in structure.topology.residues() if not _isKnown(residue.name)])
    name = structure.name
    if not any(atom.element is app.element.hydrogen for atom in modeller.topology.atoms()):
        modeller.addHydrogens(_readForceField())
        name += ", hydrogens added"
    positions = np.array(modeller.positions.value_in_unit(unit.nanometer), dtype=np.float64)
    return SampledProtein(name, modeller.topology, positions)


def findFiles(names):
    """Return which files lie ready, as paths, and the names of the others."""
    folder = os.environ.get(_FOLDER)
    found = [Path(folder, name) for name in names if folder and Path(folder, name).exists()]
    return found, [name for name in names if name not in {path.name for path in found}]
