/**
 * This tests the trials of StericExclusionForce on one platform: proposals, limits, and torsion angles.
 */

#include "openmm/VerletIntegrator.h"
#include "openmm/VirtualSite.h"
#include "TestSupport.h"
#include <map>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

typedef vector<pair<int, int>> Pairs;

void testTorsionProposals(Platform& platform)
{
    // Six beads: torsion 1 is about the bond 2-3 and moves 4 and 5.

    const double tolerance = getTolerance(platform);
    BeadChain chain(6, 0.4);
    VerletIntegrator integrator(0.001);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    const double change = 0.7;
    ASSERT(chain.force->proposeTorsions(context, {1}, {change}));
    assertRounded(platform, chain.positions, getPositions(context));
    vector<Vec3> proposed;
    chain.force->getProposedPositions(context, proposed);
    const vector<Vec3>& x = chain.positions;
    for (int i = 0; i < 6; i++) {
        Vec3 expected = i < 4 ? x[i] : rotate(x[i], x[2], x[3] - x[2], change);
        ASSERT_EQUAL_VEC(expected, proposed[i], tolerance);
    }
    double value = getDihedral(proposed[1], proposed[2], proposed[3], proposed[4]);
    ASSERT_EQUAL_TOL(remainder(M_PI + change, 2 * M_PI), value, tolerance);

    // A query does not close the trial, and ignores it.

    Pairs pairs;
    vector<double> values;
    chain.force->getClashes(context, pairs, values);
    ASSERT_EQUAL(0, pairs.size());
    chain.force->acceptProposal(context);
    assertRounded(platform, proposed, getPositions(context));

    // A rejected trial leaves no trace.

    ASSERT(chain.force->proposeTorsions(context, {0, 1, 2}, {0.3, -0.2, 0.1}));
    chain.force->rejectProposal(context);
    assertRounded(platform, proposed, getPositions(context));
    assertThrows("there is no open proposal", [&] {
        chain.force->acceptProposal(context);
    });
    chain.force->rejectProposal(context);

    // A clashing one may be accepted all the same: beads 1 and 4, cis, are one bead spacing apart.

    chain.force->setParticleParameters(1, 0.7);
    chain.force->updateParametersInContext(context);
    value = getDihedral(proposed[1], proposed[2], proposed[3], proposed[4]);
    ASSERT(!chain.force->proposeTorsions(context, {1}, {-value}));
    ASSERT(!chain.force->hasClash(context));
    chain.force->acceptProposal(context);
    ASSERT(chain.force->hasClash(context));
    chain.force->getClashes(context, pairs, values);
    ASSERT_EQUAL_CONTAINERS((Pairs{{1, 4}}), pairs);
    ASSERT_EQUAL_TOL(0.1, values[0], tolerance);
}

void testDroppedProposals(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    BeadChain chain(6, 0.3);
    VerletIntegrator integrator(0.001);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    vector<Vec3> positions;
    assertThrows("there is no open proposal", [&] {
        chain.force->getProposedPositions(context, positions);
    });

    // Setting other positions drops a trial, setting the same ones does not.

    chain.force->proposeTorsions(context, {1}, {0.5});
    context.setPositions(chain.positions);
    chain.force->getProposedPositions(context, positions);
    vector<Vec3> shifted = chain.positions;
    shifted[5] += Vec3(0, 0, 1e-15);
    context.setPositions(shifted);
    assertThrows("there is no open proposal", [&] {
        chain.force->getProposedPositions(context, positions);
    });
    chain.force->proposeTorsions(context, {1}, {0.5});
    context.setPositions(chain.positions);
    assertThrows("there is no open proposal", [&] {
        chain.force->acceptProposal(context);
    });
    assertRounded(platform, chain.positions, getPositions(context));

    chain.force->proposeTorsions(context, {1}, {0.5});
    context.setPositions(shifted);
    Pairs pairs;
    vector<double> before, after;
    assertThrows("there is no open proposal", [&] {
        chain.force->getChangedNeighborPairs(context, 1, pairs, before, after);
    });

    // So does molecular dynamics.

    chain.force->proposeTorsions(context, {1}, {0.5});
    context.setVelocitiesToTemperature(300, 1);
    integrator.step(1);
    assertThrows("there is no open proposal", [&] {
        chain.force->acceptProposal(context);
    });

    // A new proposal takes the place of the old one.

    context.setPositions(chain.positions);
    chain.force->proposeTorsions(context, {1}, {0.5});
    chain.force->proposeTorsions(context, {2}, {0.25});
    chain.force->acceptProposal(context);
    positions = getPositions(context);
    for (int i = 0; i < 5; i++)
        ASSERT_EQUAL_VEC(chain.positions[i], positions[i], tolerance);
    ASSERT(getDistance(chain.positions[5], positions[5]) > 0.1);

    // A proposal that was refused as bad input leaves the open one.

    chain.force->proposeTorsions(context, {1}, {0.5});
    assertThrows("names torsion 3", [&] {
        chain.force->proposeTorsions(context, {3}, {0.5});
    });
    chain.force->acceptProposal(context);
}

void testChangedNeighborPairs(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    BeadChain chain(30, 0.3, 2.0);
    chain.force->setParticleParameters(17, 0);
    VerletIntegrator integrator(0.001);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    const double cutoff = 6;
    chain.force->proposeTorsions(context, {8, 15}, {1.0, -0.6});
    vector<Vec3> proposed;
    chain.force->getProposedPositions(context, proposed);
    Pairs pairs;
    vector<double> before, after;
    chain.force->getChangedNeighborPairs(context, cutoff, pairs, before, after);
    map<pair<int, int>, pair<double, double>> found;
    for (size_t i = 0; i < pairs.size(); i++) {
        ASSERT(i == 0 || pairs[i - 1] < pairs[i]);
        found[pairs[i]] = make_pair(before[i], after[i]);
    }
    int numChanged = 0;
    for (int i = 0; i < 30; i++)
        for (int j = i + 1; j < 30; j++) {
            double d1 = getDistance(chain.positions[i], chain.positions[j]), d2 = getDistance(proposed[i], proposed[j]);
            bool isCounted = (i != 17 && j != 17 && j - i > 2);
            auto pair = found.find(make_pair(i, j));
            if (isCounted && fabs(d1 - d2) > 1e-9 + tolerance && min(d1, d2) <= cutoff - tolerance) {
                ASSERT(pair != found.end());
                numChanged++;
            }
            if (pair != found.end()) {
                ASSERT(isCounted);
                ASSERT_EQUAL_TOL(d1, pair->second.first, tolerance);
                ASSERT_EQUAL_TOL(d2, pair->second.second, tolerance);
                ASSERT(min(d1, d2) <= cutoff + tolerance);
                found.erase(pair);
            }
        }
    ASSERT(found.empty());
    ASSERT(numChanged > 30);
    chain.force->acceptProposal(context);
    assertRounded(platform, proposed, getPositions(context));
    assertThrows("there is no open proposal", [&] {
        chain.force->getChangedNeighborPairs(context, cutoff, pairs, before, after);
    });
}

void testRigidMotions(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    BeadChain chain(5, 0.4);
    int second = chain.addMolecule(4, 0.4, 1.0, Vec3(0, 0, 2));
    VerletIntegrator integrator(0.001);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    Vec3 centroid;
    for (int i = second; i < second + 4; i++)
        centroid += chain.positions[i] / 4;
    Vec3 axis(0.3, -0.2, 0.5), shift(0.1, 0.2, 0.3);
    ASSERT(chain.force->proposeRigidMotion(context, second + 2, axis, shift));
    chain.force->acceptProposal(context);
    vector<Vec3> moved = getPositions(context);
    for (int i = 0; i < second; i++)
        assertRounded(platform, {chain.positions[i]}, {moved[i]});
    for (int i = second; i < second + 4; i++)
        ASSERT_EQUAL_VEC(rotate(chain.positions[i], centroid, axis, sqrt(axis.dot(axis))) + shift, moved[i], tolerance);

    // Without rotation, and into the other molecule.

    ASSERT(!chain.force->proposeRigidMotion(context, second, Vec3(), moved[0] - moved[second]));
    chain.force->acceptProposal(context);
    moved = getPositions(context);
    ASSERT_EQUAL_VEC(moved[0], moved[second], tolerance);
    ASSERT(chain.force->hasClash(context));
}

void testFixedParticles(Platform& platform)
{
    // Bead 5 is fixed: torsion 1, about the bond 2-3, moves 0 and 1.

    const double tolerance = getTolerance(platform);
    BeadChain chain(6, 0.4);
    chain.system.setParticleMass(5, 0);
    VerletIntegrator integrator(0.001);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    chain.force->proposeTorsions(context, {1}, {0.7});
    chain.force->acceptProposal(context);
    vector<Vec3> moved = getPositions(context);
    for (int i = 2; i < 6; i++)
        ASSERT_EQUAL_VEC(chain.positions[i], moved[i], tolerance);
    assertRounded(platform, {chain.positions[5]}, {moved[5]});
    ASSERT_EQUAL_TOL(remainder(M_PI + 0.7, 2 * M_PI), getDihedral(moved[1], moved[2], moved[3], moved[4]), tolerance);
    assertThrows("the molecule of particle 1 has fixed particles and cannot move", [&] {
        chain.force->proposeRigidMotion(context, 1, Vec3(), Vec3());
    });
}

void testVirtualSites(Platform& platform)
{
    // The site is set again wherever the particles that define it go, even if it was elsewhere.

    const double tolerance = getTolerance(platform);
    BeadChain chain(6, 0.3);
    chain.system.addParticle(0);
    chain.force->addParticle(0.1);
    chain.system.setVirtualSite(6, new TwoParticleAverageSite(4, 5, 0.25, 0.75));
    chain.positions.push_back(Vec3(7, 8, 9));
    VerletIntegrator integrator(0.001);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    for (int i = 0; i < 3; i++) {
        chain.force->proposeTorsions(context, {0, 1}, {0.5, 0.6});
        chain.force->acceptProposal(context);
        vector<Vec3> moved = getPositions(context);
        ASSERT_EQUAL_VEC(moved[4] * 0.25 + moved[5] * 0.75, moved[6], tolerance);
        Pairs pairs;
        vector<double> values;
        chain.force->getNeighborPairs(context, 0.8, pairs, values);
        ASSERT_EQUAL_CONTAINERS((Pairs{{4, 6}, {5, 6}}), pairs);
        ASSERT_EQUAL_TOL(0.75, values[0], tolerance);
        ASSERT_EQUAL_TOL(0.25, values[1], tolerance);
    }

    // It need not be the last particle.

    const int last = chain.system.addParticle(1);
    chain.force->addParticle(0.1);
    chain.positions.push_back(Vec3(0, 0, 9));
    VerletIntegrator another(0.001);
    Context inMidst(chain.system, another, platform);
    inMidst.setPositions(chain.positions);
    chain.force->proposeTorsions(inMidst, {0, 1}, {0.5, 0.6});
    chain.force->acceptProposal(inMidst);
    vector<Vec3> moved = getPositions(inMidst);
    ASSERT_EQUAL_VEC(moved[4] * 0.25 + moved[5] * 0.75, moved[6], tolerance);
    assertRounded(platform, {chain.positions[last]}, {moved[last]});

    // The computed site counts as proposed by the trial, to the last bit: limits do not change.

    BeadChain clashing(4, 0.7, 0.5);
    clashing.system.addParticle(0);
    clashing.force->addParticle(0);
    clashing.system.setVirtualSite(4, new TwoParticleAverageSite(2, 3, 0.3, 0.7));
    clashing.positions.push_back(Vec3());
    VerletIntegrator otherIntegrator(0.001);
    Context other(clashing.system, otherIntegrator, platform);
    other.setPositions(clashing.positions);
    for (int i = 0; i < 10; i++) {
        ASSERT(clashing.force->proposeTorsions(other, {0}, {0.03}));
        clashing.force->acceptProposal(other);
        vector<Vec3> accepted = getPositions(other);
        other.computeVirtualSites();
        assertSameBits(accepted, getPositions(other));
    }
    ASSERT(clashing.force->proposeTorsions(other, {0}, {-0.3}));
    ASSERT(!clashing.force->proposeTorsions(other, {0}, {-0.31}));
}

void testLimits(Platform& platform)
{
    // Beads 0 and 3 of radius 0.7 clash up to a dihedral of 1.02: their distance is sqrt(3 - 2 cos(dihedral)).

    const double tolerance = getTolerance(platform);
    BeadChain chain(4, 0.7, 0.5);
    VerletIntegrator integrator(0.001);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    ASSERT(chain.force->hasClash(context));

    // The clash is tolerated as it is; it may become less, but not more.

    ASSERT(chain.force->proposeTorsions(context, {0}, {0.0}));
    ASSERT(chain.force->proposeTorsions(context, {0}, {0.1}));
    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.1}));

    // After a decrease, the overlap may rise to its former value, but not above.

    ASSERT(chain.force->proposeTorsions(context, {0}, {0.3}));
    chain.force->acceptProposal(context);
    ASSERT(chain.force->hasClash(context));
    ASSERT(chain.force->proposeTorsions(context, {0}, {-0.3}));
    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.31}));

    // Positions that no proposal made restart limits, from the clash that they have.

    vector<Vec3> positions = getPositions(context);
    context.setPositions(BeadChain(4, 0.7, 0.7).positions);
    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.1}));
    ASSERT_EQUAL(1, chain.force->getNumToleratedClashes(context));
    context.setPositions(BeadChain(4, 0.7, 0.2).positions);
    ASSERT_EQUAL(0, chain.force->getNumToleratedClashes(context));
    ASSERT(chain.force->proposeTorsions(context, {0}, {0.1}));
    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.1}));

    // So does an accepted clash: its overlap is the new limit.

    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.15}));
    chain.force->acceptProposal(context);
    ASSERT(chain.force->proposeTorsions(context, {0}, {0.1}));
    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.01}));
    chain.force->proposeTorsions(context, {0}, {0.15});
    chain.force->acceptProposal(context);
    chain.force->restartLimits(context);
    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.1}));

    // Limits that are restarted while a trial is proposed start from the proposed positions.

    context.setPositions(BeadChain(4, 0.7, 0.2).positions);
    ASSERT(chain.force->proposeTorsions(context, {0}, {0.3}));
    chain.force->restartLimits(context);
    chain.force->acceptProposal(context);
    ASSERT_EQUAL(0, chain.force->getNumToleratedClashes(context));
    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.1}));
    context.setPositions(BeadChain(4, 0.7, 0.2).positions);

    // So does a step of an Integrator, where no TorsionMonteCarloIntegrator takes turns with it.

    ASSERT(chain.force->proposeTorsions(context, {0}, {0.1}));
    ASSERT_EQUAL(1, chain.force->getNumToleratedClashes(context));
    context.setVelocities(vector<Vec3>(4, Vec3(0, 1, 0)));
    integrator.step(1);
    ASSERT_EQUAL(0, chain.force->getNumToleratedClashes(context));
    context.setPositions(BeadChain(4, 0.7, 0.2).positions);

    // Queries have no influence on limits, and limits none on queries.

    Pairs pairs;
    vector<double> overlaps;
    chain.force->getClashes(context, pairs, overlaps);
    ASSERT_EQUAL_CONTAINERS((Pairs{{0, 3}}), pairs);
    ASSERT_EQUAL_TOL(1.4 - sqrt(3 - 2 * cos(0.2)), overlaps[0], tolerance);
}

/**
 * Angles can be read and set, and tolerated clashes counted, whatever drives the Context.
 */
void testTorsionAngles(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    BeadChain chain(6, 0.7, 0.5);
    VerletIntegrator integrator(0.001);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    vector<double> angles;
    chain.force->getTorsionAngles(context, angles);
    ASSERT_EQUAL(3, angles.size());
    for (double angle : angles)
        ASSERT_EQUAL_TOL(0.5, angle, tolerance);
    ASSERT_EQUAL(0, chain.force->getNumToleratedClashes(context));
    chain.force->proposeTorsions(context, {0}, {0.1});
    ASSERT(chain.force->getNumToleratedClashes(context) > 0);
    chain.force->setTorsionAngles(context, {3.0, -2.5, 2 * M_PI + 2.8});
    ASSERT_EQUAL(0, chain.force->getNumToleratedClashes(context));
    vector<Vec3> positions = getPositions(context);
    vector<double> expected = {3.0, -2.5, 2.8};
    chain.force->getTorsionAngles(context, angles);
    for (int i = 0; i < 3; i++) {
        ASSERT_EQUAL_TOL(expected[i], angles[i], tolerance);
        ASSERT_EQUAL_TOL(expected[i], getDihedral(positions[i], positions[i + 1], positions[i + 2], positions[i + 3]),
                         tolerance);
    }
    assertThrows("setTorsionAngles() was given 2 angles, but there are 3 torsions", [&] {
        chain.force->setTorsionAngles(context, {1, 2});
    });
    BeadChain other(6, 0.1);
    assertThrows("This Force is not present in the Context", [&] {
        other.force->getTorsionAngles(context, angles);
    });
}

void testTrials(Platform& platform)
{
    testTorsionProposals(platform);
    testDroppedProposals(platform);
    testChangedNeighborPairs(platform);
    testRigidMotions(platform);
    testFixedParticles(platform);
    testVirtualSites(platform);
    testLimits(platform);
    testTorsionAngles(platform);
}
