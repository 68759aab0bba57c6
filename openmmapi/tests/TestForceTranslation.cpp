/**
 * This tests the translation of Forces to terms: each kind with odd parameters against OpenMM.
 */

#include "NativeEnergySupport.h"
#include "openmm/CMAPTorsionForce.h"
#include "openmm/CustomAngleForce.h"
#include "openmm/CustomBondForce.h"
#include "openmm/CustomCentroidBondForce.h"
#include "openmm/CustomCompoundBondForce.h"
#include "openmm/CustomExternalForce.h"
#include "openmm/CustomTorsionForce.h"
#include "openmm/PeriodicTorsionForce.h"
#include "openmm/RBTorsionForce.h"
#include "openmm/TabulatedFunction.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static const int NUM_TERMS = 12, NUM_BEADS = NativeScene::NUM_BEADS;

/**
 * Check that a Force is native, and that its energy is that of OpenMM.
 */
static void assertNative(Force* force, double tolerance = 1e-7)
{
    NativeScene scene;
    const int index = scene.add(force);
    scene.build();
    scene.assertAgreement(index, tolerance);
}

// ---- Terms of fixed form ----

void testBondsAndAngles()
{
    OddNumbers numbers(1);
    HarmonicBondForce* bonds = new HarmonicBondForce();
    HarmonicAngleForce* angles = new HarmonicAngleForce();
    for (int i = 0; i < NUM_TERMS; i++) {
        vector<int> p = numbers.particles(3, NUM_BEADS);
        bonds->addBond(p[0], p[1], numbers.between(0, 3), numbers.between(-50, 100));
        angles->addAngle(p[0], p[1], p[2], numbers.between(0, M_PI), numbers.between(-50, 100));
    }
    assertNative(bonds);
    assertNative(angles);
}

void testTorsions()
{
    OddNumbers numbers(2);
    PeriodicTorsionForce* periodic = new PeriodicTorsionForce();
    RBTorsionForce* rb = new RBTorsionForce();
    for (int i = 0; i < NUM_TERMS; i++) {
        vector<int> p = numbers.particles(4, NUM_BEADS);
        periodic->addTorsion(p[0], p[1], p[2], p[3], 1 + numbers.below(7), numbers.between(-9, 9),
                             numbers.between(-9, 9));
        double c[6];
        for (double& coefficient : c)
            coefficient = numbers.between(-9, 9);
        rb->addTorsion(p[0], p[1], p[2], p[3], c[0], c[1], c[2], c[3], c[4], c[5]);
    }
    assertNative(periodic);
    assertNative(rb);
}

void testMaps()
{
    OddNumbers numbers(3);
    CMAPTorsionForce* force = new CMAPTorsionForce();
    for (int size : {3, 24, 7}) {
        vector<double> energies(size * size);
        for (double& energy : energies)
            energy = numbers.between(-9, 9);
        force->addMap(size, energies);
    }
    for (int i = 0; i < NUM_TERMS; i++) {
        vector<int> p = numbers.particles(8, NUM_BEADS);
        force->addTorsion(i % 3, p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7]);
    }
    force->addTorsion(1, 0, 1, 2, 3, 1, 2, 3, 4);
    assertNative(force);
}

// ---- Expressions ----

/**
 * Make bonds of an expression of r, the parameters a, b and big, and the global parameters half and minus.
 */
static CustomBondForce* createBonds(const string& expression)
{
    OddNumbers numbers(4);
    CustomBondForce* force = new CustomBondForce(expression);
    force->addGlobalParameter("half", 0.5);
    force->addPerBondParameter("a");
    force->addPerBondParameter("b");
    force->addPerBondParameter("big");
    force->addGlobalParameter("minus", -1.25);
    for (int i = 0; i < NUM_TERMS; i++) {
        vector<int> p = numbers.particles(2, NUM_BEADS);
        force->addBond(p[0], p[1], {numbers.between(0.1, 0.9), numbers.between(-0.9, 0.9), numbers.between(10, 20)});
    }
    return force;
}

void testEveryFunction()
{
    for (const string expression : {"r+a",
                                    "r-a",
                                    "r*b",
                                    "r/a",
                                    "(r*a)^b",
                                    "a^r",
                                    "-r",
                                    "sqrt(r)",
                                    "exp(b*r)",
                                    "log(r*a)",
                                    "sin(r)",
                                    "cos(r)",
                                    "sec(b*a)+r",
                                    "csc(a)*r",
                                    "tan(b)*r",
                                    "cot(a)*r",
                                    "asin(b)*r",
                                    "acos(b)*r",
                                    "atan(r*b)",
                                    "atan2(r*b,minus)",
                                    "atan2(minus,r*b)",
                                    "sinh(b*r)",
                                    "cosh(b*r)",
                                    "tanh(b*r)",
                                    "erf(r*b)",
                                    "erfc(r*b)",
                                    "step(r-2)",
                                    "step(b)*r",
                                    "delta(b)*r+delta(0*r)",
                                    "(r-1)^2",
                                    "(r-1)^3",
                                    "(r-b)^4",
                                    "(r-9)^-3",
                                    "r^2.5",
                                    "r^half",
                                    "1/r",
                                    "r+3",
                                    "3-r",
                                    "r*7",
                                    "r/7",
                                    "7/r",
                                    "min(r,2)",
                                    "min(2,r)",
                                    "max(r,2*a)",
                                    "abs(r-2)",
                                    "floor(3*r*b)",
                                    "ceil(3*r*b)",
                                    "select(step(r-2),r,a)",
                                    "select(b,a,r)",
                                    "select(0*r,a,r)",
                                    "half",
                                    "a",
                                    "minus*half",
                                    "2",
                                    "r",
                                    "sqrt(r^2)",
                                    "(r*minus)^2",
                                    "r^1",
                                    "r^0",
                                    "a^(half+half)",
                                    "(r+b)^(2*half+1)",
                                    "(r+b)^(4*half+1)",
                                    "exp(half)*r",
                                    "select(half,r,a)",
                                    "minus+r",
                                    "r-minus",
                                    "minus-r",
                                    "minus*r",
                                    "r/minus",
                                    "minus/r",
                                    "(b*r)^(4*half)"})
        try {
            assertNative(createBonds(expression));
        }
        catch (const exception& error) {
            throw OpenMMException(expression + ": " + error.what());
        }
}

/**
 * Make an expression of r, a, b, big, half, minus and numbers.
 */
static string createExpression(OddNumbers& numbers, int depth)
{
    static const vector<string> leaves = {"r", "a", "b", "big", "half", "minus", "2", "0.3", "1", "0", "r", "-1"};
    static const vector<string> functions = {"sqrt(abs(#))",
                                             "exp(min(#,3))",
                                             "log(1+abs(#))",
                                             "sin(#)",
                                             "cos(#)",
                                             "sec(0.1*sin(#))",
                                             "csc(2+sin(#))",
                                             "tan(sin(#))",
                                             "cot(2+sin(#))",
                                             "asin(0.9*sin(#))",
                                             "acos(0.9*cos(#))",
                                             "atan(#)",
                                             "sinh(sin(#))",
                                             "cosh(sin(#))",
                                             "tanh(#)",
                                             "erf(#)",
                                             "erfc(#)",
                                             "step(#)",
                                             "delta(#)",
                                             "abs(#)",
                                             "floor(#)",
                                             "ceil(#)",
                                             "-(#)",
                                             "(#)^2",
                                             "(#)^3",
                                             "(#)^4",
                                             "(1+abs(#))^-1",
                                             "(1+abs(#))^1.5",
                                             "(#)^1",
                                             "(#)*minus",
                                             "(#)/half"};
    static const vector<string> pairs = {"(#)+(#)",           "(#)-(#)",  "(#)*(#)",  "(#)/(2+sin(#))",
                                         "(1+abs(#))^sin(#)", "min(#,#)", "max(#,#)", "atan2(#,1.5+sin(#))",
                                         "(#)*(#)",           "(#)-(#)"};
    if (depth == 0)
        return leaves[numbers.below(leaves.size())];
    const int choice = numbers.below(10);
    string form = choice == 0  ? "select(#,#,#)"
                  : choice < 6 ? pairs[numbers.below(pairs.size())]
                               : functions[numbers.below(functions.size())];
    string expression;
    for (char c : form)
        expression += c == '#' ? createExpression(numbers, depth - 1) : string(1, c);
    return expression;
}

void testRandomExpressions()
{
    OddNumbers numbers(9);
    int numCompared = 0;
    for (int i = 0; i < 500; i++) {
        const string expression = createExpression(numbers, 1 + i % 5);
        NativeScene scene;
        const int index = scene.add(createBonds(expression));
        scene.build();
        const double expected = scene.computeOpenMMEnergy(1 << index), found = scene.computeEnergies()[index];
        if (!(fabs(expected) < 1e9))
            continue;
        numCompared++;
        if (scene.plan->getEntries()[index].kind != EnergyPlan::Native ||
            !(fabs(found - expected) <= 1e-9 * (1 + fabs(expected))))
            throw OpenMMException(expression + ": expected " + to_string(expected) + ", found " + to_string(found));
    }
    ASSERT(numCompared > 400);
}

void testSharedSubexpressions()
{
    CustomBondForce* force = createBonds("4*big*(s12-s6)+half*q*(q+s6)+minus; q=x-s6+s12; s12=s6*s6; s6=x^6; x=a/r");
    NativeScene scene;
    const int index = scene.add(force);
    scene.build();
    scene.assertAgreement(index);

    // What appears more than once is computed once, and nothing is left over.

    const vector<ctOperation>& operations = scene.plan->getTerms().termSets[0].operations;
    int numPowers = 0;
    for (const ctOperation& operation : operations)
        numPowers += operation.kind == ctPowerConstantOperator;
    ASSERT_EQUAL(1, numPowers);
    ASSERT_EQUAL(1, scene.plan->getTerms().termSets[0].inputs.size());
    ASSERT(operations.size() <= 18);
}

void testCustomAnglesAndTorsions()
{
    OddNumbers numbers(5);
    CustomAngleForce* angles = new CustomAngleForce("k*(theta-theta0)^2*scale+cos(theta)");
    CustomTorsionForce* torsions =
        new CustomTorsionForce("scale*k*min(d,2*pi-d)^2+theta+sin(theta); d=abs(theta-theta0); pi=3.1415926535897932");
    angles->addPerAngleParameter("k");
    angles->addPerAngleParameter("theta0");
    angles->addGlobalParameter("scale", 1.75);
    torsions->addPerTorsionParameter("theta0");
    torsions->addPerTorsionParameter("k");
    torsions->addGlobalParameter("scale", 0.75);
    for (int i = 0; i < NUM_TERMS; i++) {
        vector<int> p = numbers.particles(4, NUM_BEADS);
        angles->addAngle(p[0], p[1], p[2], {numbers.between(-9, 9), numbers.between(0, 3)});
        torsions->addTorsion(p[0], p[1], p[2], p[3], {numbers.between(-3, 3), numbers.between(-9, 9)});
    }
    assertNative(angles);
    assertNative(torsions);
}

static CustomCompoundBondForce* createCompoundBonds(const string& expression, int numParticles = 5)
{
    OddNumbers numbers(6);
    CustomCompoundBondForce* force = new CustomCompoundBondForce(numParticles, expression);
    force->addPerBondParameter("a");
    force->addPerBondParameter("p1"); // Only where a particle is expected does this name one.
    force->addGlobalParameter("g", 1.5);
    for (int i = 0; i < NUM_TERMS; i++)
        force->addBond(numbers.particles(numParticles, NUM_BEADS), {numbers.between(1, 2), numbers.between(-2, 2)});
    return force;
}

void testCompoundBonds()
{
    for (const string expression :
         {"a*distance(p1,p2)+p1*angle(p3,p2,p5)^2+g*cos(dihedral(p4,p1,p2,p3))",
          "distance(p2,p1)+distance(p1,p2)*angle(p1,p2,p3)-angle(p3,p2,p1)+sin(dihedral(p4,p3,p2,p1))",
          "sin(dihedral(p1,p2,p3,p4))+2*sin(dihedral(p4,p3,p2,p1))-sin(dihedral(p2,p1,p3,p4))", "x1*y2-z3^2+a*y5*x4",
          "pointdistance(x1,y1,z1,x3,y3,z3)*a",
          "a*pointangle(x5,y5,z5,x2,y2,z2,x4,y4,z4)+sin(pointdihedral(x5,y5,z5,x2,y2,z2,x4,y4,z4,x1,y1,z1))",
          "pointdistance(x1,y1,z1,a,g,0.25)^2+pointdistance(0,0,0,x2,y2,z2)",
          "pointdistance((x1+x2)/2,(y1+y2)/2,(z1+z2)/2,(x3+x4)/2,(y3+y4)/2,(z3+z4)/2)",
          "pointdistance(x1,y2,z1,x3,y3,z3)", "r1*r2+r1; r1=distance(p1,q); r2=distance(q,p4); q=p3", "a*p1"})
        try {
            assertNative(createCompoundBonds(expression));
        }
        catch (const exception& error) {
            throw OpenMMException(expression + ": " + error.what());
        }
    assertNative(createCompoundBonds("x1*a+p1", 1));
    assertNative(createCompoundBonds("sin(x12)*distance(p11,p12)+y1", 12));

    // A table that is not used is no hindrance.

    CustomCompoundBondForce* force = createCompoundBonds("x1");
    force->addTabulatedFunction("table", new Continuous1DFunction({0, 1, 2}, 0, 1));
    assertNative(force);
}

/**
 * Groups of one particle to six, some weighted by masses.
 */
static CustomCentroidBondForce* createCentroidBonds(const string& expression, int numGroupsPerBond = 5)
{
    OddNumbers numbers(8);
    CustomCentroidBondForce* force = new CustomCentroidBondForce(numGroupsPerBond, expression);
    force->addPerBondParameter("a");
    force->addGlobalParameter("g", 1.5);
    for (int i = 0; i < 2 * numGroupsPerBond; i++) {
        const vector<int> particles = numbers.particles(1 + numbers.below(6), NUM_BEADS);
        vector<double> weights;
        for (int k = 0; k < (int)particles.size() && i % 2 == 0; k++)
            weights.push_back(numbers.between(0.2, 2));
        force->addGroup(particles, weights);
    }
    for (int i = 0; i < NUM_TERMS; i++)
        force->addBond(numbers.particles(numGroupsPerBond, 2 * numGroupsPerBond), {numbers.between(1, 2)});
    return force;
}

void testCentroidBonds()
{
    for (const string expression : {"a*distance(g1,g2)+angle(g3,g2,g5)^2+g*cos(dihedral(g4,g1,g2,g3))",
                                    "x1*y2-z3^2+a*y5*x4", "pointdistance(x1,y1,z1,x3,y3,z3)*a", "a"})
        try {
            assertNative(createCentroidBonds(expression));
        }
        catch (const exception& error) {
            throw OpenMMException(expression + ": " + error.what());
        }
    assertNative(createCentroidBonds("x1*a", 1));

    // Bonds between neighbours of a chain, whose groups lie in one link each or across links, with masses that differ.

    for (int size : {1, 2, 3}) {
        NativeScene scene;
        for (int i = 0; i < NUM_BEADS; i++)
            scene.chain.system.setParticleMass(i, 1 + i % 3);
        CustomCentroidBondForce* force = new CustomCentroidBondForce(2, "10*(distance(g1,g2)-0.5)^2");
        for (int first = 0; first + size <= 9; first++) {
            vector<int> particles;
            for (int i = first; i < first + size; i++)
                particles.push_back(i);
            force->addGroup(particles);
        }
        for (int i = 0; i + 2 < force->getNumGroups(); i++)
            force->addBond({i, i + 2});
        const int index = scene.add(force);
        scene.build();
        scene.assertAgreement(index);
    }
}

void testExternal()
{
    OddNumbers numbers(7);
    CustomExternalForce* force = new CustomExternalForce("k*((x-x0)^2+s*(y-y0)^2+abs(z-z0)+x*y*z)");
    force->addPerParticleParameter("x0");
    force->addPerParticleParameter("y0");
    force->addPerParticleParameter("z0");
    force->addGlobalParameter("k", 2.5);
    force->addGlobalParameter("s", -0.5);
    for (int i = 0; i < NUM_TERMS; i++)
        force->addParticle(numbers.below(NUM_BEADS),
                           {numbers.between(-2, 2), numbers.between(-2, 2), numbers.between(-2, 2)});
    assertNative(force);
}

void testGlobalParameters()
{
    NativeScene scene;
    const int index = scene.add(createBonds("half*r+minus*big"));
    scene.build();
    scene.context->setParameter("half", 3.25);
    scene.context->setParameter("minus", 0.5);
    scene.plan->translate(-1, true, TorsionMonteCarloIntegrator::Hard);
    scene.getEnergy().setTerms(scene.plan->getTerms());
    scene.assertAgreement(index);
}

// ---- NonbondedForce ----

/**
 * Odd particles, and exceptions of all sorts: with parameters and without, of near and of distant particles.
 */
static NonbondedForce* createNonbonded()
{
    OddNumbers numbers(8);
    NonbondedForce* force = new NonbondedForce();
    for (int i = 0; i < NUM_BEADS; i++)
        force->addParticle(i % 5 == 0 ? 0 : numbers.between(-1, 1), numbers.between(0.1, 0.4),
                           i % 4 == 0 ? 0 : numbers.between(0, 3));
    for (int i = 0; i < 8; i++) {
        force->addException(i, i + 1, 0, i % 2, 0);
        force->addException(i + 3, i, numbers.between(-1, 1), numbers.between(0.1, 0.9), numbers.between(0, 3));
    }
    force->addException(0, 14, 0.7, 0, 0);
    force->addException(14, 3, 0, 0.5, 2.5);
    force->addException(4, 12, 0, 0.5, 0);
    return force;
}

/** Pairs are in single precision, and their energies of some ten kJ/mol cancel. */
static const double PAIR_TOLERANCE = 5e-5;

void testNonbonded()
{
    assertNative(createNonbonded(), PAIR_TOLERANCE);
    for (double cutoff : {1.3, 2.5, 100.0})
        for (double dielectric : {1.0, 7.5, 78.5, 1e10}) {
            NonbondedForce* force = createNonbonded();
            force->setNonbondedMethod(NonbondedForce::CutoffNonPeriodic);
            force->setCutoffDistance(cutoff);
            force->setReactionFieldDielectric(dielectric);
            assertNative(force, PAIR_TOLERANCE);
        }
    for (double switchingDistance : {0.0, 0.9, 1.79}) {
        NonbondedForce* force = createNonbonded();
        force->setNonbondedMethod(NonbondedForce::CutoffNonPeriodic);
        force->setCutoffDistance(1.8);
        force->setUseSwitchingFunction(true);
        force->setSwitchingDistance(switchingDistance);
        assertNative(force, PAIR_TOLERANCE);
    }

    // What is said about a cutoff counts only if there is one.

    NonbondedForce* force = createNonbonded();
    force->setCutoffDistance(1.8);
    force->setUseSwitchingFunction(true);
    force->setSwitchingDistance(0.5);
    force->setReciprocalSpaceForceGroup(7);
    assertNative(force, PAIR_TOLERANCE);
}

void testOffsets()
{
    NonbondedForce* force = createNonbonded();
    force->addGlobalParameter("lambda", 0.5);
    force->addGlobalParameter("mu", -0.25);
    force->addParticleParameterOffset("lambda", 3, 0.5, 0.1, 2);
    force->addParticleParameterOffset("mu", 3, -0.5, -0.01, 0.1);
    force->addParticleParameterOffset("mu", 0, 1, 0, 0);
    force->addExceptionParameterOffset("lambda", 0, 1.5, 0.25, 3); // of an exception without parameters
    force->addExceptionParameterOffset("mu", 1, 1.5, 0.25, 3);
    NativeScene scene;
    const int index = scene.add(force);
    scene.build();
    scene.assertAgreement(index, PAIR_TOLERANCE);
    for (double lambda : {0.0, 1.5}) {
        scene.context->setParameter("lambda", lambda);
        scene.context->setParameter("mu", 0.75);
        scene.plan->translate(-1, true, TorsionMonteCarloIntegrator::Hard);
        scene.getEnergy().setTerms(scene.plan->getTerms());
        scene.assertAgreement(index, PAIR_TOLERANCE);
    }
}

int main()
{
    return runOnPlatform("Reference", [](Platform&) {
        testBondsAndAngles();
        testTorsions();
        testMaps();
        testEveryFunction();
        testRandomExpressions();
        testSharedSubexpressions();
        testCustomAnglesAndTorsions();
        testCompoundBonds();
        testCentroidBonds();
        testExternal();
        testGlobalParameters();
        testNonbonded();
        testOffsets();
    });
}
