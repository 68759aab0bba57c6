#include "openmm/serialization/SerializationProxy.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include "openmmchaintree/StericExclusionForce.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "StericExclusionForceProxy.h"
#include "TorsionMonteCarloIntegratorProxy.h"
#include <typeinfo>

using namespace ChainTreePlugin;
using namespace OpenMM;

// From a static library a linker may leave out the initializer below; then a program calls this itself.

extern "C" OPENMM_EXPORT_CHAINTREE void registerChainTreeSerializationProxies()
{
    SerializationProxy::registerProxy(typeid(StericExclusionForce), new StericExclusionForceProxy());
    SerializationProxy::registerProxy(typeid(TorsionMonteCarloIntegrator), new TorsionMonteCarloIntegratorProxy());
}

// A program that loads this library can read and write the XML of its classes.

static const bool proxiesAreRegistered = (registerChainTreeSerializationProxies(), true);
