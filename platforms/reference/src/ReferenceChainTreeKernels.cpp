#include "ReferenceChainTreeKernels.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

void ReferenceCalcStericExclusionForceKernel::initialize(const StericExclusionForce& force,
                                                         const LinkStructure& structure)
{
    scene.reset(new Scene(force, structure));
}

double ReferenceCalcStericExclusionForceKernel::execute(vector<Vec3>& forces)
{
    return scene->computeEnergy(forces);
}

void ReferenceCalcStericExclusionForceKernel::copyParametersToContext(ContextImpl&, const StericExclusionForce& force)
{
    scene->copyParameters(force);
}
