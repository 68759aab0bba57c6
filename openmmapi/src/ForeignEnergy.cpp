#include "openmmchaintree/internal/ForeignEnergy.h"
#include "openmm/OpenMMException.h"
#include <limits>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Get whether an energy is one that a state can have: neither NaN nor minus infinity, whose probability no other state
 * would have a part of.
 */
static bool isEnergy(double energy)
{
    return energy > -numeric_limits<double>::infinity();
}

bool ForeignEnergy::begin(TrialSession& trials)
{
    groups = native.leavesForeignToOuterTest() ? 0 : native.getForeignGroups();
    if (groups == 0)
        return false;
    energy = trials.computeOtherEnergy(groups);
    if (!isEnergy(energy))
        fail(trials);
    return true;
}

/**
 * Throw an exception that names those of the Forces whose groups have no energy by themselves.
 */
void ForeignEnergy::fail(TrialSession& trials) const
{
    int failing = 0;
    for (int group = 0; group < numeric_limits<unsigned int>::digits; group++) {
        const int mask = groups & (int)(1u << group);
        if (mask != 0 && !isEnergy(trials.computeOtherEnergy(mask)))
            failing |= mask;
    }
    throw OpenMMException("TorsionMonteCarloIntegrator: the energy of the integration force groups is not a number: "
                          "that of " +
                          native.describeForeignForces(failing != 0 ? failing : groups));
}

double ForeignEnergy::computeChange(TrialSession& trials)
{
    proposedEnergy = trials.computeOtherEnergyOfProposal(groups);
    if (!isEnergy(proposedEnergy))
        return numeric_limits<double>::quiet_NaN();
    if (proposedEnergy == energy && energy == numeric_limits<double>::infinity())
        return 0;
    return proposedEnergy - energy - (native.sharesForeignGroups() ? native.getComputedChange() : 0);
}

void ForeignEnergy::accept()
{
    energy = proposedEnergy;
}
