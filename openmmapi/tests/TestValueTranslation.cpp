/**
 * This tests CustomGBForces that are no generalized Born model: what they become, against OpenMM, what is said of them,
 * and which of them are left to OpenMM.
 */

#include "NativeEnergySupport.h"
#include "openmm/CustomGBForce.h"
#include "openmm/TabulatedFunction.h"
#include "openmmchaintree/internal/ForceTranslation.h"
#include <functional>
#include <limits>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static const int NUM_BEADS = NativeScene::NUM_BEADS;

typedef CustomGBForce Form;

/**
 * Make a Force of these values and terms, of the parameters q and s and the global parameter scale.
 */
class Description {
public:
    class Part {
    public:
        string expression;
        Form::ComputationType type;
    };
    CustomGBForce* create() const
    {
        OddNumbers numbers(5);
        CustomGBForce* force = new CustomGBForce();
        force->addPerParticleParameter("q");
        force->addGlobalParameter("scale", 0.75);
        force->addPerParticleParameter("s");
        for (size_t i = 0; i < values.size(); i++)
            force->addComputedValue("v" + to_string(i), values[i].expression, values[i].type);
        for (const Part& term : terms)
            force->addEnergyTerm(term.expression, term.type);
        for (int i = 0; i < NUM_BEADS; i++)
            force->addParticle({numbers.between(-1, 1), numbers.between(0.2, 0.9)});
        for (int i = 0; i + 2 < NUM_BEADS; i++)
            force->addExclusion(i, i + 1 + i % 2);
        edit(*force);
        return force;
    }
    vector<Part> values = {{"s1*exp(-r/s2)", Form::ParticlePair}};
    vector<Part> terms = {{"q^2*v0", Form::SingleParticle}};
    function<void(CustomGBForce&)> edit = [](CustomGBForce&) {
    };
};

static EnergyPlan::Entry plan(NativeScene& scene, Force* force)
{
    const int index = scene.add(force);
    scene.build();
    return scene.plan->getEntries()[index];
}

/**
 * Check that a Force is native, and that its energy is that of OpenMM.
 */
static double assertNative(const Description& description)
{
    NativeScene scene;
    const EnergyPlan::Entry entry = plan(scene, description.create());
    if (entry.kind != EnergyPlan::Native)
        throw OpenMMException("it is not native: " + entry.reason);
    ASSERT_EQUAL(1, scene.plan->getTerms().valueEnergies.size());
    const double expected = scene.computeOpenMMEnergy(entry.groups), found = scene.computeEnergies()[1];
    ASSERT(fabs(expected) > 1e-3);
    if (fabs(found - expected) > 1e-6 * (1 + fabs(expected)))
        throw OpenMMException(to_string(found) + ", not " + to_string(expected));
    return found;
}

static void assertForeign(const Description& description, const string& reason)
{
    NativeScene scene;
    scene.chain.system.setDefaultPeriodicBoxVectors(Vec3(99, 0, 0), Vec3(0, 99, 0), Vec3(0, 0, 99));
    const EnergyPlan::Entry entry = plan(scene, description.create());
    if (entry.kind != EnergyPlan::Foreign || entry.reason != reason)
        throw OpenMMException("expected \"" + reason + "\", found \"" + entry.reason + "\"");
    ASSERT_EQUAL(0, scene.plan->getTerms().valueEnergies.size());
}

void testForms()
{
    Description form;
    double energy = assertNative(form);
    form.values[0].type = Form::ParticlePairNoExclusions;
    ASSERT(fabs(assertNative(form) - energy) > 1e-3);
    form.values.push_back({"tanh(v0)*s+x-0.5*z", Form::SingleParticle});
    form.values.push_back({"v1*v0+scale*q*y", Form::SingleParticle});
    form.terms.push_back({"v2+x*y*z", Form::SingleParticle});
    energy = assertNative(form);
    form.terms.push_back({"q1*q2*v11*v12/(r+v01^2+v02^2)", Form::ParticlePair});
    const double withPairs = assertNative(form);
    ASSERT(fabs(withPairs - energy) > 1e-3);
    form.terms.back().type = Form::ParticlePairNoExclusions;
    ASSERT(fabs(assertNative(form) - withPairs) > 1e-3);
    form.terms = {form.terms[2]};
    assertNative(form);

    // Roots of products of values that may be negative.

    form.values = {{"q2*exp(-r)", Form::ParticlePair}};
    form.terms = {{"sqrt(v01*v01*v02*v02+s1*s2*r)", Form::ParticlePair}, {"sqrt(v0*v0)", Form::SingleParticle}};
    assertNative(form);
    form.terms = {{"select(step(v01*v02), sqrt(step(v01*v02)*v01*v02), -r)", Form::ParticlePair}};
    assertNative(form);
}

void testCutoffs()
{
    Description form;
    form.terms.push_back({"exp(-0.5*r)*v01*v02", Form::ParticlePairNoExclusions});
    const double whole = assertNative(form);
    for (double cutoff : {1.5, 2.2, 3.1}) {
        form.edit = [=](CustomGBForce& force) {
            force.setNonbondedMethod(Form::CutoffNonPeriodic);
            force.setCutoffDistance(cutoff);
        };
        ASSERT(fabs(assertNative(form) - whole) > 1e-3);
    }
}

void testTables()
{
    Description form;
    form.values[0].expression = "line(r)*s2+step2(floor(2*s1+r), 1)";
    form.terms = {{"line(v0)+patch(s, v0-floor(v0))", Form::SingleParticle},
                  {"line(v01)*line(v02)*line(r)", Form::ParticlePair}};
    form.edit = [](CustomGBForce& force) {
        vector<double> line = {1, 3, 2, 4, 1.5, 0.5, 2.5}, patch(9);
        for (int i = 0; i < 9; i++)
            patch[i] = i * i % 7;
        force.addTabulatedFunction("line", new Continuous1DFunction(line, 0, 9));
        force.addTabulatedFunction("patch", new Continuous2DFunction(3, 3, patch, 0, 1, 0, 1));
        force.addTabulatedFunction("step2", new Discrete2DFunction(5, 2, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}));
    };
    assertNative(form);
}

/**
 * Debye-Hueckel charges that neighbours weaken, and Gaussian solvent exclusion as in EEF1.
 */
void testKnownModels()
{
    Description screened;
    screened.values = {{"exp(-(r/0.6)^2)", Form::ParticlePair},
                       {"q/(1+0.3*v0)", Form::SingleParticle}}; // how buried, and the charge that is left
    screened.terms = {{"138.935485/78.5*v11*v12*exp(-r/0.8)/r", Form::ParticlePair}, {"2*v0^2", Form::SingleParticle}};
    assertNative(screened);
    Description exclusion;
    exclusion.values = {{"s2^3/(2*3.14159265^1.5*s1*r^2)*exp(-((r-s1)/0.6)^2)", Form::ParticlePair}};
    exclusion.terms = {{"-q*(1-v0)", Form::SingleParticle}};
    assertNative(exclusion);
}

void testReasons()
{
    NativeScene scene;
    const EnergyPlan::Entry entry = plan(scene, Description().create());
    vector<int> counts;
    scene.plan->setChangeableTerms(counts, true);
    const EnergyPlan::Entry& told = scene.plan->getEntries()[1];
    ASSERT_EQUAL(EnergyPlan::Native, told.kind);
    ASSERT_EQUAL("it needs a NonbondedForce that openmm-chaintree evaluates, too", told.reason);
    scene.plan->setChangeableTerms(counts, false);
    ASSERT_EQUAL(EnergyPlan::Constant, told.kind);
    ASSERT_EQUAL("nothing moves", told.reason);
}

void testForeign()
{
    Description form;
    form.edit = [](CustomGBForce& force) {
        force.setNonbondedMethod(Form::CutoffPeriodic);
    };
    assertForeign(form, "its cutoff is periodic");
    form.edit = [](CustomGBForce& force) {
        force.addTabulatedFunction("cube", new Continuous3DFunction(2, 2, 2, vector<double>(8, 1), 0, 1, 0, 1, 0, 1));
    };
    assertNative(form); // nobody reads it
    form.terms[0].expression = "v0*cube(q, q, q)";
    assertForeign(form, "its expression uses the tabulated function cube");
    form = Description();
    form.terms.push_back({"v01*v02^2", Form::ParticlePair});
    assertForeign(form, "its expression is not the same in either order of two particles");
    form.terms.back().type = Form::ParticlePairNoExclusions;
    assertForeign(form, "its expression is not the same in either order of two particles");
    form = Description();
    form.edit = [](CustomGBForce& force) {
        force.setParticleParameters(3, {numeric_limits<double>::quiet_NaN(), 1});
    };
    assertForeign(form, "one of its parameters is infinite or not a number");

    // What a Context would refuse, but what a Force may have become since.

    EnergyTerms terms;
    const NativeForceKind::Parameters parameters = {{"scale", 1}};
    System system;
    for (int i = 0; i < NUM_BEADS; i++)
        system.addParticle(1);
    auto assertRefused = [&](const Description& description, const string& reason) {
        unique_ptr<CustomGBForce> force(description.create());
        const string found = translateForce(*force, 0, system, parameters, terms);
        if (found != reason)
            throw OpenMMException("expected \"" + reason + "\", found \"" + found + "\"");
        ASSERT_EQUAL(0, terms.valueEnergies.size());
    };
    form = Description();
    form.values = {{"v1*r", Form::ParticlePair}, {"v0", Form::SingleParticle}};
    assertRefused(form, "its expression has an unknown variable, v1");
    form.values = {{"v11*r", Form::ParticlePair}, {"v0", Form::SingleParticle}};
    assertRefused(form, "its expression has an unknown variable, v11");
    form = Description();
    form.edit = [](CustomGBForce& force) {
        force.addExclusion(2, NUM_BEADS);
    };
    assertRefused(form, "there is no particle 15");
    form.edit = [](CustomGBForce& force) {
        force.addParticle({1, 1});
    };
    assertRefused(form, "it has not as many particles as the System");
    form.edit = [](CustomGBForce& force) {
        force.addPerParticleParameter("x");
        for (int i = 0; i < NUM_BEADS; i++)
            force.setParticleParameters(i, {1, 1, 1});
    };
    assertRefused(form, "the name x means two things in its expression");
    form.edit = [](CustomGBForce& force) {
        force.setNonbondedMethod(Form::CutoffNonPeriodic);
        force.setCutoffDistance(0);
    };
    assertRefused(form, "its cutoff makes no sense");
}

int main()
{
    return runOnPlatform("Reference", [](Platform&) {
        testForms();
        testCutoffs();
        testTables();
        testKnownModels();
        testReasons();
        testForeign();
    });
}
