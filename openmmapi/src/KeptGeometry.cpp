#include "openmmchaintree/internal/KeptGeometry.h"
#include "openmm/OpenMMException.h"
#include <cmath>
#include <string>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/** Positions agree within this, in nm, plus the rounding of a platform that has them in single precision. */
static const double TOLERANCE = 1e-5, RELATIVE_TOLERANCE = 1e-6;

[[noreturn]] static void fail(int particle, const string& what)
{
    throw OpenMMException("StericExclusionForce: the saved state is damaged: particle " + to_string(particle) + " " +
                          what);
}

static bool areNear(double a, double b)
{
    return fabs(a - b) <= TOLERANCE + RELATIVE_TOLERANCE * fabs(b); // false for NaN
}

static bool areNear(const Vec3& a, const Vec3& b)
{
    return areNear(a[0], b[0]) && areNear(a[1], b[1]) && areNear(a[2], b[2]);
}

static double distanceOf(const Vec3& a, const Vec3& b)
{
    const Vec3 difference = a - b;
    return sqrt(difference.dot(difference));
}

KeptGeometry::KeptGeometry(CheckpointReader& reader) : state(reader.readVector<double>())
{
    LimitPolicy::readLimits(reader, limits);
    agreedPositions = reader.readVector<Vec3>();
    LimitPolicy::readStep(reader, limits);
}

void KeptGeometry::check(Scene& scene, const System& system) const
{
    scene.setState(state);
    vector<Vec3> positions;
    if (!state.empty()) {
        scene.setLimits(limits.pairs, limits.limits);
        scene.getPositions(positions);
    }
    if (agreedPositions.empty())
        return;
    if (agreedPositions.size() != positions.size())
        throw OpenMMException("StericExclusionForce: the saved state is damaged: it has " +
                              to_string(agreedPositions.size()) + " positions");

    // OpenMM computes virtual sites itself.

    for (size_t i = 0; i < positions.size(); i++)
        if (!system.isVirtualSite(i) && !areNear(positions[i], agreedPositions[i]))
            fail(i, "is not where its link places it");
}

/**
 * Get whether these are agreedPositions, up to periodic images.
 */
bool KeptGeometry::hasImage(const vector<Vec3>& positions, const BoxVectors& box) const
{
    if (positions.size() != agreedPositions.size())
        return false;
    for (size_t i = 0; i < positions.size(); i++) {
        Vec3 shifted = positions[i];
        for (int j = 2; j >= 0; j--)
            shifted -= box[j] * round((shifted[j] - agreedPositions[i][j]) / box[j][j]);
        if (!areNear(shifted, agreedPositions[i]))
            return false;
    }
    return true;
}

bool KeptGeometry::checkPositions(const vector<Vec3>& positions, const BoxVectors& box, const System& system,
                                  const LinkStructure& structure, const StericExclusionForce& force) const
{
    if (positions.size() != agreedPositions.size())
        return false;
    const bool isImage = hasImage(positions, box);
    int numDifferent = 0, different = -1;
    bool someAreSame = false;
    for (size_t i = 0; i < positions.size(); i++) {
        for (int j = 0; j < 3; j++)
            if (positions[i][j] != agreedPositions[i][j]) {
                numDifferent++;
                different = i;
            }
        someAreSame |= different != (int)i && system.getParticleMass(i) != 0;
    }
    if (numDifferent == 1 && !isImage)
        fail(different, "alone is elsewhere, in one coordinate");
    if (!someAreSame || structure.isFlexible())
        return isImage;

    // The distances to the first particle of a link and to the previous one determine its shape.

    const vector<int>& links = structure.getParticleLinks();
    vector<int> first(structure.getLinks().size(), -1), last(first);
    for (int i = 0; i < (int)positions.size(); i++) {
        if (system.isVirtualSite(i))
            continue;
        if (first[links[i]] == -1)
            first[links[i]] = last[links[i]] = i;
        checkDistance(positions, i, first[links[i]]);
        checkDistance(positions, i, last[links[i]]);
        last[links[i]] = i;
    }
    for (int i = 0; i < force.getNumBonds(); i++) {
        int particle1, particle2;
        force.getBondParticles(i, particle1, particle2);
        if (!system.isVirtualSite(particle1) && !system.isVirtualSite(particle2))
            checkDistance(positions, particle1, particle2);
    }
    return isImage;
}

void KeptGeometry::checkDistance(const vector<Vec3>& positions, int particle1, int particle2) const
{
    if (!areNear(distanceOf(positions[particle1], positions[particle2]),
                 distanceOf(agreedPositions[particle1], agreedPositions[particle2])))
        fail(particle1, "has another distance from particle " + to_string(particle2) + ", to which it is bound");
}
