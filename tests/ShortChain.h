#ifndef OPENMM_CHAINTREE_SHORTCHAIN_H_
#define OPENMM_CHAINTREE_SHORTCHAIN_H_

/**
 * A chain of two torsions, whose means are known by quadrature, and runs that sample them.
 */

#include "openmm/CustomTorsionForce.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "TestSupport.h"
#include <array>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

const double kT = 300 * 8.31446261815324e-3;

/** Of two torsions: the means of their cosines and sines, and of the cosine of their difference. */
typedef array<double, 5> Means;

inline void add(Means& sums, const vector<double>& angles, double weight)
{
    const double values[] = {cos(angles[0]), sin(angles[0]), cos(angles[1]), sin(angles[1]),
                             cos(angles[0] - angles[1])};
    for (int i = 0; i < 5; i++)
        sums[i] += weight * values[i];
}

inline double getLargestDifference(const Means& a, const Means& b)
{
    double largest = 0;
    for (int i = 0; i < 5; i++)
        largest = max(largest, fabs(a[i] - b[i]));
    return largest;
}

/**
 * Five beads whose torsions have native energies. The steric force has a separate group.
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

class Setting {
public:
    int trialsPerTest, trialsPerStep;
    bool native, soft;
};

/**
 * Sample, and see to it that there was something to test.
 */
inline Means sample(const ShortChain& chain, const Setting& setting, int numSteps)
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
    ASSERT(setting.trialsPerTest == 0 || attempted > 0);
    ASSERT(setting.trialsPerTest == 0 ||
           (accepted > 0.1 * attempted && accepted < 0.9 * attempted && deviation > 0.5 * kT));
    return means;
}

/**
 * Get five standard deviations of the mean of samples of which two are worth one.
 */
inline double getTolerance(int numSamples)
{
    return 5 * 0.7 / sqrt(numSamples / 2);
}

inline void assertSampled(const ShortChain& chain, const Means& expected, const Setting& setting, int numSteps)
{
    const double error = getLargestDifference(expected, sample(chain, setting, numSteps));
    if (error > getTolerance(numSteps))
        throw OpenMMException("with " + to_string(setting.trialsPerTest) + " trials a test and " +
                              to_string(setting.trialsPerStep) + " a step a mean is off by " + to_string(error));
}

#endif /*OPENMM_CHAINTREE_SHORTCHAIN_H_*/
