/**
 * This tests the copies of Forces that are made by hand: by what OpenMM's XML says of them, and whose tables they have.
 */

#include "openmm/CustomCentroidBondForce.h"
#include "openmm/CustomCompoundBondForce.h"
#include "openmm/CustomGBForce.h"
#include "openmm/CustomNonbondedForce.h"
#include "openmm/serialization/XmlSerializer.h"
#include "openmm/TabulatedFunction.h"
#include "openmmchaintree/internal/ForceTranslation.h"
#include "TestSupport.h"
#include <memory>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static string toXml(const Force& force)
{
    stringstream xml;
    XmlSerializer::serialize<Force>(&force, "Force", xml);
    return xml.str();
}

/**
 * Give a Force all kinds of tables, and what else these classes have in common.
 */
template <class T>
static unique_ptr<T> furnish(T* bare)
{
    unique_ptr<T> force(bare);
    force->setName("odd name");
    force->setForceGroup(7);
    force->addGlobalParameter("one", 1.5);
    force->addGlobalParameter("two", -2.25);
    force->addEnergyParameterDerivative("two");
    vector<double> cycle = {1, 2, 3, 1}, values(27);
    for (int i = 0; i < 27; i++)
        values[i] = (i % 3) * 0.1; // periodic in x alone
    const vector<double> plane(16, 0.25), space(64, 0.125);
    force->addTabulatedFunction("line", new Continuous1DFunction({1, 2, 4}, 0.5, 2.5));
    force->addTabulatedFunction("circle", new Continuous1DFunction(cycle, 0, 3, true));
    force->addTabulatedFunction("plane", new Continuous2DFunction(4, 4, plane, 0, 1, 2, 3));
    force->addTabulatedFunction("torus", new Continuous2DFunction(4, 4, plane, 0, 1, 2, 3, true));
    force->addTabulatedFunction("space", new Continuous3DFunction(4, 4, 4, space, 0, 1, 2, 3, 4, 5));
    force->addTabulatedFunction("solid torus", new Continuous3DFunction(4, 4, 4, space, 0, 1, 2, 3, 4, 5, true));
    force->addTabulatedFunction("steps", new Discrete1DFunction({3, 1, 2}));
    force->addTabulatedFunction("squares", new Discrete2DFunction(2, 2, {1, 2, 3, 4}));
    force->addTabulatedFunction("cubes", new Discrete3DFunction(3, 3, 3, values));
    return force;
}

/**
 * Check that the copy of a Force is the same, and still is when the original is gone.
 */
static void assertCopies(unique_ptr<Force> original)
{
    const string expected = toXml(*original);
    unique_ptr<Force> copy(NativeForceKind::find(*original)->copy(*original));
    original.reset();
    ASSERT_EQUAL(expected, toXml(*copy));
    unique_ptr<Force> again(NativeForceKind::find(*copy)->copy(*copy));
    ASSERT_EQUAL(expected, toXml(*again));
}

void testCustomGB()
{
    auto force = furnish(new CustomGBForce());
    force->setNonbondedMethod(CustomGBForce::CutoffNonPeriodic);
    force->setCutoffDistance(0.75);
    force->addPerParticleParameter("charge");
    force->addPerParticleParameter("radius");
    for (int i = 0; i < 4; i++)
        force->addParticle({0.5 * i, 0.1 + i});
    force->addExclusion(0, 1);
    force->addExclusion(3, 2);
    force->addComputedValue("I", "radius1*circle(r)", CustomGBForce::ParticlePairNoExclusions);
    force->addComputedValue("B", "1/(I+radius)", CustomGBForce::SingleParticle);
    force->addEnergyTerm("one*charge^2/B", CustomGBForce::SingleParticle);
    force->addEnergyTerm("two*charge1*charge2/r", CustomGBForce::ParticlePair);
    assertCopies(move(force));
}

void testCompoundBonds()
{
    auto force = furnish(new CustomCompoundBondForce(3, "k*one*angle(p1,p2,p3)+two"));
    force->setUsesPeriodicBoundaryConditions(true);
    force->addPerBondParameter("k");
    force->addPerBondParameter("unused");
    force->addBond({0, 1, 2}, {3.5, 1});
    force->addBond({4, 2, 3}, {0.1, -1});
    assertCopies(move(force));
}

void testCentroidBonds()
{
    auto force = furnish(new CustomCentroidBondForce(2, "k*one*distance(g1,g2)+two"));
    force->setUsesPeriodicBoundaryConditions(true);
    force->addPerBondParameter("k");
    force->addPerBondParameter("unused");
    force->addGroup({0, 3});
    force->addGroup({1, 4, 2}, {0.5, 1.5, 2});
    force->addGroup({5});
    force->addBond({0, 1}, {3.5, 1});
    force->addBond({2, 0}, {0.1, -1});
    assertCopies(move(force));
}

void testCustomNonbonded()
{
    auto force = furnish(new CustomNonbondedForce("one*a1*a2*circle(r)+two*v1*v2; w=1"));
    force->setNonbondedMethod(CustomNonbondedForce::CutoffNonPeriodic);
    force->setCutoffDistance(0.75);
    force->setUseSwitchingFunction(true);
    force->setSwitchingDistance(0.5);
    force->setUseLongRangeCorrection(true);
    force->addPerParticleParameter("a");
    force->addComputedValue("v", "a^2");
    for (int i = 0; i < 4; i++)
        force->addParticle({0.3 * i});
    force->addExclusion(0, 1);
    force->addInteractionGroup({0, 1}, {2, 3});
    assertCopies(move(force));
}

int main()
{
    return runOnPlatform("Reference", [](Platform&) {
        testCustomGB();
        testCompoundBonds();
        testCentroidBonds();
        testCustomNonbonded();
    });
}
