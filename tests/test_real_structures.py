"""Real structures, through every layer of the plugin, against the long-double oracle.

Lists and verdicts must be the oracle's wherever a pair is not within SIGMA of what decides; forces must be the oracle's
gradient and the central differences of the energy.
"""

import os
import warnings
from pathlib import Path

import numpy as np
import openmm
import openmm.app
import pytest
from openmm import unit
from openmmchaintree import createStericExclusionForce
from oraclescene import TRIAL, OracleScene

SIGMA = 1e-9

# Limits that a start gives are SIGMA above its overlaps, so that it is free itself: that must be decided, too.
UNDECIDED = 0.99 * SIGMA

# Positions (nm) that the engine and the oracle have reached by the same trials.
SAME_POSITION = 1e-11

CUTOFFS = (0.5, 0.8, 1.2)
TRIALS = 2000
FEWER_TRIALS = {"4hhb": 1000, "6msm": 500}  # the oracle compares all pairs of these
KINDS = ("phi", "psi", "omega", "chi", "rotor")

# name: arguments of createStericExclusionForce, names of residues of mass 0
STRUCTURES = {
    "villin": ({}, ()),
    "1shg": ({}, ()),
    "1ctf": ({}, ()),
    "1ubi_h": ({}, ()),
    "bpti_h": ({}, ()),
    "bpti_h, disulfides cut": ({"cutDisulfides": True}, ()),
    "5dfr_h": ({}, ()),
    "4hhb": ({}, ("HEM",)),
    "6msm": ({}, ()),
}


def structurePath(name):
    if name == "villin":
        return Path(openmm.app.__file__).parent / "data" / "test.pdb"
    folder = os.environ.get("CHAINTREE_TEST_DATA")
    if not folder:
        pytest.skip("CHAINTREE_TEST_DATA, the folder of real structures, is not set")
    return Path(folder) / f"{name.split(',')[0]}.pdb"


class Sampled:
    """A structure without its water in a Context on the Reference platform, and the oracle's scene of the same."""

    def __init__(self, name):
        arguments, fixedResidues = STRUCTURES[name]
        pdb = openmm.app.PDBFile(str(structurePath(name)))
        modeller = openmm.app.Modeller(pdb.topology, pdb.positions)
        modeller.deleteWater()
        self.numTrials = FEWER_TRIALS.get(name, TRIALS)
        self.start = np.array(modeller.positions.value_in_unit(unit.nanometer))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # notes on omitted parts are tested elsewhere
            self.force = createStericExclusionForce(modeller.topology, self.start, torsions=KINDS, **arguments)
        self.topology = modeller.topology
        self.system = openmm.System()
        for atom in self.topology.atoms():
            self.system.addParticle(0 if atom.residue.name in fixedResidues else atom.element.mass)
        self.system.addForce(self.force)
        self.context = openmm.Context(
            self.system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatformByName("Reference")
        )
        self.oracle = OracleScene(self.system, self.force, self.start)
        links = self.oracle.links
        self.movable = [i for i in range(len(self.start)) if not links.isFixed(links.molecules[i])]

    def setPositions(self, positions):
        """Move both there; pairs that clash there get their overlap as limit."""
        self.context.setPositions(positions)
        self.oracle.setPositions(positions)
        self.restartLimits()

    def restartLimits(self):
        """Give the oracle's pairs that clash their overlap as limit, as the plugin does."""
        pairs, overlaps, margins = self.oracle.clashes(0)
        assert np.all(margins > SIGMA), "a pair is too near to its tolerance for this test"
        self.oracle.setLimits(pairs, overlaps + SIGMA)

    def positions(self):
        return self.context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)

    def energy(self):
        return self.context.getState(energy=True).getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)

    def forces(self):
        forces = self.context.getState(forces=True).getForces(asNumpy=True)
        return forces.value_in_unit(unit.kilojoule_per_mole / unit.nanometer)


@pytest.fixture(scope="module", params=STRUCTURES, ids=lambda name: name.replace(", ", "-").replace(" ", "-"))
def sampled(request):
    return Sampled(request.param)


def asKeys(pairs, count):
    return pairs[:, 0].astype(np.int64) * count + pairs[:, 1]


def assertSameList(sampled, pairs, values, oraclePairs, oracleValues, mayMiss):
    """Compare sorted lists of pairs. The oracle's list includes pairs that the plugin may miss."""
    keys, oracleKeys = asKeys(pairs, len(sampled.start)), asKeys(oraclePairs, len(sampled.start))
    assert np.all(np.diff(keys) > 0)
    isListed = np.isin(oracleKeys, keys)
    assert np.all(isListed | mayMiss), f"missing: {oraclePairs[~isListed & ~mayMiss][0]}"
    assert np.count_nonzero(isListed) == len(keys), f"not the oracle's: {pairs[~np.isin(keys, oracleKeys)][0]}"
    assert np.abs(values - oracleValues[isListed]).max(initial=0) < SIGMA


def assertSameClashes(sampled):
    pairs, overlaps = sampled.force.getClashes(sampled.context)
    oraclePairs, oracleOverlaps, margins = sampled.oracle.clashes(SIGMA)
    assertSameList(sampled, pairs, overlaps, oraclePairs, oracleOverlaps, margins <= SIGMA)
    assert sampled.force.hasClash(sampled.context) == (len(pairs) > 0)


def assertSameNeighborPairs(sampled, cutoff):
    pairs, distances = sampled.force.getNeighborPairs(sampled.context, cutoff)
    oraclePairs, oracleDistances = sampled.oracle.neighborPairs(cutoff + SIGMA)
    assert len(pairs) > len(sampled.start)
    assertSameList(sampled, pairs, distances, oraclePairs, oracleDistances, oracleDistances >= cutoff - SIGMA)


def assertSameChangedPairs(sampled, cutoff):
    pairs, before, after = sampled.force.getChangedNeighborPairs(sampled.context, cutoff)
    oraclePairs, oracleBefore, oracleAfter = sampled.oracle.changedPairs(cutoff + SIGMA)
    mayMiss = np.minimum(oracleBefore, oracleAfter) >= cutoff - SIGMA
    assertSameList(sampled, pairs, before, oraclePairs, oracleBefore, mayMiss)
    assertSameList(sampled, pairs, after, oraclePairs, oracleAfter, mayMiss)


def test_gaps_disulfides_and_obstacles_are_there():
    """What three of the structures were chosen for."""
    whole, cut = Sampled("bpti_h"), Sampled("bpti_h, disulfides cut")
    assert cut.force.getNumTorsions() > whole.force.getNumTorsions()

    hemoglobin = Sampled("4hhb")
    molecules = hemoglobin.oracle.links.molecules
    assert sum(hemoglobin.oracle.links.isFixed(molecule) for molecule in range(molecules.max() + 1)) == 4

    gapped = Sampled("6msm")
    chain = max(gapped.topology.chains(), key=len)
    fragments = {gapped.oracle.links.molecules[atom.index] for atom in chain.atoms()}
    assert 1 < len(fragments) < len(gapped.oracle.links.roots)


def test_lists_equal_the_oracles(sampled):
    sampled.setPositions(sampled.start)
    assertSameClashes(sampled)
    for cutoff in CUTOFFS:
        assertSameNeighborPairs(sampled, cutoff)


class Trials:
    """Draws trials, of all kinds and sizes, for both."""

    def __init__(self, sampled, seed):
        self._sampled = sampled
        self._random = np.random.default_rng(seed)

    def uniform(self):
        return self._random.uniform()

    def propose(self):
        """Open a trial and return the plugin's verdict."""
        return self._proposeRigidMotion() if self.uniform() < 0.2 else self._proposeTorsions()

    def _drawSize(self, largest):
        return largest * 10 ** self._random.uniform(-4, 0)

    def _proposeTorsions(self):
        force, random = self._sampled.force, self._random
        count = 1 if self.uniform() < 0.6 else random.integers(2, 12)
        torsions = random.choice(force.getNumTorsions(), size=count, replace=False)
        changes = random.uniform(-1, 1, size=count) * self._drawSize(np.pi)
        self._sampled.oracle.proposeTorsions(torsions, changes)
        return force.proposeTorsions(self._sampled.context, torsions, changes)

    def _proposeRigidMotion(self):
        particle = int(self._random.choice(self._sampled.movable))
        rotation = self._random.normal(size=3) * self._drawSize(1)
        translation = self._random.normal(size=3) * self._drawSize(0.5)
        self._sampled.oracle.proposeRigidMotion(particle, rotation, translation)
        return self._sampled.force.proposeRigidMotion(self._sampled.context, particle, rotation, translation)


def test_verdicts_equal_the_oracles(sampled):
    sampled.setPositions(sampled.start)
    trials = Trials(sampled, 2002)
    verdicts = {True: 0, False: 0}
    undecided = 0
    clashFree, hasClashed = sampled.start, False
    for trial in range(sampled.numTrials):
        isFree = trials.propose()
        margin, worstPair = sampled.oracle.worstTrialMargin()
        if abs(margin) < UNDECIDED:
            undecided += 1
        else:
            assert isFree == (margin < 0), f"trial {trial}: the worst pair is {worstPair}, its margin {margin} nm"
            verdicts[isFree] += 1

        if trial % 50 == 0:
            proposed = sampled.force.getProposedPositions(sampled.context)
            assert np.abs(proposed - sampled.oracle.positions(TRIAL)).max() < SAME_POSITION
            assertSameChangedPairs(sampled, CUTOFFS[0])

        if trials.uniform() < (0.5 if isFree else 0.02):
            sampled.force.acceptProposal(sampled.context)
            sampled.oracle.accept()
            if not isFree:
                sampled.restartLimits()
            hasClashed = hasClashed or not isFree
            if not hasClashed:
                clashFree = sampled.positions()
        elif trials.uniform() < 0.5:
            sampled.force.rejectProposal(sampled.context)
        # A structure with a clash refuses nearly everything, so it is left again after a while.
        if hasClashed and trials.uniform() < 0.05:
            sampled.setPositions(clashFree)
            hasClashed = False

    assert min(verdicts.values()) > sampled.numTrials / 10
    assert undecided < sampled.numTrials / 100
    assert np.abs(sampled.positions() - sampled.oracle.positions()).max() < SAME_POSITION
    assert np.abs(sampled.positions() - sampled.start).max() > 0.1
    assertSameClashes(sampled)
    assertSameNeighborPairs(sampled, CUTOFFS[0])


def test_forces_equal_differences_of_the_energy(sampled):
    """At perturbed positions, where bonds are broken and many pairs clash."""
    random = np.random.default_rng(1)
    positions = sampled.start + random.normal(scale=0.03, size=sampled.start.shape)
    sampled.setPositions(positions)
    k = sampled.force.getForceConstant().value_in_unit(unit.kilojoule_per_mole / unit.nanometer**2)
    energy, forces = sampled.energy(), sampled.forces()
    oracleEnergy, oracleForces = sampled.oracle.energy(k)
    assert energy == pytest.approx(oracleEnergy, rel=1e-10)
    largest = np.abs(oracleForces).max()
    np.testing.assert_allclose(forces, oracleForces, rtol=0, atol=1e-10 * largest)

    # Along all forces at once, and for single coordinates.
    step = 1e-7
    pushed = np.flatnonzero(np.linalg.norm(forces, axis=1) > 1e-3 * largest)
    assert len(pushed) > 20
    directions = [forces / np.linalg.norm(forces)]
    for particle in random.choice(pushed, size=20, replace=False):
        direction = np.zeros_like(positions)
        direction[particle] = random.normal(size=3)
        directions.append(direction / np.linalg.norm(direction))
    for direction in directions:
        energies = []
        for sign in (-1, 1):
            sampled.context.setPositions(positions + sign * step * direction)
            energies.append(sampled.energy())
        slope = (energies[1] - energies[0]) / (2 * step)
        # Within a step of its limit a pair is on one side of it only: then k * step / 4 is missing.
        assert -slope == pytest.approx(np.vdot(forces, direction), rel=1e-6, abs=k * step)
