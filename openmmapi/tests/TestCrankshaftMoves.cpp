/**
 * This tests crankshaft moves: which beads they turn, and what they sample.
 */

#include "FreeChain.h"
#include "openmm/CustomCompoundBondForce.h"
#include "openmm/serialization/XmlSerializer.h"
#include "SamplingSupport.h"
#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static double getLength(const Vec3& x)
{
    return sqrt(x.dot(x));
}

/**
 * Get by which angle the beads between two others have turned about the line between these. Throws an exception if that
 * is not how they have moved.
 */
static double findAngle(const vector<Vec3>& before, const vector<Vec3>& after, int begin, int end)
{
    const Vec3 axis = (before[end] - before[begin]) / getLength(before[end] - before[begin]);
    const auto across = [&](const Vec3& x) {
        const Vec3 way = x - before[begin];
        return way - axis * way.dot(axis);
    };
    int farthest = begin + 1;
    for (int i = begin + 1; i < end; i++)
        if (getLength(across(before[i])) > getLength(across(before[farthest])))
            farthest = i;
    const Vec3 a = across(before[farthest]), b = across(after[farthest]);
    const double angle = atan2(axis.dot(a.cross(b)), a.dot(b));
    for (int i = begin + 1; i < end; i++)
        ASSERT_EQUAL_VEC(rotate(before[i], before[begin], axis, angle), after[i], 1e-11);
    return angle;
}

/**
 * In random chains each trial turns one window about the line between its ends, by a uniform angle, and all windows are
 * drawn with the probabilities that are promised. Nothing else moves, and bonds keep their lengths.
 *
 * @param choices  the ball joints that may turn
 * @param root     a bead of mass 0, or -1
 */
static void testTrials(Platform& platform, const vector<int>& choices, int window, int root)
{
    const int length = 9, numTrials = 4000;
    FreeChain chain(length, 0);
    if (root != -1)
        chain.system.setParticleMass(root, 0);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(3);
    integrator.setTrialsPerStep(1);
    const double maxAngle = 0.7;
    integrator.addCrankshaftMove(1, maxAngle, choices, window);
    Context context(chain.system, integrator, platform);
    mt19937_64 random(4);
    context.setPositions(chain.drawPositions(random));

    // Which windows there are: joint i turns about bead i, and the root has no part in them.

    vector<int> row = choices;
    for (int i = 0; choices.empty() && i < length - 1; i++)
        row.push_back(i);
    sort(row.begin(), row.end());
    if (root != -1)
        reverse(row.begin(), row.end());
    map<pair<int, int>, double> expected;
    for (size_t end = 2; end < row.size(); end++) {
        const int most = min((int)end, window);
        for (int numBonds = 2; numBonds <= most; numBonds++)
            expected[minmax(row[end - numBonds], row[end])] = 1.0 / (row.size() - 2) / (most - 1);
    }
    map<pair<int, int>, int> counts;
    double sum = 0, squares = 0;
    vector<Vec3> before = getPositions(context);
    for (int i = 0; i < numTrials; i++) {
        integrator.step(1);
        const vector<Vec3> after = getPositions(context);
        int first = 0, last = length - 1;
        while (getDistance(before[first], after[first]) < 1e-9 && first < last)
            first++;
        while (getDistance(before[last], after[last]) < 1e-9 && first < last)
            last--;
        const pair<int, int> ends(first - 1, last + 1);
        ASSERT(expected.count(ends) == 1);
        counts[ends]++;
        const double angle = findAngle(before, after, ends.first, ends.second);
        ASSERT(fabs(angle) < maxAngle);
        sum += angle / maxAngle;
        squares += angle * angle / maxAngle / maxAngle;
        for (int j = 0; j < length; j++) {
            if (j <= ends.first || j >= ends.second)
                ASSERT_EQUAL_VEC(before[j], after[j], 1e-13);
            if (j > 0)
                ASSERT_EQUAL_TOL(1, getDistance(after[j - 1], after[j]), 1e-12);
        }
        before = after;
    }
    for (auto& one : expected) {
        const double share = one.second;
        ASSERT_USUALLY_EQUAL_TOL(share, counts[one.first] / (double)numTrials, 5 * sqrt(share / numTrials));
    }
    ASSERT_USUALLY_EQUAL_TOL(0, sum / numTrials, 5 * sqrt(1.0 / 3 / numTrials));
    ASSERT_USUALLY_EQUAL_TOL(1.0 / 3, squares / numTrials, 5 * 0.3 / sqrt(numTrials));
}

/**
 * Without energy, directions of bonds that are uniform and independent before a few trials are so afterwards. Pearson's
 * statistic of eight cells for each variable is compared with its quantile at 1e-6.
 */
static void testUniformDirections(Platform& platform)
{
    const int numCells = 8, numSamples = 10000, numBonds = 5;
    FreeChain chain(numBonds + 1, 0);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(5);
    integrator.setTrialsPerStep(4);
    integrator.addCrankshaftMove(1, M_PI);
    integrator.addCrankshaftMove(1, 0.8, {}, 3);
    Context context(chain.system, integrator, platform);
    mt19937_64 random(5);
    vector<vector<int>> counts(3 * numBonds - 3, vector<int>(numCells, 0));
    for (int i = 0; i < numSamples; i++) {
        context.setPositions(chain.drawPositions(random));
        integrator.step(1);
        const vector<Vec3> x = getPositions(context);
        vector<double> shares;
        for (int j = 0; j < numBonds; j++) {
            const Vec3 bond = x[j + 1] - x[j];
            shares.push_back(0.5 + 0.5 * bond[2]);
            if (j > 0)
                shares.push_back(0.5 + 0.5 * bond.dot(x[j] - x[j - 1]));
            if (j > 1)
                shares.push_back(0.5 + getDihedral(x[j - 2], x[j - 1], x[j], x[j + 1]) / (2 * M_PI));
        }
        for (size_t j = 0; j < counts.size(); j++)
            counts[j][min(numCells - 1, (int)(numCells * shares[j]))]++;
    }
    const double expected = numSamples / (double)numCells;
    for (size_t j = 0; j < counts.size(); j++) {
        double statistic = 0;
        for (int count : counts[j])
            statistic += (count - expected) * (count - expected) / expected;
        if (statistic > 40.5)
            throw OpenMMException("variable " + to_string(j) + " is not uniform: " + to_string(statistic));
    }
}

/**
 * With spheres and an energy, crankshaft moves beside pivot moves sample what pivot moves sample.
 */
static void testMeans(Platform& platform)
{
    const int numSteps = 20000;
    array<array<double, 3>, 2> means = {}, variances = {};
    for (int withCrankshafts = 0; withCrankshafts < 2; withCrankshafts++) {
        FreeChain chain(7, 0.6);
        CustomCompoundBondForce* energy = new CustomCompoundBondForce(3, "5*cos(angle(p1, p2, p3))+2*distance(p1, p3)");
        for (int i = 0; i + 2 < 7; i++)
            energy->addBond({i, i + 1, i + 2});
        chain.system.addForce(energy);
        TorsionMonteCarloIntegrator integrator(300);
        integrator.setRandomNumberSeed(8);
        integrator.setTrialsPerStep(20);
        integrator.setStericMode(TorsionMonteCarloIntegrator::Hard);
        integrator.addPivotMove(1, M_PI);
        if (withCrankshafts == 1)
            integrator.addCrankshaftMove(3, M_PI);
        Context context(chain.system, integrator, platform);
        context.setPositions(chain.positions);
        integrator.step(100);
        for (int i = 0; i < numSteps; i++) {
            integrator.step(1);
            const vector<Vec3> x = getPositions(context);
            const array<double, 3> values = {
                {(x[6] - x[0]).dot(x[6] - x[0]), (x[3] - x[2]).dot(x[2] - x[1]), (x[4] - x[1]).dot(x[4] - x[1])}};
            for (int j = 0; j < 3; j++) {
                means[withCrankshafts][j] += values[j] / numSteps;
                variances[withCrankshafts][j] += values[j] * values[j] / numSteps;
            }
        }
        for (int j = 0; j < 3; j++)
            variances[withCrankshafts][j] -= means[withCrankshafts][j] * means[withCrankshafts][j];
    }

    // Five standard deviations, if ten samples are worth one.

    for (int j = 0; j < 3; j++)
        ASSERT_USUALLY_EQUAL_TOL(means[0][j], means[1][j],
                                 5 * sqrt((variances[0][j] + variances[1][j]) / (numSteps / 10)));
}

static void testParameters(Platform& platform)
{
    TorsionMonteCarloIntegrator integrator(300);
    ASSERT_EQUAL(0, integrator.addCrankshaftMove(2, 0.5, {3, 1, 2}, 5));
    ASSERT_EQUAL(TorsionMonteCarloIntegrator::CrankshaftMove, integrator.getMoveType(0));
    ASSERT_EQUAL("crankshaft ±0.5 rad (weight 2, 3 ballJoints to choose from)", integrator.getMoveDescription(0));
    stringstream xml;
    XmlSerializer::serialize<Integrator>(&integrator, "Integrator", xml);
    unique_ptr<Integrator> read(XmlSerializer::deserialize<Integrator>(xml));
    auto& copy = dynamic_cast<TorsionMonteCarloIntegrator&>(*read);
    integrator.setCrankshaftMoveParameters(0, 1, 0.25);
    double weight, maxAngle;
    vector<int> joints;
    int window;
    integrator.getCrankshaftMoveParameters(0, weight, maxAngle, joints, window);
    ASSERT_EQUAL(1, weight);
    ASSERT_EQUAL(0.25, maxAngle);
    ASSERT(joints.empty());
    ASSERT_EQUAL(8, window);
    copy.getCrankshaftMoveParameters(0, weight, maxAngle, joints, window);
    ASSERT_EQUAL(0.5, maxAngle);
    ASSERT_EQUAL_CONTAINERS((vector<int>{3, 1, 2}), joints);
    ASSERT_EQUAL(5, window);
    assertThrows("the largest angle of a crankshaft move must be at most pi, half a turn, but is 20 radians", [&] {
        integrator.addCrankshaftMove(1, 20);
    });
    assertThrows("the largest number of bonds in a window of a crankshaft move must be at least 2, but is 1", [&] {
        integrator.addCrankshaftMove(1, 1, {}, 1);
    });
    FreeChain chain(4, 0.1);
    assertThrows("no three of its ball joints follow each other", [&] {
        TorsionMonteCarloIntegrator other(300);
        other.addCrankshaftMove(1, 0.1, {0, 2});
        Context context(chain.system, other, platform);
    });
}

int main()
{
    return runOnPlatform("Reference", [](Platform& platform) {
        testParameters(platform);
        testTrials(platform, {}, 8, -1);
        testTrials(platform, {}, 3, 8);
        testTrials(platform, {1, 2, 4, 7}, 3, -1);
        testUniformDirections(platform);
        testMeans(platform);
    });
}
