/**
 * This tests StericExclusionForce on one platform: energy and forces, queries, trials for anyone's Monte Carlo, limits,
 * and bad input.
 */

#include "openmm/CustomExternalForce.h"
#include "openmm/HarmonicBondForce.h"
#include "openmm/LangevinMiddleIntegrator.h"
#include "openmm/LocalEnergyMinimizer.h"
#include "openmm/NonbondedForce.h"
#include "openmm/VerletIntegrator.h"
#include "openmm/VirtualSite.h"
#include "openmmchaintree/internal/Warnings.h"
#include "TestSupport.h"
#include <limits>
#include <map>
#include <random>
#include <set>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

typedef vector<pair<int, int>> Pairs;

/**
 * Unbonded particles in a cube, of several radii and roles, some not modelled, with some exclusions; and the plain way
 * to answer what StericExclusionForce answers.
 */
class Crowd {
public:
    Crowd(int numParticles, double edge) : force(new StericExclusionForce())
    {
        mt19937 random(5);
        uniform_real_distribution<double> uniform;
        for (int i = 0; i < numParticles; i++) {
            system.addParticle(10);
            radii.push_back(i % 10 == 0 ? 0 : 0.1 + 0.1 * uniform(random));
            roles.push_back(i % 4);
            force->addParticle(radii[i], StericExclusionForce::HydrogenBondRole(roles[i]));
            positions.push_back(Vec3(uniform(random), uniform(random), uniform(random)) * edge);
        }
        for (int i = 0; i + 7 < numParticles; i += 3) {
            force->addExclusion(i + 7, i);
            excluded.insert(make_pair(i, i + 7));
        }
        system.addForce(force);
    }
    bool isCounted(int i, int j) const
    {
        return radii[i] > 0 && radii[j] > 0 && excluded.find(make_pair(i, j)) == excluded.end();
    }
    double getExcess(int i, int j) const
    {
        bool hydrogenBond = ((roles[i] & 1) && (roles[j] & 2)) || ((roles[i] & 2) && (roles[j] & 1));
        double tolerance = force->getOverlapTolerance() + (hydrogenBond ? force->getHydrogenBondAllowance() : 0);
        return radii[i] + radii[j] - getDistance(positions[i], positions[j]) - tolerance;
    }
    System system;
    StericExclusionForce* force;
    vector<double> radii;
    vector<int> roles;
    set<pair<int, int>> excluded;
    vector<Vec3> positions;
};

void testOnePair(Platform& platform)
{
    // GPU platforms add forces up in fixed point, in units of 2^-32 kJ/mol/nm. Here they are above 100.

    const bool isGpu = (platform.getName() != "Reference" && platform.getName() != "CPU");
    const double tolerance = getTolerance(platform), forceTolerance = isGpu ? 1e-11 + tolerance : 1e-12;

    // Overlap 0.1 nm, tolerance 0.04 nm: 0.06 nm too much.

    System system;
    StericExclusionForce* force = new StericExclusionForce();
    system.addForce(force);
    for (double radius : {0.2, 0.3}) {
        system.addParticle(1);
        force->addParticle(radius);
    }
    force->setForceConstant(2000);
    VerletIntegrator integrator(0.001);
    Context context(system, integrator, platform);
    context.setPositions({Vec3(1, 0, 0), Vec3(1, 0.4, 0)});
    State state = context.getState(State::Energy | State::Forces);
    ASSERT_EQUAL_TOL(0.5 * 2000 * 0.06 * 0.06, state.getPotentialEnergy(), tolerance);
    ASSERT_EQUAL_VEC(Vec3(0, -2000 * 0.06, 0), state.getForces()[0], forceTolerance);
    ASSERT_EQUAL_VEC(Vec3(0, 2000 * 0.06, 0), state.getForces()[1], forceTolerance);
    ASSERT(force->hasClash(context));

    // Within the tolerance there is no clash and no energy.

    context.setPositions({Vec3(1, 0, 0), Vec3(1, 0.47, 0)});
    state = context.getState(State::Energy | State::Forces);
    ASSERT_EQUAL(0, state.getPotentialEnergy());
    ASSERT_EQUAL_VEC(Vec3(0, 0, 0), state.getForces()[0], 0);
    ASSERT(!force->hasClash(context));

    // At the same place, particles are pushed apart along x.

    context.setPositions({Vec3(1, 2, 3), Vec3(1, 2, 3)});
    state = context.getState(State::Energy | State::Forces);
    ASSERT_EQUAL_TOL(0.5 * 2000 * 0.46 * 0.46, state.getPotentialEnergy(), tolerance);
    ASSERT_EQUAL_VEC(Vec3(2000 * 0.46, 0, 0), state.getForces()[0], forceTolerance);
    ASSERT_EQUAL_VEC(Vec3(-2000 * 0.46, 0, 0), state.getForces()[1], forceTolerance);
}

void testHydrogenBonds(Platform& platform)
{
    // Overlap 0.08 nm is beyond the tolerance of 0.04 nm, but not beyond 0.1 nm.

    typedef StericExclusionForce Force;
    const Force::HydrogenBondRole roles[] = {Force::NoHydrogenBond, Force::Donor, Force::Acceptor,
                                             Force::DonorAndAcceptor};
    const bool mayBond[4][4] = {{false, false, false, false},
                                {false, false, true, true},
                                {false, true, false, true},
                                {false, true, true, true}};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            System system;
            StericExclusionForce* force = new StericExclusionForce();
            system.addForce(force);
            system.addParticle(1);
            system.addParticle(1);
            force->addParticle(0.1, roles[i]);
            force->addParticle(0.1, roles[j]);
            VerletIntegrator integrator(0.001);
            Context context(system, integrator, platform);
            context.setPositions({Vec3(), Vec3(0.12, 0, 0)});
            ASSERT_EQUAL(!mayBond[i][j], force->hasClash(context));
            context.setPositions({Vec3(), Vec3(0.09, 0, 0)});
            ASSERT(force->hasClash(context));
        }
}

void testEnergyAndForces(Platform& platform)
{
    Crowd crowd(120, 1.2);
    crowd.force->setForceConstant(3000);
    VerletIntegrator integrator(0.001);
    Context context(crowd.system, integrator, platform);
    context.setPositions(crowd.positions);
    State state = context.getState(State::Energy | State::Forces);
    double energy = 0;
    for (int i = 0; i < 120; i++)
        for (int j = i + 1; j < 120; j++)
            if (crowd.isCounted(i, j) && crowd.getExcess(i, j) > 0)
                energy += 0.5 * 3000 * crowd.getExcess(i, j) * crowd.getExcess(i, j);
    ASSERT(energy > 100);
    ASSERT_EQUAL_TOL(energy, state.getPotentialEnergy(), 1e-10 + getTolerance(platform));

    // A central difference along the force.

    const vector<Vec3>& forces = state.getForces();
    double norm = 0;
    for (const Vec3& f : forces)
        norm += f.dot(f);
    norm = sqrt(norm);
    const bool single = (getPrecision(platform) == "single");
    const double step = single ? 1e-3 : 1e-5;
    double energies[2];
    for (int side = 0; side < 2; side++) {
        vector<Vec3> displaced = crowd.positions;
        for (int i = 0; i < 120; i++)
            displaced[i] += forces[i] * ((side == 0 ? -0.5 : 0.5) * step / norm);
        context.setPositions(displaced);
        energies[side] = context.getState(State::Energy).getPotentialEnergy();
    }
    ASSERT_EQUAL_TOL(norm, (energies[0] - energies[1]) / step, single ? 1e-3 : 1e-5);
}

/** The engine keeps the sets that were asked about last, and begins with the pair that was nearest. */
void testMinimumDistanceAgain(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    Crowd crowd(150, 1.5);
    VerletIntegrator integrator(0.001);
    Context context(crowd.system, integrator, platform);
    vector<int> sets[3];
    for (int i = 0; i < 150; i++)
        sets[i % 3].push_back(i);
    sets[2] = {3, 7, 64, 130};
    for (int round = 0; round < 40; round++) {
        crowd.positions[(31 * round) % 150] = Vec3(round % 7, round % 5, round % 3) * 0.3;
        context.setPositions(crowd.positions);
        if (round % 10 == 9) {
            crowd.force->setParticleParameters(round, 0.1, StericExclusionForce::NoHydrogenBond);
            crowd.force->updateParametersInContext(context); // makes another scene
        }
        const vector<int>&set1 = sets[round / 4 % 3], &set2 = sets[round / 3 % 3];
        double least = 1e10;
        for (int i : set1)
            for (int j : set2)
                if (i != j)
                    least = min(least, getDistance(crowd.positions[i], crowd.positions[j]));
        for (int ask = 0; ask < 2; ask++) {
            int particle1, particle2;
            double found = crowd.force->getMinimumDistance(context, set1, set2, particle1, particle2);
            ASSERT_EQUAL_TOL(least, found, tolerance);
            ASSERT_EQUAL_TOL(least, getDistance(crowd.positions[particle1], crowd.positions[particle2]), tolerance);
            ASSERT(find(set1.begin(), set1.end(), particle1) != set1.end());
            ASSERT(find(set2.begin(), set2.end(), particle2) != set2.end());
        }
    }
}

void testForceGroups(Platform& platform)
{
    Crowd crowd(50, 0.8);
    crowd.force->setForceGroup(3);
    VerletIntegrator integrator(0.001);
    Context context(crowd.system, integrator, platform);
    context.setPositions(crowd.positions);
    ASSERT(context.getState(State::Energy, false, 1 << 3).getPotentialEnergy() > 0);
    ASSERT_EQUAL(0, context.getState(State::Energy, false, ~(1 << 3)).getPotentialEnergy());
    ASSERT(!crowd.force->usesPeriodicBoundaryConditions());
    ASSERT(!crowd.system.usesPeriodicBoundaryConditions());
}

void testQueries(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    Crowd crowd(150, 1.5);
    VerletIntegrator integrator(0.001);
    Context context(crowd.system, integrator, platform);
    context.setPositions(crowd.positions);
    Pairs expectedClashes, expectedNeighbors;
    vector<double> expectedOverlaps, expectedDistances;
    for (int i = 0; i < 150; i++)
        for (int j = i + 1; j < 150; j++) {
            if (!crowd.isCounted(i, j))
                continue;
            double distance = getDistance(crowd.positions[i], crowd.positions[j]);
            if (crowd.getExcess(i, j) > 0) {
                expectedClashes.push_back(make_pair(i, j));
                expectedOverlaps.push_back(crowd.radii[i] + crowd.radii[j] - distance);
            }
            if (distance <= 0.5) {
                expectedNeighbors.push_back(make_pair(i, j));
                expectedDistances.push_back(distance);
            }
        }
    ASSERT(expectedClashes.size() > 50);
    Pairs pairs;
    vector<double> values;
    crowd.force->getClashes(context, pairs, values);
    ASSERT_EQUAL_CONTAINERS(expectedClashes, pairs);
    for (size_t i = 0; i < pairs.size(); i++)
        ASSERT_EQUAL_TOL(expectedOverlaps[i], values[i], tolerance);
    ASSERT(crowd.force->hasClash(context));
    crowd.force->getNeighborPairs(context, 0.5, pairs, values);
    ASSERT_EQUAL_CONTAINERS(expectedNeighbors, pairs);
    for (size_t i = 0; i < pairs.size(); i++)
        ASSERT_EQUAL_TOL(expectedDistances[i], values[i], tolerance);

    // The minimum distance includes what is not modelled or excluded.

    vector<int> set1 = {0, 10, 20, 30, 33, 47}, set2 = {7, 40, 50, 33, 60, 99, 100};
    double least = 1e10;
    for (int i : set1)
        for (int j : set2)
            if (i != j)
                least = min(least, getDistance(crowd.positions[i], crowd.positions[j]));
    int particle1, particle2;
    ASSERT_EQUAL_TOL(least, crowd.force->getMinimumDistance(context, set1, set2, particle1, particle2), tolerance);
    ASSERT_EQUAL_TOL(least, getDistance(crowd.positions[particle1], crowd.positions[particle2]), tolerance);
    ASSERT(find(set1.begin(), set1.end(), particle1) != set1.end());
    ASSERT(find(set2.begin(), set2.end(), particle2) != set2.end());

    // A probe.

    Vec3 center(0.7, 0.8, 0.6);
    vector<int> expectedParticles, particles;
    for (int i = 0; i < 150; i++)
        if (crowd.radii[i] > 0 && crowd.radii[i] + 0.3 - getDistance(crowd.positions[i], center) > 0.04)
            expectedParticles.push_back(i);
    ASSERT(expectedParticles.size() > 5);
    crowd.force->getClashesWith(context, center, 0.3, particles, values);
    ASSERT_EQUAL_CONTAINERS(expectedParticles, particles);
    for (size_t i = 0; i < particles.size(); i++)
        ASSERT_EQUAL_TOL(crowd.radii[particles[i]] + 0.3 - getDistance(crowd.positions[particles[i]], center),
                         values[i], tolerance);
}

void testExclusionsFromBonds()
{
    // A ring of six with a tail: 0-1-2-3-4-5-0, 0-6-7, and a lone particle.

    StericExclusionForce force;
    for (int i = 0; i < 9; i++)
        force.addParticle(0.1);
    for (int i = 0; i < 6; i++)
        force.addBond(i, (i + 1) % 6);
    force.addBond(6, 0);
    force.addBond(7, 6);
    force.createExclusionsFromBonds(0);
    ASSERT_EQUAL(0, force.getNumExclusions());
    force.addExclusion(5, 3);
    force.createExclusionsFromBonds(2);
    set<pair<int, int>> found;
    for (int i = 0; i < force.getNumExclusions(); i++) {
        int particle1, particle2;
        force.getExclusionParticles(i, particle1, particle2);
        found.insert(minmax(particle1, particle2));
    }
    set<pair<int, int>> expected = {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}, {0, 5}, {0, 2}, {1, 3}, {2, 4},
                                    {3, 5}, {0, 4}, {1, 5}, {0, 6}, {1, 6}, {5, 6}, {6, 7}, {0, 7}};
    ASSERT_EQUAL_CONTAINERS(expected, found);
    ASSERT_EQUAL(expected.size(), force.getNumExclusions());
    force.createExclusionsFromBonds(2);
    ASSERT_EQUAL(expected.size(), force.getNumExclusions());
    force.createExclusionsFromBonds(3);
    ASSERT_EQUAL(expected.size() + 3 + 4, force.getNumExclusions());
    force.addBond(3, 9);
    assertThrows("a bond names particle 9, but there are 9 particles", [&] {
        force.createExclusionsFromBonds(3);
    });
    assertThrows("bondCutoff must be at least 0, but is -1", [&] {
        force.createExclusionsFromBonds(-1);
    });
}

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

    // A query does not close the trial, and sees nothing of it.

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
    // The site is set anew wherever the particles that define it go, even if it was elsewhere.

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

    // What the site is set to counts as what the trial proposed, to the last bit: limits stay as they were.

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

    // Once less, it may become what it was, but still not more.

    ASSERT(chain.force->proposeTorsions(context, {0}, {0.3}));
    chain.force->acceptProposal(context);
    ASSERT(chain.force->hasClash(context));
    ASSERT(chain.force->proposeTorsions(context, {0}, {-0.3}));
    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.31}));

    // Positions that no proposal made start limits anew, from the clash that they have.

    vector<Vec3> positions = getPositions(context);
    context.setPositions(BeadChain(4, 0.7, 0.7).positions);
    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.1}));
    context.setPositions(BeadChain(4, 0.7, 0.2).positions);
    ASSERT(chain.force->proposeTorsions(context, {0}, {0.1}));
    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.1}));

    // So does a clash that is accepted: what it clashes by is the limit from then on.

    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.15}));
    chain.force->acceptProposal(context);
    ASSERT(chain.force->proposeTorsions(context, {0}, {0.1}));
    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.01}));
    chain.force->proposeTorsions(context, {0}, {0.15});
    chain.force->acceptProposal(context);
    chain.force->restartLimits(context);
    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.1}));

    // Whoever starts limits anew while a trial is open has them start from where it leads.

    context.setPositions(BeadChain(4, 0.7, 0.2).positions);
    ASSERT(chain.force->proposeTorsions(context, {0}, {0.3}));
    chain.force->restartLimits(context);
    chain.force->acceptProposal(context);
    ASSERT_EQUAL(0, chain.force->getNumToleratedClashes(context));
    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.1}));
    context.setPositions(BeadChain(4, 0.7, 0.2).positions);

    // Queries have no influence on limits, and limits none on queries.

    Pairs pairs;
    vector<double> overlaps;
    chain.force->getClashes(context, pairs, overlaps);
    ASSERT_EQUAL_CONTAINERS((Pairs{{0, 3}}), pairs);
    ASSERT_EQUAL_TOL(1.4 - sqrt(3 - 2 * cos(0.2)), overlaps[0], tolerance);
}

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

    // The structure stays what it was.

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

void testStatistics(Platform& platform)
{
    BeadChain chain(200, 0.45, 0.8);
    VerletIntegrator integrator(0.001);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    long long queries, volumeTests, particleTests, nodesUpdated;
    chain.force->hasClash(context);
    chain.force->proposeTorsions(context, {100}, {0.01});
    chain.force->resetTraversalStatistics(context);
    chain.force->acceptProposal(context);
    chain.force->getTraversalStatistics(context, queries, volumeTests, particleTests, nodesUpdated);
    ASSERT_EQUAL(0, queries);
    ASSERT(nodesUpdated > 0);
    ASSERT_EQUAL(0, particleTests);
    chain.force->proposeTorsions(context, {100}, {0.01});
    context.getState(State::Energy);
    Pairs pairs;
    vector<double> values;
    chain.force->getNeighborPairs(context, 3, pairs, values);
    chain.force->getTraversalStatistics(context, queries, volumeTests, particleTests, nodesUpdated);
    ASSERT_EQUAL(3, queries);
    ASSERT(volumeTests > 0);
    ASSERT(particleTests >= (long long)pairs.size());
}

void testMinimization(Platform& platform)
{
    Crowd crowd(60, 1.2);
    ASSERT(crowd.force->getForceConstant() == 1e5);
    VerletIntegrator integrator(0.001);
    Context context(crowd.system, integrator, platform);
    context.setPositions(crowd.positions);
    double before = context.getState(State::Energy).getPotentialEnergy();
    LocalEnergyMinimizer::minimize(context, 1, 500);
    ASSERT(context.getState(State::Energy).getPotentialEnergy() < 1e-3 * before);
}

void testDynamics(Platform& platform)
{
    // Soft spheres held together by springs.

    Crowd crowd(60, 1.5);
    crowd.force->setForceConstant(2000);
    CustomExternalForce* spring = new CustomExternalForce("30*((x-0.75)^2+(y-0.75)^2+(z-0.75)^2)");
    for (int i = 0; i < 60; i++)
        spring->addParticle(i);
    crowd.system.addForce(spring);
    {
        VerletIntegrator integrator(0.001);
        Context context(crowd.system, integrator, platform);
        context.setPositions(crowd.positions);
        context.setVelocitiesToTemperature(300, 1);
        integrator.step(10);
        double least = 1e10, largest = -1e10;
        for (int i = 0; i < 100; i++) {
            integrator.step(10);
            State state = context.getState(State::Energy);
            ASSERT(state.getPotentialEnergy() > 0);
            least = min(least, state.getPotentialEnergy() + state.getKineticEnergy());
            largest = max(largest, state.getPotentialEnergy() + state.getKineticEnergy());
        }
        ASSERT(largest - least < 0.01 * largest);
    }
    LangevinMiddleIntegrator integrator(300, 5, 0.002);
    integrator.setRandomNumberSeed(3);
    Context context(crowd.system, integrator, platform);
    context.setPositions(crowd.positions);
    integrator.step(1000);
    double kinetic = 0;
    for (int i = 0; i < 200; i++) {
        integrator.step(10);
        kinetic += context.getState(State::Energy).getKineticEnergy() / 200;
    }
    ASSERT_USUALLY_EQUAL_TOL(1.5 * 60 * 0.00831446 * 300, kinetic, 0.1);
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

// ---- Torsion angles ----

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

// ---- Warnings ----

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

void testStericExclusionForce(Platform& platform)
{
    testOnePair(platform);
    testHydrogenBonds(platform);
    testEnergyAndForces(platform);
    testForceGroups(platform);
    testQueries(platform);
    testMinimumDistanceAgain(platform);
    testExclusionsFromBonds();
    testTorsionProposals(platform);
    testDroppedProposals(platform);
    testChangedNeighborPairs(platform);
    testRigidMotions(platform);
    testFixedParticles(platform);
    testVirtualSites(platform);
    testLimits(platform);
    testUpdateParameters(platform);
    testRefusedUpdate(platform);
    testTwoContexts(platform);
    testStatistics(platform);
    if (canMinimize(platform))
        testMinimization(platform);
    testDynamics(platform);
    testFailureLeavesContextUsable(platform);
    testBadArguments(platform);
    testTorsionAngles(platform);
    testPeriodicForces(platform);
    testBadDefinitions(platform);
}
