/**
 * This tests that trials in two levels leave exp(-U/kT) as it is, however slowly they lead through it: many independent
 * draws from it are distributed as they were after any number of trials from each. A mean over all draws may change by
 * no more than chance allows.
 */

#include "openmm/CustomCentroidBondForce.h"
#include "openmm/CustomTorsionForce.h"
#include "openmm/GBSAOBCForce.h"
#include "openmm/NonbondedForce.h"
#include "openmm/TabulatedFunction.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "TestSupport.h"
#include <array>
#include <random>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static const double TEMPERATURE = 400;
static const double kT = TEMPERATURE * 8.31446261815324e-3;
static const int STERIC_GROUP = 1, FOREIGN_GROUP = 2;

/** In standard errors, what a mean may change by. Chance exceeds it once in some 5,000 runs of this test. */
static const double LARGEST_CHANGE = 4.5;

/** Of two torsions and U / kT, what is compared. */
typedef array<double, 6> Values;

class Draw {
public:
    vector<double> angles;
    Values values;
};

/**
 * Five beads with Born solvation, of which the ends are charged and bury others, and draws from exp(-U/kT). There can
 * be a Force that OpenMM evaluates, in the group of the others or not, and bonded terms.
 */
class SolvatedChain {
public:
    explicit SolvatedChain(int numDraws, bool hasForeign = false, int foreignGroup = 0) :
        force(new StericExclusionForce()), integrator(TEMPERATURE)
    {
        positions = {{0, 0.4, 0}, {0, 0, 0}, {0.3, 0, 0}, {0.3, 0.3, 0}, {0.7, 0.3, 0.1}};
        NonbondedForce* pairs = new NonbondedForce();
        GBSAOBCForce* born = new GBSAOBCForce();
        for (int i = 0; i < 5; i++) {
            const bool isEnd = i % 4 == 0;
            const double charge = isEnd ? 0.6 : i % 2 == 1 ? -0.4 : 0.4;
            system.addParticle(10);
            force->addParticle(0.01);
            pairs->addParticle(charge, 0.25, 0.5);
            born->addParticle(charge, isEnd ? 0.35 : 0.15, 0.8);
        }
        for (int i = 0; i < 4; i++)
            force->addBond(i, i + 1);
        for (int i = 0; i < 5; i++)
            for (int j = i + 1; j < min(i + 3, 5); j++)
                pairs->addException(i, j, 0, 1, 0);
        force->createExclusionsFromBonds(3);
        for (int i = 0; i < 2; i++)
            force->addTorsion(i, i + 1, i + 2, i + 3);
        force->setForceGroup(STERIC_GROUP);
        system.addForce(force);
        system.addForce(pairs);
        system.addForce(born);
        if (hasForeign) {
            CustomTorsionForce* torsions = new CustomTorsionForce("4*cos(theta-1)");
            for (int i = 0; i < 2; i++)
                torsions->addTorsion(i, i + 1, i + 2, i + 3);
            system.addForce(torsions);
            CustomCentroidBondForce* foreign = new CustomCentroidBondForce(2, "150*(same(distance(g1,g2))-0.45)^2");
            foreign->addTabulatedFunction(
                "same", new Continuous1DFunction({0, 30}, 0, 30)); // so that only OpenMM can evaluate it
            foreign->addGroup({0, 1});
            foreign->addGroup({3, 4});
            foreign->addBond({0, 1});
            foreign->setForceGroup(foreignGroup);
            system.addForce(foreign);
        }
        context.reset(new Context(system, integrator, Platform::getPlatform("Reference")));
        context->setPositions(positions);
        makeDraws(numDraws);
    }
    /**
     * Evaluate what is compared, by OpenMM's energy.
     */
    Values evaluate(const vector<double>& angles)
    {
        const double a = angles[0], b = angles[1];
        return {cos(a), sin(a), cos(b), sin(b), cos(a - b), computeEnergy(angles) / kT};
    }
    System system;
    StericExclusionForce* force;
    vector<Vec3> positions;
    vector<Draw> draws;

private:
    double computeEnergy(const vector<double>& angles)
    {
        force->setTorsionAngles(*context, angles);
        return context->getState(State::Energy, false, ~(1 << STERIC_GROUP)).getPotentialEnergy();
    }
    /**
     * Draw by rejection: uniform angles are taken with exp(-(U - lowest U)/kT).
     */
    void makeDraws(int numDraws)
    {
        const int size = 30;
        double lowest = HUGE_VAL;
        for (int i = 0; i < size * size; i++)
            lowest = min(lowest, computeEnergy({2 * M_PI * (i / size) / size, 2 * M_PI * (i % size) / size}));
        lowest -= 0.5 * kT;
        mt19937_64 generator(1);
        uniform_real_distribution<double> angle(-M_PI, M_PI), unit(0, 1);
        while ((int)draws.size() < numDraws) {
            const vector<double> angles = {angle(generator), angle(generator)};
            const double energy = computeEnergy(angles) - lowest;
            ASSERT(energy > 0);
            if (unit(generator) < exp(-energy / kT) && !force->hasClash(*context))
                draws.push_back({angles, evaluate(angles)});
        }
    }
    TorsionMonteCarloIntegrator integrator;
    unique_ptr<Context> context;
};

class Setting {
public:
    string name;
    double bornCutoff, pairCutoff, gridWidth;
    int trialsPerTest, trials;
    double leastKept, mostKept; // of the outer tests
};

static const Setting SETTINGS[] = {{"all pairs", 2, 2, 0.1, 5, 20, 0.95, 1},
                                   {"short cutoffs", 0.4, 0.4, 0.1, 3, 12, 0.3, 0.9},
                                   {"constant radii", 0.05, 2, 0.1, 4, 12, 0.3, 0.9},
                                   {"wide grid", 2, 2, 1, 5, 20, 0.3, 0.98},
                                   {"bonded terms alone", 0.05, 0.05, 0.1, 1, 10, 0.1, 0.9}};

/** With a Force that is foreign: left to outer tests, or decided in each trial. */
static const Setting FOREIGN_SETTINGS[] = {{"foreign in tests", 0.4, 0.4, 0.1, 3, 12, 0.2, 0.9},
                                           {"foreign in trials", 0.4, 0.4, 0.1, 0, 4, 0.2, 0.9}};

/**
 * Get by how many standard errors the mean of a value has changed after trials from each draw, the largest of all.
 */
static double findLargestChange(SolvatedChain& chain, const Setting& setting, bool constantsOfDraws)
{
    TorsionMonteCarloIntegrator integrator(TEMPERATURE);
    integrator.setRandomNumberSeed(5);
    integrator.addTorsionMove(1, M_PI);
    integrator.addTorsionMove(1, 0.6, {}, 2);
    integrator.setStandInCutoffs(setting.bornCutoff, setting.pairCutoff);
    integrator.setStandInGridWidth(setting.gridWidth);
    integrator.setTrialsPerOuterTest(setting.trialsPerTest);
    integrator.setTrialsPerStep(setting.trials);
    Context context(chain.system, integrator, Platform::getPlatform("Reference"));
    context.setPositions(chain.positions);
    integrator.renewStandIns(context);
    Values sums = {}, squares = {};
    int numMoved = 0;
    for (const Draw& draw : chain.draws) {
        integrator.setTorsionAngles(context, draw.angles);
        if (constantsOfDraws)
            integrator.renewStandIns(context);
        integrator.step(1);
        vector<double> angles;
        integrator.getTorsionAngles(context, angles);
        numMoved += fabs(angles[0] - draw.angles[0]) + fabs(angles[1] - draw.angles[1]) > 1e-6 ? 1 : 0;
        const Values values = chain.evaluate(angles);
        for (size_t i = 0; i < values.size(); i++) {
            const double change = values[i] - draw.values[i];
            sums[i] += change;
            squares[i] += change * change;
        }
    }
    ASSERT(numMoved > (int)chain.draws.size() / 2);
    long long attempted, accepted, trialsTakenBack;
    double mean, deviation;
    integrator.getOuterStatistics(attempted, accepted, trialsTakenBack, mean, deviation);
    const double kept = (double)accepted / attempted;
    if (attempted > 0 && !constantsOfDraws && !(kept >= setting.leastKept && kept <= setting.mostKept))
        throw OpenMMException(setting.name + ": " + to_string(kept) + " of the outer tests are passed");
    double largest = 0;
    for (size_t i = 0; i < sums.size(); i++)
        largest = max(largest, fabs(sums[i]) / sqrt(squares[i]));
    return largest;
}

static void assertUnchanged(SolvatedChain& chain, const Setting& setting)
{
    const double largest = findLargestChange(chain, setting, false);
    if (largest > LARGEST_CHANGE)
        throw OpenMMException(setting.name + ": a mean changes by " + to_string(largest) + " standard errors");
}

static void testNativeForces()
{
    SolvatedChain chain(10000);
    for (const Setting& setting : SETTINGS) {
        assertUnchanged(chain, setting);

        // Constants that depend on where trials begin are noticed.

        if (setting.name == "constant radii")
            ASSERT(findLargestChange(chain, setting, true) > LARGEST_CHANGE);
    }
}

static void testForeignForce()
{
    for (int group : {0, FOREIGN_GROUP}) {
        SolvatedChain chain(4000, true, group);
        for (const Setting& setting : FOREIGN_SETTINGS)
            assertUnchanged(chain, setting);
    }
}

int main()
{
    return runOnPlatform("Reference", [](Platform&) {
        testNativeForces();
        testForeignForce();
    });
}
