#include "openmmchaintree/internal/CoreSpheres.h"
#include "openmm/reference/SimTKOpenMMRealType.h"
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

using namespace ChainTreePlugin;
using namespace std;

namespace {

/**
 * Particles with the same Lennard-Jones parameters.
 */
class Type {
public:
    double sigma, epsilon;
    vector<int> particles;
    /** The greatest positive charge, and the absolute value of the greatest negative one. */
    double positive, negative;
    double radius;
};

} // namespace

static vector<Type> findTypes(const EnergyTerms::Nonbonded& nonbonded)
{
    map<pair<double, double>, Type> types;
    for (size_t i = 0; i < nonbonded.charges.size(); i++) {
        const double sigma = nonbonded.sigmas[i], epsilon = nonbonded.epsilons[i], charge = nonbonded.charges[i];
        if (!(sigma > 0 && epsilon > 0))
            continue;
        Type& type = types.insert({{sigma, epsilon}, {sigma, epsilon, {}, 0, 0, 0}}).first->second;
        type.particles.push_back(i);
        type.positive = max(type.positive, charge);
        type.negative = max(type.negative, -charge);
    }
    vector<Type> found;
    for (auto& type : types)
        found.push_back(type.second);
    return found;
}

/**
 * Get the distance below which two particles exceed an energy: the root of 4 epsilon (sigma^12 - sigma^6 d^6) -
 * attraction d^11 - energy d^12.
 */
static double findCoreDistance(const Type& a, const Type& b, double energy)
{
    const double sigma = 0.5 * (a.sigma + b.sigma), epsilon = sqrt(a.epsilon * b.epsilon);
    const double attraction = ONE_4PI_EPS0 * max(a.positive * b.negative, a.negative * b.positive);
    double low = 0, high = sigma;
    for (int i = 0; i < 40; i++) {
        const double distance = 0.5 * (low + high), power6 = pow(sigma / distance, 6);
        const bool isCore = 4 * epsilon * power6 * (power6 - 1) - attraction / distance > energy;
        (isCore ? low : high) = distance;
    }
    return low;
}

CoreSpheres::CoreSpheres(const EnergyTerms::Nonbonded& nonbonded, const vector<EnergyTerms::TermSet>& termSets,
                         double energy) :
    radii(nonbonded.charges.size(), 0),
    exclusions(nonbonded.exclusions)
{
    // A rare type, such as that of an ion, must not shrink the spheres of all others, so it comes last.

    vector<Type> types = findTypes(nonbonded);
    stable_sort(types.begin(), types.end(), [](const Type& a, const Type& b) {
        return a.particles.size() > b.particles.size();
    });
    const double undiminished = min(nonbonded.cutoff, nonbonded.switchingDistance);
    for (size_t i = 0; i < types.size(); i++) {
        types[i].radius = 0.5 * min(undiminished, findCoreDistance(types[i], types[i], energy));
        for (size_t j = 0; j < i; j++) {
            const double distance = min(undiminished, findCoreDistance(types[i], types[j], energy));
            if (types[j].radius > 0)
                types[i].radius = max(0.0, min(types[i].radius, distance - types[j].radius));
        }
        for (int particle : types[i].particles)
            radii[particle] = types[i].radius;
    }
    for (size_t i = 0; i < radii.size(); i++)
        if (nonbonded.charges[i] != 0 && !(nonbonded.sigmas[i] > 0 && nonbonded.epsilons[i] > 0))
            radii[i] = GUARD_RADIUS;
    for (const EnergyTerms::TermSet& set : termSets)
        if (set.particlesPerTerm == 2)
            for (size_t i = 0; i + 1 < set.particles.size(); i += 2)
                exclusions.push_back({{set.particles[i], set.particles[i + 1]}});
}
