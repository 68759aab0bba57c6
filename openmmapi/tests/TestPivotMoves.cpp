/**
 * This tests ball joints: trials that turn them, what pivot moves draw, and that bonds keep their lengths.
 */

#include "FreeChain.h"
#include "openmm/VerletIntegrator.h"
#include "SamplingSupport.h"
#include <limits>
#include <memory>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

// ---- Trials ----

void testProposals(Platform& platform)
{
    FreeChain chain(6, 0.2);
    VerletIntegrator integrator(0.001);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    const vector<Vec3>& x = chain.positions;
    const Vec3 rotation(0.3, -0.5, 0.2);
    const double angle = sqrt(rotation.dot(rotation));
    ASSERT(chain.force->proposeBallRotations(context, {2}, {rotation}));
    vector<Vec3> proposed;
    chain.force->getProposedPositions(context, proposed);
    for (int i = 0; i < 6; i++)
        ASSERT_EQUAL_VEC((i < 3 ? x[i] : rotate(x[i], x[2], rotation, angle)), proposed[i], 1e-14);

    // Of two, the one nearer to the root carries the other along.

    ASSERT(chain.force->proposeBallRotations(context, {2, 4}, {rotation, Vec3(0, 0.7, 0)}));
    chain.force->acceptProposal(context);
    proposed = getPositions(context);
    ASSERT_EQUAL_VEC(rotate(x[4], x[2], rotation, angle), proposed[4], 1e-14);
    ASSERT_EQUAL_VEC(rotate(rotate(x[5], x[4], Vec3(0, 1, 0), 0.7), x[2], rotation, angle), proposed[5], 1e-14);

    // No joint at all is a trial, too: one of nothing.

    ASSERT(chain.force->proposeBallRotations(context, {}, {}));
    chain.force->rejectProposal(context);

    const double nan = numeric_limits<double>::quiet_NaN();
    assertThrows("proposeBallRotations() names ball joint 5, but there are 5 ball joints", [&] {
        chain.force->proposeBallRotations(context, {5}, {rotation});
    });
    assertThrows("proposeBallRotations() names ball joint 1 twice", [&] {
        chain.force->proposeBallRotations(context, {1, 1}, {rotation, rotation});
    });
    assertThrows("was given 1 ball joints, but 2 rotations", [&] {
        chain.force->proposeBallRotations(context, {1}, {rotation, rotation});
    });
    assertThrows("the rotation of ball joint 3 is not finite", [&] {
        chain.force->proposeBallRotations(context, {0, 3}, {rotation, Vec3(0, nan, 0)});
    });
    chain.force->addBallJoint(0, 1);
    assertThrows("ball joints, closures or exclusions differ from those", [&] {
        chain.force->updateParametersInContext(context);
    });
}

/**
 * The side without the root moves, and it turns about the first particle wherever that is.
 */
void testRootAtTheEnd(Platform& platform)
{
    FreeChain chain(6, 0.2);
    chain.system.setParticleMass(5, 0);
    VerletIntegrator integrator(0.001);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    const vector<Vec3>& x = chain.positions;
    ASSERT(chain.force->proposeBallRotations(context, {3}, {Vec3(0.4, 0, 0)}));
    vector<Vec3> proposed;
    chain.force->getProposedPositions(context, proposed);
    for (int i = 0; i < 6; i++)
        ASSERT_EQUAL_VEC((i > 3 ? x[i] : rotate(x[i], x[3], Vec3(1, 0, 0), 0.4)), proposed[i], 1e-14);
}

/**
 * Torsions keep their values, which are sums of turns, while ball joints around them turn.
 */
void testTorsionsBeside(Platform& platform)
{
    BeadChain chain(8, 0.1, 1.0);
    StericExclusionForce* force = new StericExclusionForce(*chain.force);
    chain.system.removeForce(0);
    chain.system.addForce(force);
    while (force->getNumBallJoints() < 1)
        force->addBallJoint(0, 1);
    VerletIntegrator integrator(0.001);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    vector<double> angles;
    for (int i = 0; i < 20; i++) {
        force->proposeBallRotations(context, {0}, {Vec3(1, 2.0 - i, 0.5)});
        force->acceptProposal(context);
        force->proposeTorsions(context, {i % 5}, {0.3});
        force->acceptProposal(context);
    }
    force->getTorsionAngles(context, angles);
    const vector<Vec3> x = getPositions(context);
    for (int i = 0; i < 5; i++) {
        ASSERT_EQUAL_TOL(getDihedral(x[i], x[i + 1], x[i + 2], x[i + 3]), angles[i], 1e-12);
        ASSERT_EQUAL_TOL(remainder(1.0 + 4 * 0.3, 2 * M_PI), angles[i], 1e-12);
    }
}

// ---- Moves ----

class Turn {
public:
    int joint;
    double angle;
    Vec3 axis;
};

/**
 * Find out by which rotation a chain has been turned, from the positions before and after.
 */
Turn findTurn(const vector<Vec3>& before, const vector<Vec3>& after)
{
    int joint = 0;
    while (getDistance(before[joint + 1], after[joint + 1]) < 1e-9)
        joint++;
    Vec3 twice;
    double trace = 0;
    const Vec3 e1 = before[joint + 1] - before[joint], e2 = before[joint + 2] - before[joint];
    const Vec3 f1 = after[joint + 1] - after[joint], f2 = after[joint + 2] - after[joint];
    const auto orthonormal = [](const Vec3& a, const Vec3& b) {
        const Vec3 u = a / sqrt(a.dot(a)), w = u.cross(b) / sqrt(u.cross(b).dot(u.cross(b)));
        return vector<Vec3>{u, w.cross(u), w};
    };
    const vector<Vec3> e = orthonormal(e1, e2), f = orthonormal(f1, f2);
    for (int i = 0; i < 3; i++) {
        twice += e[i].cross(f[i]);
        trace += e[i].dot(f[i]);
    }
    return {joint, atan2(sqrt(twice.dot(twice)), trace - 1), twice / sqrt(twice.dot(twice))};
}

/**
 * Joints, axes and angles are drawn as promised.
 */
void testDraws(Platform& platform)
{
    FreeChain chain(9, 0);
    const vector<int> choices = {5, 1, 2};
    const int numSteps = 4000;
    for (double maxAngle : {0.6, M_PI}) {
        TorsionMonteCarloIntegrator integrator(300);
        integrator.setRandomNumberSeed(2);
        integrator.setTrialsPerStep(1);
        integrator.addPivotMove(1, maxAngle, choices);
        Context context(chain.system, integrator, platform);
        context.setPositions(chain.positions);
        vector<int> numTurned(8, 0);
        double largest = 0, meanAngle = 0, meanCosine = 0;
        Vec3 meanAxis, meanSquare;
        vector<Vec3> before = chain.positions;
        for (int i = 0; i < numSteps; i++) {
            integrator.step(1);
            const vector<Vec3> after = getPositions(context);
            const Turn turn = findTurn(before, after);
            numTurned[turn.joint]++;
            largest = max(largest, turn.angle);
            meanAngle += turn.angle / numSteps;
            meanCosine += cos(turn.angle) / numSteps;
            meanAxis += turn.axis / numSteps;
            for (int j = 0; j < 3; j++)
                meanSquare[j] += turn.axis[j] * turn.axis[j] / numSteps;
            before = after;
        }
        for (int joint = 0; joint < 8; joint++) {
            const bool isChoice = find(choices.begin(), choices.end(), joint) != choices.end();
            ASSERT_USUALLY_EQUAL_TOL(isChoice ? 1.0 / 3 : 0.0, numTurned[joint] / (double)numSteps, 0.035);
        }
        ASSERT(largest <= maxAngle + 1e-12 && largest > 0.995 * maxAngle);
        for (int j = 0; j < 3; j++) {
            ASSERT_USUALLY_EQUAL_TOL(0, meanAxis[j], 0.04);
            ASSERT_USUALLY_EQUAL_TOL(1.0 / 3, meanSquare[j], 0.022);
        }

        // Angles are uniform, or those of rotations of which all are equally likely. Five standard deviations.

        const bool isWhole = maxAngle == M_PI;
        ASSERT_USUALLY_EQUAL_TOL(isWhole ? M_PI / 2 + 2 / M_PI : 0.3, meanAngle, 5 * 0.65 / sqrt(numSteps));
        ASSERT_USUALLY_EQUAL_TOL(isWhole ? -0.5 : sin(0.6) / 0.6, meanCosine, 5 * 0.5 / sqrt(numSteps));
    }
}

void testParameters(Platform& platform)
{
    TorsionMonteCarloIntegrator integrator(300);
    ASSERT_EQUAL(0, integrator.addPivotMove(2, 0.5, {3, 1}));
    ASSERT_EQUAL(TorsionMonteCarloIntegrator::PivotMove, integrator.getMoveType(0));
    double weight, maxAngle;
    vector<int> joints;
    integrator.getPivotMoveParameters(0, weight, maxAngle, joints);
    ASSERT_EQUAL(2, weight);
    ASSERT_EQUAL(0.5, maxAngle);
    ASSERT_EQUAL_CONTAINERS((vector<int>{3, 1}), joints);
    integrator.setPivotMoveParameters(0, 1, 0.25);
    integrator.getPivotMoveParameters(0, weight, maxAngle, joints);
    ASSERT_EQUAL(1, weight);
    ASSERT_EQUAL(0.25, maxAngle);
    ASSERT(joints.empty());
    integrator.addTorsionMove(1, 0.1);
    assertThrows("move 1 is not a pivot move", [&] {
        integrator.setPivotMoveParameters(1, 1, 0.1);
    });
    assertThrows("move 0 is not a torsion move", [&] {
        integrator.setTorsionMoveParameters(0, 1, 0.1);
    });
    assertThrows("the largest angle of a pivot move must be at most pi, half a turn, but is 20 radians", [&] {
        integrator.addPivotMove(1, 20);
    });
    for (double bad : {-1.0, numeric_limits<double>::quiet_NaN()})
        assertThrows("the largest angle of a pivot move must be", [&] {
            integrator.addPivotMove(1, bad);
        });
    auto assertRefused = [&](const string& message, const System& system, const vector<int>& choices) {
        TorsionMonteCarloIntegrator other(300);
        other.addPivotMove(1, 0.1, choices);
        assertThrows(message, [&] {
            Context context(system, other, platform);
        });
    };
    FreeChain chain(4, 0.1);
    assertRefused("move 0 names ball joint 3, but there are 3 ball joints", chain.system, {3});
    assertRefused("move 0 names ball joint 1 twice", chain.system, {1, 2, 1});
    assertRefused("move 0 turns ball joints, but the StericExclusionForce has none", BeadChain(4, 0.1).system, {});

    // Constraints may lie in bonds, and not across a joint.

    chain.system.addConstraint(0, 1, 1.0);
    TorsionMonteCarloIntegrator pivots(300);
    pivots.addPivotMove(1, 0.1);
    Context context(chain.system, pivots, platform);
    chain.system.addConstraint(1, 3, 1.0);
    assertRefused("between particles 1 and 3 cannot hold: ball joint 2 moves them relative to each other", chain.system,
                  {});
}

/**
 * Bonds keep their lengths, whatever is accepted and however the run continues.
 */
void testBondLengths(Platform& platform)
{
    FreeChain chain(30, 0.45);
    unique_ptr<State> state;
    auto run = [&](const string& checkpoint, string& end) {
        TorsionMonteCarloIntegrator integrator(300);
        integrator.setRandomNumberSeed(3);
        integrator.setTrialsPerStep(1000);
        integrator.addPivotMove(1, M_PI);
        integrator.addPivotMove(1, 0.1);
        integrator.addRigidBodyMove(0.1, 0.1, 1);
        Context context(chain.system, integrator, platform);
        if (checkpoint == "state")
            context.setState(*state);
        else if (checkpoint.empty())
            context.setPositions(chain.positions);
        else {
            stringstream stream(checkpoint);
            context.loadCheckpoint(stream);
        }
        integrator.step(50);
        stringstream stream;
        context.createCheckpoint(stream);
        end = stream.str();
        if (!state)
            state = make_unique<State>(context.getState(State::Positions | State::IntegratorParameters));
        ASSERT(!chain.force->hasClash(context));
        return getPositions(context);
    };
    string middle, end, again;
    run("", middle);
    const vector<Vec3> x = run(middle, end);
    for (int i = 0; i < 29; i++)
        ASSERT_EQUAL_TOL(1, getDistance(x[i], x[i + 1]), 1e-13);
    assertSameBits(x, run(middle, again));
    ASSERT(end == again);
    assertSameBits(x, run("state", again));

    // What is of another structure is refused: here the joints turn about their other ends.

    FreeChain other(30, 0.45);
    StericExclusionForce* reversed = new StericExclusionForce();
    reversed->setOverlapTolerance(0);
    for (int i = 0; i < 30; i++)
        reversed->addParticle(0.45);
    for (int i = 0; i < 29; i++) {
        reversed->addBond(i, i + 1);
        reversed->addBallJoint(i + 1, i);
    }
    other.system.removeForce(0);
    other.system.addForce(reversed);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addPivotMove(1, M_PI);
    Context context(other.system, integrator, platform);
    assertThrows("the checkpoint is of another structure", [&] {
        stringstream stream(middle);
        context.loadCheckpoint(stream);
    });
}

int main()
{
    return runOnPlatform("Reference", [](Platform& platform) {
        testProposals(platform);
        testRootAtTheEnd(platform);
        testTorsionsBeside(platform);
        testDraws(platform);
        testParameters(platform);
        testBondLengths(platform);
    });
}
