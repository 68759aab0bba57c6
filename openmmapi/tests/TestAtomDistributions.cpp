/**
 * This tests what atom moves sample, alone and beside moves that keep bond lengths and angles. Means are compared with
 * integrals; their errors are estimated from blocks.
 */

#include "openmm/CompoundIntegrator.h"
#include "openmm/HarmonicAngleForce.h"
#include "openmm/HarmonicBondForce.h"
#include "openmm/LangevinMiddleIntegrator.h"
#include "openmm/PeriodicTorsionForce.h"
#include "SamplingSupport.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

const double LENGTH = 0.15, BOND_CONSTANT = 3000, ANGLE = 1.9, ANGLE_CONSTANT = 40, PHASE = 0.7, BARRIER = 3;

/** The most standard errors by which a mean may be off; there are some 200 means. */
const double MOST_ERRORS = 5;

enum Joints { NoJoints, Torsions, BallJoints };

/**
 * Beads in a row with energies of bonds, angles and dihedrals, which are independent of each other.
 */
class Chain {
public:
    Chain(int length, Joints joints, double radius = 0.01) :
        force(new StericExclusionForce()), length(length), integrator(300)
    {
        HarmonicBondForce* bonds = new HarmonicBondForce();
        HarmonicAngleForce* angles = new HarmonicAngleForce();
        PeriodicTorsionForce* torsions = new PeriodicTorsionForce();
        force->setOverlapTolerance(0);
        for (int i = 0; i < length; i++) {
            system.addParticle(12);
            force->addParticle(radius);
            positions.push_back(Vec3(0.13 * i, 0.08 * (i % 2), 0.04 * (i / 2 % 2)));
            if (i > 0) {
                force->addBond(i - 1, i);
                bonds->addBond(i - 1, i, LENGTH, BOND_CONSTANT);
            }
            if (i > 0 && joints == BallJoints)
                force->addBallJoint(i - 1, i);
            if (i > 1)
                angles->addAngle(i - 2, i - 1, i, ANGLE, ANGLE_CONSTANT);
            if (i > 2) {
                torsions->addTorsion(i - 3, i - 2, i - 1, i, 1, PHASE, BARRIER);
                if (joints == Torsions)
                    force->addTorsion(i - 3, i - 2, i - 1, i);
            }
        }
        for (Force* one : {(Force*)force, (Force*)bonds, (Force*)angles, (Force*)torsions})
            system.addForce(one);
        integrator.setStericMode(TorsionMonteCarloIntegrator::Off);
        integrator.setRandomNumberSeed(7);
        integrator.setTrialsPerStep(4 * length);
    }
    System system;
    StericExclusionForce* force;
    const int length;
    vector<Vec3> positions;
    TorsionMonteCarloIntegrator integrator;
};

/**
 * Get the values of which means are compared: of each bond length, angle and dihedral.
 */
static vector<double> measure(const vector<Vec3>& x, int length)
{
    vector<double> values;
    auto add = [&](double value, double square) {
        values.push_back(value);
        values.push_back(square);
    };
    for (int i = 1; i < length; i++) {
        const Vec3 bond = x[i] - x[i - 1];
        const double r = sqrt(bond.dot(bond));
        add(r, r * r);
        if (i > 1) {
            const Vec3 back = x[i - 2] - x[i - 1];
            const double angle = acos(bond.dot(back) / r / sqrt(back.dot(back)));
            add(angle, angle * angle);
        }
        if (i > 2) {
            const double dihedral = getDihedral(x[i - 3], x[i - 2], x[i - 1], x[i]);
            add(cos(dihedral), sin(dihedral));
        }
    }
    return values;
}

/**
 * Get the means of a variable and of another function of it, by quadrature.
 */
static array<double, 2> integrate(double low, double high, const function<double(double)>& weight,
                                  const function<array<double, 2>(double)>& values)
{
    const int count = 20000;
    double sum = 0;
    array<double, 2> means = {{0, 0}};
    for (int i = 0; i < count; i++) {
        const double x = low + (i + 0.5) * (high - low) / count, share = weight(x);
        sum += share;
        for (int j = 0; j < 2; j++)
            means[j] += share * values(x)[j];
    }
    for (double& mean : means)
        mean /= sum;
    return means;
}

static vector<double> expect(int length, double leastLength = 0.05)
{
    auto withSquare = [](double x) {
        return array<double, 2>{{x, x * x}};
    };
    const auto r = integrate(
        leastLength, 0.3,
        [](double x) {
            return x * x * exp(-0.5 * BOND_CONSTANT * pow(x - LENGTH, 2) / THERMAL);
        },
        withSquare);
    const auto angle = integrate(
        0, M_PI,
        [](double x) {
            return sin(x) * exp(-0.5 * ANGLE_CONSTANT * pow(x - ANGLE, 2) / THERMAL);
        },
        withSquare);
    const auto dihedral = integrate(
        -M_PI, M_PI,
        [](double x) {
            return exp(-BARRIER * cos(x - PHASE) / THERMAL);
        },
        [](double x) {
            return array<double, 2>{{cos(x), sin(x)}};
        });
    vector<double> values;
    for (int i = 1; i < length; i++) {
        values.insert(values.end(), r.begin(), r.end());
        if (i > 1)
            values.insert(values.end(), angle.begin(), angle.end());
        if (i > 2)
            values.insert(values.end(), dihedral.begin(), dihedral.end());
    }
    return values;
}

/**
 * Sample, and return by how many standard errors the mean that is farthest off differs from the expected one.
 *
 * @param advance  makes one sample
 */
static double findLargestError(Context& context, const vector<double>& expected, int length, int numSamples,
                               const function<void()>& advance)
{
    const int numBlocks = 40, blockSize = numSamples / numBlocks;
    vector<double> sums(expected.size(), 0), squares(expected.size(), 0);
    for (int i = 0; i < numBlocks; i++) {
        vector<double> block(expected.size(), 0);
        for (int j = 0; j < blockSize; j++) {
            advance();
            const vector<double> values = measure(getPositions(context), length);
            for (size_t k = 0; k < values.size(); k++)
                block[k] += (values[k] - expected[k]) / blockSize;
        }
        for (size_t k = 0; k < block.size(); k++) {
            sums[k] += block[k];
            squares[k] += block[k] * block[k];
        }
    }
    double largest = 0;
    for (size_t k = 0; k < sums.size(); k++) {
        const double mean = sums[k] / numBlocks, variance = squares[k] / numBlocks - mean * mean;
        largest = max(largest, fabs(mean) / sqrt(variance / (numBlocks - 1)));
    }
    return largest;
}

static long long countAccepted(const TorsionMonteCarloIntegrator& integrator, int move)
{
    long long attempted, clashed, rejected, accepted;
    integrator.getMoveStatistics(move, attempted, clashed, rejected, accepted);
    return accepted;
}

static double findLargestError(Platform& platform, Chain& chain, int numSamples,
                               const vector<double>& expected = vector<double>())
{
    Context context(chain.system, chain.integrator, platform);
    context.setPositions(chain.positions);
    chain.integrator.step(200);
    for (int i = 0; i < chain.integrator.getNumMoves(); i++)
        ASSERT(countAccepted(chain.integrator, i) > 20);
    return findLargestError(context, expected.empty() ? expect(chain.length) : expected, chain.length, numSamples, [&] {
        chain.integrator.step(1);
    });
}

/**
 * A diatomic has the density r^2 exp(-k (r - r0)^2 / 2kT), a bent triatomic that of its angle besides, and a chain that
 * of its dihedrals.
 */
static void testAtomsAlone(Platform& platform)
{
    for (int length : {2, 3, 4}) {
        Chain chain(length, NoJoints);
        chain.integrator.addAtomMove(1, 0.05);
        ASSERT(findLargestError(platform, chain, 8000) < MOST_ERRORS);
    }

    // Hydrogens follow, and move alone, too.

    Chain bent(3, NoJoints);
    for (int i : {0, 2})
        bent.system.setParticleMass(i, 1.008);
    bent.integrator.addAtomMove(1, 0.05);
    ASSERT(findLargestError(platform, bent, 8000) < MOST_ERRORS);

    // Hard spheres cut the bond's distribution off.

    Chain hard(2, NoJoints, 0.07);
    hard.integrator.setStericMode(TorsionMonteCarloIntegrator::Hard);
    hard.integrator.addAtomMove(1, 0.05);
    ASSERT(findLargestError(platform, hard, 8000, expect(2, 0.14)) < MOST_ERRORS);
}

/**
 * Moves that keep bond lengths and angles leave their distribution as it is, and use the present ones.
 */
static void testMixtures(Platform& platform)
{
    const vector<function<void(TorsionMonteCarloIntegrator&)>> mixtures = {
        [](TorsionMonteCarloIntegrator& integrator) {
            integrator.addTorsionMove(1, M_PI, {}, 2);
        },
        [](TorsionMonteCarloIntegrator& integrator) {
            integrator.addClosedMove(1, 0.5, {}, 0);
        },
        [](TorsionMonteCarloIntegrator& integrator) {
            integrator.addClosedMove(1, 0.5, {}, 1);
        },
        [](TorsionMonteCarloIntegrator& integrator) {
            integrator.addLocalMove(1, 0.3, 30, {}, 5);
        },
        [](TorsionMonteCarloIntegrator& integrator) {
            integrator.addDrawnMove(1, {{0}, {4}, {8}}, {TorsionDensity::fromTable({4}, {1, 2, 1, 3})});
        }};
    for (auto& addMoves : mixtures) {
        Chain chain(12, Torsions);
        chain.integrator.addAtomMove(1, 0.05);
        addMoves(chain.integrator);
        ASSERT(findLargestError(platform, chain, 8000) < MOST_ERRORS);
    }
    Chain beads(6, BallJoints);
    beads.integrator.addAtomMove(1, 0.05);
    beads.integrator.addPivotMove(1, 0.5);
    beads.integrator.addCrankshaftMove(1, 1);
    beads.integrator.addRigidBodyMove(0.2, 0.1, 1);
    ASSERT(findLargestError(platform, beads, 8000) < MOST_ERRORS);
}

/**
 * Sample a ring of beads by atom moves: alone, when the ring is one link, or beside closed moves, when a closure closes
 * it. Returns the means of squared lengths, angles, cosines of twice the dihedrals and the squared radius of gyration,
 * and the squares of their standard errors.
 */
static array<array<double, 4>, 2> sampleRing(Platform& platform, bool isClosed)
{
    const int length = 12, numBlocks = 40, blockSize = 500;
    System system;
    StericExclusionForce* force = new StericExclusionForce();
    HarmonicBondForce* bonds = new HarmonicBondForce();
    HarmonicAngleForce* angles = new HarmonicAngleForce();
    PeriodicTorsionForce* torsions = new PeriodicTorsionForce();
    vector<Vec3> positions;
    for (int i = 0; i < length; i++) {
        const int j = (i + 1) % length, k = (i + 2) % length, l = (i + 3) % length;
        const double turn = 2 * M_PI * i / length, radius = 0.5 * LENGTH / sin(M_PI / length);
        system.addParticle(12);
        force->addParticle(0.01);
        positions.push_back(Vec3(radius * cos(turn), radius * sin(turn), i % 2 == 0 ? 0.03 : -0.03));
        bonds->addBond(i, j, LENGTH, BOND_CONSTANT);
        angles->addAngle(i, j, k, ANGLE, ANGLE_CONSTANT);
        torsions->addTorsion(i, j, k, l, 2, PHASE, 1);
        if (i + 1 < length || !isClosed)
            force->addBond(i, j);
        if (i + 3 < length && isClosed)
            force->addTorsion(i, j, k, l);
    }
    if (isClosed)
        force->addClosure(length - 2, length - 1, 0, 1);
    for (Force* one : {(Force*)force, (Force*)bonds, (Force*)angles, (Force*)torsions})
        system.addForce(one);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setStericMode(TorsionMonteCarloIntegrator::Off);
    integrator.setRandomNumberSeed(6);
    integrator.setTrialsPerStep(isClosed ? 6 * length : 12 * length);
    integrator.addAtomMove(1, 0.05);
    if (isClosed)
        integrator.addClosedMove(0.5, 0.4, {}, 0.3);
    Context context(system, integrator, platform);
    context.setPositions(positions);
    integrator.step(500);
    if (isClosed)
        ASSERT(countAccepted(integrator, 1) > 100);
    array<array<double, 4>, 2> results = {};
    array<double, 4> squares = {};
    for (int block = 0; block < numBlocks; block++) {
        array<double, 4> means = {};
        for (int i = 0; i < blockSize; i++) {
            integrator.step(1);
            vector<Vec3> x = getPositions(context);
            Vec3 middle;
            for (const Vec3& bead : x)
                middle += bead / length;
            for (int j = 0; j < length; j++)
                means[3] += (x[j] - middle).dot(x[j] - middle);
            x.insert(x.end(), x.begin(), x.begin() + 3);
            for (int j = 0; j < length; j++) {
                const Vec3 bond = x[j + 1] - x[j], next = x[j + 2] - x[j + 1];
                means[0] += bond.dot(bond);
                means[1] += acos(-bond.dot(next) / sqrt(bond.dot(bond) * next.dot(next)));
                means[2] += cos(2 * getDihedral(x[j], x[j + 1], x[j + 2], x[j + 3]));
            }
        }
        for (int k = 0; k < 4; k++) {
            const double mean = means[k] / length / blockSize;
            results[0][k] += mean / numBlocks;
            squares[k] += mean * mean / numBlocks;
        }
    }
    for (int k = 0; k < 4; k++)
        results[1][k] = (squares[k] - results[0][k] * results[0][k]) / (numBlocks - 1);
    return results;
}

static void testRings(Platform& platform)
{
    const auto alone = sampleRing(platform, false), closed = sampleRing(platform, true);
    for (int k = 0; k < 4; k++)
        ASSERT(fabs(alone[0][k] - closed[0][k]) < MOST_ERRORS * sqrt(alone[1][k] + closed[1][k]));
}

/**
 * Dynamics in turn with all of them samples the same.
 */
static void testDynamicsInTurn(Platform& platform)
{
    Chain chain(4, Torsions);
    CompoundIntegrator compound;
    TorsionMonteCarloIntegrator* sampler = new TorsionMonteCarloIntegrator(300);
    sampler->setStericMode(TorsionMonteCarloIntegrator::Off);
    sampler->setRandomNumberSeed(3);
    sampler->setTrialsPerStep(10);
    sampler->addAtomMove(1, 0.05);
    sampler->addTorsionMove(1, M_PI);
    LangevinMiddleIntegrator* dynamics = new LangevinMiddleIntegrator(300, 20, 0.0005);
    dynamics->setRandomNumberSeed(4);
    compound.addIntegrator(sampler);
    compound.addIntegrator(dynamics);
    Context context(chain.system, compound, platform);
    context.setPositions(chain.positions);
    context.setVelocitiesToTemperature(300, 5);
    const int numSamples = 8000;
    double kinetic = 0;
    auto advance = [&] {
        compound.setCurrentIntegrator(0);
        compound.step(1);
        compound.setCurrentIntegrator(1);
        compound.step(5);
    };
    for (int i = 0; i < 500; i++)
        advance();
    const double error = findLargestError(context, expect(4), 4, numSamples, [&] {
        advance();
        kinetic += context.getState(State::Energy).getKineticEnergy() / numSamples;
    });
    ASSERT(error < MOST_ERRORS);
    ASSERT_EQUAL_TOL(6 * THERMAL, kinetic, 0.03);
}

/**
 * Free molecules at a pressure have a mean volume of (N + 1) kT/P, whatever their bonds do.
 */
static void testVolume(Platform& platform)
{
    const int numMolecules = 4;
    const double pressure = 50 * 6.02214076e-2; // kJ/mol/nm^3, of 50 bar: the box is wide enough for a bond
    Chain chain(2, NoJoints, 0);
    HarmonicBondForce& bonds = dynamic_cast<HarmonicBondForce&>(chain.system.getForce(1));
    for (int i = 1; i < numMolecules; i++) {
        for (int j = 0; j < 2; j++) {
            chain.system.addParticle(12);
            chain.force->addParticle(0);
            chain.positions.push_back(Vec3(LENGTH * j, 0.4 * i, 0));
        }
        chain.force->addBond(2 * i, 2 * i + 1);
        bonds.addBond(2 * i, 2 * i + 1, LENGTH, BOND_CONSTANT);
    }
    bonds.setUsesPeriodicBoundaryConditions(true);
    chain.force->setUsesPeriodicBoundaryConditions(true);
    chain.system.setDefaultPeriodicBoxVectors(Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1));
    vector<int> all;
    for (int i = 0; i < 2 * numMolecules; i++)
        all.push_back(i);
    chain.integrator.addAtomMove(4, 0.05, all);
    chain.integrator.addVolumeMove(1, 50, 1);
    chain.integrator.setTrialsPerStep(20);
    Context context(chain.system, chain.integrator, platform);
    context.setPositions(chain.positions);
    const int numSamples = 20000;
    double sum = 0;
    chain.integrator.step(1000);
    const double error = findLargestError(context, expect(2), 2, numSamples, [&] {
        chain.integrator.step(1);
        sum += context.getState(0).getPeriodicBoxVolume() / numSamples;
    });
    ASSERT(error < MOST_ERRORS);
    ASSERT_EQUAL_TOL((numMolecules + 1) * THERMAL / pressure, sum, 0.03);
}

int main()
{
    return runOnPlatform("Reference", [](Platform& platform) {
        testAtomsAlone(platform);
        testMixtures(platform);
        testRings(platform);
        testDynamicsInTurn(platform);
        testVolume(platform);
    });
}
