/**
 * This tests the translation of CustomNonbondedForces against OpenMM: what they become, by plain sums in double, and
 * what the scene makes of that.
 */

#include "NativeEnergySupport.h"
#include "openmm/CustomNonbondedForce.h"
#include "openmm/TabulatedFunction.h"
#include "PlainEnergies.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static const int NUM_BEADS = NativeScene::NUM_BEADS;

/**
 * Make a Force of an expression of r, the parameters a, b and kind of each particle, and the global parameters half and
 * minus.
 */
static CustomNonbondedForce* createPairs(const string& expression)
{
    OddNumbers numbers(4);
    CustomNonbondedForce* force = new CustomNonbondedForce(expression);
    force->addPerParticleParameter("a");
    force->addGlobalParameter("half", 0.5);
    force->addPerParticleParameter("b");
    force->addPerParticleParameter("kind");
    force->addGlobalParameter("minus", -1.25);
    for (int i = 0; i < NUM_BEADS; i++)
        force->addParticle({numbers.between(0.1, 0.9), numbers.between(-0.9, 0.9), (double)(i % 3)});
    for (int i = 0; i + 2 < NUM_BEADS; i += 2) {
        force->addExclusion(i, i + 1);
        force->addExclusion(i + 2, i);
    }
    return force;
}

/**
 * Check that a Force is native, and that its energy is that of OpenMM.
 */
static void assertNative(CustomNonbondedForce* force, const map<string, double>& parameters = {})
{
    NativeScene scene;
    const int index = scene.add(force);
    scene.build();
    for (auto& parameter : parameters)
        scene.context->setParameter(parameter.first, parameter.second);
    scene.plan->translate(-1, true, TorsionMonteCarloIntegrator::Hard);
    const EnergyPlan::Entry& entry = scene.plan->getEntries()[index];
    if (entry.kind != EnergyPlan::Native)
        throw OpenMMException("it is not native: " + entry.reason);
    const EnergyTerms& terms = scene.plan->getTerms();
    ASSERT_EQUAL(1, terms.pairSets.size());
    ASSERT_EQUAL(index, terms.pairSets[0].force);
    const double expected = scene.context->getState(State::Energy, false, entry.groups).getPotentialEnergy();
    ASSERT(fabs(expected) > 1e-3);
    ASSERT_EQUAL_TOL(expected, computePlainEnergy(terms.pairSets[0], scene.chain.positions), 1e-10);

    // The scene's pairs are in single precision.

    scene.getEnergy().setTerms(terms);
    scene.assertAgreement(index, 5e-5);
}

static void assertForeign(CustomNonbondedForce* force, const string& reason)
{
    NativeScene scene;
    scene.chain.system.setDefaultPeriodicBoxVectors(Vec3(9, 0, 0), Vec3(0, 9, 0), Vec3(0, 0, 9));
    const int index = scene.add(force);
    scene.makePlan();
    const EnergyPlan::Entry& entry = scene.plan->getEntries()[index];
    if (entry.kind != EnergyPlan::Foreign || entry.reason != reason)
        throw OpenMMException("expected \"" + reason + "\", found \"" + entry.reason + "\"");
    ASSERT_EQUAL(0, scene.plan->getTerms().pairSets.size());
}

void testExpressions()
{
    for (const string expression :
         {"4*eps*(s^12-s^6); s=sigma/r; eps=sqrt(a1*a2); sigma=half*(a1+a2)", "138.935*b1*b2/r*exp(minus*r)",
          "select(step(r-2), b1*b2, (b1+b2)*r)", "delta(kind1-kind2)*r^2+min(a1,a2)", "half*minus", "r", "a1+a2",
          "exp(-r)*erfc(half*r)*tanh(b1*b2)+max(b1,b2)"})
        try {
            assertNative(createPairs(expression));
            assertNative(createPairs(expression), {{"half", 0.75}, {"minus", -0.5}});
        }
        catch (const exception& error) {
            throw OpenMMException(expression + ": " + error.what());
        }
}

/**
 * Models of beads that users write: short ranges of a hydropathy scale, and screened charges.
 */
void testBeadModel()
{
    CustomNonbondedForce* force = createPairs(
        "select(step(r-2^(1/6)*sigma), lambda*lj, lj+(1-lambda)*epsilon)+138.935*b1*b2/(80*r)*(exp(-r/debye)-0.01);"
        "lj=4*epsilon*((sigma/r)^12-(sigma/r)^6); sigma=a1+a2; lambda=half*(a1+a2); epsilon=0.8368; debye=0.8");
    force->setNonbondedMethod(CustomNonbondedForce::CutoffNonPeriodic);
    force->setCutoffDistance(2.2);
    assertNative(force);
}

void testCutoffs()
{
    const string expression = "b1*b2/r";
    for (double switchingDistance : {-1.0, 0.0, 0.8, 1.79})
        for (bool hasCutoff : {false, true}) {
            CustomNonbondedForce* force = createPairs(expression);
            force->setCutoffDistance(1.8);
            if (hasCutoff)
                force->setNonbondedMethod(CustomNonbondedForce::CutoffNonPeriodic);
            force->setUseSwitchingFunction(switchingDistance >= 0);
            force->setSwitchingDistance(switchingDistance);
            force->setUseLongRangeCorrection(true); // without a meaning unless it is periodic
            assertNative(force);
        }
    CustomNonbondedForce* periodic = createPairs(expression);
    periodic->setNonbondedMethod(CustomNonbondedForce::CutoffPeriodic);
    assertForeign(periodic, "its cutoff is periodic");
}

void testComputedValues()
{
    CustomNonbondedForce* force = createPairs("root1*root2/r+b1*b2*other1*other2");
    force->addTabulatedFunction("table", new Discrete1DFunction({0.5, 0.75, 3}));
    force->addComputedValue("root", "sqrt(a)*half");
    force->addComputedValue("other", "table(kind)+minus");
    assertNative(force);
    assertNative(createPairs("b1*b2*r"), {{"half", 2}});
    CustomNonbondedForce* withDerivative = createPairs("half*b1*b2*r");
    withDerivative->addEnergyParameterDerivative("half");
    assertNative(withDerivative);
}

void testGroups()
{
    vector<set<int>> sets(3);
    for (int i = 0; i < 10; i++)
        sets[0].insert(i);
    for (int i = 4; i < NUM_BEADS; i++)
        sets[1].insert(i);
    sets[2] = {2, 3, 11};
    for (bool hasCutoff : {false, true}) {
        CustomNonbondedForce* force = createPairs("b1*b2/r");
        force->addInteractionGroup(sets[0], sets[1]);
        force->addInteractionGroup(sets[2], sets[2]);
        force->addInteractionGroup(sets[2], sets[0]);
        force->setCutoffDistance(2.5);
        if (hasCutoff)
            force->setNonbondedMethod(CustomNonbondedForce::CutoffNonPeriodic);
        assertNative(force);
    }
}

void testTables()
{
    OddNumbers numbers(6);
    auto values = [&](int size) {
        vector<double> values(size);
        for (double& value : values)
            value = numbers.between(-2, 2);
        return values;
    };
    auto periodic = [&](int sizeX, int sizeY) {
        vector<double> all = values(sizeX * sizeY);
        for (int j = 0; j < sizeY; j++)
            all[sizeX - 1 + sizeX * j] = all[sizeX * j];
        for (int i = 0; i < sizeX; i++)
            all[i + sizeX * (sizeY - 1)] = all[i];
        return all;
    };
    auto symmetric = [&](int size) {
        vector<double> all = values(size * size);
        for (int i = 0; i < size; i++)
            for (int j = 0; j < i; j++)
                all[i + size * j] = all[j + size * i];
        return all;
    };
    auto assertTable = [&](const string& expression, TabulatedFunction* function) {
        CustomNonbondedForce* force = createPairs(expression);
        force->addTabulatedFunction("unused", new Discrete1DFunction({1, 2}));
        force->addTabulatedFunction("f", function);
        force->addTabulatedFunction("unused3", new Continuous3DFunction(2, 2, 2, values(8), 0, 1, 0, 1, 0, 1));
        try {
            assertNative(force);
        }
        catch (const exception& error) {
            throw OpenMMException(expression + ": " + error.what());
        }
    };
    assertTable("f(r)", new Continuous1DFunction(values(9), 0.7, 2.9)); // nothing beyond
    assertTable("f(r)", new Continuous1DFunction(values(2), 0.0, 9.0));
    assertTable("f(r)*b1*b2", new Continuous1DFunction(periodic(8, 1), 0.1, 0.9, true));
    assertTable("f(r,half*(a1+a2))", new Continuous2DFunction(7, 5, values(35), 0.5, 4, 0.2, 0.8));
    assertTable("f(r,b1*b2)", new Continuous2DFunction(6, 4, periodic(6, 4), 0.5, 1.5, 0.1, 0.3, true));
    assertTable("f(kind1+kind2)/r", new Discrete1DFunction(values(5)));
    assertTable("f(kind1,kind2)/r+r*f(kind1,kind2)", new Discrete2DFunction(3, 3, symmetric(3)));
    assertTable("f(floor(min(r,3)),kind1+kind2,1)*r", new Discrete3DFunction(4, 5, 2, values(40)));
    assertTable("f(kind1+kind2-1)/r", new Discrete1DFunction(values(2))); // what is outside is brought to the end
    assertTable("f(kind1,5*kind2)+f(kind2,5*kind1)", new Discrete2DFunction(2, 7, values(14)));
    assertTable("f(half+half)*r+f(minus+1.25)", new Discrete1DFunction({0.5, 1.5}));
    assertTable("f(f(r))", new Continuous1DFunction(values(6), -3, 4));

    // Where no index can be outside, nothing is done about it.

    NativeScene scene;
    CustomNonbondedForce* types = createPairs("f(kind1,kind2)");
    types->addTabulatedFunction("f", new Discrete2DFunction(3, 3, symmetric(3)));
    scene.add(types);
    scene.makePlan();
    ASSERT_EQUAL(3, scene.plan->getTerms().pairSets[0].operations.size());

    CustomNonbondedForce* force = createPairs("f(r,a1+a2,1)");
    force->addTabulatedFunction("f", new Continuous3DFunction(2, 2, 2, values(8), 0, 1, 0, 1, 0, 1));
    assertForeign(force, "its expression uses the tabulated function f");
}

void testOrder()
{
    const string reason = "its expression is not the same in either order of two particles";
    assertForeign(createPairs("a1*r+a2*r^2"), reason);
    assertForeign(createPairs("b1*b2*r+step(kind1-1.5)*delta(kind2)"), reason);
    CustomNonbondedForce* force = createPairs("f(kind1,kind2)*r");
    force->addTabulatedFunction("f", new Discrete2DFunction(3, 3, {0, 1, 2, 1, 0, 5, 2, 5.0001, 0}));
    assertForeign(force, reason);
    assertNative(createPairs("(a1+b2)*(b1+a2)*r"));
}

int main()
{
    return runOnPlatform("Reference", [](Platform&) {
        testExpressions();
        testBeadModel();
        testCutoffs();
        testComputedValues();
        testGroups();
        testTables();
        testOrder();
    });
}
