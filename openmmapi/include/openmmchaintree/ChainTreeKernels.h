#ifndef OPENMM_CHAINTREEKERNELS_H_
#define OPENMM_CHAINTREEKERNELS_H_

#include "openmm/internal/ContextImpl.h"
#include "openmm/KernelImpl.h"
#include "openmm/Platform.h"
#include "openmm/Vec3.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/internal/Scene.h"
#include "openmmchaintree/StericExclusionForce.h"
#include <string>
#include <vector>

namespace ChainTreePlugin {

/**
 * This kernel is invoked by StericExclusionForceImpl. It makes the Scene of the force and hands it over; queries and
 * trials call the Scene directly. It does not need a Context, so that a Context of any Platform can use the kernel
 * of the Reference platform.
 */
class CalcStericExclusionForceKernel : public OpenMM::KernelImpl {
public:
    static std::string Name()
    {
        return "CalcStericExclusionForce";
    }
    CalcStericExclusionForceKernel(std::string name, const OpenMM::Platform& platform) :
        OpenMM::KernelImpl(name, platform)
    {
    }
    /**
     * Initialize the kernel.
     *
     * @param force      the StericExclusionForce this kernel will be used for
     * @param structure  its links
     */
    virtual void initialize(const StericExclusionForce& force, const LinkStructure& structure) = 0;
    /**
     * Compute the energy of the Scene's state and replace forces by its negative gradient.
     */
    virtual double execute(std::vector<OpenMM::Vec3>& forces) = 0;
    /**
     * Copy changed parameters over to the Scene. If this throws an exception, nothing has changed.
     */
    virtual void copyParametersToContext(OpenMM::ContextImpl& context, const StericExclusionForce& force) = 0;
    /**
     * Get the Scene, which lives as long as this kernel.
     */
    virtual Scene& getScene() = 0;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREEKERNELS_H_*/
