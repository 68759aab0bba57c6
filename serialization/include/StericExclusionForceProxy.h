#ifndef OPENMM_STERICEXCLUSIONFORCEPROXY_H_
#define OPENMM_STERICEXCLUSIONFORCEPROXY_H_

#include "openmm/serialization/SerializationProxy.h"

namespace ChainTreePlugin {

/**
 * This is a proxy for serializing StericExclusionForce objects.
 */
class StericExclusionForceProxy : public OpenMM::SerializationProxy {
public:
    StericExclusionForceProxy();
    void serialize(const void* object, OpenMM::SerializationNode& node) const;
    void* deserialize(const OpenMM::SerializationNode& node) const;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_STERICEXCLUSIONFORCEPROXY_H_*/
