/**
 * This tests sampling with CustomGBForces that are no generalized Born model: the means of two torsions against
 * quadrature; the same decisions as where OpenMM evaluates them; what follows parameters; the energy that is held.
 */

#include "NativeEnergySupport.h"
#include "openmm/CustomCentroidBondForce.h"
#include "openmm/CustomGBForce.h"
#include "openmm/CustomTorsionForce.h"
#include "openmm/GBSAOBCForce.h"
#include "openmm/NonbondedForce.h"
#include "openmm/TabulatedFunction.h"
#include "openmmchaintree/internal/NativeEnergyCheck.h"
#include "ShortChain.h"
#include <functional>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * One that OpenMM has to evaluate, since it is of another class.
 */
class DerivedForce : public CustomGBForce {};

/**
 * Fill a Force whose charges are weaker where there are neighbours.
 */
static void describe(CustomGBForce& force, int numParticles)
{
    force.addPerParticleParameter("q");
    force.addGlobalParameter("scale", 1);
    force.addComputedValue("v", "exp(-(r/1.4)^2)*(1+0.3*q2)", CustomGBForce::ParticlePair);
    force.addComputedValue("w", "q/(1+v^2)", CustomGBForce::SingleParticle);
    force.addEnergyTerm("scale*15*w1*w2*exp(-r)/r", CustomGBForce::ParticlePairNoExclusions);
    force.addEnergyTerm("-scale*v^2+w", CustomGBForce::SingleParticle);
    for (int i = 0; i < numParticles; i++)
        force.addParticle({i % 2 == 0 ? 0.8 : -0.5});
    for (int i = 0; i + 2 < numParticles; i++)
        force.addExclusion(i, i + 2);
}

template <class Force>
static Force* addForce(System& system, int group)
{
    Force* force = new Force();
    describe(*force, system.getNumParticles());
    force->setForceGroup(group);
    system.addForce(force);
    return force;
}

// ---- Quadrature ----

static void addCentroidForce(System& system, int group)
{
    CustomCentroidBondForce* force = new CustomCentroidBondForce(2, "15*(same(distance(g1,g2))-2.2)^2");
    force->addTabulatedFunction("same",
                                new Continuous1DFunction({0, 30}, 0, 30)); // so that only OpenMM can evaluate it
    force->addGroup({0, 1});
    force->addGroup({3, 4});
    force->addBond({0, 1});
    force->setForceGroup(group);
    system.addForce(force);
}

static void testMeans()
{
    const int numSteps = 10000;
    const double tolerance = getTolerance(numSteps);
    ShortChain chain(0.3), bare(0.3), shared(0.3);
    addForce<CustomGBForce>(chain.system, 1);
    const Means expected = chain.computeMeans(3);
    ASSERT(getLargestDifference(expected, chain.computeMeans(2)) > 1.5 * tolerance);
    ASSERT(getLargestDifference(expected, bare.computeMeans(1)) > 1.5 * tolerance);
    for (const Setting& setting :
         {Setting{0, 7, true, false}, Setting{7, 21, true, false}, Setting{50, 50, true, false}})
        assertSampled(chain, expected, setting, numSteps);

    // Beside a foreign Force in the same group, whose change has to be told from that of the others. OpenMM evaluates
    // both, which takes long.

    const int numSlowSteps = 700;
    addForce<CustomGBForce>(shared.system, 0);
    addCentroidForce(shared.system, 0);
    const Means ofBoth = shared.computeMeans(1);
    ASSERT(getLargestDifference(expected, ofBoth) > 3 * getTolerance(numSlowSteps));
    for (const Setting& setting : {Setting{0, 4, true, false}, Setting{7, 14, true, false}})
        assertSampled(shared, ofBoth, setting, numSlowSteps);
}

// ---- Decisions ----

/**
 * A chain with native energies and a Force of values, in a Context.
 */
class Run {
public:
    template <class Force>
    static unique_ptr<Run> create(int trialsPerTest, double temperature, int group = 1, bool withBorn = false)
    {
        unique_ptr<Run> run(new Run(temperature));
        run->force = addForce<Force>(run->chain.system, group);
        if (withBorn)
            run->addBorn();
        run->integrator.setTrialsPerOuterTest(trialsPerTest);
        run->context.reset(new Context(run->chain.system, run->integrator, Platform::getPlatform("Reference")));
        run->context->setPositions(run->chain.positions);
        return run;
    }
    vector<Vec3> getPositions() const
    {
        return context->getState(State::Positions).getPositions();
    }
    /**
     * Get U by OpenMM.
     */
    double computeEnergy() const
    {
        return context->getState(State::Energy, false, GROUPS).getPotentialEnergy();
    }
    void assertHeld()
    {
        ASSERT_EQUAL_TOL(computeEnergy(), integrator.getPotentialEnergy(*context), 1e-6);
    }
    string getKind() const
    {
        for (auto& entry : integrator.getEnergyPlan(*context))
            if (entry.force == index)
                return entry.kind == TorsionMonteCarloIntegrator::Foreign ? "foreign" : "native";
        return "";
    }
    long long countAccepted() const
    {
        long long attempted, clashed, rejected, accepted;
        integrator.getMoveStatistics(0, attempted, clashed, rejected, accepted);
        return accepted;
    }
    static const int GROUPS = 1 | 2 | 4;
    BeadChain chain;
    TorsionMonteCarloIntegrator integrator;
    CustomGBForce* force;
    unique_ptr<Context> context;

private:
    explicit Run(double temperature) : chain(30, 0.3), integrator(temperature), index(2)
    {
        chain.force->setForceGroup(5);
        CustomTorsionForce* torsions = new CustomTorsionForce("height*cos(theta)");
        torsions->addGlobalParameter("height", -2);
        for (int i = 0; i + 3 < 30; i++)
            torsions->addTorsion(i, i + 1, i + 2, i + 3);
        chain.system.addForce(torsions);
        integrator.setRandomNumberSeed(5);
        integrator.addTorsionMove(1, 0.4);
        integrator.setTrialsPerStep(60);
        integrator.setIntegrationForceGroups(GROUPS);
    }
    void addBorn()
    {
        NonbondedForce* nonbonded = new NonbondedForce();
        GBSAOBCForce* born = new GBSAOBCForce();
        for (int i = 0; i < 30; i++) {
            nonbonded->addParticle(i % 2 == 0 ? 0.4 : -0.4, 0.5, 0.3);
            born->addParticle(i % 2 == 0 ? 0.4 : -0.4, 0.3, 0.8);
        }
        chain.system.addForce(nonbonded);
        chain.system.addForce(born);
    }
    const int index;
};

static void testDecisions()
{
    for (int trialsPerTest : {0, 1, 12}) {
        for (bool withBorn : {false, true}) {
            auto native = Run::create<CustomGBForce>(trialsPerTest, 300, 1, withBorn);
            auto foreign = Run::create<DerivedForce>(trialsPerTest, 300, 1, withBorn);
            ASSERT_EQUAL("native", native->getKind());
            ASSERT_EQUAL("foreign", foreign->getKind());
            for (int i = 0; i < 10; i++) {
                native->integrator.step(1);
                foreign->integrator.step(1);
                ASSERT(trialsPerTest == 0 || native->getPositions() == foreign->getPositions());
                native->assertHeld();
                foreign->assertHeld();
            }
            const long long accepted = native->countAccepted();
            ASSERT(trialsPerTest == 0 || foreign->countAccepted() == accepted);
            ASSERT(accepted > 10);
            auto stages = native->integrator.getStageStatistics();
            ASSERT_EQUAL("computed values", stages[4].stage);
            ASSERT_EQUAL(trialsPerTest == 0, stages[4].computed > 100);
            ASSERT_EQUAL(0, stages[5].computed);
            long long attempted, passed, takenBack;
            double mean, deviation;
            native->integrator.getOuterStatistics(attempted, passed, takenBack, mean, deviation);
            ASSERT_EQUAL(trialsPerTest > 0 || withBorn, attempted > 0);
            ASSERT(trialsPerTest == 0 || (passed > 0 && passed < attempted));
        }
    }
}

/**
 * At a temperature of 0 the energy never goes up, whoever is asked when. And it goes down.
 */
static void assertDownhill(bool withBorn, int trialsPerTest, double scale, double height)
{
    auto run = Run::create<CustomGBForce>(trialsPerTest, 0, 1, withBorn);
    run->context->setParameter("scale", scale);
    run->context->setParameter("height", height);
    const double start = run->computeEnergy();
    double before = start;
    for (int i = 0; i < 20; i++) {
        run->integrator.step(1);
        const double energy = run->computeEnergy();
        ASSERT(energy <= before + 1e-5 * fabs(before));
        before = energy;
    }
    ASSERT(before < start - 10);
}

static void testDownhill()
{
    for (bool withBorn : {false, true}) {
        assertDownhill(withBorn, 0, 1, -2);
        assertDownhill(withBorn, 4, 1, -2);
        assertDownhill(withBorn, 0, 10, 2); // all else has to go up
    }
}

/**
 * A Force of values alone, in trials and left to outer tests.
 */
static void testNothingElse()
{
    for (int trialsPerTest : {0, 5}) {
        auto run = Run::create<CustomGBForce>(trialsPerTest, 300);
        run->integrator.setIntegrationForceGroups(2);
        for (int i = 0; i < 10; i++) {
            run->integrator.step(1);
            ASSERT_EQUAL_TOL(run->context->getState(State::Energy, false, 2).getPotentialEnergy(),
                             run->integrator.getPotentialEnergy(*run->context), 1e-6);
        }
        ASSERT(run->countAccepted() > 10);
    }
}

// ---- What changes ----

static void testParameters()
{
    auto run = Run::create<CustomGBForce>(0, 300);
    run->integrator.step(3);
    run->assertHeld();
    const double before = run->computeEnergy();
    run->context->setParameter("scale", 0.25);
    ASSERT(fabs(run->computeEnergy() - before) > 1);
    run->assertHeld();
    run->integrator.step(3);
    run->assertHeld();
    for (int i = 0; i < 30; i++)
        run->force->setParticleParameters(i, {0.1 + 0.02 * i});
    run->assertHeld(); // as long as the Context has not been told
    const double untold = run->computeEnergy();
    run->force->updateParametersInContext(*run->context);
    ASSERT(fabs(run->computeEnergy() - untold) > 0.1);
    run->assertHeld();
    run->integrator.step(3);
    run->assertHeld();
    run->context->setPositions(run->chain.positions);
    run->assertHeld();
}

/**
 * An energy that is not that of OpenMM is found.
 */
static void testCheck()
{
    NativeScene scene;
    CustomGBForce* force = new CustomGBForce();
    describe(*force, NativeScene::NUM_BEADS);
    const int index = scene.add(force);
    scene.build();
    const NativeEnergyCheck check(scene.getImpl(), *scene.plan, [&scene] {
        return scene.createScene();
    });
    vector<double> energies = scene.computeEnergies();
    ASSERT(check.check(scene.chain.positions, energies, NativeEnergyCheck::GroupEnergy()));
    energies[index] += 0.02;
    assertThrows("do not agree about the energy of force 1 (CustomGBForce)", [&] {
        check.check(scene.chain.positions, energies, NativeEnergyCheck::GroupEnergy());
    });
}

int main()
{
    return runOnPlatform("Reference", [](Platform&) {
        testMeans();
        testDecisions();
        testDownhill();
        testNothingElse();
        testParameters();
        testCheck();
    });
}
