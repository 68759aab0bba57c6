/**
 * This tests the spheres by which hopeless trials are refused where the radii of the force count for nothing.
 */

#include "openmmchaintree/internal/CoreSpheres.h"
#include "TestSupport.h"
#include <random>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static const double COULOMB = 138.93545764438198, ENERGY = 150;

static EnergyTerms::Nonbonded createNonbonded(const vector<double>& charges, const vector<double>& sigmas,
                                              const vector<double>& epsilons)
{
    EnergyTerms::Nonbonded nonbonded;
    nonbonded.force = 0;
    nonbonded.charges = charges;
    nonbonded.sigmas = sigmas;
    nonbonded.epsilons = epsilons;
    nonbonded.cutoff = nonbonded.switchingDistance = INFINITY;
    nonbonded.dielectric = 1;
    return nonbonded;
}

static CoreSpheres createSpheres(const vector<double>& charges, const vector<double>& sigmas,
                                 const vector<double>& epsilons)
{
    return CoreSpheres(createNonbonded(charges, sigmas, epsilons), {}, ENERGY);
}

/**
 * Get the Lennard-Jones energy of two particles, less their Coulomb attraction.
 */
static long double computeBound(const EnergyTerms::Nonbonded& nonbonded, int i, int j, long double distance)
{
    const long double sigma = 0.5L * (nonbonded.sigmas[i] + nonbonded.sigmas[j]);
    const long double epsilon = sqrtl((long double)nonbonded.epsilons[i] * nonbonded.epsilons[j]);
    const long double power6 = powl(sigma / distance, 6);
    const long double coulomb = COULOMB * nonbonded.charges[i] * nonbonded.charges[j] / distance;
    return 4 * epsilon * power6 * (power6 - 1) + min(0.0L, coulomb);
}

/**
 * Particles of any parameters: where spheres overlap, the force field forbids it, however near the centres are.
 */
static void testOverlapsAreForbidden()
{
    mt19937 random(1);
    uniform_real_distribution<double> uniform(0, 1);
    for (int scene = 0; scene < 20; scene++) {
        vector<double> charges, sigmas, epsilons;
        for (int i = 0; i < 60; i++) {
            const int type = uniform(random) * 8;
            charges.push_back(uniform(random) * 2 - 1 + (type == 7 ? 2 : 0));
            sigmas.push_back(0.1 + 0.04 * type);
            epsilons.push_back(0.05 + 0.15 * (type % 4));
        }
        const EnergyTerms::Nonbonded nonbonded = createNonbonded(charges, sigmas, epsilons);
        const CoreSpheres spheres(nonbonded, {}, ENERGY);
        for (int i = 0; i < 60; i++)
            for (int j = 0; j < i; j++) {
                const double contact = spheres.radii[i] + spheres.radii[j];
                if (spheres.radii[i] == 0 || spheres.radii[j] == 0)
                    continue;
                for (double share : {1 - 1e-9, 0.9, 0.5, 0.1, 0.01})
                    ASSERT(computeBound(nonbonded, i, j, share * contact) > ENERGY);
            }
    }
}

/**
 * Spheres of one type are as large as they may be, and the rare ion has what the others have left over.
 */
static void testSpheresAreLarge()
{
    vector<double> charges(10, -0.5), sigmas(10, 0.3), epsilons(10, 0.8);
    auto checkContact = [&](double contact) {
        const EnergyTerms::Nonbonded nonbonded = createNonbonded(charges, sigmas, epsilons);
        ASSERT_EQUAL_TOL(ENERGY, (double)computeBound(nonbonded, 0, 9, contact), 1e-6);
    };
    checkContact(2 * createSpheres(charges, sigmas, epsilons).radii[0]);
    const double alone = createSpheres(charges, sigmas, epsilons).radii[0];
    charges.push_back(2);
    sigmas.push_back(0.2);
    epsilons.push_back(0.05);
    const CoreSpheres spheres = createSpheres(charges, sigmas, epsilons);
    ASSERT_EQUAL(alone, spheres.radii[0]);
    const EnergyTerms::Nonbonded nonbonded = createNonbonded(charges, sigmas, epsilons);
    ASSERT_EQUAL_TOL(ENERGY, (double)computeBound(nonbonded, 0, 10, spheres.radii[0] + spheres.radii[10]), 1e-6);
}

static void testParticlesWithoutLennardJones()
{
    // Neither like charges nor opposite ones are refused but where they all but coincide; no charge, no sphere.

    const CoreSpheres spheres = createSpheres({1, 1, -1, 0, 0.3}, {1, 0, 0.3, 1, 0.3}, {0, 1, 0, 0, 0.5});
    for (int i : {0, 1, 2})
        ASSERT_EQUAL(CoreSpheres::GUARD_RADIUS, spheres.radii[i]);
    ASSERT_EQUAL(0, spheres.radii[3]);
    ASSERT(spheres.radii[4] > 0.09);
}

static void testExceptions()
{
    EnergyTerms::Nonbonded nonbonded = createNonbonded({0, 0, 0}, {1, 1, 1}, {1, 1, 1});
    nonbonded.exclusions.push_back({{0, 1}});
    EnergyTerms::TermSet bonds = {}, angles = {};
    bonds.particlesPerTerm = 2;
    bonds.particles = {1, 2};
    angles.particlesPerTerm = 3;
    angles.particles = {0, 1, 2};
    const vector<array<int, 2>> expected = {{{0, 1}}, {{1, 2}}};
    ASSERT(CoreSpheres(nonbonded, {bonds, angles}, ENERGY).exclusions == expected);

    // Beyond the cutoff, and where Lennard-Jones is switched, there is nothing to refuse for.

    nonbonded.cutoff = 0.5;
    nonbonded.switchingDistance = 0.4;
    ASSERT_EQUAL_TOL(0.2, CoreSpheres(nonbonded, {}, ENERGY).radii[0], 1e-12);
}

int main()
{
    return runOnPlatform("Reference", [](Platform&) {
        testOverlapsAreForbidden();
        testSpheresAreLarge();
        testParticlesWithoutLennardJones();
        testExceptions();
    });
}
