/**
 * This tests which foreign energies are left to outer tests and after how many trials, by what the first tests find.
 */

#include "openmm/internal/AssertionUtilities.h"
#include "openmmchaintree/internal/OuterSchedule.h"
#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <limits>
#include <random>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/** Draws by how much some trials change each energy, in kT. */
typedef function<vector<double>(int trials)> Changes;

/**
 * A normal distribution of differences as outer tests have it: its mean is half of its variance.
 */
class NormalChange {
public:
    /**
     * @param perTrial  the standard deviation of one trial
     * @param seed      of the random numbers
     */
    explicit NormalChange(double perTrial, int seed = 1) : perTrial(perTrial), random(seed)
    {
    }
    double operator()(int trials)
    {
        const double deviation = perTrial * sqrt(trials);
        return normal_distribution<double>(deviation * deviation / 2, deviation)(random);
    }

private:
    double perTrial;
    mt19937 random;
};

static void addTests(OuterSchedule& schedule, const Changes& draw, int numTests, double unseen = 0)
{
    for (int i = 0; i < numTests; i++) {
        const vector<double> changes = draw(schedule.getTrialsPerTest());
        double sum = unseen;
        for (size_t j = 0; j < changes.size(); j++)
            sum += schedule.isLeft(j) ? changes[j] : 0;
        schedule.add(changes, sum);
    }
}

/**
 * Measure until all is chosen. Returns the number of tests.
 */
static int choose(OuterSchedule& schedule, int numEnergies, int longest, const Changes& draw)
{
    vector<int> energies(numEnergies);
    for (int i = 0; i < numEnergies; i++)
        energies[i] = 3 * i + 1;
    int numTests = 0;
    schedule.begin(energies, longest);
    while (schedule.isMeasuring()) {
        addTests(schedule, draw, 4);
        numTests += 4;
        ASSERT(numTests < 1000);
        schedule.begin(energies, longest);
    }
    return numTests;
}

static void testNumbersOfTrials()
{
    // At a deviation of 1.35 kT half of the tests keep their trials. The chosen number of trials is the last one tried
    // below that, or a neighbour of it: 20 tests know their acceptance within a tenth.

    for (auto& each :
         vector<pair<double, int>>{{0, 400}, {0.04, 400}, {0.08, 200}, {0.115, 100}, {0.16, 50}, {0.23, 25}}) {
        vector<int> chosen;
        for (int seed = 1; seed <= 41; seed++) {
            OuterSchedule schedule;
            NormalChange change(each.first, seed);
            const int numTests = choose(schedule, 1, 400, [&](int trials) {
                return vector<double>{change(trials)};
            });
            ASSERT(numTests <= 120);
            chosen.push_back(schedule.isLeft(0) ? schedule.getTrialsPerTest() : 0);
        }
        sort(chosen.begin(), chosen.end());
        const int median = chosen[chosen.size() / 2];
        ASSERT(median >= each.second / 2 && median <= 2 * each.second);
        if (each.first <= 0.04)
            ASSERT_EQUAL(400, median);
    }

    // The last number of trials that was good, exactly, where chance has no part.

    for (int good : {12, 25, 50, 100, 200, 400}) {
        OuterSchedule schedule;
        choose(schedule, 1, 400, [good](int trials) {
            return vector<double>{trials <= good ? 0.1 : 9.0};
        });
        ASSERT(schedule.isLeft(0));
        ASSERT_EQUAL(good, schedule.getTrialsPerTest());
    }

    // No more trials than there are in a step, however few these are.

    for (auto& each : vector<pair<int, int>>{{1, 1}, {5, 1}, {12, 1}, {30, 3}, {100, 4}}) {
        OuterSchedule schedule;
        const int numTests = choose(schedule, 1, each.first, [](int trials) {
            return vector<double>{0.001 * trials};
        });
        ASSERT(schedule.isLeft(0));
        ASSERT_EQUAL(each.first, schedule.getTrialsPerTest());
        ASSERT_EQUAL(20 * each.second, numTests);
    }
}

static void testLargeChanges()
{
    // Forces that change too much, always change in one direction, or give no number are decided in each trial.

    for (double change : {numeric_limits<double>::quiet_NaN(), numeric_limits<double>::infinity(),
                          -numeric_limits<double>::infinity(), 1e300, 5.0, -5.0}) {
        OuterSchedule schedule;
        const int numTests = choose(schedule, 1, 400, [change](int) {
            return vector<double>{change};
        });
        ASSERT(!schedule.isLeft(0));
        ASSERT_EQUAL(20, numTests);
    }

    // One of them is no reason for the others, if it is known which; nor is what tests decide about besides.

    NormalChange small(0.1, 1), large(3, 2), other(0.1, 3);
    OuterSchedule schedule;
    choose(schedule, 3, 400, [&](int trials) {
        return vector<double>{small(trials), large(trials), other(trials)};
    });
    ASSERT(schedule.isLeft(0) && !schedule.isLeft(1) && schedule.isLeft(2));
    ASSERT(schedule.getTrialsPerTest() >= 25 && schedule.getTrialsPerTest() <= 200);
    OuterSchedule besides;
    besides.begin({7}, 400);
    for (int i = 0; i < 20; i++)
        besides.add({0}, i % 3 == 0 ? -10 : 10);
    besides.begin({7}, 400);
    ASSERT(!besides.isLeft(0) && !besides.isMeasuring());
}

static void testFixed()
{
    NormalChange change(0.12);
    const Changes draw = [&](int trials) {
        return vector<double>{change(trials)};
    };
    OuterSchedule schedule;
    choose(schedule, 1, 400, draw);
    const int chosen = schedule.getTrialsPerTest();
    ASSERT(chosen > 12);
    schedule.begin({1}, 400);
    ASSERT(!schedule.isMeasuring());
    ASSERT_EQUAL(chosen, schedule.getTrialsPerTest());

    // Other energies are measured, and the same on request.

    schedule.begin({2}, 400);
    ASSERT(schedule.isMeasuring() && schedule.getTrialsPerTest() == 12);
    choose(schedule, 1, 400, draw);
    schedule.restart();
    schedule.begin({1}, 400);
    ASSERT(schedule.isMeasuring() && schedule.getTrialsPerTest() == 12);
    OuterSchedule none;
    none.begin({}, 400);
    ASSERT(!none.isMeasuring());
    ASSERT_EQUAL(0, none.getNumbers().size());
}

static void testNumbers()
{
    // A copy that is made at any time goes the same way.

    for (int numTests : {0, 1, 20, 37, 90, 130}) {
        NormalChange first(0.12, 4), second(0.12, 4);
        OuterSchedule schedule, copy;
        schedule.begin({1}, 400);
        for (int i = 0; i < numTests; i++) {
            schedule.begin({1}, 400);
            if (schedule.isMeasuring())
                addTests(
                    schedule,
                    [&](int trials) {
                        return vector<double>{first(trials) + 0 * second(trials)};
                    },
                    1);
        }
        copy.setNumbers(schedule.getNumbers());
        ASSERT(schedule.getNumbers() == copy.getNumbers());
        auto draw = [](NormalChange& change) {
            return [&change](int trials) {
                return vector<double>{change(trials)};
            };
        };
        choose(schedule, 1, 400, draw(first));
        choose(copy, 1, 400, draw(second));
        ASSERT(schedule.getNumbers() == copy.getNumbers());
    }

    // Numbers of something else.

    OuterSchedule schedule;
    schedule.begin({1, 4}, 400);
    vector<double> numbers = schedule.getNumbers();
    auto assertUnusable = [&](vector<double> damaged) {
        OuterSchedule other;
        other.setNumbers(damaged);
        ASSERT(!other.isMeasuring() && other.getNumbers().empty());
        other.begin({1, 4}, 400);
        ASSERT(other.isMeasuring() && other.getTrialsPerTest() == 12);
    };
    assertUnusable({});
    assertUnusable({1, 2, 3});
    assertUnusable(vector<double>(numbers.begin(), numbers.end() - 1));
    for (int i : {1, 2, 3, 4})
        for (double bad : {-1.0, 1e30, numeric_limits<double>::quiet_NaN()}) {
            vector<double> damaged = numbers;
            damaged[i] = bad;
            assertUnusable(damaged);
        }
}

int main()
{
    try {
        testNumbersOfTrials();
        testLargeChanges();
        testFixed();
        testNumbers();
    }
    catch (const exception& e) {
        cout << "exception: " << e.what() << endl;
        return 1;
    }
    cout << "Done" << endl;
    return 0;
}
