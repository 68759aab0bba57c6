/**
 * This tests that no checkpoint or State in which a bit was flipped is loaded in silence, on one platform.
 */

#include "CheckpointSupport.h"
#include "openmm/CustomExternalForce.h"
#include "openmmchaintree/internal/Warnings.h"
#include <cstring>
#include <functional>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static int numWarnings = 0;

static void countWarning(const string&)
{
    numWarnings++;
}

static string flip(string bytes, size_t position, int bit)
{
    bytes[position] ^= 1 << bit;
    return bytes;
}

static string toWholeXml(const Context& context)
{
    return toXml(
        context.getState(State::Positions | State::Velocities | State::Parameters | State::IntegratorParameters));
}

/**
 * A run in the midst of its sampling, with velocities and a parameter.
 */
class DamagedRun {
public:
    DamagedRun(Platform& platform) : run(prepare(scene), 3, platform)
    {
        run.context->setPositions(scene.positions);
        run.context->setVelocities(scene.getTurnedPositions());
        run.integrator.step(3);
    }
    Scene scene;
    Run run;

private:
    static System& prepare(Scene& scene)
    {
        CustomExternalForce* field = new CustomExternalForce("strength*x");
        field->addGlobalParameter("strength", 0.25);
        field->addParticle(3);
        scene.system.addForce(field);
        return scene.system;
    }
};

static void testFlippedCheckpoints(Platform& platform)
{
    DamagedRun damaged(platform);
    Run& run = damaged.run;
    const string good = run.createCheckpoint();
    for (size_t i = 0; i < good.size(); i += 37) {
        const string bad = flip(good, i, i / 37 % 8);
        bool isRefused = false;
        try {
            run.loadCheckpoint(bad);
        }
        catch (const exception&) { // OpenMM itself may ask for too much memory
            isRefused = true;
        }
        ASSERT(isRefused);
    }

    // OpenMM has put names of parameters into the Context that never go away. All else is as good as before.

    Run fresh(damaged.scene.system, 1, platform);
    for (Run* each : {&run, &fresh}) {
        each->loadCheckpoint(good);
        each->integrator.step(2);
    }
    assertSameBits(getPositions(*run.context), getPositions(*fresh.context));
}

static void testFlippedStates(Platform& platform)
{
    DamagedRun damaged(platform);
    Run& run = damaged.run;
    const string before = toWholeXml(*run.context);
    run.context->setParameter("strength", 0.5);
    run.context->setVelocities(damaged.scene.positions);
    run.integrator.step(2);
    const string xml = toWholeXml(*run.context);
    setWarningHandler(countWarning);
    for (size_t i = 0; i < xml.size(); i += 61) {
        run.context->setState(fromXml(before));
        numWarnings = 0;
        try {
            const State state = fromXml(flip(xml, i, i / 61 % 8));
            if ((state.getDataTypes() & State::IntegratorParameters) == 0)
                continue; // OpenMM passes over parts whose names it does not know, so that we are not asked
            run.context->setState(state);
        }
        catch (const exception&) {
            continue;
        }
        ASSERT(toWholeXml(*run.context) == xml || numWarnings > 0);
    }
    numWarnings = 0;
    run.context->setState(fromXml(xml));
    ASSERT_EQUAL(0, numWarnings);
    ASSERT(toWholeXml(*run.context) == xml);
}

/**
 * Without checksums the geometry of links tells.
 */
static void testOldVersions(Platform& platform)
{
    DamagedRun damaged(platform);
    Run& run = damaged.run;
    string good = run.createCheckpoint(), xml = toWholeXml(*run.context);
    const size_t version = good.find("ChainTMC") + 8;
    good.erase(version + 4, 32); // sizes and checksums
    good[version] = 4;
    run.loadCheckpoint(good);
    const size_t parameters = xml.find("<IntegratorParameters");
    xml.replace(xml.find(NEWEST_VERSION, parameters), NEWEST_VERSION.size(), "version=\"3\"");
    run.context->setState(fromXml(xml));

    // A coordinate of particle 20 in the reference geometry, and where OpenMM keeps it.

    const vector<Vec3> present = getPositions(*run.context);
    auto countRefused = [](const function<void()>& load, const string& message, int& numRefused) {
        try {
            load();
        }
        catch (const OpenMMException& exception) {
            ASSERT(string(exception.what()).find(message) != string::npos);
            numRefused++;
        }
    };
    int numRefused = 0, numFound = 0;
    char bytes[sizeof(double)];
    const double x = present[20][0];
    memcpy(bytes, &x, sizeof(bytes));
    const string coordinate(bytes, sizeof(bytes));
    for (size_t i = good.find(coordinate); i != string::npos; i = good.find(coordinate, i + 1)) {
        numFound++;
        countRefused(
            [&] {
                run.loadCheckpoint(flip(good, i + 6, 3));
            },
            "the saved state is damaged: particle 20", numRefused);
    }
    ASSERT(numFound >= 2);
    ASSERT_EQUAL(numFound, numRefused);
    string digits;
    for (char byte : coordinate)
        for (int nibble : {(byte >> 4) & 15, byte & 15})
            digits += "0123456789abcdef"[nibble];
    size_t found = xml.find(digits);
    ASSERT(found != string::npos);
    xml[found + 13] = xml[found + 13] == '0' ? '8' : '0';
    assertThrows("the saved state is damaged: particle 20 is not where its link places it", [&] {
        run.context->setState(fromXml(xml));
    });
}

/**
 * A State of which the last part is bad replaces no part.
 */
static void testRefusedStateChangesNothing(Platform& platform)
{
    DamagedRun damaged(platform);
    Run& run = damaged.run;
    string xml = toXml(run.context->getState(State::IntegratorParameters));
    xml.replace(xml.find(NEWEST_VERSION, xml.find("<IntegratorParameters")), NEWEST_VERSION.size(), "version=\"3\"");
    xml.insert(xml.find("mean=\"") + 6, "x");
    run.integrator.step(2);
    const string before = getOwnPart(run.createCheckpoint());
    assertThrows("the State is damaged: mean is", [&] {
        run.context->setState(fromXml(xml));
    });
    ASSERT(before == getOwnPart(run.createCheckpoint()));
}

void testDamagedCheckpoints(Platform& platform)
{
    // On OpenCL, OpenMM keeps positions in other bytes, rounds away flips of last bits in States, and crashes if its
    // own part of a checkpoint is damaged.

    if (platform.getName() != "OpenCL") {
        testFlippedCheckpoints(platform);
        testFlippedStates(platform);
        testOldVersions(platform);
    }
    testRefusedStateChangesNothing(platform);
}
