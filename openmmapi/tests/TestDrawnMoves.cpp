/**
 * This tests moves that draw torsions from a density: what they sample, what they write, and bad input.
 */

#include "openmm/CustomTorsionForce.h"
#include "openmm/serialization/XmlSerializer.h"
#include "openmmchaintree/internal/RandomNumberGenerator.h"
#include "openmmchaintree/TorsionDensity.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "SamplingSupport.h"
#include "Significance.h"
#include <functional>
#include <limits>
#include <memory>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/** Has two peaks, one of them across the end of the circle. */
static TorsionDensity makePeaks(double floor = 0.2)
{
    return TorsionDensity::fromRotamers({3, 1}, {0.7, -3}, {0.2, 0.3}, floor);
}

/** Correlates two torsions: a ridge along which their sum is 0. */
static TorsionDensity makeRidge()
{
    vector<double> values;
    for (int i = 0; i < 12; i++)
        for (int j = 0; j < 18; j++)
            values.push_back(exp(1.5 * cos((i / 12.0 + j / 18.0) * 2 * M_PI)));
    return TorsionDensity::fromTable({12, 18}, values, 0.02);
}

/** Rotamers of three torsions, as a side chain has them. */
static TorsionDensity makeSideChain()
{
    return TorsionDensity::fromRotamers({5, 2, 1}, {-1.1, 3.1, 1.2, 3.1, -1.1, 0.2, 1.1, 1.5, -1.3},
                                        {0.3, 0.3, 0.5, 0.3, 0.4, 1.2, 0.3, 0.3, 0.3}, 0.5);
}

// ---- What is sampled ----

/**
 * Get the cell of angles in a grid.
 */
static int cellOf(const vector<double>& angles, int cellsOfTorsion)
{
    int cell = 0;
    for (double angle : angles)
        cell = cellsOfTorsion * cell + min(cellsOfTorsion - 1, (int)((angle + M_PI) / (2 * M_PI) * cellsOfTorsion));
    return cell;
}

/** Eight comparisons of this significance are one of 8e-5. */
static const double LEAST_CHANCE = 1e-5;

/**
 * Without energy and spheres torsions stay uniform: from independent uniform starts after two trials, and in a chain.
 * A
 * chain forgets within max(uniform / density) trials, at most 8 here, and samples are 60 apart.
 */
static void testUniform(Platform& platform, int numTorsions, const vector<vector<int>>& sets,
                        const vector<TorsionDensity>& densities)
{
    const int numSamples = 8000, numCells = numTorsions == 3 ? 8 : 24;
    for (bool isChain : {false, true}) {
        BeadChain chain(3 + numTorsions, 0);
        TorsionMonteCarloIntegrator integrator(300);
        integrator.setRandomNumberSeed(3);
        integrator.setTrialsPerStep(isChain ? 60 : 2);
        integrator.addDrawnMove(1, sets, densities);
        Context context(chain.system, integrator, platform);
        context.setPositions(chain.positions);
        RandomNumberGenerator random(11);
        vector<int> counts(pow(numCells, numTorsions), 0);
        vector<double> angles(numTorsions);
        for (int i = 0; i < numSamples; i++) {
            for (double& angle : angles)
                angle = random.drawSymmetric(M_PI);
            if (!isChain)
                integrator.setTorsionAngles(context, angles);
            integrator.step(1);
            integrator.getTorsionAngles(context, angles);
            counts[cellOf(angles, numCells)]++;
        }
        const Statistics trials(integrator, 0);
        ASSERT(trials.rejectedByEnergy > trials.attempted / 10 && trials.accepted > trials.attempted / 50);
        ASSERT(testEquallyLikely(counts) > LEAST_CHANCE);
    }
}

/**
 * With energy, torsions are as likely as it says, by drawn moves of two densities and torsion moves together.
 */
static void testEnergy(Platform& platform)
{
    BeadChain chain(4, 0);
    CustomTorsionForce* energy = new CustomTorsionForce("4*cos(theta-1)");
    energy->addTorsion(0, 1, 2, 3, vector<double>());
    chain.system.addForce(energy);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(5);
    integrator.addDrawnMove(1, {{0}}, {makePeaks()});
    integrator.addDrawnMove(1, {{0}}, {TorsionDensity::fromTable({4}, {1, 5, 2, 9})});
    integrator.addTorsionMove(0.5, 0.5);
    integrator.setTrialsPerStep(20);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    const int numSamples = 10000;
    double sums[4] = {0, 0, 0, 0}, expected[4] = {0, 0, 0, 0}, total = 0;
    vector<double> angles;
    auto addTo = [](double* sums, double angle, double weight) {
        sums[0] += weight * cos(angle);
        sums[1] += weight * sin(angle);
        sums[2] += weight * cos(2 * angle);
        sums[3] += weight * sin(2 * angle);
    };
    for (int i = 0; i < numSamples; i++) {
        integrator.step(1);
        integrator.getTorsionAngles(context, angles);
        addTo(sums, angles[0], 1.0 / numSamples);
    }
    for (int i = 0; i < 360; i++) {
        const double angle = i * M_PI / 180, weight = exp(-4 * cos(angle - 1) / THERMAL);
        addTo(expected, angle, weight);
        total += weight;
    }
    for (int i = 0; i < 4; i++) // five standard deviations of the mean of samples that are nearly independent
        ASSERT_EQUAL_TOL(expected[i] / total, sums[i], 5 * 0.75 / sqrt(numSamples));
}

/**
 * A trial draws one set, each equally often, and leaves the other torsions alone.
 */
static void testSets(Platform& platform)
{
    BeadChain chain(7, 0);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(7);
    integrator.setTrialsPerStep(1);
    integrator.addDrawnMove(1, {{3}, {2, 0}, {1}}, {makePeaks(), makeRidge(), makePeaks()});
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    vector<double> before, after;
    int drawn[3] = {0, 0, 0};
    const vector<double> starts = {2.5, -2, 0.7, 2.5};
    for (int i = 0; i < 6000; i++) {
        integrator.setTorsionAngles(context, starts);
        integrator.getTorsionAngles(context, before);
        integrator.step(1);
        integrator.getTorsionAngles(context, after);
        const bool changed[] = {fabs(before[0] - after[0]) > 1e-5, fabs(before[1] - after[1]) > 1e-5,
                                fabs(before[2] - after[2]) > 1e-5, fabs(before[3] - after[3]) > 1e-5};
        ASSERT_EQUAL(changed[0], changed[2]);
        ASSERT(changed[0] + changed[1] + changed[3] <= 1);
        drawn[0] += changed[3];
        drawn[1] += changed[0];
        drawn[2] += changed[1];
    }

    // Torsion 1 is as likely to be accepted as torsion 3, since both start where the floor is.

    const double share = Statistics(integrator, 0).accepted / 6000.0;
    ASSERT(drawn[0] > 50 && drawn[1] > 50 && share < 0.9);
    ASSERT_USUALLY_EQUAL_TOL(drawn[0] / 6000.0, drawn[2] / 6000.0, 0.02);
}

// ---- What is written ----

static void assertSameMoves(const TorsionMonteCarloIntegrator& expected, const TorsionMonteCarloIntegrator& found)
{
    double weight1, weight2;
    vector<vector<int>> torsions1, torsions2;
    vector<TorsionDensity> densities1, densities2;
    for (int move = 0; move < expected.getNumMoves(); move++) {
        expected.getDrawnMoveParameters(move, weight1, torsions1, densities1);
        found.getDrawnMoveParameters(move, weight2, torsions2, densities2);
        ASSERT_EQUAL(weight1, weight2);
        ASSERT(torsions1 == torsions2);
        for (size_t i = 0; i < torsions1.size(); i++) {
            auto& one = densities1[densities1.size() == 1 ? 0 : i];
            auto& two = densities2[densities2.size() == 1 ? 0 : i];
            ASSERT(one == two);
        }
    }
}

static void testWriting(Platform& platform)
{
    BeadChain chain(7, 0.1);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(9);
    const TorsionDensity ridge = makeRidge();
    integrator.addDrawnMove(1.0 / 3, {{3, 2}, {1, 0}, {0, 1}}, {ridge, makeRidge(), ridge});
    integrator.addDrawnMove(2, {{0}, {1, 2, 3}}, {makePeaks(1.0 / 7), makeSideChain()});
    ASSERT_EQUAL(TorsionMonteCarloIntegrator::DrawnMove, integrator.getMoveType(0));
    ASSERT_EQUAL("drawn torsions, 2 sets (weight 2, 4 torsions to choose from)", integrator.getMoveDescription(1));
    stringstream xml;
    XmlSerializer::serialize<Integrator>(&integrator, "Integrator", xml);

    // A density that several sets have is written once.

    const string text = xml.str();
    size_t count = 0;
    for (size_t found = text.find("<Density"); found != string::npos; found = text.find("<Density", found + 1))
        count++;
    ASSERT_EQUAL(3, count);
    unique_ptr<Integrator> read(XmlSerializer::deserialize<Integrator>(xml));
    auto& copy = dynamic_cast<TorsionMonteCarloIntegrator&>(*read);
    ASSERT_EQUAL(2, copy.getNumMoves());
    assertSameMoves(integrator, copy);

    // The copy continues from a checkpoint, bit for bit; one with another density refuses it.

    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    integrator.step(3);
    stringstream checkpoint;
    context.createCheckpoint(checkpoint);
    ASSERT(checkpoint.str().size() < 20000);
    Context copied(chain.system, copy, platform);
    copied.loadCheckpoint(checkpoint);
    integrator.step(5);
    copy.step(5);
    assertSameBits(getPositions(context), getPositions(copied));
    copy.setDrawnMoveParameters(1, 2, {{0}, {1, 2, 3}}, {makePeaks(0.1), makeSideChain()});
    assertThrows("the checkpoint is of other moves: move 1 has other densities in it than here", [&] {
        stringstream again(checkpoint.str());
        copied.loadCheckpoint(again);
    });
    copy.setDrawnMoveParameters(1, 2, {{0}, {1, 3, 2}}, {makePeaks(1.0 / 7), makeSideChain()});
    assertThrows("move 1 has torsions 0 1 2 3 in it, but 0 1 3 2 here", [&] {
        stringstream again(checkpoint.str());
        copied.loadCheckpoint(again);
    });
    auto readWith = [&](const string& was, const string& is) {
        string other = text;
        const size_t found = other.find(was);
        ASSERT(found != string::npos);
        stringstream stream(other.replace(found, was.size(), is));
        delete XmlSerializer::deserialize<Integrator>(stream);
    };
    assertThrows("the XML of a drawn move names density 3, but there are 1 densitys", [&] {
        readWith("<Set density=\"0\"", "<Set density=\"3\"");
    });
    assertThrows("the number of bins must be at least 1, but is -2", [&] {
        readWith("bins=\"12\"", "bins=\"-2\"");
    });
}

// ---- Bad input ----

static void testBadDensities()
{
    const double nan = numeric_limits<double>::quiet_NaN(), infinity = numeric_limits<double>::infinity();
    typedef TorsionDensity Density;
    auto assertTable = [](const string& message, const vector<int>& bins, const vector<double>& values, double floor) {
        assertThrows("TorsionDensity: " + message, [&] {
            Density::fromTable(bins, values, floor);
        });
    };
    assertTable("a density must be of 1 to 8 torsions, but is of 0", {}, {}, 0);
    assertTable("a density must be of 1 to 8 torsions, but is of 9", vector<int>(9, 1), {1}, 0);
    assertTable("the number of bins must be at least 1, but is 0", {3, 0}, {}, 0);
    assertTable("a table has too many bins", {65536, 65536}, {}, 0);
    assertTable("a table of 6 bins has 5 values", {3, 2}, {1, 2, 3, 4, 5}, 0);
    assertTable("a value is 0, so that torsions there would never move", {2}, {1, 0}, 0);
    assertTable("a value must be at least 0, but is -1", {2}, {1, -1}, 0.1);
    assertTable("a value must be at least 0, but is nan", {2}, {1, nan}, 0.1);
    assertTable("the sum of all values must be finite and above 0", {2}, {0, 0}, 0.1);
    assertTable("the sum of all values must be finite and above 0", {2}, {1, infinity}, 0.1);
    for (double bad : {-0.1, 1.1, nan})
        assertTable("the floor must be from 0 to 1, but is", {2}, {1, 1}, bad);
    auto assertRotamers = [](const string& message, const vector<double>& weights, const vector<double>& means,
                             const vector<double>& widths, double floor) {
        assertThrows("TorsionDensity: " + message, [&] {
            Density::fromRotamers(weights, means, widths, floor);
        });
    };
    assertRotamers("there must be at least one rotamer", {}, {}, {}, 0.1);
    assertRotamers("3 means cannot be divided among 2 rotamers", {1, 1}, {1, 1, 1}, {1, 1, 1}, 0.1);
    assertRotamers("a density must be of 1 to 8 torsions, but is of 0", {1, 1}, {}, {}, 0.1);
    assertRotamers("there are 2 means, but 1 widths", {1, 1}, {1, 1}, {1}, 0.1);
    assertRotamers("a weight must be at least 0, but is -1", {1, -1}, {1, 1}, {1, 1}, 0.1);
    assertRotamers("the sum of all weights must be finite and above 0", {0, 0}, {1, 1}, {1, 1}, 0.1);
    assertRotamers("a mean must be from -pi to pi radians, but is 60", {1}, {60}, {1}, 0.1);
    assertRotamers("a width must be above 0 and at most pi radians, but is 20", {1}, {1}, {20}, 0.1);
    assertRotamers("a width must be above 0", {1}, {1}, {0}, 0.1);
    assertRotamers("the floor must be above 0 and at most 1, but is nan", {1}, {1}, {1}, nan);
    assertRotamers("the floor of rotamers must be above 0", {1}, {1}, {1}, 0);
    vector<int> bins;
    vector<double> numbers;
    assertThrows("it is a sum of rotamers, not a table", [&] {
        makePeaks().getTable(bins, numbers);
    });
    assertThrows("it is a table, not a sum of rotamers", [&] {
        makeRidge().getRotamers(numbers, numbers, numbers);
    });
    assertThrows("it is of 2 torsions, but was given 1 angles", [&] {
        makeRidge().evaluate({1});
    });
    assertThrows("an angle is not finite", [&] {
        makePeaks().evaluate({nan});
    });
    ASSERT_EQUAL_TOL(makePeaks().evaluate({0.7}), makePeaks().evaluate({0.7 + 4 * M_PI}), 1e-12);
}

static void testBadMoves(Platform& platform)
{
    TorsionMonteCarloIntegrator integrator(300);
    const TorsionDensity peaks = makePeaks(), ridge = makeRidge();
    auto assertRefused = [&](const string& message, const vector<vector<int>>& torsions,
                             const vector<TorsionDensity>& densities) {
        assertThrows("TorsionMonteCarloIntegrator: " + message, [&] {
            integrator.addDrawnMove(1, torsions, densities);
        });
    };
    assertRefused("a drawn move must have at least one set of torsions", {}, {peaks});
    assertRefused("a drawn move must have one density, or one for each of its 3 sets of torsions, but has 2",
                  {{0}, {1}, {2}}, {peaks, peaks});
    assertRefused("a drawn move must have one density, or one for each of its 1 sets of torsions, but has 0", {{0}},
                  {});
    assertRefused("set 1 of a drawn move has 2 torsions, but its density is of 1", {{0}, {1, 2}}, {peaks});
    assertRefused("set 0 of a drawn move has 0 torsions, but its density is of 1", {{}}, {peaks});
    assertRefused("set 1 of a drawn move names torsion 2 twice", {{0, 1}, {2, 2}}, {ridge});
    assertThrows("the weight of a move must be", [&] {
        integrator.addDrawnMove(-1, {{0}}, {peaks});
    });
    integrator.addTorsionMove(1, 0.1);
    double weight;
    vector<vector<int>> torsions;
    vector<TorsionDensity> densities;
    assertThrows("move 0 is not a drawn move", [&] {
        integrator.getDrawnMoveParameters(0, weight, torsions, densities);
    });
    assertThrows("move 0 is not a drawn move", [&] {
        integrator.setDrawnMoveParameters(0, 1, {{0}}, {peaks});
    });
    BeadChain chain(6, 0);
    Context context(chain.system, integrator, platform);
    for (int bad : {-1, 3})
        assertThrows("move 1 names torsion " + to_string(bad) + ", but there are 3 torsions", [&] {
            integrator.addDrawnMove(1, {{0}, {bad}}, {peaks});
        });

    // A dihedral without a value cannot be drawn. What was sampled before stays.

    integrator.setTorsionMoveParameters(0, 0, 0.1);
    integrator.addDrawnMove(1, {{0}}, {peaks});
    context.setPositions(chain.positions);
    integrator.step(1);
    vector<Vec3> straight = chain.positions;
    for (int i = 0; i < 6; i++)
        straight[i] = Vec3(0.3 * i, 0, 0);
    context.setPositions(straight);
    assertThrows("torsion 0 has no value: the dihedral of particles 0, 1, 2 and 3 is undefined", [&] {
        integrator.step(1);
    });
    assertSameBits(straight, getPositions(context));
    context.setPositions(chain.positions);
    integrator.step(1);
    ASSERT_EQUAL(200, Statistics(integrator, 1).attempted);
}

int main()
{
    return runOnPlatform("Reference", [](Platform& platform) {
        testUniform(platform, 1, {{0}}, {makePeaks()});
        testUniform(platform, 2, {{1, 0}}, {makeRidge()});
        testUniform(platform, 3, {{0, 1, 2}}, {makeSideChain()});
        testUniform(platform, 3, {{0}, {2, 1}}, {makePeaks(), makeRidge()});
        testEnergy(platform);
        testSets(platform);
        testWriting(platform);
        testBadDensities();
        testBadMoves(platform);
    });
}
