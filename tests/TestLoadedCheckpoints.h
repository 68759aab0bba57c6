/**
 * This tests checkpoints on one platform: runs that continue from them, and checkpoints that are refused.
 */

#include "CheckpointSupport.h"
#include "openmm/CompoundIntegrator.h"
#include "openmm/CustomTorsionForce.h"
#include "openmm/VerletIntegrator.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include <memory>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * A run has positions set in its midst. Broken off anywhere, it ends with the same bits.
 */
void testEveryStepBoundary(Scene& scene, Platform& platform)
{
    const int numSteps = 12;
    vector<string> checkpoints;
    Run whole(scene.system, 5, platform);
    whole.context->setPositions(scene.positions);
    for (int i = 0; i < numSteps; i++) {
        if (i == 5)
            whole.context->setPositions(scene.getTurnedPositions());
        checkpoints.push_back(whole.createCheckpoint());
        whole.integrator.step(1);
    }
    string end = whole.createCheckpoint();
    ASSERT(whole.getNumToleratedClashes() > 0);
    for (int i = 5; i < numSteps; i++) {
        Run fresh(scene.system, 77, platform);
        fresh.loadCheckpoint(checkpoints[i]);
        ASSERT_EQUAL(i, fresh.context->getStepCount());
        fresh.integrator.step(numSteps - i);
        ASSERT(end == fresh.createCheckpoint());

        // A Context that has gone elsewhere, and back.

        whole.loadCheckpoint(checkpoints[i]);
        ASSERT(checkpoints[i] == whole.createCheckpoint());
        whole.integrator.step(numSteps - i);
        ASSERT(end == whole.createCheckpoint());
    }
    long long attempted, clashed, rejected, accepted, sumAttempted = 0, sumClashed = 0;
    for (int move = 0; move < 3; move++) {
        whole.integrator.getMoveStatistics(move, attempted, clashed, rejected, accepted);
        ASSERT(accepted > 0);
        sumAttempted += attempted;
        sumClashed += clashed;
    }
    ASSERT_EQUAL(50 * numSteps, sumAttempted);
    ASSERT(sumClashed > 0);
}

void testGoingOn(Platform& platform)
{
    Scene scene;
    testEveryStepBoundary(scene, platform);
    CustomTorsionForce* potential = new CustomTorsionForce("4*cos(theta)");
    for (int i = 0; i < 6; i++)
        potential->addTorsion(i, i + 1, i + 2, i + 3, {});
    scene.system.addForce(potential);
    testEveryStepBoundary(scene, platform);
}

/**
 * Proposals, queries and checkpoints in between leave no trace in what follows.
 */
void testNoTrace(Platform& platform)
{
    Scene scene;
    Run quiet(scene.system, 5, platform), busy(scene.system, 5, platform);
    for (Run* run : {&quiet, &busy}) {
        run->context->setPositions(scene.positions);
        run->integrator.step(3);
    }
    scene.force->proposeTorsions(*busy.context, {1}, {0.1});
    string checkpoint = busy.createCheckpoint();
    ASSERT(checkpoint == quiet.createCheckpoint());
    scene.force->proposeTorsions(*busy.context, {2}, {0.2});
    busy.loadCheckpoint(checkpoint);
    assertThrows("there is no open proposal", [&] {
        scene.force->acceptProposal(*busy.context);
    });
    for (Run* run : {&quiet, &busy})
        run->integrator.step(3);
    ASSERT(quiet.createCheckpoint() == busy.createCheckpoint());
}

/**
 * Beads 0 and 3 clash at first, and may come as close again, also after a checkpoint was loaded with them apart.
 */
void testLimitsAreRestored(Platform& platform)
{
    BeadChain chain(11, 0.7, M_PI);
    vector<Vec3> bent = BeadChain(11, 0.7, 0.5).positions;
    copy(bent.begin(), bent.begin() + 4, chain.positions.begin());
    for (int i = 0; i < 11; i++)
        for (int j = i + 1; j < 11; j++)
            if (i != 0 || j != 3)
                chain.force->addExclusion(i, j);
    Run run(chain.system, 1, platform), fresh(chain.system, 1, platform);
    run.context->setPositions(chain.positions);
    ASSERT(chain.force->proposeTorsions(*run.context, {0}, {1.5}));
    chain.force->acceptProposal(*run.context);
    ASSERT(!chain.force->hasClash(*run.context));
    fresh.loadCheckpoint(run.createCheckpoint());
    ASSERT_EQUAL(1, fresh.getNumToleratedClashes());
    ASSERT(chain.force->proposeTorsions(*fresh.context, {0}, {-1.5}));
    ASSERT(!chain.force->proposeTorsions(*fresh.context, {0}, {-1.51}));

    // Setting positions restarts limits, even if the positions are the same.

    fresh.context->setPositions(getPositions(*fresh.context));
    ASSERT_EQUAL(0, fresh.getNumToleratedClashes());
    ASSERT(!chain.force->proposeTorsions(*fresh.context, {0}, {-1.5}));
}

/**
 * With new parameters the engine restarts from its state, and a checkpoint holds that state.
 */
void testAfterNewParameters(Platform& platform)
{
    Scene scene;
    Run whole(scene.system, 5, platform), fresh(scene.system, 77, platform);
    whole.context->setPositions(scene.positions);
    whole.integrator.step(3);
    scene.force->setParticleParameters(3, 0.29);
    scene.force->updateParametersInContext(*whole.context);
    scene.force->updateParametersInContext(*fresh.context);
    whole.integrator.step(1);
    fresh.loadCheckpoint(whole.createCheckpoint());
    whole.integrator.step(3);
    fresh.integrator.step(3);
    ASSERT(whole.createCheckpoint() == fresh.createCheckpoint());
}

/**
 * Positions that another integrator has moved since the last step only let limits grow, with or without a checkpoint
 * in between.
 */
void testAfterDynamics(Platform& platform)
{
    Scene scene;
    class CompoundRun {
    public:
        CompoundRun(Scene& scene, Platform& platform)
        {
            TorsionMonteCarloIntegrator* sampler = new TorsionMonteCarloIntegrator(300);
            sampler->setRandomNumberSeed(2);
            sampler->addTorsionMove(1, 0.3);
            integrator.addIntegrator(sampler);
            integrator.addIntegrator(new VerletIntegrator(0.001));
            context = make_unique<Context>(scene.system, integrator, platform);
        }
        void step(int index, int steps)
        {
            integrator.setCurrentIntegrator(index);
            integrator.step(steps);
        }
        string createCheckpoint()
        {
            stringstream stream;
            context->createCheckpoint(stream);
            return stream.str();
        }
        CompoundIntegrator integrator;
        unique_ptr<Context> context;
    };
    CompoundRun whole(scene, platform), fresh(scene, platform), fromState(scene, platform);
    whole.context->setPositions(scene.positions);
    whole.step(0, 2);
    int tolerated = dynamic_cast<TorsionMonteCarloIntegrator&>(whole.integrator.getIntegrator(0))
                        .getNumToleratedClashes(*whole.context);
    ASSERT(tolerated > 0);
    vector<Vec3> velocities(scene.system.getNumParticles());
    velocities[0] = Vec3(0, -100, 0);
    velocities[4] = Vec3(30, 20, 10);
    whole.context->setVelocities(velocities);
    whole.step(1, 3);
    string checkpoint = whole.createCheckpoint();
    State state = writeAndRead(*whole.context);
    whole.step(0, 3);
    stringstream stream(checkpoint);
    fresh.context->loadCheckpoint(stream);
    TorsionMonteCarloIntegrator& sampler =
        dynamic_cast<TorsionMonteCarloIntegrator&>(fresh.integrator.getIntegrator(0));
    ASSERT(sampler.getNumToleratedClashes(*fresh.context) >= tolerated);
    fresh.step(0, 3);
    ASSERT(whole.createCheckpoint() == fresh.createCheckpoint());
    fromState.context->setState(state);
    fromState.step(0, 3);
    ASSERT(getOwnPart(whole.createCheckpoint()) == getOwnPart(fromState.createCheckpoint()));
    assertSameBits(getPositions(*whole.context), getPositions(*fromState.context));
}

void testRefusedCheckpoints(Platform& platform)
{
    BeadChain chain(11, 0.45, 2.5), other(11, 0.45, 2.5);
    other.force->addBond(0, 5);
    BeadChain cut(6, 0.45, 2.5);
    cut.addMolecule(5, 0.45, 2.5, Vec3(0, 0, 9));
    Run run(chain.system, 1, platform);
    run.context->setPositions(chain.positions);
    run.integrator.step(2);
    string checkpoint = run.createCheckpoint();

    // Of another structure, be it of as many particles.

    BeadChain longer(12, 0.45);
    Run withMore(longer.system, 1, platform);
    assertThrows("wrong number of particles", [&] {
        withMore.loadCheckpoint(checkpoint);
    });
    TorsionMonteCarloIntegrator plain(300);
    plain.addTorsionMove(3, 0.4);
    plain.addTorsionMove(1, 0.3);
    plain.addRigidBodyMove(1, 0.3, 0.5);
    Context cutContext(cut.system, plain, platform);
    stringstream stream(checkpoint);
    assertThrows("the checkpoint is of another structure: its bonds and torsions make other links", [&] {
        cutContext.loadCheckpoint(stream);
    });

    // Of another integrator, or another version.

    run.integrator.addTorsionMove(1, 0.1);
    assertThrows("the checkpoint is of an integrator with 3 moves, but this one has 4", [&] {
        run.loadCheckpoint(checkpoint);
    });
    string newer = run.createCheckpoint();
    size_t version = newer.find("ChainTMC") + 8;
    ASSERT(version < newer.size());
    newer[version] = 9;
    assertThrows("the checkpoint of a TorsionMonteCarloIntegrator has version 9", [&] {
        run.loadCheckpoint(newer);
    });
    VerletIntegrator verlet(0.001);
    Context verletContext(chain.system, verlet, platform);
    verletContext.setPositions(chain.positions);
    stringstream verletStream;
    verletContext.createCheckpoint(verletStream);
    assertThrows("the checkpoint", [&] {
        run.loadCheckpoint(verletStream.str());
    });
    string foreign = run.createCheckpoint();
    foreign.replace(foreign.find("ChainTMC"), 8, "UnchainT");
    assertThrows("the checkpoint was created with another Integrator", [&] {
        run.loadCheckpoint(foreign);
    });

    // Damaged ones, cut off anywhere in our part.

    string good = run.createCheckpoint();
    size_t begin = good.find("ChainTMC");
    for (size_t length = begin; length < good.size(); length += 97)
        assertThrows("the checkpoint is incomplete", [&] {
            run.loadCheckpoint(good.substr(0, length));
        });
    int numRefused = 0;
    for (size_t position = begin; position + 8 < good.size(); position += 101) {
        string damaged = good;
        damaged.replace(position, 8, 8, '\xff');
        try {
            run.loadCheckpoint(damaged);
        }
        catch (const OpenMMException&) {
            numRefused++;
        }
    }
    ASSERT(numRefused > 10);

    // None of this has broken anything, and the good one is as good as before.

    run.integrator.step(1);
    run.loadCheckpoint(good);
    ASSERT(good == run.createCheckpoint());
}

/**
 * Moves must agree in all parameters, not only in number.
 */
void testCheckpointsOfOtherMoves(Platform& platform)
{
    BeadChain chain(11, 0.45, 2.5);
    Run run(chain.system, 1, platform);
    run.context->setPositions(chain.positions);
    string good = run.createCheckpoint();
    run.integrator.step(1);
    auto assertRefused = [&](const string& message) {
        assertThrows("the checkpoint is of other moves: " + message, [&] {
            run.loadCheckpoint(good);
        });
    };
    vector<int> many;
    for (int i = 0; i < 8; i++)
        many.push_back(i);
    run.integrator.setTorsionMoveParameters(0, 3, 0.5);
    run.integrator.setTorsionMoveParameters(1, 1, 0.3, {0, 2, 5}, 3);
    assertRefused("move 0 has maxAngle 0.4 in it, but 0.5 here");
    run.integrator.setTorsionMoveParameters(0, 2, 0.4);
    assertRefused("move 0 has weight 3 in it, but 2 here");
    run.integrator.setTorsionMoveParameters(0, 3, 0.4);
    assertRefused("move 1 has torsions 0 2 5 7 in it, but 0 2 5 here");
    run.integrator.setTorsionMoveParameters(1, 1, 0.3, {0, 2, 7, 5}, 3);
    assertRefused("move 1 has torsions 0 2 5 7 in it, but 0 2 7 5 here");
    run.integrator.setTorsionMoveParameters(1, 1, 0.3, {0, 2, 5, 7}, 2);
    assertRefused("move 1 has count 3 in it, but 2 here");
    run.integrator.setTorsionMoveParameters(1, 1, 0.3, {0, 2, 5, 7}, 3);
    run.integrator.setRigidBodyMoveParameters(2, 1, nextafter(0.3, 1), 0.5);
    assertRefused("move 2 has maxTranslation 0.3 in it, but 0.30000000000000004 here");
    run.integrator.setRigidBodyMoveParameters(2, 1, 0.3, 0.5, {4});
    assertRefused("move 2 has molecules all in it, but 4 here");
    run.integrator.removeMove(2);
    run.integrator.addTorsionMove(1, 0.5);
    assertRefused("move 2 has kind rigid body in it, but torsion here");
    run.integrator.removeMove(2);
    run.integrator.addRigidBodyMove(1, 0.3, 0.5);
    run.loadCheckpoint(good);
    ASSERT(good == run.createCheckpoint());
}

/**
 * The positions of a refused checkpoint count as set by the user.
 */
void testPositionsOfRefusedCheckpoint(Platform& platform)
{
    BeadChain chain(11, 0.7, 0.5);
    Run run(chain.system, 1, platform), more(chain.system, 1, platform);
    run.context->setPositions(BeadChain(11, 0.7, 2.5).positions);
    string checkpoint = run.createCheckpoint();
    more.integrator.addTorsionMove(1, 0.1);
    more.context->setPositions(chain.positions);
    more.integrator.step(1);
    ASSERT(more.getNumToleratedClashes() > 0);
    assertThrows("3 moves", [&] {
        more.loadCheckpoint(checkpoint);
    });
    assertSameBits(getPositions(*run.context), getPositions(*more.context));
    ASSERT_EQUAL(0, more.getNumToleratedClashes());
    more.integrator.step(1);
    ASSERT_EQUAL(0, more.getNumToleratedClashes());
    ASSERT(!chain.force->hasClash(*more.context));

    // So do existing ones.

    more.context->setPositions(chain.positions);
    more.integrator.step(1);
    ASSERT(more.getNumToleratedClashes() > 0);
    run.context->setPositions(getPositions(*more.context));
    checkpoint = run.createCheckpoint();
    assertThrows("3 moves", [&] {
        more.loadCheckpoint(checkpoint);
    });
    ASSERT_EQUAL(0, more.getNumToleratedClashes());
}

void testLoadedCheckpoints(Platform& platform)
{
    testGoingOn(platform);
    testNoTrace(platform);
    testLimitsAreRestored(platform);
    testAfterNewParameters(platform);
    testAfterDynamics(platform);
    testRefusedCheckpoints(platform);
    testCheckpointsOfOtherMoves(platform);
    testPositionsOfRefusedCheckpoint(platform);
}
