#include "openmm/serialization/SerializationProxy.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include "openmmchaintree/StericExclusionForce.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "StericExclusionForceProxy.h"
#include "TorsionMonteCarloIntegratorProxy.h"
#include <typeinfo>

using namespace ChainTreePlugin;
using namespace OpenMM;

// A linker may omit the initializer below from a static library; the program must then call this function.

extern "C" OPENMM_EXPORT_CHAINTREE void registerChainTreeSerializationProxies()
{
    SerializationProxy::registerProxy(typeid(StericExclusionForce), new StericExclusionForceProxy());
    SerializationProxy::registerProxy(typeid(TorsionMonteCarloIntegrator), new TorsionMonteCarloIntegratorProxy());
}

// Registers the proxies when a program loads this library.

static const bool proxiesAreRegistered = (registerChainTreeSerializationProxies(), true);
