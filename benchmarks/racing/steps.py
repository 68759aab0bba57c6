"""Trials through Simulation.step, and what else in a System they must not pay for."""

import copy
import math
from typing import NamedTuple

import numpy as np
import openmm
from openmm import app, unit
from openmmchaintree import StericExclusionForce, TorsionMonteCarloIntegrator
from openmmchaintree.bonds import molecules, neighborLists

from .course import Course, measure, summarizeTimes
from .program import ProgramError
from .proteins import Model
from .races import ALL_CHAINS, Moves
from .scene import findLinks

_TRIALS_PER_STEP = 10000

_WATERS = 8000
_FAR_ATOMS = 100000
RESIDUES = 12

# Contestants.
ALONE, WITH_WATERS, WITH_FAR_ATOMS = "alone", f"with {_WATERS:,} waters", f"with {_FAR_ATOMS:,} far atoms"
WITHIN_WHOLE, BESIDE_REST = "within the whole", "beside the rest"


class Simulated(NamedTuple):
    """What a Simulation runs on.

    force : StericExclusionForce; positions : (n, 3) float64 array, nm; masses : (n,) float64 array, Da, 0 at rest;
    torsions : list of int, those of the force that turn
    """

    force: StericExclusionForce
    positions: np.ndarray
    masses: np.ndarray
    torsions: list[int]

    def start(self, seed, trials):
        """Return a Simulation that has gone a step, of a number of trials."""
        integrator = TorsionMonteCarloIntegrator(300 * unit.kelvin)
        integrator.setRandomNumberSeed(seed)
        integrator.setTrialsPerStep(trials)
        integrator.addTorsionMove(1.0, math.pi, self.torsions)
        system = openmm.System()
        for mass in self.masses.tolist():
            system.addParticle(mass)
        system.addForce(copy.copy(self.force))
        simulation = app.Simulation(app.Topology(), system, integrator, openmm.Platform.getPlatformByName("Reference"))
        simulation.context.setPositions(self.positions)
        simulation.step(1)
        return simulation

    def plus(self, radii, positions, masses, bonds=()):
        """Return a scene with more particles; bonds count from the first of them."""
        force = copy.copy(self.force)
        first = len(self.masses)
        for radius in radii:
            force.addParticle(radius)
        for particle1, particle2 in bonds:
            force.addBond(first + particle1, first + particle2)
        return Simulated(
            force, np.concatenate([self.positions, positions]), np.concatenate([self.masses, masses]), self.torsions
        )


def simulate(model):
    """Return the Simulated of a Model: all of it moves, and its backbone turns."""
    positions = model.protein.positions
    return Simulated(model.force, positions, np.ones(len(positions)), model.backboneTorsions())


class NeedRow(NamedTuple):
    """A protein alone, beside waters of radius 0, and beside fixed atoms that are far from it."""

    group: str
    chain: Model
    trials: int
    moves: Moves = Moves("uniform")
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return self.chain.name

    def run(self, course: Course, seed: int):
        """Return an entry for each of the three.

        Raises
        ------
        ProgramError
            if they do not accept the same number of trials
        """
        alone = simulate(self.chain)
        water = _lattice(3 * _WATERS, 0.2)
        bonds = [(oxygen, oxygen + k) for oxygen in range(0, 3 * _WATERS, 3) for k in (1, 2)]
        far = _lattice(_FAR_ATOMS, 0.4) + [100.0, 0.0, 0.0]
        variants = {
            ALONE: alone,
            WITH_WATERS: alone.plus(np.zeros(len(water)), water, np.ones(len(water)), bonds),
            WITH_FAR_ATOMS: alone.plus(np.full(len(far), 0.17), far, np.zeros(len(far))),
        }
        return _takeTurns(self, course, seed, self.chain.name, variants)


class PartRow(NamedTuple):
    """A few residues of a protein, at the end of a chain or before a gap in it: all else is at rest.

    Once as a part of the whole; once with the chain cut before them, so that the rest is but an obstacle.
    """

    group: str
    chain: Model
    trials: int
    moves: Moves = Moves("uniform")
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return f"{self.chain.name}, {RESIDUES} residues"

    def run(self, course: Course, seed: int):
        """Return an entry for each of the two.

        Raises
        ------
        ProgramError
            if they do not accept the same number of trials
        """
        part, cut = _findPart(self.chain)
        inWhole = _copyForce(self.chain.force, part)
        particleLinks, links = findLinks(inWhole, [False] * len(part))
        masses = np.array([float(links[link].parent >= 0) for link in particleLinks.tolist()])
        positions, torsions = self.chain.protein.positions, list(range(len(part)))
        variants = {
            WITHIN_WHOLE: Simulated(inWhole, positions, masses, torsions),
            BESIDE_REST: Simulated(_copyForce(self.chain.force, part, cut), positions, masses, torsions),
        }
        return _takeTurns(self, course, seed, str(self), variants)


def _takeTurns(row, course, seed, chain, variants):
    """Let Simulations go step by step, in turns; return an entry for each. Their trials must be accepted alike."""
    trials = course.trials or row.trials
    block = min(trials, _TRIALS_PER_STEP)
    simulations = {name: variant.start(seed, block) for name, variant in variants.items()}
    times = {name: [] for name in variants}
    for _ in range(trials // block):
        accepted = set()
        for name, simulation in simulations.items():
            times[name].append(measure(simulation.step, 1)[1] / block)
            accepted.add(simulation.integrator.getMoveStatistics(0).accepted)
        if len(accepted) > 1:
            raise ProgramError(f"of the same trials are accepted {' and '.join(map(str, sorted(accepted)))}")
    entries = []
    for name, variant in variants.items():
        attempted, *_, accepted = simulations[name].integrator.getMoveStatistics(0)
        entries.append(
            {
                "group": row.group,
                "chain": chain,
                "moves": str(row.moves),
                "particles": len(row.chain.protein.positions),
                "torsions": len(variant.torsions),
                "seed": seed,
                "trials": attempted - block,
                "asked": trials,
                "block": block,
                "contestant": name,
                "accepted": accepted / attempted,
                **summarizeTimes(times[name]),
            }
        )
    return entries


def _lattice(count, spacing):
    """Return so many places in a cube, some way from the origin, as a (count, 3) float64 array in nm."""
    side = math.ceil(count ** (1 / 3))
    return spacing * np.stack(np.unravel_index(np.arange(count), (side, side, side)), axis=1) + spacing


def _findPart(model):
    """Return the torsions of the last residues of the first molecule, and the bond before the residue before these."""
    force = model.force
    bonds = [tuple(force.getBondParticles(i)) for i in range(force.getNumBonds())]
    residues = np.array([atom.residue.index for atom in model.protein.topology.atoms()])
    ofMolecule = np.array(molecules(neighborLists(len(residues), bonds))) == 0
    firstOfPart = np.unique(residues[ofMolecule])[-RESIDUES]
    end = residues[ofMolecule].max()
    part = [i for i, torsion in enumerate(model.torsions) if firstOfPart <= torsion.residue.index <= end]
    cut = next(bond for bond in bonds if {*residues[list(bond)]} == {firstOfPart - 2, firstOfPart - 1})
    return part, cut


def _copyForce(force, torsions, withoutBond=None):
    """Copy a StericExclusionForce with some of its torsions."""
    copied = StericExclusionForce()
    copied.setOverlapTolerance(force.getOverlapTolerance())
    copied.setHydrogenBondAllowance(force.getHydrogenBondAllowance())
    for i in range(force.getNumParticles()):
        copied.addParticle(*force.getParticleParameters(i))
    for i in range(force.getNumBonds()):
        if tuple(force.getBondParticles(i)) != withoutBond:
            copied.addBond(*force.getBondParticles(i))
    for i in torsions:
        copied.addTorsion(*force.getTorsionParticles(i))
    for i in range(force.getNumExclusions()):
        copied.addExclusion(*force.getExclusionParticles(i))
    return copied
