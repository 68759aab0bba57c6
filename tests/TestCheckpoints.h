/**
 * This tests what of sampling is kept in checkpoints and States, on one platform.
 */

#include "openmm/CompoundIntegrator.h"
#include "openmm/CustomTorsionForce.h"
#include "openmm/HarmonicBondForce.h"
#include "openmm/LangevinMiddleIntegrator.h"
#include "openmm/serialization/XmlSerializer.h"
#include "openmm/VerletIntegrator.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "TestSupport.h"
#include <memory>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * A chain that ends in a stiff clump of more beads than a leaf of the tree holds, a second chain whose first bead is
 * fixed, and a loose one. The first chain clashes with itself. There are 64 particles, a multiple of 32: else a GPU
 * platform pads them with others, and what their velocities happen to be is in its checkpoints too.
 */
class Scene : public BeadChain {
public:
    Scene() : BeadChain(9, 0.45, 0.3)
    {
        int first = system.getNumParticles();
        for (int i = 0; i < 43; i++) {
            system.addParticle(1);
            force->addParticle(0.2);
            positions.push_back(positions[8] + Vec3(0.1 * (i % 3), 0.1 * (i / 3 % 3), 0.1 * (i / 9)) + Vec3(0, 0, 0.6));
            force->addBond(i == 0 ? 8 : first, first + i);
            for (int j = 6; j < first + i; j++)
                if (j < 9 || j >= first)
                    force->addExclusion(j, first + i);
        }
        int fixed = addMolecule(7, 0.45, 2.5, Vec3(0, 0, 6));
        system.setParticleMass(fixed, 0);
        addMolecule(5, 0.45, 2.5, Vec3(0, 0, -6));
    }
    /**
     * The same positions after a turn about a skew axis.
     */
    vector<Vec3> getTurnedPositions() const
    {
        vector<Vec3> turned;
        for (const Vec3& position : positions)
            turned.push_back(rotate(position, Vec3(), Vec3(1, 2, 3), 2.0));
        return turned;
    }
};

/**
 * An integrator with all kinds of moves, in a Context.
 */
class Run {
public:
    Run(System& system, int seed, Platform& platform) : integrator(300)
    {
        integrator.setRandomNumberSeed(seed);
        integrator.setTrialsPerStep(50);
        integrator.addTorsionMove(3, 0.4);
        integrator.addTorsionMove(1, 0.3, {0, 2, 5, 7}, 3);
        integrator.addRigidBodyMove(1, 0.3, 0.5);
        context = make_unique<Context>(system, integrator, platform);
    }
    /**
     * The bytes of a checkpoint: the state of everything.
     */
    string createCheckpoint()
    {
        stringstream stream;
        context->createCheckpoint(stream);
        return stream.str();
    }
    void loadCheckpoint(const string& checkpoint)
    {
        stringstream stream(checkpoint);
        context->loadCheckpoint(stream);
    }
    int getNumToleratedClashes()
    {
        return integrator.getNumToleratedClashes(*context);
    }
    TorsionMonteCarloIntegrator integrator;
    unique_ptr<Context> context;
};

/**
 * The integrator's part of a checkpoint. What GPU platforms write of their own tells of more than the simulation.
 */
string getOwnPart(const string& checkpoint)
{
    size_t begin = checkpoint.find("ChainTMC");
    ASSERT(begin != string::npos);
    return checkpoint.substr(begin);
}

string toXml(const State& state)
{
    stringstream stream;
    XmlSerializer::serialize<State>(&state, "State", stream);
    return stream.str();
}

State fromXml(const string& xml)
{
    stringstream stream(xml);
    unique_ptr<State> read(XmlSerializer::deserialize<State>(stream));
    return *read;
}

/**
 * As Simulation.saveState() and loadState() do it.
 */
State writeAndRead(const Context& context, bool enforcePeriodicBox = false)
{
    return fromXml(toXml(context.getState(
        State::Positions | State::Velocities | State::Parameters | State::IntegratorParameters, enforcePeriodicBox)));
}

// ---- Checkpoints ----

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

    // The user who sets positions, be they the same, starts limits anew.

    fresh.context->setPositions(getPositions(*fresh.context));
    ASSERT_EQUAL(0, fresh.getNumToleratedClashes());
    ASSERT(!chain.force->proposeTorsions(*fresh.context, {0}, {-1.5}));
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

// ---- A refused reinitialize() ----

/**
 * Check that nothing crashes that would need what an incomplete Context lacks.
 */
void checkIncomplete(Scene& scene, Run& run, const string& good)
{
    const string incomplete = "reinitialize() was refused";
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
    try {
        // Whether there is an answer depends on who refused. None may crash.

        scene.force->hasClash(*run.context);
        scene.force->proposeTorsions(*run.context, {0}, {0.1});
        scene.force->rejectProposal(*run.context);
        run.context->getState(State::Energy);
    }
    catch (const OpenMMException&) {
    }
}

/**
 * A run whose Context is made anew in its midst goes on as if nothing had happened, however often it is refused.
 */
void checkRefusal(Platform& platform, const string& message, const function<void(Scene&)>& spoil,
                  const function<void(Scene&)>& mend)
{
    Scene scene, other;
    Run whole(other.system, 5, platform), refused(scene.system, 5, platform);
    for (Run* run : {&whole, &refused}) {
        run->context->setPositions(scene.positions);
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
    const int types = State::Positions | State::Velocities | State::IntegratorParameters;
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
            scene.system.removeForce(1);
        });
}

/**
 * What a refused Context holds can be looked at, changed and written.
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

    // Moves are the integrator's own, and need not be what they were.

    run.integrator.addTorsionMove(1, 0.1);
    run.context->reinitialize(true);
    run.integrator.removeMove(3);
    ASSERT(before == getOwnPart(run.createCheckpoint()));

    // Positions that are set in between are kept, and the limits of the former start anew.

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

    // Who asks for a Context without state gets one.

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

// ---- Refused checkpoints ----

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
    newer[version] = 3;
    assertThrows("the checkpoint of a TorsionMonteCarloIntegrator has version 3", [&] {
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
 * Moves must be the same in all that decides what they do, not only as many.
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
 * What a refused checkpoint has brought are positions as if the user had set them.
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
}

// ---- States ----

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
 * A State that does not fit brings what it can: its random numbers and limits.
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

    // A damaged one harms nothing but limits.

    string xml = toXml(run.context->getState(State::IntegratorParameters));
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
    size_t version = xml.find("version=\"2\"", parameters);
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

void testCheckpoints(Platform& platform)
{
    testGoingOn(platform);
    testNoTrace(platform);
    testLimitsAreRestored(platform);
    testAfterDynamics(platform);
    testReinitialize(platform);
    testRefusedReinitialize(platform);
    testBetweenRefusalAndSuccess(platform);
    testRefusedCheckpoints(platform);
    testCheckpointsOfOtherMoves(platform);
    testPositionsOfRefusedCheckpoint(platform);
    testState(platform);
    testGoingOnFromStates(platform);
    testStatesThatDoNotFit(platform);
    testStatesOfVersion1(platform);
    testStatesOfOtherIntegrators(platform);
}
