/**
 * This tests that foreign Forces are evaluated alone, as often as the plan says, and as they are: with the parameters
 * that were copied to the Context, and with what they remember.
 */

#include "ForeignSupport.h"
#include "openmm/CMMotionRemover.h"
#include "openmm/CustomCentroidBondForce.h"
#include "openmm/CustomTorsionForce.h"
#include "openmm/GBSAOBCForce.h"
#include "openmm/HarmonicBondForce.h"
#include "openmm/NonbondedForce.h"
#include "openmm/TabulatedFunction.h"
#include "SamplingSupport.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

typedef TorsionMonteCarloIntegrator Sampler;

static NonbondedForce* createNonbonded(int numParticles, double charge)
{
    NonbondedForce* force = new NonbondedForce();
    for (int i = 0; i < numParticles; i++)
        force->addParticle(i % 2 == 0 ? charge : -charge, 0.3, 0.1);
    return force;
}

/**
 * A chain with each kind of Force, all but one in one force group.
 */
class Everything {
public:
    Everything(int foreignGroup, bool withLargeChanges) : chain(14, 0.3, 2), integrator(300)
    {
        System& system = chain.system;
        HarmonicBondForce* bonds = new HarmonicBondForce();
        for (int i = 1; i < 14; i++)
            bonds->addBond(i - 1, i, 1.01, 1000);
        system.addForce(bonds);
        CustomTorsionForce* torsions = new CustomTorsionForce("2*cos(theta)");
        for (int i = 0; i < 11; i++)
            torsions->addTorsion(i, i + 1, i + 2, i + 3);
        system.addForce(torsions);
        system.addForce(createNonbonded(14, 0.2));
        GBSAOBCForce* born = new GBSAOBCForce();
        for (int i = 0; i < 14; i++)
            born->addParticle(i % 2 == 0 ? 0.2 : -0.2, 0.2, 0.8);
        system.addForce(born);
        HarmonicBondForce* elsewhere = new HarmonicBondForce();
        elsewhere->addBond(0, 13, 1, 1);
        elsewhere->setForceGroup(3);
        system.addForce(elsewhere);
        system.addForce(new CMMotionRemover());
        CustomCentroidBondForce* spring = new CustomCentroidBondForce(2, "0.01*same(distance(g1,g2))^2");
        spring->addTabulatedFunction("same",
                                     new Continuous1DFunction({0, 30}, 0, 30)); // so that only OpenMM can evaluate it
        spring->addGroup({0, 1});
        spring->addGroup({12, 13});
        spring->addBond({0, 1});
        addForeign(spring, foreignGroup);
        addForeign(createProbe(0.1), foreignGroup);
        if (withLargeChanges) {
            addForeign(createProbe(1000), foreignGroup);
            addForeign(createNonbonded(14, 6), foreignGroup); // openmm-chaintree has code for one
        }
        counter = new EvaluationCounter();
        addForeign(counter, foreignGroup);
        integrator.setRandomNumberSeed(4); // with which some trials are accepted, in spite of large changes
        integrator.addTorsionMove(1, 0.4);
        integrator.addTorsionMove(1, M_PI);
        integrator.setIntegrationForceGroups(~(1 << 3));
    }
    void begin(const string& platform = "Reference")
    {
        context = make_unique<Context>(chain.system, integrator, Platform::getPlatform(platform));
        context->setPositions(chain.positions);
        integrator.step(1);
        for (int i = 0; i < 60 && describe().find("while its spread is measured") != string::npos; i++)
            integrator.step(1);
        ASSERT(describe().find("while its spread is measured") == string::npos);
    }
    string describe()
    {
        string all;
        for (auto& entry : integrator.getEnergyPlan(*context))
            all += entry.name + ": " + entry.reason + "\n";
        return all;
    }
    long long countTests() const
    {
        long long attempted, accepted, takenBack;
        double mean, deviation;
        integrator.getOuterStatistics(attempted, accepted, takenBack, mean, deviation);
        return attempted;
    }
    BeadChain chain;
    Sampler integrator;
    EvaluationCounter* counter;
    unique_ptr<Context> context;

private:
    void addForeign(Force* force, int group)
    {
        force->setForceGroup(group);
        chain.system.addForce(force);
    }
    static Probe* createProbe(double height)
    {
        Probe* probe = new Probe();
        probe->energy = [height](const vector<Vec3>& x) {
            return height * sin(1000 * x[13][0]);
        };
        return probe;
    }
};

static bool says(const string& text, const string& part)
{
    return text.find(part) != string::npos;
}

/**
 * Find the number of trials to an evaluation by OpenMM that a reason tells of: 1 if it is each trial, 0 if there are
 * none.
 */
static int findInterval(const string& reason)
{
    const size_t begin = reason.find("OpenMM evaluates it");
    if (begin == string::npos)
        return 0;
    const string text = reason.substr(begin);
    if (says(text, "in each trial"))
        return 1;
    const size_t number = text.find(", every ");
    ASSERT(number != string::npos);
    return stoi(text.substr(number + 8));
}

/**
 * Check that OpenMM evaluates each Force as often as the plan says. Returns the plan.
 */
static vector<Sampler::PlannedEnergy> assertCounts(Everything& all)
{
    const int numSteps = 30;
    const auto plan = all.integrator.getEnergyPlan(*all.context);
    all.counter->counts.assign(plan.size(), 0);
    all.integrator.resetMoveStatistics();
    all.integrator.step(numSteps);
    ASSERT(all.describe().find("spread") == string::npos);
    const long long numTests = all.countTests(), computed = all.integrator.getStageStatistics().back().computed;
    for (auto& entry : plan) {
        const int count = all.counter->counts[entry.force], interval = findInterval(entry.reason);
        if (entry.kind == Sampler::NotSampled || entry.force + 1 == (int)plan.size())
            continue; // those without energy are asked, too; the last one counts
        ASSERT_EQUAL(entry.kind == Sampler::Foreign, entry.reason.find("OpenMM evaluates it") == 0);
        if (interval == 0)
            ASSERT_EQUAL(0, count);
        if (interval == 1)
            ASSERT_EQUAL(computed + numSteps, count);
        if (interval > 1) {
            ASSERT_EQUAL(numSteps * ((100 + interval - 1) / interval), numTests);
            ASSERT(count <= numTests + numSteps && count > numSteps); // one is of each step's start
        }
    }
    ASSERT_EQUAL(0, all.counter->counts[5]);
    return plan;
}

static void testAlone(const string& platform)
{
    // Of a Force in a group with all others.

    Everything all(0, true);
    all.begin(platform);
    const auto plan = assertCounts(all);
    ASSERT_EQUAL(Sampler::Constant, plan[1].kind);
    ASSERT_EQUAL(0, findInterval(plan[2].reason));
    ASSERT(says(plan[3].reason, "openmm-chaintree evaluates it at each outer test, every "));
    ASSERT_EQUAL("it has no energy", plan[6].reason);
    ASSERT_EQUAL("its force group is not an integration force group", plan[5].reason);
    const int interval = findInterval(plan[7].reason);
    ASSERT(interval >= 12);
    ASSERT_EQUAL(interval, findInterval(plan[8].reason));
    ASSERT(says(plan[4].reason, ", every " + to_string(interval) + " trials; trials use a stand-in"));
    ASSERT(says(plan[7].reason, ": its expression uses the tabulated function same"));

    // What changes too much is evaluated in each trial, a whole NonbondedForce too.

    ASSERT_EQUAL(1, findInterval(plan[9].reason));
    ASSERT_EQUAL(1, findInterval(plan[10].reason));
    const double energy = all.context->getState(State::Energy, false, ~(1 << 3)).getPotentialEnergy();
    ASSERT_EQUAL_TOL(energy, all.integrator.getPotentialEnergy(*all.context), 1e-5);

    // The user may say otherwise.

    all.integrator.setTrialsPerOuterTest(20);
    const auto chosen = assertCounts(all);
    for (int force : {7, 8, 9, 10})
        ASSERT_EQUAL(20, findInterval(chosen[force].reason));
    all.integrator.setTrialsPerOuterTest(0);
    all.integrator.setNativeEnergies(false);
    const auto plain = assertCounts(all);
    for (int force : {1, 2, 3, 4, 7, 8, 9, 10})
        ASSERT_EQUAL(1, findInterval(plain[force].reason));
    all.integrator.setNativeEnergies(true);
    ASSERT_EQUAL(interval, findInterval(assertCounts(all)[7].reason));

    // Equilibration may have changed what is good.

    all.integrator.renewStandIns(*all.context);
    ASSERT(says(all.describe(), "every 12 trials while its spread is measured"));
}

static void testGroups()
{
    // Where groups are evaluated as a whole: a group of native Forces is, too, and the plan says so.

    WholeGroups wholeGroups;
    for (bool withLargeChanges : {false, true}) {
        Everything all(0, withLargeChanges);
        all.begin();
        const auto plan = assertCounts(all);
        for (int force : {1, 2, 3, 4, 7, 8})
            ASSERT(withLargeChanges ? findInterval(plan[force].reason) == 1 : findInterval(plan[force].reason) >= 12);
        ASSERT(says(plan[7].reason, "OpenMM evaluates it with all of its force group"));
        ASSERT_EQUAL(!withLargeChanges, says(plan[4].reason, "every"));
        const double energy = all.context->getState(State::Energy, false, ~(1 << 3)).getPotentialEnergy();
        ASSERT_EQUAL_TOL(energy, all.integrator.getPotentialEnergy(*all.context), 1e-5);

        // In a group of their own they are alone.

        Everything apart(1, withLargeChanges);
        apart.begin();
        const auto other = assertCounts(apart);
        ASSERT_EQUAL_TOL(apart.context->getState(State::Energy, false, ~(1 << 3)).getPotentialEnergy(),
                         apart.integrator.getPotentialEnergy(*apart.context), 1e-5);
        for (int force : {1, 2, 3, 4})
            ASSERT_EQUAL(0, findInterval(other[force].reason));
        ASSERT(withLargeChanges ? findInterval(other[7].reason) == 1 : findInterval(other[7].reason) >= 12);
        ASSERT(says(other[4].reason, "at each outer test, every "));
    }
}

// ---- As they are ----

/**
 * A Force that remembers how many steps there were, and which nothing can copy.
 */
class Remembering : public Force {
public:
    bool usesPeriodicBoundaryConditions() const
    {
        return false;
    }

protected:
    ForceImpl* createImpl() const;

private:
    class Impl;
};

class Remembering::Impl : public ForceImpl {
public:
    explicit Impl(const Remembering& owner) : owner(owner), numSteps(0)
    {
        forceGroup = owner.getForceGroup();
    }
    void initialize(ContextImpl&)
    {
    }
    const Remembering& getOwner() const
    {
        return owner;
    }
    void updateContextState(ContextImpl&, bool&)
    {
        numSteps++;
    }
    double calcForcesAndEnergy(ContextImpl& context, bool, bool, int groups)
    {
        vector<Vec3> x;
        context.getPositions(x);
        return (groups >> forceGroup & 1) * (100.0 * numSteps + 0.1 * x[13][0]);
    }
    map<string, double> getDefaultParameters()
    {
        return {};
    }
    vector<string> getKernelNames()
    {
        return {};
    }

private:
    const Remembering& owner;
    int numSteps;
};

ForceImpl* Remembering::createImpl() const
{
    return new Impl(*this);
}

/**
 * A foreign Force has the energy that the Context says, after everything that can change it but positions.
 */
static void testPresentForces(const string& platform, bool withMemory)
{
    BeadChain chain(14, 0.3, 2);
    CustomTorsionForce* torsions = new CustomTorsionForce("2*cos(theta)");
    for (int i = 0; i < 11; i++)
        torsions->addTorsion(i, i + 1, i + 2, i + 3);
    CustomCentroidBondForce* spring = new CustomCentroidBondForce(2, "k*distance(g1,g2)^2+table(distance(g1,g2))");
    spring->addGlobalParameter("k", 0.3);
    spring->addGroup({0, 1});
    spring->addGroup({12, 13});
    spring->addBond({0, 1});
    Continuous1DFunction* table = new Continuous1DFunction({0, 1, 0}, 0, 30);
    spring->addTabulatedFunction("table", table);
    HarmonicBondForce* periodic = new HarmonicBondForce();
    periodic->setUsesPeriodicBoundaryConditions(true);
    periodic->addBond(0, 13, 1, 2);
    for (Force* force : vector<Force*>{torsions, spring, periodic})
        chain.system.addForce(force);
    if (withMemory)
        chain.system.addForce(new Remembering());
    chain.system.setDefaultPeriodicBoxVectors(Vec3(40, 0, 0), Vec3(0, 40, 0), Vec3(0, 0, 40));
    Sampler integrator(300);
    integrator.setRandomNumberSeed(2);
    integrator.addTorsionMove(1, 0.4);
    Context context(chain.system, integrator, Platform::getPlatform(platform));
    context.setPositions(chain.positions);
    auto assertPresent = [&] {
        const double energy = context.getState(State::Energy).getPotentialEnergy();
        ASSERT_EQUAL_TOL(energy, integrator.getPotentialEnergy(context), 1e-5);
        return energy;
    };
    double former = assertPresent();
    const vector<function<void()>> changes = {
        [&] {
            integrator.step(3);
        },
        [&] {
            context.setParameter("k", 0.9);
        },
        [&] {
            periodic->setBondParameters(0, 0, 13, 2, 3);
            periodic->updateParametersInContext(context);
        },
        [&] { // as app.Metadynamics does
            table->setFunctionParameters({5, 20, 40}, 0, 30);
            spring->updateParametersInContext(context);
        },
        [&] {
            context.setPeriodicBoxVectors(Vec3(2, 0, 0), Vec3(0, 2, 0), Vec3(0, 0, 2));
        },
        [&] {
            integrator.step(40);
        },
    };
    for (auto& change : changes) {
        change();
        const double energy = assertPresent();
        ASSERT(fabs(energy - former) > 1e-2);
        former = energy;
    }
    ASSERT(integrator.getEnergyPlan(context)[1].reason.find("moves can change all of its 11 terms") == 0);
}

static void testCopies()
{
    // Where groups are evaluated as a whole, copies are evaluated in an inner Context, if all can be copied.

    WholeGroups wholeGroups("copies");
    for (bool withMemory : {false, true})
        testPresentForces("Reference", withMemory);
    for (bool withForeignOnly : {false, true}) {
        BeadChain chain(14, 0.3, 2);
        CustomTorsionForce* torsions = new CustomTorsionForce("2*cos(theta)");
        for (int i = 0; i < 11; i++)
            torsions->addTorsion(i, i + 1, i + 2, i + 3);
        CustomCentroidBondForce* spring = new CustomCentroidBondForce(2, "0.01*same(distance(g1,g2))^2");
        spring->addTabulatedFunction("same",
                                     new Continuous1DFunction({0, 30}, 0, 30)); // so that only OpenMM can evaluate it
        spring->addGroup({0, 1});
        spring->addGroup({12, 13});
        spring->addBond({0, 1});
        NonbondedForce* nonbonded = createNonbonded(14, 3);
        nonbonded->setNonbondedMethod(NonbondedForce::CutoffPeriodic);
        nonbonded->setCutoffDistance(2);
        chain.system.setDefaultPeriodicBoxVectors(Vec3(40, 0, 0), Vec3(0, 40, 0), Vec3(0, 0, 40));
        EvaluationCounter* counter = new EvaluationCounter();
        counter->setForceGroup(4);
        if (!withForeignOnly)
            chain.system.addForce(torsions);
        for (Force* force : vector<Force*>{spring, nonbonded, counter})
            chain.system.addForce(force);
        if (withForeignOnly) {
            torsions->setForceGroup(4);
            chain.system.addForce(torsions);
        }
        Sampler integrator(300);
        integrator.setRandomNumberSeed(3);
        integrator.addTorsionMove(1, 0.4);
        integrator.setIntegrationForceGroups(1 | 2);
        Context context(chain.system, integrator, Platform::getPlatform("Reference"));
        context.setPositions(chain.positions);
        integrator.step(20);
        const int first = withForeignOnly ? 1 : 2;
        counter->counts.assign(counter->counts.size(), 0);
        integrator.step(3);
        auto plan = integrator.getEnergyPlan(context);
        ASSERT_EQUAL(!withForeignOnly, says(plan[first].reason, ", by a copy: "));
        ASSERT_EQUAL(!withForeignOnly, says(plan[first + 1].reason, ", by a copy: "));
        for (int force : {first, first + 1})
            ASSERT_EQUAL(withForeignOnly, counter->counts[force] > 0);
        const double energy = context.getState(State::Energy, false, 1 | 2).getPotentialEnergy();
        ASSERT_EQUAL_TOL(energy, integrator.getPotentialEnergy(context), 1e-5);
    }
}

static void testSharedGroup()
{
    // While they are measured, Forces of a group that is evaluated as a whole count once.

    WholeGroups wholeGroups;
    BeadChain chain(14, 0.3, 2);
    for (int i = 0; i < 2; i++) {
        Probe* probe = new Probe();
        probe->energy = [](const vector<Vec3>& x) {
            return 0.01 * x[13][0];
        };
        probe->setForceGroup(1);
        chain.system.addForce(probe);
    }
    Sampler integrator(300);
    integrator.setRandomNumberSeed(1);
    integrator.addTorsionMove(1, 0.4);
    integrator.setTrialsPerStep(12);
    Context context(chain.system, integrator, Platform::getPlatform("Reference"));
    context.setPositions(chain.positions);
    integrator.step(1);
    long long attempted, accepted, takenBack;
    double mean, deviation;
    integrator.getOuterStatistics(attempted, accepted, takenBack, mean, deviation);
    ASSERT_EQUAL(1, attempted);
    ASSERT_EQUAL(1, accepted);
    const double shift = getPositions(context)[13][0] - chain.positions[13][0];
    ASSERT(shift != 0);
    ASSERT_EQUAL_TOL(0.02 * shift, mean, 1e-9);
}

static void testOneStepATest()
{
    // Steps of one trial.

    Everything all(0, false);
    all.integrator.setTrialsPerStep(1);
    all.begin();
    ASSERT(says(all.integrator.getEnergyPlan(*all.context)[7].reason, "at each outer test, every trial"));
}

int main()
{
    return runOnPlatform("Reference", [](Platform&) {
        for (int i = 0; i < Platform::getNumPlatforms(); i++) {
            const string name = Platform::getPlatform(i).getName();
            if (name != "Reference" && name != "CPU")
                continue;
            testAlone(name);
            testPresentForces(name, true);
        }
        testGroups();
        testCopies();
        testSharedGroup();
        testOneStepATest();
    });
}
