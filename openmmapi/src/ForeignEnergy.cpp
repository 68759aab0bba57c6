#include "openmmchaintree/internal/ForeignEnergy.h"
#include <limits>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

bool ForeignEnergy::begin(TrialSession& trials)
{
    groups = native.leavesForeignToOuterTest() ? 0 : native.getForeignGroups();
    if (groups == 0)
        return false;
    energy = trials.computeOtherEnergy(groups);
    if (!NativeEnergy::isPossible(energy))
        native.refuseState(trials);
    return true;
}

double ForeignEnergy::computeChange(TrialSession& trials)
{
    proposedEnergy = trials.computeOtherEnergyOfProposal(groups);
    if (!NativeEnergy::isPossible(proposedEnergy))
        return numeric_limits<double>::quiet_NaN();
    if (proposedEnergy == energy && energy == numeric_limits<double>::infinity())
        return 0;
    return proposedEnergy - energy - (native.sharesForeignGroups() ? native.getComputedChange() : 0);
}

void ForeignEnergy::accept()
{
    energy = proposedEnergy;
}
