#ifndef OPENMM_CHAINTREE_FOREIGNCOPIES_H_
#define OPENMM_CHAINTREE_FOREIGNCOPIES_H_

#include "openmm/Context.h"
#include "openmm/Force.h"
#include "openmm/internal/ContextImpl.h"
#include "openmm/System.h"
#include "openmm/VerletIntegrator.h"
#include <memory>
#include <vector>

namespace ChainTreePlugin {

/**
 * An inner Context that evaluates copies of some Forces of another, one by one, on the same device. It is given the
 * other's positions, box and parameters before it evaluates. A copy has the parameters that its Force had when it was
 * made, so it has to be made again when some Force was copied to the Context.
 */
class ForeignCopies {
public:
    /** The number of force groups. */
    static const int MOST_FORCES = 32;
    /**
     * Get whether a copy has the same energy as the Force. This holds for classes of OpenMM whose energy depends on
     * positions, box and parameters alone. Other Forces may have a memory, or hold other Forces or programs.
     */
    static bool canCopy(const OpenMM::Force& force);
    ForeignCopies(OpenMM::ContextImpl& context, const std::vector<const OpenMM::Force*>& forces);
    /**
     * Compute the energy of some of the Forces at the positions of the other Context.
     */
    double computeEnergy(const std::vector<int>& chosen);

private:
    OpenMM::ContextImpl& outer;
    OpenMM::System system;
    OpenMM::VerletIntegrator integrator;
    std::unique_ptr<OpenMM::Context> inner;
    std::vector<OpenMM::Vec3> positions;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_FOREIGNCOPIES_H_*/
