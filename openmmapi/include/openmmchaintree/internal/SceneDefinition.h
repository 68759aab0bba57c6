#ifndef OPENMM_CHAINTREE_SCENEDEFINITION_H_
#define OPENMM_CHAINTREE_SCENEDEFINITION_H_

#include "chaintree.h"
#include "openmm/Vec3.h"
#include "openmmchaintree/internal/BoxVectors.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/StericExclusionForce.h"
#include <array>
#include <cstdint>
#include <vector>

namespace ChainTreePlugin {

/**
 * The definition of a Scene in the arrays that the engine takes, and the links there of torsions, ball joints and
 * molecules.
 */
class SceneDefinition {
public:
    SceneDefinition(const StericExclusionForce& force, const LinkStructure& structure);
    /** The values that StericExclusionForce::updateParametersInContext() changes. */
    struct Parameters {
        explicit Parameters(const StericExclusionForce& force);
        double getTolerance(int particle1, int particle2) const;
        std::vector<double> radii;
        std::vector<uint8_t> roles;
        double overlapTolerance, hydrogenBondAllowance, forceConstant;
    };
    int getNumParticles() const
    {
        return particleLinks.size();
    }
    int getNumLinks() const
    {
        return linkParents.size();
    }
    /**
     * Describe the scene in arrays that belong to this object or the caller.
     */
    ctDefinition describe(const std::vector<OpenMM::Vec3>& positions) const;
    Parameters parameters;
    /** Marks particles without a radius that are in leaves because the energy needs them; empty if there are none. */
    std::vector<uint8_t> listed;
    /** Whether images in the box count. Without it, the box is not read. */
    bool isPeriodic;
    /** Whether trials may displace particles within their links. */
    bool isFlexible;
    BoxVectors box;
    std::vector<int> torsionLinks, ballJointLinks, moleculeRoots;

private:
    std::vector<int> particleLinks;
    std::vector<int> linkParents;
    std::vector<uint8_t> linkJoints;
    std::vector<std::array<int, 4>> linkTorsions;
    std::vector<std::array<int, 2>> exclusions;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_SCENEDEFINITION_H_*/
