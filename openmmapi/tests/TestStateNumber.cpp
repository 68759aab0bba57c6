/**
 * This tests the numbers of States: against OpenMM's, both ways.
 */

#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/StateNumber.h"
#include "TestSupport.h"
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static void assertSameBits(double expected, double found)
{
    ASSERT(memcmp(&expected, &found, sizeof expected) == 0 || (isnan(expected) && isnan(found)));
}

static void testNumber(double value)
{
    SerializationNode ours, theirs;
    setNumber(ours, "x", value);
    theirs.setDoubleProperty("x", value);
    assertSameBits(value, getNumber(ours, "x"));
    assertSameBits(value, getNumber(theirs, "x"));
    assertSameBits(value, ours.getDoubleProperty("x"));
}

void testNumbers()
{
    typedef numeric_limits<double> Limits;
    for (double value : {0.0, -0.0, 1.0, 0.5, 0.1, 1e-5, -2.0 / 3, 1e22, Limits::max(), Limits::min(),
                         Limits::denorm_min(), Limits::infinity(), -Limits::infinity(), Limits::quiet_NaN()})
        testNumber(value);
    mt19937_64 random(1);
    for (int i = 0; i < 1000; i++) {
        const unsigned long long bits = random();
        double value;
        memcpy(&value, &bits, sizeof value);
        testNumber(value);
    }
}

void testDamage()
{
    for (const string damaged : {"", "1.5x", "nonsense", "1 2"}) {
        SerializationNode node;
        node.setStringProperty("overlap", damaged);
        try {
            getNumber(node, "overlap");
        }
        catch (const OpenMMException& exception) {
            ASSERT(string(exception.what()).find("overlap is \"" + damaged + "\"") != string::npos);
            continue;
        }
        throwException(__FILE__, __LINE__, "nothing was thrown for " + damaged);
    }
}

int main()
{
    return runOnPlatform("Reference", [](Platform&) {
        testNumbers();
        testDamage();
    });
}
