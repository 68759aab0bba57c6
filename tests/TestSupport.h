#ifndef OPENMM_CHAINTREE_TESTSUPPORT_H_
#define OPENMM_CHAINTREE_TESTSUPPORT_H_

/**
 * Common code of the tests of the C++ classes: running them on a platform, expecting errors, and chains of beads.
 */

#include "openmm/Context.h"
#include "openmm/internal/AssertionUtilities.h"
#include "openmm/OpenMMException.h"
#include "openmm/Platform.h"
#include "openmm/System.h"
#include "openmm/Vec3.h"
#include "openmmchaintree/internal/Warnings.h"
#include "openmmchaintree/StericExclusionForce.h"
#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

extern "C" void registerChainTreeReferenceKernelFactories();

namespace ChainTreePlugin {

/**
 * Takes no notice of a warning. Tests of warnings set a handler of their own.
 */
inline void ignoreWarning(const std::string&)
{
}

/**
 * Run tests on a platform, at each precision if it has a choice.
 */
inline void runAtEveryPrecision(OpenMM::Platform& platform, const std::function<void(OpenMM::Platform&)>& tests)
{
    const std::vector<std::string>& properties = platform.getPropertyNames();
    if (std::find(properties.begin(), properties.end(), "Precision") == properties.end()) {
        tests(platform);
        return;
    }
    for (const std::string precision : {"double", "mixed", "single"}) {
        std::cout << "Precision: " << precision << std::endl;
        platform.setPropertyDefaultValue("Precision", precision);
        tests(platform);
    }
}

/**
 * Run tests on the platform of a name. The result is that of the program: 0 if they pass, 1 if one fails, 77 if there
 * is no such platform.
 */
inline int runOnPlatform(const std::string& name, const std::function<void(OpenMM::Platform&)>& tests)
{
    try {
        OpenMM::Platform::loadPluginsFromDirectory(OpenMM::Platform::getDefaultPluginsDirectory());
        registerChainTreeReferenceKernelFactories();
        setWarningHandler(ignoreWarning);
        for (int i = 0; i < OpenMM::Platform::getNumPlatforms(); i++)
            if (OpenMM::Platform::getPlatform(i).getName() == name) {
                runAtEveryPrecision(OpenMM::Platform::getPlatform(i), tests);
                std::cout << "Done" << std::endl;
                return 0;
            }
        std::cout << "Skipped: there is no platform " << name << std::endl;
        return 77;
    }
    catch (const std::exception& e) {
        std::cout << "exception: " << e.what() << std::endl;
        return 1;
    }
}

/**
 * Get the precision at which a platform runs. Reference and CPU have no choice.
 */
inline std::string getPrecision(const OpenMM::Platform& platform)
{
    const std::vector<std::string>& names = platform.getPropertyNames();
    bool hasChoice = (std::find(names.begin(), names.end(), "Precision") != names.end());
    return hasChoice ? platform.getPropertyDefaultValue("Precision") : "double";
}

/**
 * Get how far from where it was set a particle can be, in nm, within 16 nm from the origin. At mixed precision a
 * coordinate is the sum of two floats.
 */
inline double getRounding(const OpenMM::Platform& platform)
{
    std::string precision = getPrecision(platform);
    return precision == "single" ? 1e-6 : precision == "mixed" ? 1e-13 : 0;
}

/**
 * Get a tolerance for what is computed from positions.
 */
inline double getTolerance(const OpenMM::Platform& platform)
{
    return 1e-12 + 10 * getRounding(platform);
}

/**
 * Whether LocalEnergyMinimizer is reliable. On OpenCL with PoCL it sometimes crashes in its kernel getScale, with any
 * forces.
 */
inline bool canMinimize(const OpenMM::Platform& platform)
{
    return platform.getName() != "OpenCL";
}

/**
 * Check that something throws an OpenMMException whose message contains a text.
 */
inline void assertThrows(const std::string& text, const std::function<void()>& action)
{
    std::string message = "no exception";
    try {
        action();
    }
    catch (const OpenMM::OpenMMException& e) {
        message = e.what();
    }
    if (message.find(text) == std::string::npos)
        throw OpenMM::OpenMMException("Expected an exception about \"" + text + "\", found: " + message);
}

/**
 * Check that two sets of positions have the same bits.
 */
inline void assertSameBits(const std::vector<OpenMM::Vec3>& expected, const std::vector<OpenMM::Vec3>& found)
{
    using OpenMM::throwException;
    ASSERT_EQUAL(expected.size(), found.size());
    for (size_t i = 0; i < expected.size(); i++)
        for (int j = 0; j < 3; j++)
            ASSERT_EQUAL(expected[i][j], found[i][j]);
}

/**
 * Check that positions are the set ones, up to the rounding of the platform.
 */
inline void assertRounded(const OpenMM::Platform& platform, const std::vector<OpenMM::Vec3>& expected,
                          const std::vector<OpenMM::Vec3>& found)
{
    using OpenMM::throwException;
    ASSERT_EQUAL(expected.size(), found.size());
    for (size_t i = 0; i < expected.size(); i++)
        for (int j = 0; j < 3; j++)
            ASSERT(std::fabs(expected[i][j] - found[i][j]) <= getRounding(platform));
}

inline std::vector<OpenMM::Vec3> getPositions(const OpenMM::Context& context)
{
    return context.getState(OpenMM::State::Positions).getPositions();
}

inline double getDistance(const OpenMM::Vec3& a, const OpenMM::Vec3& b)
{
    return std::sqrt((a - b).dot(a - b));
}

/**
 * The IUPAC dihedral of four points, in (-pi, pi].
 */
inline double getDihedral(const OpenMM::Vec3& p1, const OpenMM::Vec3& p2, const OpenMM::Vec3& p3,
                          const OpenMM::Vec3& p4)
{
    OpenMM::Vec3 b1 = p2 - p1, b2 = p3 - p2, b3 = p4 - p3;
    return std::atan2(b1.dot(b2.cross(b3)) * std::sqrt(b2.dot(b2)), b1.cross(b2).dot(b2.cross(b3)));
}

/**
 * A point turned about an axis through a center.
 */
inline OpenMM::Vec3 rotate(const OpenMM::Vec3& point, const OpenMM::Vec3& center, const OpenMM::Vec3& axis,
                           double angle)
{
    OpenMM::Vec3 u = axis / std::sqrt(axis.dot(axis));
    OpenMM::Vec3 v = point - center;
    return center + v * std::cos(angle) + u.cross(v) * std::sin(angle) + u * (u.dot(v) * (1 - std::cos(angle)));
}

/**
 * Beads in a row, 1 nm apart, with bond angles of 90 degrees and a torsion about every bond but the first and the last.
 * All beads have one radius, exclusions reach over two bonds, and no overlap is tolerated. Torsion i is that of beads
 * i ... i+3.
 */
class BeadChain {
public:
    /**
     * @param length    the number of beads
     * @param radius    their radius, in nm
     * @param dihedral  the value of all torsions, in radians; pi makes a zigzag in a plane
     */
    BeadChain(int length, double radius, double dihedral = M_PI) : force(new StericExclusionForce())
    {
        system.addForce(force);
        force->setOverlapTolerance(0);
        addMolecule(length, radius, dihedral, OpenMM::Vec3());
    }
    /**
     * Add one more chain, and return its first bead.
     */
    int addMolecule(int length, double radius, double dihedral, const OpenMM::Vec3& origin)
    {
        int first = system.getNumParticles();
        for (int i = 0; i < length; i++) {
            system.addParticle(1);
            force->addParticle(radius);
            positions.push_back(origin + place(i, dihedral, first));
            if (i > 0)
                force->addBond(first + i - 1, first + i);
            if (i > 2)
                force->addTorsion(first + i - 3, first + i - 2, first + i - 1, first + i);
        }
        for (int i = 0; i < length; i++)
            for (int j = i + 1; j < std::min(i + 3, length); j++)
                force->addExclusion(first + i, first + j);
        return first;
    }
    OpenMM::System system;
    StericExclusionForce* force;
    std::vector<OpenMM::Vec3> positions;

private:
    OpenMM::Vec3 place(int i, double dihedral, int first) const
    {
        if (i < 3)
            return std::vector<OpenMM::Vec3>{{0, 1, 0}, {0, 0, 0}, {1, 0, 0}}[i];
        OpenMM::Vec3 origin = positions[first] - OpenMM::Vec3(0, 1, 0);
        OpenMM::Vec3 p1 = positions[first + i - 3], p2 = positions[first + i - 2], p3 = positions[first + i - 1];
        return rotate(p3 + (p1 - p2), p3, p3 - p2, dihedral) - origin;
    }
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_TESTSUPPORT_H_*/
