/**
 * This tests what an outer test does: how often it asks, what it keeps, and that what it takes back leaves no trace.
 */

#include "OuterTestSupport.h"
#include <limits>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

// ---- How often ----

static void testCounts(Platform& platform)
{
    // One evaluation at the beginning of a step and one a test, of which the last may come early.

    for (auto& each : map<int, int>{{1, 50}, {7, 8}, {25, 2}, {50, 1}, {400, 1}}) {
        OuterScene scene;
        OuterRun run(scene, platform, each.first);
        run.context->setPositions(scene.positions);
        run.integrator.step(1);
        scene.numEvaluations = 0;
        run.integrator.resetMoveStatistics();
        run.integrator.step(3);
        Tests tests(run.integrator);
        ASSERT_EQUAL(3 * each.second, tests.attempted);
        ASSERT_EQUAL(tests.attempted, tests.accepted);
        ASSERT_EQUAL(0, tests.trialsTakenBack);
        ASSERT_EQUAL(0, tests.mean);
        ASSERT_EQUAL(0, tests.deviation);
        ASSERT_EQUAL(150, run.sumMoves(&Statistics::attempted));
        const long long accepted = run.sumMoves(&Statistics::accepted);
        ASSERT(accepted > 5 && accepted < 145);

        // A test before which nothing was accepted asks nothing.

        if (each.first == 1)
            ASSERT_EQUAL(3 + accepted, scene.numEvaluations);
        if (each.first >= 25)
            ASSERT_EQUAL(3 + tests.attempted, scene.numEvaluations);
        run.integrator.resetMoveStatistics();
        ASSERT_EQUAL(0, Tests(run.integrator).attempted);
        ASSERT_EQUAL(0, Tests(run.integrator).accepted);
    }

    // One a step and one for each trial that comes so far, where it changes too much.

    OuterScene scene;
    scene.say = [](const vector<Vec3>& x) {
        return 1000 * sin(1000 * x[11][0]);
    };
    OuterRun run(scene, platform, 0);
    run.context->setPositions(scene.positions);
    run.integrator.step(6);
    const long long former = Tests(run.integrator).attempted;
    ASSERT_EQUAL(5 * 5, former);
    auto stages = run.integrator.getStageStatistics();
    ASSERT_EQUAL("foreign forces", stages.back().stage);
    ASSERT(stages.back().computed > 5);
    scene.numEvaluations = 0;
    run.integrator.step(1);
    ASSERT_EQUAL(run.integrator.getStageStatistics().back().computed - stages.back().computed + 1,
                 scene.numEvaluations);
    ASSERT_EQUAL(former, Tests(run.integrator).attempted);
}

static void testNothingToTest(Platform& platform)
{
    // Without foreign Forces there is no test, and the trajectory is that of any other setting.

    vector<Vec3> positions;
    for (int trials : {0, 1, 20}) {
        Scene scene;
        Run run(scene.system, 5, platform);
        run.integrator.setTrialsPerOuterTest(trials);
        run.context->setPositions(scene.positions);
        run.integrator.step(5);
        ASSERT_EQUAL(0, Tests(run.integrator).attempted);
        if (positions.empty())
            positions = getPositions(*run.context);
        assertSameBits(positions, getPositions(*run.context));
    }
    TorsionMonteCarloIntegrator integrator(300);
    ASSERT_EQUAL(0, integrator.getTrialsPerOuterTest());
    assertThrows("the number of trials to an outer test must be at least 0, but is -1", [&] {
        integrator.setTrialsPerOuterTest(-1);
    });
}

// ---- What is kept ----

static string getLimits(const Run& run)
{
    const string xml = toXml(run.context->getState(State::IntegratorParameters));
    const size_t begin = xml.find("<Limits");
    return xml.substr(begin, xml.find("<Context", begin) - begin);
}

static string getGeometry(const Run& run)
{
    const string xml = toXml(run.context->getState(State::IntegratorParameters));
    const size_t begin = xml.find("<Geometry");
    return xml.substr(begin, xml.find("/>", begin) - begin);
}

/**
 * A force that forbids everything but where the run stands: steps leave no trace but in the counts of tests.
 */
static void testTakenBack(Platform& platform, bool isNative, bool isSoft)
{
    OuterScene scene;
    OuterRun run(scene, platform, 10);
    run.integrator.setNativeEnergies(isNative);
    run.integrator.setStericMode(isSoft ? TorsionMonteCarloIntegrator::Soft : TorsionMonteCarloIntegrator::Hard);
    run.context->setPositions(scene.positions);
    run.integrator.step(20);
    const vector<Vec3> start = getPositions(*run.context);
    const string limits = getLimits(run), geometry = getGeometry(run);
    const double energy = run.integrator.getPotentialEnergy(*run.context);
    const Tests former(run.integrator);
    ASSERT(isNative == (former.accepted == former.attempted) && isSoft == (run.getNumToleratedClashes() == 0));
    auto getCounts = [&] {
        vector<long long> counts;
        for (int i = 0; i < run.integrator.getNumMoves(); i++) {
            Statistics statistics(run.integrator, i);
            counts.insert(counts.end(), {statistics.clashed, statistics.rejectedByEnergy, statistics.accepted});
        }
        for (auto& stage : run.integrator.getStageStatistics())
            counts.insert(counts.end(), {stage.computed, stage.refused});
        return counts;
    };
    const vector<long long> counts = getCounts();
    for (double forbidding : {1e9, numeric_limits<double>::infinity(), numeric_limits<double>::quiet_NaN(),
                              -numeric_limits<double>::infinity()}) {
        bool wasElsewhere = false;
        scene.say = [&](const vector<Vec3>& x) {
            for (size_t i = 0; i < x.size(); i++)
                for (int j = 0; j < 3; j++)
                    if (fabs(x[i][j] - start[i][j]) > 1e-5) {
                        wasElsewhere = true;
                        return forbidding;
                    }
            return 0.0;
        };
        run.integrator.step(4);
        ASSERT(wasElsewhere);
        assertSameBits(start, getPositions(*run.context));
        ASSERT_EQUAL(energy, run.integrator.getPotentialEnergy(*run.context));
        ASSERT_EQUAL(limits, getLimits(run));
        ASSERT_EQUAL(geometry, getGeometry(run));
    }
    Tests tests(run.integrator);
    const long long numTests = tests.attempted - former.attempted, numKept = tests.accepted - former.accepted;
    ASSERT_EQUAL(4 * 4 * 5, numTests);
    ASSERT_EQUAL(10 * (numTests - numKept), tests.trialsTakenBack - former.trialsTakenBack);
    ASSERT(numTests - numKept > 20);

    // Trials of tests before which nothing was accepted count.

    vector<long long> more = getCounts();
    long long attempted = 0;
    for (int i = 0; i < 9; i++)
        attempted += more[i] - counts[i];
    ASSERT_EQUAL(10 * numKept, attempted);
    for (int move = 0; move < 3; move++)
        ASSERT_EQUAL(counts[3 * move + 2], more[3 * move + 2]);
    const long long numFree = run.sumMoves(&Statistics::attempted) - run.sumMoves(&Statistics::clashed);
    ASSERT_EQUAL(isNative ? numFree : 0, run.integrator.getStageStatistics()[0].computed);
    scene.say = [](const vector<Vec3>&) {
        return 0.0;
    };
    run.integrator.step(1);
    ASSERT(getPositions(*run.context)[5] != start[5] || getPositions(*run.context)[10] != start[10]);
}

static void testStatistics(Platform& platform)
{
    // Tests of one trial each, of which every other is forbidden.

    OuterScene scene;
    OuterRun run(scene, platform, 1);
    run.integrator.setTrialsPerStep(1);
    run.context->setPositions(scene.positions);
    double said = 0, sum = 0, squares = 0;
    int numSaid = 0;
    scene.say = [&](const vector<Vec3>&) {
        return said;
    };
    long long kept = 0, takenBack = 0, numNothing = 0;
    for (int i = 0; i < 400; i++) {
        // Two evaluations a step: the first is of the start.

        const double change = i % 2 == 0 ? -1.0 - i : 1e6;
        int number = 0;
        scene.say = [&](const vector<Vec3>&) {
            return number++ == 0 ? 0.0 : change;
        };
        run.integrator.step(1);
        if (number < 2)
            numNothing++;
        else {
            (i % 2 == 0 ? kept : takenBack)++;
            numSaid++;
            sum += change;
            squares += change * change;
        }
    }
    Tests tests(run.integrator);
    ASSERT_EQUAL(400, tests.attempted);
    ASSERT_EQUAL(numNothing + kept, tests.accepted);
    ASSERT_EQUAL(takenBack, tests.trialsTakenBack);
    ASSERT(kept > 20 && takenBack > 20 && numNothing > 20);
    ASSERT_EQUAL(kept, run.sumMoves(&Statistics::accepted));
    ASSERT_EQUAL(400 - takenBack, run.sumMoves(&Statistics::attempted));
    ASSERT_EQUAL_TOL(sum / numSaid, tests.mean, 1e-9);
    ASSERT_EQUAL_TOL(sqrt((squares - sum * sum / numSaid) / (numSaid - 1)), tests.deviation, 1e-9);
}

// ---- Bad energies ----

static void testBadStart(Platform& platform)
{
    OuterScene scene;
    OuterRun run(scene, platform, 10);
    run.context->setPositions(scene.positions);
    const double infinity = numeric_limits<double>::infinity();
    for (double bad : {-infinity, numeric_limits<double>::quiet_NaN()}) {
        scene.say = [bad](const vector<Vec3>&) {
            return bad;
        };
        assertThrows("the energy of the integration force groups is not a number", [&] {
            run.integrator.step(1);
        });
        ASSERT_EQUAL(0, run.context->getStepCount());
        assertSameBits(scene.positions, getPositions(*run.context));
    }

    // From plus infinity anything leads out, and nothing back.

    scene.say = [&](const vector<Vec3>& x) {
        return x[18][2] > scene.positions[18][2] - 0.5 ? infinity : 0;
    };
    for (int i = 0; i < 1000 && scene.say(getPositions(*run.context)) > 0; i++)
        run.integrator.step(1);
    for (int i = 0; i < 50; i++) {
        run.integrator.step(1);
        ASSERT_EQUAL(0, scene.say(getPositions(*run.context)));
    }
    ASSERT(isfinite(Tests(run.integrator).mean));
}

static void testThrowingForce(Platform& platform)
{
    // A test that cannot be made leaves the Context where the last one has led, and the counts as well.

    OuterScene scene;
    OuterRun run(scene, platform, 10);
    run.integrator.setStericMode(TorsionMonteCarloIntegrator::Hard);
    run.context->setPositions(scene.positions);
    run.integrator.step(3);
    for (int failing : {2, 1, 0}) {
        vector<Vec3> last = getPositions(*run.context);
        const long long former = run.sumMoves(&Statistics::attempted);
        int number = 0;
        scene.say = [&](const vector<Vec3>& x) {
            if (number++ == failing)
                throw OpenMMException("out of order");
            last = x;
            return 0.0;
        };
        const long long tests = Tests(run.integrator).attempted;
        assertThrows("out of order", [&] {
            run.integrator.step(1);
        });
        assertSameBits(last, getPositions(*run.context));
        ASSERT_EQUAL(10 * (Tests(run.integrator).attempted - tests), run.sumMoves(&Statistics::attempted) - former);
        ASSERT_EQUAL(3, run.context->getStepCount());
    }
    scene.say = [](const vector<Vec3>&) {
        return 0.0;
    };
    run.integrator.step(1);
    ASSERT(!scene.force->hasClash(*run.context) || run.getNumToleratedClashes() > 0);
}

// ---- Zero temperature ----

static void testZeroTemperature(Platform& platform)
{
    // U never goes up: not the sum of what trials and tests see. A part that goes up is made good by the other.

    for (bool isSoft : {false, true}) {
        OuterScene scene;
        scene.say = [](const vector<Vec3>& x) {
            return 30 * (x[0] - x[11]).dot(x[0] - x[11]);
        };
        OuterRun run(scene, platform, 5);
        run.integrator.setTemperature(0);
        run.integrator.setTrialsPerStep(5);
        if (isSoft)
            run.integrator.setStericMode(TorsionMonteCarloIntegrator::Soft);
        run.context->setPositions(scene.positions);
        double before = run.integrator.getPotentialEnergy(*run.context);
        double foreign = scene.say(scene.positions);
        int numForeignUp = 0;
        for (int i = 0; i < 600; i++) {
            run.integrator.step(1);
            const double after = run.integrator.getPotentialEnergy(*run.context);
            ASSERT(after <= before + 1e-6 * fabs(before));
            before = after;
            const double now = scene.say(getPositions(*run.context));
            numForeignUp += now > foreign;
            foreign = now;
        }
        Tests tests(run.integrator);
        ASSERT(numForeignUp > 0);
        ASSERT(tests.trialsTakenBack > 0 && tests.accepted > 0);
    }
}

/**
 * What soft spheres gain makes good what the foreign energy loses.
 */
static void testSoftSpheresAtZeroTemperature(Platform& platform)
{
    BeadChain chain(20, 0.7, 0.6);
    Probe* probe = new Probe();
    int numEvaluations = 0;
    probe->energy = [&](const vector<Vec3>&) {
        return 1e-3 * numEvaluations++;
    };
    probe->setForceGroup(1);
    chain.system.addForce(probe);
    Run run(chain.system, 1, platform);
    run.integrator.setTemperature(0);
    run.integrator.setTrialsPerOuterTest(5);
    run.integrator.setStericMode(TorsionMonteCarloIntegrator::Soft);
    run.context->setPositions(chain.positions);
    const double start = run.context->getState(State::Energy, false, 1).getPotentialEnergy();
    run.integrator.step(40);
    ASSERT(run.context->getState(State::Energy, false, 1).getPotentialEnergy() < 0.5 * start);
}

int main()
{
    return runOnPlatform("Reference", [](Platform& platform) {
        testCounts(platform);
        testNothingToTest(platform);
        for (bool isNative : {true, false})
            for (bool isSoft : {false, true})
                testTakenBack(platform, isNative, isSoft);
        testStatistics(platform);
        testBadStart(platform);
        testThrowingForce(platform);
        testZeroTemperature(platform);
        testSoftSpheresAtZeroTemperature(platform);
    });
}
