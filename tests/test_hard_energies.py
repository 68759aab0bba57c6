"""Inputs of native energies that are easy to get wrong, as a user would meet them: each has to be as OpenMM has it, or
be refused with words that help."""

import numpy as np
import openmm
import pytest
from openmm import OpenMMException, Vec3
from openmmchaintree import StericExclusionForce, TorsionMonteCarloIntegrator
from realsystems import Reference, Run, positionsOf

LENGTH = 12
SPACING = 0.3  # nm


def zigzag(count, origin=(0, 0, 0)):
    """Return positions of a chain of beads none of whose torsions is straight."""
    positions, direction = [np.array(origin, dtype=float)], 0
    steps = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.6, 0.8, 0]])
    for i in range(count - 1):
        positions.append(positions[-1] + SPACING * steps[(i + direction) % 4])
    return np.array(positions)


class Chain:
    """Chains of charged beads with all torsions, as a System that tests add to; beads have no radius."""

    def __init__(self, lengths=(LENGTH,), torsions=True, exclusions=2):
        self.system, self.steric = openmm.System(), StericExclusionForce()
        self.pairs = openmm.NonbondedForce()
        self.positions = np.concatenate([zigzag(length, (0, 1.5 * i, 0.7 * i)) for i, length in enumerate(lengths)])
        self.bonds = []
        for length in lengths:
            first = self.system.getNumParticles()
            for i in range(first, first + length):
                self.system.addParticle(1)
                self.steric.addParticle(0)
                self.pairs.addParticle(0.2 if i % 2 else -0.2, 0.25, 0.5)
                if i > first:
                    self.bonds.append((i - 1, i))
                    self.steric.addBond(i - 1, i)
                if torsions and i >= first + 3:
                    self.steric.addTorsion(i - 3, i - 2, i - 1, i)
        self.pairs.createExceptionsFromBonds(self.bonds, 0.8, 0.5)
        self.system.addForce(self.steric)

    def addParticle(self, charge=0.0, mass=1.0):
        self.system.addParticle(mass)
        self.steric.addParticle(0)
        self.pairs.addParticle(charge, 0.25, 0.1)

    def run(self, moves=((1, 0.4, 1), (1, 3, 1)), **choice):
        return Run(self.system, self.positions, moves=moves, **choice)


def kinds(run):
    return [entry.kind for entry in run.integrator.getEnergyPlan(run.context)]


def parametersOf(context):
    return dict(context.getParameters().items())


def assertHeld(run, trials=3000, tolerance=1e-4):
    """Check U against OpenMM's, now and after some trials, some of which have to be accepted."""
    reference = Reference(run.system)
    for count in (0, trials):
        if count:
            before = run.accepted
            run.run(count)
            assert run.accepted > before
        for name, value in parametersOf(run.context).items():
            if name in parametersOf(reference.context):
                reference.context.setParameter(name, value)
        expected = reference.energy(run.positions)
        assert abs(run.energy - expected) <= tolerance * (1 + 0.01 * abs(expected))


# ---- Energies that are none ----


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_positions_that_are_no_numbers(value):
    chain = Chain()
    chain.system.addForce(chain.pairs)
    run = chain.run()
    run.run(100)
    good, energy = run.positions, run.energy
    bad = good.copy()
    bad[3, 1] = value
    with pytest.raises(OpenMMException, match="particle 3|[Pp]osition|NaN"):
        run.context.setPositions(bad)
        run.integrator.step(1)
    with pytest.raises(OpenMMException):
        run.integrator.getPotentialEnergy(run.context)
    run.context.setPositions(good)
    assert abs(run.energy - energy) < 1e-5
    assertHeld(run)


def test_start_on_top_of_each_other_is_left():
    """An infinite energy is one that a state can have, as in OpenMM, but no trial comes to it."""
    chain = Chain()
    chain.positions[11] = chain.positions[7]
    chain.system.addForce(chain.pairs)
    run = chain.run()
    assert run.energy == np.inf == Reference(run.system).energy(run.positions)
    run.run(5000)
    assert run.energy < 1e6
    assertHeld(run)


@pytest.mark.parametrize("epsilon", [0, 0.1])
def test_start_on_top_of_an_opposite_charge_names_the_force(epsilon):
    """Without Lennard-Jones, the energy is minus infinity; with it, it is no number."""
    chain = Chain()
    chain.pairs.setParticleParameters(11, 0.3, 0.25, epsilon)
    chain.pairs.setParticleParameters(6, -0.3, 0.25, epsilon)
    chain.positions[11] = chain.positions[6]
    chain.pairs.setName("pairs of beads")
    chain.system.addForce(chain.pairs)
    assert not Reference(chain.system).energy(chain.positions) > -np.inf
    with pytest.raises(OpenMMException, match="pairs of beads"):
        chain.run().run(10)


def test_start_with_a_bonded_term_that_is_no_number_names_the_force():
    chain = Chain()
    expression = openmm.CustomBondForce("log(r-1)")
    expression.setName("logarithm")
    expression.addBond(0, 5, [])
    chain.system.addForce(expression)
    chain.positions = zigzag(LENGTH)
    chain.positions[0] = chain.positions[5] + [0, 0, 0.4]
    with pytest.raises(OpenMMException, match="logarithm"):
        chain.run().run(10)


def test_trials_without_an_energy_are_refused_and_counted():
    """U is a number only while two beads are at least 0.8 nm apart."""
    chain = Chain()
    expression = openmm.CustomBondForce("1e-6*sqrt(r-0.8)")
    expression.addBond(0, LENGTH - 1, [])
    chain.system.addForce(expression)
    run = chain.run(moves=((1, 3, 1),))
    for _ in range(20):
        run.run(100)
        ends = run.positions[[0, LENGTH - 1]]
        assert np.linalg.norm(ends[0] - ends[1]) >= 0.8
    statistics = run.integrator.getMoveStatistics(0)
    assert statistics.rejectedByEnergy > 0 and statistics.accepted > 0
    refused = sum(stage.refused for stage in run.integrator.getStageStatistics())
    assert refused == statistics.rejectedByEnergy


def test_a_start_of_infinite_energy_is_left():
    """Atoms whose overlap gives OpenMM an energy far beyond a float have a native energy."""
    chain = Chain()
    chain.addParticle()
    chain.positions = np.vstack([chain.positions, chain.positions[7] + [1e-5, 0, 0]])
    chain.system.addForce(chain.pairs)
    run = chain.run()
    reference = Reference(run.system)
    expected = reference.energy(run.positions)
    assert expected > 1e38 and abs(run.energy / expected - 1) < 1e-2
    run.run(5000)
    assert run.energy < 1e6
    assertHeld(run)


def test_trials_that_overlap_are_refused():
    """A hairpin whose ends meet: no accepted trial has them on top of each other."""
    chain = Chain((5,), exclusions=2)
    chain.system.addForce(chain.pairs)
    run = chain.run(moves=((1, np.pi, 1),))
    for _ in range(30):
        run.run(200)
        assert abs(run.energy - Reference(run.system).energy(run.positions)) < 1e-4


# ---- What OpenMM knows and openmm-chaintree must not forget ----


@pytest.mark.parametrize("cutoff", [None, 0.7])
def test_exclusions_across_links(cutoff):
    chain = Chain((LENGTH, LENGTH))
    if cutoff:
        chain.pairs.setNonbondedMethod(openmm.NonbondedForce.CutoffNonPeriodic)
        chain.pairs.setCutoffDistance(cutoff)
    random = np.random.default_rng(3)
    known = {tuple(sorted(chain.pairs.getExceptionParameters(i)[:2])) for i in range(chain.pairs.getNumExceptions())}
    while len(known) < 120:
        pair = tuple(sorted(int(i) for i in random.choice(2 * LENGTH, 2, replace=False)))
        if pair not in known:
            known.add(pair)
            isExcluded = random.random() < 0.5
            chain.pairs.addException(*pair, 0 if isExcluded else 0.1, 0.2, 0 if isExcluded else 0.3)
    chain.system.addForce(chain.pairs)
    assertHeld(chain.run())


def test_virtual_site_in_a_rigid_molecule():
    """A water of four sites beside a chain, whose charge sits on the fourth."""
    chain = Chain()
    first = chain.system.getNumParticles()
    chain.addParticle(0, 16)
    chain.addParticle(0.52)
    chain.addParticle(0.52)
    chain.addParticle(-1.04, 0)
    chain.system.setVirtualSite(
        first + 3, openmm.ThreeParticleAverageSite(first, first + 1, first + 2, 0.7868, 0.1066, 0.1066)
    )
    for other in (1, 2, 3):
        chain.steric.addBond(first, first + other)
    for a in range(4):
        for b in range(a):
            chain.pairs.addException(first + a, first + b, 0, 1, 0)
    water = np.array([[0, 0, 0], [0.09572, 0, 0], [-0.024, 0.0927, 0], [0, 0, 0]]) + [0.3, 0.9, 0.2]
    chain.positions = np.vstack([chain.positions, water])
    chain.system.addForce(chain.pairs)
    assertHeld(chain.run(rigid=(0.05, 0.5)))


def test_virtual_site_whose_parents_a_torsion_parts():
    """That would be no part of any link."""
    chain = Chain()
    chain.addParticle(0.4, 0)
    site = chain.system.getNumParticles() - 1
    chain.system.setVirtualSite(site, openmm.TwoParticleAverageSite(2, 9, 0.5, 0.5))
    chain.pairs.addException(site, 2, 0, 1, 0)
    chain.pairs.addException(site, 9, 0, 1, 0)
    chain.positions = np.vstack([chain.positions, (chain.positions[2] + chain.positions[9]) / 2])
    chain.system.addForce(chain.pairs)
    with pytest.raises(OpenMMException, match=f"virtual site {site} is defined by particles"):
        chain.run()


def test_particles_of_mass_0():
    """A wall of charged particles that do not move, and a chain that is fixed at one end."""
    chain = Chain()
    wall = [[0.4 * i, -0.5, 0.4 * k] for i in range(4) for k in range(4)]
    for k in range(len(wall)):
        chain.addParticle((-1) ** k * 0.3, 0)
    chain.system.setParticleMass(0, 0)
    chain.positions = np.vstack([chain.positions, wall])
    chain.system.addForce(chain.pairs)
    run = chain.run()
    assertHeld(run)
    assert np.array_equal(run.positions[LENGTH:], chain.positions[LENGTH:])


def test_everything_is_fixed_but_a_ligand():
    chain = Chain((LENGTH, 3), torsions=False)
    for i in range(LENGTH):
        chain.system.setParticleMass(i, 0)
    chain.system.addForce(chain.pairs)
    assertHeld(chain.run(moves=(), rigid=(0.1, 1)))


def test_rigid_bodies_without_torsions():
    chain = Chain((4, 5), torsions=False)
    chain.system.addForce(chain.pairs)
    harmonic = openmm.HarmonicBondForce()
    harmonic.addBond(1, 6, 1.0, 20)
    chain.system.addForce(harmonic)
    assertHeld(chain.run(moves=(), rigid=(0.1, 1)))


# ---- What is changed in mid-run ----


def test_global_parameters_changed_in_mid_run():
    chain = Chain()
    chain.pairs.addGlobalParameter("scale", 0.5)
    for i in range(LENGTH):
        chain.pairs.addParticleParameterOffset("scale", i, 0.1 * (-1) ** i, 0.01, 0.02)
    chain.pairs.addExceptionParameterOffset("scale", 20, 0.05, 0, 0.1)
    chain.system.addForce(chain.pairs)
    pull = openmm.CustomBondForce("strength*(r-0.9)^2")
    pull.addGlobalParameter("strength", 10)
    pull.addBond(0, LENGTH - 1, [])
    chain.system.addForce(pull)
    run = chain.run()
    assertHeld(run)
    for strength, scale in [(300, 0.5), (300, 1.2), (0, -0.3)]:
        before = run.energy
        run.context.setParameter("strength", strength)
        run.context.setParameter("scale", scale)
        assert run.energy != before
        assertHeld(run)


def test_parameters_updated_in_mid_run():
    chain = Chain()
    chain.system.addForce(chain.pairs)
    torsions = openmm.PeriodicTorsionForce()
    torsions.addTorsion(2, 3, 4, 5, 2, 0.3, 4)
    chain.system.addForce(torsions)
    run = chain.run()
    assertHeld(run)
    chain.pairs.setParticleParameters(3, 0.7, 0.3, 0.2)
    chain.pairs.updateParametersInContext(run.context)
    assertHeld(run)
    torsions.setTorsionParameters(0, 2, 3, 4, 5, 1, 2.0, 9)
    torsions.updateParametersInContext(run.context)
    assertHeld(run)


def test_an_update_that_was_forgotten():
    """The Context continues with the old parameters."""
    chain = Chain()
    chain.system.addForce(chain.pairs)
    run = chain.run()
    run.run(100)
    chain.pairs.setParticleParameters(3, 0.7, 0.3, 0.2)
    energy = run.energy
    assert run.energy == energy  # an edit of a Force is nothing before the Context is told
    run.context.reinitialize(preserveState=True)
    assertHeld(run)


def test_integration_force_groups_changed_in_mid_run():
    chain = Chain()
    chain.system.addForce(chain.pairs)
    pull = openmm.HarmonicBondForce()
    pull.addBond(0, LENGTH - 1, 0.5, 200)
    pull.setForceGroup(3)
    chain.system.addForce(pull)
    run = chain.run()
    reference = Reference(run.system)
    groups = {name: 1 << group for group, name in reference.names.items()}
    for chosen, names in [({0}, ["NonbondedForce"]), ({3}, ["HarmonicBondForce"]), ({0, 3}, list(groups))]:
        run.integrator.setIntegrationForceGroups(chosen)
        for _ in range(2):
            expected = sum(reference.energy(run.positions, groups[name]) for name in names)
            assert abs(run.energy - expected) < 1e-6 * (100 + abs(expected))
            run.run(1000)


# ---- How many Forces there are ----


def test_two_nonbonded_forces():
    """One of them is left to OpenMM."""
    chain = Chain()
    chain.system.addForce(chain.pairs)
    second = openmm.NonbondedForce()
    for _ in range(LENGTH):
        second.addParticle(0.1, 0.2, 0.3)
    second.createExceptionsFromBonds(chain.bonds, 0.5, 0.5)
    chain.system.addForce(second)
    run = chain.run()
    assert sorted(kind for kind in kinds(run)) == ["foreign", "native", "not sampled"]
    assertHeld(run, 500)


def test_empty_nonbonded_force():
    """OpenMM refuses one that knows of no particles; one whose particles do nothing is cheap."""
    chain = Chain()
    empty = openmm.NonbondedForce()
    chain.system.addForce(empty)
    with pytest.raises(OpenMMException):
        chain.run()
    chain = Chain()
    for i in range(LENGTH):
        chain.pairs.setParticleParameters(i, 0, 1, 0)
    for i in range(chain.pairs.getNumExceptions()):
        p1, p2, *_ = chain.pairs.getExceptionParameters(i)
        chain.pairs.setExceptionParameters(i, p1, p2, 0, 1, 0)
    chain.system.addForce(chain.pairs)
    run = chain.run()
    assert run.energy == 0
    run.run(500)
    assert run.energy == 0 and run.accepted == 500


def test_more_forces_than_there_are_groups():
    chain = Chain()
    for k in range(40):
        force = openmm.PeriodicTorsionForce()
        force.addTorsion(k % 9, k % 9 + 1, k % 9 + 2, k % 9 + 3, k % 4 + 1, 0.1 * k, 0.5)
        force.setForceGroup(k % 32)
        chain.system.addForce(force)
    run = chain.run()
    assert kinds(run).count("native") == 40
    expected = openmm.Context(
        withoutSteric(run.system), openmm.VerletIntegrator(0.001), openmm.Platform.getPlatform("Reference")
    )
    for _ in range(3):
        expected.setPositions(run.positions)
        assert abs(run.energy - expected.getState(energy=True).getPotentialEnergy()._value) < 1e-6
        run.run(500)


def withoutSteric(system):
    copy = openmm.XmlSerializer.clone(system)
    for index in reversed(range(copy.getNumForces())):
        if copy.getForce(index).getName() == "StericExclusionForce":
            copy.removeForce(index)
    return copy


def test_no_force_but_the_steric_one():
    chain = Chain()
    run = chain.run()
    assert kinds(run) == ["not sampled"]
    run.run(500)
    assert run.energy == 0 and run.accepted == 500


def test_only_a_foreign_force():
    chain = Chain()
    foreign = openmm.CustomCentroidBondForce(2, "0.1/same(distance(g1,g2))")
    foreign.addTabulatedFunction("same", openmm.Continuous1DFunction([0, 1000], 0, 1000))
    for particle in range(LENGTH):
        foreign.addGroup([particle])
        for other in range(particle):
            foreign.addBond([other, particle])
    chain.system.addForce(foreign)
    run = chain.run()
    assert "foreign" in kinds(run) and "native" not in kinds(run)
    assertHeld(run, 500)


def test_far_from_the_origin():
    """Energies depend on distances alone, so that single precision does not suffer."""
    chain = Chain()
    chain.system.addForce(chain.pairs)
    near = chain.run()
    chain.positions = chain.positions + np.array(Vec3(1000, -2000, 500))
    far = chain.run()
    assert abs(near.energy - far.energy) < 1e-5
    assertHeld(far)


def test_positions_set_in_mid_run():
    chain = Chain((LENGTH, LENGTH))
    chain.system.addForce(chain.pairs)
    run = chain.run()
    for shift in (0.001, 0.3, 5):
        run.run(500)
        positions = run.positions
        positions[LENGTH:] += [0, 0, shift]
        run.context.setPositions(positions)
        assertHeld(run, 500)


def test_dynamics_and_monte_carlo_in_turns():
    chain = Chain()
    chain.system.addForce(chain.pairs)
    springs = openmm.HarmonicBondForce()
    for bond in chain.bonds:
        springs.addBond(*bond, SPACING, 1e4)
    chain.system.addForce(springs)
    compound = openmm.CompoundIntegrator()
    sampler = TorsionMonteCarloIntegrator(300)
    sampler.setRandomNumberSeed(1)
    sampler.addTorsionMove(1, 0.4)
    dynamics = openmm.LangevinMiddleIntegrator(300, 1, 0.0005)
    dynamics.setRandomNumberSeed(1)
    compound.addIntegrator(sampler)
    compound.addIntegrator(dynamics)
    context = openmm.Context(chain.system, compound, openmm.Platform.getPlatform("Reference"))
    context.setPositions(chain.positions)
    reference = Reference(chain.system)
    for _ in range(5):
        for integrator in (0, 1):
            compound.setCurrentIntegrator(integrator)
            compound.step(5)
            assert abs(sampler.getPotentialEnergy(context) - reference.energy(positionsOf(context))) < 1e-4
