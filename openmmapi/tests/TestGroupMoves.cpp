/**
 * This tests group moves: which molecules they move, how, and what they sample.
 */

#include "openmm/CustomExternalForce.h"
#include "openmm/NonbondedForce.h"
#include "openmm/serialization/XmlSerializer.h"
#include "SamplingSupport.h"
#include "Significance.h"
#include <array>
#include <limits>
#include <memory>
#include <random>
#include <set>
#include <sstream>

typedef array<Vec3, 3> Box;

static const Box NO_BOX = {}, SKEWED = {{Vec3(3, 0, 0), Vec3(1.3, 2.8, 0), Vec3(-1.1, 0.9, 3.2)}},
                 SMALL = {{Vec3(1.2, 0, 0), Vec3(0, 1.3, 0), Vec3(0.3, 0, 1.25)}};

/** nm, the distance of the two particles of a molecule. */
static const double BOND = 0.2;

static bool isPeriodic(const Box& box)
{
    return box[0][0] > 0;
}

/**
 * Get the way to the nearest periodic image of a place: the best of 27.
 */
static Vec3 findNearest(Vec3 way, const Box& box)
{
    if (!isPeriodic(box))
        return way;
    for (int k = 2; k >= 0; k--)
        way -= box[k] * round(way[k] / box[k][k]);
    Vec3 nearest = way;
    for (int i = -1; i <= 1; i++)
        for (int j = -1; j <= 1; j++)
            for (int k = -1; k <= 1; k++) {
                const Vec3 image = way + box[0] * i + box[1] * j + box[2] * k;
                if (image.dot(image) < nearest.dot(nearest))
                    nearest = image;
            }
    return nearest;
}

static double getLength(const Vec3& way)
{
    return sqrt(way.dot(way));
}

/**
 * Dumbbells that stand apart from each other until an energy or spheres are added.
 */
class Dumbbells {
public:
    Dumbbells(int count, const Box& box, double radius = 0) : box(box), count(count), force(new StericExclusionForce())
    {
        system.addForce(force);
        if (isPeriodic(box)) {
            system.setDefaultPeriodicBoxVectors(box[0], box[1], box[2]);
            force->setUsesPeriodicBoundaryConditions(true);
        }
        force->setOverlapTolerance(0);
        for (int i = 0; i < count; i++) {
            for (int j = 0; j < 2; j++) {
                system.addParticle(20);
                force->addParticle(radius);
            }
            force->addBond(2 * i, 2 * i + 1);
        }
        force->createExclusionsFromBonds(1);
    }
    /**
     * Add charges and Lennard-Jones, which makes dumbbells stick to each other.
     */
    void addAttraction(double epsilon, double cutoff)
    {
        NonbondedForce* pairs = new NonbondedForce();
        pairs->setNonbondedMethod(isPeriodic(box) ? NonbondedForce::CutoffPeriodic : NonbondedForce::NoCutoff);
        pairs->setCutoffDistance(cutoff);
        for (int i = 0; i < 2 * count; i++)
            pairs->addParticle(i % 2 == 0 ? 0.1 : -0.1, 0.25, epsilon);
        for (int i = 0; i < count; i++)
            pairs->addException(2 * i, 2 * i + 1, 0, 1, 0);
        system.addForce(pairs);
    }
    /**
     * Add the energy kT/2 (r/spread)^2 of each particle.
     */
    void addTrap(double spread)
    {
        CustomExternalForce* trap = new CustomExternalForce("k*(x^2+y^2+z^2)");
        trap->addGlobalParameter("k", THERMAL / 2 / spread / spread);
        for (int i = 0; i < 2 * count; i++)
            trap->addParticle(i);
        system.addForce(trap);
    }
    /**
     * Draw dumbbells that have any place and direction, in the box or, without one, in a trap of this spread.
     */
    vector<Vec3> drawPositions(mt19937_64& random, double spread = 1) const
    {
        uniform_real_distribution<double> uniform(-1, 1);
        normal_distribution<double> normal(0, spread / sqrt(2.0));
        vector<Vec3> positions;
        for (int i = 0; i < count; i++) {
            Vec3 centre;
            for (int k = 0; k < 3; k++)
                centre += isPeriodic(box) ? box[k] * uniform(random) : Vec3(k == 0, k == 1, k == 2) * normal(random);
            const double z = uniform(random), angle = M_PI * uniform(random), r = sqrt(1 - z * z);
            const Vec3 half = Vec3(r * cos(angle), r * sin(angle), z) * (BOND / 2);
            positions.push_back(centre - half);
            positions.push_back(centre + half);
        }
        return positions;
    }
    vector<Vec3> getCentroids(const vector<Vec3>& positions) const
    {
        vector<Vec3> centroids;
        for (int i = 0; i < count; i++)
            centroids.push_back((positions[2 * i] + positions[2 * i + 1]) / 2);
        return centroids;
    }
    const Box box;
    const int count;
    System system;
    StericExclusionForce* force;
};

/**
 * A tree of shortest ways that links some molecules.
 */
class ShortestTree {
public:
    ShortestTree(const vector<Vec3>& centroids, const set<int>& members, const Box& box)
    {
        set<int> others(members);
        places = centroids;
        linked = {*members.begin()};
        others.erase(linked[0]);
        while (!others.empty()) {
            double shortest = numeric_limits<double>::infinity();
            int next = -1;
            Vec3 place;
            for (int i : linked)
                for (int j : others) {
                    const Vec3 way = findNearest(centroids[j] - centroids[i], box);
                    if (getLength(way) < shortest) {
                        shortest = getLength(way);
                        next = j;
                        place = places[i] + way;
                    }
                }
            places[next] = place;
            longest = max(longest, shortest);
            linked.push_back(next);
            others.erase(next);
        }
        for (int i : linked)
            for (int j : linked) {
                const Vec3 way = findNearest(centroids[j] - centroids[i], box);
                if (getLength(way) < longest && getLength(places[j] - places[i] - way) > 1e-6)
                    spansBox = true;
            }
    }
    vector<int> linked;
    /** The centroids in the images that the tree links. */
    vector<Vec3> places;
    /** Its longest way. */
    double longest = 0;
    /** Whether a shorter way leads to another image of a member. */
    bool spansBox = false;
};

/**
 * Each trial moves a group as one rigid body, and keeps it a group that has no further neighbors.
 *
 * @param numListed  how many of the molecules may move
 */
static void testTrials(Platform& platform, const Box& box, int count, int numListed, double maxDistance)
{
    const int numTrials = 3000;
    Dumbbells gas(count, box);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(3);
    integrator.setTrialsPerStep(1);
    vector<int> listed;
    for (int i = 0; i < numListed; i++)
        listed.push_back(2 * i + 1);
    const double maxTranslation = 0.4, maxAngle = 0.9;
    integrator.addGroupMove(1, maxTranslation, maxAngle, maxDistance, numListed == count ? vector<int>() : listed);
    Context context(gas.system, integrator, platform);
    mt19937_64 random(4);
    vector<int> sizes(numListed + 1, 0);
    int numTurned = 0, numSpanning = 0, numStiff = 0;
    for (int trial = 0; trial < numTrials; trial++) {
        if (trial % 20 == 0)
            context.setPositions(gas.drawPositions(random));
        const vector<Vec3> before = getPositions(context);
        integrator.step(1);
        const vector<Vec3> after = getPositions(context);
        const vector<Vec3> from = gas.getCentroids(before), to = gas.getCentroids(after);
        set<int> group;
        for (int i = 0; i < count; i++)
            if (getLength(after[2 * i] - before[2 * i]) > 1e-9 ||
                getLength(after[2 * i + 1] - before[2 * i + 1]) > 1e-9)
                group.insert(i);
        sizes[group.size()]++;
        if (group.empty())
            continue;

        // Some distance, up to the largest, links the group, and no other molecule to it, before and after.

        const ShortestTree tree(from, group, box);
        ASSERT(tree.longest < maxDistance);
        for (int i : group) {
            ASSERT(i < numListed);
            for (int j = 0; j < numListed; j++)
                if (group.count(j) == 0) {
                    ASSERT(getLength(findNearest(from[j] - from[i], box)) > tree.longest);
                    ASSERT(getLength(findNearest(to[j] - to[i], box)) > tree.longest);
                }
        }

        // The group is rigid in the images that it links, and keeps these links.

        vector<Vec3> pointsBefore, pointsAfter;
        bool turned = false;
        Vec3 shift;
        for (int i : tree.linked) {
            for (int j = 2 * i; j < 2 * i + 2; j++) {
                pointsBefore.push_back(before[j] + tree.places[i] - from[i]);
                pointsAfter.push_back(after[j] + tree.places[i] - from[i]);
                turned |= getLength(after[j] - before[j] - (after[2 * i] - before[2 * i])) > 1e-9;
            }
            shift += (to[i] - from[i]) / tree.linked.size();
        }
        for (size_t i = 0; i < pointsBefore.size(); i++)
            for (size_t j = 0; j < i; j++)
                ASSERT_EQUAL_TOL(getLength(pointsBefore[i] - pointsBefore[j]),
                                 getLength(pointsAfter[i] - pointsAfter[j]), 1e-9);
        ASSERT(getLength(shift) < maxTranslation);
        ASSERT(!(turned && (tree.spansBox || ShortestTree(to, group, box).spansBox)));
        numTurned += turned;
        numSpanning += tree.spansBox;
        numStiff += (!turned && group.size() > 2);
    }
    for (int size = 1; size <= numListed; size++)
        ASSERT((sizes[size] > 0) == (size < count || !isPeriodic(box)));
    ASSERT(sizes[0] > numTrials / 50 && sizes[0] < numTrials * 3 / 4);
    ASSERT(numTurned > numTrials / 10);
    ASSERT((numSpanning > numTrials / 100) == (box == SMALL));
    ASSERT(numStiff < numTrials / 50 || box == SMALL);
    long long attempted, clashed, rejected, accepted;
    integrator.getMoveStatistics(0, attempted, clashed, rejected, accepted);
    ASSERT_EQUAL(numTrials, attempted);
    ASSERT_EQUAL(0, clashed + rejected);
    ASSERT_EQUAL(numTrials - sizes[0], accepted);
}

/**
 * Count, in classes that are equally likely for independent dumbbells in a box, in which class distances of pairs and
 * angles between them are.
 */
class PairCounts {
public:
    static const int NUM_CLASSES = 12;
    PairCounts() : counts(4, vector<int>(NUM_CLASSES, 0))
    {
    }
    void add(int kind, double share)
    {
        counts[kind][max(0, min(NUM_CLASSES - 1, (int)(share * NUM_CLASSES)))]++;
    }
    void add(const Dumbbells& gas, const vector<Vec3>& x, double scale)
    {
        const vector<Vec3> centroids = gas.getCentroids(x);
        for (int i = 0; i < gas.count; i++)
            for (int j = 0; j < i; j++) {
                const Vec3 way = findNearest(centroids[j] - centroids[i], gas.box);
                const Vec3 a = (x[2 * i + 1] - x[2 * i]) / BOND, b = (x[2 * j + 1] - x[2 * j]) / BOND;
                add(0, pow(getLength(way) / scale, 3));
                add(1, fabs(a.dot(b)));
                add(2, fabs(a.dot(way) / getLength(way)));
                add(3, 0.5 + 0.5 * way[2] / getLength(way));
            }
    }
    vector<vector<int>> counts;
};

/**
 * Dumbbells that are independent of each other before some trials are so afterwards.
 */
static void testIndependence(Platform& platform, const Box& box, int count, double maxDistance, double scale)
{
    const int numSamples = 8000;
    const double spread = 0.7;
    Dumbbells gas(count, box);
    if (!isPeriodic(box))
        gas.addTrap(spread);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(5);
    integrator.setTrialsPerStep(12);
    integrator.setStericMode(TorsionMonteCarloIntegrator::Off);
    integrator.addGroupMove(1, 0.1, 2, maxDistance);
    integrator.addGroupMove(0.3, 0.3, 0, maxDistance);
    Context context(gas.system, integrator, platform);
    mt19937_64 random(6);
    PairCounts expected, found;
    for (int i = 0; i < numSamples; i++) {
        expected.add(gas, gas.drawPositions(random, spread), scale);
        context.setPositions(gas.drawPositions(random, spread));
        integrator.step(1);
        found.add(gas, getPositions(context), scale);
    }
    for (size_t kind = 0; kind < found.counts.size(); kind++) {
        const double p = testSameCounts(expected.counts[kind], found.counts[kind]);
        cout << "independence, " << count << " dumbbells, kind " << kind << ": p " << p << endl;
        ASSERT(p > 1e-5);
    }
}

/**
 * With energies or spheres, group moves beside moves of single molecules sample what the latter sample.
 */
static void testMeans(Platform& platform, const Box& box, bool hard, double maxDistance)
{
    const int numBlocks = 40, blockSize = 250;
    array<array<double, 3>, 2> means = {}, variances = {};
    long long numMoved = 0;
    for (int withGroups = 0; withGroups < 2; withGroups++) {
        Dumbbells fluid(6, box, hard ? 0.15 : 0);
        if (!hard)
            fluid.addAttraction(2, 0.6);
        if (!isPeriodic(box))
            fluid.addTrap(0.8);
        TorsionMonteCarloIntegrator integrator(300);
        integrator.setRandomNumberSeed(9);
        integrator.setTrialsPerStep(20);
        integrator.setStericMode(hard ? TorsionMonteCarloIntegrator::Hard : TorsionMonteCarloIntegrator::Off);
        integrator.addRigidBodyMove(1, 0.6, M_PI);
        integrator.addRigidBodyMove(0.5, 0.08, 0.5);
        if (withGroups == 1) {
            integrator.addGroupMove(1, 0.5, M_PI, maxDistance);
            integrator.addGroupMove(1, 0.1, 0.3, maxDistance);
        }
        Context context(fluid.system, integrator, platform);
        mt19937_64 random(7);
        context.setPositions(fluid.drawPositions(random));
        integrator.step(500);
        for (int block = 0; block < numBlocks; block++) {
            array<double, 3> sums = {};
            for (int i = 0; i < blockSize; i++) {
                integrator.step(1);
                const vector<Vec3> centroids = fluid.getCentroids(getPositions(context));
                for (int j = 0; j < fluid.count; j++) {
                    double nearest = numeric_limits<double>::infinity();
                    for (int k = 0; k < fluid.count; k++)
                        if (k != j)
                            nearest = min(nearest, getLength(findNearest(centroids[k] - centroids[j], box)));
                    sums[0] += nearest / fluid.count / blockSize;
                    sums[1] += nearest * nearest / fluid.count / blockSize;
                }
                sums[2] += integrator.getPotentialEnergy(context) / THERMAL / blockSize;
            }
            for (int j = 0; j < 3; j++) {
                means[withGroups][j] += sums[j] / numBlocks;
                variances[withGroups][j] += sums[j] * sums[j] / numBlocks / (numBlocks - 1);
            }
        }
        for (int j = 0; j < 3; j++)
            variances[withGroups][j] -= means[withGroups][j] * means[withGroups][j] / (numBlocks - 1);
        if (withGroups == 1)
            numMoved = Statistics(integrator, 1).accepted;
    }
    ASSERT(numMoved > 100);
    for (int j = 0; j < 3; j++) {
        const double error = sqrt(variances[0][j] + variances[1][j]);
        cout << "means: " << means[0][j] << " " << means[1][j] << " +- " << error << endl;
        ASSERT(fabs(means[0][j] - means[1][j]) <= 4.5 * error + 1e-12);
        ASSERT(error < (j < 2 ? 0.03 : 0.6));
    }
}

/**
 * A run that resumes from a checkpoint has the bits of one that continues.
 */
static void testResuming(Platform& platform)
{
    Dumbbells fluid(12, SKEWED);
    fluid.addAttraction(1, 0.8);
    auto makeIntegrator = [] {
        auto made = make_unique<TorsionMonteCarloIntegrator>(300);
        made->setRandomNumberSeed(11);
        made->setTrialsPerStep(20);
        made->addGroupMove(1, 0.3, 1, 1.2);
        made->addRigidBodyMove(1, 0.1, 0.7);
        made->setAdaptMoveSizes(true);
        return made;
    };
    auto integrator = makeIntegrator(), resumed = makeIntegrator();
    Context context(fluid.system, *integrator, platform), second(fluid.system, *resumed, platform);
    mt19937_64 random(1);
    context.setPositions(fluid.drawPositions(random));
    integrator->step(20);
    stringstream checkpoint;
    context.createCheckpoint(checkpoint);
    second.loadCheckpoint(checkpoint);
    integrator->step(20);
    resumed->step(20);
    assertSameBits(getPositions(context), getPositions(second));
    resumed->setGroupMoveParameters(0, 1, 0.3, 1, 1.3);
    checkpoint.clear();
    checkpoint.seekg(0);
    assertThrows("move 0 has maxDistance 1.2 in it, but 1.3 here", [&] {
        second.loadCheckpoint(checkpoint);
    });
}

static void testParameters(Platform& platform)
{
    TorsionMonteCarloIntegrator integrator(300);
    ASSERT_EQUAL(0, integrator.addGroupMove(2, 0.5, 0.25, 6, {3, 1}));
    ASSERT_EQUAL(TorsionMonteCarloIntegrator::GroupMove, integrator.getMoveType(0));
    ASSERT_EQUAL("group within 6 nm ±0.5 nm ±0.25 rad (weight 2, 2 molecules to choose from)",
                 integrator.getMoveDescription(0));
    stringstream xml;
    XmlSerializer::serialize<Integrator>(&integrator, "Integrator", xml);
    unique_ptr<Integrator> read(XmlSerializer::deserialize<Integrator>(xml));
    auto& copy = dynamic_cast<TorsionMonteCarloIntegrator&>(*read);
    integrator.setGroupMoveParameters(0, 1, 0.1, 0.2, 0.3);
    double weight, maxTranslation, maxAngle, maxDistance;
    vector<int> molecules;
    integrator.getGroupMoveParameters(0, weight, maxTranslation, maxAngle, maxDistance, molecules);
    ASSERT_EQUAL(1, weight);
    ASSERT_EQUAL(0.1, maxTranslation);
    ASSERT_EQUAL(0.2, maxAngle);
    ASSERT_EQUAL(0.3, maxDistance);
    ASSERT(molecules.empty());
    copy.getGroupMoveParameters(0, weight, maxTranslation, maxAngle, maxDistance, molecules);
    ASSERT_EQUAL(2, weight);
    ASSERT_EQUAL(0.5, maxTranslation);
    ASSERT_EQUAL(0.25, maxAngle);
    ASSERT_EQUAL(6, maxDistance);
    ASSERT_EQUAL_CONTAINERS((vector<int>{3, 1}), molecules);
    assertThrows("the largest angle of a group move must be at most pi, half a turn, but is 20 radians", [&] {
        integrator.addGroupMove(1, 1, 20, 1);
    });
    assertThrows("the largest distance of neighbors of a group move must be a finite number and at least 0, but is -1",
                 [&] {
                     integrator.addGroupMove(1, 1, 1, -1);
                 });
    Dumbbells gas(2, SKEWED);
    gas.system.setParticleMass(3, 0);
    auto refuse = [&](const string& message, const vector<int>& named) {
        assertThrows(message, [&] {
            TorsionMonteCarloIntegrator other(300);
            other.addGroupMove(1, 0.1, 0.1, 1, named);
            Context context(gas.system, other, platform);
        });
    };
    refuse("names the molecule of particle 2, which has fixed particles", {2});
    refuse("names the molecule of particle 1 twice", {0, 1});
    gas.system.setParticleMass(0, 0);
    refuse("moves molecules, but all molecules have fixed particles", {});
}

int main()
{
    return runOnPlatform("Reference", [](Platform& platform) {
        testParameters(platform);
        testResuming(platform);
        testTrials(platform, SKEWED, 7, 7, 1.3);
        testTrials(platform, SKEWED, 7, 4, 1.3);
        testTrials(platform, NO_BOX, 5, 5, 1.5);
        testTrials(platform, SMALL, 10, 9, 0.58);
        testIndependence(platform, SKEWED, 6, 1.3, 2);
        testIndependence(platform, SMALL, 2, 0.9, 0.8);
        testIndependence(platform, NO_BOX, 4, 1.2, 2);
        testMeans(platform, SKEWED, false, 0.8);
        testMeans(platform, SKEWED, true, 1);
        testMeans(platform, NO_BOX, false, 0.8);
    });
}
