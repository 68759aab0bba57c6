/**
 * This tests the stand-in that trials see instead of Born solvation: when its numbers are made, and that they are kept.
 */

#include "openmm/CustomGBForce.h"
#include "openmm/GBSAOBCForce.h"
#include "OuterTestSupport.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * The scene of outer tests in solvent.
 */
class SolvatedScene : public OuterScene {
public:
    SolvatedScene()
    {
        GBSAOBCForce* born = new GBSAOBCForce();
        for (int i = 0; i < system.getNumParticles(); i++)
            born->addParticle(i % 2 == 0 ? 0.2 : -0.2, 0.2, 0.8);
        system.addForce(born);
    }
};

static string getStandIn(const Run& run)
{
    const string xml = toXml(run.context->getState(State::IntegratorParameters));
    const size_t begin = xml.find("<StandIn data=\"") + 15;
    return xml.substr(begin, xml.find('"', begin) - begin);
}

static void assertSame(OuterRun& expected, OuterRun& found)
{
    assertSameBits(getPositions(*expected.context), getPositions(*found.context));
    ASSERT_EQUAL(getStandIn(expected), getStandIn(found));
    ASSERT(getOwnPart(expected.createCheckpoint()) == getOwnPart(found.createCheckpoint()));
}

static void testNumbers(Platform& platform)
{
    // They are made once, by the first step, and by the user.

    SolvatedScene scene;
    scene.system.removeForce(3);
    OuterRun run(scene, platform, 0);
    run.integrator.setStandInCutoffs(1.5, 2);
    run.context->setPositions(scene.positions);
    const string none = getStandIn(run);
    run.integrator.step(1);
    const string first = getStandIn(run);
    ASSERT(first.size() > none.size() && none.find_first_not_of('0') == string::npos);
    ASSERT_EQUAL(1, Tests(run.integrator).attempted); // after 400 trials or a step
    run.integrator.step(10);
    vector<Vec3> moved = scene.positions;
    for (Vec3& position : moved)
        position += Vec3(1, 0, 0);
    run.context->setPositions(moved);
    run.integrator.step(1);
    ASSERT_EQUAL(first, getStandIn(run));
    run.integrator.setStandInCutoffs(1.5, 1);
    run.integrator.setStandInGridWidth(0.1);
    run.integrator.step(1);
    ASSERT_EQUAL(first, getStandIn(run));
    run.integrator.renewStandIns(*run.context);
    const string second = getStandIn(run);
    ASSERT(first != second && first.size() == second.size());
    run.integrator.step(1);
    ASSERT_EQUAL(second, getStandIn(run));
    run.integrator.setStandInCutoffs(1, 1);
    run.integrator.step(1);
    ASSERT(second != getStandIn(run));
}

static void testNewPositions(Platform& platform)
{
    // Numbers that are made for new positions leave no energy of the former ones, nor one of computed values.

    SolvatedScene scene;
    CustomGBForce* values = new CustomGBForce();
    values->addComputedValue("v", "exp(-r^2)", CustomGBForce::ParticlePairNoExclusions);
    values->addEnergyTerm("10*v^2", CustomGBForce::SingleParticle);
    for (int i = 0; i < scene.system.getNumParticles(); i++)
        values->addParticle({});
    scene.system.addForce(values);
    OuterRun run(scene, platform, 10), other(scene, platform, 10);
    run.context->setPositions(scene.positions);
    run.integrator.step(5);
    const double former = run.integrator.getPotentialEnergy(*run.context);
    for (OuterRun* each : {&run, &other}) {
        each->context->setPositions(scene.positions);
        each->integrator.renewStandIns(*each->context);
    }
    const double expected = other.integrator.getPotentialEnergy(*other.context);
    ASSERT(fabs(former - expected) > 0.1);
    ASSERT_EQUAL(expected, run.integrator.getPotentialEnergy(*run.context));
}

static void testGoingOn(Platform& platform, int trialsPerTest)
{
    SolvatedScene scene;
    OuterRun whole(scene, platform, trialsPerTest);
    whole.integrator.setStandInCutoffs(1.2, 1.5);
    whole.context->setPositions(scene.positions);
    vector<string> checkpoints;
    vector<State> states;
    for (int i = 0; i < 5; i++) {
        checkpoints.push_back(whole.createCheckpoint());
        states.push_back(writeAndRead(*whole.context));
        whole.integrator.step(1);
    }
    const Tests tests(whole.integrator);
    ASSERT(tests.accepted > 0 && tests.deviation > 0);
    for (int i = 0; i < 5; i++)
        for (bool fromState : {false, true}) {
            OuterRun fresh(scene, platform, trialsPerTest, 99);
            fresh.integrator.setStandInCutoffs(1.2, 1.5);
            if (fromState)
                fresh.context->setState(states[i]);
            else
                fresh.loadCheckpoint(checkpoints[i]);
            for (int j = i; j < 5; j++) {
                fresh.createCheckpoint(); // which recomputes sums, as in the whole run
                fresh.integrator.step(1);
            }
            assertSame(whole, fresh);
        }

    // A recreated Context has the constants of the old one.

    whole.context->reinitialize(true);
    OuterRun other(scene, platform, trialsPerTest, 99);
    other.integrator.setStandInCutoffs(1.2, 1.5);
    other.loadCheckpoint(whole.createCheckpoint());
    for (OuterRun* run : {&whole, &other})
        run->integrator.step(2);
    assertSame(whole, other);
}

static void testTakenBack(Platform& platform)
{
    SolvatedScene scene;
    OuterRun run(scene, platform, 10);
    run.context->setPositions(scene.positions);
    run.integrator.step(10);
    const vector<Vec3> start = getPositions(*run.context);
    const double energy = run.integrator.getPotentialEnergy(*run.context);
    const string standIn = getStandIn(run);
    const long long formerlyAccepted = Tests(run.integrator).accepted;
    ASSERT(formerlyAccepted > 0);
    scene.say = [&](const vector<Vec3>& x) {
        return x[5] == start[5] && x[10] == start[10] && x[0] == start[0] && x[18] == start[18] ? 0.0 : 1e9;
    };
    run.integrator.step(4);
    assertSameBits(start, getPositions(*run.context));
    ASSERT_EQUAL_TOL(energy, run.integrator.getPotentialEnergy(*run.context), 1e-12);
    ASSERT_EQUAL(standIn, getStandIn(run));
    ASSERT(Tests(run.integrator).trialsTakenBack > 100);
}

/**
 * Replace the last number of a State's stand-in, of a version without checksums.
 */
static string withNumber(const OuterRun& run, const string& bytes)
{
    string xml = toXml(run.context->getState(State::IntegratorParameters));
    xml.replace(xml.find(NEWEST_VERSION, xml.find("<IntegratorParameters")), NEWEST_VERSION.size(), "version=\"3\"");
    const size_t begin = xml.find("<StandIn data=\"") + 15;
    return xml.replace(xml.find('"', begin) - bytes.size(), bytes.size(), bytes);
}

static void testNumbersThatAreNone(Platform& platform)
{
    // NaN, infinity, and 1e300, which no float is, as bytes from the lowest on.

    SolvatedScene scene;
    OuterRun run(scene, platform, 10), twin(scene, platform, 10);
    for (OuterRun* each : {&run, &twin}) {
        each->context->setPositions(scene.positions);
        each->integrator.step(2);
    }
    for (const string bytes : {"000000000000f87f", "000000000000f07f", "9c7500883ce4377e"})
        assertThrows("the State is damaged", [&] {
            State damaged = fromXml(withNumber(run, bytes));
            run.context->setState(damaged);
        });
    for (OuterRun* each : {&run, &twin})
        each->integrator.step(2);
    assertSame(twin, run);
}

int main()
{
    return runOnPlatform("Reference", [](Platform& platform) {
        testNumbers(platform);
        testNewPositions(platform);
        for (int trialsPerTest : {0, 17})
            testGoingOn(platform, trialsPerTest);
        testTakenBack(platform);
        testNumbersThatAreNone(platform);
    });
}
