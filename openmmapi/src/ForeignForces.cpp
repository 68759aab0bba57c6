#include "openmmchaintree/internal/ForeignForces.h"
#include "openmm/reference/ReferencePlatform.h"
#include "openmmchaintree/internal/NativeEnergy.h"
#include <cstdlib>
#include <numeric>
#include <string>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Lets a Context have no ForceImpls but these for as long as it lives, also if an exception ends its life.
 */
class ForceImplGuard {
public:
    ForceImplGuard(ContextImpl& context, const vector<ForceImpl*>& impls) : context(context), others(impls)
    {
        context.getForceImpls().swap(others);
    }
    ~ForceImplGuard()
    {
        context.getForceImpls().swap(others);
    }

private:
    ContextImpl& context;
    vector<ForceImpl*> others;
};

/**
 * Get whether a ForceImpl of a platform evaluates its Force when it is asked. For tests, the environment variable
 * CHAINTREE_FOREIGN=groups says that none does.
 */
static bool letsImplsEvaluate(const Platform& platform)
{
    const char* setting = getenv("CHAINTREE_FOREIGN");
    const bool isSwitchedOff = setting != NULL && string(setting) == "groups";
    return !isSwitchedOff && dynamic_cast<const ReferencePlatform*>(&platform) != NULL;
}

ForeignForces::ForeignForces(ContextImpl& context) :
    context(context), implsEvaluate(letsImplsEvaluate(context.getPlatform())), impls(context.getForceImpls()),
    groups(0), wholeGroups(0), mixed(false)
{
}

void ForeignForces::setForces(const EnergyPlan& plan, int groups, bool allowNative)
{
    this->groups = groups;
    parts.clear();
    partGroups.clear();
    wholeGroups = 0;
    mixed = false;
    forceGroups.clear();
    vector<int> foreign;
    for (const EnergyPlan::Entry& entry : plan.getEntries())
        forceGroups.push_back(entry.groups & groups);
    for (size_t i = 0; i < plan.getEntries().size(); i++)
        if (plan.getEntries()[i].kind == EnergyPlan::Foreign)
            foreign.push_back(i);
    if (foreign.empty())
        return;
    if (allowNative && implsEvaluate) {
        for (int force : foreign) {
            parts.push_back({force});
            partGroups.push_back(forceGroups[force]);
        }
        return;
    }
    wholeGroups = plan.getGroups(EnergyPlan::Foreign) & groups;
    const int native = plan.getGroups(EnergyPlan::Native) & groups;
    mixed = (wholeGroups & native) != 0;
    if (mixed)
        wholeGroups |= native;
    if (mixed || !allowNative) {
        parts.push_back(foreign);
        partGroups.push_back(wholeGroups);
        return;
    }
    for (int force : foreign)
        addToParts(force, forceGroups[force]);
}

/**
 * Make a part of a Force, and of the parts that have a group in common with it.
 */
void ForeignForces::addToParts(int force, int itsGroups)
{
    vector<int> forces = {force};
    for (int i = parts.size() - 1; i >= 0; i--)
        if ((partGroups[i] & itsGroups) != 0) {
            forces.insert(forces.begin(), parts[i].begin(), parts[i].end());
            itsGroups |= partGroups[i];
            parts.erase(parts.begin() + i);
            partGroups.erase(partGroups.begin() + i);
        }
    parts.push_back(forces);
    partGroups.push_back(itsGroups);
}

double ForeignForces::computeAlone(const vector<int>& forces) const
{
    vector<ForceImpl*> chosen;
    for (int force : forces)
        chosen.push_back(impls[force]);
    ForceImplGuard guard(context, chosen);
    return context.calcForcesAndEnergy(false, true, groups);
}

double ForeignForces::computeEnergy(TrialSession& trials, const vector<int>& chosen) const
{
    int chosenGroups = 0;
    vector<int> forces;
    for (int part : chosen) {
        chosenGroups |= partGroups[part];
        forces.insert(forces.end(), parts[part].begin(), parts[part].end());
    }
    if (forces.empty())
        return 0;
    return wholeGroups == 0 ? computeAlone(forces) : trials.computeOtherEnergy(chosenGroups);
}

double ForeignForces::computeEnergy(TrialSession& trials) const
{
    vector<int> all(parts.size());
    iota(all.begin(), all.end(), 0);
    return computeEnergy(trials, all);
}

vector<int> ForeignForces::findImpossible(TrialSession& trials) const
{
    vector<int> all, impossible;
    for (const vector<int>& part : parts)
        for (int force : part) {
            all.push_back(force);
            const double energy =
                wholeGroups == 0 ? computeAlone({force}) : trials.computeOtherEnergy(forceGroups[force]);
            if (!NativeEnergy::isPossible(energy))
                impossible.push_back(force);
        }
    return impossible.empty() ? all : impossible; // infinite energies of different signs
}
