/**
 * This tests StericExclusionForce with periodic boundary conditions, and sampling with it, on one platform.
 */

#include "CheckpointSupport.h"
#include "FreeChain.h"
#include "openmm/CompoundIntegrator.h"
#include "openmm/NonbondedForce.h"
#include "openmm/VerletIntegrator.h"
#include <array>
#include <map>
#include <random>
#include <set>

typedef vector<pair<int, int>> Pairs;
typedef array<Vec3, 3> Box;

static const Box CUBE = {{Vec3(3, 0, 0), Vec3(0, 3, 0), Vec3(0, 0, 3)}};
static const Box SKEWED = {{Vec3(4, 0, 0), Vec3(2, 3.5, 0), Vec3(-1.9, 1.7, 3.2)}};

static void setBox(Context& context, const Box& box)
{
    context.setPeriodicBoxVectors(box[0], box[1], box[2]);
}

static void setBox(System& system, const Box& box)
{
    system.setDefaultPeriodicBoxVectors(box[0], box[1], box[2]);
}

/**
 * Get the vector from b to the nearest image of a, found among many.
 */
static Vec3 getNearestDifference(const Vec3& a, const Vec3& b, const Box& box)
{
    Vec3 reduced = a - b;
    for (int k = 2; k >= 0; k--)
        reduced -= box[k] * floor(reduced[k] / box[k][k] + 0.5);
    Vec3 nearest = reduced;
    for (int i = -2; i <= 2; i++)
        for (int j = -2; j <= 2; j++)
            for (int k = -2; k <= 2; k++) {
                const Vec3 image = reduced + box[0] * i + box[1] * j + box[2] * k;
                if (image.dot(image) < nearest.dot(nearest))
                    nearest = image;
            }
    return nearest;
}

static double getNearestDistance(const Vec3& a, const Vec3& b, const Box& box)
{
    const Vec3 difference = getNearestDifference(a, b, box);
    return sqrt(difference.dot(difference));
}

static double getHalfWidth(const Box& box)
{
    return 0.5 * min(box[0][0], min(box[1][1], box[2][2]));
}

/**
 * Check a distance that is exact only up to half the width of the box.
 */
static void assertSameWithinHalf(double expected, double found, const Box& box, double rounding)
{
    if (expected < getHalfWidth(box))
        ASSERT_EQUAL_TOL(expected, found, rounding);
    ASSERT(found >= expected - rounding);
}

/**
 * Two chains with torsions and 40 loose beads, strewn over a box and its neighbours; some pairs are excluded.
 */
class PeriodicCrowd : public BeadChain {
public:
    explicit PeriodicCrowd(const Box& box) : BeadChain(9, 0.3, 1.0), box(box)
    {
        force->setUsesPeriodicBoundaryConditions(true);
        setBox(system, box);
        addMolecule(6, 0.25, 2.0, Vec3(9, -7, 2));
        mt19937 random(7);
        uniform_real_distribution<double> uniform(-8, 8);
        for (int i = 0; i < 40; i++)
            addMolecule(1, i % 7 == 0 ? 0 : 0.2, 0, Vec3(uniform(random), uniform(random), uniform(random)));
        force->addExclusion(0, 20);
        force->addExclusion(31, 30);
        for (int i = 0; i < force->getNumExclusions(); i++) {
            int p1, p2;
            force->getExclusionParticles(i, p1, p2);
            excluded.insert(minmax(p1, p2));
        }
    }
    double getRadius(int particle) const
    {
        double radius;
        StericExclusionForce::HydrogenBondRole role;
        force->getParticleParameters(particle, radius, role);
        return radius;
    }
    bool isCounted(int i, int j) const
    {
        return getRadius(i) > 0 && getRadius(j) > 0 && excluded.count(make_pair(i, j)) == 0;
    }
    /**
     * Get all pairs within a cutoff, and their distances.
     */
    map<pair<int, int>, double> getNeighbors(const vector<Vec3>& x, double cutoff) const
    {
        map<pair<int, int>, double> neighbors;
        for (int i = 0; i < (int)x.size(); i++)
            for (int j = i + 1; j < (int)x.size(); j++) {
                const double distance = getNearestDistance(x[i], x[j], box);
                if (isCounted(i, j) && distance <= cutoff)
                    neighbors[make_pair(i, j)] = distance;
            }
        return neighbors;
    }
    Box box;
    set<pair<int, int>> excluded;
};

// ---- Queries ----

/**
 * Two spheres that overlap across a face, an edge or a corner, and many boxes away.
 */
void testClashAcrossFaces(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    for (bool periodic : {false, true}) {
        System system;
        setBox(system, CUBE);
        StericExclusionForce* force = new StericExclusionForce();
        system.addForce(force);
        force->setUsesPeriodicBoundaryConditions(periodic);
        ASSERT_EQUAL(periodic, force->usesPeriodicBoundaryConditions());
        ASSERT_EQUAL(periodic, system.usesPeriodicBoundaryConditions());
        for (int i = 0; i < 2; i++) {
            system.addParticle(1);
            force->addParticle(0.2);
        }
        VerletIntegrator integrator(0.001);
        Context context(system, integrator, platform);
        for (const Vec3& turns : {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(1, 1, 0), Vec3(-1, 1, 1), Vec3(0, 4, -5)}) {
            const Vec3 shift = CUBE[0] * turns[0] + CUBE[1] * turns[1] + CUBE[2] * turns[2];
            context.setPositions({Vec3(), Vec3(0, 0, 0.3) + shift});
            Pairs pairs;
            vector<int> particles;
            vector<double> values;
            int p1, p2;
            ASSERT_EQUAL(periodic, force->hasClash(context));
            force->getClashes(context, pairs, values);
            ASSERT_EQUAL(periodic ? 1 : 0, (int)pairs.size());
            if (periodic)
                ASSERT_EQUAL_TOL(0.1, values[0], 1e-6 + tolerance);
            force->getNeighborPairs(context, 0.31, pairs, values);
            ASSERT_EQUAL(periodic ? 1 : 0, (int)pairs.size());
            const double direct = sqrt((Vec3(0, 0, 0.3) + shift).dot(Vec3(0, 0, 0.3) + shift));
            ASSERT_EQUAL_TOL(periodic ? 0.3 : direct, force->getMinimumDistance(context, {0}, {1}, p1, p2),
                             1e-6 + tolerance);
            force->getClashesWith(context, Vec3(-3, 0, 0.3), 0.2, particles, values);
            ASSERT_EQUAL(periodic ? 2 : 0, (int)particles.size());
            const State state = context.getState(State::Energy | State::Forces);
            ASSERT_EQUAL_TOL(periodic ? 0.5e5 * 0.06 * 0.06 : 0, state.getPotentialEnergy(), 1e-4);
            ASSERT_EQUAL_VEC(Vec3(0, 0, periodic ? -6000 : 0), state.getForces()[0], 1e-4);
            ASSERT_EQUAL_VEC(Vec3(0, 0, periodic ? 6000 : 0), state.getForces()[1], 1e-4);
        }
    }
}

/**
 * Everything against a comparison of all pairs in many images.
 */
void testQueriesAgainstAllPairs(Platform& platform)
{
    for (const Box& box : {CUBE, SKEWED}) {
        PeriodicCrowd crowd(box);
        VerletIntegrator integrator(0.001);
        Context context(crowd.system, integrator, platform);
        context.setPositions(crowd.positions);
        const vector<Vec3> x = getPositions(context);
        const double rounding = 1e-9 + getTolerance(platform);
        for (double cutoff : {0.4, 1.5}) {
            auto expected = crowd.getNeighbors(x, cutoff);
            Pairs pairs;
            vector<double> distances;
            crowd.force->getNeighborPairs(context, cutoff, pairs, distances);
            ASSERT_EQUAL(expected.size(), pairs.size());
            for (size_t i = 0; i < pairs.size(); i++)
                ASSERT_EQUAL_TOL(expected.at(pairs[i]), distances[i], rounding);
        }
        double energy = 0;
        int numClashes = 0;
        vector<Vec3> forces(x.size());
        for (auto& neighbor : crowd.getNeighbors(x, 0.6)) {
            const int i = neighbor.first.first, j = neighbor.first.second;
            const double excess = crowd.getRadius(i) + crowd.getRadius(j) - neighbor.second;
            if (excess <= 0)
                continue;
            numClashes++;
            energy += 0.5 * crowd.force->getForceConstant() * excess * excess;
            const Vec3 push =
                getNearestDifference(x[i], x[j], box) * (crowd.force->getForceConstant() * excess / neighbor.second);
            forces[i] += push;
            forces[j] -= push;
        }
        ASSERT(numClashes > 5);
        Pairs pairs;
        vector<double> overlaps;
        crowd.force->getClashes(context, pairs, overlaps);
        ASSERT_EQUAL(numClashes, (int)pairs.size());
        const State state = context.getState(State::Energy | State::Forces);
        ASSERT_EQUAL_TOL(energy, state.getPotentialEnergy(), 1e-4);
        for (size_t i = 0; i < forces.size(); i++)
            ASSERT_EQUAL_VEC(forces[i], state.getForces()[i], 1e-3);

        // The least distance can be longer than half the box.

        int numFar = 0;
        for (int i = 0; i < 30; i++) {
            int p1, p2;
            const double expected = getNearestDistance(x[i], x[i + 20], box);
            ASSERT_EQUAL_TOL(expected, crowd.force->getMinimumDistance(context, {i}, {i + 20}, p1, p2), rounding);
            numFar += expected > getHalfWidth(box);
        }
        ASSERT(numFar > 0);
    }
}

/**
 * The pairs that proposals change, of which those in one molecule may be pairs of images alone.
 */
void testProposals(Platform& platform)
{
    for (const Box& box : {CUBE, SKEWED}) {
        PeriodicCrowd crowd(box);
        VerletIntegrator integrator(0.001);
        Context context(crowd.system, integrator, platform);
        context.setPositions(crowd.positions);
        const double rounding = 1e-9 + getTolerance(platform), cutoff = 1.4;
        int numFree = 0;
        for (int trial = 0; trial < 30; trial++) {
            bool isFree;
            const vector<Vec3> before = getPositions(context);
            crowd.force->restartLimits(context);
            if (trial % 3 == 0)
                isFree = crowd.force->proposeTorsions(context, {trial % 6}, {0.3 * (trial + 1)});
            else if (trial % 3 == 1)
                isFree = crowd.force->proposeRigidMotion(context, 0, Vec3(0.4, trial, 0), Vec3(0, 0, 2.9 * trial));
            else
                isFree = crowd.force->proposeRigidMotion(context, 15 + trial, Vec3(), Vec3(0.4, 0.1 * trial, -7));
            vector<Vec3> after;
            crowd.force->getProposedPositions(context, after);
            Pairs pairs;
            vector<double> distances, newDistances;
            crowd.force->getChangedNeighborPairs(context, cutoff, pairs, distances, newDistances);
            const set<pair<int, int>> listed(pairs.begin(), pairs.end());
            for (size_t i = 0; i < pairs.size(); i++) {
                const int p1 = pairs[i].first, p2 = pairs[i].second;
                assertSameWithinHalf(getNearestDistance(before[p1], before[p2], box), distances[i], box, rounding);
                assertSameWithinHalf(getNearestDistance(after[p1], after[p2], box), newDistances[i], box, rounding);
            }
            bool hasNewClash = false;
            for (int i = 0; i < (int)after.size(); i++)
                for (int j = i + 1; j < (int)after.size(); j++) {
                    const double distance = getNearestDistance(before[i], before[j], box),
                                 newDistance = getNearestDistance(after[i], after[j], box);
                    if (!crowd.isCounted(i, j) || fabs(newDistance - distance) < 1e-5)
                        continue;
                    const double contact = crowd.getRadius(i) + crowd.getRadius(j);
                    hasNewClash |= newDistance < min(contact, distance);
                    ASSERT_EQUAL(min(distance, newDistance) <= cutoff, listed.count(make_pair(i, j)) == 1);
                }
            ASSERT_EQUAL(hasNewClash, !isFree);
            numFree += isFree;
            crowd.force->acceptProposal(context);
            assertRounded(platform, after, getPositions(context));
        }
        ASSERT(numFree > 3 && numFree < 27);
    }
}

// ---- The box ----

void testWrongBoxes(Platform& platform)
{
    PeriodicCrowd crowd(CUBE);
    setBox(crowd.system, {{Vec3(3, 0, 0), Vec3(0, 1.19, 0), Vec3(0, 0, 3)}});
    VerletIntegrator integrator(0.001);
    assertThrows("StericExclusionForce: the periodic box is 1.19 nm wide; it must be twice as wide as particles reach, "
                 "which is 0.6 nm",
                 [&] {
                     Context context(crowd.system, integrator, platform);
                 });
    setBox(crowd.system, CUBE);
    Context context(crowd.system, integrator, platform);
    context.setPositions(crowd.positions);
    Pairs pairs;
    vector<int> particles;
    vector<double> before, after;
    crowd.force->getNeighborPairs(context, 1.5, pairs, before);
    assertThrows("the cutoff is 1.6 nm; it must be at most half the periodic box's width, 1.5 nm", [&] {
        crowd.force->getNeighborPairs(context, 1.6, pairs, before);
    });
    crowd.force->proposeTorsions(context, {0}, {0.1});
    assertThrows("half the periodic box's width", [&] {
        crowd.force->getChangedNeighborPairs(context, 1.6, pairs, before, after);
    });
    assertThrows("half the periodic box's width", [&] {
        crowd.force->getClashesWith(context, Vec3(), 1.3, particles, before);
    });

    // A box that is too narrow is an error until another one is set.

    setBox(context, {{Vec3(3, 0, 0), Vec3(0, 3, 0), Vec3(0, 0, 1.1)}});
    for (int i = 0; i < 2; i++)
        assertThrows("the periodic box is 1.1 nm wide", [&] {
            crowd.force->hasClash(context);
        });
    setBox(context, CUBE);
    crowd.force->getChangedNeighborPairs(context, 1.4, pairs, before, after);
    assertSameBits(getPositions(context), crowd.positions);

    // So are new radii for which it is too narrow.

    crowd.force->setParticleParameters(3, 0.8);
    assertThrows("the periodic box is 3 nm wide; it must be twice as wide as particles reach, which is 1.6 nm", [&] {
        crowd.force->updateParametersInContext(context);
    });
    crowd.force->getChangedNeighborPairs(context, 1.4, pairs, before, after);
}

/**
 * Neither updateParametersInContext() nor a change of the force changes what counts in a Context.
 */
void testFlagIsKept(Platform& platform)
{
    PeriodicCrowd crowd(CUBE);
    VerletIntegrator integrator(0.001);
    Context context(crowd.system, integrator, platform);
    context.setPositions(crowd.positions);
    Pairs pairs;
    vector<double> overlaps;
    crowd.force->getClashes(context, pairs, overlaps);
    const size_t numClashes = pairs.size();
    crowd.force->setUsesPeriodicBoundaryConditions(false);
    crowd.force->updateParametersInContext(context);
    crowd.force->getClashes(context, pairs, overlaps);
    ASSERT_EQUAL(numClashes, pairs.size());
    context.reinitialize(true);
    crowd.force->getClashes(context, pairs, overlaps);
    ASSERT(pairs.size() < numClashes);
}

/**
 * Two beads, each a molecule, of which the second clashes with the first's image if the box is narrow.
 */
class TwoBeads {
public:
    TwoBeads() : force(new StericExclusionForce())
    {
        setBox(system, CUBE);
        system.addForce(force);
        force->setUsesPeriodicBoundaryConditions(true);
        force->setOverlapTolerance(0);
        for (int i = 0; i < 2; i++) {
            system.addParticle(1);
            force->addParticle(0.25);
        }
    }
    System system;
    StericExclusionForce* force;
    vector<Vec3> positions = {Vec3(0.1, 0, 0), Vec3(2.5, 0, 0)};
};

void testChangedBox(Platform& platform)
{
    TwoBeads beads;
    VerletIntegrator integrator(0.001);
    Context context(beads.system, integrator, platform);
    context.setPositions(beads.positions);
    ASSERT(!beads.force->hasClash(context));
    ASSERT(beads.force->proposeRigidMotion(context, 1, Vec3(), Vec3(0.05, 0, 0)));

    // A narrower box discards the proposal, and makes a clash, which gets its limit.

    setBox(context, {{Vec3(2.8, 0, 0), Vec3(0, 3, 0), Vec3(0, 0, 3)}});
    assertThrows("there is no open proposal", [&] {
        beads.force->acceptProposal(context);
    });
    ASSERT(beads.force->hasClash(context));
    ASSERT(beads.force->proposeRigidMotion(context, 1, Vec3(), Vec3(-0.01, 0, 0)));
    ASSERT(!beads.force->proposeRigidMotion(context, 1, Vec3(), Vec3(0.01, 0, 0)));
    ASSERT_EQUAL(1, beads.force->getNumToleratedClashes(context));

    // Limits stay when the box widens, and grow when it narrows.

    setBox(context, CUBE);
    ASSERT(!beads.force->hasClash(context));
    ASSERT(beads.force->proposeRigidMotion(context, 1, Vec3(), Vec3(0.19, 0, 0)));
    ASSERT(!beads.force->proposeRigidMotion(context, 1, Vec3(), Vec3(0.21, 0, 0)));
    setBox(context, {{Vec3(2.7, 0, 0), Vec3(0, 3, 0), Vec3(0, 0, 3)}});
    ASSERT(beads.force->proposeRigidMotion(context, 1, Vec3(), Vec3(-0.01, 0, 0)));
    setBox(context, CUBE);
    ASSERT(beads.force->proposeRigidMotion(context, 1, Vec3(), Vec3(0.29, 0, 0)));

    // New positions start limits again.

    context.setPositions(beads.positions);
    beads.positions[0][0] = 0.11;
    context.setPositions(beads.positions);
    ASSERT(!beads.force->proposeRigidMotion(context, 1, Vec3(), Vec3(0.15, 0, 0)));
    ASSERT_EQUAL(0, beads.force->getNumToleratedClashes(context));

    // Skewing the box alone can make a clash, too.

    context.setPositions({Vec3(0, 0, 0), Vec3(1.4, 2.9, 0)});
    ASSERT(!beads.force->hasClash(context));
    setBox(context, {{Vec3(3, 0, 0), Vec3(1.4, 3, 0), Vec3(0, 0, 3)}});
    ASSERT(beads.force->hasClash(context));
}

// ---- Warnings ----

static vector<string> warnings;

void testWarnings(Platform& platform)
{
    setWarningHandler([](const string& message) {
        warnings.push_back(message);
    });
    for (bool periodic : {false, true}) {
        TwoBeads beads;
        NonbondedForce* nonbonded = new NonbondedForce();
        beads.system.addForce(nonbonded);
        nonbonded->setNonbondedMethod(NonbondedForce::CutoffPeriodic);
        for (int i = 0; i < 2; i++)
            nonbonded->addParticle(0, 0.1, 0);
        beads.force->setUsesPeriodicBoundaryConditions(periodic);
        warnings.clear();
        VerletIntegrator integrator(0.001);
        Context context(beads.system, integrator, platform);
        ASSERT_EQUAL(periodic ? 0 : 1, (int)warnings.size());
        ASSERT(periodic || warnings[0].find("spheres ignore periodic images") != string::npos);
    }
    setWarningHandler(ignoreWarning);
}

// ---- Sampling ----

/**
 * Free chains of beads, most of which are longer than the box is wide.
 */
class Melt : public FreeChain {
public:
    explicit Melt(const Box& box) : FreeChain(1, 0.3), box(box)
    {
        force->setUsesPeriodicBoundaryConditions(true);
        setBox(system, box);
        for (int chain = 1; chain < 6; chain++) {
            const FreeChain added(chain + 1, 0.3);
            const int first = system.getNumParticles();
            for (int i = 0; i <= chain; i++) {
                system.addParticle(1);
                force->addParticle(0.3);
                positions.push_back(added.positions[i] + Vec3(0.65 * chain, 0.3 * chain, 0.7));
                if (i > 0) {
                    force->addBond(first + i - 1, first + i);
                    force->addBallJoint(first + i - 1, first + i);
                    force->addExclusion(first + i - 1, first + i);
                }
            }
        }
    }
    bool isBonded(int i, int j) const
    {
        for (int k = 0; k < force->getNumBonds(); k++) {
            int p1, p2;
            force->getBondParticles(k, p1, p2);
            if (minmax(p1, p2) == minmax(i, j))
                return true;
        }
        return false;
    }
    double getLeastDistance(const vector<Vec3>& x) const
    {
        double least = 10;
        for (int i = 0; i < (int)x.size(); i++)
            for (int j = 0; j < i; j++)
                if (!isBonded(i, j))
                    least = min(least, getNearestDistance(x[i], x[j], box));
        return least;
    }
    Box box;
};

class MeltRun {
public:
    MeltRun(System& system, Platform& platform, int seed = 4) : integrator(300)
    {
        integrator.setRandomNumberSeed(seed);
        integrator.setTrialsPerStep(20);
        integrator.addPivotMove(2, 0.8);
        integrator.addRigidBodyMove(1, 1.5, 3);
        context = make_unique<Context>(system, integrator, platform);
    }
    TorsionMonteCarloIntegrator integrator;
    unique_ptr<Context> context;
};

/**
 * No sampled state has images nearer than the spheres allow, however far molecules have gone.
 */
void testSampledStates(Platform& platform)
{
    for (const Box& box : {CUBE, SKEWED}) {
        Melt melt(box);
        MeltRun run(melt.system, platform);
        run.context->setPositions(melt.positions);
        const double start = melt.getLeastDistance(melt.positions), rounding = 2e-9 + getTolerance(platform);
        int numOutside = 0;
        for (int i = 0; i < 60; i++) {
            run.integrator.step(1);
            const vector<Vec3> x = getPositions(*run.context);
            ASSERT(melt.getLeastDistance(x) >= min(0.6, start) - rounding);
            for (const Vec3& position : x)
                numOutside += fabs(position[2]) > 1.5 * box[2][2];
        }
        ASSERT(numOutside > 0);
        long long attempted, clashed, rejected, accepted;
        run.integrator.getMoveStatistics(0, attempted, clashed, rejected, accepted);
        ASSERT(clashed > 50 && accepted > 50);
    }
}

static string saveCheckpoint(Context& context)
{
    stringstream stream;
    context.createCheckpoint(stream);
    return stream.str();
}

static void loadCheckpoint(Context& context, const string& checkpoint)
{
    stringstream stream(checkpoint);
    context.loadCheckpoint(stream);
}

/**
 * A run that was resumed from a checkpoint or State has the bits of one that continues, also if the box has changed.
 */
void testResuming(Platform& platform)
{
    for (bool useState : {false, true}) {
        Melt melt(SKEWED);
        MeltRun whole(melt.system, platform);
        whole.context->setPositions(melt.positions);
        for (int i = 0; i < 6; i++) {
            whole.integrator.step(3);
            if (i == 3)
                setBox(*whole.context, {{Vec3(4.1, 0, 0), Vec3(2, 3.5, 0), Vec3(-1.9, 1.7, 3.3)}});
            MeltRun resumed(melt.system, platform, 17);
            if (useState)
                resumed.context->setState(writeAndRead(*whole.context));
            else
                loadCheckpoint(*resumed.context, saveCheckpoint(*whole.context));
            MeltRun again(melt.system, platform, 18);
            loadCheckpoint(*again.context, saveCheckpoint(*resumed.context));
            whole.integrator.step(4);
            resumed.integrator.step(4);
            again.integrator.step(4);
            assertSameBits(getPositions(*whole.context), getPositions(*resumed.context));
            assertSameBits(getPositions(*whole.context), getPositions(*again.context));
            ASSERT_EQUAL(whole.integrator.getNumToleratedClashes(*whole.context),
                         resumed.integrator.getNumToleratedClashes(*resumed.context));
        }
    }
}

/**
 * States whose molecules were wrapped into the box hold the same structure.
 */
void testWrappedStates(Platform& platform)
{
    Melt melt(CUBE);
    MeltRun run(melt.system, platform), other(melt.system, platform);
    run.context->setPositions(melt.positions);
    run.integrator.step(20);
    other.context->setState(writeAndRead(*run.context, true));
    ASSERT_EQUAL(run.integrator.getNumToleratedClashes(*run.context),
                 other.integrator.getNumToleratedClashes(*other.context));
    other.integrator.step(10);
    ASSERT(melt.getLeastDistance(getPositions(*other.context)) >=
           min(0.6, melt.getLeastDistance(melt.positions)) - 1e-6);
}

/**
 * Checkpoints and States know whether images count.
 */
void testOtherForces(Platform& platform)
{
    Melt melt(CUBE), bare(CUBE);
    bare.force->setUsesPeriodicBoundaryConditions(false);
    MeltRun periodic(melt.system, platform), plain(bare.system, platform);
    periodic.context->setPositions(melt.positions);
    plain.context->setPositions(melt.positions);
    periodic.integrator.step(1);
    plain.integrator.step(1);
    assertThrows("only one of the two uses periodic boundary conditions", [&] {
        loadCheckpoint(*plain.context, saveCheckpoint(*periodic.context));
    });
    assertThrows("only one of the two uses periodic boundary conditions", [&] {
        loadCheckpoint(*periodic.context, saveCheckpoint(*plain.context));
    });
    plain.context->setState(writeAndRead(*periodic.context));
    assertRounded(platform, getPositions(*periodic.context), getPositions(*plain.context));
    plain.integrator.step(1);
}

/**
 * Another Integrator and a change of the box in turn with sampling: limits may grow, not shrink.
 */
void testBoxBetweenSteps(Platform& platform)
{
    TwoBeads beads;
    CompoundIntegrator both;
    TorsionMonteCarloIntegrator* sampler = new TorsionMonteCarloIntegrator(300);
    sampler->addRigidBodyMove(1, 0.01, 0.1);
    both.addIntegrator(sampler);
    both.addIntegrator(new VerletIntegrator(0.001));
    Context context(beads.system, both, platform);
    context.setPositions(beads.positions);
    both.step(1);
    ASSERT_EQUAL(0, sampler->getNumToleratedClashes(context));
    const vector<Vec3> x = getPositions(context);
    const double width = getNearestDistance(x[0], x[1], {{Vec3(50, 0, 0), Vec3(0, 3, 0), Vec3(0, 0, 3)}}) + 0.45;
    setBox(context, {{Vec3(width, 0, 0), Vec3(0, 3, 0), Vec3(0, 0, 3)}});
    both.step(1);
    ASSERT_EQUAL(1, sampler->getNumToleratedClashes(context));
    setBox(context, CUBE);
    both.step(1);
    ASSERT_EQUAL(1, sampler->getNumToleratedClashes(context));
    setBox(context, {{Vec3(0.9, 0, 0), Vec3(0, 3, 0), Vec3(0, 0, 3)}});
    assertThrows("the periodic box is 0.9 nm wide", [&] {
        both.step(1);
    });
    setBox(context, CUBE);
    both.step(1);
    ASSERT_EQUAL(1, sampler->getNumToleratedClashes(context));
}

/**
 * Where spheres count for nothing, trials whose images overlap are refused early only if the energy has images, too.
 */
void testEarlyRefusal(Platform& platform)
{
    for (bool periodic : {false, true}) {
        TwoBeads beads;
        NonbondedForce* nonbonded = new NonbondedForce();
        beads.system.addForce(nonbonded);
        if (periodic)
            nonbonded->setNonbondedMethod(NonbondedForce::CutoffPeriodic);
        nonbonded->setCutoffDistance(1.4);
        for (int i = 0; i < 2; i++)
            nonbonded->addParticle(0, 0.8, 0.5);
        TorsionMonteCarloIntegrator integrator(300);
        integrator.setRandomNumberSeed(2);
        integrator.setNativeEnergies(false);
        integrator.addRigidBodyMove(1, 1.5, 1);
        integrator.setStericMode(TorsionMonteCarloIntegrator::Off);
        Context context(beads.system, integrator, platform);
        context.setPositions({Vec3(0, 0, 0), Vec3(100.5, 1.5, 0)}); // far without images
        integrator.setTrialsPerStep(40);
        integrator.step(5);
        long long attempted, clashed, rejected, accepted;
        integrator.getMoveStatistics(0, attempted, clashed, rejected, accepted);
        ASSERT_EQUAL(periodic, clashed > 0);
        ASSERT(periodic || accepted == attempted);
    }
}

void testPeriodicBoxes(Platform& platform)
{
    testClashAcrossFaces(platform);
    testQueriesAgainstAllPairs(platform);
    testProposals(platform);
    testWrongBoxes(platform);
    testFlagIsKept(platform);
    testChangedBox(platform);
    testWarnings(platform);
    testSampledStates(platform);
    testResuming(platform);
    testWrappedStates(platform);
    testOtherForces(platform);
    testBoxBetweenSteps(platform);
    testEarlyRefusal(platform);
}
