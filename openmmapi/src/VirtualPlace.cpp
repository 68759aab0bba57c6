#include "openmmchaintree/internal/VirtualPlace.h"
#include "openmm/VirtualSite.h"
#include <cmath>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

VirtualPlace::VirtualPlace(const System& system, int site) : site(site), kind(Unknown)
{
    const VirtualSite& given = system.getVirtualSite(site);
    for (int i = 0; i < given.getNumParticles(); i++)
        particles.push_back(given.getParticle(i));
    if (auto two = dynamic_cast<const TwoParticleAverageSite*>(&given)) {
        kind = Average;
        weights = {two->getWeight(0), two->getWeight(1)};
    }
    else if (auto three = dynamic_cast<const ThreeParticleAverageSite*>(&given)) {
        kind = Average;
        weights = {three->getWeight(0), three->getWeight(1), three->getWeight(2)};
    }
    else if (auto outside = dynamic_cast<const OutOfPlaneSite*>(&given)) {
        kind = OutOfPlane;
        weights = {outside->getWeight12(), outside->getWeight13(), outside->getWeightCross()};
    }
    else if (auto axes = dynamic_cast<const LocalCoordinatesSite*>(&given)) {
        kind = LocalCoordinates;
        axes->getOriginWeights(weights);
        axes->getXWeights(xWeights);
        axes->getYWeights(yWeights);
        local = axes->getLocalPosition();
    }
}

Vec3 VirtualPlace::average(const vector<double>& weights, const vector<Vec3>& positions) const
{
    Vec3 sum;
    for (size_t i = 0; i < weights.size(); i++)
        sum += positions[i] * weights[i];
    return sum;
}

/**
 * Get a vector of length 1, or 0 if it has no direction.
 */
static Vec3 normalize(const Vec3& x)
{
    const double length = sqrt(x.dot(x));
    return length > 0 ? x / length : Vec3();
}

Vec3 VirtualPlace::compute(const vector<Vec3>& positions) const
{
    if (kind == Average)
        return average(weights, positions);
    if (kind == OutOfPlane) {
        const Vec3 to2 = positions[1] - positions[0], to3 = positions[2] - positions[0];
        return positions[0] + to2 * weights[0] + to3 * weights[1] + to2.cross(to3) * weights[2];
    }
    const Vec3 x = normalize(average(xWeights, positions));
    const Vec3 z = normalize(x.cross(average(yWeights, positions)));
    return average(weights, positions) + x * local[0] + z.cross(x) * local[1] + z * local[2];
}
