/**
 * This tests atom moves: which particles move together and how far, what is refused, how sizes adapt by class, and that
 * checkpoints, States and XML hold all of it.
 */

#include "CheckpointSupport.h"
#include "openmm/CustomExternalForce.h"
#include "openmm/HarmonicAngleForce.h"
#include "openmm/HarmonicBondForce.h"
#include "openmm/serialization/XmlSerializer.h"
#include "openmm/VirtualSite.h"
#include "openmmchaintree/internal/AtomGroups.h"
#include "SamplingSupport.h"
#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * A molecule like ethanol, without hydrogens at its first carbon: C0-C1-O2-H3, hydrogens 4 and 5 at C1; a torsion about
 * C1-O2; and beside it a single atom 6.
 */
class Ethanol {
public:
    explicit Ethanol(double hydrogenMass = 1.008) : force(new StericExclusionForce()), bonds(new HarmonicBondForce())
    {
        const double moved = hydrogenMass - 1.008; // from the heavy atoms
        for (double mass :
             {12.011, 12.011 - 2 * moved, 15.999 - moved, hydrogenMass, hydrogenMass, hydrogenMass, 39.95})
            system.addParticle(mass);
        positions = {{0, 0, 0},           {0.15, 0, 0},         {0.2, 0.13, 0}, {0.28, 0.12, 0.06},
                     {0.18, -0.05, 0.09}, {0.18, -0.05, -0.09}, {0.8, 0.7, 0}};
        for (size_t i = 0; i < positions.size(); i++)
            force->addParticle(0.05);
        for (auto& bond : BONDS) {
            force->addBond(bond.first, bond.second);
            bonds->addBond(bond.first, bond.second, getDistance(positions[bond.first], positions[bond.second]), 2e5);
        }
        force->addTorsion(0, 1, 2, 3);
        force->createExclusionsFromBonds(3);
        system.addForce(force);
        system.addForce(bonds);
    }
    const vector<pair<int, int>> BONDS = {{0, 1}, {1, 2}, {2, 3}, {1, 4}, {1, 5}};
    System system;
    StericExclusionForce* force;
    HarmonicBondForce* bonds;
    vector<Vec3> positions;
};

/**
 * Count how often trials displace each set of particles, and check that each set moves by one vector.
 */
static map<set<int>, int> countSets(Platform& platform, const System& system, const vector<Vec3>& positions,
                                    const vector<int>& particles, bool withHydrogens)
{
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addAtomMove(1, 0.003, particles, withHydrogens);
    integrator.setTrialsPerStep(1);
    integrator.setRandomNumberSeed(5);
    Context context(system, integrator, platform);
    context.setPositions(positions);
    map<set<int>, int> found;
    vector<Vec3> before = getPositions(context);
    for (int i = 0; i < 1000; i++) {
        integrator.step(1);
        const vector<Vec3> after = getPositions(context);
        set<int> moved;
        Vec3 shift;
        for (int j = 0; j < (int)after.size(); j++)
            if (after[j] != before[j]) {
                if (moved.empty())
                    shift = after[j] - before[j];
                if (!system.isVirtualSite(j))
                    ASSERT_EQUAL_VEC(shift, after[j] - before[j], 1e-12);
                moved.insert(j);
            }
        ASSERT(sqrt(shift.dot(shift)) < 0.003);
        if (!moved.empty())
            found[moved]++;
        before = after;
    }
    return found;
}

static set<set<int>> findSets(Platform& platform, const System& system, const vector<Vec3>& positions,
                              const vector<int>& particles, bool withHydrogens)
{
    set<set<int>> found;
    for (auto& counted : countSets(platform, system, positions, particles, withHydrogens))
        found.insert(counted.first);
    return found;
}

static void testGroups(Platform& platform)
{
    for (double hydrogenMass : {1.008, 4.0}) {
        Ethanol molecule(hydrogenMass);
        auto find = [&](const vector<int>& particles, bool withHydrogens) {
            return findSets(platform, molecule.system, molecule.positions, particles, withHydrogens);
        };
        ASSERT(find({}, true) == set<set<int>>({{0}, {1, 4, 5}, {2, 3}, {3}, {4}, {5}, {6}}));
        ASSERT(find({}, false) == set<set<int>>({{0}, {1}, {2}, {3}, {4}, {5}, {6}}));
        ASSERT(find({5, 1}, true) == set<set<int>>({{1, 4, 5}, {5}}));
        ASSERT(find({5, 1}, false) == set<set<int>>({{1}, {5}}));

        // What is in a molecule without a radius or a joint moves only if it is named. Others move even without a
        // radius.

        molecule.force->setParticleParameters(6, 0);
        molecule.force->setParticleParameters(4, 0);
        ASSERT(find({}, false) == set<set<int>>({{0}, {1}, {2}, {3}, {4}, {5}}));
        ASSERT(find({6}, true) == set<set<int>>({{6}}));
    }

    // Beads need no radius.

    System chain;
    StericExclusionForce* beads = new StericExclusionForce();
    chain.addForce(beads);
    for (int i = 0; i < 3; i++) {
        chain.addParticle(100);
        beads->addParticle(0);
    }
    for (int i = 0; i < 2; i++)
        beads->addBond(i, i + 1);
    beads->addBallJoint(1, 2);
    ASSERT(findSets(platform, chain, {{0, 0, 0}, {0.38, 0, 0}, {0.38, 0.38, 0}}, {}, true) ==
           set<set<int>>({{0}, {1}, {2}}));

    // Light particles of one kind are no hydrogens of each other.

    Ethanol light;
    for (int i = 0; i < 7; i++)
        light.system.setParticleMass(i, 1);
    ASSERT(findSets(platform, light.system, light.positions, {0}, true) == set<set<int>>({{0}}));
    System pair;
    StericExclusionForce* spheres = new StericExclusionForce();
    pair.addForce(spheres);
    for (int i = 0; i < 2; i++) {
        pair.addParticle(1);
        spheres->addParticle(0.01);
    }
    spheres->addBond(0, 1);
    ASSERT(findSets(platform, pair, {{0, 0, 0}, {0.07, 0, 0}}, {}, true) == set<set<int>>({{0}, {1}}));
}

static void testConstraints(Platform& platform)
{
    // Bonds of hydrogens.

    Ethanol molecule;
    for (auto& bond : {make_pair(2, 3), make_pair(1, 4), make_pair(5, 1)})
        molecule.system.addConstraint(bond.first, bond.second,
                                      getDistance(molecule.positions[bond.first], molecule.positions[bond.second]));
    for (bool withHydrogens : {false, true})
        ASSERT(findSets(platform, molecule.system, molecule.positions, {}, withHydrogens) ==
               set<set<int>>({{0}, {1, 4, 5}, {2, 3}, {6}}));
    ASSERT(findSets(platform, molecule.system, molecule.positions, {4, 5, 3}, true) ==
           set<set<int>>({{1, 4, 5}, {2, 3}}));

    // They are chosen once, though the list names two of them.

    map<set<int>, int> counts = countSets(platform, molecule.system, molecule.positions, {4, 5, 3}, true);
    const double ratio = counts[{2, 3}] / (double)counts[{1, 4, 5}];
    ASSERT_USUALLY_EQUAL_TOL(1, ratio, 0.25);

    // A bond between links.

    auto make = [&](const vector<int>& particles) {
        TorsionMonteCarloIntegrator integrator(300);
        integrator.addAtomMove(1, 0.01, particles);
        Context context(molecule.system, integrator, platform);
    };
    molecule.system.addConstraint(1, 2, 0.14);
    const string refusal = "move 0 cannot displace particles 1 and 2 as one: a constraint joins them, but a torsion or "
                           "ball joint is between them; build the System with constraints=None";
    assertThrows(refusal, [&] {
        make({});
    });
    assertThrows(refusal, [&] {
        make({3});
    });
    make({0, 6});

    // Rigid water, with a virtual site that follows.

    System water;
    StericExclusionForce* spheres = new StericExclusionForce();
    water.addForce(spheres);
    const vector<Vec3> positions = {{0, 0, 0}, {0.0957, 0, 0}, {-0.024, 0.0927, 0}, {0.0105, 0.0136, 0}};
    for (double mass : {15.999, 1.008, 1.008, 0.0}) {
        water.addParticle(mass);
        spheres->addParticle(mass > 2 ? 0.1 : 0);
    }
    const double a = 0.852834, b = 0.073583;
    water.setVirtualSite(3, new ThreeParticleAverageSite(0, 1, 2, a, b, b));
    for (int i : {1, 2}) {
        spheres->addBond(0, i);
        water.addConstraint(0, i, getDistance(positions[0], positions[i]));
    }
    water.addConstraint(1, 2, getDistance(positions[1], positions[2]));
    ASSERT(findSets(platform, water, positions, {}, true) == set<set<int>>({{0, 1, 2, 3}}));
    assertThrows("move 0 names particle 3, a virtual site, which follows the particles that define it", [&] {
        TorsionMonteCarloIntegrator integrator(300);
        integrator.addAtomMove(1, 0.01, {3});
        Context context(water, integrator, platform);
    });
}

/**
 * In a flexible molecule each virtual site is where OpenMM computes it, trial by trial, though its particles move one
 * by one.
 */
static void testVirtualSites(Platform& platform)
{
    Ethanol molecule;
    auto add = [&](VirtualSite* site) {
        molecule.force->addParticle(0);
        molecule.system.setVirtualSite(molecule.system.addParticle(0), site);
        molecule.positions.push_back(Vec3());
    };
    add(new TwoParticleAverageSite(0, 1, 0.3, 0.7));
    add(new ThreeParticleAverageSite(1, 4, 5, 0.5, 0.2, 0.3));
    add(new OutOfPlaneSite(1, 4, 5, 0.4, 0.3, 2));
    add(new LocalCoordinatesSite({0, 1, 4, 5}, {0.1, 0.6, 0.2, 0.1}, {-1, 0.5, 0.25, 0.25}, {0, -1, 0.2, 0.8},
                                 Vec3(0.03, -0.05, 0.07)));
    for (bool withHydrogens : {true, false}) {
        TorsionMonteCarloIntegrator integrator(300);
        integrator.addAtomMove(1, 0.02, {}, withHydrogens);
        integrator.addTorsionMove(1, M_PI);
        Context context(molecule.system, integrator, platform);
        context.setPositions(molecule.positions);
        context.computeVirtualSites();
        integrator.setRandomNumberSeed(2);
        integrator.step(20);

        // Distances are measured by the scene; the Context computes sites itself.

        const vector<Vec3> positions = getPositions(context);
        for (int site = 7; site < 11; site++) {
            ASSERT(getDistance(positions[site], positions[1]) > 1e-3);
            int first, second;
            for (int other : {0, 3, 4, 6})
                ASSERT_EQUAL_TOL(getDistance(positions[site], positions[other]),
                                 molecule.force->getMinimumDistance(context, {site}, {other}, first, second), 1e-9);
        }
    }

    // What cannot be followed.

    molecule.system.setVirtualSite(
        7, new SymmetrySite(0, Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(1, 0, 0), false));
    assertThrows("displaces particle 0, which virtual site 7 follows, but this is an image by symmetry", [&] {
        TorsionMonteCarloIntegrator integrator(300);
        integrator.addAtomMove(1, 0.02);
        Context context(molecule.system, integrator, platform);
    });
}

static void testFixedParticles(Platform& platform)
{
    Ethanol molecule;
    molecule.system.setParticleMass(0, 0);
    auto make = [&](const vector<int>& particles) {
        return findSets(platform, molecule.system, molecule.positions, particles, true);
    };

    // The link of particle 0 is 0, 1, 4 and 5.

    ASSERT(make({}) == set<set<int>>({{2, 3}, {3}, {6}}));
    assertThrows("TorsionMonteCarloIntegrator: move 0 names particle 0, whose mass is 0, so that it is fixed", [&] {
        make({2, 0});
    });
    assertThrows("move 0 names particle 4, which is in a rigid link with a fixed particle", [&] {
        make({4});
    });
    System fixed;
    StericExclusionForce* spheres = new StericExclusionForce();
    fixed.addForce(spheres);
    fixed.addParticle(0);
    spheres->addParticle(0.1);
    assertThrows("move 0 displaces particles, but all are fixed, or in molecules without a radius or a joint", [&] {
        findSets(platform, fixed, {Vec3()}, {}, true);
    });
}

static void testErrors(Platform& platform)
{
    Ethanol molecule;
    auto make = [&](const vector<int>& particles) {
        TorsionMonteCarloIntegrator integrator(300);
        integrator.addTorsionMove(1, 1);
        integrator.addAtomMove(0, 0.01, particles);
        Context context(molecule.system, integrator, platform);
    };
    assertThrows("move 1 names particle 7, but there are", [&] {
        make({7});
    });
    assertThrows("particle -1", [&] {
        make({-1});
    });
    assertThrows("move 1 names particle 3 twice", [&] {
        make({3, 2, 3});
    });
    TorsionMonteCarloIntegrator integrator(300);
    for (double bad : {-0.1, numeric_limits<double>::infinity(), numeric_limits<double>::quiet_NaN()})
        assertThrows("the largest displacement of an atom move must be", [&] {
            integrator.addAtomMove(1, bad);
        });

    // Later the links of a Context cannot become flexible.

    integrator.addTorsionMove(1, 1);
    ASSERT(!integrator.displacesParticles());
    Context context(molecule.system, integrator, platform);
    context.setPositions(molecule.positions);
    assertThrows("move 1 displaces particles within their links, but the Context was made when no move did", [&] {
        integrator.addAtomMove(1, 0.01);
    });
    ASSERT_EQUAL(1, integrator.getNumMoves());
    integrator.step(1);

    // A flexible Context stays flexible.

    TorsionMonteCarloIntegrator second(300);
    second.addAtomMove(0, 0.01);
    ASSERT(second.displacesParticles());
    Context flexible(molecule.system, second, platform);
    flexible.setPositions(molecule.positions);
    second.removeMove(0);
    second.addAtomMove(1, 0.01);
    second.step(1);
    second.setAtomMoveParameters(0, 2, 0.03, {1}, false);
    double weight, size;
    vector<int> particles;
    bool withHydrogens;
    second.getAtomMoveParameters(0, weight, size, particles, withHydrogens);
    ASSERT(weight == 2 && size == 0.03 && particles == vector<int>({1}) && !withHydrogens);
    ASSERT_EQUAL("atom ±0.03 nm (weight 2, 1 particle to choose from)", second.getMoveDescription(0));
    ASSERT_EQUAL(TorsionMonteCarloIntegrator::AtomMove, second.getMoveType(0));
}

/**
 * Trials are uniform in a ball: the mean of a coordinate is 0, and of its square a fifth of the squared radius.
 */
static void testDisplacements(Platform& platform)
{
    System system;
    StericExclusionForce* spheres = new StericExclusionForce();
    system.addForce(spheres);
    system.addParticle(12);
    spheres->addParticle(0.1);
    TorsionMonteCarloIntegrator integrator(300);
    const double radius = 0.25;
    integrator.addAtomMove(1, 0.5);
    integrator.setMoveScale(0, 0.5);
    integrator.setTrialsPerStep(1);
    integrator.setRandomNumberSeed(8);
    Context context(system, integrator, platform);
    context.setPositions({Vec3()});
    const int numTrials = 20000;
    Vec3 sum, squares, before;
    int numInner = 0;
    for (int i = 0; i < numTrials; i++) {
        integrator.step(1);
        const Vec3 after = getPositions(context)[0], shift = (after - before) / radius;
        before = after;
        sum += shift;
        squares += Vec3(shift[0] * shift[0], shift[1] * shift[1], shift[2] * shift[2]);
        ASSERT(shift.dot(shift) < 1 + 1e-9);
        numInner += shift.dot(shift) < 0.25;
    }
    for (int i = 0; i < 3; i++) {
        ASSERT_USUALLY_EQUAL_TOL(0, sum[i] / numTrials, 5 * sqrt(0.2 / numTrials));
        ASSERT_USUALLY_EQUAL_TOL(0.2, squares[i] / numTrials, 5 * 0.22 / sqrt(numTrials));
    }
    ASSERT_USUALLY_EQUAL_TOL(0.125, numInner / (double)numTrials, 5 * sqrt(0.11 / numTrials));
    const Statistics counts(integrator, 0);
    ASSERT_EQUAL(numTrials, counts.accepted);
}

/**
 * Limits hold for particles of one link, too.
 */
static void testHardSpheres(Platform& platform)
{
    System system;
    StericExclusionForce* spheres = new StericExclusionForce();
    spheres->setOverlapTolerance(0.02);
    system.addForce(spheres);
    vector<Vec3> positions;
    for (int i = 0; i < 6; i++) {
        system.addParticle(12);
        spheres->addParticle(0.1);
        positions.push_back(Vec3(0.19 * i, 0, 0));
        if (i > 0)
            spheres->addBond(i - 1, i);
    }
    positions[5] = positions[4] + Vec3(0, 0.12, 0); // which is tolerated
    CustomExternalForce* trap = new CustomExternalForce("40*(x^2+y^2+z^2)");
    for (int i = 0; i < 6; i++)
        trap->addParticle(i);
    system.addForce(trap);
    for (bool isHard : {true, false}) {
        TorsionMonteCarloIntegrator integrator(300);
        integrator.addAtomMove(1, 0.05);
        integrator.setStericMode(isHard ? TorsionMonteCarloIntegrator::Hard : TorsionMonteCarloIntegrator::Off);
        integrator.setRandomNumberSeed(9);
        Context context(system, integrator, platform);
        context.setPositions(positions);
        double least = 1, toleratedLeast = 1;
        for (int i = 0; i < 50; i++) {
            integrator.step(1);
            const vector<Vec3> x = getPositions(context);
            for (int j = 0; j < 6; j++)
                for (int k = 0; k < j; k++)
                    (j == 5 && k == 4 ? toleratedLeast : least) =
                        min(j == 5 && k == 4 ? toleratedLeast : least, getDistance(x[j], x[k]));
        }
        ASSERT_EQUAL(isHard, least > 0.18 - 1e-8);
        ASSERT_EQUAL(isHard, toleratedLeast > 0.12 - 1e-8);
        const Statistics counts(integrator, 0);
        ASSERT_EQUAL(isHard, counts.clashed > 0);
        ASSERT(counts.accepted > 0);
    }
}

// ---- Sizes, and what is saved ----

/**
 * An ethanol whose bonds and angles are stiff, and a loosely held atom beside it, sampled while sizes adapt.
 */
class Adapting : public Ethanol {
public:
    explicit Adapting(bool hasOuterTests = false) : integrator(300)
    {
        HarmonicAngleForce* angles = new HarmonicAngleForce();
        angles->addAngle(0, 1, 2, 1.9, 400);
        angles->addAngle(4, 1, 5, 1.9, 300);
        angles->addAngle(1, 2, 3, 1.8, 300);
        angles->addAngle(0, 1, 4, 1.9, 300);
        angles->addAngle(0, 1, 5, 1.9, 300);
        system.addForce(angles);
        CustomExternalForce* trap = new CustomExternalForce("100*((x-0.8)^2+(y-0.7)^2+z^2)");
        trap->addParticle(6);
        system.addForce(trap);
        if (hasOuterTests) {
            Probe* probe = new Probe(); // that OpenMM evaluates
            probe->energy = [](const vector<Vec3>& x) {
                return 50 * x[3].dot(x[3]);
            };
            system.addForce(probe);
            integrator.setTrialsPerOuterTest(20);
        }
        integrator.addAtomMove(1, 0.4);
        integrator.addTorsionMove(0.5, 1);
        integrator.setRandomNumberSeed(3);
        integrator.setTrialsPerStep(77);
        integrator.setAdaptMoveSizes(true);
    }
    vector<double> getScales() const
    {
        vector<double> scales;
        integrator.getMoveScales(0, scales);
        return scales;
    }
    TorsionMonteCarloIntegrator integrator;
};

static void testSizes(Platform& platform)
{
    // Classes: hydrogens, C0, the hydroxyl and methylene groups, the single atom.

    Adapting run;
    Context context(run.system, run.integrator, platform);
    context.setPositions(run.positions);
    ASSERT(run.getScales() == vector<double>(5, 1));
    run.integrator.step(1500);
    run.integrator.setAdaptMoveSizes(false);
    const vector<double> scales = run.getScales();
    for (int i = 0; i < 4; i++)
        ASSERT(scales[i] < 0.3);
    ASSERT(scales[4] > 2 * *max_element(scales.begin(), scales.end() - 1));
    double product = 1;
    for (double scale : scales)
        product *= scale;
    ASSERT_EQUAL_TOL(pow(product, 0.2), run.integrator.getMoveScale(0), 1e-12);
    ASSERT(run.integrator.getMoveDescription(0).find(", scaled by 0.0") != string::npos);
    run.integrator.step(500);
    ASSERT(run.getScales() == scales);
    const Statistics counts(run.integrator, 0);
    ASSERT_EQUAL_TOL(0.25, counts.accepted / (double)counts.attempted, 0.05 / 0.25);

    // XML holds the scales, and they apply where there are as many classes.

    stringstream xml;
    XmlSerializer::serialize<Integrator>(&run.integrator, "Integrator", xml);
    unique_ptr<Integrator> read(XmlSerializer::deserialize<Integrator>(xml));
    auto& copy = dynamic_cast<TorsionMonteCarloIntegrator&>(*read);
    ASSERT_EQUAL(run.integrator.getMoveDescription(0), copy.getMoveDescription(0));
    vector<double> copied;
    copy.getMoveScales(0, copied);
    ASSERT(copied == scales);
    Context other(run.system, copy, platform);
    copy.getMoveScales(0, copied);
    ASSERT(copied == scales);
    assertThrows("move 0 has 5 scales, but was given 2", [&] {
        copy.setMoveScales(0, {0.5, 0.25});
    });
    assertThrows("the scale of move 0 must be above 0 and at most 1, but is 0", [&] {
        copy.setMoveScales(0, {1, 1, 0, 1, 1});
    });
    assertThrows("move 1 has 1 scales, but was given 2", [&] {
        copy.setMoveScales(1, {0.5, 0.25});
    });
    copy.setMoveScales(0, {1, 0.5, 0.25, 0.125, 0.0625});
    ASSERT_EQUAL_TOL(0.25, copy.getMoveScale(0), 1e-15);
    copy.setMoveScale(0, 0.5);
    copy.getMoveScales(0, copied);
    ASSERT(copied == vector<double>(5, 0.5));

    TorsionMonteCarloIntegrator few(300);
    few.addAtomMove(1, 0.1, {0, 6});
    few.setMoveScales(0, {0.5, 0.25, 0.125});
    assertThrows("move 0 has 3 scales, but its trials have 2 classes", [&] {
        Context third(run.system, few, platform);
    });
}

/**
 * A run interrupted while sizes adapt continues bit for bit, from a checkpoint and from a State; with outer tests, too,
 * which take trials back.
 */
static void testContinuation(Platform& platform, bool hasOuterTests)
{
    unique_ptr<Adapting> runs[3];
    unique_ptr<Context> contexts[3];
    for (int i = 0; i < 3; i++) {
        runs[i] = make_unique<Adapting>(hasOuterTests);
        contexts[i] = make_unique<Context>(runs[i]->system, runs[i]->integrator, platform);
    }
    contexts[0]->setPositions(runs[0]->positions);
    runs[0]->integrator.step(60);
    const WrittenContext written(*contexts[0]);
    written.loadCheckpoint(*contexts[1]);
    contexts[2]->setState(fromXml(written.xml));
    for (auto& run : runs)
        run->integrator.step(60);
    for (int i : {1, 2}) {
        assertSameBits(getPositions(*contexts[0]), getPositions(*contexts[i]));
        ASSERT(runs[0]->getScales() == runs[i]->getScales());
        ASSERT_EQUAL(Statistics(runs[0]->integrator, 0).accepted, Statistics(runs[i]->integrator, 0).accepted);
    }
    ASSERT(runs[0]->getScales()[0] < 1);
    long long attempted, accepted, takenBack;
    double mean, deviation;
    runs[0]->integrator.getOuterStatistics(attempted, accepted, takenBack, mean, deviation);
    ASSERT_EQUAL(hasOuterTests, takenBack > 0);
    for (auto& bond : runs[0]->BONDS)
        ASSERT(getDistance(getPositions(*contexts[0])[bond.first], getPositions(*contexts[0])[bond.second]) !=
               getDistance(runs[0]->positions[bond.first], runs[0]->positions[bond.second]));

    // The energy that trials have updated is that of the positions.

    ASSERT_EQUAL_TOL(contexts[0]->getState(State::Energy).getPotentialEnergy(),
                     runs[0]->integrator.getPotentialEnergy(*contexts[0]), 1e-9);

    // A Context of rigid links is of another structure.

    Adapting rigid;
    rigid.integrator.removeMove(0);
    Context unlike(rigid.system, rigid.integrator, platform);
    unlike.setPositions(rigid.positions);
    assertThrows("or only one of the two uses periodic boundary conditions or has atom moves", [&] {
        written.loadCheckpoint(unlike);
    });
}

/**
 * Other positions of a flexible molecule are no damage of a State, though some particles are where they were.
 */
static void testOtherPositions(Platform& platform)
{
    Adapting run, other;
    Context context(run.system, run.integrator, platform), next(other.system, other.integrator, platform);
    context.setPositions(run.positions);
    run.integrator.step(5);
    const State state = context.getState(State::IntegratorParameters);
    vector<Vec3> changed = getPositions(context);
    changed[1] += Vec3(0.001, 0.002, 0.003);
    next.setPositions(changed);
    next.setState(state);
    assertSameBits(changed, getPositions(next));
    other.integrator.step(1);

    // One number alone is.

    changed[1] = getPositions(context)[1] + Vec3(0.001, 0, 0);
    next.setPositions(changed);
    assertThrows("damaged", [&] {
        next.setState(state);
    });
}

int main()
{
    return runOnPlatform("Reference", [](Platform& platform) {
        testGroups(platform);
        testConstraints(platform);
        testVirtualSites(platform);
        testFixedParticles(platform);
        testErrors(platform);
        testDisplacements(platform);
        testHardSpheres(platform);
        testSizes(platform);
        testContinuation(platform, false);
        testContinuation(platform, true);
        testOtherPositions(platform);
    });
}
