/**
 * This tests what of sampling is kept in States, on one platform.
 */

#include "CheckpointSupport.h"
#include "openmm/CompoundIntegrator.h"
#include "openmm/LangevinMiddleIntegrator.h"
#include "openmm/VerletIntegrator.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

void testState(Platform& platform)
{
    Scene scene;
    Run run(scene.system, 1, platform), fresh(scene.system, 1, platform);
    run.context->setPositions(scene.positions);
    fresh.context->setState(writeAndRead(*run.context));
    ASSERT_EQUAL(0, fresh.getNumToleratedClashes());
    run.integrator.step(30);
    int tolerated = run.getNumToleratedClashes();
    ASSERT(tolerated > 0);

    // Limits are kept as they are, not taken from the positions.

    State state = writeAndRead(*run.context);
    fresh.context->setState(state);
    ASSERT_EQUAL(tolerated, fresh.getNumToleratedClashes());
    assertSameBits(getPositions(*run.context), getPositions(*fresh.context));
    ASSERT_EQUAL(30, fresh.context->getStepCount());
    auto getLimits = [](Run& run) {
        string xml = toXml(run.context->getState(State::IntegratorParameters));
        size_t begin = xml.find("<Limits");
        return xml.substr(begin, xml.find("</Limits") - begin);
    };
    ASSERT_EQUAL(getLimits(run), getLimits(fresh));
    fresh.integrator.step(3);
    ASSERT_EQUAL(tolerated, fresh.getNumToleratedClashes());
    ASSERT_EQUAL(getLimits(run), getLimits(fresh));

    // Without integrator parameters, setting a State is setting positions.

    Run third(scene.system, 1, platform);
    third.context->setState(run.context->getState(State::Positions));
    ASSERT_EQUAL(0, third.getNumToleratedClashes());
}

/**
 * As testGoingOn(), but from States.
 */
void testGoingOnFromStates(Platform& platform)
{
    const int numSteps = 8;
    Scene scene;
    Run whole(scene.system, 5, platform);
    whole.context->setPositions(scene.positions);
    vector<State> states;
    for (int i = 0; i < numSteps; i++) {
        if (i == 4)
            whole.context->setPositions(scene.getTurnedPositions());
        states.push_back(writeAndRead(*whole.context));
        whole.integrator.step(1);
    }
    string end = getOwnPart(whole.createCheckpoint());
    vector<Vec3> positions = getPositions(*whole.context);
    ASSERT(whole.getNumToleratedClashes() > 0);
    for (int i = 4; i < numSteps; i++) {
        Run fresh(scene.system, 77, platform);
        for (Run* run : {&fresh, &whole}) {
            run->context->setState(states[i]);
            ASSERT_EQUAL(i, run->context->getStepCount());
            run->integrator.step(numSteps - i);
            ASSERT(end == getOwnPart(run->createCheckpoint()));
            assertSameBits(positions, getPositions(*run->context));
        }
    }
}

/**
 * A State that does not match restores its random numbers and limits.
 */
void testStatesThatDoNotFit(Platform& platform)
{
    Scene scene;
    Run run(scene.system, 1, platform);
    run.context->setPositions(scene.positions);
    run.integrator.step(10);
    int tolerated = run.getNumToleratedClashes();
    ASSERT(tolerated > 0);
    State state = writeAndRead(*run.context);

    // Other moves: their counts are left alone.

    long long attempted, clashed, rejected, accepted;
    Run others(scene.system, 1, platform);
    others.integrator.setTorsionMoveParameters(0, 3, 0.2);
    others.context->setState(state);
    others.integrator.getMoveStatistics(0, attempted, clashed, rejected, accepted);
    ASSERT_EQUAL(0, attempted);
    ASSERT_EQUAL(tolerated, others.getNumToleratedClashes());
    others.integrator.setTorsionMoveParameters(0, 3, 0.4);
    others.context->setState(state);
    others.integrator.getMoveStatistics(0, attempted, clashed, rejected, accepted);
    ASSERT(attempted > 0);

    // Other positions: those of an image, or none in the State.

    Run image(scene.system, 1, platform), moved(scene.system, 1, platform);
    image.context->setState(writeAndRead(*run.context, true));
    ASSERT_EQUAL(tolerated, image.getNumToleratedClashes());
    moved.context->setPositions(scene.getTurnedPositions());
    moved.context->setState(fromXml(toXml(run.context->getState(State::IntegratorParameters))));
    assertRounded(platform, scene.getTurnedPositions(), getPositions(*moved.context));
    ASSERT_EQUAL(tolerated, moved.getNumToleratedClashes());

    // Another structure.

    Scene cut;
    cut.system.setParticleMass(20, 0);
    Run cutRun(cut.system, 1, platform);
    cutRun.context->setState(state);
    ASSERT_EQUAL(tolerated, cutRun.getNumToleratedClashes());
    for (Run* each : {&others, &image, &moved, &cutRun})
        each->integrator.step(1);

    // A damaged one harms nothing, be it of a version that has no checksum.

    string xml = toXml(run.context->getState(State::IntegratorParameters));
    xml.replace(xml.find(NEWEST_VERSION, xml.find("<IntegratorParameters")), NEWEST_VERSION.size(), "version=\"3\"");
    for (const char* text : {"Random state=\"", " data=\""}) {
        string damaged = xml;
        damaged.insert(damaged.find(text) + string(text).size(), "x");
        assertThrows("the State is damaged", [&] {
            run.context->setState(fromXml(damaged));
        });
    }
    size_t begin = xml.find(" data=\"") + 7;
    size_t end = xml.find('"', begin);
    assertThrows("the checkpoint is incomplete", [&] {
        run.context->setState(fromXml(xml.substr(0, end - 40) + xml.substr(end)));
    });
    ASSERT_EQUAL(tolerated, run.getNumToleratedClashes());
    run.integrator.step(1);
}

/**
 * States of version 1 hold limits alone.
 */
void testStatesOfVersion1(Platform& platform)
{
    Scene scene;
    Run run(scene.system, 1, platform), fresh(scene.system, 1, platform);
    run.context->setPositions(scene.positions);
    run.integrator.step(10);
    int tolerated = run.getNumToleratedClashes();
    string xml = toXml(writeAndRead(*run.context));
    size_t parameters = xml.find("<IntegratorParameters");
    size_t version = xml.find(NEWEST_VERSION, parameters);
    xml.replace(version, 11, "version=\"1\"");
    size_t moves = xml.find("<Moves", parameters), limits = xml.find("<Limits", parameters);
    ASSERT(moves < limits && limits != string::npos);
    fresh.context->setState(fromXml(xml.erase(moves, limits - moves)));
    ASSERT_EQUAL(tolerated, fresh.getNumToleratedClashes());
    fresh.integrator.step(1);
    long long attempted, clashed, rejected, accepted;
    fresh.integrator.getMoveStatistics(0, attempted, clashed, rejected, accepted);
    ASSERT(attempted <= 50);
}

/**
 * Limits that come with a State may still grow: a pair that clashes where the Context stands, and in no State, is
 * tolerated as it is by the next trial.
 */
void testLimitsOfStatesGrow(Platform& platform)
{
    BeadChain clashing(11, 0.7, 0.5), apart(11, 0.7, 2.5);
    Run run(clashing.system, 1, platform), other(apart.system, 1, platform);
    other.context->setPositions(apart.positions);
    State state = fromXml(toXml(other.context->getState(State::IntegratorParameters)));
    run.context->setPositions(clashing.positions);
    run.integrator.step(1);
    ASSERT(run.getNumToleratedClashes() > 0);
    run.context->setState(state);
    ASSERT_EQUAL(0, run.getNumToleratedClashes());
    vector<pair<int, int>> pairs;
    vector<double> overlaps;
    clashing.force->getClashes(*run.context, pairs, overlaps);
    ASSERT(pairs.size() > 0);
    run.integrator.step(1);
    ASSERT_EQUAL(pairs.size(), run.getNumToleratedClashes());
}

void testStatesOfOtherIntegrators(Platform& platform)
{
    BeadChain chain(11, 0.45, 2.5);
    Run run(chain.system, 1, platform);
    LangevinMiddleIntegrator langevin(300, 1, 0.001);
    Context equilibration(chain.system, langevin, platform);
    equilibration.setPositions(chain.positions);
    run.context->setState(writeAndRead(equilibration));
    run.integrator.step(1);
    equilibration.setState(writeAndRead(*run.context));

    CompoundIntegrator compound;
    compound.addIntegrator(new VerletIntegrator(0.001));
    Context compoundContext(chain.system, compound, platform);
    compoundContext.setPositions(chain.positions);
    assertThrows("the integrator parameters of the State are those of another Integrator", [&] {
        run.context->setState(writeAndRead(compoundContext));
    });

    BeadChain shorter(11, 0.45, 2.5);
    Run other(shorter.system, 1, platform);
    BeadChain clashing(12, 0.7, 0.5);
    Run clashingRun(clashing.system, 1, platform);
    clashingRun.context->setPositions(clashing.positions);
    clashingRun.integrator.step(1);
    State limits = clashingRun.context->getState(State::IntegratorParameters);
    assertThrows("Particle positions have not been set", [&] {
        other.context->setState(limits);
    });
    other.context->setPositions(shorter.positions);
    assertThrows("there are 11 particles", [&] {
        other.context->setState(limits);
    });
    other.integrator.step(1);
}

void testStates(Platform& platform)
{
    testState(platform);
    testGoingOnFromStates(platform);
    testStatesThatDoNotFit(platform);
    testStatesOfVersion1(platform);
    testLimitsOfStatesGrow(platform);
    testStatesOfOtherIntegrators(platform);
}
