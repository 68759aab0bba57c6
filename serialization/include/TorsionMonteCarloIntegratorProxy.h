#ifndef OPENMM_TORSIONMONTECARLOINTEGRATORPROXY_H_
#define OPENMM_TORSIONMONTECARLOINTEGRATORPROXY_H_

#include "openmm/serialization/SerializationProxy.h"

namespace ChainTreePlugin {

/**
 * This is a proxy for serializing TorsionMonteCarloIntegrator objects.
 */
class TorsionMonteCarloIntegratorProxy : public OpenMM::SerializationProxy {
public:
    TorsionMonteCarloIntegratorProxy();
    void serialize(const void* object, OpenMM::SerializationNode& node) const;
    void* deserialize(const OpenMM::SerializationNode& node) const;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_TORSIONMONTECARLOINTEGRATORPROXY_H_*/
