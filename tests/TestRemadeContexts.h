/**
 * This tests Contexts that are recreated on one platform, and what becomes of a run if that is refused.
 */

#include "CheckpointSupport.h"
#include "openmm/CustomExternalForce.h"
#include "openmm/HarmonicBondForce.h"
#include <functional>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

void testReinitialize(Platform& platform)
{
    Scene scene;
    Run whole(scene.system, 0, platform), broken(scene.system, 0, platform);
    whole.context->reinitialize(true);
    assertThrows("Particle positions have not been set", [&] {
        whole.integrator.step(1);
    });
    whole.context->setPositions(scene.positions);
    whole.integrator.step(2);
    broken.loadCheckpoint(whole.createCheckpoint());
    broken.context->reinitialize(true);
    whole.integrator.step(3);
    broken.integrator.step(3);
    ASSERT(whole.createCheckpoint() == broken.createCheckpoint());

    // Without the state, positions are gone.

    broken.context->reinitialize();
    assertThrows("Particle positions have not been set", [&] {
        broken.integrator.step(1);
    });

    // What does not change the links may change.

    int tolerated = whole.getNumToleratedClashes();
    vector<Vec3> positions = getPositions(*whole.context);
    scene.force->addExclusion(0, 30);
    scene.force->setParticleParameters(20, 0.21);
    whole.context->reinitialize(true);
    assertSameBits(positions, getPositions(*whole.context));
    ASSERT_EQUAL(tolerated, whole.getNumToleratedClashes());
    whole.integrator.step(1);
    scene.force->addBond(0, 1);
    whole.context->reinitialize(true);
    whole.integrator.step(1);
    scene.force->addTorsion(7, 8, 9, 10);
    assertThrows("the checkpoint is of another structure", [&] {
        whole.context->reinitialize(true);
    });
    whole.context->reinitialize();
    whole.context->setPositions(positions);
    whole.integrator.step(1);
}

/**
 * Check that nothing crashes that would need what an incomplete Context lacks.
 */
void checkIncomplete(Scene& scene, Run& run, const string& good)
{
    const string incomplete = "reinitialize() threw an exception";
    assertThrows(incomplete, [&] {
        run.integrator.step(1);
    });
    assertThrows(incomplete, [&] {
        run.context->getState(State::IntegratorParameters);
    });
    assertThrows(incomplete, [&] {
        run.getNumToleratedClashes();
    });
    vector<double> angles;
    assertThrows(incomplete, [&] {
        run.integrator.getTorsionAngles(*run.context, angles);
    });
    assertThrows(incomplete, [&] {
        run.integrator.setTorsionAngles(*run.context, angles);
    });
    assertThrows(incomplete, [&] {
        run.loadCheckpoint(good);
    });

    // Whether there is an answer to these depends on who refused. None may crash.

    const vector<function<void()>> actions = {[&] {
                                                  scene.force->hasClash(*run.context);
                                              },
                                              [&] {
                                                  scene.force->proposeTorsions(*run.context, {0}, {0.1});
                                              },
                                              [&] {
                                                  scene.force->rejectProposal(*run.context);
                                              },
                                              [&] {
                                                  run.context->getState(State::Energy);
                                              }};
    for (auto& act : actions)
        try {
            act();
        }
        catch (const OpenMMException&) {
        }
}

/**
 * A run whose Context is recreated in its midst continues as if nothing had happened, however often it is refused.
 */
void checkRefusal(Platform& platform, const string& message, const function<void(Scene&)>& spoil,
                  const function<void(Scene&)>& mend)
{
    Scene scene, other;
    for (Scene* each : {&scene, &other}) {
        CustomExternalForce* field = new CustomExternalForce("strength*x");
        field->addGlobalParameter("strength", 0);
        field->addParticle(3);
        each->system.addForce(field);
    }
    Run whole(other.system, 5, platform), refused(scene.system, 5, platform);
    for (Run* run : {&whole, &refused}) {
        run->context->setPositions(scene.positions);
        run->context->setParameter("strength", 0.5);
        run->context->setPeriodicBoxVectors(Vec3(20, 0, 0), Vec3(0, 21, 0), Vec3(0, 0, 22));
        run->context->setVelocities(vector<Vec3>(scene.positions.size(), Vec3(1, 2, 3)));
        run->context->setTime(7);
        run->integrator.step(4);
    }
    string good = refused.createCheckpoint();
    for (int i = 0; i < 2; i++) {
        spoil(scene);
        for (int j = 0; j < 2; j++)
            assertThrows(message, [&] {
                refused.context->reinitialize(true);
            });
        if (i == 0)
            checkIncomplete(scene, refused, good);
        mend(scene);
        if (i == 0) // A refused checkpoint brings other positions, of which nobody tells.
            refused.context->setPositions(getPositions(*whole.context));
        refused.context->reinitialize(true);
        if (i == 0)
            refused.loadCheckpoint(good);
    }
    assertSameBits(getPositions(*whole.context), getPositions(*refused.context));
    ASSERT(whole.getNumToleratedClashes() > 0);
    ASSERT_EQUAL(whole.getNumToleratedClashes(), refused.getNumToleratedClashes());
    whole.integrator.step(3);
    refused.integrator.step(3);
    ASSERT(getOwnPart(whole.createCheckpoint()) == getOwnPart(refused.createCheckpoint()));
    const int types = State::Positions | State::Velocities | State::Parameters | State::IntegratorParameters;
    ASSERT_EQUAL(toXml(whole.context->getState(types)), toXml(refused.context->getState(types)));
}

void testRefusedReinitialize(Platform& platform)
{
    // Refused by the integrator, by the StericExclusionForce, and by another Force.

    checkRefusal(
        platform, "the constraint between particles 0 and 5",
        [](Scene& scene) {
            scene.system.addConstraint(0, 5, 1.0);
        },
        [](Scene& scene) {
            scene.system.removeConstraint(0);
        });
    if (platform.getName() == "OpenCL")
        return; // OpenMM itself crashes on a Context without an integrator's kernel.
    checkRefusal(
        platform, "lies between two fixed parts",
        [](Scene& scene) {
            scene.system.setParticleMass(0, 0);
            scene.system.setParticleMass(8, 0);
        },
        [](Scene& scene) {
            scene.system.setParticleMass(0, 1);
            scene.system.setParticleMass(8, 1);
        });
    checkRefusal(
        platform, "particle",
        [](Scene& scene) {
            HarmonicBondForce* bad = new HarmonicBondForce();
            bad->addBond(0, 1000, 1, 1);
            scene.system.addForce(bad);
        },
        [](Scene& scene) {
            scene.system.removeForce(scene.system.getNumForces() - 1);
        });
}

/**
 * The objects of a refused Context can be read, changed and written.
 */
void testBetweenRefusalAndSuccess(Platform& platform)
{
    Scene scene;
    Run run(scene.system, 5, platform), rescued(scene.system, 77, platform);
    run.context->setPositions(scene.positions);
    run.integrator.step(4);
    vector<Vec3> positions = getPositions(*run.context);
    string before = getOwnPart(run.createCheckpoint());
    auto refuse = [&] {
        scene.system.addConstraint(0, 5, 1.0);
        assertThrows("the constraint", [&] {
            run.context->reinitialize(true);
        });
        scene.system.removeConstraint(0);
    };
    refuse();
    assertSameBits(positions, getPositions(*run.context));
    rescued.loadCheckpoint(run.createCheckpoint());
    ASSERT(before == getOwnPart(rescued.createCheckpoint()));
    assertSameBits(positions, getPositions(*rescued.context));

    // Moves belong to the integrator, and may differ from those before.

    run.integrator.addTorsionMove(1, 0.1);
    run.context->reinitialize(true);
    run.integrator.removeMove(3);
    ASSERT(before == getOwnPart(run.createCheckpoint()));

    // Positions that are set in between are kept, and limits restart from them.

    refuse();
    vector<Vec3> velocities(positions.size(), Vec3(3, 2, 1));
    run.context->setPositions(scene.getTurnedPositions());
    run.context->setVelocities(velocities);
    refuse();
    run.context->reinitialize(true);
    assertRounded(platform, scene.getTurnedPositions(), getPositions(*run.context));
    assertSameBits(velocities, run.context->getState(State::Velocities).getVelocities());
    ASSERT_EQUAL(0, run.getNumToleratedClashes());
    run.integrator.step(1);
    ASSERT(run.getNumToleratedClashes() > 0);

    // A Context is made without state if that is asked for.

    refuse();
    run.context->reinitialize();
    assertThrows("Particle positions have not been set", [&] {
        run.integrator.step(1);
    });
    refuse();
    run.context->reinitialize(true);
    assertThrows("Particle positions have not been set", [&] {
        run.integrator.step(1);
    });
    run.context->setPositions(scene.positions);
    run.integrator.step(1);
}

/**
 * An integrator whose Context has been deleted says so.
 */
void testDeletedContext(Platform& platform)
{
    BeadChain chain(5, 0);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addTorsionMove(1, 1);
    unique_ptr<Context> context(new Context(chain.system, integrator, platform));
    context->setPositions(chain.positions);
    integrator.step(1);
    context.reset();
    assertThrows("its Context was deleted", [&] {
        integrator.step(1);
    });
}

void testRemadeContexts(Platform& platform)
{
    testDeletedContext(platform);
    testReinitialize(platform);
    testRefusedReinitialize(platform);
    testBetweenRefusalAndSuccess(platform);
}
