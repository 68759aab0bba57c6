"""Proteins: which are measured, as hard spheres, and as Systems in AMBER14."""

import os
import warnings
from functools import cache, cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
import openmm
from measure import CPU, hasCPU
from openmm import app, unit
from openmmchaintree import TorsionMonteCarloIntegrator, createStericExclusionForce, findTorsions
from openmmchaintree.errors import InputError
from openmmchaintree.residues import aminoAcid, isNucleotide
from openmmchaintree.structures.structure import readStructure
from scene import Scene, excludeClashes, makeScene

_FOLDER = "CHAINTREE_TEST_DATA"

TEMPERATURE = 300  # K
KT = 8.314462618e-3 * TEMPERATURE  # kJ/mol

NUCLEOTIDE_BACKBONE = ("alpha", "beta", "gamma", "epsilon", "zeta")
_BACKBONE_KINDS = ("phi", "psi", *NUCLEOTIDE_BACKBONE)
_SMALL_KINDS = ("phi", "psi", "chi")  # of chains of amino acids
_KINDS = (*_SMALL_KINDS, *NUCLEOTIDE_BACKBONE)


def nameOf(path):
    """Return what tables call a structure; None is the villin headpiece."""
    return "villin" if path is None else Path(path).name.partition(".")[0]


def findStructures(options, files):
    """Return the paths that are measured, None for villin, and lines about files that are missing."""
    if options.structures:
        return options.structures, []
    if options.quick:
        return [None], []
    folder = os.environ.get(_FOLDER)
    found = [Path(folder, name) for name in files if folder and Path(folder, name).exists()]
    missing = [name for name in files if name not in {path.name for path in found}]
    return [None, *found], [f"{name}: not in the folder that {_FOLDER} names" for name in missing]


# ---- Hard spheres of the longest chain of amino acids ----


class Model:
    """Some atoms of a chain of amino acids as hard spheres; pairs that overlap are excluded.

    name : str; topology : openmm.app.Topology; positions : (n, 3) float64 array, nm
    force : StericExclusionForce; torsions : list of Torsion, as in the force; scene : Scene
    """

    def __init__(self, name, topology, positions):
        """Make the force and the scene; an InputError tells of an element without a radius."""
        self.name, self.topology, self.positions = name, topology, positions
        # Disulfides are cut, so that no part of the chain is in a ring.
        self.torsions = findTorsions(topology, positions, _SMALL_KINDS, cutDisulfides=True).torsions
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                force = createStericExclusionForce(
                    topology, positions, torsions=self.torsions, cutDisulfides=True
                )  # fmt: skip
            except ValueError as error:
                raise InputError(f"{name}: {error}") from error
        self.force = excludeClashes(force, positions)
        sideChains = [torsion.kind not in _BACKBONE_KINDS for torsion in self.torsions]
        self.scene: Scene = makeScene(self.force, positions, sideChains)

    def __str__(self):
        """Return what messages call it."""
        return self.name

    def options(self, course):
        """Return the options of the program."""
        path = course.folder / self.name.replace(" ", "-")
        if not path.exists():
            self.scene.write(path)
        return {"--chain": path}


class ChainModels:
    """The Models of the longest chain of amino acids of a structure, made when they are asked for."""

    def __init__(self, path):
        """Read a structure, by default the villin headpiece."""
        structure = readStructure(path)
        chains = [
            {residue for residue in chain.residues() if aminoAcid(residue.name) is not None}
            for chain in structure.topology.chains()
        ]
        longest = max(chains, key=len)
        if not longest:
            raise InputError(f"{path}: there is no chain of amino acids")
        self._name = structure.name
        self._source = _choose(structure.topology, structure.positions, lambda atom: atom.residue in longest)

    @cached_property
    def backbone(self):
        """The Model with three atoms of each residue."""
        return self._only("backbone", lambda atom: atom.name in ("N", "CA", "C"))

    @cached_property
    def heavyAtoms(self):
        """The Model without hydrogens."""
        return self._only("heavy atoms", lambda atom: not _isHydrogen(atom))

    @cached_property
    def allAtoms(self):
        """The Model with hydrogens, or None if there are none."""
        hasHydrogens = any(map(_isHydrogen, self._source[0].atoms()))
        return self._only("all atoms", lambda atom: True) if hasHydrogens else None

    def _only(self, words, isWanted):
        return Model(f"{self._name} {words}", *_choose(*self._source, isWanted))


def _isHydrogen(atom):
    return atom.element is app.element.hydrogen


def _choose(topology, positions, isWanted):
    """Return the topology and the positions of some atoms."""
    atoms = list(topology.atoms())
    modeller = app.Modeller(topology, np.zeros((len(atoms), 3)) * unit.nanometer)
    modeller.delete([atom for atom in atoms if not isWanted(atom)])
    return modeller.topology, positions[[atom.index for atom in atoms if isWanted(atom)]]


# ---- Systems in AMBER14 ----


class Method(NamedTuple):
    """The energy apart from bonded terms: its name, the cutoff of a reaction field (nm), a file of implicit solvent."""

    name: str
    cutoff: float | None
    solvent: str | None = None


REACTION_FIELD, NO_CUTOFF = Method("reaction field 1.0 nm", 1.0), Method("no cutoff", None)
IMPLICIT_SOLVENT = Method("GBn2, no cutoff", None, "implicit/gbn2.xml")

BACKBONE, SIDE_CHAINS = "backbone", "side chains"  # which torsions a move turns

# The moves of examples/sample_protein.py: weight, largest angle in degrees, and which torsions.
EXAMPLE_MOVES = ((1.0, 1, BACKBONE), (1.0, 10, SIDE_CHAINS), (0.5, 180, SIDE_CHAINS))
TRIALS_PER_OUTER_TEST = 400  # the default


@cache
def _readForceField(*files):
    return app.ForceField("amber14-all.xml", *files)


class Protein:
    """A protein or nucleic acid with hydrogens, in AMBER14.

    name : str; topology : openmm.app.Topology; positions : (n, 3) float64 array, nm
    """

    def __init__(self, name, topology, positions):
        """Take what readProtein has read."""
        self.name, self.topology, self.positions = name, topology, positions
        self._evaluators = {}

    @cached_property
    def torsions(self):
        """The Torsions that turn, numbered as in the force."""
        return findTorsions(self.topology, self.positions, _KINDS).torsions

    def torsionsOf(self, which):
        """Return the numbers of the torsions of BACKBONE or of SIDE_CHAINS."""
        isWanted = [(torsion.kind in _BACKBONE_KINDS) == (which == BACKBONE) for torsion in self.torsions]
        return np.flatnonzero(isWanted).tolist()

    def makeSystem(self, method, sterics=True, constraints=None):
        """Make the System of a Method, with or without hard spheres, and with OpenMM's constraints."""
        nonbonded = {"nonbondedMethod": app.NoCutoff}
        if method.cutoff is not None:
            nonbonded = {"nonbondedMethod": app.CutoffNonPeriodic, "nonbondedCutoff": method.cutoff * unit.nanometer}
        files = [] if method.solvent is None else [method.solvent]
        system = _readForceField(*files).createSystem(self.topology, constraints=constraints, **nonbonded)
        if sterics:
            system.addForce(self.makeForce())
        return system

    def makeForce(self):
        """Make the StericExclusionForce."""
        return createStericExclusionForce(self.topology, self.positions, torsions=self.torsions)

    def makeSimulation(self, system, seed, native=True, moves=EXAMPLE_MOVES):
        """Make a Simulation on the CPU platform with one thread, or else on the Reference platform.

        The moves, by default those of examples/sample_protein.py, turn one torsion each.
        """
        integrator = TorsionMonteCarloIntegrator(TEMPERATURE * unit.kelvin)
        integrator.setRandomNumberSeed(seed)
        integrator.setNativeEnergies(native)
        for weight, angle, which in moves:
            integrator.addTorsionMove(weight, angle * unit.degree, self.torsionsOf(which))
        name, properties = (CPU, [{"Threads": "1"}]) if hasCPU() else ("Reference", [])
        platform = openmm.Platform.getPlatformByName(name)
        simulation = app.Simulation(self.topology, system, integrator, platform, *properties)
        simulation.context.setPositions(self.positions)
        return simulation

    def relaxed(self, trials, method=REACTION_FIELD):
        """Return the protein after trials of these moves: hydrogens of a crystal structure lie anywhere."""
        perStep = min(trials, 100 if method.solvent is None else TRIALS_PER_OUTER_TEST)
        simulation = self.makeSimulation(self.makeSystem(method), 1)
        simulation.integrator.setTrialsPerStep(perStep)
        simulation.step(trials // perStep)
        return Protein(self.name, self.topology, positionsOf(simulation.context))

    def makeScene(self):
        """Make the Scene of hard spheres for the program."""
        force = excludeClashes(self.makeForce(), self.positions)
        return makeScene(force, self.positions, [torsion.kind not in _BACKBONE_KINDS for torsion in self.torsions])

    def evaluator(self, method, platformName):
        """Return a function of positions, nm, that returns OpenMM's energy on a platform, kJ/mol."""
        key = method.name, platformName
        if key not in self._evaluators:
            properties = {"Threads": "1"} if platformName == CPU else {}
            platform = openmm.Platform.getPlatformByName(platformName)
            system = self.makeSystem(method, sterics=False)
            self._evaluators[key] = openmm.Context(system, openmm.VerletIntegrator(0.001), platform, properties)
        context = self._evaluators[key]

        def evaluate(positions):
            context.setPositions(positions)
            return context.getState(energy=True).getPotentialEnergy()._value

        return evaluate


def positionsOf(context):
    """Return the positions of a Context as an (n, 3) float64 array, nm."""
    return context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)


def readProtein(path=None):
    """Read the polymers of a structure, by default the villin headpiece, and add hydrogens if there are none."""
    structure = readStructure(path)
    modeller = app.Modeller(structure.topology, structure.positions * unit.nanometer)
    isPolymer = lambda residue: aminoAcid(residue.name) is not None or isNucleotide(residue.name)  # noqa: E731
    modeller.delete([residue for residue in structure.topology.residues() if not isPolymer(residue)])
    if not any(map(_isHydrogen, modeller.topology.atoms())):
        modeller.addHydrogens(_readForceField())
    positions = np.array(modeller.positions.value_in_unit(unit.nanometer), dtype=np.float64)
    return Protein(nameOf(path), modeller.topology, positions)


def prepare(options, files, quickTrials, method=REACTION_FIELD):
    """Return functions that make the Proteins to measure, relaxed, by names; and lines about files that are missing.

    quickTrials : the number of trials of a quick run, and of its relaxation
    """
    if options.quick and options.trials is None:
        options.trials = quickTrials
    paths, skipped = findStructures(options, files)
    trials = quickTrials if options.quick else options.warm
    return {nameOf(path): cache(lambda path=path: readProtein(path).relaxed(trials, method)) for path in paths}, skipped
