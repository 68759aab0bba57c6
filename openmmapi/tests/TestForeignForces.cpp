/**
 * This tests why a Force is left to OpenMM, and that it is then, whatever it may be.
 */

#include "NativeEnergySupport.h"
#include "openmm/CMAPTorsionForce.h"
#include "openmm/CustomAngleForce.h"
#include "openmm/CustomBondForce.h"
#include "openmm/CustomCentroidBondForce.h"
#include "openmm/CustomCompoundBondForce.h"
#include "openmm/CustomExternalForce.h"
#include "openmm/CustomHbondForce.h"
#include "openmm/CustomTorsionForce.h"
#include "openmm/PeriodicTorsionForce.h"
#include "openmm/RBTorsionForce.h"
#include "openmm/TabulatedFunction.h"
#include "openmmchaintree/internal/ForceTranslation.h"
#include <limits>
#include <map>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static const int NUM_BEADS = NativeScene::NUM_BEADS;

static CustomBondForce* createBonds(const string& expression)
{
    CustomBondForce* force = new CustomBondForce(expression);
    force->addPerBondParameter("a");
    force->addGlobalParameter("g", 1.5);
    force->addBond(0, 1, {0.5});
    return force;
}

static CustomCompoundBondForce* createCompoundBonds(const string& expression)
{
    CustomCompoundBondForce* force = new CustomCompoundBondForce(3, expression);
    force->addBond({0, 1, 2});
    return force;
}

static NonbondedForce* createNonbonded()
{
    NonbondedForce* force = new NonbondedForce();
    for (int i = 0; i < NUM_BEADS; i++)
        force->addParticle(0.1, 0.3, 1);
    force->addException(0, 1, 0.5, 0.3, 1);
    return force;
}

/**
 * Check that a Force is left to OpenMM for a reason, and that no trace of it is in the terms.
 */
static void assertForeign(Force* force, const string& reason)
{
    NativeScene scene;
    scene.add(createBonds("r"));
    const int index = scene.add(force);
    scene.chain.system.setDefaultPeriodicBoxVectors(Vec3(9, 0, 0), Vec3(0, 9, 0), Vec3(0, 0, 9));
    scene.build();
    const EnergyPlan::Entry& entry = scene.plan->getEntries()[index];
    ASSERT_EQUAL(EnergyPlan::Foreign, entry.kind);
    if (entry.reason.find(reason) == string::npos)
        throw OpenMMException("expected the reason \"" + reason + "\", found \"" + entry.reason + "\"");
    ASSERT_EQUAL(1, scene.plan->getTerms().termSets.size());
    ASSERT_EQUAL(0, scene.plan->getTerms().nonbonded.size());
    ASSERT(scene.computeEnergies()[1] > 0);
}

void testPeriodicForcesAreForeign()
{
    const string reason = "it uses periodic boundary conditions";
    HarmonicBondForce* bonds = new HarmonicBondForce();
    bonds->setUsesPeriodicBoundaryConditions(true);
    assertForeign(bonds, reason);
    HarmonicAngleForce* angles = new HarmonicAngleForce();
    angles->setUsesPeriodicBoundaryConditions(true);
    assertForeign(angles, reason);
    PeriodicTorsionForce* torsions = new PeriodicTorsionForce();
    torsions->setUsesPeriodicBoundaryConditions(true);
    assertForeign(torsions, reason);
    RBTorsionForce* rb = new RBTorsionForce();
    rb->setUsesPeriodicBoundaryConditions(true);
    assertForeign(rb, reason);
    CMAPTorsionForce* maps = new CMAPTorsionForce();
    maps->setUsesPeriodicBoundaryConditions(true);
    assertForeign(maps, reason);
    CustomBondForce* customBonds = createBonds("r");
    customBonds->setUsesPeriodicBoundaryConditions(true);
    assertForeign(customBonds, reason);
    CustomAngleForce* customAngles = new CustomAngleForce("theta");
    customAngles->setUsesPeriodicBoundaryConditions(true);
    assertForeign(customAngles, reason);
    CustomTorsionForce* customTorsions = new CustomTorsionForce("theta");
    customTorsions->setUsesPeriodicBoundaryConditions(true);
    assertForeign(customTorsions, reason);
    CustomCompoundBondForce* compound = createCompoundBonds("x1");
    compound->setUsesPeriodicBoundaryConditions(true);
    assertForeign(compound, reason);
    assertForeign(new CustomExternalForce("periodicdistance(x,y,z,0,0,0)"), "it uses periodic boundary conditions");
}

void testForeignNonbondedForces()
{
    for (auto& method : map<NonbondedForce::NonbondedMethod, string>{
             {NonbondedForce::CutoffPeriodic, "its cutoff is periodic"},
             {NonbondedForce::Ewald, "Ewald summation is periodic"},
             {NonbondedForce::PME, "PME is periodic"},
             {NonbondedForce::LJPME, "openmm-chaintree has no code for LJPME"}}) {
        NonbondedForce* force = createNonbonded();
        force->setNonbondedMethod(method.first);
        force->setCutoffDistance(1);
        assertForeign(force, method.second);
    }
    NonbondedForce* force = createNonbonded();
    force->setExceptionsUsePeriodicBoundaryConditions(true);
    assertForeign(force, "its exceptions use periodic boundary conditions");
    force = createNonbonded();
    force->setIncludeDirectSpace(false);
    assertForeign(force, "its direct space is left out");
    force = createNonbonded();
    force->addGlobalParameter("lambda", 0.5);
    force->addParticleParameterOffset("lambda", 3, 0.5, 0.1, 2);
    force->addParticleParameterOffset("lambda", 3, 0.5, 0.1, 2);
    assertForeign(force, "the parameter lambda appears in two offsets");
    force = createNonbonded();
    force->addGlobalParameter("lambda", -2);
    force->addParticleParameterOffset("lambda", 3, 0.5, 0.1, 2);
    assertForeign(force, "a parameter makes the epsilon of a particle negative");
    force = createNonbonded();
    force->setParticleParameters(2, numeric_limits<double>::infinity(), 1, 1);
    assertForeign(force, "one of its parameters is infinite or not a number");

    // One is native.

    NativeScene scene;
    const int first = scene.add(createNonbonded()), second = scene.add(createNonbonded());
    scene.build();
    ASSERT_EQUAL(EnergyPlan::Native, scene.plan->getEntries()[first].kind);
    ASSERT_EQUAL(first, scene.plan->getTerms().nonbonded[0].force);
    ASSERT_EQUAL(EnergyPlan::Foreign, scene.plan->getEntries()[second].kind);
    ASSERT_EQUAL("openmm-chaintree has code for one NonbondedForce, and there is another before it",
                 scene.plan->getEntries()[second].reason);
}

void testForeignExpressions()
{
    CustomCompoundBondForce* force = createCompoundBonds("table(x1)+distance(p1,p2)");
    force->addTabulatedFunction("table", new Continuous1DFunction({0, 1, 2}, 0, 1));
    assertForeign(force, "its expression uses the tabulated function table");
    force = createCompoundBonds("table(x1,y1)");
    force->addTabulatedFunction("table", new Discrete2DFunction(2, 2, {0, 1, 2, 3}));
    assertForeign(force, "its expression uses the tabulated function table");
    force = createCompoundBonds("pointdistance(x1,y1,z1,x1(0),y1,z1)"); // a function of this name, no particle
    force->addTabulatedFunction("x1", new Discrete1DFunction({4, 5}));
    assertForeign(force, "its expression uses the tabulated function x1");
    assertForeign(createCompoundBonds("pointangle(x1,y1,z1,0,0,0,x2,y2,z2)"),
                  "its expression takes pointangle of points that are not particles");
    assertForeign(createCompoundBonds("pointdihedral(x1,y1,z1,0,0,0,x2,y2,z2,x3,y3,z3)"),
                  "its expression takes pointdihedral of points that are not particles");
    assertForeign(createCompoundBonds("distance(p1,p1)+x1"), "its expression takes distance of one particle twice");
    assertForeign(createCompoundBonds("x1+pointangle(0,0,0,1,0,0,1,1,0)"), "its expression");
    CustomBondForce* bonds = new CustomBondForce("k*r");
    bonds->addGlobalParameter("k", 1);
    bonds->addPerBondParameter("k");
    bonds->addBond(0, 1, {2});
    assertForeign(bonds, "the name k means two things in its expression");
    bonds = new CustomBondForce("2*r");
    bonds->addPerBondParameter("r");
    assertForeign(bonds, "the name r means two things in its expression");
    bonds = createBonds("a*r");
    bonds->addBond(0, 1, {numeric_limits<double>::quiet_NaN()});
    assertForeign(bonds, "one of its parameters is infinite or not a number");
}

/**
 * A class that knows better than the one it is derived from.
 */
class DerivedForce : public HarmonicBondForce {};

void testUnknownForces()
{
    assertForeign(new DerivedForce(), "openmm-chaintree has no code for a DerivedForce");
    assertForeign(new CustomHbondForce("distance(d1,a1)"), "openmm-chaintree has no code for a CustomHbondForce");
}

static CustomCentroidBondForce* createCentroidBonds(const vector<int>& particles, const vector<double>& weights = {})
{
    CustomCentroidBondForce* force = new CustomCentroidBondForce(2, "distance(g1,g2)");
    force->addGroup(particles, weights);
    force->addGroup({1});
    force->addBond({0, 1});
    return force;
}

void testCentroidBonds()
{
    CustomCentroidBondForce* bonds = createCentroidBonds({0});
    bonds->setUsesPeriodicBoundaryConditions(true);
    assertForeign(bonds, "it uses periodic boundary conditions");
    bonds = createCentroidBonds({0});
    bonds->setEnergyFunction("table(distance(g1,g2))");
    bonds->addTabulatedFunction("table", new Continuous1DFunction({0, 1, 2}, 0, 10));
    assertForeign(bonds, "its expression uses the tabulated function table");
    assertForeign(createCentroidBonds(vector<int>(1001, 0)), "one of its groups has more than 1000 particles");
}

void testEditedForces()
{
    // A Force can become anything after its Context was made.

    EnergyTerms terms;
    System system;
    for (int i = 0; i < NUM_BEADS; i++)
        system.addParticle(1);
    unique_ptr<HarmonicBondForce> bonds(new HarmonicBondForce());
    bonds->addBond(0, 1, 1, 1);
    bonds->setBondParameters(0, 0, NUM_BEADS, 1, 1);
    ASSERT_EQUAL("there is no particle 15", translateForce(*bonds, 1, system, {}, terms));
    unique_ptr<CustomBondForce> custom(createBonds("unknown*r"));
    ASSERT(translateForce(*custom, 2, system, {{"g", 1}}, terms).find("unknown variable, unknown") != string::npos);
    custom->setEnergyFunction("r+");
    ASSERT(translateForce(*custom, 2, system, {{"g", 1}}, terms).find("it cannot be read") == 0);
    custom->setEnergyFunction("a*r");
    ASSERT(translateForce(*custom, 2, system, {}, terms).find("it cannot be read") == 0);
    custom->addBond(0, 1, {1, 2});
    ASSERT_EQUAL("one of its terms has a wrong number of particles or parameters",
                 translateForce(*custom, 2, system, {{"g", 1}}, terms));
    ASSERT_EQUAL(0, terms.termSets.size());
}

int main()
{
    return runOnPlatform("Reference", [](Platform&) {
        testPeriodicForcesAreForeign();
        testForeignNonbondedForces();
        testForeignExpressions();
        testUnknownForces();
        testCentroidBonds();
        testEditedForces();
    });
}
