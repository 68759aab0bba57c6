#include "openmmchaintree/internal/ForeignEnergy.h"
#include "openmm/AndersenThermostat.h"
#include "openmm/CMMotionRemover.h"
#include "openmm/NonbondedForce.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/StericExclusionForce.h"
#include <limits>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Get the groups of all Forces that can contribute to U, as a bit mask. OpenMM too goes by the groups that Forces had
 * when the Context was created.
 */
static int findGroupsWithEnergy(const System& system)
{
    unsigned int groups = 0;
    for (int i = 0; i < system.getNumForces(); i++) {
        const Force* force = &system.getForce(i);
        if (dynamic_cast<const CMMotionRemover*>(force) != NULL ||
            dynamic_cast<const AndersenThermostat*>(force) != NULL ||
            dynamic_cast<const StericExclusionForce*>(force) != NULL)
            continue;
        groups |= 1u << force->getForceGroup();
        const NonbondedForce* nonbonded = dynamic_cast<const NonbondedForce*>(force);
        if (nonbonded != NULL && nonbonded->getReciprocalSpaceForceGroup() >= 0)
            groups |= 1u << nonbonded->getReciprocalSpaceForceGroup();
    }
    return groups;
}

/**
 * Get whether an energy is one that a state can have: neither NaN nor minus infinity, whose probability no other state
 * would have a part of.
 */
static bool isEnergy(double energy)
{
    return energy > -numeric_limits<double>::infinity();
}

ForeignEnergy::ForeignEnergy(const Integrator& integrator, const System& system) :
    integrator(integrator), groupsWithEnergy(findGroupsWithEnergy(system)), groups(0), energy(0), proposedEnergy(0)
{
}

bool ForeignEnergy::begin(TrialSession& trials)
{
    groups = integrator.getIntegrationForceGroups() & groupsWithEnergy;
    if (groups == 0)
        return false;
    energy = trials.computeOtherEnergy(groups);
    if (!isEnergy(energy))
        throw OpenMMException(
            "TorsionMonteCarloIntegrator: the energy of the integration force groups is not a number");
    return true;
}

double ForeignEnergy::computeChange(TrialSession& trials)
{
    proposedEnergy = trials.computeOtherEnergyOfProposal(groups);
    if (!isEnergy(proposedEnergy))
        return numeric_limits<double>::quiet_NaN();
    return proposedEnergy == energy ? 0 : proposedEnergy - energy; // Both may be infinite.
}

void ForeignEnergy::accept()
{
    energy = proposedEnergy;
}
