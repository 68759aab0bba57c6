#include "ReferenceChainTreeKernelFactory.h"
#include "openmm/internal/windowsExport.h"
#include "openmm/OpenMMException.h"
#include "openmm/Platform.h"
#include "openmm/reference/ReferencePlatform.h"
#include "ReferenceChainTreeKernels.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

#ifdef _MSC_VER
#define PLUGIN_EXPORT __declspec(dllexport)
#else
#define PLUGIN_EXPORT __attribute__((visibility("default")))
#endif

// Platform::loadPluginLibrary() looks for these two functions.

extern "C" PLUGIN_EXPORT void registerPlatforms()
{
}

extern "C" PLUGIN_EXPORT void registerKernelFactories()
{
    for (int i = 0; i < Platform::getNumPlatforms(); i++) {
        Platform& platform = Platform::getPlatform(i);
        if (dynamic_cast<ReferencePlatform*>(&platform) != NULL)
            platform.registerKernelFactory(CalcStericExclusionForceKernel::Name(),
                                           new ReferenceChainTreeKernelFactory());
    }
}

// For programs that link to this library instead of loading it as a plugin.

extern "C" PLUGIN_EXPORT void registerChainTreeReferenceKernelFactories()
{
    registerKernelFactories();
}

KernelImpl* ReferenceChainTreeKernelFactory::createKernelImpl(string name, const Platform& platform, ContextImpl&) const
{
    if (name == CalcStericExclusionForceKernel::Name())
        return new ReferenceCalcStericExclusionForceKernel(name, platform);
    throw OpenMMException("Tried to create kernel with illegal kernel name '" + name + "'");
}
