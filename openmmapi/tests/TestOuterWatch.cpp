/**
 * This tests when the integrator warns that what trials see is too far from U.
 */

#include "openmm/internal/AssertionUtilities.h"
#include "openmmchaintree/internal/OuterWatch.h"
#include "openmmchaintree/internal/Warnings.h"
#include <functional>
#include <iostream>
#include <limits>
#include <random>
#include <string>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static int numWarnings = 0;
static string lastWarning;

static void keepWarning(const string& message)
{
    numWarnings++;
    lastWarning = message;
}

/**
 * Get how many warnings there are after some changes, judged after every tenth.
 */
static int countWarnings(OuterWatch& watch, int numChanges, const function<double(int)>& change)
{
    numWarnings = 0;
    for (int i = 0; i < numChanges; i++) {
        watch.add(change(i));
        if (i % 10 == 9)
            watch.judge();
    }
    return numWarnings;
}

static int countWarnings(int numChanges, const function<double(int)>& change)
{
    OuterWatch watch;
    return countWarnings(watch, numChanges, change);
}

static void testSpreads()
{
    mt19937 random(1);
    for (double deviation : {0.1, 0.5, 1.0, 1.5, 3.0, 5.0, 30.0}) {
        normal_distribution<double> draw(deviation * deviation / 2, deviation);
        auto change = [&](int) {
            return draw(random);
        };
        ASSERT_EQUAL(deviation > 2 ? 1 : 0, countWarnings(2000, change));
        ASSERT_EQUAL(0, countWarnings(99, change));
    }
}

static void testOtherChanges()
{
    // A chain that sits where all that it proposes is worse by the same, and one that few of its trials lead away from.

    ASSERT_EQUAL(1, countWarnings(100, [](int) {
                     return 20.0;
                 }));
    ASSERT(lastWarning.find(" 0 % ") != string::npos);
    ASSERT_EQUAL(1, countWarnings(100, [](int i) {
                     return i % 4 == 0 ? 11.0 : 0.01;
                 }));
    ASSERT(lastWarning.find(" 4.8 kT") != string::npos && lastWarning.find(" 74 % ") != string::npos);
    ASSERT_EQUAL(1, countWarnings(100, [](int i) {
                     return i % 4 != 0 ? numeric_limits<double>::infinity() : 0.01;
                 }));

    ASSERT_EQUAL(1, countWarnings(400, [](int i) {
                     return i % 4 == 0 ? 1.5 : 0.0;
                 }));

    // Tests that tell nothing, and impossible states that a few trials lead to.

    ASSERT_EQUAL(0, countWarnings(1000, [](int) {
                     return 0.0;
                 }));
    ASSERT_EQUAL(0, countWarnings(1000, [](int i) {
                     return i % 4 == 0 ? numeric_limits<double>::infinity() : 0.01;
                 }));
}

static void testRestart()
{
    OuterWatch watch;
    auto large = [](int) {
        return 20.0;
    };
    ASSERT_EQUAL(0, countWarnings(watch, 90, large));
    watch.restart();
    ASSERT_EQUAL(0, countWarnings(watch, 90, large));
    ASSERT_EQUAL(1, countWarnings(watch, 10, large));
    ASSERT_EQUAL(0, countWarnings(watch, 1000, large));
}

int main()
{
    try {
        setWarningHandler(keepWarning);
        testSpreads();
        testOtherChanges();
        testRestart();
    }
    catch (const exception& e) {
        cout << "exception: " << e.what() << endl;
        return 1;
    }
    cout << "Done" << endl;
    return 0;
}
