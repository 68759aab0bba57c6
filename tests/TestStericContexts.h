/**
 * This tests StericExclusionForce in Contexts on one platform: new parameters, bad input, and warnings.
 */

#include "openmm/CustomIntegrator.h"
#include "openmm/HarmonicBondForce.h"
#include "openmm/NonbondedForce.h"
#include "openmm/VerletIntegrator.h"
#include "openmmchaintree/internal/Warnings.h"
#include "TestSupport.h"
#include <limits>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

typedef vector<pair<int, int>> Pairs;

void testUpdateParameters(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    BeadChain chain(6, 0.1, 0.5);
    chain.force->setParticleParameters(3, 0.4);
    VerletIntegrator integrator(0.001);
    Context context(chain.system, integrator, platform);
    chain.force->setForceConstant(100);
    context.setPositions(chain.positions);
    ASSERT(!chain.force->hasClash(context));
    chain.force->proposeTorsions(context, {0}, {0.1});

    // Nothing changes until it is asked for.

    double distance = sqrt(3 - 2 * cos(0.5));
    chain.force->setParticleParameters(0, distance - 0.3);
    ASSERT(!chain.force->hasClash(context));
    chain.force->updateParametersInContext(context);
    assertThrows("there is no open proposal", [&] {
        chain.force->acceptProposal(context);
    });
    Pairs pairs;
    vector<double> overlaps;
    chain.force->getClashes(context, pairs, overlaps);
    ASSERT_EQUAL_CONTAINERS((Pairs{{0, 3}}), pairs);
    ASSERT_EQUAL_TOL(0.1, overlaps[0], tolerance);
    ASSERT_EQUAL_TOL(50 * 0.1 * 0.1, context.getState(State::Energy).getPotentialEnergy(), tolerance);

    // The new clash gets its limit, and keeps it when other parameters change.

    ASSERT(chain.force->proposeTorsions(context, {0}, {0.2}));
    chain.force->acceptProposal(context);
    chain.force->setParticleParameters(5, 0.11);
    chain.force->updateParametersInContext(context);
    ASSERT(chain.force->proposeTorsions(context, {0}, {-0.2}));
    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.21}));

    // Tolerance, allowance and roles.

    context.setPositions(chain.positions);
    chain.force->setOverlapTolerance(0.11);
    chain.force->updateParametersInContext(context);
    ASSERT(!chain.force->hasClash(context));
    chain.force->setOverlapTolerance(0.05);
    chain.force->updateParametersInContext(context);
    ASSERT(chain.force->hasClash(context));
    chain.force->setParticleParameters(0, distance - 0.3, StericExclusionForce::Donor);
    chain.force->setParticleParameters(3, 0.4, StericExclusionForce::Acceptor);
    chain.force->updateParametersInContext(context);
    ASSERT(!chain.force->hasClash(context));
    chain.force->setHydrogenBondAllowance(0.04);
    chain.force->updateParametersInContext(context);
    ASSERT(chain.force->hasClash(context));

    // What is there already may be repeated, in any order.

    chain.force->addBond(1, 0);
    chain.force->addBond(4, 5);
    chain.force->addExclusion(1, 0);
    chain.force->setForceConstant(50);
    chain.force->updateParametersInContext(context);
    ASSERT(chain.force->hasClash(context));

    // The structure does not change.

    chain.force->addExclusion(0, 3);
    assertThrows("reinitialize the Context", [&] {
        chain.force->updateParametersInContext(context);
    });
    ASSERT(chain.force->hasClash(context));
    context.reinitialize(true);
    ASSERT(!chain.force->hasClash(context));
    chain.force->addBond(0, 2);
    assertThrows("reinitialize the Context", [&] {
        chain.force->updateParametersInContext(context);
    });
    BeadChain turned(6, 0.1, 0.5);
    VerletIntegrator another(0.001);
    Context other(turned.system, another, platform);
    turned.force->addTorsion(0, 1, 2, 3);
    assertThrows("reinitialize the Context", [&] {
        turned.force->updateParametersInContext(other);
    });
}

/**
 * A CustomIntegrator asks for forces again only if it is told that they have changed.
 */
void testUpdateIsTold(Platform& platform)
{
    BeadChain chain(4, 0.7, 0.5);
    chain.force->setForceConstant(1);
    CustomIntegrator integrator(0.001);
    integrator.addComputePerDof("v", "f");
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    integrator.step(1);
    const Vec3 before = context.getState(State::Velocities).getVelocities()[0];
    ASSERT(sqrt(before.dot(before)) > 0.1);
    chain.force->setForceConstant(3);
    chain.force->updateParametersInContext(context);
    integrator.step(1);
    ASSERT_EQUAL_VEC(before * 3, context.getState(State::Velocities).getVelocities()[0], 1e-5);
}

/**
 * An update that is refused leaves everything as it was, the open trial included.
 */
void testRefusedUpdate(Platform& platform)
{
    BeadChain chain(6, 0.4, 0.5);
    VerletIntegrator integrator(0.001);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    chain.force->proposeTorsions(context, {1}, {0.1});
    vector<Vec3> proposed, same;
    chain.force->getProposedPositions(context, proposed);
    double energy = context.getState(State::Energy).getPotentialEnergy();
    chain.force->setForceConstant(1);
    chain.force->setParticleParameters(0, 0.9);
    chain.force->setParticleParameters(2, 1e20);
    assertThrows("particle 2 has radius", [&] {
        chain.force->updateParametersInContext(context);
    });
    ASSERT_EQUAL(energy, context.getState(State::Energy).getPotentialEnergy());
    chain.force->getProposedPositions(context, same);
    assertSameBits(proposed, same);
    chain.force->acceptProposal(context);
    context.setPositions(chain.positions);
    ASSERT_EQUAL(energy, context.getState(State::Energy).getPotentialEnergy());
}

void testTwoContexts(Platform& platform)
{
    // They share the force, but not positions, proposals, limits or counts.

    const double tolerance = getTolerance(platform);
    BeadChain chain(6, 0.45, 0.5);
    VerletIntegrator integrator1(0.001), integrator2(0.001);
    Context context1(chain.system, integrator1, platform), context2(chain.system, integrator2, platform);
    context1.setPositions(chain.positions);
    vector<Vec3> straight = BeadChain(6, 0.45).positions;
    context2.setPositions(straight);
    chain.force->proposeTorsions(context1, {0}, {0.1});
    assertThrows("there is no open proposal", [&] {
        chain.force->acceptProposal(context2);
    });
    chain.force->proposeTorsions(context2, {1}, {0.2});
    chain.force->acceptProposal(context1);
    assertRounded(platform, straight, getPositions(context2));
    vector<Vec3> x = getPositions(context1);
    ASSERT_EQUAL_TOL(0.6, getDihedral(x[0], x[1], x[2], x[3]), tolerance);
    chain.force->acceptProposal(context2);
    x = getPositions(context2);
    ASSERT_EQUAL_TOL(0.2 - M_PI, getDihedral(x[1], x[2], x[3], x[4]), tolerance);

    long long queries, volumeTests, particleTests, nodesUpdated;
    chain.force->resetTraversalStatistics(context1);
    chain.force->getTraversalStatistics(context1, queries, volumeTests, particleTests, nodesUpdated);
    ASSERT(queries == 0 && volumeTests == 0 && particleTests == 0 && nodesUpdated == 0);
    chain.force->getTraversalStatistics(context2, queries, volumeTests, particleTests, nodesUpdated);
    ASSERT(queries == 1 && nodesUpdated > 0);
}

void testFailureLeavesContextUsable(Platform& platform)
{
    BeadChain chain(6, 0.3);
    VerletIntegrator integrator(0.001);
    Context context(chain.system, integrator, platform);
    assertThrows("Particle positions have not been set", [&] {
        chain.force->hasClash(context);
    });
    assertThrows("Particle positions have not been set", [&] {
        chain.force->proposeTorsions(context, {0}, {0.1});
    });
    for (double bad : {numeric_limits<double>::quiet_NaN(), numeric_limits<double>::infinity()}) {
        vector<Vec3> positions = chain.positions;
        positions[4][2] = bad;
        context.setPositions(positions);
        assertThrows("the position of particle 4 is not finite", [&] {
            chain.force->hasClash(context);
        });
        if (platform.getName() == "Reference") // The CPU platform has its own message, before forces are asked.
            assertThrows("the position of particle 4 is not finite", [&] {
                context.getState(State::Energy);
            });
        context.setPositions(chain.positions);
        ASSERT(!chain.force->hasClash(context));
        ASSERT_EQUAL(0, context.getState(State::Energy).getPotentialEnergy());
    }
}

void testBadArguments(Platform& platform)
{
    const double nan = numeric_limits<double>::quiet_NaN(), infinity = numeric_limits<double>::infinity();
    BeadChain chain(6, 0.3);
    StericExclusionForce& force = *chain.force;
    for (double bad : {-0.1, nan, infinity}) {
        assertThrows("the radius of particle 6 must be a finite number and at least 0", [&] {
            force.addParticle(bad);
        });
        assertThrows("the radius of particle 2 must be a finite number and at least 0", [&] {
            force.setParticleParameters(2, bad);
        });
        assertThrows("the overlap tolerance must be a finite number and at least 0", [&] {
            force.setOverlapTolerance(bad);
        });
        assertThrows("the hydrogen bond allowance must be a finite number and at least 0", [&] {
            force.setHydrogenBondAllowance(bad);
        });
        assertThrows("the force constant must be a finite number and at least 0", [&] {
            force.setForceConstant(bad);
        });
    }
    assertThrows("the hydrogen bond role of particle 6 must be", [&] {
        force.addParticle(0.1, StericExclusionForce::HydrogenBondRole(4));
    });
    double radius;
    StericExclusionForce::HydrogenBondRole role;
    int p;
    assertThrows("Index out of range", [&] {
        force.getParticleParameters(6, radius, role);
    });
    assertThrows("Index out of range", [&] {
        force.setParticleParameters(-1, 0.1);
    });
    assertThrows("Index out of range", [&] {
        force.getBondParticles(5, p, p);
    });
    assertThrows("Index out of range", [&] {
        force.getTorsionParticles(3, p, p, p, p);
    });
    assertThrows("Index out of range", [&] {
        force.getExclusionParticles(9, p, p);
    });

    VerletIntegrator integrator(0.001);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    Pairs pairs;
    vector<double> values, others;
    vector<int> particles;
    for (double bad : {0.0, -1.0, nan, infinity}) {
        assertThrows("the cutoff is", [&] {
            force.getNeighborPairs(context, bad, pairs, values);
        });
        force.proposeTorsions(context, {1}, {0.1});
        assertThrows("the cutoff is", [&] {
            force.getChangedNeighborPairs(context, bad, pairs, values, others);
        });
    }
    for (double bad : {-1.0, nan, infinity})
        assertThrows("the radius of the probe is", [&] {
            force.getClashesWith(context, Vec3(), bad, particles, values);
        });
    assertThrows("the position of the probe is not finite", [&] {
        force.getClashesWith(context, Vec3(0, nan, 0), 0.1, particles, values);
    });
    assertThrows("there is no particle 6", [&] {
        force.getMinimumDistance(context, {0, 6}, {1}, p, p);
    });
    assertThrows("there is no particle -1", [&] {
        force.getMinimumDistance(context, {0}, {-1}, p, p);
    });
    assertThrows("hold no pair of different particles", [&] {
        force.getMinimumDistance(context, {}, {1}, p, p);
    });
    assertThrows("hold no pair of different particles", [&] {
        force.getMinimumDistance(context, {1}, {1}, p, p);
    });
    assertThrows("names torsion 3, but there are 3 torsions", [&] {
        force.proposeTorsions(context, {0, 3}, {0, 0});
    });
    assertThrows("names torsion -1, but there are 3 torsions", [&] {
        force.proposeTorsions(context, {-1}, {0});
    });
    assertThrows("names torsion 1 twice", [&] {
        force.proposeTorsions(context, {1, 0, 1}, {0, 0, 0});
    });
    assertThrows("was given 2 torsions, but 1 changes", [&] {
        force.proposeTorsions(context, {1, 0}, {0});
    });
    assertThrows("the change of torsion 2 is not finite", [&] {
        force.proposeTorsions(context, {0, 2}, {0, nan});
    });
    assertThrows("names particle 6, but there are 6 particles", [&] {
        force.proposeRigidMotion(context, 6, Vec3(), Vec3());
    });
    assertThrows("must be finite", [&] {
        force.proposeRigidMotion(context, 0, Vec3(0, 0, infinity), Vec3());
    });
    assertThrows("must be finite", [&] {
        force.proposeRigidMotion(context, 0, Vec3(), Vec3(nan, 0, 0));
    });
}

vector<string> warnings;

void noteWarning(const string& message)
{
    warnings.push_back(message);
}

void testPeriodicForces(Platform& platform)
{
    setWarningHandler(noteWarning);
    BeadChain chain(4, 0.1);
    NonbondedForce* nonbonded = new NonbondedForce();
    for (int i = 0; i < 4; i++)
        nonbonded->addParticle(0, 0.1, 0);
    nonbonded->setNonbondedMethod(NonbondedForce::CutoffNonPeriodic);
    chain.system.addForce(nonbonded);
    VerletIntegrator integrator(0.001);
    {
        Context context(chain.system, integrator, platform);
    }
    ASSERT_EQUAL(0, warnings.size());

    // One warning is enough, however many forces are periodic.

    nonbonded->setNonbondedMethod(NonbondedForce::CutoffPeriodic);
    nonbonded->setCutoffDistance(0.5);
    HarmonicBondForce* bonds = new HarmonicBondForce();
    bonds->setUsesPeriodicBoundaryConditions(true);
    chain.system.addForce(bonds);
    {
        VerletIntegrator another(0.001);
        Context context(chain.system, another, platform);
        context.setPositions(chain.positions);
        chain.force->hasClash(context);
        another.step(2);
    }
    ASSERT_EQUAL(1, warnings.size());
    ASSERT(warnings[0].find("(force 1, NonbondedForce), but spheres ignore periodic images") != string::npos);
    warnings.clear();
    setWarningHandler(ignoreWarning);
}

void testBadDefinitions(Platform& platform)
{
    auto assertContextRefused = [&](const string& message, const BeadChain& chain) {
        VerletIntegrator integrator(0.001);
        assertThrows(message, [&] {
            Context context(chain.system, integrator, platform);
        });
    };
    BeadChain tooMany(4, 0.1), outOfRange(4, 0.1), self(4, 0.1), badTorsion(4, 0.1);
    tooMany.force->addParticle(0.1);
    assertContextRefused("it has 5 particles, but the System has 4", tooMany);
    outOfRange.force->addExclusion(2, 4);
    assertContextRefused("exclusion 5 names particle 4, but there are 4 particles", outOfRange);
    self.force->addExclusion(2, 2);
    assertContextRefused("exclusion 5 excludes particle 2 from itself", self);
    badTorsion.force->addTorsion(3, 2, 1, 0);
    assertContextRefused("are about the same bond", badTorsion);
}

void testStericContexts(Platform& platform)
{
    testUpdateParameters(platform);
    testUpdateIsTold(platform);
    testRefusedUpdate(platform);
    testTwoContexts(platform);
    testFailureLeavesContextUsable(platform);
    testBadArguments(platform);
    testPeriodicForces(platform);
    testBadDefinitions(platform);
}
