/**
 * This tests the translation of generalized Born: how CustomGBForces are recognized, whatever their text, and what they
 * and GBSAOBCForces become, by plain sums in double, against OpenMM.
 */

#include "NativeEnergySupport.h"
#include "openmm/CustomGBForce.h"
#include "openmm/GBSAOBCForce.h"
#include "openmm/TabulatedFunction.h"
#include "PlainEnergies.h"
#include <array>
#include <cmath>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static const int NUM_BEADS = NativeScene::NUM_BEADS;

/**
 * The texts of a model. Those given here are of OBC2, as the application layer of OpenMM writes it.
 */
class Texts {
public:
    string sum = "select(step(r+sr2-or1), 0.5*(1/L-1/U+0.25*(r-sr2^2/r)*(1/(U^2)-1/(L^2))+0.5*log(L/U)/r), 0);"
                 "U=r+sr2; L=max(or1, D); D=abs(r-sr2)";
    string radius = "1/(1/or-tanh(psi-0.8*psi^2+4.85*psi^3)/radius); psi=I*or; radius=or+offset; offset=0.009";
    string self = "-0.5*138.935485*(1/soluteDielectric-1/solventDielectric)*charge^2/B; solventDielectric=78.5;"
                  "soluteDielectric=1; kappa=0; offset=0.009";
    string surface = "28.3919551*(radius+0.14)^2*(radius/B)^6; radius=or+offset; offset=0.009";
    string pairs = "-138.935485*(1/soluteDielectric-1/solventDielectric)*charge1*charge2/f;"
                   "f=sqrt(r^2+B1*B2*exp(-r^2/(4*B1*B2))); solventDielectric=78.5; soluteDielectric=1";
    string sumName = "I", radiusName = "B";
    double cutoff = 0;
};

static const string NECK = "Ivdw+neckScale*Ineck;"
                           "Ineck=step(radius1+radius2+neckCut-r)*getm0(radindex1,radindex2)/"
                           "(1+100*(r-getd0(radindex1,radindex2))^2+0.3*1000000*(r-getd0(radindex1,radindex2))^6);"
                           "Ivdw=select(step(r+sr2-or1), 0.5*(1/L-1/U+0.25*(r-sr2^2/r)*(1/(U^2)-1/(L^2))+"
                           "0.5*log(L/U)/r), 0); U=r+sr2; L=max(or1, D); D=abs(r-sr2);"
                           "radius1=or1+offset; radius2=or2+offset; neckScale=0.826836; neckCut=0.68; offset=0.0195141";
static const string NECK_RADIUS = "1/(1/or-tanh(alpha*psi-beta*psi^2+gamma*psi^3)/radius);"
                                  "psi=I*or; radius=or+offset; offset=0.0195141";
static const string SCREENED = "-0.5*138.935485*(1/soluteDielectric-exp(-kappa*B)/solventDielectric)*charge^2/B;"
                               "solventDielectric=78.5; soluteDielectric=2; kappa=0.7";
static const string SCREENED_PAIRS =
    "-138.935485*(1/soluteDielectric-exp(-kappa*f)/solventDielectric)*charge1*charge2/f;"
    "f=sqrt(r^2+B1*B2*exp(-r^2/(4*B1*B2)));"
    "solventDielectric=78.5; soluteDielectric=2; kappa=0.7";

static CustomGBForce* createForce(const Texts& texts)
{
    OddNumbers numbers(5);
    CustomGBForce* force = new CustomGBForce();
    for (const char* name : {"charge", "or", "sr", "alpha", "beta", "gamma", "radindex"})
        force->addPerParticleParameter(name);
    force->addGlobalParameter("scale", 0.75);
    const int size = 3;
    vector<double> heights(size * size), distances(size * size);
    for (int i = 0; i < size * size; i++) {
        heights[i] = numbers.between(0.1, 0.3);
        distances[i] = numbers.between(0.2, 0.5);
    }
    force->addTabulatedFunction("getd0", new Discrete2DFunction(size, size, distances));
    force->addTabulatedFunction("getm0", new Discrete2DFunction(size, size, heights));
    force->addComputedValue(texts.sumName, texts.sum, CustomGBForce::ParticlePairNoExclusions);
    force->addComputedValue(texts.radiusName, texts.radius, CustomGBForce::SingleParticle);
    force->addEnergyTerm(texts.self, CustomGBForce::SingleParticle);
    if (!texts.surface.empty())
        force->addEnergyTerm(texts.surface, CustomGBForce::SingleParticle);
    force->addEnergyTerm(texts.pairs, CustomGBForce::ParticlePairNoExclusions);
    for (int i = 0; i < NUM_BEADS; i++)
        force->addParticle({numbers.between(-1, 1), i % 3 == 0 ? 0.2 : numbers.between(0.2, 0.5),
                            numbers.between(-0.1, 0.4), numbers.between(0.5, 1), numbers.between(0.3, 0.8),
                            numbers.between(0.2, 5), (double)(float)(i % size)});
    if (texts.cutoff > 0) {
        force->setNonbondedMethod(CustomGBForce::CutoffNonPeriodic);
        force->setCutoffDistance(texts.cutoff);
    }
    return force;
}

static NonbondedForce* createNonbonded()
{
    NonbondedForce* force = new NonbondedForce();
    for (int i = 0; i < NUM_BEADS; i++)
        force->addParticle(0.1, 0.3, 1);
    return force;
}

/**
 * Check that a Force is native, and that its energy is that of OpenMM. Returns what it has become.
 */
static EnergyTerms::Born assertNative(Force* force)
{
    NativeScene scene;
    const int index = scene.add(force); // before what it needs
    scene.add(createNonbonded());
    scene.makePlan();
    const EnergyPlan::Entry& entry = scene.plan->getEntries()[index];
    if (entry.kind != EnergyPlan::Native)
        throw OpenMMException("it is not native: " + entry.reason);
    const EnergyTerms& terms = scene.plan->getTerms();
    ASSERT_EQUAL(1, terms.born.size());
    ASSERT_EQUAL(index, terms.born[0].force);
    for (double factor : {1.0, 0.8, 1.5}) {
        vector<Vec3> positions = scene.chain.positions;
        for (Vec3& position : positions)
            position *= factor;
        scene.context->setPositions(positions);
        const double expected = scene.context->getState(State::Energy, false, entry.groups).getPotentialEnergy();
        ASSERT(fabs(expected) > 1);
        ASSERT_EQUAL_TOL(expected, computePlainEnergy(terms.born[0], positions), 1e-10);
    }
    return terms.born[0];
}

static EnergyTerms::Born assertNative(const Texts& texts)
{
    return assertNative(createForce(texts));
}

static void assertForeign(Force* force, const string& reason, bool hasNonbonded = true)
{
    NativeScene scene;
    scene.chain.system.setDefaultPeriodicBoxVectors(Vec3(99, 0, 0), Vec3(0, 99, 0), Vec3(0, 0, 99));
    if (hasNonbonded)
        scene.add(createNonbonded());
    const int index = scene.add(force);
    scene.makePlan();
    const EnergyPlan::Entry& entry = scene.plan->getEntries()[index];
    if (entry.kind != EnergyPlan::Foreign || entry.reason != reason)
        throw OpenMMException("expected \"" + reason + "\", found \"" + entry.reason + "\"");
    ASSERT_EQUAL(0, scene.plan->getTerms().born.size());
}

/**
 * Check that a Force is native as one of values, for a reason, and that its energy is that of OpenMM.
 */
static void assertWhole(Force* force, const string& reason, bool hasNonbonded = true)
{
    NativeScene scene;
    if (hasNonbonded)
        scene.add(createNonbonded());
    const int index = scene.add(force);
    scene.build();
    const EnergyPlan::Entry& entry = scene.plan->getEntries()[index];
    if (entry.kind != EnergyPlan::Native)
        throw OpenMMException("it is not native: " + entry.reason);
    const EnergyTerms& terms = scene.plan->getTerms();
    ASSERT_EQUAL(0, terms.born.size());
    ASSERT_EQUAL(1, terms.valueEnergies.size());
    if (terms.valueEnergies[0].reason != reason)
        throw OpenMMException("expected \"" + reason + "\", found \"" + terms.valueEnergies[0].reason + "\"");
    const double expected = scene.context->getState(State::Energy, false, entry.groups).getPotentialEnergy();
    const double found = scene.computeEnergies()[index];
    if (isfinite(expected) || isfinite(found))
        ASSERT_EQUAL_TOL(expected, found, 1e-6);
}

static void assertUnknown(const Texts& texts, const string& what)
{
    assertWhole(createForce(texts),
                "its " + what + " is not that of a generalized Born model that openmm-chaintree knows");
}

// ---- What is recognized ----

/**
 * Replace a part of a text.
 */
static string edit(string text, const string& part, const string& other)
{
    const size_t at = text.find(part);
    if (at == string::npos)
        throw OpenMMException("there is no " + part + " in " + text);
    return text.replace(at, part.size(), other);
}

void testModels()
{
    Texts texts;
    EnergyTerms::Born born = assertNative(texts);
    ASSERT(born.rescaled);
    ASSERT_EQUAL(0, born.numNeckTypes);
    ASSERT_EQUAL_TOL(78.5, born.solventDielectric, 1e-12);
    ASSERT_EQUAL_TOL(1, born.soluteDielectric, 1e-12);
    ASSERT_EQUAL_TOL(28.3919551, born.surfaceEnergy, 1e-12);
    ASSERT_EQUAL(0.14, born.probeRadius);
    ASSERT_EQUAL(0, born.kappa);
    for (int i = 0; i < NUM_BEADS; i++) {
        ASSERT_EQUAL_TOL(born.offsetRadii[i] + 0.009, born.radii[i], 1e-12);
        ASSERT_EQUAL_TOL(1, born.alphas[i], 1e-12);
        ASSERT_EQUAL_TOL(0.8, born.betas[i], 1e-12);
        ASSERT_EQUAL_TOL(4.85, born.gammas[i], 1e-12);
    }
    texts.radius = "1/(1/or-tanh(0.8*psi+2.909125*psi^3)/radius); psi=I*or; radius=or+offset; offset=0.009";
    ASSERT_EQUAL(0, assertNative(texts).betas[3]);
    texts.radius = "1/(1/or-I)";
    ASSERT(!assertNative(texts).rescaled);
    texts.surface = "";
    ASSERT_EQUAL(0, assertNative(texts).surfaceEnergy);
    texts.sum = NECK;
    assertUnknown(texts, "neck"); // without the whole radius
    texts.radius = NECK_RADIUS;
    born = assertNative(texts);
    ASSERT_EQUAL(3, born.numNeckTypes);
    ASSERT_EQUAL_TOL(0.68, born.neckCut, 1e-12);
    texts.surface = Texts().surface;
    assertUnknown(texts, "surface"); // of other radii
}

void testScreening()
{
    Texts texts;
    texts.self = SCREENED;
    texts.pairs = SCREENED_PAIRS;
    const EnergyTerms::Born born = assertNative(texts);
    ASSERT_EQUAL_TOL(0.7, born.kappa, 1e-12);
    ASSERT_EQUAL_TOL(2, born.soluteDielectric, 1e-12);
    ASSERT_EQUAL_TOL(78.5, born.solventDielectric, 1e-12);
    texts.surface = "";
    assertNative(texts);
}

void testCutoffs()
{
    Texts texts;
    texts.cutoff = 2.5;
    assertNative(texts); // no shift
    for (const string& pairs : {Texts().pairs, SCREENED_PAIRS}) {
        texts.pairs = pairs;
        texts.pairs.replace(pairs.find("/f;"), 3, "*(1/f-0.4);");
        texts.self = pairs == SCREENED_PAIRS ? SCREENED : texts.self;
        const EnergyTerms::Born born = assertNative(texts);
        ASSERT_EQUAL_TOL(0.4, born.shift, 1e-12);
        ASSERT_EQUAL(2.5, born.cutoff);
    }
    CustomGBForce* periodic = createForce(texts);
    periodic->setNonbondedMethod(CustomGBForce::CutoffPeriodic);
    assertForeign(periodic, "its cutoff is periodic");
}

/**
 * Others write the same in other words.
 */
void testOtherTexts()
{
    Texts texts;
    texts.sum = "step(x)*0.5*(0.5*log(M/(s+r))/r+(r-s*s/r)*(1/(s+r)^2-1/M^2)/4-1/(r+s)+1/M);"
                "x=-(or1-r)+s; M=max(abs(s-r),or1); s=abs(sr2)";
    texts.radius = "or/(1-or*tanh(p*(1+p*(-4*0.2+p*4.85)))/(9e-3+or)); p=or*total";
    texts.self = "q*q*scale/born; q=charge*5";
    texts.pairs = "(charge2*scale*25*charge1*2)*(born2*born1*1/exp(0.25*r*r/born1/born2)+r*r)^(-1/2)";
    texts.surface = "-2*(or^8*born^-6)";
    texts.sumName = "total";
    texts.radiusName = "born";
    assertUnknown(texts, "surface"); // the radii are others
    texts.surface = "-2*(or+0.009)^6*(or+0.3)^2/born^6";
    const EnergyTerms::Born born = assertNative(texts);
    ASSERT_EQUAL_TOL(0.291, born.probeRadius, 1e-9);
    ASSERT_EQUAL_TOL(-2, born.surfaceEnergy, 1e-9);
    for (double radius : born.scaledRadii)
        ASSERT(radius > 0);

    // Written like this, it is not a number for near particles if there are negative radii.

    texts.sum = edit(texts.sum, "abs(sr2)", "sr2");
    assertUnknown(texts, "pair sum");

    // Terms may be in parts.

    CustomGBForce* force = createForce(Texts());
    string term;
    CustomGBForce::ComputationType type;
    force->getEnergyTermParameters(2, term, type);
    force->setEnergyTermParameters(2, "0.25*(" + term.substr(0, term.find(';')) + ")" + term.substr(term.find(';')),
                                   type);
    force->addEnergyTerm("0.75*(" + term.substr(0, term.find(';')) + ")" + term.substr(term.find(';')), type);
    assertNative(force);
}

/**
 * The text of older versions: a particle within another one has a further term.
 */
void testFilledSpheres()
{
    Texts texts;
    texts.sum = "step(r+sr2-or1)*0.5*(1/L-1/U+0.25*(1/U^2-1/L^2)*(r-sr2*sr2/r)+0.5*log(L/U)/r+C);"
                "U=r+abs(sr2); C=2*(1/or1-1/L)*step(sr2-r-or1); L=max(or1, D); D=abs(r-sr2)";
    assertUnknown(texts, "pair sum");
    texts.sum = edit(texts.sum, "abs(sr2)", "sr2");
    assertUnknown(texts, "pair sum"); // no number for near particles, if there are negative radii
    while (texts.sum.find("sr2") != string::npos)
        texts.sum = edit(texts.sum, "sr2", "gamma2");
    ASSERT(assertNative(texts).filled); // so large that there are such particles
    ASSERT(!assertNative(Texts()).filled);
}

static GBSAOBCForce* createObc(double scale)
{
    OddNumbers numbers(7);
    GBSAOBCForce* force = new GBSAOBCForce();
    for (int i = 0; i < NUM_BEADS; i++)
        force->addParticle(numbers.between(-1, 1), numbers.between(0.1, 0.5), scale * numbers.between(0.5, 1));
    return force;
}

void testObc()
{
    for (double scale : {0.8, 5.0}) { // some particles lie within others
        assertNative(createObc(scale));
        GBSAOBCForce* force = createObc(scale);
        force->setSolventDielectric(40);
        force->setSoluteDielectric(3);
        force->setSurfaceAreaEnergy(0);
        assertNative(force);
        force = createObc(scale);
        force->setNonbondedMethod(GBSAOBCForce::CutoffNonPeriodic);
        force->setCutoffDistance(2.5);
        assertNative(force);
    }
    GBSAOBCForce* force = createObc(1);
    force->setNonbondedMethod(GBSAOBCForce::CutoffPeriodic);
    assertForeign(force, "its cutoff is periodic");
    force = createObc(1);
    force->setParticleParameters(3, 0.5, 0.009, 0.8);
    assertForeign(force, "one of its radii is not positive");
    force = createObc(1);
    force->setSolventDielectric(0);
    assertForeign(force, "its dielectrics or its screening make no sense");
    assertForeign(createObc(1), "it needs a NonbondedForce that openmm-chaintree evaluates, too", false);
}

void testGlobalParameters()
{
    Texts texts;
    texts.self = "scale*(" + texts.self.substr(0, texts.self.find(';')) + ")" + texts.self.substr(texts.self.find(';'));
    texts.pairs = "scale*" + texts.pairs;
    assertNative(texts);
    NativeScene scene;
    const int index = scene.add(createForce(texts));
    scene.add(createNonbonded());
    scene.makePlan();
    for (double scale : {0.25, 2.0, 0.0}) {
        scene.context->setParameter("scale", scale);
        scene.plan->translate(-1, true, TorsionMonteCarloIntegrator::Hard);
        const double expected = scene.context->getState(State::Energy, false, 1 << index).getPotentialEnergy();
        ASSERT_EQUAL(1, scene.plan->getTerms().born.size());
        ASSERT_EQUAL_TOL(expected, computePlainEnergy(scene.plan->getTerms().born[0], scene.chain.positions), 1e-10);
    }
}

// ---- What is not ----

void testOtherModels()
{
    const Texts texts;
    auto assertEdited = [&](string Texts::*text, const string& part, const string& other, const string& what) {
        Texts edited = texts;
        edited.*text = edit(edited.*text, part, other);
        try {
            assertUnknown(edited, what);
        }
        catch (const exception& error) {
            throw OpenMMException(part + " -> " + other + ": " + error.what());
        }
    };
    const string sum = "pair sum", radius = "Born radius", self = "energy of particles", pairs = "pair energy";
    assertEdited(&Texts::sum, "0.25", "0.2500001", sum);
    assertEdited(&Texts::sum, "sr2^2/r", "sr2^2/r^2", sum);
    assertEdited(&Texts::sum, "/r), 0)", "/r)*1.0001, 0)", sum);
    assertEdited(&Texts::sum, "log(L/U)", "log(U/L)", sum);
    assertEdited(&Texts::sum, "sr2-or1", "sr2+or1", sum);
    assertEdited(&Texts::sum, "max", "min", sum);
    assertEdited(&Texts::sum, "abs(r-sr2)", "abs(r+sr2)", sum);
    assertEdited(&Texts::sum, "r+sr2;", "r+sr1;", "order of particles");
    assertEdited(&Texts::sum, "U=r+sr2", "U=r+sr2*(1+delta(radindex1-2)*delta(radindex2-1))", "order of particles");
    assertEdited(&Texts::sum, "/r), 0)", "/r), 0)+step(r-7)*delta(r-7.5)", sum);
    assertEdited(&Texts::sum, "0)", "1e-12)", sum);
    assertEdited(&Texts::radius, "psi^3", "psi^4", radius);
    assertEdited(&Texts::radius, "1/or-", "1/(or+1e-6)-", radius);
    assertEdited(&Texts::radius, "psi=I*or", "psi=I*or+1e-6", radius);
    assertEdited(&Texts::radius, "psi=I*or", "psi=I*or+0*x", radius);
    assertEdited(&Texts::self, "charge^2", "charge^3", self);
    assertEdited(&Texts::self, "-0.5*", "-0.50001*", self);
    assertEdited(&Texts::self, "charge^2", "charge^2+x", self);
    assertEdited(&Texts::self, "charge^2/B", "charge^2/B^2", self);
    assertEdited(&Texts::self, "charge^2", "(charge^2+delta(radindex-2)*1e-5)", self);
    assertEdited(&Texts::surface, "^6", "^4", self);
    assertEdited(&Texts::surface, "28.39", "alpha*28.39", "surface");
    assertEdited(&Texts::pairs, "4*", "4.00001*", pairs);
    assertEdited(&Texts::pairs, "charge1*charge2", "(charge1*charge2+1e-5*delta(radindex1)*delta(radindex2))", pairs);
    assertEdited(&Texts::pairs, "charge1*charge2", "(charge1*charge2+1e-5*step(0.3-charge1^2)*step(0.3-charge2^2))",
                 pairs);
    assertEdited(&Texts::pairs, "charge1*charge2", "charge1*charge2*step(3-r)", pairs);

    // Nor the same in either order.

    for (auto& edited : vector<array<string, 2>>{{"charge1*charge2", "charge1*charge1"},
                                                 {"charge1*charge2", "charge1*(charge2+1e-5)"},
                                                 {"charge2/f", "charge2*(1/f-0.4*charge1)"},
                                                 {"B1*B2*", "B1*B1*"}}) {
        Texts other;
        other.pairs = edit(other.pairs, edited[0], edited[1]);
        assertForeign(createForce(other), "its expression is not the same in either order of two particles");
    }

    Texts screened;
    screened.self = SCREENED;
    screened.pairs = edit(SCREENED_PAIRS, "kappa=0.7", "kappa=0.70001");
    assertUnknown(screened, self);
    screened.pairs = texts.pairs;
    assertUnknown(screened, self);
}

void testOtherForms()
{
    const string unknown = " is not that of a generalized Born model that openmm-chaintree knows";
    CustomGBForce* force = createForce(Texts());
    force->addComputedValue("C", "B^2", CustomGBForce::SingleParticle);
    assertWhole(force, "its number of computed values" + unknown);
    force = createForce(Texts());
    force->addEnergyTerm("B", CustomGBForce::SingleParticle);
    assertWhole(force, "its energy of particles" + unknown);
    force = createForce(Texts());
    force->addEnergyTerm("1/r", CustomGBForce::ParticlePairNoExclusions);
    assertWhole(force, "its pair energy" + unknown);

    // Excluded pairs matter only if there are some.

    force = createForce(Texts());
    string text;
    CustomGBForce::ComputationType type;
    force->getEnergyTermParameters(2, text, type);
    force->setEnergyTermParameters(2, text, CustomGBForce::ParticlePair);
    force->getComputedValueParameters(0, text, text, type);
    force->setComputedValueParameters(0, "I", Texts().sum, CustomGBForce::ParticlePair);
    assertNative(force);
    force = createForce(Texts());
    force->addExclusion(0, 1);
    assertNative(force);
    force = createForce(Texts());
    force->getEnergyTermParameters(2, text, type);
    force->setEnergyTermParameters(2, text, CustomGBForce::ParticlePair);
    force->addExclusion(0, 1);
    assertWhole(force, "its exclusion of pairs" + unknown);
}

void testPartners()
{
    const string noPairs = "it needs a NonbondedForce that openmm-chaintree evaluates, too";
    assertWhole(createForce(Texts()), noPairs, false);
    NativeScene scene;
    const int first = scene.add(createForce(Texts())), second = scene.add(createForce(Texts()));
    scene.add(createNonbonded());
    scene.makePlan();
    ASSERT_EQUAL(EnergyPlan::Native, scene.plan->getEntries()[first].kind);
    ASSERT_EQUAL(EnergyPlan::Native, scene.plan->getEntries()[second].kind);
    ASSERT_EQUAL(1, scene.plan->getTerms().born.size());
    ASSERT_EQUAL(1, scene.plan->getTerms().valueEnergies.size());
    ASSERT_EQUAL(second, scene.plan->getTerms().valueEnergies[0].force);
    ASSERT_EQUAL("openmm-chaintree has code for one Force of generalized Born, and there is another before it",
                 scene.plan->getTerms().valueEnergies[0].reason);

    // If the NonbondedForce has no part in U, it is not there.

    scene.plan->translate(1 << first, true, TorsionMonteCarloIntegrator::Hard);
    ASSERT_EQUAL(0, scene.plan->getTerms().born.size());
    ASSERT_EQUAL(first, scene.plan->getTerms().valueEnergies[0].force);
    ASSERT_EQUAL(noPairs, scene.plan->getTerms().valueEnergies[0].reason);
}

int main()
{
    return runOnPlatform("Reference", [](Platform&) {
        testModels();
        testScreening();
        testCutoffs();
        testOtherTexts();
        testFilledSpheres();
        testObc();
        testGlobalParameters();
        testOtherModels();
        testOtherForms();
        testPartners();
    });
}
