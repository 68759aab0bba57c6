/**
 * This tests which energies TorsionMonteCarloIntegrator samples with, where and how often it asks for them, and what it
 * does when there is none, on one platform.
 */

#include "openmm/AndersenThermostat.h"
#include "openmm/CMMotionRemover.h"
#include "openmm/CompoundIntegrator.h"
#include "openmm/CustomExternalForce.h"
#include "openmm/CustomTorsionForce.h"
#include "openmm/internal/ContextImpl.h"
#include "openmm/NonbondedForce.h"
#include "openmm/VirtualSite.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "SamplingSupport.h"
#include <functional>
#include <limits>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * The change of the soft spheres' energy in a trial is correct for all moves and kinds of pairs: at a temperature of 0
 * this energy never rises, and it is the only stage that is computed.
 */
void testSoftEnergy(Platform& platform)
{
    BeadChain chain(20, 0.7, 0.6);
    chain.addMolecule(6, 0.6, 0.4, Vec3(1, 1, 1));
    chain.force->setParticleParameters(4, 0);
    chain.force->setParticleParameters(2, 0.8, StericExclusionForce::Donor);
    chain.force->setParticleParameters(9, 0.8, StericExclusionForce::Acceptor);
    chain.force->setParticleParameters(12, 0.8, StericExclusionForce::DonorAndAcceptor);
    chain.force->setOverlapTolerance(0.02);
    TorsionMonteCarloIntegrator integrator(0);
    integrator.setStericMode(TorsionMonteCarloIntegrator::Soft);
    integrator.setRandomNumberSeed(1);
    integrator.setTrialsPerStep(1);
    integrator.addTorsionMove(2, 0.2, {}, 2);
    integrator.addRigidBodyMove(1, 0.1, 0.1);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    auto getEnergy = [&] {
        return context.getState(State::Energy).getPotentialEnergy();
    };
    const double start = getEnergy();
    double before = start;
    for (int i = 0; i < 2000; i++) {
        integrator.step(1);
        double after = getEnergy();
        ASSERT(after <= before + start * getTolerance(platform));
        before = after;
    }
    ASSERT(before < 0.2 * start);

    // Hard trials that follow restart limits, from the remaining clashes.

    vector<pair<int, int>> pairs;
    vector<double> overlaps;
    context.setPositions(chain.positions);
    integrator.step(1);
    chain.force->getClashes(context, pairs, overlaps);
    ASSERT(pairs.size() > 3);
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));
    integrator.setStericMode(TorsionMonteCarloIntegrator::Hard);
    integrator.step(1);
    ASSERT_EQUAL(pairs.size(), integrator.getNumToleratedClashes(context));
    integrator.setStericMode(TorsionMonteCarloIntegrator::Soft);
    integrator.setInitialClashPolicy(TorsionMonteCarloIntegrator::Refuse);
    integrator.step(1);
    integrator.setStericMode(TorsionMonteCarloIntegrator::Hard);
    assertThrows("clash when sampling starts", [&] {
        integrator.step(1);
    });
}

/**
 * Soft spheres that may share a hydrogen bond overlap by the allowance for nothing, whichever is the donor.
 */
void testSoftHydrogenBonds(Platform& platform)
{
    for (bool donorFirst : {true, false}) {
        System system;
        StericExclusionForce* force = new StericExclusionForce();
        force->setOverlapTolerance(0.1);
        force->setHydrogenBondAllowance(0.3);
        for (bool isDonor : {donorFirst, !donorFirst}) {
            system.addParticle(1);
            force->addParticle(0.5, isDonor ? StericExclusionForce::Donor : StericExclusionForce::Acceptor);
        }
        system.addForce(force);
        TorsionMonteCarloIntegrator integrator(0);
        integrator.setStericMode(TorsionMonteCarloIntegrator::Soft);
        integrator.setRandomNumberSeed(1);
        integrator.setTrialsPerStep(50);
        integrator.addRigidBodyMove(1, 0.002, 0);
        Context context(system, integrator, platform);
        context.setPositions({Vec3(), Vec3(0.75, 0, 0)});
        integrator.step(1);
        ASSERT_EQUAL(50, Statistics(integrator, 0).accepted);
        context.setPositions({Vec3(), Vec3(0.55, 0, 0)});
        integrator.step(1);
        ASSERT(Statistics(integrator, 0).rejectedByEnergy > 10);
    }
}

void testStericEnergyIsLeftOut(Platform& platform)
{
    // A tolerated clash has a large energy in the force group of another force, and yet none of it enters U.

    const double tolerance = getTolerance(platform);
    BeadChain chain(4, 0.7, 0.5);
    chain.force->setForceConstant(1e6);
    CustomExternalForce* nothing = new CustomExternalForce("0");
    nothing->addParticle(0);
    chain.system.addForce(nothing);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(1);
    integrator.addTorsionMove(1, 0.5);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    double energy = context.getState(State::Energy).getPotentialEnergy();
    ASSERT(energy > 100);
    integrator.step(20);
    Statistics statistics(integrator, 0);
    ASSERT(statistics.accepted > 1000 && statistics.clashed > 20);
    ASSERT_EQUAL(0, statistics.rejectedByEnergy);

    // When trials are over, it is back.

    context.setPositions(chain.positions);
    ASSERT_EQUAL_TOL(energy, context.getState(State::Energy).getPotentialEnergy(), tolerance);
}

/**
 * Counts how often positions reach the Context, as a member of a CompoundIntegrator.
 */
class PositionCounter : public Integrator {
public:
    int numChanges = 0;
    void step(int)
    {
    }

protected:
    void initialize(ContextImpl&)
    {
    }
    vector<string> getKernelNames()
    {
        return {};
    }
    void stateChanged(State::DataType changed)
    {
        if (changed == State::Positions)
            numChanges++;
    }
    double computeKineticEnergy()
    {
        return 0;
    }
};

void testUploads(Platform& platform)
{
    // Positions reach the Context once a step, and with foreign Forces that change much once more for each trial
    // without a clash.

    BeadChain chain(6, 0.45);
    chain.system.addForce(new CMMotionRemover());
    chain.system.addForce(new AndersenThermostat(300, 1));
    CustomExternalForce* field = new CustomExternalForce("x");
    field->addParticle(5);
    field->setForceGroup(2);
    chain.system.addForce(field);
    Probe* probe = new Probe();
    probe->energy = [](const vector<Vec3>& positions) {
        return 1000 * sin(1000 * positions[5][0]);
    };
    probe->setForceGroup(1);
    chain.system.addForce(probe);
    TorsionMonteCarloIntegrator* integrator = new TorsionMonteCarloIntegrator(300);
    integrator->addTorsionMove(1, M_PI);
    integrator->setIntegrationForceGroups(1);
    PositionCounter* counter = new PositionCounter();
    CompoundIntegrator compound;
    compound.addIntegrator(integrator);
    compound.addIntegrator(counter);
    Context context(chain.system, compound, platform);
    context.setPositions(chain.positions);
    counter->numChanges = 0;
    compound.step(5);
    ASSERT_EQUAL(5, counter->numChanges);
    integrator->setIntegrationForceGroups(1 << 2);
    counter->numChanges = 0;
    compound.step(5);
    ASSERT_EQUAL(5, counter->numChanges);
    ASSERT(Statistics(*integrator, 0).rejectedByEnergy > 0);
    integrator->setIntegrationForceGroups(3);
    compound.step(5); // outer tests find out
    integrator->resetMoveStatistics();
    counter->numChanges = 0;
    compound.step(5);
    Statistics statistics(*integrator, 0);
    ASSERT(statistics.clashed > 0);
    ASSERT_EQUAL(5 + statistics.accepted + statistics.rejectedByEnergy, counter->numChanges);
}

void testAthermal(Platform& platform)
{
    // A CMMotionRemover has no energy, and neither has what is outside the integration force groups.

    BeadChain chain(6, 0.3);
    chain.system.addForce(new CMMotionRemover());
    CustomExternalForce* trap = new CustomExternalForce("1e6*(x^2+y^2+z^2)");
    for (int i = 0; i < 6; i++)
        trap->addParticle(i);
    trap->setForceGroup(4);
    chain.system.addForce(trap);
    TorsionMonteCarloIntegrator integrator(0);
    integrator.addTorsionMove(1, M_PI);
    integrator.setIntegrationForceGroups(~(1 << 4));
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    integrator.step(5);
    ASSERT_EQUAL(0, Statistics(integrator, 0).rejectedByEnergy);
    ASSERT(Statistics(integrator, 0).accepted > 0);

    // Inside them, at a temperature of 0, the energy can only go down.

    integrator.setIntegrationForceGroups(-1);
    double before = context.getState(State::Energy, false, 1 << 4).getPotentialEnergy();
    for (int i = 0; i < 5; i++) {
        integrator.step(1);
        double after = context.getState(State::Energy, false, 1 << 4).getPotentialEnergy();
        ASSERT(after <= before * (1 + getTolerance(platform)));
        before = after;
    }
    ASSERT(Statistics(integrator, 0).rejectedByEnergy > 0);
}

/**
 * Other forces see each trial as it is accepted, to the last bit, though only what moves is handed to them.
 */
void testPositionsOfTrials(Platform& platform)
{
    for (bool withSites : {false, true}) {
        BeadChain chain(40, 0.3);
        chain.addMolecule(5, 0.3, 1.0, Vec3(0, 0, 3));
        chain.addMolecule(1, 0.3, 1.0, Vec3(0, 0, 5));
        chain.force->setParticleParameters(30, 0);
        if (withSites) {
            chain.system.addParticle(0);
            chain.force->addParticle(0);
            chain.system.setVirtualSite(46, new TwoParticleAverageSite(38, 39, 0.5, 0.5));
            chain.positions.push_back(Vec3());
        }
        Probe* probe = new Probe();
        vector<Vec3> seen;
        probe->energy = [&](const vector<Vec3>& positions) {
            seen = positions;
            return 2 * cos(9 * positions[39][1]); // now and then it refuses a trial
        };
        chain.system.addForce(probe);
        TorsionMonteCarloIntegrator integrator(300);
        integrator.setRandomNumberSeed(1);
        integrator.setTrialsPerStep(1);
        integrator.addTorsionMove(2, 0.3);
        integrator.addTorsionMove(1, 0.3, {}, 3);
        integrator.addRigidBodyMove(1, 0.1, 0.3);
        Context context(chain.system, integrator, platform);
        context.setPositions(chain.positions);
        int numRejected = 0;
        for (int i = 0; i < 300; i++) {
            auto count = [&] {
                long long sum = 0;
                for (int move = 0; move < 3; move++)
                    sum += Statistics(integrator, move).accepted;
                return sum;
            };
            long long before = count();
            integrator.step(1);
            if (count() > before)
                assertSameBits(getPositions(context), seen);
            else
                numRejected++;
            if (i == 100)
                context.setPositions(chain.positions);
            if (i == 200) { // the engine restarts
                chain.force->setParticleParameters(3, 0.29);
                chain.force->updateParametersInContext(context);
            }
        }
        ASSERT(numRejected > 20 && numRejected < 200);
    }
}

/**
 * What counts as energy is settled when the Context is made, whatever becomes of the System.
 */
void testEnergyIsSettled(Platform& platform)
{
    auto sample = [&](const function<void(System&)>& change) {
        BeadChain chain(6, 0.3);
        CustomTorsionForce* potential = new CustomTorsionForce("20*cos(theta)");
        for (int i = 0; i < 3; i++)
            potential->addTorsion(i, i + 1, i + 2, i + 3, {});
        chain.system.addForce(potential);
        TorsionMonteCarloIntegrator integrator(300);
        integrator.setRandomNumberSeed(3);
        integrator.addTorsionMove(1, 1);
        integrator.setIntegrationForceGroups(1);
        Context context(chain.system, integrator, platform);
        context.setPositions(chain.positions);
        change(chain.system);
        integrator.step(5);
        ASSERT(Statistics(integrator, 0).rejectedByEnergy > 100);
        return getPositions(context);
    };
    vector<Vec3> unchanged = sample([](System&) {
    });
    assertSameBits(unchanged, sample([](System& system) {
                       system.getForce(1).setForceGroup(1);
                   }));
    assertSameBits(unchanged, sample([](System& system) {
                       system.removeForce(1);
                   }));
    assertSameBits(unchanged, sample([](System& system) {
                       system.addForce(new CustomExternalForce("x"));
                   }));

    // The reciprocal space of a NonbondedForce has a separate group.

    BeadChain chain(6, 0.1);
    NonbondedForce* nonbonded = new NonbondedForce();
    nonbonded->setNonbondedMethod(NonbondedForce::Ewald);
    nonbonded->setReciprocalSpaceForceGroup(2);
    nonbonded->setCutoffDistance(2);
    for (int i = 0; i < 6; i++)
        nonbonded->addParticle(i % 2 == 0 ? 2 : -2, 0.1, 0);
    chain.system.setDefaultPeriodicBoxVectors(Vec3(9, 0, 0), Vec3(0, 9, 0), Vec3(0, 0, 9));
    chain.system.addForce(nonbonded);
    TorsionMonteCarloIntegrator integrator(30);
    integrator.addTorsionMove(1, 3);
    integrator.setIntegrationForceGroups(1 << 2);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    integrator.step(5); // outer tests find out that it changes much
    ASSERT(Statistics(integrator, 0).rejectedByEnergy > 0);
}

void testBadEnergy(Platform& platform)
{
    // The energy of a lone particle is not a number beyond x = 1.

    System system;
    StericExclusionForce* force = new StericExclusionForce();
    CustomExternalForce* cliff = new CustomExternalForce("sqrt(1-x)+20*(x-1)^2");
    system.addParticle(1);
    force->addParticle(0.1);
    cliff->addParticle(0);
    system.addForce(force);
    system.addForce(cliff);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(1);
    integrator.addRigidBodyMove(1, 0.2, 0);
    Context context(system, integrator, platform);
    context.setPositions({Vec3(0.5, 0, 0)});
    integrator.setTrialsPerStep(10);
    double largest = 0;
    for (int i = 0; i < 2000; i++) {
        integrator.step(1);
        State now = context.getState(State::Positions | State::Energy);
        ASSERT(now.getPositions()[0][0] <= 1);
        ASSERT(now.getPotentialEnergy() >= 0);
        largest = max(largest, now.getPositions()[0][0]);
    }
    ASSERT(largest > 0.9);
    ASSERT(Statistics(integrator, 0).rejectedByEnergy > 1000);
    ASSERT_EQUAL(20000, Statistics(integrator, 0).attempted);
    State state = context.getState(State::Positions);
    context.setPositions({Vec3(2, 0, 0)});
    assertThrows("the energy of the integration force groups is not a number: that of force 1, CustomExternalForce",
                 [&] {
                     integrator.step(1);
                 });
    assertRounded(platform, {Vec3(2, 0, 0)}, getPositions(context));
    ASSERT_EQUAL(0, context.getStepCount() - state.getStepCount());
    context.setPositions({Vec3(-1000, 0, 0)});
    integrator.step(10);
}

void testInfiniteEnergy(Platform& platform)
{
    // A wall of infinite energy: nothing enters it, and what is in it at first may leave. A hole of minus infinity is
    // no place to be.

    System system;
    StericExclusionForce* force = new StericExclusionForce();
    Probe* probe = new Probe();
    const double infinity = numeric_limits<double>::infinity();
    probe->energy = [=](const vector<Vec3>& x) {
        return x[0][0] > 1 ? infinity : x[0][0] < 0 ? -infinity : 0;
    };
    probe->setName("Wall");
    system.addParticle(1);
    force->addParticle(0.1);
    system.addForce(force);
    system.addForce(probe);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addRigidBodyMove(1, 0.2, 0);
    Context context(system, integrator, platform);
    context.setPositions({Vec3(1.3, 0, 0)});
    while (getPositions(context)[0][0] > 1)
        integrator.step(1);
    for (int i = 0; i < 100; i++) {
        integrator.step(1);
        double x = getPositions(context)[0][0];
        ASSERT(x <= 1 && x >= 0);
    }
    for (int trialsPerOuterTest : {0, 5}) {
        integrator.setTrialsPerOuterTest(trialsPerOuterTest);
        context.setPositions({Vec3(-1, 0, 0)});
        assertThrows("the energy of the integration force groups is not a number: that of force 1, Wall", [&] {
            integrator.step(1);
        });
    }
}

/**
 * If another force throws, the trials before that stay, and sampling can continue.
 */
void testThrowingForce(Platform& platform)
{
    BeadChain chain(8, 0.3);
    Probe* probe = new Probe();
    int numEvaluations = 0, failing = -1;
    vector<Vec3> accepted;
    probe->energy = [&](const vector<Vec3>& positions) {
        if (numEvaluations++ == failing)
            throw OpenMMException("out of order");
        accepted = positions;
        return 0.0;
    };
    chain.system.addForce(probe);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(1);
    integrator.addTorsionMove(1, 0.3);
    integrator.setNativeEnergies(false); // one evaluation for each trial
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    integrator.step(1);
    for (int trial : {30, 0}) { // in the midst of trials, and before the first
        integrator.resetMoveStatistics();
        vector<Vec3> before = getPositions(context);
        numEvaluations = 0;
        failing = trial;
        assertThrows("out of order", [&] {
            integrator.step(1);
        });
        failing = -1;
        ASSERT_EQUAL(1, context.getStepCount());
        ASSERT_EQUAL(max(0, trial - 1), Statistics(integrator, 0).accepted);
        assertSameBits(trial == 0 ? before : accepted, getPositions(context));
        assertThrows("there is no open proposal", [&] {
            chain.force->acceptProposal(context);
        });
    }
    integrator.step(1);
    ASSERT_EQUAL(2, context.getStepCount());
    ASSERT(!chain.force->hasClash(context));
}

void testSamplingEnergies(Platform& platform)
{
    testSoftEnergy(platform);
    testSoftHydrogenBonds(platform);
    testStericEnergyIsLeftOut(platform);
    testUploads(platform);
    testAthermal(platform);
    testPositionsOfTrials(platform);
    testEnergyIsSettled(platform);
    testBadEnergy(platform);
    testInfiniteEnergy(platform);
    testThrowingForce(platform);
}
