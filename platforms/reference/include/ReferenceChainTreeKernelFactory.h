#ifndef OPENMM_REFERENCECHAINTREEKERNELFACTORY_H_
#define OPENMM_REFERENCECHAINTREEKERNELFACTORY_H_

#include "openmm/KernelFactory.h"
#include <string>

namespace ChainTreePlugin {

/**
 * This KernelFactory creates the kernels of the Reference platform, which serve the CPU platform too.
 */
class ReferenceChainTreeKernelFactory : public OpenMM::KernelFactory {
public:
    OpenMM::KernelImpl* createKernelImpl(std::string name, const OpenMM::Platform& platform,
                                         OpenMM::ContextImpl& context) const;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_REFERENCECHAINTREEKERNELFACTORY_H_*/
