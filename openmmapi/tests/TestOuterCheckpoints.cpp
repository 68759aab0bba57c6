/**
 * This tests that what outer tests have found, and where they left off, is in checkpoints and States.
 */

#include "OuterTestSupport.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static const int NUM_STEPS = 8;

/**
 * A foreign energy of which tests refuse many trials.
 */
static double spring(const vector<Vec3>& x)
{
    return 0.8 * (x[0] - x[11]).dot(x[0] - x[11]) + 0.5 * (x[4] - x[18]).dot(x[4] - x[18]);
}

static Tests getTests(const OuterRun& run)
{
    return Tests(run.integrator);
}

static void assertSameTests(const OuterRun& expected, const OuterRun& found)
{
    const Tests a = getTests(expected), b = getTests(found);
    ASSERT_EQUAL(a.attempted, b.attempted);
    ASSERT_EQUAL(a.accepted, b.accepted);
    ASSERT_EQUAL(a.trialsTakenBack, b.trialsTakenBack);
    ASSERT_EQUAL(a.mean, b.mean);
    ASSERT_EQUAL(a.deviation, b.deviation);
}

/**
 * A run interrupted after any step continues with the same bits, whether steps end with a whole block of trials or
 * with a part of one.
 */
static void testGoingOn(Platform& platform, int trialsPerTest)
{
    OuterScene scene;
    scene.say = spring;
    OuterRun whole(scene, platform, trialsPerTest);
    whole.context->setPositions(scene.positions);
    vector<string> checkpoints;
    vector<State> states;
    for (int i = 0; i < NUM_STEPS; i++) {
        checkpoints.push_back(whole.createCheckpoint());
        states.push_back(writeAndRead(*whole.context));
        whole.integrator.step(1);
    }
    const string end = getOwnPart(whole.createCheckpoint());
    const vector<Vec3> positions = getPositions(*whole.context);
    const Tests tests = getTests(whole);
    ASSERT(tests.accepted > 1 && tests.trialsTakenBack > trialsPerTest && tests.deviation > 0);
    for (int i = 0; i < NUM_STEPS; i++)
        for (bool fromState : {false, true}) {
            OuterRun fresh(scene, platform, trialsPerTest, 99);
            if (fromState)
                fresh.context->setState(states[i]);
            else
                fresh.loadCheckpoint(checkpoints[i]);
            fresh.integrator.step(NUM_STEPS - i);
            assertSameBits(positions, getPositions(*fresh.context));
            assertSameTests(whole, fresh);
            ASSERT(end == getOwnPart(fresh.createCheckpoint()));
        }
}

static void testReinitialize(Platform& platform)
{
    OuterScene scene;
    scene.say = spring;
    OuterRun whole(scene, platform, 10), broken(scene, platform, 10);
    for (OuterRun* run : {&whole, &broken}) {
        run->context->setPositions(scene.positions);
        run->integrator.step(4);
    }
    whole.createCheckpoint();
    broken.context->reinitialize(true);
    assertSameTests(whole, broken);

    // One that is refused keeps the counts, too.

    scene.system.addConstraint(0, 11, 1);
    assertThrows("constraint", [&] {
        broken.context->reinitialize(true);
    });
    scene.system.removeConstraint(0);
    broken.context->reinitialize(true);
    for (OuterRun* run : {&whole, &broken})
        run->integrator.step(4);
    assertSameTests(whole, broken);
    assertSameBits(getPositions(*whole.context), getPositions(*broken.context));
}

/**
 * The counts come with those of the moves, or not at all.
 */
static void testStatesThatDoNotFit(Platform& platform)
{
    OuterScene scene;
    scene.say = spring;
    OuterRun run(scene, platform, 10), others(scene, platform, 10), older(scene, platform, 10);
    run.context->setPositions(scene.positions);
    run.integrator.step(4);
    others.integrator.setTorsionMoveParameters(0, 3, 0.2);
    others.context->setState(writeAndRead(*run.context));
    ASSERT_EQUAL(0, getTests(others).attempted);

    // Version 2 knew no outer tests.

    const string xml = toXml(writeAndRead(*run.context));
    string old = xml;
    const size_t parameters = old.find("<IntegratorParameters");
    old.replace(old.find(NEWEST_VERSION, parameters), NEWEST_VERSION.size(), "version=\"2\"");
    const size_t tests = old.find("<OuterTests", parameters), limits = old.find("<Limits", parameters);
    ASSERT(tests < limits && limits != string::npos);
    older.context->setState(fromXml(old.erase(tests, limits - tests)));
    ASSERT_EQUAL(0, getTests(older).attempted);
    ASSERT_EQUAL(Statistics(run.integrator, 0).accepted, Statistics(older.integrator, 0).accepted);
    for (OuterRun* each : {&run, &older})
        each->integrator.step(2);
    assertSameBits(getPositions(*run.context), getPositions(*older.context));

    string damaged = xml;
    damaged.insert(damaged.find("<StandIn data=\"") + 15, "x");
    assertThrows("the State is damaged", [&] {
        run.context->setState(fromXml(damaged));
    });
}

int main()
{
    return runOnPlatform("Reference", [](Platform& platform) {
        for (int trialsPerTest : {0, 1, 10, 17, 50})
            testGoingOn(platform, trialsPerTest);
        testReinitialize(platform);
        testStatesThatDoNotFit(platform);
    });
}
