/**
 * This tests, on one platform, sampling in a Context that others change too: the user, other integrators and forces,
 * and other Contexts, also in other threads.
 */

#include "openmm/CompoundIntegrator.h"
#include "openmm/CustomExternalForce.h"
#include "openmm/CustomIntegrator.h"
#include "openmm/CustomTorsionForce.h"
#include "openmm/Force.h"
#include "openmm/internal/ContextImpl.h"
#include "openmm/internal/ForceImpl.h"
#include "openmm/kernels.h"
#include "openmm/LangevinMiddleIntegrator.h"
#include "openmm/LocalEnergyMinimizer.h"
#include "openmm/serialization/XmlSerializer.h"
#include "openmm/VerletIntegrator.h"
#include "openmm/VirtualSite.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "TestSupport.h"
#include <cstdio>
#include <map>
#include <memory>
#include <thread>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

typedef map<pair<int, int>, double> Limits;

/**
 * Get the limits that a State keeps.
 */
Limits getLimits(const Context& context)
{
    State state = context.getState(State::IntegratorParameters);
    stringstream stream;
    XmlSerializer::serialize<State>(&state, "State", stream);
    Limits limits;
    for (string line; getline(stream, line);) {
        int p1, p2;
        double overlap;
        if (sscanf(line.c_str(), " <Limit overlap=\"%lf\" p1=\"%d\" p2=\"%d\"", &overlap, &p1, &p2) == 3)
            limits[make_pair(p1, p2)] = overlap;
    }
    return limits;
}

/**
 * Check that no pair overlaps beyond its limit.
 */
void assertWithinLimits(const StericExclusionForce& force, Context& context)
{
    const double rounding = getTolerance(context.getPlatform());
    vector<pair<int, int>> pairs;
    vector<double> overlaps;
    Limits limits = getLimits(context);
    force.getClashes(context, pairs, overlaps);
    for (size_t i = 0; i < pairs.size(); i++) {
        ASSERT(limits.count(pairs[i]) == 1);
        ASSERT(overlaps[i] <= limits[pairs[i]] + rounding);
    }
}

/**
 * Get all bond lengths of a chain.
 */
vector<double> getBondLengths(const vector<Vec3>& positions, int length)
{
    vector<double> lengths;
    for (int i = 1; i < length; i++)
        lengths.push_back(getDistance(positions[i - 1], positions[i]));
    return lengths;
}

void addMoves(TorsionMonteCarloIntegrator& integrator, int seed)
{
    integrator.setRandomNumberSeed(seed);
    integrator.addTorsionMove(2, 0.4);
    integrator.addRigidBodyMove(1, 0.2, 0.4);
}

// ---- The user ----

/**
 * Whatever positions the user sets, sampling continues from just these, with their bond lengths and bond angles.
 */
void testUserEdits(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    const int length = 8;
    BeadChain chain(length, 0.45, 2.0);
    TorsionMonteCarloIntegrator integrator(300);
    addMoves(integrator, 1);
    Context context(chain.system, integrator, platform);
    vector<Vec3> x = chain.positions;
    for (int edit = 0; edit < 6; edit++) {
        for (int i = 0; i < length; i++)
            x[i] += Vec3(0.01 * sin(i + edit), 0.02 * sin(3.0 * i), 0.01 * i * edit);
        context.setPositions(x);
        integrator.step(2);
        x = getPositions(context);
        vector<double> lengths = getBondLengths(x, length);

        // Restarted alike, a Context that has never seen the earlier positions goes the same way.

        TorsionMonteCarloIntegrator otherIntegrator(300);
        addMoves(otherIntegrator, 7);
        Context other(chain.system, otherIntegrator, platform);
        other.setPositions(x);
        otherIntegrator.step(3);
        vector<double> otherLengths = getBondLengths(getPositions(other), length);
        for (int i = 0; i < length - 1; i++)
            ASSERT_EQUAL_TOL(lengths[i], otherLengths[i], tolerance);
        assertWithinLimits(*chain.force, context);
        assertWithinLimits(*chain.force, other);
    }

    // The smallest edit of one coordinate is kept as it is until something moves.

    x = getPositions(context);
    x[0][1] = nextafter(x[0][1], 10);
    context.setPositions(x);
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));
    integrator.resetMoveStatistics();
    integrator.setTrialsPerStep(1);
    for (long long moved = 0; moved == 0;) {
        assertRounded(platform, {x[0]}, {getPositions(context)[0]});
        integrator.step(1);
        for (int move = 0; move < 2; move++) {
            long long attempted, clashed, rejected, accepted;
            integrator.getMoveStatistics(move, attempted, clashed, rejected, accepted);
            moved += accepted;
        }
    }

    // The box is no business of ours.

    vector<Vec3> before = getPositions(context);
    context.setPeriodicBoxVectors(Vec3(3, 0, 0), Vec3(0, 4, 0), Vec3(0, 0, 5));
    ASSERT(chain.force->proposeTorsions(context, {0}, {0}));
    chain.force->acceptProposal(context);
    assertSameBits(before, getPositions(context));
}

void testVirtualSites(Platform& platform)
{
    // Positions that the user sets for a virtual site are ignored, even if they would clash.

    const double tolerance = getTolerance(platform);
    BeadChain chain(8, 0.3);
    chain.system.addParticle(0);
    chain.force->addParticle(0.2);
    chain.system.setVirtualSite(8, new TwoParticleAverageSite(6, 7, 0.5, 0.5));
    for (int i : {4, 5, 6, 7})
        chain.force->addExclusion(i, 8);
    chain.positions.push_back(chain.positions[0]);
    TorsionMonteCarloIntegrator integrator(300);
    addMoves(integrator, 1);
    Context context(chain.system, integrator, platform);
    for (int i = 0; i < 3; i++) {
        context.setPositions(chain.positions);
        integrator.step(1);
        ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));
        vector<Vec3> x = getPositions(context);
        ASSERT_EQUAL_VEC((x[6] + x[7]) * 0.5, x[8], tolerance);
        ASSERT(!chain.force->hasClash(context));
    }
}

/**
 * Parameters that change between steps count from the next step on: torsions follow a potential that is turned over.
 */
void testOtherParameters(Platform& platform)
{
    BeadChain chain(5, 0.1);
    CustomTorsionForce* potential = new CustomTorsionForce("k*s*cos(theta)");
    potential->addGlobalParameter("k", 200);
    potential->addPerTorsionParameter("s");
    potential->addTorsion(0, 1, 2, 3, {1.0});
    potential->addTorsion(1, 2, 3, 4, {1.0});
    chain.system.addForce(potential);
    TorsionMonteCarloIntegrator integrator(300);
    addMoves(integrator, 1);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    auto assertCosine = [&](int torsion, double expected) {
        integrator.step(50);
        vector<double> angles;
        integrator.getTorsionAngles(context, angles);
        ASSERT_EQUAL_TOL(expected, cos(angles[torsion]), 0.06);
    };
    assertCosine(0, -1);
    context.setParameter("k", -200);
    assertCosine(0, 1);
    assertCosine(1, 1);
    potential->setTorsionParameters(0, 0, 1, 2, 3, {-1.0});
    potential->updateParametersInContext(context);
    assertCosine(0, -1);
    assertCosine(1, 1);
    integrator.setIntegrationForceGroups(2);
    double sum = 0;
    vector<double> angles;
    for (int i = 0; i < 200; i++) {
        integrator.step(1);
        integrator.getTorsionAngles(context, angles);
        sum += cos(angles[1]) / 200;
    }
    ASSERT(fabs(sum) < 0.5);
}

/**
 * Spheres that have grown between steps get limits where they now clash, and lose none.
 */
void testOwnParameters(Platform& platform)
{
    BeadChain chain(8, 0.45, 1.3);
    TorsionMonteCarloIntegrator integrator(300);
    addMoves(integrator, 1);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    integrator.step(1);
    vector<Vec3> x = getPositions(context);
    Limits limits = getLimits(context);
    for (double radius : {0.6, 0.8, 0.7}) {
        for (int i = 0; i < 8; i++)
            chain.force->setParticleParameters(i, radius);
        chain.force->updateParametersInContext(context);
        assertSameBits(x, getPositions(context));
        integrator.step(2);
        assertWithinLimits(*chain.force, context);
        Limits now = getLimits(context);
        for (auto& limit : limits)
            ASSERT(now.count(limit.first) == 1 && now[limit.first] >= limit.second);
        limits = now;
        x = getPositions(context);
    }
    ASSERT(limits.size() > 1);
}

// ---- Other integrators and forces ----

/**
 * Turns of dynamics and Monte Carlo. The limit of no pair ever falls, and no pair ever goes beyond it in Monte Carlo,
 * which also keeps the bonds that dynamics has left.
 */
void testTurns(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    const int length = 10;
    BeadChain chain(length, 0.6, 1.2);
    chain.force->setForceConstant(50);
    CustomExternalForce* well = new CustomExternalForce("20*(x^2+y^2+z^2)");
    for (int i = 0; i < length; i++)
        well->addParticle(i);
    well->setForceGroup(1);
    chain.system.addForce(well);
    CompoundIntegrator compound;
    TorsionMonteCarloIntegrator* sampler = new TorsionMonteCarloIntegrator(300);
    addMoves(*sampler, 1);
    sampler->setIntegrationForceGroups(1);
    LangevinMiddleIntegrator* dynamics = new LangevinMiddleIntegrator(300, 1, 0.005);
    dynamics->setRandomNumberSeed(1);
    compound.addIntegrator(sampler);
    compound.addIntegrator(dynamics);
    Context context(chain.system, compound, platform);
    context.setPositions(chain.positions);
    context.setVelocitiesToTemperature(300, 1);
    Limits limits;
    size_t atFirst = 0;
    for (int turn = 0; turn < 15; turn++) {
        compound.setCurrentIntegrator(1);
        compound.step(10);
        vector<double> lengths = getBondLengths(getPositions(context), length);
        compound.setCurrentIntegrator(0);
        compound.step(2);
        vector<double> lengthsAfter = getBondLengths(getPositions(context), length);
        for (int i = 0; i < length - 1; i++)
            ASSERT_EQUAL_TOL(lengths[i], lengthsAfter[i], tolerance);
        assertWithinLimits(*chain.force, context);
        Limits now = getLimits(context);
        for (auto& limit : limits)
            ASSERT(now.count(limit.first) == 1 && now[limit.first] >= limit.second);
        limits = now;
        ASSERT_EQUAL(limits.size(), sampler->getNumToleratedClashes(context));
        if (turn == 0)
            atFirst = limits.size();
    }
    ASSERT(limits.size() > atFirst);
    ASSERT_EQUAL(15 * 12, context.getStepCount());
}

/**
 * Two samplers that take turns share limits, also over a checkpoint.
 */
void testTwoSamplers(Platform& platform)
{
    BeadChain chain(10, 0.6, 0.4);
    auto makeIntegrator = [] {
        unique_ptr<CompoundIntegrator> compound(new CompoundIntegrator());
        for (int seed : {1, 2}) {
            TorsionMonteCarloIntegrator* sampler = new TorsionMonteCarloIntegrator(300);
            addMoves(*sampler, seed);
            compound->addIntegrator(sampler);
        }
        return compound;
    };
    auto takeTurns = [](CompoundIntegrator& integrator) {
        for (int i = 0; i < 4; i++) {
            integrator.setCurrentIntegrator(i % 2);
            integrator.step(1);
        }
    };
    auto compound = makeIntegrator(), otherCompound = makeIntegrator();
    Context context(chain.system, *compound, platform), other(chain.system, *otherCompound, platform);
    context.setPositions(chain.positions);
    takeTurns(*compound);
    Limits limits = getLimits(context);
    ASSERT(!limits.empty());
    assertWithinLimits(*chain.force, context);
    stringstream checkpoint;
    context.createCheckpoint(checkpoint);
    other.loadCheckpoint(checkpoint);
    ASSERT(limits == getLimits(other));
    takeTurns(*compound);
    takeTurns(*otherCompound);
    ASSERT(limits == getLimits(context));
    ASSERT(limits == getLimits(other));
    assertSameBits(getPositions(context), getPositions(other));
}

/**
 * A force that silently moves particles before a step, as a barostat does.
 */
class Mover : public Force {
public:
    bool usesPeriodicBoundaryConditions() const
    {
        return false;
    }
    /**
     * Move the last particle between two steps.
     */
    void move(Context& context, const Vec3& shift);
    /** How far the last particle moves before each step. */
    Vec3 shift;

protected:
    ForceImpl* createImpl() const;
};

class MoverImpl : public ForceImpl {
public:
    explicit MoverImpl(const Mover& owner) : owner(owner)
    {
    }
    void initialize(ContextImpl& context)
    {
        kernel = context.getPlatform().createKernel(UpdateStateDataKernel::Name(), context);
        kernel.getAs<UpdateStateDataKernel>().initialize(context.getSystem());
    }
    const Mover& getOwner() const
    {
        return owner;
    }
    void move(ContextImpl& context, const Vec3& shift)
    {
        vector<Vec3> positions;
        context.getPositions(positions);
        positions.back() += shift;
        kernel.getAs<UpdateStateDataKernel>().setPositions(context, positions);
    }
    void updateContextState(ContextImpl& context, bool& forcesInvalid)
    {
        if (owner.shift == Vec3())
            return;
        move(context, owner.shift);
        forcesInvalid = true;
    }
    double calcForcesAndEnergy(ContextImpl&, bool, bool, int)
    {
        return 0;
    }
    map<string, double> getDefaultParameters()
    {
        return {};
    }
    vector<string> getKernelNames()
    {
        return {UpdateStateDataKernel::Name()};
    }

private:
    const Mover& owner;
    Kernel kernel;
};

ForceImpl* Mover::createImpl() const
{
    return new MoverImpl(*this);
}

void Mover::move(Context& context, const Vec3& shift)
{
    dynamic_cast<MoverImpl&>(getImplInContext(context)).move(getContextImpl(context), shift);
}

void testSilentMoves(Platform& platform)
{
    // A lone sphere is pushed towards a chain until they clash, and then held there.

    const double tolerance = getTolerance(platform);
    BeadChain chain(6, 0.45);
    int last = chain.addMolecule(1, 0.45, 0, chain.positions[3] + Vec3(0, 0, 2) - Vec3(0, 1, 0));
    chain.system.setParticleMass(0, 0);
    chain.system.setParticleMass(last, 0);
    Mover* mover = new Mover();
    chain.system.addForce(mover);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(1);
    integrator.setTrialsPerStep(1);
    integrator.addTorsionMove(1, 0);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    mover->shift = Vec3(0, 0, -0.2);
    Limits limits;
    for (int i = 1; i <= 8; i++) {
        integrator.step(1);
        double z = getPositions(context)[last][2];
        ASSERT_EQUAL_TOL(2 - 0.2 * i, z, tolerance);
        assertWithinLimits(*chain.force, context);
        Limits now = getLimits(context);
        for (auto& limit : limits)
            ASSERT(now.count(limit.first) == 1 && now[limit.first] >= limit.second);
        limits = now;
        ASSERT_EQUAL(z > 0.9, limits.empty());
    }
    ASSERT(!limits.empty());

    // On the way back limits stay.

    mover->shift = Vec3(0, 0, 0.5);
    integrator.step(4);
    ASSERT(!chain.force->hasClash(context));
    ASSERT(limits == getLimits(context));
}

/**
 * What has moved in no step counts as set by the user, though nobody tells. On GPU platforms the minimizer moves
 * particles in this way.
 */
void testMovesBetweenSteps(Platform& platform)
{
    // A lone sphere clashes with the middle of a chain, and leaves it.

    BeadChain chain(6, 0.45);
    int last = chain.addMolecule(1, 0.45, 0, chain.positions[3] + Vec3(0, 0, 0.7) - Vec3(0, 1, 0));
    chain.force->setForceConstant(10);
    Mover* mover = new Mover();
    chain.system.addForce(mover);
    CompoundIntegrator compound;
    TorsionMonteCarloIntegrator* sampler = new TorsionMonteCarloIntegrator(300);
    sampler->addTorsionMove(1, 0);
    CustomIntegrator* dynamics = new CustomIntegrator(0.001);
    dynamics->addUpdateContextState();
    for (int i = 0; i < 3; i++) { // Forces are computed in the midst of a step too.
        dynamics->addComputePerDof("v", "v+f/m*dt/3");
        dynamics->addComputePerDof("x", "x+v*dt/3");
    }
    compound.addIntegrator(sampler);
    compound.addIntegrator(dynamics);
    Context context(chain.system, compound, platform);
    Limits limits;
    auto start = [&] {
        context.setPositions(chain.positions);
        vector<Vec3> velocities(last + 1);
        velocities[last] = Vec3(0, 0, 10);
        context.setVelocities(velocities);
        compound.step(1);
        limits = getLimits(context);
        ASSERT_EQUAL(1, limits.size());
    };
    auto runDynamics = [&] {
        compound.setCurrentIntegrator(1);
        compound.step(30);
        compound.setCurrentIntegrator(0);
        ASSERT(getPositions(context)[last][2] > 0.9);
    };
    auto evaluate = [&] {
        context.getState(State::Energy);
    };
    const Vec3 away(0, 0, 1);

    start();
    mover->move(context, away);
    compound.step(1);
    ASSERT_EQUAL(0, getLimits(context).size());

    // It is noticed early enough in evaluations of forces, also if dynamics follows or went before.

    start();
    mover->move(context, away);
    evaluate();
    runDynamics();
    compound.step(1);
    ASSERT_EQUAL(0, getLimits(context).size());
    start();
    runDynamics();
    evaluate();
    mover->move(context, away);
    evaluate();
    compound.step(1);
    ASSERT_EQUAL(0, getLimits(context).size());

    // And back again.

    start();
    mover->move(context, away);
    evaluate();
    mover->move(context, away * -1);
    evaluate();
    mover->move(context, away);
    compound.step(1);
    ASSERT_EQUAL(0, getLimits(context).size());

    // Dynamics alone does not do that.

    start();
    runDynamics();
    evaluate();
    compound.step(1);
    ASSERT(limits == getLimits(context));

    // A step that was refused does not hide it.

    sampler->setInitialClashPolicy(TorsionMonteCarloIntegrator::Refuse);
    context.setPositions(chain.positions);
    assertThrows("clash when sampling starts", [&] {
        compound.step(1);
    });
    mover->move(context, away);
    compound.step(1);
    sampler->setInitialClashPolicy(TorsionMonteCarloIntegrator::Tolerate);

    // A checkpoint knows when the sampler saw the positions for the last time.

    start();
    mover->move(context, away);
    stringstream moved, stepped;
    context.createCheckpoint(moved);
    start();
    runDynamics();
    context.createCheckpoint(stepped);
    context.loadCheckpoint(moved);
    compound.step(1);
    ASSERT_EQUAL(0, getLimits(context).size());
    context.loadCheckpoint(stepped);
    compound.step(1);
    ASSERT(limits == getLimits(context));
}

/**
 * It is known who moved positions, whatever becomes of the step count.
 */
void testStepCounts(Platform& platform)
{
    for (bool announced : {true, false}) {
        BeadChain chain(6, 0.45);
        int last = chain.addMolecule(1, 0.45, 0, chain.positions[3] + Vec3(0, 0, 0.7) - Vec3(0, 1, 0));
        chain.force->setForceConstant(0);
        CompoundIntegrator compound;
        TorsionMonteCarloIntegrator* sampler = new TorsionMonteCarloIntegrator(300);
        sampler->addTorsionMove(1, 0);
        CustomIntegrator* dynamics = new CustomIntegrator(0.1);
        if (announced)
            dynamics->addUpdateContextState();
        dynamics->addComputePerDof("x", "x+v*dt");
        compound.addIntegrator(sampler);
        compound.addIntegrator(dynamics);
        Context context(chain.system, compound, platform);
        context.setPositions(chain.positions);
        vector<Vec3> velocities(last + 1);
        velocities[last] = Vec3(0, 0, 10);
        context.setVelocities(velocities);
        compound.step(5);
        const Limits limits = getLimits(context);
        ASSERT_EQUAL(1, limits.size());
        for (long long count : {0, 3, 4, 5, 100}) {
            context.setStepCount(count);
            compound.setCurrentIntegrator(1);
            compound.step(2);
            context.setStepCount(5);
            compound.setCurrentIntegrator(0);
            ASSERT_EQUAL(1, sampler->getNumToleratedClashes(context));
            compound.step(1);
            ASSERT(limits == getLimits(context));
        }

        // The user may say so all the same.

        chain.force->restartLimits(context);
        ASSERT_EQUAL(0, sampler->getNumToleratedClashes(context));
        compound.step(1);
        ASSERT_EQUAL(0, getLimits(context).size());
    }
}

/**
 * The minimizer counts as a user who sets positions: limits start at its result.
 */
void testMinimizationInBetween(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    BeadChain chain(10, 0.6, 0.4);
    TorsionMonteCarloIntegrator integrator(300);
    addMoves(integrator, 1);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    integrator.step(2);
    size_t before = getLimits(context).size();
    ASSERT(before > 0);
    LocalEnergyMinimizer::minimize(context, 1, 100);
    vector<Vec3> minimized = getPositions(context);
    vector<pair<int, int>> pairs;
    vector<double> overlaps;
    chain.force->getClashes(context, pairs, overlaps);
    integrator.step(2);
    ASSERT_EQUAL(pairs.size(), getLimits(context).size());
    ASSERT(pairs.size() < before);
    assertWithinLimits(*chain.force, context);
    vector<double> lengths = getBondLengths(minimized, 10), lengthsAfter = getBondLengths(getPositions(context), 10);
    for (int i = 0; i < 9; i++)
        ASSERT_EQUAL_TOL(lengths[i], lengthsAfter[i], tolerance);
}

// ---- Other Contexts ----

/**
 * A different run for each seed, in a System that may be shared.
 */
vector<Vec3> sample(System& system, const vector<Vec3>& positions, int seed, Platform& platform)
{
    TorsionMonteCarloIntegrator integrator(300);
    addMoves(integrator, seed);
    Context context(system, integrator, platform);
    context.setPositions(positions);
    for (int i = 0; i < 5; i++)
        integrator.step(2);
    return getPositions(context);
}

void testContextsInTurns(Platform& platform)
{
    // Of two Contexts that share everything, each goes the way that it goes alone.

    BeadChain chain(40, 0.45, 0.9);
    vector<Vec3> straight = BeadChain(40, 0.45).positions;
    TorsionMonteCarloIntegrator integrator1(300), integrator2(300);
    addMoves(integrator1, 1);
    addMoves(integrator2, 2);
    Context context1(chain.system, integrator1, platform), context2(chain.system, integrator2, platform);
    context1.setPositions(chain.positions);
    context2.setPositions(straight);
    for (int i = 0; i < 5; i++) {
        integrator1.step(2);
        integrator2.step(2);
    }
    assertSameBits(sample(chain.system, chain.positions, 1, platform), getPositions(context1));
    assertSameBits(sample(chain.system, straight, 2, platform), getPositions(context2));
}

void testThreads(Platform& platform)
{
    const int numThreads = 4;
    BeadChain chain(40, 0.45, 0.9);
    vector<vector<Vec3>> alone(numThreads), together(numThreads);
    for (int i = 0; i < numThreads; i++)
        alone[i] = sample(chain.system, chain.positions, i + 1, platform);
    vector<thread> threads;
    for (int i = 0; i < numThreads; i++)
        threads.push_back(thread([&, i] {
            together[i] = sample(chain.system, chain.positions, i + 1, platform);
        }));
    for (thread& t : threads)
        t.join();
    for (int i = 0; i < numThreads; i++)
        assertSameBits(alone[i], together[i]);
    ASSERT(getDistance(alone[0][39], alone[1][39]) > 1e-3);
}

void testPositionChanges(Platform& platform)
{
    testUserEdits(platform);
    testVirtualSites(platform);
    testOtherParameters(platform);
    testOwnParameters(platform);
    testTurns(platform);
    testTwoSamplers(platform);
    testSilentMoves(platform);
    testMovesBetweenSteps(platform);
    testStepCounts(platform);
    if (canMinimize(platform))
        testMinimizationInBetween(platform);
    testContextsInTurns(platform);
    testThreads(platform);
}
