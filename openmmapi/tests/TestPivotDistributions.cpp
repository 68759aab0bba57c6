/**
 * This tests what pivot moves sample: directions without energy and spheres, and short chains with both.
 */

#include "FreeChain.h"
#include "openmm/CustomNonbondedForce.h"
#include "openmm/HarmonicAngleForce.h"
#include "openmm/HarmonicBondForce.h"
#include "SamplingSupport.h"
#include <array>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Without energy and spheres, bonds have any direction, each for itself: what is uniform before a few moves is so
 * afterwards. The samples are independent. Pearson's statistic of eight cells for each of ten variables is compared
 * with its quantile at 1e-6.
 */
void testUniformDirections(Platform& platform)
{
    const int numCells = 8, numSamples = 10000;
    FreeChain chain(5, 0);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(5);
    integrator.setTrialsPerStep(4);
    integrator.addPivotMove(1, M_PI);
    integrator.addPivotMove(2, 0.8);
    Context context(chain.system, integrator, platform);
    mt19937_64 random(5);
    vector<vector<int>> counts(10, vector<int>(numCells, 0));
    for (int i = 0; i < numSamples; i++) {
        context.setPositions(chain.drawPositions(random));
        integrator.step(1);
        const vector<Vec3> x = getPositions(context);
        vector<double> shares;
        for (int j = 0; j < 4; j++) {
            const Vec3 bond = x[j + 1] - x[j];
            shares.push_back(0.5 + 0.5 * bond[2]);
            if (j > 0)
                shares.push_back(0.5 + 0.5 * bond.dot(x[j] - x[j - 1]));
        }
        shares.push_back(0.5 + atan2(x[4][1] - x[3][1], x[4][0] - x[3][0]) / (2 * M_PI));
        for (int j = 0; j < 2; j++)
            shares.push_back(0.5 + getDihedral(x[j], x[j + 1], x[j + 2], x[j + 3]) / (2 * M_PI));
        for (int j = 0; j < 10; j++)
            counts[j][min(numCells - 1, (int)(numCells * shares[j]))]++;
    }
    const double expected = numSamples / (double)numCells;
    for (int j = 0; j < 10; j++) {
        double statistic = 0;
        for (int count : counts[j])
            statistic += (count - expected) * (count - expected) / expected;
        if (statistic > 40.5)
            throw OpenMMException("variable " + to_string(j) + " is not uniform: " + to_string(statistic));
    }
}

/**
 * Four beads whose spheres keep next but one neighbours apart, with a bending energy and an attraction of the ends. The
 * mean cosine of bond angles and the mean squared distance of the ends are known by quadrature over both angles and the
 * dihedral.
 */
class BentChain : public FreeChain {
public:
    explicit BentChain(bool isSoft) : FreeChain(4, 0.6), isSoft(isSoft)
    {
        force->setForceGroup(5);
        force->setForceConstant(100);
        HarmonicAngleForce* angles = new HarmonicAngleForce();
        angles->addAngle(0, 1, 2, 1.6, 6);
        angles->addAngle(1, 2, 3, 1.6, 6);
        system.addForce(angles);
        HarmonicBondForce* bonds = new HarmonicBondForce();
        for (int i = 0; i < 3; i++)
            bonds->addBond(i, i + 1, 0.9, 1000);
        system.addForce(bonds);
        CustomNonbondedForce* ends = new CustomNonbondedForce("-6*exp(-r*r)");
        for (int i = 0; i < 4; i++)
            ends->addParticle();
        ends->addInteractionGroup({0}, {3});
        system.addForce(ends);
    }
    /**
     * Compute the mean of the cosine of the second angle, and that of the squared distance of the ends.
     */
    array<double, 2> computeMeans() const
    {
        // Of hard spheres, cosines are less than that of touching neighbours.

        const int size = 64;
        const double largest = isSoft ? 1 : 1 - 0.5 * 1.2 * 1.2;
        array<double, 2> means = {};
        double weights = 0;
        for (int i = 0; i < size; i++)
            for (int j = 0; j < size; j++)
                for (int k = 0; k < size; k++) {
                    const double c1 = -1 + (i + 0.5) / size * (largest + 1), s1 = sqrt(1 - c1 * c1);
                    const double c2 = -1 + (j + 0.5) / size * (largest + 1), s2 = sqrt(1 - c2 * c2);
                    const double dihedral = M_PI * (k + 0.5) / size;
                    const Vec3 ends = Vec3(1 - c2, s2 * cos(dihedral), s2 * sin(dihedral)) - Vec3(c1, s1, 0);
                    const double square = ends.dot(ends);
                    double energy = 3 * pow(acos(c1) - 1.6, 2) + 3 * pow(acos(c2) - 1.6, 2) - 6 * exp(-square);
                    bool isFree = true;
                    for (double squared : {2 - 2 * c1, 2 - 2 * c2, square}) {
                        const double overlap = max(0.0, 1.2 - sqrt(squared));
                        isFree = isFree && overlap == 0;
                        energy += isSoft ? 50 * overlap * overlap : 0;
                    }
                    const double weight = isFree || isSoft ? exp(-energy / THERMAL) : 0;
                    weights += weight;
                    means[0] += weight * c2;
                    means[1] += weight * square;
                }
        for (double& mean : means)
            mean /= weights;
        return means;
    }

private:
    const bool isSoft;
};

/**
 * How energies of trials are computed.
 */
class Way {
public:
    string name;
    bool native, soft;
    int trialsPerTest;
};

/**
 * Hard and soft spheres, energies of this library and OpenMM's, in trials and in outer tests: all sample the same.
 */
void testEnergies(Platform& platform)
{
    const vector<Way> ways = {{"native", true, false, 0},
                              {"soft", true, true, 0},
                              {"foreign", false, false, 0},
                              {"outer tests", false, false, 5}};
    for (const Way& way : ways) {
        BentChain chain(way.soft);
        TorsionMonteCarloIntegrator integrator(300);
        integrator.setRandomNumberSeed(7);
        integrator.setTrialsPerStep(20);
        integrator.addPivotMove(1, M_PI);
        integrator.addPivotMove(1, 0.8);
        integrator.setNativeEnergies(way.native);
        integrator.setTrialsPerOuterTest(way.trialsPerTest);
        if (way.soft)
            integrator.setStericMode(TorsionMonteCarloIntegrator::Soft);
        integrator.setIntegrationForceGroups(~(1 << 5));
        Context context(chain.system, integrator, platform);
        context.setPositions(chain.positions);
        integrator.step(10);
        if (way.native) {
            // No joint changes a bond, of whatever length.

            const auto plan = integrator.getEnergyPlan(context);
            ASSERT_EQUAL(TorsionMonteCarloIntegrator::Native, plan[1].kind);
            ASSERT_EQUAL(TorsionMonteCarloIntegrator::Constant, plan[2].kind);
            ASSERT_EQUAL(TorsionMonteCarloIntegrator::Native, plan[3].kind);
        }
        const int numSteps = way.native ? 10000 : 2000;
        array<double, 2> sums = {}, squares = {};
        for (int i = 0; i < numSteps; i++) {
            integrator.step(1);
            const vector<Vec3> x = getPositions(context);
            const array<double, 2> values = {{(x[1] - x[2]).dot(x[3] - x[2]), (x[3] - x[0]).dot(x[3] - x[0])}};
            for (int j = 0; j < 2; j++) {
                sums[j] += values[j] / numSteps;
                squares[j] += values[j] * values[j] / numSteps;
            }
        }

        // Five standard deviations, if three samples are worth one.

        const array<double, 2> expected = chain.computeMeans();
        for (int j = 0; j < 2; j++) {
            const double deviation = sqrt((squares[j] - sums[j] * sums[j]) / (numSteps / 3));
            if (!(fabs(sums[j] - expected[j]) < 5 * deviation))
                throw OpenMMException(way.name + ": mean " + to_string(j) + " is " + to_string(sums[j]) + ", not " +
                                      to_string(expected[j]));
        }
    }
}

int main()
{
    return runOnPlatform("Reference", [](Platform& platform) {
        testUniformDirections(platform);
        testEnergies(platform);
    });
}
