/**
 * This tests that outer tests sample what the energy says: the means of two torsions against quadrature, for foreign
 * Forces of kinds that no code of ours will evaluate.
 */

#include "openmm/CustomCentroidBondForce.h"
#include "openmm/CustomManyParticleForce.h"
#include "openmm/CustomTorsionForce.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "TestSupport.h"
#include <array>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static const double kT = 300 * 8.31446261815324e-3;

/** Of two torsions: the means of their cosines and sines, and of the cosine of their difference. */
typedef array<double, 5> Means;

static void add(Means& sums, const vector<double>& angles, double weight)
{
    const double values[] = {cos(angles[0]), sin(angles[0]), cos(angles[1]), sin(angles[1]),
                             cos(angles[0] - angles[1])};
    for (int i = 0; i < 5; i++)
        sums[i] += weight * values[i];
}

static double getLargestDifference(const Means& a, const Means& b)
{
    double largest = 0;
    for (int i = 0; i < 5; i++)
        largest = max(largest, fabs(a[i] - b[i]));
    return largest;
}

/**
 * Five beads, of which the torsions have native energies. The steric force has a group of its own.
 */
class ShortChain : public BeadChain {
public:
    explicit ShortChain(double radius) : BeadChain(5, radius)
    {
        force->setForceGroup(5);
        CustomTorsionForce* torsions = new CustomTorsionForce("3*cos(theta-1)+1.5*sin(2*theta)");
        torsions->addTorsion(0, 1, 2, 3);
        torsions->addTorsion(1, 2, 3, 4);
        system.addForce(torsions);
    }
    /**
     * Compute what should be sampled, by OpenMM's energies on a grid of both angles.
     */
    Means computeMeans(int groups, bool isHard = true) const
    {
        const int size = 36;
        TorsionMonteCarloIntegrator integrator(300);
        Context context(system, integrator, Platform::getPlatform("Reference"));
        context.setPositions(positions);
        Means means = {};
        double weights = 0;
        for (int i = 0; i < size; i++)
            for (int j = 0; j < size; j++) {
                const vector<double> angles = {2 * M_PI * (i + 0.5) / size, 2 * M_PI * (j + 0.5) / size};
                force->setTorsionAngles(context, angles);
                if (isHard && force->hasClash(context))
                    continue;
                const double energy = context.getState(State::Energy, false, groups).getPotentialEnergy();
                const double weight = exp(-energy / kT);
                weights += weight;
                add(means, angles, weight);
            }
        for (double& mean : means)
            mean /= weights;
        return means;
    }
};

static void addCentroidForce(System& system, int group)
{
    CustomCentroidBondForce* force = new CustomCentroidBondForce(2, "12*(distance(g1,g2)-1.3)^2");
    force->addGroup({0, 1});
    force->addGroup({3, 4});
    force->addBond({0, 1});
    force->setForceGroup(group);
    system.addForce(force);
}

static void addManyParticleForce(System& system, int group)
{
    CustomManyParticleForce* force =
        new CustomManyParticleForce(3, "15*(1+3*cos(theta1)*cos(theta2)*cos(theta3))/(r12*r13*r23);"
                                       "theta1=angle(p1,p2,p3); theta2=angle(p2,p3,p1); theta3=angle(p3,p1,p2);"
                                       "r12=distance(p1,p2); r13=distance(p1,p3); r23=distance(p2,p3)");
    for (int i = 0; i < system.getNumParticles(); i++)
        force->addParticle({}, i % 2);
    for (int i = 0; i < 3; i++)
        force->setTypeFilter(i, {0}); // one triple: OpenMM takes long for each
    force->setPermutationMode(CustomManyParticleForce::SinglePermutation);
    force->setForceGroup(group);
    system.addForce(force);
}

class Setting {
public:
    int trialsPerTest, trialsPerStep;
    bool native, soft;
};

/**
 * Sample, and see to it that there was something to test.
 */
static Means sample(const ShortChain& chain, const Setting& setting, int numSteps)
{
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(17);
    integrator.addTorsionMove(1, M_PI);
    integrator.addTorsionMove(1, 0.6, {}, 2);
    integrator.setTrialsPerStep(setting.trialsPerStep);
    integrator.setTrialsPerOuterTest(setting.trialsPerTest);
    integrator.setNativeEnergies(setting.native);
    if (setting.soft)
        integrator.setStericMode(TorsionMonteCarloIntegrator::Soft);
    else
        integrator.setIntegrationForceGroups(~(1 << 5));
    Context context(chain.system, integrator, Platform::getPlatform("Reference"));
    context.setPositions(chain.positions);
    Means means = {};
    vector<double> angles;
    for (int i = 0; i < numSteps; i++) {
        integrator.step(1);
        integrator.getTorsionAngles(context, angles);
        add(means, angles, 1.0 / numSteps);
    }
    long long attempted, accepted, trialsTakenBack;
    double mean, deviation;
    integrator.getOuterStatistics(attempted, accepted, trialsTakenBack, mean, deviation);
    ASSERT_EQUAL(setting.trialsPerTest == 0, attempted == 0);
    ASSERT(attempted == 0 || (accepted > 0.1 * attempted && accepted < 0.9 * attempted && deviation > 0.5 * kT));
    return means;
}

/**
 * Get five standard deviations of the mean of samples of which two are worth one.
 */
static double getTolerance(int numSamples)
{
    return 5 * 0.7 / sqrt(numSamples / 2);
}

static void assertSampled(const ShortChain& chain, const Means& expected, const Setting& setting, int numSteps)
{
    const double error = getLargestDifference(expected, sample(chain, setting, numSteps));
    if (error > getTolerance(numSteps))
        throw OpenMMException("with " + to_string(setting.trialsPerTest) + " trials a test and " +
                              to_string(setting.trialsPerStep) + " a step a mean is off by " + to_string(error));
}

static void testForeignForces()
{
    // In a group of their own and in that of the native Force; with and without native energies.

    for (auto addForce : {addCentroidForce, addManyParticleForce}) {
        const int numSteps = addForce == addCentroidForce ? 10000 : 3000;
        const double tolerance = getTolerance(numSteps);
        ShortChain chain(0.3), shared(0.3), bare(0.3);
        addForce(chain.system, 1);
        addForce(shared.system, 0);
        const Means expected = chain.computeMeans(3);
        ASSERT(getLargestDifference(expected, shared.computeMeans(1)) < 1e-12);
        ASSERT(getLargestDifference(expected, chain.computeMeans(2)) > 1.5 * tolerance);
        ASSERT(getLargestDifference(expected, bare.computeMeans(1)) > 1.5 * tolerance);
        for (const Setting& setting : {Setting{7, 21, true, false}, Setting{50, 50, true, false}})
            assertSampled(chain, expected, setting, numSteps);
        assertSampled(shared, expected, {7, 20, true, false}, numSteps);
        assertSampled(chain, expected, {7, 14, false, false}, numSteps);
        assertSampled(chain, expected, {0, 7, true, false}, numSteps);
    }
}

/**
 * The energy of soft spheres is seen by trials, and not by tests.
 */
static void testSoftSpheres()
{
    ShortChain chain(0.9);
    chain.force->setForceConstant(60);
    addCentroidForce(chain.system, 1);
    const Means expected = chain.computeMeans(3 | 1 << 5, false);
    const int numSteps = 10000;
    ASSERT(getLargestDifference(expected, chain.computeMeans(3, false)) > 4 * getTolerance(numSteps));
    assertSampled(chain, expected, {7, 20, true, true}, numSteps);
}

int main()
{
    return runOnPlatform("Reference", [](Platform&) {
        testForeignForces();
        testSoftSpheres();
    });
}
