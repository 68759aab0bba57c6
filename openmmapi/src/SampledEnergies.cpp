/* The calls of TorsionMonteCarloIntegrator that are about energies. */

#include "openmm/internal/ContextImpl.h"
#include "openmmchaintree/internal/EnergyStage.h"
#include "openmmchaintree/internal/ForeignEnergy.h"
#include "openmmchaintree/internal/NativeEnergy.h"
#include "openmmchaintree/internal/SoftSphereEnergy.h"
#include "openmmchaintree/internal/StericExclusionForceImpl.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

typedef CalcStericExclusionForceKernel EnergyKernel;

bool TorsionMonteCarloIntegrator::getNativeEnergies() const
{
    return nativeEnergies;
}

void TorsionMonteCarloIntegrator::setNativeEnergies(bool native)
{
    nativeEnergies = native;
}

/**
 * Make the stages of U, cheapest first.
 */
void TorsionMonteCarloIntegrator::bindEnergies(StericExclusionForceImpl& force, ContextImpl& context)
{
    native.reset(new NativeEnergy(*this, force, context));
    stages.reset(new EnergyStages());
    stages->add(make_unique<NativeEnergyStage>(*native, EnergyKernel::BondedPart));
    stages->add(make_unique<NativeEnergyStage>(*native, EnergyKernel::NearPairsPart));
    stages->add(make_unique<SoftSphereEnergy>(*this));
    stages->add(make_unique<NativeEnergyStage>(*native, EnergyKernel::OtherPairsPart));
    stages->add(make_unique<ForeignEnergy>(*native));
}

vector<TorsionMonteCarloIntegrator::PlannedEnergy> TorsionMonteCarloIntegrator::getEnergyPlan(Context& context) const
{
    requireContext(context);
    vector<PlannedEnergy> planned;
    for (const EnergyPlan::Entry& entry : native->getPlan().getEntries())
        planned.push_back({(int)planned.size(), entry.name, (EnergyKind)entry.kind, entry.reason});
    return planned;
}

double TorsionMonteCarloIntegrator::getPotentialEnergy(Context& context) const
{
    requireContext(context);
    TrialSession trials(*force, *this->context, TrialSession::IgnoreLimits);
    return native->computeEnergy(trials) + (stericMode == Soft ? trials.computeSoftEnergy() : 0);
}

vector<TorsionMonteCarloIntegrator::StageStatistics> TorsionMonteCarloIntegrator::getStageStatistics() const
{
    requireBound();
    vector<StageStatistics> counts;
    for (int i = 0; i < stages->size(); i++) {
        const EnergyStages::Statistics& statistics = stages->getStatistics(i);
        counts.push_back({stages->get(i).getName(), statistics.computed, statistics.rejected});
    }
    return counts;
}
