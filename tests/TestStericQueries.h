/**
 * This tests the energy of StericExclusionForce, also where others use it, and its queries, on one platform.
 */

#include "openmm/CustomExternalForce.h"
#include "openmm/LangevinMiddleIntegrator.h"
#include "openmm/LocalEnergyMinimizer.h"
#include "openmm/VerletIntegrator.h"
#include "TestSupport.h"
#include <functional>
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

/**
 * Whatever is asked first sees the positions that were set before.
 */
void testNewPositions(Platform& platform)
{
    BeadChain spheres(1, 0.3);
    spheres.addMolecule(1, 0.3, 0, Vec3());
    VerletIntegrator integrator(0.001);
    Context context(spheres.system, integrator, platform);
    const StericExclusionForce& force = *spheres.force;
    Pairs pairs;
    vector<double> values;
    vector<int> particles;
    int particle1, particle2;
    const vector<function<double()>> queries = {
        [&] {
            return force.hasClash(context);
        },
        [&] {
            force.getClashes(context, pairs, values);
            return pairs.size();
        },
        [&] {
            force.getNeighborPairs(context, 1, pairs, values);
            return pairs.size();
        },
        [&] {
            return force.getMinimumDistance(context, {0}, {1}, particle1, particle2) < 1;
        },
        [&] {
            force.getClashesWith(context, Vec3(0.55, 0, 0), 0.01, particles, values);
            return particles.size();
        },
        [&] {
            return context.getState(State::Energy).getPotentialEnergy() > 0;
        }};
    for (auto& ask : queries)
        for (double distance : {0.5, 5.0, 0.5}) {
            context.setPositions({Vec3(), Vec3(distance, 0, 0)});
            ASSERT_EQUAL(distance < 1 ? 1.0 : 0.0, double(ask()));
        }
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

void testStericQueries(Platform& platform)
{
    testOnePair(platform);
    testHydrogenBonds(platform);
    testEnergyAndForces(platform);
    testForceGroups(platform);
    testQueries(platform);
    testNewPositions(platform);
    testMinimumDistanceAgain(platform);
    testStatistics(platform);
    if (canMinimize(platform))
        testMinimization(platform);
    testDynamics(platform);
    testExclusionsFromBonds();
}
