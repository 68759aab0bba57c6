/**
 * This tests that a platform gives the answers of the Reference platform, whatever the precision of its positions:
 * queries see the positions that the Context returns, and the engine's state does not suffer from their rounding.
 */

#include "openmm/CustomTorsionForce.h"
#include "openmm/VerletIntegrator.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "TestSupport.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

typedef vector<pair<int, int>> Pairs;

/**
 * The same chain in two Contexts. The one of the Reference platform starts from the positions that the other one has.
 */
class BothContexts {
public:
    BothContexts(BeadChain& chain, Integrator& integrator, Platform& platform, Integrator& referenceIntegrator) :
        context(chain.system, integrator, platform),
        reference(chain.system, referenceIntegrator, Platform::getPlatformByName("Reference"))
    {
        context.setPositions(chain.positions);
        reference.setPositions(getPositions(context));
    }
    double getLargestShift() const
    {
        vector<Vec3> expected = getPositions(reference), found = getPositions(context);
        double largest = 0;
        for (size_t i = 0; i < expected.size(); i++)
            largest = max(largest, getDistance(expected[i], found[i]));
        return largest;
    }
    Context context, reference;
};

/**
 * A long chain that clashes with itself, some 10 nm wide.
 */
BeadChain makeClashingChain()
{
    return BeadChain(80, 0.68, 0.9);
}

void testEnergyAndQueries(Platform& platform)
{
    BeadChain chain = makeClashingChain();
    chain.force->setForceConstant(1000);
    VerletIntegrator integrator1(0.001), integrator2(0.001);
    BothContexts both(chain, integrator1, platform, integrator2);
    State expected = both.reference.getState(State::Energy | State::Forces);
    State found = both.context.getState(State::Energy | State::Forces);
    ASSERT(expected.getPotentialEnergy() > 10);
    ASSERT_EQUAL_TOL(expected.getPotentialEnergy(), found.getPotentialEnergy(), 1e-5);
    for (int i = 0; i < 80; i++)
        ASSERT_EQUAL_VEC(expected.getForces()[i], found.getForces()[i], 1e-5);

    Pairs expectedPairs, pairs;
    vector<double> expectedValues, values;
    for (int i = 0; i < 2; i++) {
        if (i == 0) {
            chain.force->getClashes(both.reference, expectedPairs, expectedValues);
            chain.force->getClashes(both.context, pairs, values);
        }
        else {
            chain.force->getNeighborPairs(both.reference, 2.5, expectedPairs, expectedValues);
            chain.force->getNeighborPairs(both.context, 2.5, pairs, values);
        }
        ASSERT(expectedPairs.size() > 20);
        ASSERT_EQUAL_CONTAINERS(expectedPairs, pairs);
        ASSERT(expectedValues == values);
    }
}

void testProposals(Platform& platform)
{
    BeadChain chain = makeClashingChain();
    VerletIntegrator integrator1(0.001), integrator2(0.001);
    BothContexts both(chain, integrator1, platform, integrator2);
    int numFree = 0;
    for (int i = 0; i < 200; i++) {
        vector<int> torsions = {i * 29 % 77};
        vector<double> changes = {0.4 * sin(i)};
        bool expected = chain.force->proposeTorsions(both.reference, torsions, changes);
        ASSERT_EQUAL(expected, chain.force->proposeTorsions(both.context, torsions, changes));
        vector<Vec3> before = getPositions(both.context);
        if (!expected || i % 3 == 0) {
            chain.force->rejectProposal(both.reference);
            chain.force->rejectProposal(both.context);
            assertSameBits(before, getPositions(both.context));
            continue;
        }
        numFree++;
        chain.force->acceptProposal(both.reference);
        chain.force->acceptProposal(both.context);
        ASSERT(both.getLargestShift() < 2e-6);
    }
    ASSERT(numFree > 10 && numFree < 130);
}

/**
 * One run of each platform, with the same seed. If every sync of positions left its rounding in the state, their ways
 * would part.
 */
void testTrajectory(Platform& platform)
{
    BeadChain chain = makeClashingChain();
    chain.addMolecule(6, 0.3, 2.0, Vec3(3, 3, -3));
    TorsionMonteCarloIntegrator integrator1(300), integrator2(300);
    for (TorsionMonteCarloIntegrator* integrator : {&integrator1, &integrator2}) {
        integrator->setRandomNumberSeed(4);
        integrator->setTrialsPerStep(20);
        integrator->addTorsionMove(1, 0.3);
        integrator->addRigidBodyMove(1, 0.2, 0.4);
    }
    BothContexts both(chain, integrator1, platform, integrator2);
    for (int i = 0; i < 100; i++) {
        integrator1.step(1);
        integrator2.step(1);
        ASSERT(both.getLargestShift() < 2e-6);
    }
    for (int move = 0; move < 2; move++) {
        long long expected[4], found[4];
        integrator1.getMoveStatistics(move, found[0], found[1], found[2], found[3]);
        integrator2.getMoveStatistics(move, expected[0], expected[1], expected[2], expected[3]);
        ASSERT(expected[3] > 0 && (move == 1 || expected[1] > 0));
        for (int i = 0; i < 4; i++)
            ASSERT_EQUAL(expected[i], found[i]);
    }
    ASSERT_EQUAL(integrator2.getNumToleratedClashes(both.reference), integrator1.getNumToleratedClashes(both.context));
}

/**
 * With another force's energy: a torsion between two wells, of which the lower one is visited more.
 */
void testOtherEnergy(Platform& platform)
{
    BeadChain chain(4, 0.1, 0.3);
    CustomTorsionForce* potential = new CustomTorsionForce("-4*cos(theta)");
    potential->addTorsion(0, 1, 2, 3, {});
    chain.system.addForce(potential);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(8);
    integrator.setTrialsPerStep(10);
    integrator.addTorsionMove(1, 3);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    const int numSteps = 1000;
    double mean = 0, expected = 0, sum = 0;
    vector<double> angles;
    for (int i = 0; i < numSteps; i++) {
        integrator.step(1);
        integrator.getTorsionAngles(context, angles);
        mean += cos(angles[0]) / numSteps;
    }
    for (int i = 0; i < 1000; i++) {
        double theta = 2 * M_PI * i / 1000, weight = exp(4 * cos(theta) / (0.00831446 * 300));
        expected += weight * cos(theta);
        sum += weight;
    }
    ASSERT_USUALLY_EQUAL_TOL(expected / sum, mean, 0.1);
}

void testAgreementWithReference(Platform& platform)
{
    testEnergyAndQueries(platform);
    testProposals(platform);
    testTrajectory(platform);
    testOtherEnergy(platform);
}
