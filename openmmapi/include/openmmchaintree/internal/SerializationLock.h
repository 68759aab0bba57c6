#ifndef OPENMM_CHAINTREE_SERIALIZATIONLOCK_H_
#define OPENMM_CHAINTREE_SERIALIZATIONLOCK_H_

#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <mutex>

namespace ChainTreePlugin {

/**
 * Held by whoever turns numbers into text, or text into numbers, as OpenMM's XML does: those functions of OpenMM share
 * memory among all threads, and steps of several Contexts may run at a time.
 */
class OPENMM_EXPORT_CHAINTREE SerializationLock {
public:
    SerializationLock();

private:
    std::lock_guard<std::recursive_mutex> lock;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_SERIALIZATIONLOCK_H_*/
