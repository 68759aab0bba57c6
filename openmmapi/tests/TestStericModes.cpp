/**
 * This tests what becomes of the spheres where a force field takes their place: the mode that Automatic means, the
 * energy of the force, early rejection, and queries and trials of users in between.
 */

#include "openmm/CompoundIntegrator.h"
#include "openmm/CustomNonbondedForce.h"
#include "openmm/HarmonicBondForce.h"
#include "openmm/NonbondedForce.h"
#include "openmm/VerletIntegrator.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "SamplingSupport.h"
#include <memory>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

typedef TorsionMonteCarloIntegrator Sampler;

static const int LENGTH = 12;

static const double RADIUS = 1.2;

/**
 * A chain of beads with large spheres and Lennard-Jones cores that are much smaller.
 */
class CoreChain : public BeadChain {
public:
    CoreChain() : BeadChain(LENGTH, RADIUS, 2.5), pairs(new NonbondedForce())
    {
        force->setForceGroup(3);
        for (int i = 0; i < LENGTH; i++) {
            pairs->addParticle(0, 0.8, 3);
            for (int j = max(0, i - 2); j < i; j++)
                pairs->addException(j, i, 0, 1, 0);
        }
        system.addForce(pairs);
    }
    NonbondedForce* pairs;
};

static void setUp(Sampler& integrator, int seed = 1)
{
    integrator.setRandomNumberSeed(seed);
    integrator.addTorsionMove(1, 0.5);
    integrator.addTorsionMove(1, M_PI);
    integrator.setTrialsPerStep(50);
}

/**
 * A chain that is sampled from its start.
 */
class CoreRun {
public:
    CoreRun(Platform& platform, CoreChain& chain, int seed = 1) : integrator(300)
    {
        setUp(integrator, seed);
        context = make_unique<Context>(chain.system, integrator, platform);
        context->setPositions(chain.positions);
    }
    Sampler integrator;
    unique_ptr<Context> context;
};

static string describeSteric(Sampler& integrator, Context& context)
{
    return integrator.getEnergyPlan(context)[0].reason;
}

// ---- Which mode ----

static void checkMode(Platform& platform, System& system, int groups, Sampler::StericMode expected,
                      const string& reason)
{
    Sampler integrator(300);
    ASSERT_EQUAL(Sampler::Automatic, integrator.getStericMode());
    integrator.setIntegrationForceGroups(groups);
    integrator.addTorsionMove(1, 0.5);
    Context context(system, integrator, platform);
    ASSERT_EQUAL(expected, integrator.getStericModeInContext(context));
    ASSERT_EQUAL(expected == Sampler::Off, integrator.hasSpheresOff());
    ASSERT_EQUAL(Sampler::NotSampled, integrator.getEnergyPlan(context)[0].kind);
    ASSERT_EQUAL(reason, describeSteric(integrator, context));
    for (Sampler::StericMode mode : {Sampler::Hard, Sampler::Soft, Sampler::Off}) {
        integrator.setStericMode(mode);
        ASSERT_EQUAL(mode, integrator.getStericModeInContext(context));
    }
}

static void testAutomatic(Platform& platform)
{
    const string none = "no sampled Force has an energy of pairs of all its particles, so its spheres are hard";
    CoreChain chain;
    checkMode(platform, chain.system, -1, Sampler::Off,
              "its spheres have no effect: force 1, NonbondedForce, has an energy of all pairs");
    checkMode(platform, chain.system, ~1, Sampler::Hard, none);
    BeadChain bare(LENGTH, 0.2);
    HarmonicBondForce* bond = new HarmonicBondForce();
    bond->addBond(0, 5, 1, 1);
    bare.system.addForce(bond);
    checkMode(platform, bare.system, -1, Sampler::Hard, none);

    // A CustomNonbondedForce may hold some particles alone. Those without a radius are none of the force's.

    CustomNonbondedForce* custom = new CustomNonbondedForce("1/r");
    for (int i = 0; i < LENGTH; i++)
        custom->addParticle();
    set<int> most;
    for (int i = 1; i < LENGTH; i++)
        most.insert(i);
    const int group = custom->addInteractionGroup(most, {3});
    bare.system.addForce(custom);
    checkMode(platform, bare.system, -1, Sampler::Hard, none);
    bare.force->setParticleParameters(0, 0, StericExclusionForce::NoHydrogenBond);
    checkMode(platform, bare.system, -1, Sampler::Off,
              "its spheres have no effect: force 2, CustomNonbondedForce, has an energy of all pairs");
    bare.force->setParticleParameters(0, 0.2, StericExclusionForce::NoHydrogenBond);
    custom->setInteractionGroupParameters(group, most, {0});
    checkMode(platform, bare.system, -1, Sampler::Off,
              "its spheres have no effect: force 2, CustomNonbondedForce, has an energy of all pairs");
}

// ---- The force's energy ----

static double computeStericEnergy(Context& context)
{
    State state = context.getState(State::Energy | State::Forces, false, 1 << 3);
    double largest = 0;
    for (const Vec3& force : state.getForces())
        largest = max(largest, sqrt(force.dot(force)));
    ASSERT_EQUAL(state.getPotentialEnergy() == 0, largest == 0);
    return state.getPotentialEnergy();
}

static void testEnergyIsZero(Platform& platform)
{
    CoreChain chain;
    Sampler* sampler = new Sampler(300);
    setUp(*sampler);
    CompoundIntegrator integrator;
    integrator.addIntegrator(new VerletIntegrator(1e-6));
    integrator.addIntegrator(sampler);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    ASSERT_EQUAL(0, computeStericEnergy(context));
    const double soft = [&] {
        sampler->setStericMode(Sampler::Soft);
        return computeStericEnergy(context);
    }();
    ASSERT(soft > 1000);
    sampler->setStericMode(Sampler::Off);
    ASSERT_EQUAL(0, computeStericEnergy(context));
    integrator.step(1);
    integrator.setCurrentIntegrator(1);
    integrator.step(1);
    ASSERT_EQUAL(0, computeStericEnergy(context));
    sampler->setStericMode(Sampler::Hard);
    ASSERT(computeStericEnergy(context) > 0);

    // Automatic follows the force groups that are sampled.

    sampler->setStericMode(Sampler::Automatic);
    ASSERT_EQUAL(0, computeStericEnergy(context));
    sampler->setIntegrationForceGroups(~1);
    ASSERT(computeStericEnergy(context) > 0);
}

static void testModesThatContradict(Platform& platform)
{
    CoreChain chain;
    Sampler *soft = new Sampler(300), *off = new Sampler(300);
    setUp(*soft);
    setUp(*off);
    soft->setStericMode(Sampler::Soft);
    CompoundIntegrator integrator;
    integrator.addIntegrator(soft);
    integrator.addIntegrator(off);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    assertThrows("its steric mode is Soft, but that of another integrator of the Context is Off", [&] {
        integrator.step(1);
    });
    integrator.setCurrentIntegrator(1);
    integrator.step(1);

    // Hard beside Off makes trials of different spheres, in turns.

    soft->setStericMode(Sampler::Hard);
    for (int i = 0; i < 7; i++) {
        integrator.setCurrentIntegrator(i % 2);
        integrator.step(1);
    }
    ASSERT(chain.force->getNumToleratedClashes(context) > 0);
}

// ---- Early rejection ----

static long long countClashed(const Sampler& integrator)
{
    return Statistics(integrator, 0).clashed + Statistics(integrator, 1).clashed;
}

static double getLeastDistance(const vector<Vec3>& positions)
{
    double least = INFINITY;
    for (int i = 0; i < (int)positions.size(); i++)
        for (int j = 0; j < i - 2; j++)
            least = min(least, sqrt((positions[i] - positions[j]).dot(positions[i] - positions[j])));
    return least;
}

static void testEarlyRefusal(Platform& platform)
{
    // Spheres of 2.4 nm would overlap everywhere; cores of 0.6 nm let the chain fold, and are never entered.

    CoreChain chain;
    CoreRun run(platform, chain);
    Sampler& integrator = run.integrator;
    Context& context = *run.context;
    double least = INFINITY;
    for (int i = 0; i < 200; i++) {
        integrator.step(1);
        least = min(least, getLeastDistance(getPositions(context)));
    }
    ASSERT(countClashed(integrator) > 100 && least > 0.55 && least < 0.85);
    ASSERT_EQUAL(0, chain.force->getNumToleratedClashes(context));

    // Another energy of pairs might make good what Lennard-Jones forbids, so nothing is refused early.

    CustomNonbondedForce* custom = new CustomNonbondedForce("-0.1/r");
    for (int i = 0; i < LENGTH; i++)
        custom->addParticle();
    for (int i = 0; i < chain.pairs->getNumExceptions(); i++) {
        int p1, p2;
        double charge, sigma, epsilon;
        chain.pairs->getExceptionParameters(i, p1, p2, charge, sigma, epsilon);
        custom->addExclusion(p1, p2);
    }
    chain.system.addForce(custom);
    CoreRun other(platform, chain);
    other.integrator.step(20);
    ASSERT_EQUAL(0, countClashed(other.integrator));

    // Nor by spheres of the force that are free at the start.

    for (int i = 0; i < LENGTH; i++)
        chain.force->setParticleParameters(i, 0.45);
    CoreRun free(platform, chain);
    ASSERT(!chain.force->hasClash(*free.context));
    free.integrator.step(20);
    ASSERT_EQUAL(0, countClashed(free.integrator));
    ASSERT(chain.force->hasClash(*free.context));
}

static void testStartWithinCores(Platform& platform)
{
    // A chain that starts within cores finds out of them by its energy.

    CoreChain chain;
    CoreRun run(platform, chain);
    Sampler& integrator = run.integrator;
    Context& context = *run.context;
    vector<double> angles(LENGTH - 3, 0.02);
    integrator.setTorsionAngles(context, angles);
    ASSERT(getLeastDistance(getPositions(context)) < 0.5);
    const double before = integrator.getPotentialEnergy(context);
    integrator.step(1);
    ASSERT_EQUAL(0, countClashed(integrator));
    integrator.step(50);
    ASSERT(integrator.getPotentialEnergy(context) < before && getLeastDistance(getPositions(context)) > 0.55);
    ASSERT(countClashed(integrator) > 0);
}

static void testOtherParameters(Platform& platform)
{
    // Cores follow the parameters of the NonbondedForce, and the temperature where it is high.

    CoreChain chain;
    CoreRun run(platform, chain);
    Sampler& integrator = run.integrator;
    Context& context = *run.context;
    integrator.step(5);
    const long long before = countClashed(integrator);
    ASSERT(before > 0);
    for (int i = 0; i < LENGTH; i++)
        chain.pairs->setParticleParameters(i, 0, 0.8, 0);
    chain.pairs->updateParametersInContext(context);
    integrator.step(5);
    ASSERT_EQUAL(before, countClashed(integrator));
    for (int i = 0; i < LENGTH; i++)
        chain.pairs->setParticleParameters(i, 0, 0.8, 3);
    chain.pairs->updateParametersInContext(context);
    integrator.setTemperature(1e6);
    integrator.step(5);
    ASSERT(countClashed(integrator) >= before);
}

// ---- Users' queries and trials ----

/**
 * Queries and trials of users are by the radii of the force, and leave the trajectory as it is.
 */
static void testQueriesInBetween(Platform& platform)
{
    CoreChain chain;
    auto run = [&](bool asks) {
        CoreRun run(platform, chain);
        Sampler& integrator = run.integrator;
        Context& context = *run.context;
        for (int i = 0; i < 10; i++) {
            integrator.step(1);
            if (!asks)
                continue;
            ASSERT(chain.force->hasClash(context));
            vector<pair<int, int>> pairs;
            vector<double> overlaps;
            chain.force->getClashes(context, pairs, overlaps);
            const vector<Vec3> positions = getPositions(context);
            for (size_t j = 0; j < pairs.size(); j++)
                ASSERT_EQUAL_TOL(2 * RADIUS - getDistance(positions[pairs[j].first], positions[pairs[j].second]),
                                 overlaps[j], 1e-5);
            ASSERT(pairs.size() > 5);
            chain.force->proposeTorsions(context, {3}, {0.4});
            chain.force->rejectProposal(context);
        }
        return getPositions(context);
    };
    assertSameBits(run(false), run(true));
}

static void testTrialsOfUsers(Platform& platform)
{
    CoreChain chain;
    CoreRun run(platform, chain);
    Sampler& integrator = run.integrator;
    Context& context = *run.context;
    for (int i = 0; i < 5; i++) {
        integrator.step(1);
        vector<double> before, after;
        integrator.getTorsionAngles(context, before);
        chain.force->proposeTorsions(context, {2}, {0.25});
        chain.force->acceptProposal(context);
        integrator.getTorsionAngles(context, after);
        ASSERT_EQUAL_TOL(0.25, remainder(after[2] - before[2], 2 * M_PI), 1e-4);
        const double energy = context.getState(State::Energy).getPotentialEnergy();
        ASSERT(fabs(energy - integrator.getPotentialEnergy(context)) < 1e-3 * (1 + fabs(energy)));

        // A step drops a proposal that is open.

        chain.force->proposeTorsions(context, {4}, {0.1});
        integrator.step(1);
        assertThrows("there is no open proposal", [&] {
            chain.force->acceptProposal(context);
        });
    }
    long long queries, volumeTests, particleTests, nodesUpdated;
    chain.force->getTraversalStatistics(context, queries, volumeTests, particleTests, nodesUpdated);
    ASSERT(queries > 500 && nodesUpdated > 0);
    chain.force->resetTraversalStatistics(context);
    chain.force->getTraversalStatistics(context, queries, volumeTests, particleTests, nodesUpdated);
    ASSERT_EQUAL(0, queries + volumeTests + particleTests + nodesUpdated);
}

static void testCheckpoint(Platform& platform, int numSteps, bool byState)
{
    CoreChain chain;
    CoreRun run(platform, chain), resumed(platform, chain, 2);
    run.integrator.step(numSteps);
    if (numSteps > 0)
        chain.force->hasClash(*run.context);
    run.integrator.step(numSteps);
    stringstream checkpoint;
    run.context->createCheckpoint(checkpoint);
    const State state = run.context->getState(State::Positions | State::Velocities | State::IntegratorParameters);
    run.integrator.step(5);
    resumed.integrator.step(1);
    if (byState)
        resumed.context->setState(state);
    else
        resumed.context->loadCheckpoint(checkpoint);
    resumed.integrator.step(5);
    assertSameBits(getPositions(*run.context), getPositions(*resumed.context));
}

int main()
{
    return runOnPlatform("Reference", [](Platform& platform) {
        testAutomatic(platform);
        testEnergyIsZero(platform);
        testModesThatContradict(platform);
        testEarlyRefusal(platform);
        testStartWithinCores(platform);
        testOtherParameters(platform);
        testQueriesInBetween(platform);
        testTrialsOfUsers(platform);
        for (int numSteps : {0, 5})
            for (bool byState : {false, true})
                testCheckpoint(platform, numSteps, byState);
    });
}
