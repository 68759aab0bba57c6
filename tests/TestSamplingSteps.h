/**
 * This tests steps of TorsionMonteCarloIntegrator on one platform: seeds, torsion angles, limits, life beside other
 * integrators, and Systems that it refuses.
 */

#include "openmm/CompoundIntegrator.h"
#include "openmm/CustomExternalForce.h"
#include "openmm/LangevinMiddleIntegrator.h"
#include "openmm/LocalEnergyMinimizer.h"
#include "openmm/MonteCarloAnisotropicBarostat.h"
#include "openmm/MonteCarloBarostat.h"
#include "openmm/MonteCarloFlexibleBarostat.h"
#include "openmm/MonteCarloMembraneBarostat.h"
#include "openmm/VirtualSite.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "SamplingSupport.h"
#include <limits>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

void testSteps(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    BeadChain chain(6, 0.3);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addTorsionMove(1, 0.5);
    ASSERT_EQUAL(100, integrator.getTrialsPerStep());
    ASSERT_EQUAL(0, integrator.getStepSize());
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    vector<Vec3> velocities(6, Vec3(1, 2, 3));
    context.setVelocities(velocities);
    integrator.step(3);
    ASSERT_EQUAL(300, Statistics(integrator, 0).attempted);
    ASSERT_EQUAL(3, context.getStepCount());
    ASSERT_EQUAL(0, context.getTime());
    integrator.setTrialsPerStep(7);
    integrator.setStepSize(0.5);
    integrator.step(2);
    ASSERT_EQUAL(314, Statistics(integrator, 0).attempted);
    ASSERT_EQUAL(5, context.getStepCount());
    ASSERT_EQUAL_TOL(1.0, context.getTime(), 1e-12);

    // Velocities turn with their links, that of the root stays.

    State state = context.getState(State::Velocities | State::Energy);
    ASSERT_EQUAL_VEC(velocities[0], state.getVelocities()[0], tolerance);
    ASSERT(getDistance(velocities[5], state.getVelocities()[5]) > 1e-3);
    ASSERT_EQUAL_TOL(6 * 0.5 * 14, state.getKineticEnergy(), tolerance);
    ASSERT(getDistance(chain.positions[5], getPositions(context)[5]) > 1e-3);
}

void testSeeds(Platform& platform)
{
    BeadChain chain(20, 0.45);
    int other = chain.addMolecule(5, 0.45, 1.0, Vec3(0, 0, 2));
    ASSERT_EQUAL(20, other);
    CustomExternalForce* trap = new CustomExternalForce("x^2+y^2+z^2");
    for (int i = 0; i < 25; i++)
        trap->addParticle(i);
    trap->setForceGroup(1);
    chain.system.addForce(trap);
    auto sample = [&](int seed, int groups) {
        TorsionMonteCarloIntegrator integrator(300);
        integrator.setRandomNumberSeed(seed);
        ASSERT_EQUAL(seed, integrator.getRandomNumberSeed());
        integrator.addTorsionMove(1, 0.5, {}, 2);
        integrator.addRigidBodyMove(1, 0.1, 0.1);
        integrator.setIntegrationForceGroups(groups);
        Context context(chain.system, integrator, platform);
        context.setPositions(chain.positions);
        integrator.step(10);
        return getPositions(context);
    };
    for (int groups : {1, 3}) {
        vector<Vec3> first = sample(17, groups);
        assertSameBits(first, sample(17, groups));
        ASSERT(!(first == sample(18, groups)));
        ASSERT(!(sample(0, groups) == sample(0, groups)));
    }
}

void testTorsionAngles(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    BeadChain chain(6, 0.4, 2.5);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addTorsionMove(1, M_PI);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    vector<double> angles;
    integrator.getTorsionAngles(context, angles);
    ASSERT_EQUAL(3, angles.size());
    for (double angle : angles)
        ASSERT_EQUAL_TOL(2.5, angle, tolerance);
    assertRounded(platform, chain.positions, getPositions(context));

    // Setting what is there already changes nothing, not even a bit.

    integrator.step(1);
    vector<Vec3> before = getPositions(context);
    integrator.getTorsionAngles(context, angles);
    integrator.setTorsionAngles(context, angles);
    assertSameBits(before, getPositions(context));
    for (int i = 0; i < 3; i++)
        ASSERT_EQUAL_TOL(getDihedral(before[i], before[i + 1], before[i + 2], before[i + 3]), angles[i], tolerance);

    // Other angles are reached, clashing or not: all cis closes a ring of four beads.

    integrator.setTorsionAngles(context, {0.5, -3.0, 2 * M_PI + 1});
    vector<Vec3> x = getPositions(context);
    const double expected[] = {0.5, -3.0, 1.0};
    integrator.getTorsionAngles(context, angles);
    for (int i = 0; i < 3; i++) {
        ASSERT_EQUAL_TOL(expected[i], getDihedral(x[i], x[i + 1], x[i + 2], x[i + 3]), tolerance);
        ASSERT_EQUAL_TOL(expected[i], angles[i], tolerance);
    }
    integrator.setTorsionAngles(context, {0, 0, 0});
    ASSERT(chain.force->hasClash(context));
    ASSERT_EQUAL_VEC(getPositions(context)[0], getPositions(context)[4], tolerance);

    // A straight torsion turns, but has no value.

    vector<Vec3> straight = chain.positions;
    straight[0] = straight[1] + (straight[1] - straight[2]);
    context.setPositions(straight);
    assertThrows("torsion 0 has no value: the dihedral of particles 0, 1, 2 and 3 is undefined", [&] {
        integrator.getTorsionAngles(context, angles);
    });
    assertThrows("torsion 0 has no value", [&] {
        integrator.setTorsionAngles(context, {1, 1, 1});
    });
    assertRounded(platform, straight, getPositions(context));
    integrator.step(1);
    ASSERT(Statistics(integrator, 0).accepted > 0);

    assertThrows("was given 2 angles, but there are 3 torsions", [&] {
        integrator.setTorsionAngles(context, {0, 0});
    });
    assertThrows("the angle of torsion 1 is not finite", [&] {
        integrator.setTorsionAngles(context, {0, numeric_limits<double>::infinity(), 0});
    });
}

void testFixedAndVirtual(Platform& platform)
{
    // Bead 2 is fixed, and a virtual site hangs on the last bond.

    const double tolerance = getTolerance(platform);
    BeadChain chain(8, 0.3);
    chain.system.setParticleMass(2, 0);
    chain.system.addParticle(0);
    chain.force->addParticle(0.2);
    chain.system.setVirtualSite(8, new TwoParticleAverageSite(6, 7, 0.5, 0.5));
    for (int i : {4, 5, 6, 7})
        chain.force->addExclusion(i, 8);
    chain.positions.push_back(Vec3());
    CustomExternalForce* field = new CustomExternalForce("x");
    field->addParticle(8);
    chain.system.addForce(field);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addTorsionMove(1, 0.5);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    for (int i = 0; i < 20; i++) {
        integrator.step(1);
        vector<Vec3> x = getPositions(context);
        assertRounded(platform, {chain.positions[2]}, {x[2]});
        ASSERT_EQUAL_VEC((x[6] + x[7]) * 0.5, x[8], tolerance);
        ASSERT(!chain.force->hasClash(context));
    }
    ASSERT(Statistics(integrator, 0).accepted > 100);
    assertThrows("all molecules have fixed particles", [&] {
        integrator.addRigidBodyMove(1, 0.1, 0.1);
    });
}

void testLimits(Platform& platform)
{
    // Beads 0 and 3 of radius 0.7 clash up to a dihedral of 1.02.

    const double tolerance = getTolerance(platform);
    BeadChain chain(4, 0.7, 0.5);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(8);
    integrator.addTorsionMove(1, 0.2);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));
    auto assertNotBeyond = [&](double dihedral) {
        vector<double> angles;
        for (int i = 0; i < 50; i++) {
            integrator.step(1);
            integrator.getTorsionAngles(context, angles);
            ASSERT(fabs(angles[0]) >= dihedral - 1e-8 - tolerance);
        }
    };
    assertNotBeyond(0.5);
    ASSERT_EQUAL(1, integrator.getNumToleratedClashes(context));

    // Positions that the user sets restart limits, even if they are the same; so does setTorsionAngles().

    context.setPositions(BeadChain(4, 0.7, 0.7).positions);
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));
    assertNotBeyond(0.7);
    integrator.setTorsionAngles(context, {0.9});
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));
    assertNotBeyond(0.9);
    integrator.setTorsionAngles(context, {0.3});
    assertNotBeyond(0.3);
    integrator.setTorsionAngles(context, {2.5});
    integrator.step(1);
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));
    context.setPositions(getPositions(context));
    integrator.step(1);
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));

    // An accepted proposal does not restart limits.

    context.setPositions(chain.positions);
    ASSERT(chain.force->proposeTorsions(context, {0}, {0.4}));
    chain.force->acceptProposal(context);
    ASSERT_EQUAL(1, integrator.getNumToleratedClashes(context));
    ASSERT(chain.force->proposeTorsions(context, {0}, {-0.4}));
    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.41}));

    // One that clashes does, like setTorsionAngles(): limits start from there.

    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.6}));
    chain.force->acceptProposal(context);
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));
    assertNotBeyond(0.3);
    ASSERT_EQUAL(1, integrator.getNumToleratedClashes(context));
    integrator.setTorsionAngles(context, {2.5});
    ASSERT(!chain.force->proposeTorsions(context, {0}, {-2.2}));
    chain.force->acceptProposal(context);
    integrator.setInitialClashPolicy(TorsionMonteCarloIntegrator::Refuse);
    assertThrows("particles 0 and 3 clash when sampling starts", [&] {
        integrator.step(1);
    });
    integrator.setInitialClashPolicy(TorsionMonteCarloIntegrator::Tolerate);

    // The user can restart limits.

    integrator.setTorsionAngles(context, {0.4});
    ASSERT(chain.force->proposeTorsions(context, {0}, {0.4}));
    chain.force->acceptProposal(context);
    ASSERT_EQUAL(1, integrator.getNumToleratedClashes(context));
    chain.force->restartLimits(context);
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));
    assertNotBeyond(0.8);

    // A step drops an open proposal.

    ASSERT(chain.force->proposeTorsions(context, {0}, {0}));
    integrator.step(1);
    assertThrows("there is no open proposal", [&] {
        chain.force->acceptProposal(context);
    });
}

void testRefusedClashes(Platform& platform)
{
    BeadChain chain(4, 0.7, 0.5);
    chain.addMolecule(4, 0.7, 0.5, Vec3(0, 0, 5));
    TorsionMonteCarloIntegrator integrator(300);
    ASSERT(integrator.getInitialClashPolicy() == TorsionMonteCarloIntegrator::Tolerate);
    integrator.setInitialClashPolicy(TorsionMonteCarloIntegrator::Refuse);
    ASSERT(integrator.getInitialClashPolicy() == TorsionMonteCarloIntegrator::Refuse);
    integrator.addTorsionMove(1, 0.2);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    const string message = "particles 0 and 3 clash when sampling starts, by an overlap of 0.284";
    assertThrows(message, [&] {
        integrator.step(1);
    });
    assertThrows("they are the first of 2 such pairs", [&] {
        integrator.step(1);
    });
    assertRounded(platform, chain.positions, getPositions(context));
    ASSERT_EQUAL(0, context.getStepCount());
    integrator.setTorsionAngles(context, {2.5, 2.5});
    integrator.step(10);
    ASSERT_EQUAL(10, context.getStepCount());
    integrator.setTorsionAngles(context, {0.5, 2.5});
    assertThrows(message, [&] {
        integrator.step(1);
    });
    integrator.setInitialClashPolicy(TorsionMonteCarloIntegrator::Tolerate);
    integrator.step(1);
    ASSERT_EQUAL(1, integrator.getNumToleratedClashes(context));
}

void testCompoundIntegrator(Platform& platform)
{
    // Spheres 0 and 1 clash from the start. Dynamics pulls 2 and 3 into each other; the steric force is too weak to
    // matter.

    const double tolerance = getTolerance(platform);
    System system;
    StericExclusionForce* force = new StericExclusionForce();
    force->setForceConstant(0);
    system.addForce(force);
    CustomExternalForce* pull = new CustomExternalForce("1000*(x-10)^2");
    pull->setForceGroup(1);
    system.addForce(pull);
    for (int i = 0; i < 4; i++) {
        system.addParticle(1);
        force->addParticle(0.5);
    }
    pull->addParticle(2);
    pull->addParticle(3);
    CompoundIntegrator compound;
    TorsionMonteCarloIntegrator* integrator = new TorsionMonteCarloIntegrator(300);
    integrator->setRandomNumberSeed(3);
    compound.addIntegrator(integrator);
    compound.addIntegrator(new LangevinMiddleIntegrator(1, 10, 0.002));
    integrator->addRigidBodyMove(1, 0.05, 0);
    integrator->setIntegrationForceGroups(1);
    Context context(system, compound, platform);
    context.setPositions({Vec3(0, 0, 0), Vec3(0.9, 0, 0), Vec3(8, 0, 0), Vec3(12, 0, 0)});
    compound.step(2);
    ASSERT_EQUAL(1, integrator->getNumToleratedClashes(context));
    assertThrows("there is no open proposal", [&] {
        force->acceptProposal(context);
    });
    compound.setCurrentIntegrator(1);
    compound.step(2000);
    compound.setCurrentIntegrator(0);
    ASSERT_EQUAL(1, integrator->getNumToleratedClashes(context));
    compound.step(1);
    ASSERT_EQUAL(2, integrator->getNumToleratedClashes(context));
    vector<Vec3> x = getPositions(context);
    double nearest = getDistance(x[2], x[3]);
    ASSERT(nearest < 0.9);

    // Limits that grew stay: the second pair may come as near as it was, whatever the first does.

    compound.step(20);
    ASSERT_EQUAL(2, integrator->getNumToleratedClashes(context));
    x = getPositions(context);
    ASSERT(getDistance(x[0], x[1]) > 0.9 - 1e-8 - tolerance);
    ASSERT_EQUAL(2023, context.getStepCount());
    context.setPositions({Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(8, 0, 0), Vec3(12, 0, 0)});
    compound.step(1);
    ASSERT_EQUAL(0, integrator->getNumToleratedClashes(context));
}

void testMinimization(Platform& platform)
{
    // The minimizer sets positions as a user does: limits start at its result.

    BeadChain chain(4, 0.7, 0.5);
    chain.addMolecule(1, 0.5, 0, chain.positions[0] + Vec3(0, 0.1, 0));
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addTorsionMove(1, 0.5);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    integrator.step(1);
    ASSERT(integrator.getNumToleratedClashes(context) > 1);
    double before = context.getState(State::Energy).getPotentialEnergy();
    chain.force->setOverlapTolerance(0.001);
    chain.force->updateParametersInContext(context);
    LocalEnergyMinimizer::minimize(context, 0.01);
    ASSERT(context.getState(State::Energy).getPotentialEnergy() < 1e-3 * before);
    chain.force->setOverlapTolerance(0.01);
    chain.force->updateParametersInContext(context);
    ASSERT(!chain.force->hasClash(context));
    integrator.step(1);
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));
}

/**
 * Parameters that are refused leave nothing behind: a checkpoint made before still loads.
 */
void testRefusedParameters(Platform& platform)
{
    BeadChain chain(6, 0.45, 0.5);
    chain.force->setParticleParameters(0, 0.9);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(1);
    integrator.addTorsionMove(1, 0.3);
    Context context(chain.system, integrator, platform);
    auto assertRefused = [&] {
        chain.force->setParticleParameters(1, 1e300);
        assertThrows("particle 1 has radius", [&] {
            chain.force->updateParametersInContext(context);
        });
        chain.force->setParticleParameters(1, 0.45);
        chain.force->setOverlapTolerance(1e300);
        assertThrows("tolerance", [&] {
            chain.force->updateParametersInContext(context);
        });
        chain.force->setOverlapTolerance(0);
    };
    assertRefused(); // before there are positions
    context.setPositions(chain.positions);
    integrator.step(2);
    int tolerated = integrator.getNumToleratedClashes(context);
    ASSERT(tolerated > 0);
    stringstream checkpoint;
    context.createCheckpoint(checkpoint);
    integrator.step(2);
    vector<Vec3> end = getPositions(context);
    assertRefused();
    ASSERT_EQUAL(tolerated, integrator.getNumToleratedClashes(context));
    context.loadCheckpoint(checkpoint);
    integrator.step(2);
    assertSameBits(end, getPositions(context));
}

void testBadSystems(Platform& platform)
{
    auto assertRefused = [&](const string& message, const System& system) {
        TorsionMonteCarloIntegrator integrator(300);
        integrator.addTorsionMove(1, 0.1);
        assertThrows(message, [&] {
            Context context(system, integrator, platform);
        });
    };
    System none;
    none.addParticle(1);
    assertRefused("the System has no StericExclusionForce", none);
    BeadChain two(4, 0.3);
    two.system.addForce(new StericExclusionForce(*two.force));
    assertRefused("the System has more than one StericExclusionForce", two.system);

    for (Force* barostat :
         {(Force*)new MonteCarloBarostat(1, 300), (Force*)new MonteCarloAnisotropicBarostat(Vec3(1, 1, 1), 300),
          (Force*)new MonteCarloMembraneBarostat(1, 1, 300, MonteCarloMembraneBarostat::XYIsotropic,
                                                 MonteCarloMembraneBarostat::ZFree),
          (Force*)new MonteCarloFlexibleBarostat(1, 300)}) {
        BeadChain chain(4, 0.3);
        chain.system.addForce(new CustomExternalForce("periodicdistance(x, y, z, 0, 0, 0)"));
        string name = barostat->getName();
        chain.system.addForce(barostat);
        assertRefused("the System has a barostat (force 2, " + name + ")", chain.system);
    }

    // A constraint may not span a torsion, unless one of its particles is on the axis.

    BeadChain spanning(5, 0.3), along(5, 0.3), between(5, 0.3);
    spanning.system.addConstraint(1, 2, 1);
    spanning.system.addConstraint(1, 4, 2);
    assertRefused("the constraint between particles 1 and 4 cannot hold: torsion 1 moves them relative to each other",
                  spanning.system);
    between.addMolecule(3, 0.3, 0, Vec3(5, 0, 0));
    between.system.addConstraint(3, 6, 1);
    assertRefused("the constraint between particles 3 and 6 cannot hold: they are in different molecules",
                  between.system);
    for (int i = 0; i < 4; i++)
        along.system.addConstraint(i, i + 1, 1);
    along.system.addConstraint(0, 2, sqrt(2.0));
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addTorsionMove(1, 0.5);
    Context context(along.system, integrator, platform);
    context.setPositions(along.positions);
    integrator.step(10);
    vector<Vec3> before = getPositions(context);
    context.applyConstraints(1e-8);
    vector<Vec3> after = getPositions(context);
    for (int i = 0; i < 5; i++)
        ASSERT_EQUAL_VEC(before[i], after[i], 1e-10 + getTolerance(platform));
}

void testReinitialize(Platform& platform)
{
    // The integrator continues with a recreated Context, and from its state if that is preserved.

    BeadChain chain(6, 0.45, 0.5);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(6);
    integrator.addTorsionMove(1, 0.5);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    integrator.step(5);
    vector<Vec3> first = getPositions(context);
    context.reinitialize(true);
    assertSameBits(first, getPositions(context));
    integrator.step(5);
    context.reinitialize();
    context.setPositions(chain.positions);
    integrator.step(5);
    assertSameBits(first, getPositions(context));
}

void testSamplingSteps(Platform& platform)
{
    testSteps(platform);
    testSeeds(platform);
    testTorsionAngles(platform);
    testFixedAndVirtual(platform);
    testLimits(platform);
    testRefusedClashes(platform);
    testCompoundIntegrator(platform);
    if (canMinimize(platform))
        testMinimization(platform);
    testRefusedParameters(platform);
    testBadSystems(platform);
    testReinitialize(platform);
}
