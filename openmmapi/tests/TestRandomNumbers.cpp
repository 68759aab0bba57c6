/**
 * This tests that random numbers are those of std::mt19937_64, and that generators continue from what others have
 * written.
 */

#include "openmm/internal/AssertionUtilities.h"
#include "openmmchaintree/internal/RandomNumberGenerator.h"
#include <iostream>
#include <random>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static const uint64_t SEEDS[] = {0, 1, 5489, 0x123456789abcdef0, UINT64_MAX};

static void testNumbers()
{
    for (uint64_t seed : SEEDS) {
        mt19937_64 expected(seed);
        MersenneTwister found(seed);
        for (int i = 0; i < 5000; i++)
            ASSERT(expected() == found());
    }
}

/**
 * An index is a number modulo the count, but for the few numbers that would make some indices more likely.
 */
static void testIndices()
{
    for (int count : {1, 2, 7, 1000, (1 << 30) + 1, INT32_MAX}) {
        mt19937_64 expected(3);
        RandomNumberGenerator found(3);
        for (int i = 0; i < 2000; i++)
            ASSERT_EQUAL((int)(expected() % count), found.drawIndex(count));
    }
}

/**
 * A generator continues from what another one was at any place among its words.
 */
static void testStates()
{
    for (uint64_t seed : SEEDS) {
        RandomNumberGenerator first(seed);
        for (int i = 0; i < 700; i++) {
            RandomNumberGenerator second(99);
            ASSERT(second.setState(first.getState()));
            ASSERT(first.getState() == second.getState());
            for (int j = 0; j < (i % 50 == 0 ? 400 : 1); j++)
                ASSERT(first.drawUniform() == second.drawUniform());
        }
    }
}

static void testBadStates()
{
    RandomNumberGenerator random(1);
    const string state = random.getState();
    const string bad[] = {"",
                          "1 2 3",
                          state.substr(0, state.rfind(' ')),
                          state.substr(0, state.rfind(' ')) + " 313",
                          state.substr(0, state.rfind(' ')) + " -1",
                          "x" + state};
    for (const string& text : bad) {
        ASSERT(!random.setState(text));
        ASSERT(random.getState() == state);
    }
}

#ifdef __GLIBCXX__

/**
 * Checkpoints and States of earlier versions hold what GCC's library writes.
 */
static void testFormerStates()
{
    mt19937_64 former(7);
    for (int i = 0; i < 700; i++) {
        stringstream text;
        text << former;
        RandomNumberGenerator random(1);
        ASSERT(random.setState(text.str()));
        ASSERT(random.getState() == text.str());
        ASSERT((former() >> 11) * 0x1p-53 == random.drawUniform());
    }
}

#endif

int main()
{
    try {
        testNumbers();
        testIndices();
        testStates();
        testBadStates();
#ifdef __GLIBCXX__
        testFormerStates();
#endif
    }
    catch (const exception& e) {
        cout << "exception: " << e.what() << endl;
        return 1;
    }
    cout << "Done" << endl;
    return 0;
}
