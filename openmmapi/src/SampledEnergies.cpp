/* The methods of TorsionMonteCarloIntegrator about energies. */

#include "openmm/internal/ContextImpl.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ContextLock.h"
#include "openmmchaintree/internal/EnergyStage.h"
#include "openmmchaintree/internal/ForeignEnergy.h"
#include "openmmchaintree/internal/NativeEnergy.h"
#include "openmmchaintree/internal/OuterTest.h"
#include "openmmchaintree/internal/SoftSphereEnergy.h"
#include "openmmchaintree/internal/StericExclusionForceImpl.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include <cmath>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

bool TorsionMonteCarloIntegrator::getNativeEnergies() const
{
    return nativeEnergies;
}

void TorsionMonteCarloIntegrator::setNativeEnergies(bool native)
{
    nativeEnergies = native;
}

// ---- Outer tests and stand-ins ----

int TorsionMonteCarloIntegrator::getTrialsPerOuterTest() const
{
    return trialsPerOuterTest;
}

void TorsionMonteCarloIntegrator::setTrialsPerOuterTest(int trials)
{
    if (trials < 0)
        throw OpenMMException("TorsionMonteCarloIntegrator: the number of trials to an outer test must be at least 0, "
                              "but is " +
                              to_string(trials));
    trialsPerOuterTest = trials;
}

void TorsionMonteCarloIntegrator::getOuterStatistics(long long& attempted, long long& accepted,
                                                     long long& trialsTakenBack, double& meanDifference,
                                                     double& standardDeviation) const
{
    ContextUse use(lock, ContextLock::User);
    attempted = outerStatistics->attempted;
    accepted = outerStatistics->accepted;
    trialsTakenBack = outerStatistics->trialsTakenBack;
    meanDifference = outerStatistics->mean;
    standardDeviation = outerStatistics->getStandardDeviation();
}

void TorsionMonteCarloIntegrator::renewStandIns(Context& context)
{
    ContextUse use(lock, ContextLock::User);
    requireContext(context);
    native->updatePlan();
    TrialSession trials(*force, *this->context, force->getTrialScene(), TrialSession::IgnoreLimits);
    native->renewStandIn();
}

static void checkPositive(double value, const string& name)
{
    if (!(value > 0) || !isfinite(value))
        throw OpenMMException("TorsionMonteCarloIntegrator: " + name + " must be a finite number above 0, but is " +
                              to_string(value));
}

void TorsionMonteCarloIntegrator::getStandInCutoffs(double& bornCutoff, double& pairCutoff) const
{
    bornCutoff = standInBornCutoff;
    pairCutoff = standInPairCutoff;
}

void TorsionMonteCarloIntegrator::setStandInCutoffs(double bornCutoff, double pairCutoff)
{
    checkPositive(bornCutoff, "the bornCutoff of stand-ins");
    checkPositive(pairCutoff, "the pairCutoff of stand-ins");
    standInBornCutoff = bornCutoff;
    standInPairCutoff = pairCutoff;
}

double TorsionMonteCarloIntegrator::getStandInGridWidth() const
{
    return standInGridWidth;
}

void TorsionMonteCarloIntegrator::setStandInGridWidth(double width)
{
    checkPositive(width, "the grid width of stand-ins");
    standInGridWidth = width;
}

// ---- In a Context ----

/**
 * Make the stages of U, cheapest first.
 */
void TorsionMonteCarloIntegrator::bindEnergies(StericExclusionForceImpl& force, ContextImpl& context)
{
    native.reset(new NativeEnergy(*this, force, context));
    stages.reset(new EnergyStages());
    stages->add(make_unique<NativeEnergyStage>(*native, ctTermsPart));
    stages->add(make_unique<NativeEnergyStage>(*native, ctNearPairsPart));
    stages->add(make_unique<SoftSphereEnergy>(*native));
    stages->add(make_unique<NativeEnergyStage>(*native, ctOtherPairsPart));
    stages->add(make_unique<ValueEnergyStage>(*native));
    stages->add(make_unique<ForeignEnergy>(*native));
}

vector<TorsionMonteCarloIntegrator::PlannedEnergy> TorsionMonteCarloIntegrator::getEnergyPlan(Context& context) const
{
    ContextUse use(lock, ContextLock::User);
    requireContext(context);
    vector<PlannedEnergy> planned;
    for (const EnergyPlan::Entry& entry : native->describePlan())
        planned.push_back({(int)planned.size(), entry.name, (EnergyKind)entry.kind, entry.reason});
    return planned;
}

double TorsionMonteCarloIntegrator::getPotentialEnergy(Context& context) const
{
    ContextUse use(lock, ContextLock::User);
    requireContext(context);
    native->updatePlan();
    TrialSession trials(*force, *this->context, force->getTrialScene(), TrialSession::IgnoreLimits);
    return native->computeEnergy(trials) + (native->getStericMode() == Soft ? trials.computeSoftEnergy() : 0);
}

vector<TorsionMonteCarloIntegrator::StageStatistics> TorsionMonteCarloIntegrator::getStageStatistics() const
{
    ContextUse use(lock, ContextLock::User);
    requireBound();
    vector<StageStatistics> counts;
    for (int i = 0; i < stages->size(); i++) {
        const EnergyStages::Statistics& statistics = stages->getStatistics(i);
        counts.push_back({stages->get(i).getName(), statistics.computed, statistics.rejected});
    }
    return counts;
}
