/**
 * This tests volume moves: what they sample, which trials they allow, and that a rejected trial changes no bit.
 */

#include "openmm/HarmonicBondForce.h"
#include "openmm/MonteCarloBarostat.h"
#include "openmm/NonbondedForce.h"
#include "openmm/serialization/XmlSerializer.h"
#include "openmm/VerletIntegrator.h"
#include "SamplingSupport.h"
#include "Significance.h"
#include <array>
#include <cstring>
#include <memory>
#include <set>
#include <sstream>

/** 1 bar in kJ/mol/nm^3. */
static const double BAR = 0.0602214076;

typedef array<Vec3, 3> Box;

static const Box CUBE = {{Vec3(3, 0, 0), Vec3(0, 3, 0), Vec3(0, 0, 3)}};
static const Box FLAT = {{Vec3(2.5, 0, 0), Vec3(0, 3, 0), Vec3(0, 0, 4)}};
static const Box SKEWED = {{Vec3(3, 0, 0), Vec3(1.5, 2.8, 0), Vec3(-1.4, 1.3, 3.4)}};
static const Box OCTAHEDRON = {
    {Vec3(3.2, 0, 0), Vec3(3.2 / 3, 3.2 * sqrt(8.0) / 3, 0), Vec3(-3.2 / 3, 3.2 * sqrt(2.0) / 3, 3.2 * sqrt(2.0 / 3))}};

static Box getBox(const Context& context)
{
    Box box;
    context.getState(0).getPeriodicBoxVectors(box[0], box[1], box[2]);
    return box;
}

/**
 * Dumbbells on a lattice that fills a box.
 */
class Dumbbells {
public:
    Dumbbells(int side, const Box& box, double radius) : force(new StericExclusionForce())
    {
        system.addForce(force);
        system.setDefaultPeriodicBoxVectors(box[0], box[1], box[2]);
        force->setUsesPeriodicBoundaryConditions(true);
        force->setOverlapTolerance(0);
        for (int i = 0; i < side * side * side; i++) {
            const Vec3 corner = box[0] * (i % side) + box[1] * (i / side % side) + box[2] * (i / side / side);
            for (int j = 0; j < 2; j++) {
                system.addParticle(20);
                force->addParticle(radius);
                positions.push_back(corner / side + Vec3(0, 0.05, 0.1 * j));
            }
            force->addBond(2 * i, 2 * i + 1);
        }
        force->createExclusionsFromBonds(1);
    }
    /**
     * Add Lennard-Jones with a switch and a dispersion correction, charges by a reaction field, and bonds.
     */
    NonbondedForce* addEnergies(double epsilon, double cutoff)
    {
        NonbondedForce* pairs = new NonbondedForce();
        HarmonicBondForce* bonds = new HarmonicBondForce();
        pairs->setNonbondedMethod(NonbondedForce::CutoffPeriodic);
        pairs->setCutoffDistance(cutoff);
        pairs->setUseSwitchingFunction(true);
        pairs->setSwitchingDistance(0.8 * cutoff);
        bonds->setUsesPeriodicBoundaryConditions(true);
        for (int i = 0; i < system.getNumParticles(); i++) {
            pairs->addParticle(i % 2 == 0 ? 0.1 : -0.1, 0.3, epsilon);
            if (i % 2 == 1) {
                pairs->addException(i - 1, i, 0, 1, 0);
                bonds->addBond(i - 1, i, 0.11, 1000);
            }
        }
        system.addForce(pairs);
        system.addForce(bonds);
        return pairs;
    }
    int getNumMolecules() const
    {
        return system.getNumParticles() / 2;
    }
    System system;
    StericExclusionForce* force;
    vector<Vec3> positions;
};

/**
 * A force with the energy a ln V, which evaluates to exp(-U/kT) = V^(-a/kT).
 */
class LogVolume : public Force {
public:
    explicit LogVolume(double factor) : factor(factor)
    {
    }
    bool usesPeriodicBoundaryConditions() const
    {
        return true;
    }
    const double factor;

protected:
    ForceImpl* createImpl() const;
};

class LogVolumeImpl : public ForceImpl {
public:
    explicit LogVolumeImpl(const LogVolume& owner) : owner(owner)
    {
    }
    void initialize(ContextImpl&)
    {
    }
    const LogVolume& getOwner() const
    {
        return owner;
    }
    void updateContextState(ContextImpl&, bool&)
    {
    }
    double calcForcesAndEnergy(ContextImpl& context, bool, bool, int groups)
    {
        Vec3 a, b, c;
        context.getPeriodicBoxVectors(a, b, c);
        return (groups & (1 << owner.getForceGroup())) == 0 ? 0 : owner.factor * log(a[0] * b[1] * c[2]);
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
    const LogVolume& owner;
};

ForceImpl* LogVolume::createImpl() const
{
    return new LogVolumeImpl(*this);
}

/**
 * The share of a gamma distribution below a value, for an integer shape.
 */
static double getGammaShare(int shape, double value)
{
    double term = exp(-value), sum = 1;
    for (int k = 0; k < shape; k++) {
        sum -= term;
        term *= value / (k + 1);
    }
    return sum;
}

/**
 * An ideal gas: P V / kT has a gamma distribution, of shape N + 1, or less if there is an energy a ln V.
 */
static void testIdealGas(Platform& platform, double factor, int trialsPerTest, bool native)
{
    const double pressure = 200, thermalVolume = THERMAL / (pressure * BAR);
    const int numSamples = 5000, numBins = 20;
    Dumbbells gas(2, CUBE, 0);
    if (factor != 0)
        gas.system.addForce(new LogVolume(factor * THERMAL));
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(7);
    integrator.setTrialsPerStep(20);
    integrator.addVolumeMove(1, pressure, 0.9);
    integrator.addRigidBodyMove(0.3, 0.5, 1);
    integrator.setTrialsPerOuterTest(trialsPerTest);
    integrator.setNativeEnergies(native);
    Context context(gas.system, integrator, platform);
    context.setPositions(gas.positions);
    const int shape = gas.getNumMolecules() + 1 - (int)factor;
    vector<int> counts(numBins, 0);
    double sum = 0, sumOfSquares = 0;
    for (int i = 0; i < numSamples; i++) {
        integrator.step(1);
        const double volume = context.getState(0).getPeriodicBoxVolume() / thermalVolume;
        counts[min(numBins - 1, (int)(numBins * getGammaShare(shape, volume)))]++;
        sum += volume;
        sumOfSquares += volume * volume;
    }
    const double mean = sum / numSamples, variance = sumOfSquares / numSamples - mean * mean;
    ASSERT_EQUAL_TOL((double)shape, mean, 0.04);
    ASSERT_EQUAL_TOL((double)shape, variance, 0.15);
    ASSERT(testEquallyLikely(counts) > 1e-4);
}

/**
 * A barostat also acts in steps of this integrator alone, and samples the same.
 */
static void testBarostatAlone(Platform& platform)
{
    const double pressure = 200, thermalVolume = THERMAL / (pressure * BAR);
    Dumbbells gas(3, CUBE, 0.01);
    gas.system.addForce(new MonteCarloBarostat(pressure, 300, 1));
    NonbondedForce* pairs = gas.addEnergies(0, 0.1);
    for (int i = 0; i < pairs->getNumParticles(); i++)
        pairs->setParticleParameters(i, 0, 0.1, 0);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setTrialsPerStep(1);
    integrator.addRigidBodyMove(1, 0.5, 1);
    Context context(gas.system, integrator, platform);
    context.setPositions(gas.positions);
    integrator.step(1000);
    double sum = 0;
    const int numSamples = 4000;
    for (int i = 0; i < numSamples; i++) {
        integrator.step(5);
        sum += context.getState(0).getPeriodicBoxVolume() / thermalVolume;
    }
    ASSERT_EQUAL_TOL(gas.getNumMolecules() + 1.0, sum / numSamples, 0.06);
}

/**
 * The energy at positions whose molecules and box are scaled, by OpenMM alone.
 */
static double computeScaledEnergy(Context& context, const vector<Vec3>& positions, const Box& box, double factor)
{
    vector<Vec3> scaled(positions);
    for (size_t i = 0; i < positions.size(); i += 2)
        for (int j = 0; j < 2; j++)
            scaled[i + j] += (positions[i] + positions[i + 1]) * (0.5 * (factor - 1));
    context.setPeriodicBoxVectors(box[0] * factor, box[1] * factor, box[2] * factor);
    context.setPositions(scaled);
    return context.getState(State::Energy).getPotentialEnergy();
}

/**
 * A dense fluid of dumbbells: after each step the energy is OpenMM's in the present box, and the pressure, which
 * follows from OpenMM's energies by N kT / V - dU/dV, has the mean that was asked for.
 */
static void testFluid(const Box& box, const string& platformName, bool soft)
{
    const double pressure = 300;
    Platform& platform = Platform::getPlatformByName(platformName);
    Dumbbells fluid(4, box, soft ? 0.16 : 0.1);
    fluid.force->setForceConstant(1e4);
    if (!soft)
        fluid.addEnergies(0.8, 0.6);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setStericMode(soft ? TorsionMonteCarloIntegrator::Soft : TorsionMonteCarloIntegrator::Off);
    integrator.setRandomNumberSeed(3);
    integrator.addRigidBodyMove(1, 0.1, 0.7);
    const int move = integrator.addVolumeMove(0.02, pressure, 0.1);
    Context context(fluid.system, integrator, platform);
    VerletIntegrator unused(0.001);
    Context reference(fluid.system, unused, platform);
    context.setPositions(fluid.positions);
    integrator.setAdaptMoveSizes(true);
    integrator.step(300);
    integrator.setAdaptMoveSizes(false);
    const int numBlocks = 20, blockSize = 40;
    double sum = 0, sumOfSquares = 0;
    for (int block = 0; block < numBlocks; block++) {
        double mean = 0;
        for (int i = 0; i < blockSize; i++) {
            integrator.step(2);
            const State state = context.getState(State::Positions | State::Energy);
            const Box present = getBox(context);
            const double volume = state.getPeriodicBoxVolume(), strain = 1e-4;
            if (i % 10 == 0)
                ASSERT_EQUAL_TOL(state.getPotentialEnergy(), integrator.getPotentialEnergy(context), 2e-5);
            const double change = computeScaledEnergy(reference, state.getPositions(), present, 1 + strain) -
                                  computeScaledEnergy(reference, state.getPositions(), present, 1 - strain);
            mean += (fluid.getNumMolecules() * THERMAL - change / (6 * strain)) / volume / BAR / blockSize;
        }
        sum += mean / numBlocks;
        sumOfSquares += mean * mean / numBlocks;
    }
    const double error = sqrt((sumOfSquares - sum * sum) / (numBlocks - 1));
    cout << platformName << ": " << sum << " +- " << error << " bar, " << context.getState(0).getPeriodicBoxVolume()
         << " nm^3" << endl;
    ASSERT(fabs(sum - pressure) < 4.5 * error);
    ASSERT(error < 0.1 * pressure);
    const Statistics counts(integrator, move);
    ASSERT(counts.accepted > counts.attempted / 10);
    for (int k = 0; k < 3; k++)
        ASSERT_EQUAL_VEC(box[k] *
                             cbrt(context.getState(0).getPeriodicBoxVolume() / (box[0][0] * box[1][1] * box[2][2])),
                         getBox(context)[k], 1e-9);
    for (int i = 0; i < fluid.system.getNumParticles(); i += 2) {
        const Vec3 bond = getPositions(context)[i + 1] - getPositions(context)[i];
        ASSERT_EQUAL_TOL(0.1, sqrt(bond.dot(bond)), 1e-9);
    }
}

/**
 * A rejected trial changes no bit of positions, box and energy; an accepted one scales the box and the middles of
 * molecules about the origin, wherever they have drifted.
 */
static void testTrials(Platform& platform, bool outerTests)
{
    Dumbbells fluid(3, CUBE, 0.1);
    fluid.addEnergies(0.8, 0.8);
    if (outerTests)
        fluid.system.addForce(new LogVolume(1));
    for (size_t i = 0; i < fluid.positions.size(); i++)
        fluid.positions[i] += Vec3(3, 6, -30) * (double)(i / 2 % 4);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(5);
    integrator.setTrialsPerStep(1);
    integrator.setTrialsPerOuterTest(outerTests ? 1 : 0);
    const int move = integrator.addVolumeMove(1, 30, 0.2);
    const int other = integrator.addRigidBodyMove(1, 0.1, 0.7);
    Context context(fluid.system, integrator, platform);
    context.setPositions(fluid.positions);
    integrator.step(1);
    int numRejected = 0, numAccepted = 0;
    for (int i = 0; i < 800; i++) {
        const vector<Vec3> before = getPositions(context);
        const Box box = getBox(context);
        const double energy = integrator.getPotentialEnergy(context);
        const Statistics countsBefore(integrator, move), othersBefore(integrator, other);
        integrator.step(1);
        const vector<Vec3> after = getPositions(context);
        const Box newBox = getBox(context);
        const Statistics counts(integrator, move), others(integrator, other);
        if (others.accepted > othersBefore.accepted)
            continue;
        if (box == newBox) {
            numRejected++;
            ASSERT(memcmp(before.data(), after.data(), before.size() * sizeof(Vec3)) == 0);
            ASSERT(energy == integrator.getPotentialEnergy(context));
            continue;
        }
        numAccepted++;
        ASSERT(counts.accepted == countsBefore.accepted + 1);
        const double factor = newBox[0][0] / box[0][0];
        for (size_t j = 0; j < before.size(); j += 2)
            ASSERT_EQUAL_VEC((before[j] + before[j + 1]) * factor, after[j] + after[j + 1], 1e-10);
    }
    ASSERT(numRejected > 50 && numAccepted > 50);
}

/**
 * Blocks of trials with several accepted volume moves, which an outer test takes back: no bit is another.
 */
static void testTakenBack(Platform& platform)
{
    Dumbbells fluid(3, SKEWED, 0.1);
    fluid.addEnergies(0.8, 0.8);
    fluid.system.addForce(new LogVolume(10 * THERMAL));
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(5);
    integrator.setTrialsPerStep(6);
    integrator.setTrialsPerOuterTest(6);
    integrator.addVolumeMove(1, 60, 0.2);
    integrator.addRigidBodyMove(1, 0.1, 0.7);
    Context context(fluid.system, integrator, platform);
    context.setPositions(fluid.positions);
    integrator.step(1);
    long long attempted, accepted, takenBack, before = 0;
    double mean, deviation;
    int numRestored = 0;
    for (int i = 0; i < 200; i++) {
        const vector<Vec3> positions = getPositions(context);
        const Box box = getBox(context);
        const double energy = integrator.getPotentialEnergy(context);
        integrator.getOuterStatistics(attempted, accepted, before, mean, deviation);
        integrator.step(1);
        integrator.getOuterStatistics(attempted, accepted, takenBack, mean, deviation);
        if (takenBack == before)
            continue;
        numRestored++;
        const vector<Vec3> restored = getPositions(context);
        ASSERT(box == getBox(context) && energy == integrator.getPotentialEnergy(context));
        ASSERT(memcmp(positions.data(), restored.data(), positions.size() * sizeof(Vec3)) == 0);
    }
    ASSERT(numRestored > 20 && numRestored < 180);
}

/**
 * A run that resumes from a checkpoint, or from a State, has the bits of one that continues.
 */
static void testResuming(Platform& platform, bool hard)
{
    Dumbbells fluid(3, FLAT, 0.1);
    if (!hard)
        fluid.addEnergies(0.8, 0.8);
    auto makeIntegrator = [&] {
        auto made = make_unique<TorsionMonteCarloIntegrator>(300);
        made->setRandomNumberSeed(11);
        made->setTrialsPerStep(20);
        made->addVolumeMove(1, 30, 0.1);
        made->addRigidBodyMove(3, 0.1, 0.7);
        made->setAdaptMoveSizes(true);
        return made;
    };
    auto integrator = makeIntegrator(), resumed = makeIntegrator(), fromState = makeIntegrator();
    Context context(fluid.system, *integrator, platform), second(fluid.system, *resumed, platform),
        third(fluid.system, *fromState, platform);
    context.setPositions(fluid.positions);
    integrator->step(20);
    stringstream checkpoint;
    context.createCheckpoint(checkpoint);
    const State state =
        context.getState(State::Positions | State::Velocities | State::Parameters | State::IntegratorParameters);
    second.loadCheckpoint(checkpoint);
    stringstream xml;
    XmlSerializer::serialize<State>(&state, "State", xml);
    const unique_ptr<State> loaded(XmlSerializer::deserialize<State>(xml));
    third.setState(*loaded);
    integrator->step(20);
    resumed->step(20);
    fromState->step(20);
    const vector<Vec3> expected = getPositions(context);
    ASSERT(getBox(context) != FLAT);
    for (const Context* other : {&second, &third}) {
        ASSERT(getBox(context) == getBox(*other));
        const vector<Vec3> found = getPositions(*other);
        ASSERT(memcmp(expected.data(), found.data(), expected.size() * sizeof(Vec3)) == 0);
    }
}

/**
 * Hard spheres: no clash, in no box, and clashes of the start are tolerated.
 */
static void testHardSpheres(Platform& platform)
{
    Dumbbells fluid(4, SKEWED, 0.25);
    fluid.positions[2] = fluid.positions[0] + Vec3(0.02, 0, 0);
    fluid.positions[3] = fluid.positions[1] + Vec3(0.02, 0, 0);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addRigidBodyMove(50, 0.1, 0.7);
    const int move = integrator.addVolumeMove(1, 300, 0.2);
    Context context(fluid.system, integrator, platform);
    context.setPositions(fluid.positions);
    vector<pair<int, int>> pairs;
    vector<double> overlaps;
    fluid.force->getClashes(context, pairs, overlaps);
    const set<pair<int, int>> tolerated(pairs.begin(), pairs.end());
    ASSERT(!tolerated.empty());
    for (int i = 0; i < 60; i++) {
        integrator.step(3);
        fluid.force->getClashes(context, pairs, overlaps);
        for (const auto& pair : pairs)
            ASSERT(tolerated.count(pair) != 0);
    }
    const Statistics counts(integrator, move);
    ASSERT(counts.accepted > 8 && counts.clashed > 20);
    ASSERT(getBox(context) != SKEWED);
}

static string warning;

static void keepWarning(const string& message)
{
    warning += message;
}

/**
 * The box stays as wide as cutoffs need.
 */
static void testNarrowBoxes(Platform& platform)
{
    Dumbbells gas(2, CUBE, 0);
    gas.addEnergies(0.1, 1.45);
    TorsionMonteCarloIntegrator integrator(300);
    const int move = integrator.addVolumeMove(1, 5000, 0.1);
    Context context(gas.system, integrator, platform);
    context.setPositions(gas.positions);
    warning.clear();
    setWarningHandler(keepWarning);
    integrator.step(10);
    setWarningHandler(ignoreWarning);
    ASSERT(warning.find("narrower than twice the largest cutoff") != string::npos);
    ASSERT(warning.find("narrower") == warning.rfind("narrower"));
    ASSERT(getBox(context)[0][0] >= 2.9 && getBox(context)[0][0] < 3);
    long long attempted, clashed, rejected, accepted;
    integrator.getMoveStatistics(move, attempted, clashed, rejected, accepted);
    ASSERT(attempted > clashed + rejected + accepted);
}

static void testRefusals(Platform& platform)
{
    Dumbbells gas(2, CUBE, 0);
    auto refuse = [&](const string& message, System& system) {
        TorsionMonteCarloIntegrator integrator(300);
        integrator.addVolumeMove(1, 1, 0.1);
        assertThrows(message, [&] {
            Context context(system, integrator, platform);
        });
    };
    gas.force->setUsesPeriodicBoundaryConditions(false);
    refuse("but the StericExclusionForce has none", gas.system);
    gas.force->setUsesPeriodicBoundaryConditions(true);
    gas.system.setParticleMass(3, 0);
    refuse("that of particle 2 has fixed particles", gas.system);
    gas.system.setParticleMass(3, 1);
    gas.addEnergies(0.1, 1);
    const int barostat = gas.system.addForce(new MonteCarloBarostat(1, 300));
    refuse("which changes the volume, as a volume move does", gas.system);
    gas.system.removeForce(barostat);
    TorsionMonteCarloIntegrator integrator(0);
    integrator.addVolumeMove(0, 1, 0.1);
    integrator.addRigidBodyMove(1, 0.1, 0.1);
    Context context(gas.system, integrator, platform);
    context.setPositions(gas.positions);
    integrator.step(1);
    integrator.setVolumeMoveParameters(0, 1, 1, 0.1);
    assertThrows("a volume move needs a temperature above 0", [&] {
        integrator.step(1);
    });
    assertThrows("the pressure of a volume move must be a finite number and at least 0, but is -1", [&] {
        integrator.addVolumeMove(1, -1, 0.1);
    });
    assertThrows("must be above 0 and at most 1, but is 0", [&] {
        integrator.addVolumeMove(1, 1, 0);
    });
    ASSERT_EQUAL(string("volume at 1 bar ±0.1 (weight 1)"), integrator.getMoveDescription(0));
}

int main()
{
    return runOnPlatform("Reference", [](Platform& platform) {
        testRefusals(platform);
        testTrials(platform, false);
        testTrials(platform, true);
        testTakenBack(platform);
        testResuming(platform, false);
        testResuming(platform, true);
        testHardSpheres(platform);
        testNarrowBoxes(platform);
        testIdealGas(platform, 0, 0, true);
        testIdealGas(platform, 3, 0, true);
        testIdealGas(platform, 3, 1, true);
        testIdealGas(platform, 3, 3, true);
        testIdealGas(platform, 3, 0, false);
        testBarostatAlone(platform);
        testFluid(CUBE, "Reference", false);
        testFluid(FLAT, "Reference", true);
        testFluid(OCTAHEDRON, "CPU", false);
    });
}
