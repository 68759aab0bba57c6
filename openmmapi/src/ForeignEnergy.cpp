#include "openmmchaintree/internal/ForeignEnergy.h"
#include <limits>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

bool ForeignEnergy::begin(TrialSession& trials)
{
    parts = native.getForeignOfTrials();
    if (parts.empty())
        return false;
    energy = native.getForeign().computeEnergy(trials, parts);
    if (!NativeEnergy::isPossible(energy))
        native.refuseState(trials);
    return true;
}

double ForeignEnergy::computeEnergyChange(TrialSession& trials)
{
    trials.showProposal();
    proposedEnergy = native.getForeign().computeEnergy(trials, parts);
    if (!NativeEnergy::isPossible(proposedEnergy))
        return numeric_limits<double>::quiet_NaN();
    if (proposedEnergy == energy && energy == numeric_limits<double>::infinity())
        return 0;
    return proposedEnergy - energy - (native.getForeign().areMixed() ? native.getComputedChange() : 0);
}

void ForeignEnergy::accept()
{
    energy = proposedEnergy;
}
