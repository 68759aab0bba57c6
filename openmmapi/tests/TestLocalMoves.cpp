/**
 * This tests local moves: that they leave torsions uniform where there is no energy, that they leave the ends of
 * windows nearly where they are, what their parameters mean, and how they are kept.
 */

#include "openmm/serialization/XmlSerializer.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "SamplingSupport.h"
#include <memory>
#include <random>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/** In standard errors, what a mean may change by. Chance makes one of 43 means exceed it in one of 3,000 seeds. */
static const double LARGEST_CHANGE = 4.5;

/**
 * Get log det(1 + stiffness G) of the window of all torsions, by Gauss's elimination: what a wrong ratio shifts first.
 */
static double computeLogDeterminant(const vector<Vec3>& x, double stiffness)
{
    const int count = x.size() - 3;
    vector<vector<double>> a(count, vector<double>(count));
    auto differentiate = [&](int torsion, int end) {
        const Vec3 axis = x[torsion + 2] - x[torsion + 1];
        return axis.cross(x[end] - x[torsion + 1]) / sqrt(axis.dot(axis));
    };
    double logarithm = 0;
    for (int i = 0; i < count; i++)
        for (int j = 0; j < count; j++) {
            a[i][j] = (i == j ? 1 : 0);
            for (int end = count; end < count + 3; end++)
                a[i][j] += stiffness * differentiate(i, end).dot(differentiate(j, end));
        }
    for (int i = 0; i < count; i++) {
        logarithm += log(a[i][i]);
        for (int j = i + 1; j < count; j++) {
            const double factor = a[j][i] / a[i][i];
            for (int k = i; k < count; k++)
                a[j][k] -= factor * a[i][k];
        }
    }
    return logarithm;
}

/**
 * Get what is compared: of torsions and their neighbours, how far apart beads are, and the determinant.
 */
static vector<double> computeValues(const vector<double>& angles, const vector<Vec3>& x, double stiffness)
{
    vector<double> values(1, computeLogDeterminant(x, stiffness));
    for (size_t i = 0; i < angles.size(); i++) {
        values.push_back(cos(angles[i]));
        values.push_back(sin(2 * angles[i]));
        if (i > 0) {
            values.push_back(cos(angles[i] - angles[i - 1]));
            values.push_back(cos(angles[i] + angles[i - 1]));
        }
    }
    for (size_t i = 0; i + 4 < x.size(); i++)
        values.push_back(getDistance(x[i], x[i + 4]));
    values.push_back(getDistance(x.front(), x.back()));
    return values;
}

/**
 * Torsions that are drawn uniformly are uniform after any number of trials, too: all windows of a chain, mixed with
 * another move and scaled if it is to be.
 */
static void testUniformTorsions(Platform& platform, int numTorsions, double sigma, double stiffness, bool isMixed)
{
    const int numStarts = 15000;
    BeadChain chain(numTorsions + 3, 0);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(3);
    integrator.setTrialsPerStep(30);
    integrator.addLocalMove(1, sigma, stiffness, {}, isMixed ? 3 : 8);
    if (isMixed) {
        integrator.setMoveScale(0, 0.8);
        integrator.addTorsionMove(0.2, 0.5);
    }
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    mt19937_64 random(5);
    vector<double> sums, squares;
    for (int start = 0; start < numStarts; start++) {
        vector<double> angles(numTorsions);
        for (double& angle : angles)
            angle = M_PI * (2 * (random() >> 11) * 0x1p-53 - 1);
        integrator.setTorsionAngles(context, angles);
        const vector<double> before = computeValues(angles, getPositions(context), stiffness);
        integrator.step(1);
        integrator.getTorsionAngles(context, angles);
        const vector<double> after = computeValues(angles, getPositions(context), stiffness);
        sums.resize(before.size());
        squares.resize(before.size());
        for (size_t i = 0; i < before.size(); i++) {
            const double change = after[i] - before[i];
            sums[i] += change;
            squares[i] += change * change;
        }
    }
    double largest = 0;
    for (size_t i = 0; i < sums.size(); i++)
        largest = max(largest, fabs(sums[i]) / sqrt(squares[i]));
    const Statistics counts(integrator, 0);
    const double accepted = counts.accepted / (double)counts.attempted;
    cout << "Largest change of " << sums.size() << " means: " << largest << " standard errors; accepted: " << accepted
         << endl;
    ASSERT(largest < LARGEST_CHANGE);
    ASSERT(accepted > 0.2 && accepted < 0.95);
    ASSERT_EQUAL(0, counts.clashed);
}

/**
 * A stiff window shifts its ends much less than its inside; without stiffness, torsions change by sigma.
 */
static void testStiffness(Platform& platform)
{
    BeadChain chain(23, 0, 1);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(8);
    integrator.setTrialsPerStep(1);
    vector<int> middle;
    for (int i = 4; i < 12; i++)
        middle.push_back(i);
    integrator.addLocalMove(1, 0.02, 1000, middle);
    Context context(chain.system, integrator, platform);
    auto measure = [&](double& inside, double& behind, double& turned) {
        inside = behind = turned = 0;
        int numMoved = 0;
        for (int i = 0; i < 5000; i++) {
            context.setPositions(chain.positions);
            vector<double> before, after;
            integrator.getTorsionAngles(context, before);
            integrator.step(1);
            integrator.getTorsionAngles(context, after);

            // Only whole windows: the middle torsions move.

            if (before[4] == after[4] || before[11] == after[11])
                continue;
            const vector<Vec3> x = getPositions(context);
            inside += pow(getDistance(x[10], chain.positions[10]), 2);
            behind += pow(getDistance(x[14], chain.positions[14]), 2);
            turned += pow(remainder(after[7] - before[7], 2 * M_PI), 2);
            numMoved++;
        }
        ASSERT(numMoved > 100);
        inside = sqrt(inside / numMoved);
        behind = sqrt(behind / numMoved);
        turned = sqrt(turned / numMoved);
    };
    double inside, behind, turned;
    measure(inside, behind, turned);
    cout << "Shifts inside and behind a window: " << inside << " and " << behind << " nm" << endl;
    ASSERT(behind < 0.2 * inside);
    ASSERT(turned < 0.02);
    integrator.setLocalMoveParameters(0, 1, 0.02, 0, middle);
    measure(inside, behind, turned);
    ASSERT(behind > inside);
    ASSERT_USUALLY_EQUAL_TOL(0.02, turned, 0.15);
}

/**
 * Of a chain of 6 torsions, windows of 3 are 0, 01, 012, 123, 234, 345, 45, 5.
 */
static void testWindows(Platform& platform)
{
    BeadChain chain(9, 0);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(2);
    integrator.setTrialsPerStep(1);
    integrator.addLocalMove(1, 0.2, 0, {}, 3);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    vector<int> numTurned(6, 0), numOfSize(4, 0);
    const int numTrials = 4000;
    for (int i = 0; i < numTrials; i++) {
        vector<double> before, after;
        integrator.getTorsionAngles(context, before);
        integrator.step(1);
        integrator.getTorsionAngles(context, after);
        int first = 6, last = -1, count = 0;
        for (int j = 0; j < 6; j++)
            if (before[j] != after[j]) {
                numTurned[j]++;
                count++;
                first = min(first, j);
                last = max(last, j);
            }
        ASSERT_EQUAL(count, last - first + 1);
        ASSERT(count >= 1 && count <= 3);
        numOfSize[count]++;
    }
    for (int turned : numTurned)
        ASSERT_USUALLY_EQUAL_TOL(3 / 8.0, turned / (double)numTrials, 0.1);
    ASSERT_USUALLY_EQUAL_TOL(0.5, numOfSize[3] / (double)numTrials, 0.1);
    ASSERT_EQUAL(numTrials, Statistics(integrator, 0).accepted);
}

/**
 * Parameters come back, also from XML, and sampling continues from a checkpoint bit for bit.
 */
static void testKeeping(Platform& platform)
{
    BeadChain chain(12, 0.4);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(2);
    integrator.addLocalMove(0.5, 0.25, 1.0 / 3, {1, 3, 2, 5}, 3);
    integrator.addLocalMove(1, 0.5, 10);
    ASSERT_EQUAL(TorsionMonteCarloIntegrator::LocalMove, integrator.getMoveType(0));
    ASSERT_EQUAL("local ±0.25 rad (weight 0.5, 4 torsions to choose from)", integrator.getMoveDescription(0));
    integrator.setLocalMoveParameters(1, 2, 0.4, 20);
    stringstream xml;
    XmlSerializer::serialize<Integrator>(&integrator, "Integrator", xml);
    unique_ptr<Integrator> read(XmlSerializer::deserialize<Integrator>(xml));
    auto& copy = dynamic_cast<TorsionMonteCarloIntegrator&>(*read);
    double weight, sigma, stiffness;
    vector<int> torsions;
    int window;
    copy.getLocalMoveParameters(0, weight, sigma, stiffness, torsions, window);
    ASSERT_EQUAL(0.5, weight);
    ASSERT_EQUAL(0.25, sigma);
    ASSERT_EQUAL(1.0 / 3, stiffness);
    ASSERT_EQUAL_CONTAINERS((vector<int>{1, 3, 2, 5}), torsions);
    ASSERT_EQUAL(3, window);
    copy.getLocalMoveParameters(1, weight, sigma, stiffness, torsions, window);
    ASSERT_EQUAL(2, weight);
    ASSERT_EQUAL(0.4, sigma);
    ASSERT_EQUAL(20, stiffness);
    ASSERT(torsions.empty());
    ASSERT_EQUAL(8, window);
    Context context(chain.system, integrator, platform), copiedContext(chain.system, copy, platform);
    context.setPositions(chain.positions);
    integrator.step(7);
    stringstream checkpoint;
    context.createCheckpoint(checkpoint);
    copiedContext.loadCheckpoint(checkpoint);
    integrator.step(5);
    copy.step(5);
    assertSameBits(getPositions(context), getPositions(copiedContext));
    ASSERT(Statistics(integrator, 1).accepted > 0);
    ASSERT_EQUAL(Statistics(integrator, 1).accepted, Statistics(copy, 1).accepted);
}

static void testBadMoves(Platform& platform)
{
    TorsionMonteCarloIntegrator integrator(300);
    const double nan = numeric_limits<double>::quiet_NaN();
    for (double bad : {-0.1, nan, numeric_limits<double>::infinity()}) {
        assertThrows("the sigma of a local move must be a finite number", [&] {
            integrator.addLocalMove(1, bad, 10);
        });
        assertThrows("the stiffness of a local move must be a finite number", [&] {
            integrator.addLocalMove(1, 0.1, bad);
        });
        assertThrows("the weight of a move must be", [&] {
            integrator.addLocalMove(bad, 0.1, 1);
        });
    }
    assertThrows("the sigma of a local move must be above 0", [&] {
        integrator.addLocalMove(1, 0, 10);
    });
    assertThrows("the sigma of a local move must be at most pi, half a turn, but is 20 radians; 20 degrees are", [&] {
        integrator.addLocalMove(1, 20, 10);
    });
    for (int bad : {-1, 0, 33})
        assertThrows(
            "the number of torsions in a window of a local move must be from 1 to 32, but is " + to_string(bad), [&] {
                integrator.addLocalMove(1, 0.1, 10, {}, bad);
            });
    ASSERT_EQUAL(0, integrator.getNumMoves());
    integrator.addTorsionMove(1, 0.1);
    assertThrows("move 0 is not a local move", [&] {
        integrator.setLocalMoveParameters(0, 1, 0.1, 10);
    });
    BeadChain chain(6, 0.3), rigid(3, 0.3);
    Context context(chain.system, integrator, platform);
    assertThrows("move 1 names torsion 3, but there are 3 torsions", [&] {
        integrator.addLocalMove(1, 0.1, 10, {0, 3});
    });
    assertThrows("move 1 names torsion 0 twice", [&] {
        integrator.addLocalMove(1, 0.1, 10, {0, 1, 0});
    });
    assertThrows("move 0 turns torsions, but the StericExclusionForce has none", [&] {
        TorsionMonteCarloIntegrator other(300);
        other.addLocalMove(1, 0.1, 10);
        Context refused(rigid.system, other, platform);
    });

    // Torsions in the ring of a closure are not in windows.

    BeadChain ring(9, 0), tail(9, 0);
    ring.force->addClosure(1, 0, 8, 7);
    assertThrows("move 0 turns windows of torsions, but all of them lie in rings of closures", [&] {
        TorsionMonteCarloIntegrator other(300);
        other.addLocalMove(1, 0.1, 10);
        Context refused(ring.system, other, platform);
    });
    tail.force->addClosure(1, 0, 4, 3);
    TorsionMonteCarloIntegrator ofTail(300);
    ofTail.addLocalMove(1, 0.1, 10);
    Context tailContext(tail.system, ofTail, platform);
    tailContext.setPositions(tail.positions);
    ofTail.step(1);
    const vector<Vec3> x = getPositions(tailContext);
    assertSameBits({tail.positions.begin(), tail.positions.begin() + 5}, {x.begin(), x.begin() + 5});
    ASSERT(getDistance(x[8], tail.positions[8]) > 1e-3);
}

int main()
{
    return runOnPlatform("Reference", [](Platform& platform) {
        testUniformTorsions(platform, 3, 2, 30, false);
        testUniformTorsions(platform, 6, 2.5, 100, true);
        testStiffness(platform);
        testWindows(platform);
        testKeeping(platform);
        testBadMoves(platform);
    });
}
