/**
 * This tests that velocities turn with links, on one platform: what stays, what is refused, and when nothing happens.
 */

#include "openmm/CMMotionRemover.h"
#include "openmm/CompoundIntegrator.h"
#include "openmm/CustomExternalForce.h"
#include "openmm/CustomIntegrator.h"
#include "openmm/LangevinMiddleIntegrator.h"
#include "openmm/MonteCarloBarostat.h"
#include "openmm/NonbondedForce.h"
#include "openmm/VerletIntegrator.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "SamplingSupport.h"
#include <memory>
#include <random>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Two bead chains of different masses, the bonds of which are constrained, under dynamics and Monte Carlo in turns.
 */
class TurningScene {
public:
    explicit TurningScene(Platform& platform) : platform(platform), chain(9, 0)
    {
        chain.addMolecule(5, 0, 1.0, Vec3(0, 0, 3));
        for (int i = 0; i < 14; i++) {
            chain.system.setParticleMass(i, 1 + i % 5);
            if (i != 0 && i != 9)
                chain.system.addConstraint(i - 1, i, 1);
        }
        sampler = new TorsionMonteCarloIntegrator(300);
        sampler->setStericMode(TorsionMonteCarloIntegrator::Soft);
        sampler->setRandomNumberSeed(8);
        sampler->setTrialsPerStep(10);
        compound.addIntegrator(sampler);
        compound.addIntegrator(new LangevinMiddleIntegrator(300, 1, 0.002));
    }
    void makeContext()
    {
        context.reset(new Context(chain.system, compound, platform));
        context->setPositions(chain.positions);
    }
    /**
     * The velocity of each bead is its bond to the next one, that of the last of a chain its bond to the one before.
     * Both beads of such a bond keep their places relative to the link of the bead.
     */
    static vector<Vec3> getBonds(const vector<Vec3>& x)
    {
        vector<Vec3> bonds;
        for (int i = 0; i < 14; i++)
            bonds.push_back(i == 8 || i == 13 ? x[i] - x[i - 1] : x[i + 1] - x[i]);
        return bonds;
    }
    State getState() const
    {
        return context->getState(State::Positions | State::Velocities | State::Energy);
    }
    Platform& platform;
    BeadChain chain;
    CompoundIntegrator compound;
    TorsionMonteCarloIntegrator* sampler;
    unique_ptr<Context> context;
};

void testVelocitiesTurnWithLinks(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    for (int kind = 0; kind < 4; kind++) {
        TurningScene scene(platform);
        if (kind == 0)
            scene.sampler->addTorsionMove(1, 2);
        else if (kind == 1)
            scene.sampler->addLocalMove(1, 0.3, 1);
        else if (kind == 2)
            scene.sampler->addRigidBodyMove(1, 0.3, 2);
        else
            scene.sampler->addTorsionMove(1, 2, {}, 3);
        scene.makeContext();
        scene.context->setVelocities(TurningScene::getBonds(scene.chain.positions));
        scene.compound.step(3);
        ASSERT(Statistics(*scene.sampler, 0).accepted > 5);
        State state = scene.getState();
        vector<Vec3> bonds = TurningScene::getBonds(state.getPositions());
        ASSERT(getDistance(bonds[4], TurningScene::getBonds(scene.chain.positions)[4]) > 1e-3);
        for (int i = 0; i < 14; i++)
            ASSERT_EQUAL_VEC(bonds[i], state.getVelocities()[i], 10 * tolerance);
    }
}

/**
 * Kinetic energy and the velocities of constraints stay, with momentum or without.
 */
void testWhatTurnedVelocitiesKeep(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    for (bool removesMotion : {false, true}) {
        TurningScene scene(platform);
        if (removesMotion)
            scene.chain.system.addForce(new CMMotionRemover(1000));
        scene.sampler->addTorsionMove(1, 2);
        scene.sampler->addRigidBodyMove(0.3, 0.3, 2);
        scene.makeContext();
        scene.compound.setCurrentIntegrator(1);
        scene.compound.step(1); // motion is removed in this one
        scene.compound.setCurrentIntegrator(0);
        scene.context->setVelocitiesToTemperature(300, 5);
        scene.compound.step(1); // on OpenCL, OpenMM removes motion in each step, whatever the frequency
        State before = scene.getState();
        auto getMomentum = [&](const State& state) {
            Vec3 sum;
            for (int i = 0; i < 14; i++)
                sum += state.getVelocities()[i] * scene.chain.system.getParticleMass(i);
            return sum;
        };
        scene.compound.step(5);
        State after = scene.getState();
        ASSERT_EQUAL_TOL(before.getKineticEnergy(), after.getKineticEnergy(), tolerance);
        ASSERT(getDistance(before.getVelocities()[3], after.getVelocities()[3]) > 0.01);
        const Vec3 change = getMomentum(after) - getMomentum(before);
        const double rounding = platform.getName() == "OpenCL" ? 1e-5 : 100 * tolerance; // of removing motion
        ASSERT((sqrt(change.dot(change)) < rounding) == removesMotion);
        for (int i = 1; i < 14; i++) {
            if (i == 9)
                continue;
            // OpenMM has made the velocities that it set so by 1e-5 only.

            auto stretch = [&](const State& state) {
                return (state.getPositions()[i] - state.getPositions()[i - 1])
                    .dot(state.getVelocities()[i] - state.getVelocities()[i - 1]);
            };
            ASSERT(fabs(stretch(before) - stretch(after)) < 100 * tolerance);
        }
    }
}

/**
 * When dynamics resumes, velocities have as much of the direction of the forces as they had when it paused, with the
 * same kinetic energy and constraints. A checkpoint in between forgets the pause, so that whoever loads it has the same
 * bits.
 */
void testResumedDynamics(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    for (int kind = 0; kind < 3; kind++) {
        const bool isConstrained = (kind == 1), isSaved = (kind == 2);
        BeadChain chain(7, 0);
        CustomExternalForce* field = new CustomExternalForce("30*(x^2-y*z+sin(3*z))");
        for (int i = 0; i < 7; i++) {
            chain.system.setParticleMass(i, 1 + i % 3);
            field->addParticle(i);
            if (isConstrained && i > 0)
                chain.system.addConstraint(i - 1, i, 1);
        }
        chain.system.addForce(field);
        CompoundIntegrator compound;
        TorsionMonteCarloIntegrator* sampler = new TorsionMonteCarloIntegrator(300);
        sampler->setStericMode(TorsionMonteCarloIntegrator::Soft);
        sampler->setRandomNumberSeed(2);
        sampler->addTorsionMove(1, 2);
        compound.addIntegrator(sampler);
        CustomIntegrator* still = new CustomIntegrator(0); // dynamics without any step
        still->addUpdateContextState();
        compound.addIntegrator(still);
        Context context(chain.system, compound, platform);
        context.setPositions(chain.positions);
        context.setVelocitiesToTemperature(300, 4);
        auto getState = [&] {
            return context.getState(State::Positions | State::Velocities | State::Forces | State::Energy);
        };
        auto getShare = [&](const State& state) {
            double power = 0, squares = 0;
            for (int i = 0; i < 7; i++) {
                const Vec3 force = state.getForces()[i];
                power += force.dot(state.getVelocities()[i]);
                squares += force.dot(force) / chain.system.getParticleMass(i);
            }
            return power / sqrt(squares);
        };
        const State paused = getState();
        compound.step(2);
        compound.step(1);
        const State moved = getState();
        if (isSaved) {
            stringstream checkpoint;
            context.createCheckpoint(checkpoint);
        }
        compound.setCurrentIntegrator(1);
        compound.step(1);
        const State resumed = getState();
        compound.step(1);
        assertSameBits(resumed.getVelocities(), getState().getVelocities());
        assertSameBits(moved.getPositions(), resumed.getPositions());
        ASSERT_EQUAL_TOL(paused.getKineticEnergy(), moved.getKineticEnergy(), tolerance);
        ASSERT_EQUAL_TOL(paused.getKineticEnergy(), resumed.getKineticEnergy(), tolerance);
        if (isSaved)
            assertSameBits(moved.getVelocities(), resumed.getVelocities());
        else
            ASSERT(getDistance(moved.getVelocities()[3], resumed.getVelocities()[3]) > 1e-3);
        if (kind == 0) {
            ASSERT(fabs(getShare(moved) - getShare(paused)) > 0.01);
            ASSERT_EQUAL_TOL(getShare(paused), getShare(resumed), 100 * tolerance);
        }
        for (int i = 1; isConstrained && i < 7; i++)
            ASSERT(fabs((resumed.getPositions()[i] - resumed.getPositions()[i - 1])
                            .dot(resumed.getVelocities()[i] - resumed.getVelocities()[i - 1])) < 1e-4);
    }
}

/**
 * Trials that an outer test takes back leave no trace in velocities.
 */
void testVelocitiesOfTakenBackTrials(Platform& platform)
{
    TurningScene scene(platform);
    Probe* probe = new Probe();
    const double start = scene.chain.positions[8][0];
    probe->energy = [&](const vector<Vec3>& positions) {
        return fabs(positions[8][0] - start) < 1e-9 ? 0 : 1e6;
    };
    scene.chain.system.addForce(probe);
    scene.sampler->setTrialsPerOuterTest(10);
    scene.sampler->addTorsionMove(1, 2, {0, 1, 2, 3, 4});
    scene.makeContext();
    scene.context->setVelocitiesToTemperature(300, 5);
    const State before = scene.getState();
    scene.compound.step(3);
    long long attempted, accepted, trialsTakenBack;
    double mean, deviation;
    scene.sampler->getOuterStatistics(attempted, accepted, trialsTakenBack, mean, deviation);
    ASSERT_EQUAL(30, trialsTakenBack);
    assertSameBits(before.getPositions(), getPositions(*scene.context));
    assertSameBits(before.getVelocities(), scene.getState().getVelocities());
}

/**
 * Velocities turn by proposals that users accept, and in a Context that has no other Integrator.
 */
void testVelocitiesOfOtherContexts(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    TurningScene scene(platform);
    const vector<Vec3> velocities = TurningScene::getBonds(scene.chain.positions);
    VerletIntegrator verlet(0.001);
    Context context(scene.chain.system, verlet, platform);
    context.setPositions(scene.chain.positions);
    context.setVelocities(velocities);
    ASSERT(scene.chain.force->proposeTorsions(context, {2, 4}, {1.0, -2.0}));
    scene.chain.force->acceptProposal(context);
    State state = context.getState(State::Positions | State::Velocities);
    vector<Vec3> bonds = TurningScene::getBonds(state.getPositions());
    ASSERT(getDistance(bonds[6], velocities[6]) > 0.1);
    for (int i = 0; i < 14; i++)
        ASSERT_EQUAL_VEC(bonds[i], state.getVelocities()[i], 10 * tolerance);

    // A checkpoint brings velocities, too.

    stringstream checkpoint;
    for (bool loads : {false, true}) {
        TorsionMonteCarloIntegrator alone(300);
        alone.addTorsionMove(1, 2);
        Context other(scene.chain.system, alone, platform);
        other.setPositions(scene.chain.positions);
        if (loads)
            other.loadCheckpoint(checkpoint);
        else {
            other.setVelocities(velocities);
            other.createCheckpoint(checkpoint);
        }
        alone.step(1);
        state = other.getState(State::Positions | State::Velocities);
        bonds = TurningScene::getBonds(state.getPositions());
        for (int i = 0; i < 14; i++)
            ASSERT_EQUAL_VEC(bonds[i], state.getVelocities()[i], 10 * tolerance);
    }
}

string lastVelocityWarning;

void testUnturnableVelocities(Platform& platform)
{
    // A constraint between the ends of a bond angle, one of which lies on the axis, and one across a ball joint.

    for (bool isBall : {false, true}) {
        BeadChain chain(isBall ? 3 : 5, 0);
        if (isBall)
            chain.force->addBallJoint(1, 2);
        isBall ? chain.system.addConstraint(1, 2, 1) : chain.system.addConstraint(1, 3, sqrt(2.0));
        const string message = isBall ? "the constraint between particles 1 and 2 lies across ball joint 0"
                                      : "the constraint between particles 1 and 3 lies across torsion ";
        auto addMove = [&](TorsionMonteCarloIntegrator& integrator) {
            integrator.setStericMode(TorsionMonteCarloIntegrator::Soft);
            isBall ? integrator.addPivotMove(1, 1) : integrator.addTorsionMove(1, 1);
        };
        {
            CompoundIntegrator compound;
            TorsionMonteCarloIntegrator* integrator = new TorsionMonteCarloIntegrator(300);
            addMove(*integrator);
            compound.addIntegrator(integrator);
            compound.addIntegrator(new VerletIntegrator(0.001));
            assertThrows(message, [&] {
                Context context(chain.system, compound, platform);
            });
        }

        // Alone, velocities mean nothing, and stay as they are.

        TorsionMonteCarloIntegrator alone(300);
        addMove(alone);
        Context context(chain.system, alone, platform);
        context.setPositions(chain.positions);
        lastVelocityWarning = "";
        setWarningHandler([](const string& warning) {
            lastVelocityWarning = warning;
        });
        alone.step(1);
        alone.checkVelocities(context);
        ASSERT_EQUAL(string(), lastVelocityWarning);
        const vector<Vec3> velocities(chain.positions.size(), Vec3(1, 2, 3));
        context.setVelocities(velocities);
        assertThrows(message, [&] {
            alone.checkVelocities(context);
        });
        alone.step(1);
        setWarningHandler(ignoreWarning);
        ASSERT(lastVelocityWarning.find(message) != string::npos);
        assertSameBits(velocities, context.getState(State::Velocities).getVelocities());

        // A proposal is one of somebody who has velocities.

        VerletIntegrator verlet(0.001);
        Context own(chain.system, verlet, platform);
        own.setPositions(chain.positions);
        own.setVelocities(velocities);
        const vector<Vec3> positions = getPositions(own);
        isBall ? chain.force->proposeBallRotations(own, {0}, {Vec3(1, 0, 0)})
               : chain.force->proposeTorsions(own, {0}, {1.0});
        assertThrows(message, [&] {
            chain.force->acceptProposal(own);
        });
        assertSameBits(positions, getPositions(own));
    }
}

vector<string> stepWarnings;

void testWarningsBesideDynamics(Platform& platform)
{
    setWarningHandler([](const string& warning) {
        stepWarnings.push_back(warning);
    });
    for (bool isHard : {false, true})
        for (bool isViolated : {false, true}) {
            TurningScene scene(platform);
            scene.sampler->addTorsionMove(1, 1);
            if (isHard)
                scene.sampler->setStericMode(TorsionMonteCarloIntegrator::Hard);
            if (isViolated)
                scene.chain.positions[13] += Vec3(0, 0, 0.01);
            scene.makeContext();
            stepWarnings.clear();
            scene.compound.step(1);
            scene.compound.step(1);
            ASSERT_EQUAL((size_t)isHard + isViolated, stepWarnings.size());
            for (const string& warning : stepWarnings)
                ASSERT(warning.find("hard spheres beside dynamics") != string::npos ||
                       warning.find("particles 12 and 13 are ") != string::npos);
        }
    setWarningHandler(ignoreWarning);
}

/**
 * A barostat and soft spheres: positions and box that it has changed are where trials begin.
 */
void testBarostatInTurns(Platform& platform)
{
    BeadChain chain(5, 0);
    chain.addMolecule(5, 0, 1.0, Vec3(0, 0, 3));
    NonbondedForce* pairs = new NonbondedForce();
    pairs->setNonbondedMethod(NonbondedForce::CutoffPeriodic);
    pairs->setCutoffDistance(1);
    vector<pair<int, int>> bonds;
    for (int i = 0; i < 10; i++) {
        pairs->addParticle(0, 0.3, 0.5);
        if (i != 0 && i != 5)
            bonds.push_back(make_pair(i - 1, i));
    }
    pairs->createExceptionsFromBonds(bonds, 1, 1);
    chain.system.addForce(pairs);
    chain.system.addForce(new MonteCarloBarostat(100, 300, 1));
    chain.system.setDefaultPeriodicBoxVectors(Vec3(8, 0, 0), Vec3(0, 8, 0), Vec3(0, 0, 8));
    for (int i = 0; i < 10; i++)
        if (i != 0 && i != 5)
            chain.system.addConstraint(i - 1, i, 1);
    CompoundIntegrator compound;
    TorsionMonteCarloIntegrator* sampler = new TorsionMonteCarloIntegrator(300);
    sampler->setStericMode(TorsionMonteCarloIntegrator::Soft);
    sampler->setTrialsPerStep(5);
    sampler->addTorsionMove(1, 1);
    sampler->addRigidBodyMove(1, 0.1, 1);
    compound.addIntegrator(sampler);
    compound.addIntegrator(new LangevinMiddleIntegrator(300, 1, 0.002));
    Context context(chain.system, compound, platform);
    context.setPositions(chain.positions);
    context.setVelocitiesToTemperature(300, 1);
    const double volume = context.getState(0).getPeriodicBoxVolume();
    for (int i = 0; i < 30; i++) {
        compound.setCurrentIntegrator(0);
        compound.step(1);
        ASSERT_EQUAL_TOL(context.getState(State::Energy).getPotentialEnergy(), sampler->getPotentialEnergy(context),
                         1e-5);
        compound.setCurrentIntegrator(1);
        compound.step(5);
    }
    ASSERT(fabs(context.getState(0).getPeriodicBoxVolume() - volume) > 1e-3 * volume);
    sampler->setStericMode(TorsionMonteCarloIntegrator::Hard);
    compound.setCurrentIntegrator(0);
    assertThrows("the System has a barostat", [&] {
        compound.step(1);
    });
}

void testTurnedVelocities(Platform& platform)
{
    testVelocitiesTurnWithLinks(platform);
    testWhatTurnedVelocitiesKeep(platform);
    testResumedDynamics(platform);
    testVelocitiesOfTakenBackTrials(platform);
    testVelocitiesOfOtherContexts(platform);
    testUnturnableVelocities(platform);
    testWarningsBesideDynamics(platform);
    testBarostatInTurns(platform);
}
