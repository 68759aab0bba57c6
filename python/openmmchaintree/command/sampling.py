"""Torsion-space Monte Carlo of the moving parts of a Plan, with everything else as obstacles."""

from typing import NamedTuple

import numpy as np
import openmm
from openmm import unit

from ..defaultmoves import addMovesOfPlan
from ..errors import InputError, UnknownRadiusError
from ..imageclashes import noteOnImages, noteOnOtherCopies
from ..images import vectorsOf
from ..moveadder import NamedMove
from ..movescene import MoveScene
from ..naming import nameAtom
from ..openmmchaintree import TorsionMonteCarloIntegrator
from ..replicas.segment import makeModel
from ..shape import Shape
from ..sterics import makeForce
from . import allpairs
from .energies import Energies
from .energymodel import HARD, OFF, repeatablePlatform
from .fixedparticles import fixParticles
from .flexible import addAtomMove, findScales
from .geometry import BondLengths, dihedrals
from .plan import Choice, Plan


class _MoveKind(NamedTuple):
    """Torsions that share moves: their name, their kinds, and (weight, largest angle in degrees) of each move."""

    name: str
    kinds: tuple[str, ...]
    moves: tuple[tuple[float, int], ...]


_PEPTIDE = ("phi", "psi")
_NUCLEIC = ("alpha", "beta", "gamma", "delta", "epsilon", "zeta")
_SIDE_CHAINS = ("chi1", "chi2", "chi3", "chi4", "chi")

# Moves for hard spheres alone: small steps loosen a compact structure, then large ones find new conformations.
# With energies, `addDefaultMoves` chooses the moves.
_MOVE_KINDS = (
    _MoveKind("φ/ψ", _PEPTIDE, ((2.0, 5), (1.0, 30), (1.0, 180))),
    _MoveKind("ω", ("omega",), ((1.0, 5), (0.5, 180))),
    _MoveKind("α–ζ", _NUCLEIC, ((2.0, 5), (1.0, 30), (1.0, 180))),
    _MoveKind("χ", _SIDE_CHAINS, ((1.0, 30), (1.0, 180))),
    _MoveKind("rotor", ("rotor",), ((0.5, 180),)),
    _MoveKind("others", ("planar", "other"), ((1.0, 30), (1.0, 180))),
)

# Closed moves in rings and loops.
_CLOSED_WEIGHT, _CLOSED_STEP = 2.0, 12  # degrees


class ShownAngles(NamedTuple):
    """The angles of a conformation in rad that the picture shows.

    phiPsi : (residues, 2) array, of residues in which φ and ψ rotate
    torsions : array, of all torsions; empty if there are such residues
    """

    phiPsi: np.ndarray
    torsions: np.ndarray


class Sampling:
    """What a run samples, made from a Structure and a Choice: its Context, moves and energies, and checks of positions.

    Attributes
    ----------
    structure : Structure
    force, integrator, context
        the OpenMM objects of the run
    plan : Plan
        the moving and the fixed parts
    torsions : list of Torsion
        the torsions of the plan
    notes : list of Note
        the notes of the plan, and on periodic images
    fixedAtoms : int
        number of atoms that are obstacles
    moves : list of NamedMove
        in the order of the integrator's moves
    startOverlaps : allpairs.Overlaps
        computed without the engine
    shape : Shape
        of the moving molecules
    startEnergy : float or None
        U at the start, kJ/mol; None for hard spheres alone
    energies : Energies or None
        the parts of U; None for hard spheres alone
    isFlexible : bool
        whether bond lengths and angles change
    """

    def __init__(self, structure, seed, choice=Choice(), energyModel=None):  # noqa: B008 (a tuple)
        """Make the System and the Context, with the energies of an EnergyModel if given.

        Raises
        ------
        InputError
            if nothing can move, a selection is wrong, an element has no radius, or the force field does not match
        """
        self.structure = structure
        self.plan = plan = Plan(structure, choice)
        self.torsions = plan.torsions
        try:
            self.force = makeForce(self.plan.graph, self.torsions, unknownRadius=choice.unknownRadius)
        except UnknownRadiusError as error:
            raise InputError(f"{error.note}: --unknown-radius gives them one") from error
        self.notes = list(self.plan.notes)
        box = structure.box if choice.periodic else None
        if box is None:
            names = [nameAtom(atom) for atom in structure.topology.atoms()]
            note = noteOnImages(self.force, structure.positions, structure.box, names, structure.spaceGroup)
            self.notes += [] if note is None else [note]
        else:
            self.notes += [noteOnOtherCopies(structure.spaceGroup)] if structure.spaceGroup else []
            self.force.setUsesPeriodicBoundaryConditions(True)
            structure.topology.setPeriodicBoxVectors(vectorsOf(box) * unit.nanometer)
        self.fixedAtoms = int(self.plan.fixed.sum())
        elements = [atom.element for atom in structure.topology.atoms()]
        masses = {element: element.mass.value_in_unit(unit.dalton) for element in set(elements) - {None}}
        masses[None] = 0.0
        self._masses = np.array([masses[element] for element in elements])
        self.shape = Shape(structure.topology, structure.positions, self._masses, plan.inMovingMolecules)
        temperature = 300.0 if energyModel is None else energyModel.temperature
        self.integrator = TorsionMonteCarloIntegrator(temperature * unit.kelvin)
        self.integrator.setRandomNumberSeed(seed)
        system = self._makeSystem(energyModel, box)
        if energyModel is None:
            self.moves = self._addMovesOfSpheres(system)
            if not self.moves:
                raise InputError(
                    "all torsions lie in loops and rings that --close keeps, and these have too few for closed moves: "
                    "add kinds of torsions (--torsions), or fix fewer atoms (--fix)"
                )
        else:
            try:
                self.moves = addMovesOfPlan(
                    self.integrator,
                    structure.topology,
                    system,
                    plan.torsions,
                    plan.rigidBodies,
                    choice.areDisordered,
                )
            except ValueError as error:  # a file may have added particles
                raise InputError(str(error)) from error
            self.integrator.setTrialsPerOuterTest(energyModel.trialsPerOuterTest)
            self.integrator.setNativeEnergies(energyModel.areNative)
            if energyModel.steric is not None:
                isOff = energyModel.steric == OFF
                self.integrator.setStericMode(self.integrator.Off if isOff else self.integrator.Hard)
        platform = (openmm.Platform.getPlatformByName("Reference"),) if energyModel is None else repeatablePlatform()
        self.isFlexible = energyModel is not None and energyModel.isFlexible
        if self.isFlexible:
            self.moves.append(addAtomMove(self.integrator, self.moves))
            if energyModel.areNative:  # else it would take minutes
                scales = findScales(self.integrator, system, structure.positions, platform)
                self.integrator.setMoveScales(len(self.moves) - 1, scales)
        self.context = openmm.Context(system, self.integrator, *platform)
        self.context.setPositions(structure.positions)
        self.energies = None if energyModel is None else Energies(energyModel, self.integrator, self.context)
        self._phiPsiParticles = _phiPsiParticles(self.torsions)
        shown = [] if len(self._phiPsiParticles) else [torsion.particles for torsion in self.torsions]
        self._torsionParticles = np.array(shown, dtype=int).reshape(-1, 4)
        self._spheres = allpairs.HardSpheres(self.force, box)
        self.startOverlaps = self._spheres.overlaps(structure.positions)
        self._bonds = BondLengths(self.force, structure.positions)
        self.startEnergy = None if self.energies is None else self.energies.held()

    def _makeSystem(self, energyModel, box):
        if energyModel is None:
            system = openmm.System()
            for mass in self._masses.tolist():
                system.addParticle(mass)
        else:
            system, notes = energyModel.makeSystem(self.structure)
            self.notes += notes
        fixParticles(system, self.plan)
        system.addForce(self.force)
        if box is not None:
            system.setDefaultPeriodicBoxVectors(*vectorsOf(box))
        return system

    def _addMovesOfSpheres(self, system):
        moves = []
        scene = MoveScene(self.structure.topology, system, self.torsions)
        inRings = scene.findRings()
        backbones = [i for i, torsion in enumerate(self.torsions) if torsion.kind in _PEPTIDE + _NUCLEIC]
        if inRings and scene.canClose(pool := sorted(inRings.union(backbones))):
            self.integrator.addClosedMove(_CLOSED_WEIGHT, _CLOSED_STEP * unit.degrees, pool)
            moves.append(NamedMove(f"closed {_CLOSED_STEP}°", _CLOSED_WEIGHT))
        for name, kinds, sizes in _MOVE_KINDS:
            torsions = [i for i, one in enumerate(self.torsions) if one.kind in kinds and i not in inRings]
            # Weights of protein and nucleic backbones are proportional to their numbers of torsions.
            share = len(torsions) / len(backbones) if kinds in (_PEPTIDE, _NUCLEIC) and torsions else 1.0
            for weight, degrees in sizes if torsions else ():
                self.integrator.addTorsionMove(share * weight, degrees * unit.degrees, torsions)
                moves.append(NamedMove(f"{name} ±{degrees}°", share * weight))
        if self.plan.rigidBodies:
            self.integrator.addRigidBodyMove(1.0, 0.01 * unit.nanometer, 1 * unit.degrees, self.plan.rigidBodies)
            moves.append(NamedMove("rigid body 0.01 nm, ±1°", 1.0))
        return moves

    @property
    def isHard(self):
        """Whether overlapping atoms are forbidden."""
        return not self.integrator.hasSpheresOff()

    @property
    def stericMode(self):
        """The steric mode, as in the option --steric: HARD or OFF."""
        return HARD if self.isHard else OFF

    def positions(self):
        """Return the positions of the Context, a float64 array of shape (n, 3) in nm."""
        return self.context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)

    def overlaps(self, positions):
        """Return the Overlaps of spheres at positions, computed without the engine."""
        return self._spheres.overlaps(positions)

    def check(self, positions):
        """Check positions by comparing all pairs without the engine: an allpairs.Verdict."""
        return allpairs.compare(self.startOverlaps, self.overlaps(positions))

    def checkBonds(self, positions):
        """Compare bond lengths at positions with the start: a BondVerdict."""
        return self._bonds.compare(positions)

    def takeUp(self, checkpoint):
        """Load the checkpoint of a replica of this run; None is the start."""
        if checkpoint is not None:
            self.context.loadCheckpoint(checkpoint)

    def energyByOpenMM(self):
        """Return U of the Context's positions by OpenMM's Reference platform, kJ/mol."""
        return self.energies.byOpenMM(self.positions())[0]

    def model(self):
        """Return the Model of replicas with the same start as this run."""
        platform = self.context.getPlatform()
        names = platform.getPropertyNames() if self.energies is not None else ()
        properties = {name: platform.getPropertyValue(self.context, name) for name in names if name == "Threads"}
        return makeModel(
            self.context.getSystem(),
            self.integrator,
            self.structure.positions,
            platform.getName(),
            properties,
            self.energies is not None,
        )

    def shownAngles(self, positions):
        """Return the ShownAngles of positions."""
        return ShownAngles(
            dihedrals(positions, self._phiPsiParticles).reshape(-1, 2), dihedrals(positions, self._torsionParticles)
        )


def _phiPsiParticles(torsions):
    """Return the particles of φ, ψ, φ, ψ, … of residues in which both rotate, as a (2 m, 4) array."""
    byResidue = {}
    for torsion in torsions:
        if torsion.kind in _PEPTIDE:
            byResidue.setdefault(torsion.residue.index, {})[torsion.kind] = torsion.particles
    pairs = [(found["phi"], found["psi"]) for found in byResidue.values() if len(found) == 2]
    return np.array(pairs, dtype=int).reshape(-1, 4)
