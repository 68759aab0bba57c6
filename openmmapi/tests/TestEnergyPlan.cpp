/**
 * This tests who evaluates the energy of each Force, and what is said about it.
 */

#include "NativeEnergySupport.h"
#include "openmm/AndersenThermostat.h"
#include "openmm/CMMotionRemover.h"
#include "openmm/CustomBondForce.h"
#include "openmm/CustomCentroidBondForce.h"
#include "openmm/CustomNonbondedForce.h"
#include "openmm/GBSAOBCForce.h"
#include "openmm/MonteCarloBarostat.h"
#include "openmm/PeriodicTorsionForce.h"
#include "openmm/TabulatedFunction.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static void assertEntry(const EnergyPlan& plan, int force, EnergyPlan::Kind kind, const string& reason)
{
    const EnergyPlan::Entry& entry = plan.getEntries()[force];
    if (entry.kind != kind || entry.reason != reason)
        throw OpenMMException("force " + to_string(force) + ": expected \"" + reason + "\", found kind " +
                              to_string(entry.kind) + ", \"" + entry.reason + "\"");
}

/**
 * Let the scene say which terms can change.
 */
static void countChangeableTerms(NativeScene& scene, bool somethingMoves = true)
{
    vector<int> counts;
    scene.getEnergy().countChangeableTerms(counts);
    scene.plan->setChangeableTerms(counts, somethingMoves);
}

static NonbondedForce* createNonbonded()
{
    NonbondedForce* force = new NonbondedForce();
    for (int i = 0; i < NativeScene::NUM_BEADS; i++)
        force->addParticle(0.1, 0.3, 1);
    return force;
}

void testKinds()
{
    NativeScene scene;
    HarmonicBondForce* bonds = new HarmonicBondForce();
    for (int i = 0; i < 8; i++)
        bonds->addBond(i, i + 1, 1, 1);
    const int constant = scene.add(bonds);
    HarmonicBondForce* distances = new HarmonicBondForce();
    distances->setName("distances");
    distances->addBond(0, 1, 1, 1); // within a link
    distances->addBond(0, 2, 1, 1); // across the bond of a torsion
    distances->addBond(0, 3, 1, 1);
    const int mixed = scene.add(distances);
    PeriodicTorsionForce* torsions = new PeriodicTorsionForce();
    for (int i = 0; i < 6; i++)
        torsions->addTorsion(i, i + 1, i + 2, i + 3, 2, 1, 1);
    const int native = scene.add(torsions);
    HarmonicBondForce* one = new HarmonicBondForce();
    one->addBond(1, 12, 1, 1);
    const int single = scene.add(one);
    const int empty = scene.add(new HarmonicAngleForce());
    const int pairs = scene.add(createNonbonded());
    CustomNonbondedForce* expression = new CustomNonbondedForce("r");
    for (int i = 0; i < NativeScene::NUM_BEADS; i++)
        expression->addParticle();
    const int morePairs = scene.add(expression);
    CustomCentroidBondForce* centroids = new CustomCentroidBondForce(2, "same(distance(g1,g2))");
    centroids->addTabulatedFunction("same",
                                    new Continuous1DFunction({0, 30}, 0, 30)); // so that only OpenMM can evaluate it
    centroids->addGroup({0, 1, 2});
    centroids->addGroup({7, 8});
    centroids->addBond({0, 1});
    const int foreign = scene.add(centroids);
    const int remover = scene.add(new CMMotionRemover());
    const int thermostat = scene.add(new AndersenThermostat(300, 1));
    scene.build();
    assertEntry(*scene.plan, constant, EnergyPlan::Native, "openmm-chaintree evaluates it");
    countChangeableTerms(scene);
    const EnergyPlan& plan = *scene.plan;
    assertEntry(plan, 0, EnergyPlan::None, "its spheres are hard, so that they have no energy");
    assertEntry(plan, constant, EnergyPlan::Constant, "no move can change its 8 terms");
    assertEntry(plan, mixed, EnergyPlan::Native, "moves can change 1 of its 3 terms; the rest are constant");
    assertEntry(plan, native, EnergyPlan::Native, "moves can change all of its 6 terms");
    assertEntry(plan, single, EnergyPlan::Native, "moves can change its one term");
    assertEntry(plan, empty, EnergyPlan::Constant, "it has no terms");
    assertEntry(plan, pairs, EnergyPlan::Native, "openmm-chaintree evaluates the pairs that a trial changes");
    assertEntry(plan, morePairs, EnergyPlan::Native, "openmm-chaintree evaluates the pairs that a trial changes");
    assertEntry(plan, foreign, EnergyPlan::Foreign, "its expression uses the tabulated function same");
    assertEntry(plan, remover, EnergyPlan::None, "it has no energy");
    assertEntry(plan, thermostat, EnergyPlan::None, "it has no energy");
    ASSERT_EQUAL("distances", plan.getEntries()[mixed].name);
    ASSERT_EQUAL(1 << constant | 1 << empty, plan.getGroups(EnergyPlan::Constant));
    ASSERT_EQUAL(1 << mixed | 1 << native | 1 << single | 1 << pairs | 1 << morePairs,
                 plan.getGroups(EnergyPlan::Native));
    ASSERT_EQUAL(1 << foreign, plan.getGroups(EnergyPlan::Foreign));
    ASSERT_EQUAL(plan.getGroups(EnergyPlan::Constant) | plan.getGroups(EnergyPlan::Native),
                 plan.getWhollyNativeGroups());

    // Energies are those of their Forces.

    vector<double> energies = scene.computeEnergies();
    ASSERT_EQUAL(scene.chain.system.getNumForces(), energies.size());
    for (int i = 1; i < scene.chain.system.getNumForces(); i++)
        ASSERT_EQUAL_TOL(i == foreign ? 0 : scene.computeOpenMMEnergy(1 << i), energies[i], 1e-5);

    // Where nothing moves all is constant.

    countChangeableTerms(scene, false);
    assertEntry(plan, native, EnergyPlan::Constant, "no move can change its 6 terms");
    assertEntry(plan, pairs, EnergyPlan::Constant, "nothing moves");
    assertEntry(plan, morePairs, EnergyPlan::Constant, "nothing moves");
}

void testGroups()
{
    NativeScene scene;
    scene.chain.system.setDefaultPeriodicBoxVectors(Vec3(9, 0, 0), Vec3(0, 9, 0), Vec3(0, 0, 9));
    HarmonicBondForce* bonds = new HarmonicBondForce();
    bonds->addBond(0, 3, 1, 1);
    bonds->setForceGroup(5);
    NonbondedForce* pme = createNonbonded();
    pme->setNonbondedMethod(NonbondedForce::PME);
    pme->setCutoffDistance(1);
    pme->setForceGroup(5);
    pme->setReciprocalSpaceForceGroup(6);
    NonbondedForce* pairs = createNonbonded();
    pairs->setForceGroup(31);
    pairs->setReciprocalSpaceForceGroup(3); // without a meaning for this method
    scene.add(bonds);
    scene.add(pme);
    scene.add(pairs);
    const int barostat = scene.add(new MonteCarloBarostat(1, 300));
    scene.build();
    EnergyPlan& plan = *scene.plan;
    assertEntry(plan, barostat, EnergyPlan::None, "it has no energy");
    assertEntry(plan, 2, EnergyPlan::Foreign, "PME is periodic");
    ASSERT_EQUAL(1 << 5 | 1 << 6, plan.getGroups(EnergyPlan::Foreign));
    ASSERT_EQUAL((int)(1u << 31 | 1u << 5), plan.getGroups(EnergyPlan::Native));
    ASSERT_EQUAL((int)(1u << 31), plan.getWhollyNativeGroups());

    // OpenMM goes by the groups that Forces had when the Context was made.

    const string outside = "its force group is not an integration force group";
    bonds->setForceGroup(7);
    plan.translate(1 << 7, true, TorsionMonteCarloIntegrator::Hard);
    for (int i = 1; i < 4; i++)
        assertEntry(plan, i, EnergyPlan::None, outside);
    ASSERT_EQUAL(0, plan.getTerms().termSets.size());
    plan.translate(1 << 6 | 1 << 3, true, TorsionMonteCarloIntegrator::Hard);
    assertEntry(plan, 1, EnergyPlan::None, outside);
    assertEntry(plan, 2, EnergyPlan::Foreign, "PME is periodic");
    assertEntry(plan, 3, EnergyPlan::None, outside);
    plan.translate(1 << 5, true, TorsionMonteCarloIntegrator::Hard);
    assertEntry(plan, 1, EnergyPlan::Native, "openmm-chaintree evaluates it");

    // Today's way.

    plan.translate(-1, false, TorsionMonteCarloIntegrator::Soft);
    assertEntry(plan, 0, EnergyPlan::Native, "its soft spheres are a part of the energy");
    for (int i = 1; i < 4; i++)
        assertEntry(plan, i, EnergyPlan::Foreign, "native energies are switched off");
    ASSERT_EQUAL(0, plan.getTerms().termSets.size() + plan.getTerms().nonbonded.size());
    ASSERT_EQUAL(0, plan.getWhollyNativeGroups());
}

void testEditedForces()
{
    // What becomes of Forces means nothing to a Context until it copies their parameters, nor does it here.

    NativeScene scene;
    HarmonicBondForce* edited = new HarmonicBondForce();
    HarmonicBondForce* removed = new HarmonicBondForce();
    edited->addBond(0, 3, 1, 10);
    removed->addBond(0, 4, 1, 20);
    scene.add(edited);
    const int removedIndex = scene.add(removed);
    scene.build();
    EnergyPlan& plan = *scene.plan;
    edited->setBondParameters(0, 0, 3, 1, 11);
    scene.chain.system.removeForce(removedIndex);
    plan.translate(-1, true, TorsionMonteCarloIntegrator::Hard);
    ASSERT_EQUAL(10, plan.getTerms().termSets[0].parameters[1]);
    ASSERT_EQUAL(20, plan.getTerms().termSets[1].parameters[1]);
    plan.copyForces();
    plan.translate(-1, true, TorsionMonteCarloIntegrator::Hard);
    ASSERT_EQUAL(11, plan.getTerms().termSets[0].parameters[1]);
    ASSERT_EQUAL(20, plan.getTerms().termSets[1].parameters[1]);
}

void testTwoLevels()
{
    NativeScene scene;
    GBSAOBCForce* solvent = new GBSAOBCForce();
    for (int i = 0; i < NativeScene::NUM_BEADS; i++)
        solvent->addParticle(0.1, 0.3, 0.8);
    CustomNonbondedForce* expression = new CustomNonbondedForce("r");
    for (int i = 0; i < NativeScene::NUM_BEADS; i++)
        expression->addParticle();
    const int born = scene.add(solvent), morePairs = scene.add(expression), pairs = scene.add(createNonbonded());
    scene.build();
    EnergyPlan& plan = *scene.plan;
    countChangeableTerms(scene);
    const string twoLevels = "trials use a stand-in";
    assertEntry(plan, born, EnergyPlan::Native, twoLevels);
    assertEntry(plan, pairs, EnergyPlan::Native, twoLevels);
    assertEntry(plan, morePairs, EnergyPlan::Native, "openmm-chaintree evaluates the pairs that a trial changes");
    ASSERT_EQUAL(1 << born | 1 << pairs | 1 << morePairs, plan.getWhollyNativeGroups());
    countChangeableTerms(scene, false);
    assertEntry(plan, born, EnergyPlan::Constant, "nothing moves");

    // Neither is what it is without the other.

    plan.translate(1 << pairs, true, TorsionMonteCarloIntegrator::Hard);
    countChangeableTerms(scene);
    assertEntry(plan, pairs, EnergyPlan::Native, "openmm-chaintree evaluates the pairs that a trial changes");
    plan.translate(1 << born, true, TorsionMonteCarloIntegrator::Hard);
    assertEntry(plan, born, EnergyPlan::Foreign, "it needs a NonbondedForce that openmm-chaintree evaluates, too");
}

int main()
{
    return runOnPlatform("Reference", [](Platform&) {
        testKinds();
        testGroups();
        testTwoLevels();
        testEditedForces();
    });
}
