/**
 * This tests that a Force that was misread is found by comparison with OpenMM, and named.
 */

#include "NativeEnergySupport.h"
#include "openmm/CMAPTorsionForce.h"
#include "openmm/CustomAngleForce.h"
#include "openmm/CustomBondForce.h"
#include "openmm/CustomCompoundBondForce.h"
#include "openmm/CustomExternalForce.h"
#include "openmm/CustomNonbondedForce.h"
#include "openmm/CustomTorsionForce.h"
#include "openmm/GBSAOBCForce.h"
#include "openmm/PeriodicTorsionForce.h"
#include "openmm/RBTorsionForce.h"
#include "openmm/TabulatedFunction.h"
#include "openmm/VirtualSite.h"
#include "openmmchaintree/internal/NativeEnergyCheck.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include <limits>
#include <map>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * A scene whose energies are checked.
 */
class CheckedScene : public NativeScene {
public:
    void build()
    {
        NativeScene::build();
        check.reset(new NativeEnergyCheck(getImpl(), *plan, [this] {
            return createScene();
        }));
    }
    /**
     * Check the scene's energies.
     */
    bool run()
    {
        return run(computeEnergies());
    }
    bool run(const vector<double>& energies)
    {
        vector<Vec3> positions;
        getScene().getPositions(positions);
        groupsAskedFor = 0;
        return check->check(positions, energies, [this](int groups) {
            groupsAskedFor |= groups;
            return computeOpenMMEnergy(groups);
        });
    }
    void assertFound(const string& message)
    {
        assertThrows(message, [this] {
            run();
        });
    }
    void translate()
    {
        plan->translate(-1, true, TorsionMonteCarloIntegrator::Hard);
        getEnergy().setTerms(plan->getTerms());
    }
    void copyForces()
    {
        plan->copyForces();
        translate();
    }
    void setPositions(const vector<Vec3>& positions)
    {
        context->setPositions(positions);
        getScene().setPositions(positions);
    }
    unique_ptr<NativeEnergyCheck> check;
    int groupsAskedFor;
};

static NonbondedForce* createNonbonded()
{
    OddNumbers numbers(1);
    NonbondedForce* force = new NonbondedForce();
    for (int i = 0; i < NativeScene::NUM_BEADS; i++)
        force->addParticle(numbers.between(-1, 1), numbers.between(0.8, 1), numbers.between(1, 3));
    for (int i = 0; i < 8; i++)
        force->addException(i, i + 1, 0, 1, 0);
    force->addException(0, 3, 0.5, 0.8, 200);
    force->setNonbondedMethod(NonbondedForce::CutoffNonPeriodic);
    force->setCutoffDistance(2);
    force->setUseSwitchingFunction(true);
    force->setSwitchingDistance(0.5);
    return force;
}

/**
 * Add a Force of each kind that is native.
 */
static map<string, int> addAllKinds(NativeScene& scene)
{
    HarmonicBondForce* bonds = new HarmonicBondForce();
    bonds->addBond(0, 4, 1.5, 10);
    HarmonicAngleForce* angles = new HarmonicAngleForce();
    angles->addAngle(0, 3, 6, 1.5, 10);
    PeriodicTorsionForce* periodic = new PeriodicTorsionForce();
    periodic->addTorsion(0, 1, 2, 3, 3, 0.5, 10);
    RBTorsionForce* rb = new RBTorsionForce();
    rb->addTorsion(1, 2, 3, 4, 100, 200, 300, 400, 500, 600);
    CMAPTorsionForce* maps = new CMAPTorsionForce();
    maps->addMap(3, {1, 2, 3, 4, -5, 6, 7, 8, -9});
    maps->addTorsion(0, 0, 1, 2, 3, 1, 2, 3, 4);
    CustomBondForce* customBonds = new CustomBondForce("k*(r-1)^2");
    customBonds->addPerBondParameter("k");
    customBonds->addBond(0, 4, {10});
    CustomAngleForce* customAngles = new CustomAngleForce("k*(theta-1)^2");
    customAngles->addPerAngleParameter("k");
    customAngles->addAngle(0, 3, 6, {10});
    CustomTorsionForce* customTorsions = new CustomTorsionForce("k*cos(theta-1)");
    customTorsions->addPerTorsionParameter("k");
    customTorsions->addTorsion(0, 1, 2, 3, {10});
    CustomCompoundBondForce* compound = new CustomCompoundBondForce(3, "k*distance(p1,p2)+angle(p1,p2,p3)");
    compound->addPerBondParameter("k");
    compound->addBond({0, 5, 9}, {10});
    CustomExternalForce* external = new CustomExternalForce("k*(x^2+y-z)");
    external->addPerParticleParameter("k");
    external->addParticle(7, {10});
    CustomNonbondedForce* customPairs = new CustomNonbondedForce("20*a1*a2/r+f(floor(r))");
    customPairs->addPerParticleParameter("a");
    customPairs->addTabulatedFunction("f", new Discrete1DFunction({1, 2, 4, 7, 9, 10}));
    customPairs->addInteractionGroup({0, 1, 2, 3}, {7, 8, 9, 10, 11});
    customPairs->addExclusion(3, 11);
    for (int i = 0; i < NativeScene::NUM_BEADS; i++)
        customPairs->addParticle({1 + 0.1 * i});
    customPairs->setNonbondedMethod(CustomNonbondedForce::CutoffNonPeriodic);
    customPairs->setCutoffDistance(6);
    customPairs->setUseSwitchingFunction(true);
    customPairs->setSwitchingDistance(1);
    map<string, int> added;
    for (Force* force : vector<Force*>{bonds, angles, periodic, rb, maps, customBonds, customAngles, customTorsions,
                                       compound, external, createNonbonded(), customPairs})
        added[force->getName()] = scene.add(force);
    return added;
}

void testMisreadForces()
{
    CheckedScene scene;
    map<string, int> added = addAllKinds(scene);
    scene.build();
    ASSERT(scene.run());
    ASSERT_EQUAL(scene.plan->getGroups(EnergyPlan::Native), scene.groupsAskedFor);
    const EnergyTerms truth = scene.plan->getTerms();
    auto plant = [&](const string& name, const string& what, const function<void(EnergyTerms&)>& misread) {
        EnergyTerms terms = truth;
        misread(terms);
        scene.getEnergy().setTerms(terms);
        try {
            scene.assertFound("the energy of force " + to_string(added[name]) + " (" + name + ")");
        }
        catch (const exception& error) {
            throw OpenMMException(what + ": " + error.what());
        }
    };
    for (size_t i = 0; i < truth.termSets.size(); i++) {
        const string name = scene.plan->getEntries()[truth.termSets[i].force].name;
        plant(name, "a wrong particle", [&](EnergyTerms& terms) {
            terms.termSets[i].particles[0] = 14;
        });
        plant(name, "a term left out", [&](EnergyTerms& terms) {
            terms.termSets[i].particles.clear();
            terms.termSets[i].parameters.clear();
        });
        if (truth.termSets[i].kind != ctTorsionMapTerm)
            for (size_t j = 0; j < truth.termSets[i].parameters.size(); j++)
                plant(name, "a wrong parameter " + to_string(j), [&](EnergyTerms& terms) {
                    double& parameter = terms.termSets[i].parameters[j];
                    parameter = truth.termSets[i].kind == ctPeriodicTorsionTerm && j == 0 ? 2 : 1.01 * parameter;
                });
        for (size_t j = 0; j < truth.termSets[i].operations.size(); j++)
            if (truth.termSets[i].operations[j].constant != 0)
                plant(name, "a wrong constant", [&](EnergyTerms& terms) {
                    terms.termSets[i].operations[j].constant += 0.01;
                });
        for (size_t j = 0; j < truth.termSets[i].inputs.size(); j++)
            if (truth.termSets[i].particlesPerTerm > 1)
                plant(name, "a wrong input", [&](EnergyTerms& terms) {
                    swap(terms.termSets[i].inputs[j].particles[0], terms.termSets[i].inputs[j].particles[1]);
                    terms.termSets[i].inputs[j].measure = ctMeasureX;
                });
    }
    plant("CMAPTorsionForce", "angles in the wrong order", [](EnergyTerms& terms) {
        for (EnergyTerms::TermSet& set : terms.termSets)
            if (set.kind == ctTorsionMapTerm)
                rotate(set.particles.begin(), set.particles.begin() + 4, set.particles.end());
    });
    const string expressions = "CustomNonbondedForce";
    plant(expressions, "no pairs", [](EnergyTerms& terms) {
        terms.pairSets[0].operations = {{ctConstantOperator, {}, 0}};
    });
    plant(expressions, "a wrong parameter", [](EnergyTerms& terms) {
        terms.pairSets[0].parameters[9] *= 1.01;
    });
    plant(expressions, "a wrong constant", [](EnergyTerms& terms) {
        for (ctOperation& operation : terms.pairSets[0].operations)
            operation.constant *= 1.01;
    });
    plant(expressions, "a wrong table", [](EnergyTerms& terms) {
        for (double& value : terms.pairSets[0].tables[0].values)
            value += 0.01;
    });
    plant(expressions, "a wrong cutoff", [](EnergyTerms& terms) {
        terms.pairSets[0].cutoff *= 1.05;
    });
    plant(expressions, "no switch", [](EnergyTerms& terms) {
        terms.pairSets[0].switchingDistance = terms.pairSets[0].cutoff;
    });
    plant(expressions, "no groups", [](EnergyTerms& terms) {
        terms.pairSets[0].groups.clear();
    });
    plant(expressions, "a lost exclusion", [](EnergyTerms& terms) {
        terms.pairSets[0].exclusions.clear();
    });
    const string pairs = "NonbondedForce";
    plant(pairs, "no pairs", [](EnergyTerms& terms) {
        terms.nonbonded.clear();
    });
    plant(pairs, "a wrong charge", [](EnergyTerms& terms) {
        terms.nonbonded[0].charges[4] += 0.01;
    });
    plant(pairs, "a wrong sigma", [](EnergyTerms& terms) {
        terms.nonbonded[0].sigmas[4] *= 1.05;
    });
    plant(pairs, "a wrong epsilon", [](EnergyTerms& terms) {
        terms.nonbonded[0].epsilons[4] *= 1.5;
    });
    plant(pairs, "a wrong cutoff", [](EnergyTerms& terms) {
        terms.nonbonded[0].cutoff *= 1.05;
    });
    plant(pairs, "no switch", [](EnergyTerms& terms) {
        terms.nonbonded[0].switchingDistance = terms.nonbonded[0].cutoff;
    });
    plant(pairs, "a wrong dielectric", [](EnergyTerms& terms) {
        terms.nonbonded[0].dielectric = 1;
    });
    plant(pairs, "a lost exclusion", [](EnergyTerms& terms) {
        terms.nonbonded[0].exclusions[0] = {0, 14};
    });
    scene.getEnergy().setTerms(truth);
    ASSERT(scene.run());
}

void testMisreadSolvent()
{
    CheckedScene scene;
    NonbondedForce* pairs = createNonbonded();
    GBSAOBCForce* solvent = new GBSAOBCForce();
    for (int i = 0; i < NativeScene::NUM_BEADS; i++) {
        double charge, sigma, epsilon;
        pairs->getParticleParameters(i, charge, sigma, epsilon);
        solvent->addParticle(charge, 0.3 + 0.01 * i, 0.8);
    }
    const int index = scene.add(solvent);
    scene.add(pairs);
    scene.build();
    ASSERT(scene.run());
    ASSERT_EQUAL(scene.plan->getGroups(EnergyPlan::Native), scene.groupsAskedFor);
    const EnergyTerms truth = scene.plan->getTerms();
    auto plant = [&](const string& what, const function<void(EnergyTerms::Born&)>& misread) {
        EnergyTerms terms = truth;
        misread(terms.born[0]);
        scene.getEnergy().setTerms(terms);
        try {
            scene.assertFound("the energy of force " + to_string(index) + " (GBSAOBCForce)");
        }
        catch (const exception& error) {
            throw OpenMMException(what + ": " + error.what());
        }
    };
    plant("a wrong charge", [](EnergyTerms::Born& born) {
        born.charges[4] += 0.01;
    });
    plant("a wrong radius", [](EnergyTerms::Born& born) {
        born.radii[4] += 0.02;
    });
    plant("a wrong offset radius", [](EnergyTerms::Born& born) {
        born.offsetRadii[4] += 0.01;
    });
    plant("a wrong scaled radius", [](EnergyTerms::Born& born) {
        born.scaledRadii[4] += 0.1;
    });
    plant("another rescaling", [](EnergyTerms::Born& born) {
        fill(born.alphas.begin(), born.alphas.end(), 0.5);
    });
    plant("a wrong dielectric", [](EnergyTerms::Born& born) {
        born.solventDielectric = 60;
    });
    plant("salt", [](EnergyTerms::Born& born) {
        born.kappa = 1;
    });
    plant("no surface", [](EnergyTerms::Born& born) {
        born.surfaceEnergy = 0;
    });
    plant("a cutoff", [](EnergyTerms::Born& born) {
        born.cutoff = 2;
    });
    scene.getEnergy().setTerms(truth);
    ASSERT(scene.run());
}

void testManyForces()
{
    CheckedScene scene;
    for (int i = 0; i < 70; i++) {
        HarmonicBondForce* bonds = new HarmonicBondForce();
        bonds->addBond(0, 3 + i % 8, 1, 1 + i);
        scene.add(bonds);
    }
    scene.build();
    ASSERT(scene.run());
    for (int i : {0, 31, 32, 63, 69}) {
        EnergyTerms terms = scene.plan->getTerms();
        terms.termSets[i].parameters[0] += 0.1;
        scene.getEnergy().setTerms(terms);
        scene.assertFound("the energy of force " + to_string(i + 1) + " (HarmonicBondForce)");
    }
}

void testEditedForces()
{
    CheckedScene scene;
    HarmonicBondForce* bonds = new HarmonicBondForce();
    bonds->addBond(0, 4, 1.5, 10);
    bonds->setForceGroup(5);
    HarmonicAngleForce* angles = new HarmonicAngleForce();
    angles->addAngle(0, 3, 6, 1.5, 10);
    angles->setForceGroup(5);
    scene.add(bonds);
    scene.add(angles);
    scene.build();
    ASSERT(scene.run());

    // An edit that OpenMM does not see.

    bonds->setBondParameters(0, 0, 4, 2.5, 100);
    scene.translate();
    ASSERT(scene.run());
    scene.copyForces();
    scene.assertFound("the Context's energy of force group 5");
    scene.assertFound(
        "without updateParametersInContext() or in values that it does not copy: force 1 (HarmonicBondForce), "
        "force 2 (HarmonicAngleForce)");
    bonds->updateParametersInContext(*scene.context);
    ASSERT(scene.run());
}

void testGlobalParameters()
{
    CheckedScene scene;
    CustomBondForce* bonds = new CustomBondForce("k*r");
    bonds->addGlobalParameter("k", 2);
    bonds->addBond(0, 4);
    scene.add(bonds);
    scene.build();
    ASSERT(scene.run());
    scene.context->setParameter("k", 3);
    scene.assertFound("the energy of force 1 (CustomBondForce)");
    scene.translate();
    ASSERT(scene.run());
}

void testForeignForcesInAGroup()
{
    CheckedScene scene;
    HarmonicBondForce* bonds = new HarmonicBondForce();
    bonds->addBond(0, 4, 1.5, 10);
    bonds->setForceGroup(5);
    scene.add(bonds);
    GBSAOBCForce* gb = new GBSAOBCForce();
    for (int i = 0; i < NativeScene::NUM_BEADS; i++)
        gb->addParticle(0.5, 0.3, 0.8);
    gb->setForceGroup(5);
    scene.add(gb);
    scene.build();
    ASSERT(scene.run());
    ASSERT_EQUAL(0, scene.groupsAskedFor);
}

/**
 * Waters on a lattice, all alike, which have the same distances to the last bit again and again.
 */
static void addLattice(CheckedScene& scene, int size, double spacing, NonbondedForce& pairs)
{
    const Vec3 water[] = {Vec3(0, 0, 0), Vec3(0.09572, 0, 0), Vec3(-0.02399, 0.09266, 0)};
    for (int i = 0; i < NativeScene::NUM_BEADS; i++)
        pairs.addParticle(0, 1, 0);
    for (int i = 0; i < size * size * size; i++) {
        const Vec3 origin(i % size, i / size % size, i / size / size);
        const int first = scene.chain.system.getNumParticles();
        for (int j = 0; j < 3; j++) {
            scene.chain.system.addParticle(1);
            scene.chain.force->addParticle(0.05);
            scene.chain.positions.push_back(origin * spacing + water[j]);
            pairs.addParticle(j == 0 ? -0.834 : 0.417, 0.315, j == 0 ? 0.636 : 0);
        }
        for (int j = 0; j < 3; j++) {
            if (j > 0)
                scene.chain.force->addBond(first, first + j);
            pairs.addException(first + j, first + (j + 1) % 3, 0, 1, 0);
        }
    }
}

void testRoundingAlike()
{
    CheckedScene scene;
    NonbondedForce* pairs = new NonbondedForce();
    addLattice(scene, 8, 0.31, *pairs);
    const int index = scene.add(pairs);
    scene.build();

    // What is computed on a lattice is farther off than single precision usually makes it.

    vector<double> energies = scene.computeEnergies();
    const double error = energies[index] - scene.computeOpenMMEnergy(1 << index);
    ASSERT(fabs(error) > 0.05);
    ASSERT(scene.run(energies));

    // An energy that is wrong by more than that is found, and misread Forces are.

    const string message = "the energy of force " + to_string(index) + " (NonbondedForce)";
    energies[index] += 4 * error;
    assertThrows(message, [&] {
        scene.run(energies);
    });
    const_cast<EnergyTerms&>(scene.plan->getTerms()).nonbonded[0].charges[NativeScene::NUM_BEADS] += 0.01;
    scene.getEnergy().setTerms(scene.plan->getTerms());
    scene.assertFound(message);
}

void testEditedStructure()
{
    // What is compared near a lattice is of the structure that the Context was made with, whatever becomes of it.

    CheckedScene scene;
    NonbondedForce* pairs = new NonbondedForce();
    addLattice(scene, 6, 0.31, *pairs);
    scene.add(pairs);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addRigidBodyMove(1, 0.01, 0.1);
    Context context(scene.chain.system, integrator, Platform::getPlatform("Reference"));
    context.setPositions(scene.chain.positions);
    scene.chain.force->addBond(0, NativeScene::NUM_BEADS);
    scene.chain.force->addParticle(0.05);
    integrator.step(1);
    ASSERT_EQUAL(1, context.getStepCount());
}

void testHugeEnergies()
{
    CheckedScene scene;
    const int pairs = scene.add(createNonbonded());
    scene.build();

    // Pairs that overlap have energies beyond what single precision resolves, or has at all. Then the check says that
    // it says little.

    for (double distance : {0.1, 0.01, 1e-3, 1e-4, 1e-6, 1e-12, 0.0}) {
        vector<Vec3> positions = scene.chain.positions;
        positions[11] = positions[3] + Vec3(0, distance, 0);
        scene.setPositions(positions);
        ASSERT(!scene.run());
    }

    // Of a sound state nobody may find no energy, nor of another one any.

    scene.setPositions(scene.chain.positions);
    ASSERT(scene.run());
    vector<double> energies = scene.computeEnergies();
    for (double energy : {numeric_limits<double>::quiet_NaN(), numeric_limits<double>::infinity(), 1e300}) {
        energies[pairs] = energy;
        assertThrows("the energy of force 1 (NonbondedForce)", [&] {
            scene.run(energies);
        });
    }
    vector<Vec3> positions = scene.chain.positions;
    positions[11] = positions[3];
    scene.setPositions(positions);
    energies[pairs] = -300;
    assertThrows("is not a number: that of force 1 (NonbondedForce) by OpenMM", [&] {
        scene.run(energies);
    });
}

void testVirtualSites()
{
    CheckedScene scene;
    const int site = scene.chain.system.addParticle(0);
    scene.chain.system.setVirtualSite(site, new TwoParticleAverageSite(7, 8, 0.3, 0.7));
    scene.chain.force->addParticle(0);
    scene.chain.positions.push_back(scene.chain.positions[7] * 0.3 + scene.chain.positions[8] * 0.7);
    NonbondedForce* pairs = createNonbonded();
    pairs->addParticle(0.5, 0.5, 1);
    pairs->addException(site, 7, 0, 1, 0);
    pairs->addException(site, 8, 0, 1, 0);
    HarmonicBondForce* bonds = new HarmonicBondForce();
    bonds->addBond(site, 0, 1, 10);
    scene.add(pairs);
    scene.add(bonds);
    scene.build();
    ASSERT(scene.run());
    for (int i = 0; i < 20; i++) {
        scene.getScene().propose(Proposal().addTorsion(i % 8, 0.02));
        scene.getScene().accept();
        ASSERT(scene.run());
        vector<Vec3> positions;
        scene.getScene().getPositions(positions);
        scene.context->setPositions(positions);
        scene.context->computeVirtualSites();
        ASSERT_EQUAL_VEC(positions[site], getPositions(*scene.context)[site], 1e-12);
    }
}

int main()
{
    return runOnPlatform("Reference", [](Platform&) {
        testMisreadForces();
        testMisreadSolvent();
        testManyForces();
        testEditedForces();
        testGlobalParameters();
        testForeignForcesInAGroup();
        testRoundingAlike();
        testEditedStructure();
        testHugeEnergies();
        testVirtualSites();
    });
}
