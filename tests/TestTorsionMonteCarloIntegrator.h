/**
 * This tests TorsionMonteCarloIntegrator on one platform: what it samples, its moves, limits, life beside other
 * integrators, and bad input.
 */

#include "openmm/AndersenThermostat.h"
#include "openmm/CMMotionRemover.h"
#include "openmm/CompoundIntegrator.h"
#include "openmm/CustomExternalForce.h"
#include "openmm/CustomTorsionForce.h"
#include "openmm/internal/ContextImpl.h"
#include "openmm/internal/ForceImpl.h"
#include "openmm/LangevinMiddleIntegrator.h"
#include "openmm/LocalEnergyMinimizer.h"
#include "openmm/MonteCarloAnisotropicBarostat.h"
#include "openmm/MonteCarloBarostat.h"
#include "openmm/MonteCarloFlexibleBarostat.h"
#include "openmm/MonteCarloMembraneBarostat.h"
#include "openmm/NonbondedForce.h"
#include "openmm/VerletIntegrator.h"
#include "openmm/VirtualSite.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "TestSupport.h"
#include <limits>
#include <random>
#include <set>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/** The energy of thermal motion at 300 K, in kJ/mol. */
const double THERMAL = 0.00831446261815324 * 300;

class Statistics {
public:
    Statistics(const TorsionMonteCarloIntegrator& integrator, int move)
    {
        integrator.getMoveStatistics(move, attempted, clashed, rejectedByEnergy, accepted);
        ASSERT_EQUAL(attempted, clashed + rejectedByEnergy + accepted);
    }
    long long attempted, clashed, rejectedByEnergy, accepted;
};

// ---- What is sampled ----

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
        ASSERT(sampler->getStericMode() == TorsionMonteCarloIntegrator::Hard);
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

/**
 * The energy of the soft spheres is what a trial changes of it, whatever moves, with all kinds of pairs: at a
 * temperature of 0 it never rises, and it is the only thing that is asked.
 */
void testSoftEnergy(Platform& platform)
{
    BeadChain chain(20, 0.7, 0.6);
    chain.addMolecule(6, 0.6, 0.4, Vec3(1, 1, 1));
    chain.force->setParticleParameters(4, 0);
    chain.force->setParticleParameters(2, 0.8, StericExclusionForce::Donor);
    chain.force->setParticleParameters(9, 0.8, StericExclusionForce::Acceptor);
    chain.force->setParticleParameters(12, 0.8, StericExclusionForce::DonorAndAcceptor);
    chain.force->setOverlapTolerance(0.02);
    TorsionMonteCarloIntegrator integrator(0);
    integrator.setStericMode(TorsionMonteCarloIntegrator::Soft);
    integrator.setRandomNumberSeed(1);
    integrator.setTrialsPerStep(1);
    integrator.addTorsionMove(2, 0.2, {}, 2);
    integrator.addRigidBodyMove(1, 0.1, 0.1);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    auto getEnergy = [&] {
        return context.getState(State::Energy).getPotentialEnergy();
    };
    const double start = getEnergy();
    double before = start;
    for (int i = 0; i < 2000; i++) {
        integrator.step(1);
        double after = getEnergy();
        ASSERT(after <= before + start * getTolerance(platform));
        before = after;
    }
    ASSERT(before < 0.2 * start);

    // Hard trials that follow start limits anew, from what is left.

    vector<pair<int, int>> pairs;
    vector<double> overlaps;
    context.setPositions(chain.positions);
    integrator.step(1);
    chain.force->getClashes(context, pairs, overlaps);
    ASSERT(pairs.size() > 3);
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));
    integrator.setStericMode(TorsionMonteCarloIntegrator::Hard);
    integrator.step(1);
    ASSERT_EQUAL(pairs.size(), integrator.getNumToleratedClashes(context));
    integrator.setStericMode(TorsionMonteCarloIntegrator::Soft);
    integrator.setInitialClashPolicy(TorsionMonteCarloIntegrator::Refuse);
    integrator.step(1);
    integrator.setStericMode(TorsionMonteCarloIntegrator::Hard);
    assertThrows("clash when sampling starts", [&] {
        integrator.step(1);
    });
}

void testStericEnergyIsLeftOut(Platform& platform)
{
    // A tolerated clash has a large energy in the force group of another force, and yet none of it enters U.

    const double tolerance = getTolerance(platform);
    BeadChain chain(4, 0.7, 0.5);
    chain.force->setForceConstant(1e6);
    CustomExternalForce* nothing = new CustomExternalForce("0");
    nothing->addParticle(0);
    chain.system.addForce(nothing);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(1);
    integrator.addTorsionMove(1, 0.5);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    double energy = context.getState(State::Energy).getPotentialEnergy();
    ASSERT(energy > 100);
    integrator.step(20);
    Statistics statistics(integrator, 0);
    ASSERT(statistics.accepted > 1000 && statistics.clashed > 20);
    ASSERT_EQUAL(0, statistics.rejectedByEnergy);

    // When trials are over, it is back.

    context.setPositions(chain.positions);
    ASSERT_EQUAL_TOL(energy, context.getState(State::Energy).getPotentialEnergy(), tolerance);
}

/**
 * Counts how often positions reach the Context, as a member of a CompoundIntegrator.
 */
class PositionCounter : public Integrator {
public:
    int numChanges = 0;
    void step(int)
    {
    }

protected:
    void initialize(ContextImpl&)
    {
    }
    vector<string> getKernelNames()
    {
        return {};
    }
    void stateChanged(State::DataType changed)
    {
        if (changed == State::Positions)
            numChanges++;
    }
    double computeKineticEnergy()
    {
        return 0;
    }
};

void testUploads(Platform& platform)
{
    // In athermal sampling positions reach the Context once a step, else once more for each trial without a clash.

    BeadChain chain(6, 0.45);
    chain.system.addForce(new CMMotionRemover());
    chain.system.addForce(new AndersenThermostat(300, 1));
    CustomExternalForce* field = new CustomExternalForce("x");
    field->addParticle(5);
    field->setForceGroup(1);
    chain.system.addForce(field);
    TorsionMonteCarloIntegrator* integrator = new TorsionMonteCarloIntegrator(300);
    integrator->addTorsionMove(1, M_PI);
    integrator->setIntegrationForceGroups(1);
    PositionCounter* counter = new PositionCounter();
    CompoundIntegrator compound;
    compound.addIntegrator(integrator);
    compound.addIntegrator(counter);
    Context context(chain.system, compound, platform);
    context.setPositions(chain.positions);
    counter->numChanges = 0;
    compound.step(5);
    ASSERT_EQUAL(5, counter->numChanges);
    integrator->setIntegrationForceGroups(3);
    integrator->resetMoveStatistics();
    counter->numChanges = 0;
    compound.step(5);
    Statistics statistics(*integrator, 0);
    ASSERT(statistics.clashed > 0);
    ASSERT_EQUAL(5 + statistics.accepted + statistics.rejectedByEnergy, counter->numChanges);
}

void testAthermal(Platform& platform)
{
    // A CMMotionRemover has no energy, and neither has what is outside the integration force groups.

    BeadChain chain(6, 0.3);
    chain.system.addForce(new CMMotionRemover());
    CustomExternalForce* trap = new CustomExternalForce("1e6*(x^2+y^2+z^2)");
    for (int i = 0; i < 6; i++)
        trap->addParticle(i);
    trap->setForceGroup(4);
    chain.system.addForce(trap);
    TorsionMonteCarloIntegrator integrator(0);
    integrator.addTorsionMove(1, M_PI);
    integrator.setIntegrationForceGroups(~(1 << 4));
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    integrator.step(5);
    ASSERT_EQUAL(0, Statistics(integrator, 0).rejectedByEnergy);
    ASSERT(Statistics(integrator, 0).accepted > 0);

    // Inside them, at a temperature of 0, the energy can only go down.

    integrator.setIntegrationForceGroups(-1);
    double before = context.getState(State::Energy, false, 1 << 4).getPotentialEnergy();
    for (int i = 0; i < 5; i++) {
        integrator.step(1);
        double after = context.getState(State::Energy, false, 1 << 4).getPotentialEnergy();
        ASSERT(after <= before);
        before = after;
    }
    ASSERT(Statistics(integrator, 0).rejectedByEnergy > 0);
}

/**
 * A force that says what its energy is.
 */
class Probe : public Force {
public:
    bool usesPeriodicBoundaryConditions() const
    {
        return false;
    }
    /** Called for each evaluation with the Context's positions. */
    function<double(const vector<Vec3>&)> energy;

protected:
    ForceImpl* createImpl() const;
};

class ProbeImpl : public ForceImpl {
public:
    explicit ProbeImpl(const Probe& owner) : owner(owner)
    {
    }
    void initialize(ContextImpl&)
    {
    }
    const Probe& getOwner() const
    {
        return owner;
    }
    void updateContextState(ContextImpl&, bool&)
    {
    }
    double calcForcesAndEnergy(ContextImpl& context, bool, bool, int groups)
    {
        if ((groups & (1 << owner.getForceGroup())) == 0)
            return 0;
        vector<Vec3> positions;
        context.getPositions(positions);
        return owner.energy(positions);
    }
    map<string, double> getDefaultParameters()
    {
        return {};
    }
    vector<string> getKernelNames()
    {
        return {};
    }

private:
    const Probe& owner;
};

ForceImpl* Probe::createImpl() const
{
    return new ProbeImpl(*this);
}

/**
 * Other forces see each trial as it is accepted, to the last bit, though only what moves is handed to them.
 */
void testPositionsOfTrials(Platform& platform)
{
    for (bool withSites : {false, true}) {
        BeadChain chain(40, 0.3);
        chain.addMolecule(5, 0.3, 1.0, Vec3(0, 0, 3));
        chain.addMolecule(1, 0.3, 1.0, Vec3(0, 0, 5));
        chain.force->setParticleParameters(30, 0);
        if (withSites) {
            chain.system.addParticle(0);
            chain.force->addParticle(0);
            chain.system.setVirtualSite(46, new TwoParticleAverageSite(38, 39, 0.5, 0.5));
            chain.positions.push_back(Vec3());
        }
        Probe* probe = new Probe();
        vector<Vec3> seen;
        probe->energy = [&](const vector<Vec3>& positions) {
            seen = positions;
            return 2 * cos(9 * positions[39][1]); // now and then it refuses a trial
        };
        chain.system.addForce(probe);
        TorsionMonteCarloIntegrator integrator(300);
        integrator.setRandomNumberSeed(1);
        integrator.setTrialsPerStep(1);
        integrator.addTorsionMove(2, 0.3);
        integrator.addTorsionMove(1, 0.3, {}, 3);
        integrator.addRigidBodyMove(1, 0.1, 0.3);
        Context context(chain.system, integrator, platform);
        context.setPositions(chain.positions);
        int numRejected = 0;
        for (int i = 0; i < 300; i++) {
            auto count = [&] {
                long long sum = 0;
                for (int move = 0; move < 3; move++)
                    sum += Statistics(integrator, move).accepted;
                return sum;
            };
            long long before = count();
            integrator.step(1);
            if (count() > before)
                assertSameBits(getPositions(context), seen);
            else
                numRejected++;
            if (i == 100)
                context.setPositions(chain.positions);
            if (i == 200) { // the engine begins anew
                chain.force->setParticleParameters(3, 0.29);
                chain.force->updateParametersInContext(context);
            }
        }
        ASSERT(numRejected > 20 && numRejected < 200);
    }
}

/**
 * What counts as energy is settled when the Context is made, whatever becomes of the System.
 */
void testEnergyIsSettled(Platform& platform)
{
    auto sample = [&](const function<void(System&)>& change) {
        BeadChain chain(6, 0.3);
        CustomTorsionForce* potential = new CustomTorsionForce("20*cos(theta)");
        for (int i = 0; i < 3; i++)
            potential->addTorsion(i, i + 1, i + 2, i + 3, {});
        chain.system.addForce(potential);
        TorsionMonteCarloIntegrator integrator(300);
        integrator.setRandomNumberSeed(3);
        integrator.addTorsionMove(1, 1);
        integrator.setIntegrationForceGroups(1);
        Context context(chain.system, integrator, platform);
        context.setPositions(chain.positions);
        change(chain.system);
        integrator.step(5);
        ASSERT(Statistics(integrator, 0).rejectedByEnergy > 100);
        return getPositions(context);
    };
    vector<Vec3> unchanged = sample([](System&) {
    });
    assertSameBits(unchanged, sample([](System& system) {
                       system.getForce(1).setForceGroup(1);
                   }));
    assertSameBits(unchanged, sample([](System& system) {
                       system.removeForce(1);
                   }));
    assertSameBits(unchanged, sample([](System& system) {
                       system.addForce(new CustomExternalForce("x"));
                   }));

    // The reciprocal space of a NonbondedForce has a group of its own.

    BeadChain chain(6, 0.1);
    NonbondedForce* nonbonded = new NonbondedForce();
    nonbonded->setNonbondedMethod(NonbondedForce::Ewald);
    nonbonded->setReciprocalSpaceForceGroup(2);
    nonbonded->setCutoffDistance(2);
    for (int i = 0; i < 6; i++)
        nonbonded->addParticle(i % 2 == 0 ? 2 : -2, 0.1, 0);
    chain.system.setDefaultPeriodicBoxVectors(Vec3(9, 0, 0), Vec3(0, 9, 0), Vec3(0, 0, 9));
    chain.system.addForce(nonbonded);
    TorsionMonteCarloIntegrator integrator(30);
    integrator.addTorsionMove(1, 3);
    integrator.setIntegrationForceGroups(1 << 2);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    integrator.step(1);
    ASSERT(Statistics(integrator, 0).rejectedByEnergy > 0);
}

// ---- Moves ----

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

// ---- Steps ----

void testSteps(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    BeadChain chain(6, 0.3);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addTorsionMove(1, 0.5);
    ASSERT_EQUAL(100, integrator.getTrialsPerStep());
    ASSERT_EQUAL(0, integrator.getStepSize());
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    vector<Vec3> velocities(6, Vec3(1, 2, 3));
    context.setVelocities(velocities);
    integrator.step(3);
    ASSERT_EQUAL(300, Statistics(integrator, 0).attempted);
    ASSERT_EQUAL(3, context.getStepCount());
    ASSERT_EQUAL(0, context.getTime());
    integrator.setTrialsPerStep(7);
    integrator.setStepSize(0.5);
    integrator.step(2);
    ASSERT_EQUAL(314, Statistics(integrator, 0).attempted);
    ASSERT_EQUAL(5, context.getStepCount());
    ASSERT_EQUAL_TOL(1.0, context.getTime(), 1e-12);

    // Velocities are left alone.

    State state = context.getState(State::Velocities | State::Energy);
    assertSameBits(velocities, state.getVelocities());
    ASSERT_EQUAL_TOL(6 * 0.5 * 14, state.getKineticEnergy(), tolerance);
    ASSERT(getDistance(chain.positions[5], getPositions(context)[5]) > 1e-3);
}

void testSeeds(Platform& platform)
{
    BeadChain chain(20, 0.45);
    int other = chain.addMolecule(5, 0.45, 1.0, Vec3(0, 0, 2));
    ASSERT_EQUAL(20, other);
    CustomExternalForce* trap = new CustomExternalForce("x^2+y^2+z^2");
    for (int i = 0; i < 25; i++)
        trap->addParticle(i);
    trap->setForceGroup(1);
    chain.system.addForce(trap);
    auto sample = [&](int seed, int groups) {
        TorsionMonteCarloIntegrator integrator(300);
        integrator.setRandomNumberSeed(seed);
        ASSERT_EQUAL(seed, integrator.getRandomNumberSeed());
        integrator.addTorsionMove(1, 0.5, {}, 2);
        integrator.addRigidBodyMove(1, 0.1, 0.1);
        integrator.setIntegrationForceGroups(groups);
        Context context(chain.system, integrator, platform);
        context.setPositions(chain.positions);
        integrator.step(10);
        return getPositions(context);
    };
    for (int groups : {1, 3}) {
        vector<Vec3> first = sample(17, groups);
        assertSameBits(first, sample(17, groups));
        ASSERT(!(first == sample(18, groups)));
        ASSERT(!(sample(0, groups) == sample(0, groups)));
    }
}

void testTorsionAngles(Platform& platform)
{
    const double tolerance = getTolerance(platform);
    BeadChain chain(6, 0.4, 2.5);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addTorsionMove(1, M_PI);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    vector<double> angles;
    integrator.getTorsionAngles(context, angles);
    ASSERT_EQUAL(3, angles.size());
    for (double angle : angles)
        ASSERT_EQUAL_TOL(2.5, angle, tolerance);
    assertRounded(platform, chain.positions, getPositions(context));

    // Setting what is there already changes nothing, not even a bit.

    integrator.step(1);
    vector<Vec3> before = getPositions(context);
    integrator.getTorsionAngles(context, angles);
    integrator.setTorsionAngles(context, angles);
    assertSameBits(before, getPositions(context));
    for (int i = 0; i < 3; i++)
        ASSERT_EQUAL_TOL(getDihedral(before[i], before[i + 1], before[i + 2], before[i + 3]), angles[i], tolerance);

    // Other angles are reached, clashing or not: all cis closes a ring of four beads.

    integrator.setTorsionAngles(context, {0.5, -3.0, 2 * M_PI + 1});
    vector<Vec3> x = getPositions(context);
    const double expected[] = {0.5, -3.0, 1.0};
    integrator.getTorsionAngles(context, angles);
    for (int i = 0; i < 3; i++) {
        ASSERT_EQUAL_TOL(expected[i], getDihedral(x[i], x[i + 1], x[i + 2], x[i + 3]), tolerance);
        ASSERT_EQUAL_TOL(expected[i], angles[i], tolerance);
    }
    integrator.setTorsionAngles(context, {0, 0, 0});
    ASSERT(chain.force->hasClash(context));
    ASSERT_EQUAL_VEC(getPositions(context)[0], getPositions(context)[4], tolerance);

    // A straight torsion turns, but has no value.

    vector<Vec3> straight = chain.positions;
    straight[0] = straight[1] + (straight[1] - straight[2]);
    context.setPositions(straight);
    assertThrows("torsion 0 has no value: the dihedral of particles 0, 1, 2 and 3 is undefined", [&] {
        integrator.getTorsionAngles(context, angles);
    });
    assertThrows("torsion 0 has no value", [&] {
        integrator.setTorsionAngles(context, {1, 1, 1});
    });
    assertRounded(platform, straight, getPositions(context));
    integrator.step(1);
    ASSERT(Statistics(integrator, 0).accepted > 0);

    assertThrows("was given 2 angles, but there are 3 torsions", [&] {
        integrator.setTorsionAngles(context, {0, 0});
    });
    assertThrows("the angle of torsion 1 is not finite", [&] {
        integrator.setTorsionAngles(context, {0, numeric_limits<double>::infinity(), 0});
    });
}

void testFixedAndVirtual(Platform& platform)
{
    // Bead 2 is fixed, and a virtual site hangs on the last bond.

    const double tolerance = getTolerance(platform);
    BeadChain chain(8, 0.3);
    chain.system.setParticleMass(2, 0);
    chain.system.addParticle(0);
    chain.force->addParticle(0.2);
    chain.system.setVirtualSite(8, new TwoParticleAverageSite(6, 7, 0.5, 0.5));
    for (int i : {4, 5, 6, 7})
        chain.force->addExclusion(i, 8);
    chain.positions.push_back(Vec3());
    CustomExternalForce* field = new CustomExternalForce("x");
    field->addParticle(8);
    chain.system.addForce(field);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addTorsionMove(1, 0.5);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    for (int i = 0; i < 20; i++) {
        integrator.step(1);
        vector<Vec3> x = getPositions(context);
        assertRounded(platform, {chain.positions[2]}, {x[2]});
        ASSERT_EQUAL_VEC((x[6] + x[7]) * 0.5, x[8], tolerance);
        ASSERT(!chain.force->hasClash(context));
    }
    ASSERT(Statistics(integrator, 0).accepted > 100);
    assertThrows("all molecules have fixed particles", [&] {
        integrator.addRigidBodyMove(1, 0.1, 0.1);
    });
}

// ---- Limits ----

void testLimits(Platform& platform)
{
    // Beads 0 and 3 of radius 0.7 clash up to a dihedral of 1.02.

    const double tolerance = getTolerance(platform);
    BeadChain chain(4, 0.7, 0.5);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(8);
    integrator.addTorsionMove(1, 0.2);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));
    auto assertNotBeyond = [&](double dihedral) {
        vector<double> angles;
        for (int i = 0; i < 50; i++) {
            integrator.step(1);
            integrator.getTorsionAngles(context, angles);
            ASSERT(fabs(angles[0]) >= dihedral - 1e-8 - tolerance);
        }
    };
    assertNotBeyond(0.5);
    ASSERT_EQUAL(1, integrator.getNumToleratedClashes(context));

    // Positions that the user sets start limits anew, even if they are the same; so does setTorsionAngles().

    context.setPositions(BeadChain(4, 0.7, 0.7).positions);
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));
    assertNotBeyond(0.7);
    integrator.setTorsionAngles(context, {0.9});
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));
    assertNotBeyond(0.9);
    integrator.setTorsionAngles(context, {0.3});
    assertNotBeyond(0.3);
    integrator.setTorsionAngles(context, {2.5});
    integrator.step(1);
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));
    context.setPositions(getPositions(context));
    integrator.step(1);
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));

    // An accepted proposal does not start them anew.

    context.setPositions(chain.positions);
    ASSERT(chain.force->proposeTorsions(context, {0}, {0.4}));
    chain.force->acceptProposal(context);
    ASSERT_EQUAL(1, integrator.getNumToleratedClashes(context));
    ASSERT(chain.force->proposeTorsions(context, {0}, {-0.4}));
    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.41}));

    // One that clashes does, like setTorsionAngles(): limits start from there.

    ASSERT(!chain.force->proposeTorsions(context, {0}, {-0.6}));
    chain.force->acceptProposal(context);
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));
    assertNotBeyond(0.3);
    ASSERT_EQUAL(1, integrator.getNumToleratedClashes(context));
    integrator.setTorsionAngles(context, {2.5});
    ASSERT(!chain.force->proposeTorsions(context, {0}, {-2.2}));
    chain.force->acceptProposal(context);
    integrator.setInitialClashPolicy(TorsionMonteCarloIntegrator::Refuse);
    assertThrows("particles 0 and 3 clash when sampling starts", [&] {
        integrator.step(1);
    });
    integrator.setInitialClashPolicy(TorsionMonteCarloIntegrator::Tolerate);

    // Whoever wants to starts them anew.

    integrator.setTorsionAngles(context, {0.4});
    ASSERT(chain.force->proposeTorsions(context, {0}, {0.4}));
    chain.force->acceptProposal(context);
    ASSERT_EQUAL(1, integrator.getNumToleratedClashes(context));
    chain.force->restartLimits(context);
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));
    assertNotBeyond(0.8);

    // A step drops an open proposal.

    ASSERT(chain.force->proposeTorsions(context, {0}, {0}));
    integrator.step(1);
    assertThrows("there is no open proposal", [&] {
        chain.force->acceptProposal(context);
    });
}

void testRefusedClashes(Platform& platform)
{
    BeadChain chain(4, 0.7, 0.5);
    chain.addMolecule(4, 0.7, 0.5, Vec3(0, 0, 5));
    TorsionMonteCarloIntegrator integrator(300);
    ASSERT(integrator.getInitialClashPolicy() == TorsionMonteCarloIntegrator::Tolerate);
    integrator.setInitialClashPolicy(TorsionMonteCarloIntegrator::Refuse);
    ASSERT(integrator.getInitialClashPolicy() == TorsionMonteCarloIntegrator::Refuse);
    integrator.addTorsionMove(1, 0.2);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    const string message = "particles 0 and 3 clash when sampling starts, by an overlap of 0.284";
    assertThrows(message, [&] {
        integrator.step(1);
    });
    assertThrows("they are the first of 2 such pairs", [&] {
        integrator.step(1);
    });
    assertRounded(platform, chain.positions, getPositions(context));
    ASSERT_EQUAL(0, context.getStepCount());
    integrator.setTorsionAngles(context, {2.5, 2.5});
    integrator.step(10);
    ASSERT_EQUAL(10, context.getStepCount());
    integrator.setTorsionAngles(context, {0.5, 2.5});
    assertThrows(message, [&] {
        integrator.step(1);
    });
    integrator.setInitialClashPolicy(TorsionMonteCarloIntegrator::Tolerate);
    integrator.step(1);
    ASSERT_EQUAL(1, integrator.getNumToleratedClashes(context));
}

void testCompoundIntegrator(Platform& platform)
{
    // Spheres 0 and 1 clash from the start. Dynamics pulls 2 and 3 into each other; the steric force is too weak to
    // matter.

    const double tolerance = getTolerance(platform);
    System system;
    StericExclusionForce* force = new StericExclusionForce();
    force->setForceConstant(0);
    system.addForce(force);
    CustomExternalForce* pull = new CustomExternalForce("1000*(x-10)^2");
    pull->setForceGroup(1);
    system.addForce(pull);
    for (int i = 0; i < 4; i++) {
        system.addParticle(1);
        force->addParticle(0.5);
    }
    pull->addParticle(2);
    pull->addParticle(3);
    CompoundIntegrator compound;
    TorsionMonteCarloIntegrator* integrator = new TorsionMonteCarloIntegrator(300);
    integrator->setRandomNumberSeed(3);
    compound.addIntegrator(integrator);
    compound.addIntegrator(new LangevinMiddleIntegrator(1, 10, 0.002));
    integrator->addRigidBodyMove(1, 0.05, 0);
    integrator->setIntegrationForceGroups(1);
    Context context(system, compound, platform);
    context.setPositions({Vec3(0, 0, 0), Vec3(0.9, 0, 0), Vec3(8, 0, 0), Vec3(12, 0, 0)});
    compound.step(2);
    ASSERT_EQUAL(1, integrator->getNumToleratedClashes(context));
    assertThrows("there is no open proposal", [&] {
        force->acceptProposal(context);
    });
    compound.setCurrentIntegrator(1);
    compound.step(2000);
    compound.setCurrentIntegrator(0);
    ASSERT_EQUAL(1, integrator->getNumToleratedClashes(context));
    compound.step(1);
    ASSERT_EQUAL(2, integrator->getNumToleratedClashes(context));
    vector<Vec3> x = getPositions(context);
    double nearest = getDistance(x[2], x[3]);
    ASSERT(nearest < 0.9);

    // Limits that grew stay: the second pair may come as near as it was, whatever the first does.

    compound.step(20);
    ASSERT_EQUAL(2, integrator->getNumToleratedClashes(context));
    x = getPositions(context);
    ASSERT(getDistance(x[0], x[1]) > 0.9 - 1e-8 - tolerance);
    ASSERT_EQUAL(2023, context.getStepCount());
    context.setPositions({Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(8, 0, 0), Vec3(12, 0, 0)});
    compound.step(1);
    ASSERT_EQUAL(0, integrator->getNumToleratedClashes(context));
}

void testMinimization(Platform& platform)
{
    // The minimizer sets positions as a user does: what it leaves is where limits start.

    BeadChain chain(4, 0.7, 0.5);
    chain.addMolecule(1, 0.5, 0, chain.positions[0] + Vec3(0, 0.1, 0));
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addTorsionMove(1, 0.5);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    integrator.step(1);
    ASSERT(integrator.getNumToleratedClashes(context) > 1);
    double before = context.getState(State::Energy).getPotentialEnergy();
    chain.force->setOverlapTolerance(0.001);
    chain.force->updateParametersInContext(context);
    LocalEnergyMinimizer::minimize(context, 0.01);
    ASSERT(context.getState(State::Energy).getPotentialEnergy() < 1e-3 * before);
    chain.force->setOverlapTolerance(0.01);
    chain.force->updateParametersInContext(context);
    ASSERT(!chain.force->hasClash(context));
    integrator.step(1);
    ASSERT_EQUAL(0, integrator.getNumToleratedClashes(context));
}

// ---- Bad input ----

void testBadEnergy(Platform& platform)
{
    // The energy of a lone particle is not a number beyond x = 1.

    System system;
    StericExclusionForce* force = new StericExclusionForce();
    CustomExternalForce* cliff = new CustomExternalForce("sqrt(1-x)+20*(x-1)^2");
    system.addParticle(1);
    force->addParticle(0.1);
    cliff->addParticle(0);
    system.addForce(force);
    system.addForce(cliff);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(1);
    integrator.addRigidBodyMove(1, 0.2, 0);
    Context context(system, integrator, platform);
    context.setPositions({Vec3(0.5, 0, 0)});
    integrator.setTrialsPerStep(10);
    double largest = 0;
    for (int i = 0; i < 2000; i++) {
        integrator.step(1);
        State now = context.getState(State::Positions | State::Energy);
        ASSERT(now.getPositions()[0][0] <= 1);
        ASSERT(now.getPotentialEnergy() >= 0);
        largest = max(largest, now.getPositions()[0][0]);
    }
    ASSERT(largest > 0.9);
    ASSERT(Statistics(integrator, 0).rejectedByEnergy > 1000);
    ASSERT_EQUAL(20000, Statistics(integrator, 0).attempted);
    State state = context.getState(State::Positions);
    context.setPositions({Vec3(2, 0, 0)});
    assertThrows("the energy of the integration force groups is not a number", [&] {
        integrator.step(1);
    });
    assertRounded(platform, {Vec3(2, 0, 0)}, getPositions(context));
    ASSERT_EQUAL(0, context.getStepCount() - state.getStepCount());
    context.setPositions({Vec3(-1000, 0, 0)});
    integrator.step(10);
}

void testInfiniteEnergy(Platform& platform)
{
    // A wall of infinite energy: nothing enters it, and what is in it at first may leave. A hole of minus infinity is
    // no place to be.

    System system;
    StericExclusionForce* force = new StericExclusionForce();
    Probe* probe = new Probe();
    const double infinity = numeric_limits<double>::infinity();
    probe->energy = [=](const vector<Vec3>& x) {
        return x[0][0] > 1 ? infinity : x[0][0] < 0 ? -infinity : 0;
    };
    system.addParticle(1);
    force->addParticle(0.1);
    system.addForce(force);
    system.addForce(probe);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addRigidBodyMove(1, 0.2, 0);
    Context context(system, integrator, platform);
    context.setPositions({Vec3(1.3, 0, 0)});
    while (getPositions(context)[0][0] > 1)
        integrator.step(1);
    for (int i = 0; i < 100; i++) {
        integrator.step(1);
        double x = getPositions(context)[0][0];
        ASSERT(x <= 1 && x >= 0);
    }
    context.setPositions({Vec3(-1, 0, 0)});
    assertThrows("the energy of the integration force groups is not a number", [&] {
        integrator.step(1);
    });
}

/**
 * If another force throws, the trials before that stay, and sampling can go on.
 */
void testThrowingForce(Platform& platform)
{
    BeadChain chain(8, 0.3);
    Probe* probe = new Probe();
    int numEvaluations = 0, failing = -1;
    vector<Vec3> accepted;
    probe->energy = [&](const vector<Vec3>& positions) {
        if (numEvaluations++ == failing)
            throw OpenMMException("out of order");
        accepted = positions;
        return 0.0;
    };
    chain.system.addForce(probe);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(1);
    integrator.addTorsionMove(1, 0.3);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    integrator.step(1);
    for (int trial : {30, 0}) { // in the midst of trials, and before the first
        integrator.resetMoveStatistics();
        vector<Vec3> before = getPositions(context);
        numEvaluations = 0;
        failing = trial;
        assertThrows("out of order", [&] {
            integrator.step(1);
        });
        failing = -1;
        ASSERT_EQUAL(1, context.getStepCount());
        ASSERT_EQUAL(max(0, trial - 1), Statistics(integrator, 0).accepted);
        assertSameBits(trial == 0 ? before : accepted, getPositions(context));
        assertThrows("there is no open proposal", [&] {
            chain.force->acceptProposal(context);
        });
    }
    integrator.step(1);
    ASSERT_EQUAL(2, context.getStepCount());
    ASSERT(!chain.force->hasClash(context));
}

/**
 * Parameters that are refused leave nothing behind: a checkpoint made before still loads.
 */
void testRefusedParameters(Platform& platform)
{
    BeadChain chain(6, 0.45, 0.5);
    chain.force->setParticleParameters(0, 0.9);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(1);
    integrator.addTorsionMove(1, 0.3);
    Context context(chain.system, integrator, platform);
    auto assertRefused = [&] {
        chain.force->setParticleParameters(1, 1e300);
        assertThrows("particle 1 has radius", [&] {
            chain.force->updateParametersInContext(context);
        });
        chain.force->setParticleParameters(1, 0.45);
        chain.force->setOverlapTolerance(1e300);
        assertThrows("tolerance", [&] {
            chain.force->updateParametersInContext(context);
        });
        chain.force->setOverlapTolerance(0);
    };
    assertRefused(); // before there are positions
    context.setPositions(chain.positions);
    integrator.step(2);
    int tolerated = integrator.getNumToleratedClashes(context);
    ASSERT(tolerated > 0);
    stringstream checkpoint;
    context.createCheckpoint(checkpoint);
    integrator.step(2);
    vector<Vec3> end = getPositions(context);
    assertRefused();
    ASSERT_EQUAL(tolerated, integrator.getNumToleratedClashes(context));
    context.loadCheckpoint(checkpoint);
    integrator.step(2);
    assertSameBits(end, getPositions(context));
}

void testBadSystems(Platform& platform)
{
    auto assertRefused = [&](const string& message, const System& system) {
        TorsionMonteCarloIntegrator integrator(300);
        integrator.addTorsionMove(1, 0.1);
        assertThrows(message, [&] {
            Context context(system, integrator, platform);
        });
    };
    System none;
    none.addParticle(1);
    assertRefused("the System has no StericExclusionForce", none);
    BeadChain two(4, 0.3);
    two.system.addForce(new StericExclusionForce(*two.force));
    assertRefused("the System has more than one StericExclusionForce", two.system);

    for (Force* barostat :
         {(Force*)new MonteCarloBarostat(1, 300), (Force*)new MonteCarloAnisotropicBarostat(Vec3(1, 1, 1), 300),
          (Force*)new MonteCarloMembraneBarostat(1, 1, 300, MonteCarloMembraneBarostat::XYIsotropic,
                                                 MonteCarloMembraneBarostat::ZFree),
          (Force*)new MonteCarloFlexibleBarostat(1, 300)}) {
        BeadChain chain(4, 0.3);
        chain.system.addForce(new CustomExternalForce("periodicdistance(x, y, z, 0, 0, 0)"));
        string name = barostat->getName();
        chain.system.addForce(barostat);
        assertRefused("the System has a barostat (force 2, " + name + ")", chain.system);
    }

    // A constraint may not span a torsion, unless one of its particles is on the axis.

    BeadChain spanning(5, 0.3), along(5, 0.3), between(5, 0.3);
    spanning.system.addConstraint(1, 2, 1);
    spanning.system.addConstraint(1, 4, 2);
    assertRefused("the constraint between particles 1 and 4 cannot hold: torsion 1 moves them relative to each other",
                  spanning.system);
    between.addMolecule(3, 0.3, 0, Vec3(5, 0, 0));
    between.system.addConstraint(3, 6, 1);
    assertRefused("the constraint between particles 3 and 6 cannot hold: they are in different molecules",
                  between.system);
    for (int i = 0; i < 4; i++)
        along.system.addConstraint(i, i + 1, 1);
    along.system.addConstraint(0, 2, sqrt(2.0));
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addTorsionMove(1, 0.5);
    Context context(along.system, integrator, platform);
    context.setPositions(along.positions);
    integrator.step(10);
    vector<Vec3> before = getPositions(context);
    context.applyConstraints(1e-8);
    vector<Vec3> after = getPositions(context);
    for (int i = 0; i < 5; i++)
        ASSERT_EQUAL_VEC(before[i], after[i], 1e-10 + getTolerance(platform));
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
    assertThrows("the number of torsions that a move turns must be at least 1, but is 0", [&] {
        integrator.addTorsionMove(1, 0.1, {}, 0);
    });
    assertThrows("the number of trials per step must be at least 1, but is 0", [&] {
        integrator.setTrialsPerStep(0);
    });
    assertThrows("the steric mode must be Hard or Soft, but is 2", [&] {
        integrator.setStericMode(TorsionMonteCarloIntegrator::StericMode(2));
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

void testReinitialize(Platform& platform)
{
    // The integrator goes on with a Context made anew, and from where it was if its state is preserved.

    BeadChain chain(6, 0.45, 0.5);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(6);
    integrator.addTorsionMove(1, 0.5);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    integrator.step(5);
    vector<Vec3> first = getPositions(context);
    context.reinitialize(true);
    assertSameBits(first, getPositions(context));
    integrator.step(5);
    context.reinitialize();
    context.setPositions(chain.positions);
    integrator.step(5);
    assertSameBits(first, getPositions(context));
}

void testTorsionMonteCarloIntegrator(Platform& platform)
{
    if (getPrecision(platform) == "double") // It takes long, and precision is nothing to it.
        testHardBeads(platform);
    testBoltzmannTorsions(platform);
    testIntegrationForceGroups(platform);
    testBoltzmannRigidBody(platform);
    testHardSpheresInWell(platform);
    testSoftSpheres(platform);
    testSoftEnergy(platform);
    testStericEnergyIsLeftOut(platform);
    testUploads(platform);
    testAthermal(platform);
    testPositionsOfTrials(platform);
    testEnergyIsSettled(platform);
    testTorsionMoves(platform);
    testRigidBodyMoves(platform);
    testWeights(platform);
    testChangingMoves(platform);
    testAnglesInDegrees();
    testSteps(platform);
    testSeeds(platform);
    testTorsionAngles(platform);
    testFixedAndVirtual(platform);
    testLimits(platform);
    testRefusedClashes(platform);
    testCompoundIntegrator(platform);
    if (canMinimize(platform))
        testMinimization(platform);
    testBadEnergy(platform);
    testInfiniteEnergy(platform);
    testThrowingForce(platform);
    testRefusedParameters(platform);
    testBadSystems(platform);
    testBadMoves(platform);
    testReinitialize(platform);
}
