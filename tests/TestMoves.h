/**
 * This tests the moves of TorsionMonteCarloIntegrator on one platform: their proposals, their setters, and bad input.
 */

#include "openmm/VerletIntegrator.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "SamplingSupport.h"
#include <functional>
#include <limits>
#include <memory>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

void testTorsionMoves(Platform& platform)
{
    // Three of torsions 1, 2, 4, 6, 7, each by at most 0.3.

    const double tolerance = getTolerance(platform);
    BeadChain chain(12, 0.3);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(1);
    integrator.setTrialsPerStep(1);
    const vector<int> choices = {7, 1, 2, 6, 4};
    integrator.addTorsionMove(1, 0.3, choices, 3);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    vector<double> before, after;
    vector<int> numTurned(9, 0);
    double largest = 0, sum = 0;
    const int numSteps = 3000;
    for (int i = 0; i < numSteps; i++) {
        integrator.setTorsionAngles(context, vector<double>(9, 3.0));
        integrator.getTorsionAngles(context, before);
        integrator.step(1);
        integrator.getTorsionAngles(context, after);
        int turned = 0;
        for (int j = 0; j < 9; j++) {
            double change = remainder(after[j] - before[j], 2 * M_PI);
            if (change == 0)
                continue;
            turned++;
            numTurned[j]++;
            largest = max(largest, fabs(change));
            sum += change;
        }
        ASSERT_EQUAL(3, turned);
    }
    ASSERT(largest <= 0.3 + tolerance && largest > 0.299);
    ASSERT_USUALLY_EQUAL_TOL(0, sum / (3 * numSteps), 0.01);
    for (int j = 0; j < 9; j++) {
        bool isChoice = find(choices.begin(), choices.end(), j) != choices.end();
        ASSERT_USUALLY_EQUAL_TOL(isChoice ? 0.6 : 0.0, numTurned[j] / (double)numSteps, 0.03);
    }
}

void testRigidBodyMoves(Platform& platform)
{
    // Molecules that begin with beads 0, 4 and 8 and the fixed particle 12. The move is for the second and third only.

    const double tolerance = getTolerance(platform);
    BeadChain chain(4, 0.1);
    chain.addMolecule(4, 0.1, 1.0, Vec3(0, 0, 5));
    chain.addMolecule(4, 0.1, 2.0, Vec3(0, 0, 10));
    chain.addMolecule(1, 0.1, 0.0, Vec3(0, 0, 15));
    chain.system.setParticleMass(12, 0);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(1);
    integrator.setTrialsPerStep(1);
    integrator.addRigidBodyMove(1, 0.2, 0.5, {10, 5});
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    const vector<Vec3> start = getPositions(context);
    auto getCenter = [](const vector<Vec3>& x, int first) {
        return (x[first] + x[first + 1] + x[first + 2] + x[first + 3]) * 0.25;
    };
    double largestShift = 0, largestAngle = 0, cubes = 0;
    Vec3 meanShift, meanAxis;
    int numMoved[3] = {0, 0, 0};
    const int numSteps = 4000;
    for (int i = 0; i < numSteps; i++) {
        context.setPositions(start);
        integrator.step(1);
        vector<Vec3> x = getPositions(context);
        for (int molecule = 0; molecule < 3; molecule++) {
            int first = 4 * molecule;
            if (x[first] == start[first] && x[first + 3] == start[first + 3])
                continue;
            numMoved[molecule]++;
            Vec3 shift = getCenter(x, first) - getCenter(start, first);
            meanShift += shift / numSteps;
            cubes += pow(shift.dot(shift), 1.5) / numSteps;
            largestShift = max(largestShift, sqrt(shift.dot(shift)));

            // The axis times the sine of the angle is half the antisymmetric part of the rotation.

            Vec3 twice;
            double trace = 0;
            const Vec3 e1 = start[first] - start[first + 1];
            const Vec3 e2 = start[first + 2] - start[first + 1];
            const Vec3 old[3] = {e1, e2, e1.cross(e2)};
            const Vec3 f1 = x[first] - x[first + 1], f2 = x[first + 2] - x[first + 1];
            const Vec3 turned[3] = {f1, f2, f1.cross(f2)};
            for (int j = 0; j < 3; j++) {
                twice += old[j].cross(turned[j]);
                trace += old[j].dot(turned[j]);
            }
            meanAxis += twice / numSteps;
            largestAngle = max(largestAngle, acos(min(1.0, (trace - 1) / 2)));
        }
        assertSameBits({start[12]}, {x[12]});
    }
    ASSERT_EQUAL(0, numMoved[0]);
    ASSERT_EQUAL(numSteps, numMoved[1] + numMoved[2]);
    ASSERT_USUALLY_EQUAL_TOL(0.5, numMoved[1] / (double)numSteps, 0.03);
    ASSERT(largestShift <= 0.2 + tolerance && largestShift > 0.199);
    ASSERT(largestAngle <= 0.5 + 1e-8 + tolerance && largestAngle > 0.49);
    ASSERT_USUALLY_EQUAL_TOL(0, sqrt(meanShift.dot(meanShift)), 0.006);
    ASSERT_USUALLY_EQUAL_TOL(0, sqrt(meanAxis.dot(meanAxis)), 0.02);
    ASSERT_USUALLY_EQUAL_TOL(0.5, cubes / pow(0.2, 3), 0.02); // The volume within a uniform point's radius is uniform.
}

/**
 * A recreated Context finds again what can move.
 */
void testMoleculesThatAreFixedLater(Platform& platform)
{
    BeadChain chain(4, 0.1);
    const int second = chain.addMolecule(4, 0.1, 1.0, Vec3(0, 0, 5));
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addRigidBodyMove(1, 0.2, 0.5);
    Context context(chain.system, integrator, platform);
    chain.system.setParticleMass(second, 0);
    context.reinitialize();
    context.setPositions(chain.positions);
    const vector<Vec3> start = getPositions(context);
    integrator.step(1);
    const vector<Vec3> end = getPositions(context);
    ASSERT(!(start[0] == end[0]));
    for (int i = second; i < second + 4; i++)
        assertSameBits({start[i]}, {end[i]});
}

void testWeights(Platform& platform)
{
    BeadChain chain(6, 0.3);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(4);
    ASSERT_EQUAL(0, integrator.addTorsionMove(1, 0.1));
    ASSERT_EQUAL(1, integrator.addTorsionMove(0, 0.1));
    ASSERT_EQUAL(2, integrator.addRigidBodyMove(3, 0.1, 0.1));
    ASSERT_EQUAL(3, integrator.getNumMoves());
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    integrator.step(200);
    ASSERT_EQUAL(0, Statistics(integrator, 1).attempted);
    ASSERT_EQUAL(20000, Statistics(integrator, 0).attempted + Statistics(integrator, 2).attempted);
    ASSERT_USUALLY_EQUAL_TOL(0.25, Statistics(integrator, 0).attempted / 20000.0, 0.015);
    integrator.resetMoveStatistics();
    for (int i = 0; i < 3; i++)
        ASSERT_EQUAL(0, Statistics(integrator, i).attempted);

    // A move may be added when the Context is there already.

    ASSERT_EQUAL(3, integrator.addTorsionMove(4, 0.1));
    integrator.step(10);
    ASSERT(Statistics(integrator, 3).attempted > 300);
}

/**
 * A move can be changed and removed, while there is a Context and while there is none.
 */
void testChangingMoves(Platform& platform)
{
    BeadChain chain(6, 0.3);
    chain.addMolecule(6, 0.3, 2.5, Vec3(0, 0, 4));
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addTorsionMove(1, 0.1, {0, 1});
    integrator.addRigidBodyMove(1, 0.1, 0.1);
    double weight, angle, translation;
    vector<int> choices;
    int count;
    for (bool isBound : {false, true}) {
        unique_ptr<Context> context;
        if (isBound) {
            context = make_unique<Context>(chain.system, integrator, platform);
            context->setPositions(chain.positions);
            integrator.step(3);
        }
        integrator.setTorsionMoveParameters(0, 2, 0.4, {3, 5}, 2);
        ASSERT_EQUAL(0, Statistics(integrator, 0).attempted);
        integrator.getTorsionMoveParameters(0, weight, angle, choices, count);
        ASSERT_EQUAL(2, weight);
        ASSERT_EQUAL(0.4, angle);
        ASSERT_EQUAL_CONTAINERS(vector<int>({3, 5}), choices);
        ASSERT_EQUAL(2, count);
        integrator.setRigidBodyMoveParameters(1, 0, 0.2, 0.3, {7});
        integrator.getRigidBodyMoveParameters(1, weight, translation, angle, choices);
        ASSERT_EQUAL(0, weight);
        ASSERT_EQUAL(0.2, translation);
        ASSERT_EQUAL(0.3, angle);
        ASSERT_EQUAL_CONTAINERS(vector<int>({7}), choices);
        assertThrows("move 1 is not a torsion move", [&] {
            integrator.setTorsionMoveParameters(1, 1, 0.1);
        });
        assertThrows("move 0 is not a rigid body move", [&] {
            integrator.setRigidBodyMoveParameters(0, 1, 0.1, 0.1);
        });
        for (int bad : {-1, 2}) {
            assertThrows("Index out of range", [&] {
                integrator.setTorsionMoveParameters(bad, 1, 0.1);
            });
            assertThrows("Index out of range", [&] {
                integrator.removeMove(bad);
            });
        }
        assertThrows("the weight of a move must be", [&] {
            integrator.setTorsionMoveParameters(0, -1, 0.1);
        });
        integrator.getTorsionMoveParameters(0, weight, angle, choices, count);
        ASSERT_EQUAL(2, weight);
        if (!isBound) {
            integrator.setTorsionMoveParameters(0, 1, 0.1, {0, 1});
            integrator.setRigidBodyMoveParameters(1, 1, 0.1, 0.1);
            continue;
        }

        // The next trials follow, and one that cannot is refused.

        assertThrows("move 0 names torsion 6, but there are 6 torsions", [&] {
            integrator.setTorsionMoveParameters(0, 1, 0.1, {6});
        });
        vector<double> before, after;
        integrator.getTorsionAngles(*context, before);
        integrator.step(1);
        integrator.getTorsionAngles(*context, after);
        ASSERT_EQUAL(100, Statistics(integrator, 0).attempted);
        for (int i = 0; i < 6; i++)
            ASSERT_EQUAL(i == 3 || i == 5, fabs(before[i] - after[i]) > 1e-5);

        // The others keep their counts.

        integrator.addTorsionMove(0, 0.5);
        integrator.removeMove(1);
        ASSERT_EQUAL(2, integrator.getNumMoves());
        ASSERT_EQUAL(100, Statistics(integrator, 0).attempted);
        integrator.getTorsionMoveParameters(1, weight, angle, choices, count);
        ASSERT_EQUAL(0.5, angle);
        integrator.removeMove(0);
        integrator.removeMove(0);
        assertThrows("there are no moves", [&] {
            integrator.step(1);
        });
    }
}

/**
 * An angle of more than half a turn is mostly one in degrees.
 */
void testAnglesInDegrees()
{
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addTorsionMove(1, 180 * (M_PI / 180));
    integrator.addRigidBodyMove(1, 0.1, nextafter(M_PI, 4));
    const string hint = "must be at most pi, half a turn, but is 20 radians; 20 degrees are 0.349066 radians";
    assertThrows("the largest angle of a torsion move " + hint, [&] {
        integrator.addTorsionMove(1, 20);
    });
    assertThrows("the largest angle of a torsion move " + hint, [&] {
        integrator.setTorsionMoveParameters(0, 1, 20);
    });
    assertThrows("the largest angle of a rigid body move " + hint, [&] {
        integrator.addRigidBodyMove(1, 0.1, 20);
    });
    assertThrows("the largest angle of a rigid body move " + hint, [&] {
        integrator.setRigidBodyMoveParameters(1, 1, 0.1, 20);
    });
    ASSERT_EQUAL(2, integrator.getNumMoves());
}

void testBadMoves(Platform& platform)
{
    const double nan = numeric_limits<double>::quiet_NaN(), infinity = numeric_limits<double>::infinity();
    TorsionMonteCarloIntegrator integrator(300);
    for (double bad : {-1.0, nan, infinity}) {
        assertThrows("the weight of a move must be a finite number and at least 0", [&] {
            integrator.addTorsionMove(bad, 0.1);
        });
        assertThrows("the weight of a move must be", [&] {
            integrator.addRigidBodyMove(bad, 0.1, 0.1);
        });
        assertThrows("the largest angle of a torsion move must be", [&] {
            integrator.addTorsionMove(1, bad);
        });
        assertThrows("the largest translation of a rigid body move must be", [&] {
            integrator.addRigidBodyMove(1, bad, 0.1);
        });
        assertThrows("the largest angle of a rigid body move must be", [&] {
            integrator.addRigidBodyMove(1, 0.1, bad);
        });
        assertThrows("the temperature must be", [&] {
            integrator.setTemperature(bad);
        });
        assertThrows("the temperature must be", [&] {
            TorsionMonteCarloIntegrator other(bad);
        });
    }
    assertThrows("the number of torsions of a torsion move must be at least 1, but is 0", [&] {
        integrator.addTorsionMove(1, 0.1, {}, 0);
    });
    assertThrows("the number of trials per step must be at least 1, but is 0", [&] {
        integrator.setTrialsPerStep(0);
    });
    assertThrows("the steric mode must be Automatic, Off, Hard or Soft, but is 4", [&] {
        integrator.setStericMode(TorsionMonteCarloIntegrator::StericMode(4));
    });
    assertThrows("the initial clash policy must be Tolerate or Refuse", [&] {
        integrator.setInitialClashPolicy(TorsionMonteCarloIntegrator::InitialClashPolicy(2));
    });
    ASSERT_EQUAL(0, integrator.getNumMoves());
    ASSERT_EQUAL(300, integrator.getTemperature());
    long long count;
    assertThrows("Index out of range", [&] {
        integrator.getMoveStatistics(0, count, count, count, count);
    });
    assertThrows("not bound to a context", [&] {
        integrator.step(1);
    });

    // What does not exist is found out when the Context is made, or at once if there is one.

    BeadChain chain(6, 0.3), rigid(3, 0.3);
    chain.addMolecule(1, 0.3, 0, Vec3(5, 0, 0));
    chain.system.setParticleMass(6, 0);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    assertThrows("there are no moves", [&] {
        integrator.step(1);
    });
    auto assertRefused = [&](const string& message, const System& system,
                             const function<void(TorsionMonteCarloIntegrator&)>& addMove) {
        TorsionMonteCarloIntegrator other(300);
        addMove(other);
        assertThrows(message, [&] {
            Context otherContext(system, other, platform);
        });
        if (&system == &chain.system)
            assertThrows(message, [&] {
                addMove(integrator);
            });
    };
    typedef TorsionMonteCarloIntegrator Integrator;
    assertRefused("move 0 turns torsions, but the StericExclusionForce has none", rigid.system, [](Integrator& i) {
        i.addTorsionMove(1, 0.1);
    });
    assertRefused("move 0 names torsion 3, but there are 3 torsions", chain.system, [](Integrator& i) {
        i.addTorsionMove(1, 0.1, {0, 3});
    });
    assertRefused("move 0 names torsion -1, but there are 3 torsions", chain.system, [](Integrator& i) {
        i.addTorsionMove(1, 0.1, {-1});
    });
    assertRefused("move 0 names torsion 2 twice", chain.system, [](Integrator& i) {
        i.addTorsionMove(1, 0.1, {2, 1, 2});
    });
    assertRefused("move 0 turns 3 torsions at once, but has only 2 to choose from", chain.system, [](Integrator& i) {
        i.addTorsionMove(1, 0.1, {2, 1}, 3);
    });
    assertRefused("move 0 names particle 7, but there are 7 particles", chain.system, [](Integrator& i) {
        i.addRigidBodyMove(1, 0.1, 0.1, {7});
    });
    assertRefused("move 0 names the molecule of particle 6, which has fixed particles and cannot move", chain.system,
                  [](Integrator& i) {
                      i.addRigidBodyMove(1, 0.1, 0.1, {6});
                  });
    assertRefused("move 0 names the molecule of particle 3 twice", chain.system, [](Integrator& i) {
        i.addRigidBodyMove(1, 0.1, 0.1, {0, 3});
    });
    ASSERT_EQUAL(0, integrator.getNumMoves());
    integrator.addTorsionMove(0, 0.1);
    assertThrows("all moves have weight 0", [&] {
        integrator.step(1);
    });

    // Positions, and another Context.

    integrator.addTorsionMove(1, 0.1);
    vector<Vec3> bad = chain.positions;
    bad[5][0] = nan;
    context.setPositions(bad);
    assertThrows("the position of particle 5 is not finite", [&] {
        integrator.step(1);
    });
    context.setPositions(chain.positions);
    integrator.step(1);
    VerletIntegrator verlet(0.001);
    Context other(chain.system, verlet, platform);
    other.setPositions(chain.positions);
    vector<double> angles;
    assertThrows("it is not bound to this Context", [&] {
        integrator.getTorsionAngles(other, angles);
    });
    assertThrows("it is not bound to this Context", [&] {
        integrator.getNumToleratedClashes(other);
    });
    TorsionMonteCarloIntegrator unset(300);
    unset.addTorsionMove(1, 0.1);
    Context without(chain.system, unset, platform);
    assertThrows("Particle positions have not been set", [&] {
        unset.step(1);
    });
}

void testMoves(Platform& platform)
{
    testTorsionMoves(platform);
    testRigidBodyMoves(platform);
    testMoleculesThatAreFixedLater(platform);
    testWeights(platform);
    testChangingMoves(platform);
    testAnglesInDegrees();
    testBadMoves(platform);
}
