/**
 * This tests how TorsionMonteCarloIntegrator samples with energies that the library evaluates itself: the distribution,
 * the plan, the counts, and that nothing is stale, whatever has changed in between. On one platform.
 */

#include "openmm/CMMotionRemover.h"
#include "openmm/CompoundIntegrator.h"
#include "openmm/CustomTorsionForce.h"
#include "openmm/HarmonicBondForce.h"
#include "openmm/NonbondedForce.h"
#include "openmm/PeriodicTorsionForce.h"
#include "openmm/serialization/XmlSerializer.h"
#include "openmm/VerletIntegrator.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "SamplingSupport.h"
#include <memory>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

typedef TorsionMonteCarloIntegrator Sampler;

/**
 * A chain of beads with bonds, torsions, Lennard-Jones and charges, each of a Force.
 */
class ChargedChain : public BeadChain {
public:
    explicit ChargedChain(int length, double radius = 0) : BeadChain(length, radius, 2.5)
    {
        addBonds(length);
        addTorsions(length);
        addPairs(length);
    }
    static double getCharge(int bead)
    {
        return bead % 2 == 0 ? 0.3 : -0.2;
    }
    static constexpr double k1 = 1, k2 = 1.5, phase2 = 1, sigma = 1.3, epsilon = 4;
    HarmonicBondForce* bonds;
    PeriodicTorsionForce* torsions;
    NonbondedForce* pairs;

private:
    void addBonds(int length)
    {
        bonds = new HarmonicBondForce();
        for (int i = 1; i < length; i++)
            bonds->addBond(i - 1, i, 0.9, 1000);
        system.addForce(bonds);
    }
    void addTorsions(int length)
    {
        torsions = new PeriodicTorsionForce();
        for (int i = 3; i < length; i++) {
            torsions->addTorsion(i - 3, i - 2, i - 1, i, 1, 0, k1);
            torsions->addTorsion(i - 3, i - 2, i - 1, i, 2, phase2, k2);
        }
        system.addForce(torsions);
    }
    void addPairs(int length)
    {
        pairs = new NonbondedForce();
        for (int i = 0; i < length; i++) {
            pairs->addParticle(getCharge(i), sigma, epsilon);
            for (int j = max(0, i - 2); j < i; j++)
                pairs->addException(j, i, 0, 1, 0);
            if (i >= 3)
                pairs->addException(i - 3, i, 0.5 * getCharge(i - 3) * getCharge(i), sigma, 0.5 * epsilon);
        }
        system.addForce(pairs);
    }
};

/**
 * Compute the energy of force groups on the Reference platform, without the StericExclusionForce.
 */
double computeEnergy(const System& system, const vector<Vec3>& positions, const map<string, double>& parameters = {},
                     int groups = -1)
{
    unique_ptr<System> copy(XmlSerializer::clone<System>(system));
    for (int i = copy->getNumForces() - 1; i >= 0; i--)
        if (dynamic_cast<StericExclusionForce*>(&copy->getForce(i)) != NULL)
            copy->removeForce(i);
    VerletIntegrator integrator(0.001);
    Context context(*copy, integrator, Platform::getPlatform("Reference"));
    context.setPositions(positions);
    for (auto& parameter : parameters)
        context.setParameter(parameter.first, parameter.second);
    return context.getState(State::Energy, false, groups).getPotentialEnergy();
}

/**
 * Check that U as it is held is what OpenMM says, before and after some trials.
 */
void assertHeldEnergy(const System& system, Sampler& integrator, Context& context)
{
    for (int steps : {0, 1, 3}) {
        for (int i = 0; i < steps; i++)
            integrator.step(1);
        State state = context.getState(State::Positions | State::Parameters);
        const double expected =
            computeEnergy(system, state.getPositions(), state.getParameters(), integrator.getIntegrationForceGroups());
        const double tolerance = getPrecision(context.getPlatform()) == "single" ? 1e-4 : 2e-6;
        ASSERT(fabs(expected - integrator.getPotentialEnergy(context)) <= tolerance * (100 + fabs(expected)));
    }
}

// ---- Distributions ----

/** How the energy of the chain is evaluated in a trial. Foreign are all torsions, or half of their energy. */
enum Way { AllNative, NothingNative, HalfForeignInSameGroup, ForeignInOwnGroup, SoftSpheres, NoSpheres };

static const Way WAYS[] = {AllNative, NothingNative, HalfForeignInSameGroup, ForeignInOwnGroup, SoftSpheres, NoSpheres};

/** The soft spheres of the chain are so large that they make a difference. */
static const double SOFT_RADIUS = 0.9, SOFT_CONSTANT = 50;

double computeTorsionEnergy1(double angle)
{
    return ChargedChain::k1 * (1 + cos(angle));
}

double computeTorsionEnergy(double angle)
{
    return computeTorsionEnergy1(angle) + ChargedChain::k2 * (1 + cos(2 * angle - ChargedChain::phase2));
}

/**
 * Get means of what two torsions do, by quadrature: of the cosine of each, and of their difference.
 */
vector<double> integrate(bool soft)
{
    const int numCells = 180;
    vector<double> means(3, 0.0);
    double weights = 0;
    auto pairEnergy = [&](const Vec3& a, const Vec3& b, double factor, double charges) {
        const double r = getDistance(a, b), s = pow(ChargedChain::sigma / r, 6);
        const double excess = soft ? max(0.0, 2 * SOFT_RADIUS - r) : 0;
        return factor * (4 * ChargedChain::epsilon * (s * s - s) + 138.93545764438198 * charges / r) +
               0.5 * SOFT_CONSTANT * excess * excess;
    };
    const double unlike = ChargedChain::getCharge(0) * ChargedChain::getCharge(3);
    const double like = pow(ChargedChain::getCharge(0), 2);
    for (int i = 0; i < numCells; i++)
        for (int j = 0; j < numCells; j++) {
            const double a = 2 * M_PI * (i + 0.5) / numCells, b = 2 * M_PI * (j + 0.5) / numCells;
            const Vec3 x[] = {Vec3(0, 1, 0), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, cos(a), sin(a)),
                              Vec3(1 - cos(b), cos(a) - sin(a) * sin(b), sin(a) + cos(a) * sin(b))};
            const double energy = computeTorsionEnergy(a) + computeTorsionEnergy(b) +
                                  pairEnergy(x[0], x[3], 0.5, unlike) + pairEnergy(x[1], x[4], 0.5, unlike) +
                                  pairEnergy(x[0], x[4], 1, like);
            const double weight = exp(-energy / THERMAL);
            const double values[] = {cos(a), cos(b), cos(a - b)};
            weights += weight;
            for (int k = 0; k < 3; k++)
                means[k] += weight * values[k];
        }
    for (double& mean : means)
        mean /= weights;
    return means;
}

/**
 * Make a chain whose torsions are foreign in some ways. If they are in the group of pairs, the native torsions are in
 * another group.
 */
unique_ptr<ChargedChain> createChain(Way way, int length)
{
    auto chain = make_unique<ChargedChain>(length, way == SoftSpheres || way == NoSpheres ? SOFT_RADIUS : 0);
    chain->force->setForceConstant(SOFT_CONSTANT);
    if (way == HalfForeignInSameGroup || way == ForeignInOwnGroup) {
        Probe* probe = new Probe();
        auto computeForeign = way == ForeignInOwnGroup ? computeTorsionEnergy : computeTorsionEnergy1;
        probe->energy = [=](const vector<Vec3>& x) {
            double energy = 0;
            for (int i = 3; i < length; i++)
                energy += computeForeign(getDihedral(x[i - 3], x[i - 2], x[i - 1], x[i]));
            return energy;
        };
        probe->setForceGroup(way == ForeignInOwnGroup ? 7 : 0);
        for (int i = 3; i < length; i++)
            for (int j : {0, 1})
                if (j == 0 || way == ForeignInOwnGroup)
                    chain->torsions->setTorsionParameters(2 * (i - 3) + j, i - 3, i - 2, i - 1, i, j + 1, 0, 0);
        chain->torsions->setForceGroup(2);
        chain->system.addForce(probe);
    }
    return chain;
}

void setUp(Sampler& integrator, Way way)
{
    integrator.setRandomNumberSeed(5);
    integrator.addTorsionMove(2, 1.2);
    integrator.addTorsionMove(1, M_PI);
    integrator.addTorsionMove(1, 0.8, {}, 2);
    integrator.setNativeEnergies(way != NothingNative);
    integrator.setStericMode(way == SoftSpheres ? Sampler::Soft
                             : way == NoSpheres ? Sampler::Automatic
                                                : Sampler::Hard);
}

/**
 * Whoever evaluates the energy, and in whatever stages, the two torsions of five beads are where it says.
 */
void testNativeDistributions(Platform& platform)
{
    const int numSteps = platform.getName() == "Reference" ? 12000 : 1000;
    const double error = 0.03 * sqrt(12000.0 / numSteps);
    ASSERT(fabs(integrate(true)[2] - integrate(false)[2]) > 0.1);
    for (Way way : WAYS) {
        auto chain = createChain(way, 5);
        Sampler integrator(300);
        setUp(integrator, way);
        integrator.setTrialsPerStep(10);
        Context context(chain->system, integrator, platform);
        context.setPositions(chain->positions);
        const vector<double> expected = integrate(way == SoftSpheres);
        vector<double> means(3, 0.0), angles;
        for (int i = 0; i < numSteps; i++) {
            integrator.step(1);
            integrator.getTorsionAngles(context, angles);
            means[0] += cos(angles[0]) / numSteps;
            means[1] += cos(angles[1]) / numSteps;
            means[2] += cos(angles[0] - angles[1]) / numSteps;
        }
        for (int k = 0; k < 3; k++)
            ASSERT_USUALLY_EQUAL_TOL(expected[k], means[k], error);
    }
}

// ---- Plan and counts ----

void testPlan(Platform& platform)
{
    auto chain = createChain(HalfForeignInSameGroup, 6);
    chain->system.addForce(new CMMotionRemover());
    CustomTorsionForce* elsewhere = new CustomTorsionForce("theta");
    elsewhere->addTorsion(0, 1, 2, 3, {});
    elsewhere->setForceGroup(3);
    chain->system.addForce(elsewhere);
    Sampler integrator(300);
    ASSERT(integrator.getNativeEnergies());
    integrator.addTorsionMove(1, 1);
    integrator.setIntegrationForceGroups(1 | 1 << 2);
    Context context(chain->system, integrator, platform);
    typedef vector<Sampler::EnergyKind> Kinds;
    auto getKinds = [&] {
        Kinds kinds;
        for (const Sampler::PlannedEnergy& entry : integrator.getEnergyPlan(context)) {
            ASSERT_EQUAL(kinds.size(), entry.force);
            ASSERT_EQUAL(chain->system.getForce(entry.force).getName(), entry.name);
            ASSERT(!entry.reason.empty());
            kinds.push_back(entry.kind);
        }
        return kinds;
    };

    // The plan exists before there are positions. The spheres, bonds, torsions, pairs, the probe, the remover, and a
    // Force of another group.

    const Kinds expected = {Sampler::NotSampled, Sampler::Constant,   Sampler::Native,    Sampler::Native,
                            Sampler::Foreign,    Sampler::NotSampled, Sampler::NotSampled};
    ASSERT(getKinds() == expected);
    context.setPositions(chain->positions);
    integrator.step(1);
    ASSERT(getKinds() == expected);

    // It follows the user's choices.

    integrator.setStericMode(Sampler::Soft);
    ASSERT_EQUAL(Sampler::Native, getKinds()[0]);
    integrator.setStericMode(Sampler::Hard);
    integrator.setIntegrationForceGroups(1 << 3);
    Kinds inOtherGroup(7, Sampler::NotSampled);
    inOtherGroup[6] = Sampler::Native;
    ASSERT(getKinds() == inOtherGroup);
    integrator.setIntegrationForceGroups(1 | 1 << 2);
    integrator.setNativeEnergies(false);
    ASSERT(getKinds() == Kinds({Sampler::NotSampled, Sampler::Foreign, Sampler::Foreign, Sampler::Foreign,
                                Sampler::Foreign, Sampler::NotSampled, Sampler::NotSampled}));
    Sampler unbound(300);
    assertThrows("not bound to this Context", [&] {
        unbound.getEnergyPlan(context);
    });
    assertThrows("not bound to this Context", [&] {
        unbound.getPotentialEnergy(context);
    });
    assertThrows("not bound to a context", [&] {
        unbound.getStageStatistics();
    });
}

void testStageCounts(Platform& platform)
{
    // A stage is asked about the trials that the one before has let through, and each refused trial is counted once.

    for (Way way : WAYS) {
        auto chain = createChain(way, 8);
        Sampler integrator(300);
        setUp(integrator, way);
        Context context(chain->system, integrator, platform);
        context.setPositions(chain->positions);
        integrator.step(10);
        long long reached = 0, refused = 0, accepted = 0;
        for (int i = 0; i < integrator.getNumMoves(); i++) {
            Statistics statistics(integrator, i);
            reached += statistics.attempted - statistics.clashed;
            refused += statistics.rejectedByEnergy;
            accepted += statistics.accepted;
        }
        ASSERT(refused > 100 && accepted > 10);
        const bool hasForeign = way == NothingNative; // else outer tests decide about them
        const bool hasNative = way != NothingNative;  // the exceptions of pairs are terms
        const vector<bool> takesPart = {hasNative, hasNative, way == SoftSpheres, hasNative, false, hasForeign};
        auto stages = integrator.getStageStatistics();
        ASSERT_EQUAL(takesPart.size(), stages.size());
        for (size_t i = 0; i < stages.size(); i++) {
            ASSERT(!stages[i].stage.empty());
            ASSERT_EQUAL(takesPart[i] ? reached : 0, stages[i].computed);
            if (takesPart[i])
                reached -= stages[i].refused;
            refused -= stages[i].refused;
        }
        ASSERT_EQUAL(accepted, reached);
        ASSERT_EQUAL(0, refused);
        integrator.resetMoveStatistics();
        for (auto& stage : integrator.getStageStatistics())
            ASSERT(stage.computed == 0 && stage.refused == 0);
    }
}

/**
 * What no move can change costs nothing, not even a random number.
 */
void testConstantEnergies(Platform& platform)
{
    auto sample = [&](bool withBonds) {
        BeadChain chain(6, 0.4);
        if (withBonds) {
            HarmonicBondForce* bonds = new HarmonicBondForce();
            for (int i = 1; i < 6; i++)
                bonds->addBond(i - 1, i, 0.8, 1000);
            chain.system.addForce(bonds);
        }
        Sampler integrator(300);
        integrator.setRandomNumberSeed(4);
        integrator.addTorsionMove(1, 1);
        Context context(chain.system, integrator, platform);
        context.setPositions(chain.positions);
        integrator.step(3);
        ASSERT_EQUAL_TOL(withBonds ? 100.0 : 0.0, integrator.getPotentialEnergy(context), 1e-5);
        return getPositions(context);
    };
    assertSameBits(sample(false), sample(true));
}

// ---- Nothing is stale ----

void testHeldEnergies(Platform& platform)
{
    // Whatever moves the positions in between, U is that of the state.

    ChargedChain chain(12, 0.2);
    Sampler* integrator = new Sampler(600);
    setUp(*integrator, AllNative);
    CompoundIntegrator compound;
    compound.addIntegrator(integrator);
    compound.addIntegrator(new VerletIntegrator(0.001));
    Context context(chain.system, compound, platform);
    context.setPositions(chain.positions);
    auto check = [&] {
        assertHeldEnergy(chain.system, *integrator, context);
    };
    check();
    stringstream checkpoint;
    context.createCheckpoint(checkpoint);
    integrator->step(2);
    context.setPositions(chain.positions);
    check();
    integrator->setTorsionAngles(context, vector<double>(9, 2.2));
    check();
    compound.setCurrentIntegrator(1);
    compound.step(3);
    compound.setCurrentIntegrator(0);
    check();

    // Trials of the user, who asks for no energy: the last trial of the integrator was another one.

    for (int torsion = 0; torsion < 9; torsion++) {
        integrator->step(1);
        chain.force->proposeTorsions(context, {torsion}, {0.3});
        chain.force->acceptProposal(context);
        check();
        chain.force->proposeTorsions(context, {torsion}, {0.3});
        ASSERT(integrator->getPotentialEnergy(context) != 0);
        chain.force->rejectProposal(context);
        check();
    }
    context.loadCheckpoint(checkpoint);
    check();
    context.reinitialize(true);
    check();
    for (int i = 0; i < 12; i++)
        chain.force->setParticleParameters(i, 0.1);
    chain.force->updateParametersInContext(context); // the engine restarts
    check();
}

void testChangedParameters(Platform& platform)
{
    // Parameters of the Context and of Forces.

    ChargedChain chain(10);
    CustomTorsionForce* custom = new CustomTorsionForce("scale*cos(theta-theta0)");
    custom->addGlobalParameter("scale", 2);
    custom->addPerTorsionParameter("theta0");
    custom->addTorsion(2, 3, 4, 5, {0.5});
    chain.system.addForce(custom);
    chain.pairs->addGlobalParameter("charging", 0);
    chain.pairs->addParticleParameterOffset("charging", 0, 0.2, 0, 0);
    Sampler integrator(500);
    setUp(integrator, AllNative);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    assertHeldEnergy(chain.system, integrator, context);
    double before = integrator.getPotentialEnergy(context);
    auto assertChanged = [&] {
        ASSERT(fabs(integrator.getPotentialEnergy(context) - before) > 0.01);
        assertHeldEnergy(chain.system, integrator, context);
        before = integrator.getPotentialEnergy(context);
    };
    context.setParameter("scale", 7);
    assertChanged();
    context.setParameter("charging", 1);
    assertChanged();
    chain.pairs->setParticleParameters(4, -0.3, 0.9, 1.5);
    chain.pairs->updateParametersInContext(context);
    assertChanged();
    chain.torsions->setTorsionParameters(3, 1, 2, 3, 4, 3, 0.2, 4);
    chain.torsions->updateParametersInContext(context);
    assertChanged();
    chain.bonds->setBondParameters(0, 0, 1, 0.5, 1000); // constant, but a part of U
    chain.bonds->updateParametersInContext(context);
    assertChanged();

    // Without updateParametersInContext() nothing happens, as in OpenMM.

    unique_ptr<System> original(XmlSerializer::clone<System>(chain.system));
    chain.pairs->setParticleParameters(4, 0.5, 0.9, 1.5);
    assertHeldEnergy(*original, integrator, context);
    context.setParameter("scale", 3);
    assertHeldEnergy(*original, integrator, context);

    // When its Forces are read because of another, that is noticed.

    custom->updateParametersInContext(context);
    assertThrows("the Context's energy of force group 0 is ", [&] {
        integrator.step(1);
    });
    chain.pairs->updateParametersInContext(context);
    assertHeldEnergy(chain.system, integrator, context);
}

void testChosenEnergies(Platform& platform)
{
    // Groups and modes may change between steps.

    ChargedChain chain(8, 0.1);
    chain.torsions->setForceGroup(1);
    chain.pairs->setForceGroup(2);
    Sampler integrator(500);
    setUp(integrator, AllNative);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    for (int groups : {-1, 1, 2, 4, 6, 1 << 5, -1}) {
        integrator.setIntegrationForceGroups(groups);
        assertHeldEnergy(chain.system, integrator, context);
    }
    integrator.setNativeEnergies(false);
    assertHeldEnergy(chain.system, integrator, context);
    integrator.setNativeEnergies(true);
    assertHeldEnergy(chain.system, integrator, context);

    // Soft spheres have a part in it.

    for (int i = 0; i < 8; i++)
        chain.force->setParticleParameters(i, 1.2);
    chain.force->updateParametersInContext(context);
    integrator.setStericMode(Sampler::Soft);
    for (bool native : {true, false}) {
        integrator.setNativeEnergies(native);
        context.setPositions(chain.positions);
        const double all = context.getState(State::Energy).getPotentialEnergy();
        ASSERT(all > computeEnergy(chain.system, getPositions(context)) + 1);
        ASSERT_EQUAL_TOL(all, integrator.getPotentialEnergy(context), 1e-4);
        integrator.step(1);
    }
}

/**
 * Foreign Forces that share groups with native and constant ones.
 */
void testMixedEnergies(Platform& platform)
{
    for (Way way : {HalfForeignInSameGroup, ForeignInOwnGroup}) {
        auto chain = createChain(way, 7);
        ChargedChain all(7);
        Sampler integrator(500);
        setUp(integrator, way);
        Context context(chain->system, integrator, platform);
        context.setPositions(chain->positions);
        assertHeldEnergy(all.system, integrator, context);
        chain->bonds->setForceGroup(7); // has no effect any more
        assertHeldEnergy(all.system, integrator, context);
    }

    // Of a foreign and a constant Force in one group the constant part is no change.

    auto chain = createChain(ForeignInOwnGroup, 7);
    chain->bonds->setForceGroup(7);
    ChargedChain all(7);
    Sampler integrator(500);
    setUp(integrator, AllNative);
    Context context(chain->system, integrator, platform);
    context.setPositions(chain->positions);
    assertHeldEnergy(all.system, integrator, context);
}

void testSeveralContexts(Platform& platform)
{
    // Contexts of one System, and samplers of one Context: each has separate energies.

    ChargedChain chain(8, 0.1);
    chain.torsions->setForceGroup(1);
    Sampler integrator1(400), integrator2(500);
    setUp(integrator1, AllNative);
    setUp(integrator2, AllNative);
    Context context1(chain.system, integrator1, platform), context2(chain.system, integrator2, platform);
    context1.setPositions(chain.positions);
    context2.setPositions(ChargedChain(8).positions);
    integrator2.setTorsionAngles(context2, vector<double>(5, -2.0));
    for (int i = 0; i < 3; i++) {
        assertHeldEnergy(chain.system, integrator1, context1);
        assertHeldEnergy(chain.system, integrator2, context2);
    }

    Sampler* first = new Sampler(400);
    Sampler* second = new Sampler(400);
    setUp(*first, AllNative);
    setUp(*second, AllNative);
    first->setIntegrationForceGroups(1);
    second->setIntegrationForceGroups(2);
    CompoundIntegrator compound;
    compound.addIntegrator(first);
    compound.addIntegrator(second);
    Context context(chain.system, compound, platform);
    context.setPositions(chain.positions);
    for (int i = 0; i < 3; i++) {
        assertHeldEnergy(chain.system, *first, context);
        assertHeldEnergy(chain.system, *second, context);
    }
    ASSERT_EQUAL(0, second->getStageStatistics()[1].computed); // it has no pairs
    ASSERT(first->getStageStatistics()[1].computed > 0);
}

/**
 * A run that continues after a checkpoint or State was made, and one that is resumed from it, are the same, bit for
 * bit: positions and U.
 */
void testResumedEnergies(Platform& platform)
{
    for (Way way : WAYS) {
        auto chain = createChain(way, 40);
        auto start = [&](int seed) {
            auto integrator = make_unique<Sampler>(400);
            setUp(*integrator, way);
            integrator->setRandomNumberSeed(seed);
            return integrator;
        };
        auto integrator = start(1);
        Context context(chain->system, *integrator, platform);
        context.setPositions(chain->positions);
        integrator->step(5);
        for (bool byState : {false, true}) {
            stringstream checkpoint;
            State state;
            if (byState)
                state = context.getState(State::Positions | State::Velocities | State::IntegratorParameters);
            else
                context.createCheckpoint(checkpoint);
            integrator->step(3);
            auto resumed = start(2);
            Context resumedContext(chain->system, *resumed, platform);
            if (byState)
                resumedContext.setState(state);
            else
                resumedContext.loadCheckpoint(checkpoint);
            resumed->step(3);
            assertSameBits(getPositions(context), getPositions(resumedContext));
            ASSERT_EQUAL(integrator->getPotentialEnergy(context), resumed->getPotentialEnergy(resumedContext));
        }
    }
}

// ---- Errors ----

void testStatesWithoutEnergy(Platform& platform)
{
    // A present state without energy is an error that names the Force; sampling continues from a better one.

    BeadChain chain(5, 0);
    NonbondedForce* pairs = new NonbondedForce();
    pairs->setName("Charges");
    for (int i = 0; i < 5; i++)
        pairs->addParticle(i % 2 == 0 ? 0.1 : -0.1, 0.5, 1);
    chain.system.addForce(pairs);
    Sampler integrator(300);
    integrator.addTorsionMove(1, 1);
    Context context(chain.system, integrator, platform);
    vector<Vec3> overlapping = chain.positions;
    overlapping[3] = overlapping[0];
    context.setPositions(overlapping);
    assertThrows("the energy of the integration force groups is not a number: that of force 1, Charges", [&] {
        integrator.step(1);
    });
    ASSERT_EQUAL(0, context.getStepCount());
    context.setPositions(chain.positions);
    assertHeldEnergy(chain.system, integrator, context);
}

void testNativeEnergies(Platform& platform)
{
    testPlan(platform);
    testStageCounts(platform);
    testConstantEnergies(platform);
    testHeldEnergies(platform);
    testChangedParameters(platform);
    testChosenEnergies(platform);
    testMixedEnergies(platform);
    testSeveralContexts(platform);
    testResumedEnergies(platform);
    testStatesWithoutEnergy(platform);
    testNativeDistributions(platform);
}
