/**
 * This tests that outer tests sample what the energy says: the means of two torsions against quadrature, for foreign
 * Forces of kinds that no code of ours will evaluate.
 */

#include "ForeignSupport.h"
#include "openmm/CustomCentroidBondForce.h"
#include "openmm/CustomExternalForce.h"
#include "openmm/CustomManyParticleForce.h"
#include "openmm/CustomTorsionForce.h"
#include "openmm/NonbondedForce.h"
#include "openmm/TabulatedFunction.h"
#include "ShortChain.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static void addCentroidForceOfStrength(System& system, int group, const string& strength)
{
    CustomCentroidBondForce* force = new CustomCentroidBondForce(2, strength + "*(same(distance(g1,g2))-1.3)^2");
    force->addTabulatedFunction("same",
                                new Continuous1DFunction({0, 30}, 0, 30)); // so that only OpenMM can evaluate it
    force->addGroup({0, 1});
    force->addGroup({3, 4});
    force->addBond({0, 1});
    force->setForceGroup(group);
    system.addForce(force);
}

static void addCentroidForce(System& system, int group)
{
    addCentroidForceOfStrength(system, group, "12");
}

static void addManyParticleForce(System& system, int group)
{
    CustomManyParticleForce* force =
        new CustomManyParticleForce(3, "15*(1+3*cos(theta1)*cos(theta2)*cos(theta3))/(r12*r13*r23);"
                                       "theta1=angle(p1,p2,p3); theta2=angle(p2,p3,p1); theta3=angle(p3,p1,p2);"
                                       "r12=distance(p1,p2); r13=distance(p1,p3); r23=distance(p2,p3)");
    for (int i = 0; i < system.getNumParticles(); i++)
        force->addParticle({}, i % 2);
    for (int i = 0; i < 3; i++)
        force->setTypeFilter(i, {0}); // one triple: OpenMM takes long for each
    force->setPermutationMode(CustomManyParticleForce::SinglePermutation);
    force->setForceGroup(group);
    system.addForce(force);
}

static void testForeignForces()
{
    // In a group of their own and in that of the native Force; with and without native energies.

    for (auto addForce : {addCentroidForce, addManyParticleForce}) {
        const int numSteps = addForce == addCentroidForce ? 10000 : 3000;
        const double tolerance = getTolerance(numSteps);
        ShortChain chain(0.3), shared(0.3), bare(0.3);
        addForce(chain.system, 1);
        addForce(shared.system, 0);
        const Means expected = chain.computeMeans(3);
        ASSERT(getLargestDifference(expected, shared.computeMeans(1)) < 1e-12);
        ASSERT(getLargestDifference(expected, chain.computeMeans(2)) > 1.5 * tolerance);
        ASSERT(getLargestDifference(expected, bare.computeMeans(1)) > 1.5 * tolerance);
        for (const Setting& setting : {Setting{7, 21, true, false}, Setting{50, 50, true, false}})
            assertSampled(chain, expected, setting, numSteps);
        assertSampled(shared, expected, {7, 20, true, false}, numSteps);
        assertSampled(shared, expected, {0, 25, true, false}, numSteps / 3);
        assertSampled(chain, expected, {7, 14, false, false}, numSteps);
        assertSampled(chain, expected, {0, 7, true, false}, numSteps);
    }
}

/**
 * A restraint in the group of all Forces samples the same if its expression is one that only OpenMM can evaluate.
 */
static void testRestraints()
{
    Means expected;
    for (const string expression : {"(x-0.5)^2+(y-0.3)^2+(z-1)^2", "periodicdistance(x,y,z,0.5,0.3,1)^2"}) {
        ShortChain chain(0.3);
        CustomExternalForce* restraint = new CustomExternalForce("4*(" + expression + ")");
        restraint->addParticle(4);
        chain.system.setDefaultPeriodicBoxVectors(Vec3(20, 0, 0), Vec3(0, 20, 0), Vec3(0, 0, 20));
        chain.system.addForce(restraint);
        const int numSteps = 4000;
        const Means means = chain.computeMeans(1);
        if (expression[0] == '(') {
            expected = means;
            ASSERT(getLargestDifference(expected, ShortChain(0.3).computeMeans(1)) > 1.5 * getTolerance(numSteps));
        }
        ASSERT(getLargestDifference(expected, means) < 1e-6);
        assertSampled(chain, expected, {0, 14, true, false}, numSteps);
    }
}

/**
 * The energy of soft spheres is seen by trials, and not by tests.
 */
static void testSoftSpheres()
{
    ShortChain chain(0.9);
    chain.force->setForceConstant(60);
    addCentroidForce(chain.system, 1);
    const Means expected = chain.computeMeans(3 | 1 << 5, false);
    const int numSteps = 10000;
    ASSERT(getLargestDifference(expected, chain.computeMeans(3, false)) > 4 * getTolerance(numSteps));
    assertSampled(chain, expected, {7, 20, true, true}, numSteps);
}

/**
 * As on platforms that evaluate force groups as a whole. Outer tests decide the weak Force, trials the strong one.
 */
static void testMixedForces()
{
    const int numSteps = 3000;
    for (const string strength : {"12", "60"}) {
        ShortChain shared(0.3);
        addCentroidForceOfStrength(shared.system, 0, strength);
        CustomTorsionForce* elsewhere = new CustomTorsionForce("4*cos(theta)");
        elsewhere->addTorsion(0, 1, 2, 3);
        elsewhere->setForceGroup(2);
        shared.system.addForce(elsewhere);
        const Means expected = shared.computeMeans(1 | 1 << 2);
        for (const char* way : {"groups", "copies"}) {
            WholeGroups wholeGroups(way);
            for (int trialsPerTest : {0, 7})
                assertSampled(shared, expected, {trialsPerTest, 14, true, false}, numSteps);
        }
    }
}

/**
 * Charges with a large part of their energy in reciprocal space, which OpenMM evaluates.
 */
static void addCharges(ShortChain& chain, NonbondedForce::NonbondedMethod method)
{
    NonbondedForce* charges = new NonbondedForce();
    for (int i = 0; i < 5; i++) {
        charges->addParticle(i % 2 == 0 ? 0.4 : -0.3, 0.1, 0);
        for (int j = max(0, i - 2); j < i; j++)
            charges->addException(j, i, 0, 1, 0);
    }
    charges->addException(0, 3, 0.05, 1, 0);
    charges->setNonbondedMethod(method);
    charges->setCutoffDistance(1.3);
    charges->setPMEParameters(2, 17, 17, 17); // sizes that the CPU platform does not use
    charges->setEwaldErrorTolerance(1e-3);
    charges->setReciprocalSpaceForceGroup(1);
    chain.force->setUsesPeriodicBoundaryConditions(true);
    chain.system.setDefaultPeriodicBoxVectors(Vec3(4, 0, 0), Vec3(0, 4.5, 0), Vec3(0, 0, 5));
    chain.system.addForce(charges);
}

/**
 * Trials see direct space, and tests reciprocal space, whether OpenMM evaluates it alone or with all of its group.
 */
static void testReciprocalSpace()
{
    const int numSteps = 1500;
    ShortChain pme(0.3), ewald(0.3), shared(0.3);
    addCharges(pme, NonbondedForce::PME);
    addCharges(ewald, NonbondedForce::Ewald);
    addCharges(shared, NonbondedForce::PME);
    addCentroidForce(shared.system, 0);
    const Means expected = pme.computeMeans(3), expectedOfEwald = ewald.computeMeans(3);
    ASSERT(getLargestDifference(expected, pme.computeMeans(1)) > 1.5 * getTolerance(numSteps));
    ASSERT(getLargestDifference(expected, ShortChain(0.3).computeMeans(1)) > 1.5 * getTolerance(numSteps));
    ASSERT(getLargestDifference(expected, expectedOfEwald) < 0.01);
    assertSampled(pme, expected, {7, 14, true, false}, numSteps);
    assertSampled(pme, expected, {0, 25, true, false}, numSteps);
    assertSampled(ewald, expectedOfEwald, {40, 40, true, false}, numSteps);
    const Means expectedOfBoth = shared.computeMeans(3);
    for (const char* way : {"groups", "copies"}) {
        WholeGroups wholeGroups(way);
        assertSampled(shared, expectedOfBoth, {7, 14, true, false}, numSteps);
    }
}

int main()
{
    return runOnPlatform("Reference", [](Platform&) {
        testRestraints();
        testMixedForces();
        testForeignForces();
        testSoftSpheres();
        testReciprocalSpace();
    });
}
