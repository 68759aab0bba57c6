#ifndef OPENMM_CHAINTREE_VIRTUALPLACE_H_
#define OPENMM_CHAINTREE_VIRTUALPLACE_H_

#include "openmm/System.h"
#include "openmm/Vec3.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <vector>

namespace ChainTreePlugin {

/**
 * Where a virtual site is for given positions of the particles that define it, as OpenMM computes it for a whole
 * System.
 */
class OPENMM_EXPORT_CHAINTREE VirtualPlace {
public:
    VirtualPlace(const OpenMM::System& system, int site);
    /**
     * Get whether compute() knows this kind of site. It does not know sites that are images by symmetry.
     */
    bool isKnown() const
    {
        return kind != Unknown;
    }
    int getSite() const
    {
        return site;
    }
    /**
     * Get the particles that define the site.
     */
    const std::vector<int>& getParticles() const
    {
        return particles;
    }
    /**
     * Compute the position of the site.
     *
     * @param positions  where getParticles() are; there may be more
     */
    OpenMM::Vec3 compute(const std::vector<OpenMM::Vec3>& positions) const;

private:
    enum Kind { Average, OutOfPlane, LocalCoordinates, Unknown };
    OpenMM::Vec3 average(const std::vector<double>& weights, const std::vector<OpenMM::Vec3>& positions) const;
    int site;
    Kind kind;
    std::vector<int> particles;
    /** The weights of an average or of the origin of local coordinates, and of their axes. Of a site out of plane the
     *  first are the weights of the differences and of their cross product. */
    std::vector<double> weights, xWeights, yWeights;
    OpenMM::Vec3 local;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_VIRTUALPLACE_H_*/
