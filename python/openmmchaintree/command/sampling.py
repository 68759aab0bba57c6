"""The main job: athermal torsion-space Monte Carlo of a protein, with everything else as fixed obstacles."""

import warnings
from time import perf_counter
from typing import NamedTuple

import numpy as np
import openmm
from openmm import unit

from ..bonds import molecules, neighborLists
from ..errors import InputError
from ..openmmchaintree import TorsionMonteCarloIntegrator
from ..sterics import createStericExclusionForce
from ..torsions import findTorsions
from . import allpairs
from .geometry import dihedrals, radiusOfGyration

# Protein torsions only: bases and sugars stay as they are.
KINDS = ("phi", "psi", "chi1", "chi2", "chi3", "chi4")
_BACKBONE = ("phi", "psi")

# So often can a run be interrupted, whatever the number of trials between frames.
_TRIALS_PER_STEP = 10000


class Move(NamedTuple):
    """A kind of trial: its name in tables and how often it is drawn relative to the others."""

    name: str
    weight: float


class Frame(NamedTuple):
    """What is kept of a conformation. Counts are those of each move since the start: (moves, 4)."""

    trials: int
    phiPsi: np.ndarray
    radiusOfGyration: float
    counts: np.ndarray


class Sampling:
    """One run: made from a Structure, advanced by `run`, judged by `check`.

    Attributes
    ----------
    force, integrator, context
        what runs
    torsions : list of Torsion
    notes : list of str
        what was left out, and why
    fixedAtoms : int
        number of atoms that are obstacles
    moves : list of Move
        in the order of the integrator's moves
    startOverlaps : allpairs.Overlaps
        found without the engine
    frames : list of Frame
        the start and what followed
    trials : int
        number of trials so far
    seconds : float
        wall-clock time within the integrator so far
    """

    def __init__(self, structure, seed, cutDisulfides=False):
        """Make the System and the Context, ready to run.

        Raises
        ------
        InputError
            if the structure has no torsion of a protein, or an element without radius
        """
        self._structure = structure
        self.torsions = findTorsions(structure.topology, structure.positions, KINDS, cutDisulfides).torsions
        if not self.torsions:
            raise InputError("there is no torsion of a protein (phi, psi, chi) to sample")
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                self.force = createStericExclusionForce(
                    structure.topology, structure.positions, torsions=KINDS, cutDisulfides=cutDisulfides
                )
            except ValueError as error:
                raise InputError(str(error)) from error
        self.notes = [str(warning.message) for warning in caught]
        system, self._masses, movableMolecules = self._makeSystem()
        self.fixedAtoms = int((self._masses == 0).sum())
        self.integrator = TorsionMonteCarloIntegrator(300 * unit.kelvin)
        self.integrator.setRandomNumberSeed(seed)
        self.moves = self._addMoves(movableMolecules)
        self.context = openmm.Context(system, self.integrator, openmm.Platform.getPlatformByName("Reference"))
        self.context.setPositions(structure.positions)
        self._phiPsiParticles = _phiPsiParticles(self.torsions)
        self._spheres = allpairs.HardSpheres(self.force)
        self.startOverlaps = self._spheres.overlaps(structure.positions)
        self.frames = []
        self.trials = 0
        self.seconds = 0.0
        self._keepFrame(structure.positions)

    def _makeSystem(self):
        """Make the System; molecules without torsions get the mass 0. Return it, the masses, the movable molecules."""
        bonds = [self.force.getBondParticles(i) for i in range(self.force.getNumBonds())]
        atoms = list(self._structure.topology.atoms())
        molecule = np.array(molecules(neighborLists(len(atoms), bonds)))
        movable = np.unique([molecule[torsion.particles[1]] for torsion in self.torsions])
        masses = np.array([atom.element.mass.value_in_unit(unit.dalton) for atom in atoms])
        masses[~np.isin(molecule, movable)] = 0.0
        system = openmm.System()
        for mass in masses.tolist():
            system.addParticle(mass)
        system.addForce(self.force)
        return system, masses, movable

    def _addMoves(self, movableMolecules):
        backbone = [i for i, torsion in enumerate(self.torsions) if torsion.kind in _BACKBONE]
        sideChains = [i for i, torsion in enumerate(self.torsions) if torsion.kind not in _BACKBONE]
        moves = []

        def addTorsionMove(name, weight, degrees, torsions):
            if torsions:
                self.integrator.addTorsionMove(weight, degrees * unit.degrees, torsions)
                moves.append(Move(f"{name} ±{degrees}°", weight))

        # Small steps loosen a compact structure; once it is loose, large ones find new conformations.
        addTorsionMove("φ/ψ", 2.0, 5, backbone)
        addTorsionMove("φ/ψ", 1.0, 30, backbone)
        addTorsionMove("φ/ψ", 1.0, 180, backbone)
        addTorsionMove("χ", 1.0, 30, sideChains)
        addTorsionMove("χ", 1.0, 180, sideChains)
        if len(movableMolecules) > 1:
            self.integrator.addRigidBodyMove(1.0, 0.01 * unit.nanometer, 1 * unit.degrees)
            moves.append(Move("rigid body 0.01 nm, ±1°", 1.0))
        return moves

    def run(self, trials, proceed):
        """Run a number of trials, or until proceed(), called now and then, says no; keep a frame.

        Return the positions, a float64 array of shape (n, 3) in nm.
        """
        end = self.trials + trials
        going = True
        while going and self.trials < end:
            count = min(end - self.trials, _TRIALS_PER_STEP)
            self.integrator.setTrialsPerStep(count)
            start = perf_counter()
            self.integrator.step(1)
            self.seconds += perf_counter() - start
            self.trials += count
            going = proceed()
        positions = self._positions()
        self._keepFrame(positions)
        return positions

    def statistics(self):
        """Return the MoveStatistics of each move."""
        return [self.integrator.getMoveStatistics(i) for i in range(len(self.moves))]

    def check(self):
        """Judge the Context's positions by comparing all pairs, without the engine: an allpairs.Verdict."""
        return allpairs.compare(self.startOverlaps, self._spheres.overlaps(self._positions()))

    def _positions(self):
        return self.context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)

    def _keepFrame(self, positions):
        movable = self._masses > 0
        frame = Frame(
            trials=self.trials,
            phiPsi=dihedrals(positions, self._phiPsiParticles).reshape(-1, 2),
            radiusOfGyration=radiusOfGyration(positions[movable], self._masses[movable]),
            counts=np.array(self.statistics()),
        )
        self.frames.append(frame)


def _phiPsiParticles(torsions):
    """Return the quadruples φ, ψ, φ, ψ, … of the residues of which both can turn, as a (2 m, 4) array."""
    byResidue = {}
    for torsion in torsions:
        if torsion.kind in _BACKBONE:
            byResidue.setdefault(torsion.residue.index, {})[torsion.kind] = torsion.particles
    pairs = [(found["phi"], found["psi"]) for found in byResidue.values() if len(found) == 2]
    return np.array(pairs, dtype=int).reshape(-1, 4)
