#ifndef OPENMM_REFERENCECHAINTREEKERNELS_H_
#define OPENMM_REFERENCECHAINTREEKERNELS_H_

#include "openmmchaintree/ChainTreeKernels.h"
#include <memory>
#include <string>
#include <vector>

namespace ChainTreePlugin {

/**
 * This kernel owns the Scene of a StericExclusionForce.
 */
class ReferenceCalcStericExclusionForceKernel : public CalcStericExclusionForceKernel {
public:
    ReferenceCalcStericExclusionForceKernel(std::string name, const OpenMM::Platform& platform) :
        CalcStericExclusionForceKernel(name, platform)
    {
    }
    void initialize(const StericExclusionForce& force, const LinkStructure& structure);
    double execute(std::vector<OpenMM::Vec3>& forces);
    void copyParametersToContext(OpenMM::ContextImpl& context, const StericExclusionForce& force);
    Scene& getScene()
    {
        return *scene;
    }

private:
    std::unique_ptr<Scene> scene;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_REFERENCECHAINTREEKERNELS_H_*/
