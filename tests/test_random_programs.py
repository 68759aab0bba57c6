"""Random programs through the public API in Python, each answer compared with the long-double oracle.

Hypothesis chooses what happens next and shrinks a program that fails to the shortest that still does, which it prints
as the calls of a script. The programs are the same in each run; `pytest --hypothesis-seed=N` and a larger EXAMPLES look
at others.
"""

from collections import Counter
from dataclasses import dataclass

import hypothesis
import numpy as np
import openmm
import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, precondition, rule, run_state_machine_as_test
from openmm import unit
from openmmchaintree import StericExclusionForce, TorsionMonteCarloIntegrator
from oraclescene import STATE, TRIAL, OracleScene

EXAMPLES = 350
STEPS = 50

SIGMA = 1e-9
# Where one pair is within SIGMA of its tolerance, its limit may be that or, a little above it, the overlap.
DOUBT = 3 * SIGMA
SAME_NUMBER = 1e-10
# A trial of several torsions may leave out pairs that it moves relative to each other by less, such as those of what is
# before a closed window and what is behind it.
UNMOVED = 2.1e-11

FORCE_CONSTANT = 1000.0
KJ_NM2 = unit.kilojoule_per_mole / unit.nanometer**2

lengths = st.one_of(st.sampled_from([0.0, 0.1, 0.2]), st.floats(-0.5, 0.5))
vectors = st.tuples(lengths, lengths, lengths)
angles = st.one_of(st.sampled_from([0.0, np.pi, -np.pi, 2 * np.pi, 1e-9]), st.floats(-7, 7), st.floats(-0.2, 0.2))
cutoffs = st.one_of(st.sampled_from([0.1, 0.2]), st.floats(0.01, 1))
radii = st.one_of(st.sampled_from([0.0, 0.05, 0.1]), st.floats(0, 0.15))


@dataclass
class Molecule:
    """Beads bonded as a tree: bead i + 1 to bead parents[i], by a bond that may be able to turn."""

    parents: list[int]
    turning: list[bool]
    fixed: int | None


@st.composite
def molecules(draw):
    count = draw(st.one_of(st.integers(1, 6), st.integers(1, 40)))
    branches = draw(st.booleans())
    parents = [draw(st.integers(0, i - 1)) if branches else i - 1 for i in range(1, count)]
    turning = draw(st.lists(st.booleans(), min_size=count - 1, max_size=count - 1))
    fixed = draw(st.one_of(st.none(), st.integers(0, count - 1)))
    return Molecule(parents, turning, fixed)


def torsionAbout(neighbors, p2, p3):
    """Return a torsion about a bond, or None if it ends there."""
    p1, p4 = ({*neighbors[p2]} - {p3}, {*neighbors[p3]} - {p2})
    return (min(p1), p2, p3, max(p4)) if p1 and p4 else None


def makeSystem(chosen):
    """Return a System and the force in it, still without radii."""
    system, force = openmm.System(), StericExclusionForce()
    for molecule in chosen:
        first = system.getNumParticles()
        count = len(molecule.parents) + 1
        bonds = [(first + parent, first + i + 1) for i, parent in enumerate(molecule.parents)]
        neighbors = {first + i: [] for i in range(count)}
        for i in range(count):
            system.addParticle(0 if i == molecule.fixed else 1)
            force.addParticle(0)
        for i, j in bonds:
            force.addBond(i, j)
            neighbors[i].append(j)
            neighbors[j].append(i)
        for bond, turns in zip(bonds, molecule.turning, strict=True):
            torsion = torsionAbout(neighbors, *bond) if turns else None
            if torsion is not None:
                force.addTorsion(*torsion)
    system.addForce(force)
    return system, force


def makePositions(chosen, random, onLattice):
    """Return random walks along the bonds, in steps along the axes or anywhere."""
    positions = []
    for molecule in chosen:
        first = len(positions)
        positions.append(random.uniform(-0.5, 0.5, size=3).round(1))
        for parent in molecule.parents:
            step = random.normal(size=3)
            if onLattice:
                step = np.sign(step) * (np.abs(step) == np.abs(step).max())
            positions.append(positions[first + parent] + 0.2 * step / np.linalg.norm(step))
    return np.array(positions)


class Programs(RuleBasedStateMachine):
    """A Context, the oracle's scene of the same, and what both are told and asked."""

    done = Counter()

    # ---- The scene ----

    @initialize(
        chosen=st.lists(molecules(), min_size=1, max_size=5),
        seed=st.integers(0, 2**32 - 1),
        onLattice=st.booleans(),
        tolerance=st.sampled_from([0.0, 0.04]),
        allowance=st.sampled_from([0.0, 0.06]),
        bondCutoff=st.integers(0, 3),
    )
    def make(self, chosen, seed, onLattice, tolerance, allowance, bondCutoff):
        random = np.random.default_rng(seed)
        self.system, self.force = makeSystem(chosen)
        self.count = self.system.getNumParticles()
        self._drawParameters(random)
        self.force.setOverlapTolerance(tolerance)
        self.force.setHydrogenBondAllowance(allowance)
        self.force.setForceConstant(FORCE_CONSTANT)
        self.force.createExclusionsFromBonds(bondCutoff)
        if self.count > 1:
            self.force.addExclusion(0, self.count - 1)
        self.start = makePositions(chosen, random, onLattice)
        self.oracle = OracleScene(self.system, self.force, self.start)
        links = self.oracle.links
        self.movable = [i for i in range(self.count) if not links.isFixed(links.molecules[i])]
        self.integrator = self._makeIntegrator(seed)
        self.context = openmm.Context(self.system, self.integrator, openmm.Platform.getPlatformByName("Reference"))
        self.context.setPositions(self.start)
        self.isOpen = False
        self.limits = {}
        self.limitsAreCurrent = False
        self.checkpoint = None
        Programs.done["scenes"] += 1
        Programs.done["largest"] = max(Programs.done["largest"], self.count)

    def _drawParameters(self, random):
        scale = random.choice([0.03, 0.06, 0.1])
        for i in range(self.count):
            radius = 0 if random.random() < 0.1 else scale * random.uniform(0.7, 1.2)
            self.force.setParticleParameters(i, radius, int(random.integers(4)))

    def _makeIntegrator(self, seed):
        integrator = TorsionMonteCarloIntegrator(300)
        integrator.setRandomNumberSeed(1 + seed % 1000)
        integrator.setTrialsPerStep(20)
        self.hasMoves = self.force.getNumTorsions() > 0 or len(self.movable) > 0
        if self.force.getNumTorsions() > 0:
            integrator.addTorsionMove(1, 0.5)
        if self.movable:
            integrator.addRigidBodyMove(1, 0.05, 0.5)
        return integrator

    def positions(self):
        return self.context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)

    # ---- Limits: what clashes when sampling starts keeps its overlap ----

    def _raiseLimits(self):
        if self.limitsAreCurrent:
            return
        pairs, overlaps, _ = self.oracle.beyondLimits(0)
        self.limits.update(
            {tuple(pair): overlap + SIGMA for pair, overlap in zip(pairs.tolist(), overlaps, strict=True)}
        )
        self._tellLimits()
        self.limitsAreCurrent = True

    def _tellLimits(self):
        pairs = np.array(list(self.limits), dtype=np.intc).reshape(-1, 2)
        self.oracle.setLimits(pairs, np.array(list(self.limits.values()), dtype=float))

    def _restartLimits(self):
        self.limits = {}
        self.limitsAreCurrent = False
        self._tellLimits()

    # ---- Trials ----

    @precondition(lambda self: self.force.getNumTorsions() > 0)
    @rule(data=st.data())
    def proposeTorsions(self, data):
        torsions = data.draw(
            st.lists(st.integers(0, self.force.getNumTorsions() - 1), min_size=1, max_size=4, unique=True), "torsions"
        )
        changes = data.draw(st.lists(angles, min_size=len(torsions), max_size=len(torsions)), "changes")
        self._proposeTorsions(torsions, changes)

    def _proposeTorsions(self, torsions, changes):
        self._raiseLimits()
        self.oracle.proposeTorsions(torsions, changes)
        return self._compareVerdict(self.force.proposeTorsions(self.context, torsions, changes))

    @precondition(lambda self: self.movable)
    @rule(data=st.data(), rotation=vectors, translation=vectors)
    def proposeRigidMotion(self, data, rotation, translation):
        particle = data.draw(st.sampled_from(self.movable), "particle")
        self._raiseLimits()
        self.oracle.proposeRigidMotion(particle, rotation, translation)
        self._compareVerdict(self.force.proposeRigidMotion(self.context, particle, rotation, translation))

    def _compareVerdict(self, isFree):
        self.isOpen = True
        self.isFree = isFree
        margin, pair = self.oracle.worstTrialMargin()
        if abs(margin) > DOUBT:
            assert isFree == (margin < 0), f"the worst pair is {pair}, its margin {margin} nm"
        Programs.done["free" if isFree else "clashing"] += 1
        return isFree

    @precondition(lambda self: self.force.getNumTorsions() > 0)
    @rule(seed=st.integers(0, 2**32 - 1), trials=st.integers(1, 20), size=st.sampled_from([0.01, 0.3, np.pi]))
    def wander(self, seed, trials, size):
        """A user's Monte Carlo: accept what is free."""
        random = np.random.default_rng(seed)
        for _ in range(trials):
            torsions = random.choice(self.force.getNumTorsions(), size=1 if random.random() < 0.7 else 2)
            torsions = np.unique(torsions)
            if self._proposeTorsions(torsions, random.uniform(-size, size, size=len(torsions))):
                self.accept()
            else:
                self.reject()

    @rule(cutoff=cutoffs)
    def lookAtProposal(self, cutoff):
        if not self.isOpen:
            self._refuse("no open proposal", self.force.getProposedPositions, self.context)
            self._refuse("no open proposal", self.force.getChangedNeighborPairs, self.context, cutoff)
            return
        proposed = self.force.getProposedPositions(self.context)
        np.testing.assert_allclose(proposed, self.oracle.positions(TRIAL), rtol=0, atol=SAME_NUMBER)
        pairs, before, after = self.force.getChangedNeighborPairs(self.context, cutoff)
        expected, *distances = self.oracle.changedPairs(cutoff + SIGMA)
        isDoubtful = (np.min(distances, axis=0) > cutoff - SIGMA) | (np.abs(np.subtract(*distances)) < UNMOVED)
        self._compareLists(pairs, (before, after), expected, distances, isDoubtful)
        Programs.done["changed pairs"] += len(pairs)

    @rule()
    def accept(self):
        if not self.isOpen:
            self._refuse("no open proposal", self.force.acceptProposal, self.context)
            return
        proposed = self.force.getProposedPositions(self.context)
        self.force.acceptProposal(self.context)
        self.oracle.accept()
        self.isOpen = False
        if not self.isFree:
            self._restartLimits()
        np.testing.assert_array_equal(self.positions(), proposed)
        np.testing.assert_allclose(proposed, self.oracle.positions(STATE), rtol=0, atol=SAME_NUMBER)

    @rule()
    def reject(self):
        before = self.positions()
        self.force.rejectProposal(self.context)
        self.isOpen = False
        np.testing.assert_array_equal(self.positions(), before)

    @precondition(lambda self: self.hasMoves)
    @rule()
    def step(self):
        self._raiseLimits()
        before = {tuple(pair): margin for pair, margin in self._beyondLimits()}
        self.integrator.step(1)
        self.isOpen = False
        self.oracle.setPositions(self.positions())
        for pair, margin in self._beyondLimits():
            # What clashed before may still do so if nothing has moved it.
            assert margin < DOUBT or abs(margin - before.get(tuple(pair), 0)) < SAME_NUMBER, (pair, margin)
        Programs.done["steps"] += 1

    def _beyondLimits(self):
        pairs, _, margins = self.oracle.beyondLimits(0)
        return zip(pairs.tolist(), margins, strict=True)

    # ---- Other changes ----

    @rule(seed=st.integers(0, 2**32 - 1), size=st.sampled_from([1e-12, 1e-3, 0.1]), fromStart=st.booleans())
    def setPositions(self, seed, size, fromStart):
        shaken = self.start if fromStart else self.positions()
        shaken = shaken + size * np.random.default_rng(seed).uniform(0.1, 1, size=shaken.shape)
        self.context.setPositions(shaken)
        self.oracle.setPositions(shaken)
        self.isOpen = False
        self._restartLimits()

    @rule(seed=st.integers(0, 2**32 - 1))
    def setParameters(self, seed):
        """Radii and roles, for which there must be a new oracle."""
        self._drawParameters(np.random.default_rng(seed))
        self.force.updateParametersInContext(self.context)
        self.oracle = OracleScene(self.system, self.force, self.oracle.positions(STATE))
        self.limits = {pair: limit for pair, limit in self.limits.items() if limit > self._tolerance(*pair)}
        self._tellLimits()
        self.limitsAreCurrent = False
        self.isOpen = False

    def _tolerance(self, i, j):
        """Return by how much two particles may overlap: any amount if one of them is not modelled."""
        (radius1, role1), (radius2, role2) = (self.force.getParticleParameters(k) for k in (i, j))
        if min(radius1, radius2) == 0 * unit.nanometer:
            return np.inf
        donor, acceptor = StericExclusionForce.Donor, StericExclusionForce.Acceptor
        isBond = (role1 & donor and role2 & acceptor) or (role1 & acceptor and role2 & donor)
        tolerance = self.force.getOverlapTolerance()
        return (tolerance + self.force.getHydrogenBondAllowance() * bool(isBond)).value_in_unit(unit.nanometer)

    @rule()
    def saveCheckpoint(self):
        self.checkpoint = (self.context.createCheckpoint(), self.positions(), dict(self.limits), self.limitsAreCurrent)

    @precondition(lambda self: self.checkpoint is not None)
    @rule()
    def loadCheckpoint(self):
        checkpoint, positions, self.limits, self.limitsAreCurrent = self.checkpoint
        self.limits = dict(self.limits)
        self.context.loadCheckpoint(checkpoint)
        np.testing.assert_array_equal(self.positions(), positions)
        self.oracle.setPositions(positions)
        self._tellLimits()
        self.isOpen = False

    # ---- Queries ----

    @rule()
    def listClashes(self):
        pairs, overlaps = self.force.getClashes(self.context)
        expected, expectedOverlaps, margins = self.oracle.clashes(SIGMA)
        self._compareLists(pairs, [overlaps], expected, [expectedOverlaps], margins < SIGMA)
        assert self.force.hasClash(self.context) == (len(pairs) > 0)
        Programs.done["clashes"] += len(pairs)

    @rule(cutoff=cutoffs)
    def listNeighborPairs(self, cutoff):
        pairs, distances = self.force.getNeighborPairs(self.context, cutoff)
        expected, expectedDistances = self.oracle.neighborPairs(cutoff + SIGMA)
        self._compareLists(pairs, [distances], expected, [expectedDistances], expectedDistances > cutoff - SIGMA)
        Programs.done["neighbour pairs"] += len(pairs)

    @rule(position=vectors, radius=radii)
    def probe(self, position, radius):
        particles, overlaps = self.force.getClashesWith(self.context, position, radius)
        expected, expectedOverlaps, margins = self.oracle.clashesWith(position, radius, SIGMA)
        self._compareLists(
            np.stack([particles] * 2, axis=1),
            [overlaps],
            np.stack([expected] * 2, axis=1),
            [expectedOverlaps],
            margins < SIGMA,
        )

    @rule(data=st.data())
    def findNearest(self, data):
        sets = [data.draw(st.lists(st.integers(0, self.count - 1), min_size=1), "set") for _ in range(2)]
        expected = self.oracle.minimumDistance(*sets)
        if np.isinf(expected):
            self._refuse("no pair", self.force.getMinimumDistance, self.context, *sets)
            return
        distance, i, j = self.force.getMinimumDistance(self.context, *sets)
        assert i in sets[0] and j in sets[1] and i != j
        assert distance == pytest.approx(expected, abs=SAME_NUMBER)
        assert self.oracle.distance(i, j) == pytest.approx(expected, abs=SAME_NUMBER)

    @rule()
    def compareEnergy(self):
        state = self.context.getState(energy=True, forces=True)
        forces = state.getForces(asNumpy=True).value_in_unit(unit.kilojoule_per_mole / unit.nanometer)
        expected, expectedForces = self.oracle.energy(FORCE_CONSTANT)
        energy = state.getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)
        pairs, _, _ = self.oracle.clashes(0)
        error = 1e-9 * FORCE_CONSTANT * (1 + len(pairs))
        assert energy == pytest.approx(expected, abs=error)
        # A direction means nothing where two particles are at one place.
        if all(self.oracle.distance(int(i), int(j)) > 1e-6 for i, j in pairs):
            np.testing.assert_allclose(forces, expectedForces, rtol=0, atol=1e4 * error)
        Programs.done["energies"] += expected > 0

    # ---- What must be refused, and change nothing ----

    @precondition(lambda self: self.force.getNumTorsions() > 0)
    @rule()
    def proposeNonsense(self):
        torsions = self.force.getNumTorsions()
        propose = self.force.proposeTorsions
        self._refuse("torsion", propose, self.context, [torsions], [0.1])
        self._refuse("torsion", propose, self.context, [0, 0], [0.1, 0.2])
        self._refuse("finite", propose, self.context, [0], [np.nan])

    @rule()
    def askNonsense(self):
        self._refuse("cutoff", self.force.getNeighborPairs, self.context, 0)
        self._refuse("particle", self.force.getMinimumDistance, self.context, [0], [self.count])
        self._refuse("radius", self.force.getClashesWith, self.context, (0, 0, 0), -0.1)
        rotation = (0, 0, np.inf)
        self._refuse("finite", self.force.proposeRigidMotion, self.context, 0, rotation, (0, 0, 0))

    def _refuse(self, culprit, function, *arguments):
        before = self.positions()
        with pytest.raises(openmm.OpenMMException, match=culprit):
            function(*arguments)
        np.testing.assert_array_equal(self.positions(), before)
        Programs.done["refused"] += 1

    # ---- Comparison ----

    @staticmethod
    def _compareLists(pairs, values, expected, expectedValues, mayMiss):
        """Compare sorted lists of pairs, of which the oracle's has some that the plugin may leave out."""
        listed = {tuple(pair): i for i, pair in enumerate(pairs.tolist())}
        assert list(listed) == sorted(listed) and len(listed) == len(pairs)
        keys = [tuple(pair) for pair in expected.tolist()]
        missing = [key for key, may in zip(keys, mayMiss, strict=True) if key not in listed and not may]
        assert not missing and listed.keys() <= set(keys)
        for i, key in enumerate(keys):
            if key in listed:
                for value, expectedValue in zip(values, expectedValues, strict=True):
                    assert value[listed[key]] == pytest.approx(expectedValue[i], abs=SAME_NUMBER)


def test_programs_agree_with_the_oracle():
    settings = hypothesis.settings(
        max_examples=EXAMPLES,
        stateful_step_count=STEPS,
        derandomize=True,
        database=None,
        deadline=None,
        suppress_health_check=list(hypothesis.HealthCheck),
    )
    run_state_machine_as_test(Programs, settings=settings)
    print(dict(Programs.done))
    for what in ("free", "clashing", "steps", "clashes", "neighbour pairs", "changed pairs", "energies", "refused"):
        assert Programs.done[what] > 100, what
    assert Programs.done["largest"] > 50
