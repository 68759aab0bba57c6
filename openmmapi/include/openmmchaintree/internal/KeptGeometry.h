#ifndef OPENMM_CHAINTREE_KEPTGEOMETRY_H_
#define OPENMM_CHAINTREE_KEPTGEOMETRY_H_

#include "openmm/System.h"
#include "openmm/Vec3.h"
#include "openmmchaintree/internal/BoxVectors.h"
#include "openmmchaintree/internal/CheckpointStream.h"
#include "openmmchaintree/internal/LimitPolicy.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/internal/Scene.h"
#include "openmmchaintree/StericExclusionForce.h"
#include <vector>

namespace ChainTreePlugin {

/**
 * The geometry in a checkpoint or State, which is read and checked before it is used.
 */
class KeptGeometry {
public:
    /**
     * Read the result of StericExclusionForceImpl::createCheckpoint().
     */
    explicit KeptGeometry(CheckpointReader& reader);
    /**
     * Throw an exception if a scene would refuse a part, or if the state disagrees with agreedPositions.
     *
     * @param scene  another scene of the same structure, whose state becomes the kept one
     */
    void check(Scene& scene, const OpenMM::System& system) const;
    /**
     * Throw an exception if only damage can have made these positions from agreedPositions: if one number
     * alone differs, or if some particles are where they were, but a rigid link has another shape or a bond another
     * length.
     * Returns whether they are the same but for periodic images.
     */
    bool checkPositions(const std::vector<OpenMM::Vec3>& positions, const BoxVectors& box, const OpenMM::System& system,
                        const LinkStructure& structure, const StericExclusionForce& force) const;
    /** The scene's state. */
    std::vector<double> state;
    LimitPolicy::Kept limits;
    /** The Context's positions when they were last known to agree with the state; empty if there are none. */
    std::vector<OpenMM::Vec3> agreedPositions;

private:
    void checkDistance(const std::vector<OpenMM::Vec3>& positions, int particle1, int particle2) const;
    bool hasImage(const std::vector<OpenMM::Vec3>& positions, const BoxVectors& box) const;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_KEPTGEOMETRY_H_*/
