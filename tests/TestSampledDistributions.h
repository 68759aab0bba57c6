/**
 * This tests what TorsionMonteCarloIntegrator samples, against quadrature and known integrals, on one platform.
 */

#include "openmm/CompoundIntegrator.h"
#include "openmm/CustomExternalForce.h"
#include "openmm/CustomTorsionForce.h"
#include "openmm/LangevinMiddleIntegrator.h"
#include "openmm/VerletIntegrator.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "SamplingSupport.h"
#include <random>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Get Pearson's statistic for counts with given probabilities.
 */
double computeChiSquared(const vector<int>& counts, const vector<double>& probabilities)
{
    double total = 0, sum = 0;
    for (int count : counts)
        total += count;
    for (size_t i = 0; i < counts.size(); i++)
        sum += pow(counts[i] - total * probabilities[i], 2) / (total * probabilities[i]);
    return sum;
}

/**
 * Five hard beads have two torsions. Beads 0 and 3, 1 and 4 never meet; beads 0 and 4 exclude a region of the two
 * angles. Its shape, by quadrature, gives the distribution of the first angle. A sampler that records only accepted
 * trials, a classic error, must be found out.
 */
void testHardBeads(Platform& platform)
{
    const int numBins = 25, numCells = 1000;
    const double diameter = 0.99;
    vector<double> probabilities(numBins, 0.0);
    double allowed = 0;
    for (int i = 0; i < numBins * numCells; i++) {
        double angle1 = -M_PI + 2 * M_PI * (i + 0.5) / (numBins * numCells);
        for (int j = 0; j < numCells; j++) {
            double angle2 = -M_PI + 2 * M_PI * (j + 0.5) / numCells;
            Vec3 end(1 - cos(angle2), cos(angle1) - sin(angle1) * sin(angle2), sin(angle1) + cos(angle1) * sin(angle2));
            if (getDistance(end, Vec3(0, 1, 0)) >= diameter) {
                probabilities[i / numCells] += 1;
                allowed += 1;
            }
        }
    }
    for (double& probability : probabilities)
        probability /= allowed;
    ASSERT(probabilities[numBins / 2] < 0.8 * probabilities[0]);

    // The chance of a larger value, for 24 degrees of freedom, is 0.001.

    const double criticalValue = 51.18;
    const int numSamples = 40000;
    BeadChain chain(5, diameter / 2);
    auto findBin = [&](Context& context) {
        vector<Vec3> x = getPositions(context);
        return min(numBins - 1, int((getDihedral(x[0], x[1], x[2], x[3]) / (2 * M_PI) + 0.5) * numBins));
    };
    {
        TorsionMonteCarloIntegrator integrator(300);
        integrator.setRandomNumberSeed(11);
        integrator.setTrialsPerStep(12);
        integrator.addTorsionMove(1, M_PI);
        Context context(chain.system, integrator, platform);
        context.setPositions(chain.positions);
        vector<int> counts(numBins, 0);
        for (int i = 0; i < numSamples; i++) {
            integrator.step(1);
            counts[findBin(context)]++;
        }
        ASSERT(Statistics(integrator, 0).clashed > 1000);
        ASSERT_EQUAL(0, Statistics(integrator, 0).rejectedByEnergy);
        ASSERT(computeChiSquared(counts, probabilities) < criticalValue);
    }
    {
        VerletIntegrator integrator(0.001);
        Context context(chain.system, integrator, platform);
        context.setPositions(chain.positions);
        mt19937 random(3);
        uniform_real_distribution<double> uniform(-M_PI, M_PI);
        vector<int> counts(numBins, 0);
        for (int i = 0; i < numSamples; i++) {
            int numAccepted = 0;
            while (numAccepted < 3)
                if (chain.force->proposeTorsions(context, {int(random() % 2)}, {uniform(random)})) {
                    chain.force->acceptProposal(context);
                    numAccepted++;
                }
            counts[findBin(context)]++;
        }
        ASSERT(computeChiSquared(counts, probabilities) > criticalValue);
    }
}

/**
 * Get how many steps to sample with energies. What is sampled does not depend on the platform, but on the CPU platform
 * small molecules take long: its threads wait for each other in each evaluation.
 */
int getSampleSize(const Platform& platform)
{
    return platform.getName() == "Reference" ? 20000 : 1000;
}

void testBoltzmannTorsions(Platform& platform)
{
    // Two torsions in potentials of their own: the mean of cos(angle) is a ratio of Bessel functions.

    const double tolerance = getTolerance(platform);
    const double k = 4;
    BeadChain chain(5, 0);
    CustomTorsionForce* potential = new CustomTorsionForce("k*cos(theta-theta0)");
    potential->addGlobalParameter("k", k);
    potential->addPerTorsionParameter("theta0");
    potential->addTorsion(0, 1, 2, 3, {0.0});
    potential->addTorsion(1, 2, 3, 4, {1.0});
    chain.system.addForce(potential);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(5);
    integrator.setTrialsPerStep(10);
    integrator.addTorsionMove(1, 1.5);
    integrator.addTorsionMove(1, 2.0, {0, 1}, 2);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    const int numSteps = getSampleSize(platform);
    const double wider = sqrt(20000.0 / numSteps);
    double sum1 = 0, sum2 = 0;
    vector<double> angles;
    for (int i = 0; i < numSteps; i++) {
        integrator.step(1);
        integrator.getTorsionAngles(context, angles);
        sum1 += cos(angles[0]);
        sum2 += cos(angles[1] - 1.0);
    }
    double expected = -cyl_bessel_i(1.0, k / THERMAL) / cyl_bessel_i(0.0, k / THERMAL);
    ASSERT_USUALLY_EQUAL_TOL(expected, sum1 / numSteps, 0.02 * wider);
    ASSERT_USUALLY_EQUAL_TOL(expected, sum2 / numSteps, 0.02 * wider);
    ASSERT(Statistics(integrator, 0).rejectedByEnergy > numSteps / 20);
    ASSERT_EQUAL(0, Statistics(integrator, 0).clashed);

    // The energy that the trials ended with is that of the positions.

    State state = context.getState(State::Positions | State::Energy);
    VerletIntegrator verlet(0.001);
    Context other(chain.system, verlet, platform);
    other.setPositions(state.getPositions());
    ASSERT_EQUAL_TOL(other.getState(State::Energy).getPotentialEnergy(), state.getPotentialEnergy(), tolerance);
    for (int i = 0; i < 4; i++)
        ASSERT_EQUAL_TOL(1.0, getDistance(state.getPositions()[i], state.getPositions()[i + 1]), tolerance);
}

void testIntegrationForceGroups(Platform& platform)
{
    // Two strong potentials of one torsion, in groups of their own. Only what is in the integration force groups is
    // sampled from, also if they change: with k cos(angle - theta0) the mean of cos(angle - theta0) is a ratio of
    // Bessel functions, and that of the sine is 0. The sum of both is such a potential, too.

    const double k = 6, theta1 = -0.5, theta2 = 1.5;
    BeadChain chain(4, 0);
    for (int group : {1, 2}) {
        CustomTorsionForce* potential = new CustomTorsionForce("k*cos(theta-theta0)");
        potential->addPerTorsionParameter("k");
        potential->addPerTorsionParameter("theta0");
        potential->addTorsion(0, 1, 2, 3, {k, group == 1 ? theta1 : theta2});
        potential->setForceGroup(group);
        chain.system.addForce(potential);
    }
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(5);
    integrator.setTrialsPerStep(10);
    integrator.addTorsionMove(1, 2.5);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    const int numSteps = getSampleSize(platform);
    const double error = 0.025 * sqrt(20000.0 / numSteps);
    auto check = [&](int groups, double strength, double theta0) {
        integrator.setIntegrationForceGroups(groups);
        integrator.step(20);
        integrator.resetMoveStatistics();
        double cosines = 0, sines = 0;
        vector<double> angles;
        for (int i = 0; i < numSteps; i++) {
            integrator.step(1);
            integrator.getTorsionAngles(context, angles);
            cosines += cos(angles[0] - theta0) / numSteps;
            sines += sin(angles[0] - theta0) / numSteps;
        }
        double expected = -cyl_bessel_i(1.0, strength / THERMAL) / cyl_bessel_i(0.0, strength / THERMAL);
        ASSERT_USUALLY_EQUAL_TOL(expected, cosines, error);
        ASSERT_USUALLY_EQUAL_TOL(0, sines, error);
        ASSERT_EQUAL(strength > 0, Statistics(integrator, 0).rejectedByEnergy > 0);
    };
    check(1 << 1, k, theta1);
    check(1 << 2, k, theta2);
    check(1 << 1 | 1 << 2, 2 * k * cos((theta2 - theta1) / 2), (theta1 + theta2) / 2);
    check(1 << 3, 0, 0);
    check(~(1 << 2), k, theta1);
}

void testBoltzmannRigidBody(Platform& platform)
{
    // A rigid rod in a harmonic well, with a pull on one end: <c^2> = 3 kT / (2 K), and <cos> is Langevin's function.

    const double tolerance = getTolerance(platform);
    const double k = 50, pull = 6;
    System system;
    StericExclusionForce* force = new StericExclusionForce();
    CustomExternalForce* potential = new CustomExternalForce("0.5*k*(x^2+y^2+z^2)-f*z");
    potential->addGlobalParameter("k", k);
    potential->addPerParticleParameter("f");
    for (int i = 0; i < 2; i++) {
        system.addParticle(1);
        force->addParticle(0);
        potential->addParticle(i, {i == 0 ? -pull : pull});
    }
    force->addBond(0, 1);
    system.addForce(force);
    system.addForce(potential);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(9);
    integrator.setTrialsPerStep(10);
    integrator.addRigidBodyMove(1, 0.5, 1.5);
    Context context(system, integrator, platform);
    context.setPositions({Vec3(0, 0, 0), Vec3(0.5, 0, 0)});
    const int numSteps = getSampleSize(platform);
    const double wider = sqrt(20000.0 / numSteps);
    double squares = 0, cosines = 0;
    for (int i = 0; i < numSteps; i++) {
        integrator.step(1);
        vector<Vec3> x = getPositions(context);
        Vec3 center = (x[0] + x[1]) * 0.5;
        squares += center.dot(center);
        cosines += (x[1] - x[0])[2] / 0.5;
        ASSERT_EQUAL_TOL(0.5, getDistance(x[0], x[1]), tolerance);
    }
    double a = pull * 0.5 / THERMAL;
    ASSERT_USUALLY_EQUAL_TOL(3 * THERMAL / (2 * k), squares / numSteps, 0.002 * wider);
    ASSERT_USUALLY_EQUAL_TOL(1 / tanh(a) - 1 / a, cosines / numSteps, 0.01 * wider);
}

void testHardSpheresInWell(Platform& platform)
{
    // Two hard spheres, each in the same harmonic well: their distance r has the density r^2 exp(-k r^2 / 4 kT) beyond
    // their diameter.

    const double tolerance = getTolerance(platform);
    const double k = 20, diameter = 0.8;
    System system;
    StericExclusionForce* force = new StericExclusionForce();
    force->setOverlapTolerance(0);
    CustomExternalForce* potential = new CustomExternalForce("0.5*k*(x^2+y^2+z^2)");
    potential->addGlobalParameter("k", k);
    for (int i = 0; i < 2; i++) {
        system.addParticle(1);
        force->addParticle(diameter / 2);
        potential->addParticle(i);
    }
    system.addForce(force);
    system.addForce(potential);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(2);
    integrator.setTrialsPerStep(10);
    integrator.addRigidBodyMove(1, 0.6, 0);
    Context context(system, integrator, platform);
    context.setPositions({Vec3(-0.5, 0, 0), Vec3(0.5, 0, 0)});
    const int numSteps = getSampleSize(platform);
    const double wider = sqrt(20000.0 / numSteps);
    double mean = 0;
    for (int i = 0; i < numSteps; i++) {
        integrator.step(1);
        vector<Vec3> x = getPositions(context);
        double distance = getDistance(x[0], x[1]);
        ASSERT(distance > diameter - 1e-8 - tolerance);
        mean += distance / numSteps;
    }
    double weights = 0, expected = 0;
    for (double r = diameter; r < 4; r += 1e-4) {
        double weight = r * r * exp(-k * r * r / (4 * THERMAL));
        weights += weight;
        expected += weight * r;
    }
    ASSERT_USUALLY_EQUAL_TOL(expected / weights, mean, 0.01 * wider);
    Statistics statistics(integrator, 0);
    ASSERT(statistics.clashed > numSteps / 20);
    ASSERT(statistics.rejectedByEnergy > numSteps / 20);
    ASSERT(statistics.accepted > numSteps / 20);
}

/**
 * Two spheres, each in the same harmonic well, that repel each other softly: their distance r has the density
 * r^2 exp(-(k r^2 / 4 + E(r)) / kT).
 */
class SoftPair {
public:
    SoftPair() : force(new StericExclusionForce())
    {
        force->setOverlapTolerance(tolerance);
        force->setForceConstant(stiffness);
        force->setForceGroup(3);
        CustomExternalForce* well = new CustomExternalForce("0.5*k*(x^2+y^2+z^2)");
        well->addGlobalParameter("k", k);
        for (int i = 0; i < 2; i++) {
            system.addParticle(1);
            force->addParticle(0.5 * diameter);
            well->addParticle(i);
        }
        system.addForce(force);
        system.addForce(well);
    }
    static double getMeanDistance(bool soft)
    {
        double weights = 0, expected = 0;
        for (double r = 1e-4; r < 4; r += 1e-4) {
            double excess = max(0.0, diameter - r - tolerance);
            double steric = soft ? 0.5 * stiffness * excess * excess : excess > 0 ? 1e10 : 0;
            double weight = r * r * exp(-(k * r * r / 4 + steric) / THERMAL);
            weights += weight;
            expected += weight * r;
        }
        return expected / weights;
    }
    static constexpr double k = 20, diameter = 0.9, tolerance = 0.1, stiffness = 300;
    System system;
    StericExclusionForce* force;
    vector<Vec3> positions = {Vec3(-0.5, 0, 0), Vec3(0.5, 0, 0)};
};

void testSoftSpheres(Platform& platform)
{
    // Monte Carlo alone, and in turns with dynamics, samples with the energy of the spheres, though its group is not
    // among those of the sampler.

    const double expected = SoftPair::getMeanDistance(true);
    const int numSteps = getSampleSize(platform);
    const double error = 0.01 * sqrt(20000.0 / numSteps);
    ASSERT(SoftPair::getMeanDistance(false) > expected + 0.04);
    for (bool withDynamics : {false, true}) {
        SoftPair pair;
        CompoundIntegrator compound;
        TorsionMonteCarloIntegrator* sampler = new TorsionMonteCarloIntegrator(300);
        ASSERT(sampler->getStericMode() == TorsionMonteCarloIntegrator::Automatic);
        sampler->setStericMode(TorsionMonteCarloIntegrator::Soft);
        ASSERT(sampler->getStericMode() == TorsionMonteCarloIntegrator::Soft);
        sampler->setRandomNumberSeed(2);
        sampler->setTrialsPerStep(5);
        sampler->setIntegrationForceGroups(1);
        sampler->addRigidBodyMove(1, 0.6, 0);
        LangevinMiddleIntegrator* dynamics = new LangevinMiddleIntegrator(300, 5, 0.004);
        dynamics->setRandomNumberSeed(7);
        compound.addIntegrator(sampler);
        compound.addIntegrator(dynamics);
        Context context(pair.system, compound, platform);
        context.setPositions(pair.positions);
        context.setVelocitiesToTemperature(300, 1);
        double mean = 0;
        for (int i = 0; i < numSteps; i++) {
            compound.setCurrentIntegrator(0);
            compound.step(1);
            if (withDynamics) {
                compound.setCurrentIntegrator(1);
                compound.step(5);
            }
            vector<Vec3> x = getPositions(context);
            mean += getDistance(x[0], x[1]) / numSteps;
        }
        ASSERT_USUALLY_EQUAL_TOL(expected, mean, error);
        Statistics statistics(*sampler, 0);
        ASSERT_EQUAL(0, statistics.clashed);
        ASSERT(statistics.rejectedByEnergy > numSteps / 2);
        ASSERT_EQUAL(0, sampler->getNumToleratedClashes(context));
    }
}

void testSampledDistributions(Platform& platform)
{
    if (getPrecision(platform) == "double") // It takes long, and precision is nothing to it.
        testHardBeads(platform);
    testBoltzmannTorsions(platform);
    testIntegrationForceGroups(platform);
    testBoltzmannRigidBody(platform);
    testHardSpheresInWell(platform);
    testSoftSpheres(platform);
}
