/**
 * This tests closures: bonds of rings, and of loops between fixed parts, that every move keeps.
 *
 * The argument multiplies the number of samples of a loop: TestRingClosures 10 takes minutes and says what it finds.
 */

#include "BackboneSupport.h"
#include "openmm/CustomTorsionForce.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "Significance.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * What a closure keeps: lengths, angles and dihedrals from two particles to two others.
 */
static vector<double> measure(const vector<Vec3>& x, const StericExclusionForce& force, int closure)
{
    int p[4];
    force.getClosureParticles(closure, p[0], p[1], p[2], p[3]);
    const Vec3 a = x[p[0]], b = x[p[1]], c = x[p[2]], d = x[p[3]];
    auto getAngle = [](const Vec3& first, const Vec3& middle, const Vec3& last) {
        const Vec3 v = first - middle, w = last - middle;
        return atan2(sqrt(v.cross(w).dot(v.cross(w))), v.dot(w));
    };
    return {getDistance(b, c), getAngle(a, b, c), getAngle(b, c, d), getDihedral(a, b, c, d)};
}

static void assertKept(const vector<Vec3>& before, const vector<Vec3>& after, const StericExclusionForce& force)
{
    for (int i = 0; i < force.getNumClosures(); i++) {
        const vector<double> expected = measure(before, force, i), found = measure(after, force, i);
        for (int j = 0; j < 4; j++)
            ASSERT(fabs(remainder(found[j] - expected[j], 2 * M_PI)) < 1e-9);
    }
}

class Counts {
public:
    Counts(const TorsionMonteCarloIntegrator& integrator, int move)
    {
        integrator.getMoveStatistics(move, attempted, clashed, rejected, accepted);
    }
    long long attempted, clashed, rejected, accepted;
};

/**
 * A ring stays closed, and all of it moves.
 */
static void testRing(Platform& platform)
{
    Backbone ring(14, 0.08);
    const int last = ring.positions.size() - 1;
    ring.force->addClosure(last - 1, last, 0, 1);
    ring.force->createExclusionsFromBonds(3);

    // A torsion across the closure has no other energy wherever the ring goes.

    CustomTorsionForce* energy = new CustomTorsionForce("10*cos(theta)");
    energy->addTorsion(last - 1, last, 0, 1);
    ring.system.addForce(energy);
    ring.system.addConstraint(0, last, getDistance(ring.positions[0], ring.positions[last]));
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(3);
    integrator.addClosedMove(1, 0.3, {}, 0.3);
    integrator.addRigidBodyMove(0.05, 0.1, 0.3);
    Context context(ring.system, integrator, platform);
    context.setPositions(ring.positions);
    const double start = context.getState(State::Energy).getPotentialEnergy();
    vector<double> before, after;
    integrator.getTorsionAngles(context, before);
    integrator.step(1000);
    integrator.getTorsionAngles(context, after);
    ASSERT(Counts(integrator, 0).accepted > 20000);
    ASSERT(Counts(integrator, 1).accepted > 1000);
    assertKept(ring.positions, getPositions(context), *ring.force);
    for (int i = 0; i < 14; i++)
        ASSERT(fabs(after[i] - before[i]) > 1e-3);
    ASSERT_EQUAL_TOL(start, context.getState(State::Energy).getPotentialEnergy(), 1e-8);
    ASSERT_EQUAL_TOL(start, integrator.getPotentialEnergy(context), 1e-6);

    // OpenMM takes it for one molecule, and its ends for bonded neighbours.

    ASSERT_EQUAL(1, context.getMolecules().size());
    vector<pair<int, int>> pairs;
    vector<double> distances;
    ring.force->getNeighborPairs(context, 10, pairs, distances);
    for (auto pair : {make_pair(0, last), make_pair(1, last), make_pair(0, last - 2), make_pair(1, last - 1)})
        ASSERT(find(pairs.begin(), pairs.end(), pair) == pairs.end());
    ASSERT(find(pairs.begin(), pairs.end(), make_pair(1, last - 2)) != pairs.end());
}

/**
 * A backbone with two side chains of two particles each, whose ends a closure joins as in a disulfide.
 */
class Bridged : public Backbone {
public:
    explicit Bridged(double radius) : Backbone(24, radius)
    {
        for (int residue : {3, 6}) {
            const int alpha = 3 * residue + 1, first = system.getNumParticles();
            const Vec3 x = positions[alpha];
            const Vec3 away = (x - positions[alpha - 1]) + (x - positions[alpha + 1]);
            const Vec3 across = (x - positions[alpha - 1]).cross(x - positions[alpha + 1]);
            const Vec3 way = away / sqrt(away.dot(away)) + across / sqrt(across.dot(across));
            positions.push_back(x + way * 0.1);
            positions.push_back(positions.back() + away * 0.8 - across * 3);
            for (int i = 0; i < 2; i++) {
                system.addParticle(1);
                force->addParticle(radius);
            }
            force->addBond(alpha, first);
            force->addBond(first, first + 1);
            chi.push_back(force->addTorsion(alpha - 1, alpha, first, first + 1));
        }
        const int last = system.getNumParticles() - 1;
        force->addClosure(last - 3, last - 2, last, last - 1);
        force->createExclusionsFromBonds(3);
    }
    vector<int> chi;
    /** The torsions of the ring: psi 3 to phi 6, and both chi. */
    vector<int> getRing() const
    {
        return {6, 7, 8, 9, 10, 11, chi[0], chi[1]};
    }
};

static void testBridge(Platform& platform)
{
    Bridged chain(0.05);
    LinkStructure structure(chain.system, *chain.force);
    const vector<int> ring = chain.getRing();
    for (int i = 0; i < chain.force->getNumTorsions(); i++)
        ASSERT_EQUAL(find(ring.begin(), ring.end(), i) == ring.end() ? -1 : 0,
                     structure.getLinkClosure(structure.getTorsionLinks()[i]));
    ASSERT(structure.areKeptTogether(chain.positions.size() - 1, chain.positions.size() - 3));
    ASSERT(!structure.areKeptTogether(chain.positions.size() - 1, 0));
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(5);
    integrator.addTorsionMove(1, 0.2);
    integrator.addTorsionMove(1, 0.2, {}, 18);
    integrator.addClosedMove(5, 0.2);
    integrator.addLocalMove(1, 0.05, 10);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    vector<double> before, after;
    integrator.getTorsionAngles(context, before);
    integrator.step(300);
    integrator.getTorsionAngles(context, after);
    for (int move = 0; move < 4; move++)
        ASSERT(Counts(integrator, move).accepted > 100);
    assertKept(chain.positions, getPositions(context), *chain.force);
    for (int i = 0; i < chain.force->getNumTorsions(); i++)
        ASSERT(fabs(after[i] - before[i]) > 1e-4);

    // So do windows of the ring alone, which lead over the closure and over the residue on which the ring hangs.

    integrator.setClosedMoveParameters(2, 1, 0.2, ring);
    integrator.getTorsionAngles(context, before);
    integrator.step(100);
    integrator.getTorsionAngles(context, after);
    assertKept(chain.positions, getPositions(context), *chain.force);
    for (int torsion : ring)
        ASSERT(fabs(after[torsion] - before[torsion]) > 1e-6);
}

/**
 * What names a torsion of a ring says why it cannot.
 */
static void testRefusals(Platform& platform)
{
    Bridged chain(0.05);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addTorsionMove(1, 0.1);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    const string reason = "names torsion 7, which lies in the ring of closure 0; only closed moves turn it";
    assertThrows("TorsionMonteCarloIntegrator: move 1 " + reason, [&] {
        integrator.addTorsionMove(1, 0.1, {2, 7});
    });
    assertThrows("TorsionMonteCarloIntegrator: move 1 " + reason, [&] {
        integrator.addLocalMove(1, 0.05, 10, {2, 7});
    });
    assertThrows("move 1 turns 19 torsions at once, but has only 18 to choose from", [&] {
        integrator.addTorsionMove(1, 0.1, {}, 19);
    });
    assertThrows("StericExclusionForce: proposeTorsions() " + reason, [&] {
        chain.force->proposeTorsions(context, {2, 7}, {0.1, 0.1});
    });
    vector<double> angles;
    integrator.getTorsionAngles(context, angles);
    angles[2] += 0.1;
    integrator.setTorsionAngles(context, angles);
    const vector<Vec3> x = getPositions(context);
    ASSERT(getDistance(x[8], chain.positions[8]) > 1e-3);
    angles[7] += 0.1;
    assertThrows("StericExclusionForce: setTorsionAngles() " + reason, [&] {
        integrator.setTorsionAngles(context, angles);
    });
    assertSameBits(x, getPositions(context));

    // All torsions of a ring.

    Backbone ring(14, 0);
    ring.force->addClosure(22, 23, 0, 1);
    TorsionMonteCarloIntegrator other(300);
    other.addTorsionMove(1, 0.1);
    assertThrows("move 0 turns torsions, but all of them lie in rings of closures", [&] {
        Context ringContext(ring.system, other, platform);
    });

    // Ball joints of a ring turn by no move.

    System beads;
    StericExclusionForce* joined = new StericExclusionForce();
    beads.addForce(joined);
    for (int i = 0; i < 5; i++) {
        beads.addParticle(1);
        joined->addParticle(0);
        if (i > 0) {
            joined->addBond(i - 1, i);
            joined->addBallJoint(i - 1, i);
        }
    }
    joined->addClosure(2, 3, 0, 1);
    TorsionMonteCarloIntegrator pivots(300);
    pivots.addPivotMove(1, 0.1);
    Context beadContext(beads, pivots, platform);
    assertThrows("move 1 names ball joint 2, which lies in the ring of closure 0; no move turns it", [&] {
        pivots.addPivotMove(1, 0.1, {3, 2});
    });
    vector<Vec3> circle;
    for (int i = 0; i < 5; i++)
        circle.push_back(Vec3(cos(i), sin(i), 0.1 * i));
    beadContext.setPositions(circle);
    pivots.step(1);
    const vector<Vec3> turned = getPositions(beadContext);
    for (int i = 0; i < 4; i++)
        ASSERT(getDistance(circle[i], turned[i]) < 1e-12);
    ASSERT(getDistance(circle[4], turned[4]) > 1e-3);
    assertThrows("proposeBallRotations() names ball joint 0, which lies in the ring of closure 0", [&] {
        joined->proposeBallRotations(beadContext, {0}, {Vec3(0.1, 0, 0)});
    });

    // A window must keep the closure: none of 8 torsions of a chain, to whose middle its end is tied.

    Backbone tied(8, 0);
    tied.force->addClosure(13, 14, 7, 6);
    TorsionMonteCarloIntegrator third(300);
    third.addClosedMove(1, 0.1);
    assertThrows("its torsions have none", [&] {
        Context tiedContext(tied.system, third, platform);
    });

    // A closure is a part of the structure.

    Backbone open(14, 0);
    stringstream checkpoint;
    TorsionMonteCarloIntegrator first(300), second(300);
    for (auto each : {&first, &second})
        each->addClosedMove(1, 0.1);
    Context ringContext(ring.system, first, platform), openContext(open.system, second, platform);
    ringContext.setPositions(ring.positions);
    ringContext.createCheckpoint(checkpoint);
    assertThrows("the checkpoint is of another structure", [&] {
        openContext.loadCheckpoint(checkpoint);
    });
    ring.force->addClosure(20, 21, 3, 4);
    assertThrows("its particles, bonds, torsions, ball joints, closures or exclusions differ from those", [&] {
        ring.force->updateParametersInContext(ringContext);
    });
}

static void testDefinitions()
{
    auto assertRefused = [](const string& message, const array<int, 4>& closure) {
        Backbone chain(8, 0, 3);
        chain.force->addClosure(closure[0], closure[1], closure[2], closure[3]);
        assertThrows("StericExclusionForce: " + message, [&] {
            LinkStructure structure(chain.system, *chain.force);
        });
    };
    assertRefused("closure 0 (13-14-0-18) names particle 18, but there are 18 particles", {13, 14, 0, 18});
    assertRefused("the first two particles of closure 0 (12-14-0-1) must be bonded, and the last two, but there is no "
                  "bond between particles 12 and 14",
                  {12, 14, 0, 1});
    assertRefused("the first two particles of closure 0 (13-14-0-2) must be bonded, and the last two, but there is no "
                  "bond between particles 0 and 2",
                  {13, 14, 0, 2});
    assertRefused("the bond of closure 0 (0-1-2-3), between particles 1 and 2, must not be among the bonds",
                  {0, 1, 2, 3});
    assertRefused("closure 0 (13-14-15-16) closes nothing: particles 14 and 15 belong to different molecules, and not "
                  "both of these have fixed particles; add a bond instead",
                  {13, 14, 15, 16});
    Backbone twice(8, 0);
    ASSERT_EQUAL(0, twice.force->addClosure(13, 14, 0, 1));
    ASSERT_EQUAL(1, twice.force->addClosure(1, 0, 14, 13));
    ASSERT_EQUAL(2, twice.force->getNumClosures());
    int p1, p2, p3, p4;
    twice.force->getClosureParticles(1, p1, p2, p3, p4);
    ASSERT(p1 == 1 && p2 == 0 && p3 == 14 && p4 == 13);
    assertThrows("Index out of range", [&] {
        twice.force->getClosureParticles(2, p1, p2, p3, p4);
    });
    assertThrows("the bond of closure 1 (1-0-14-13) has a closure already", [&] {
        LinkStructure structure(twice.system, *twice.force);
    });
}

/**
 * A loop between fixed parts is sampled as all its closures say: with drivers on a grid, each solution weighs 1/|J|.
 */
static void testFixedLoop(Platform& platform, double factor)
{
    const bool isLong = factor > 1;
    const int numTorsions = 8, numBins = 8, numCells = isLong ? 500 : 160;
    Backbone loop(numTorsions, 0, 3);
    for (int particle : {0, 1, 15, 16, 17})
        loop.system.setParticleMass(particle, 0);
    loop.force->addClosure(13, 14, 15, 16);
    const ctWindow window = findWindow(loop.positions, 0);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(3);
    integrator.setTrialsPerStep(isLong ? 240 : 80);
    integrator.addClosedMove(1, 1.5, {}, 0.6);
    Context context(loop.system, integrator, platform);
    context.setPositions(loop.positions);
    vector<double> start;
    integrator.getTorsionAngles(context, start);
    auto findBin = [&](double angle) {
        return (int)floor((remainder(angle, 2 * M_PI) / (2 * M_PI) + 0.5) * numBins) % numBins;
    };

    // The first driver, one pivot, and two more: what is expected of each, and what is found.

    const int looked[] = {0, 3, 4, 7};
    vector<vector<double>> expected(4, vector<double>(numBins, 0.0));
    double total = 0;
    for (int i = 0; i < numCells; i++)
        for (int j = 0; j < numCells; j++) {
            double turns[CT_WINDOW_MOST] = {0}, solutions[CT_CLOSURES_MOST][CT_PIVOTS];
            turns[0] = 2 * M_PI * (i + 0.5) / numCells;
            turns[7] = 2 * M_PI * (j + 0.5) / numCells;
            const int count = ctFindClosures(&window, turns, solutions);
            for (int k = 0; k < count; k++) {
                copy_n(solutions[k], 6, turns + 1);
                ctWindow turned;
                ctTurnWindow(&window, turns, &turned);
                const double weight = exp(-computeLogJacobian(turned));
                for (int l = 0; l < 4; l++)
                    expected[l][findBin(start[looked[l]] + turns[looked[l]])] += weight;
                total += weight;
            }
        }
    vector<vector<int>> found(4, vector<int>(numBins, 0));
    const int numSamples = factor * 2500;
    vector<double> angles;
    for (int i = 0; i < numSamples; i++) {
        integrator.step(1);
        integrator.getTorsionAngles(context, angles);
        for (int l = 0; l < 4; l++)
            found[l][findBin(angles[looked[l]])]++;
    }
    ASSERT(Counts(integrator, 0).accepted > Counts(integrator, 0).attempted / 20);
    double least = 1;
    for (int l = 0; l < 4; l++) {
        double chiSquared = 0;
        int numClasses = 0;
        for (int bin = 0; bin < numBins; bin++) {
            const double mean = expected[l][bin] / total * numSamples;
            if (mean > 5) {
                chiSquared += pow(found[l][bin] - mean, 2) / mean;
                numClasses++;
            }
            if (isLong)
                cout << "    torsion " << looked[l] << ": " << mean << " " << found[l][bin] << endl;
        }
        const double significance = getChiSquaredTail(chiSquared, numClasses - 1);
        if (isLong)
            cout << "fixed loop, torsion " << looked[l] << ": p = " << significance << endl;
        least = min(least, significance);
    }
    ASSERT(4 * least > 1e-3);

    // Neither end moves, nor does the bond between them open.

    const vector<Vec3> x = getPositions(context);
    for (int particle : {0, 1, 15, 16, 17})
        assertSameBits({loop.positions[particle]}, {x[particle]});
    assertKept(loop.positions, x, *loop.force);
}

int main(int argc, char** argv)
{
    const double factor = argc > 1 ? atof(argv[1]) : 1;
    return runOnPlatform("Reference", [&](Platform& platform) {
        testDefinitions();
        testRefusals(platform);
        testBridge(platform);
        testRing(platform);
        testFixedLoop(platform, factor);
    });
}
