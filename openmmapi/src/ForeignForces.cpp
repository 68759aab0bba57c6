#include "openmmchaintree/internal/ForeignForces.h"
#include "openmm/reference/ReferencePlatform.h"
#include "openmmchaintree/internal/NativeEnergy.h"
#include "openmmchaintree/internal/StericExclusionForceImpl.h"
#include <cstdlib>
#include <numeric>
#include <string>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Replaces the ForceImpls of a Context until the end of the scope.
 */
class ForceImplGuard {
public:
    ForceImplGuard(ContextImpl& context, vector<ForceImpl*>& impls) : context(context), others(impls)
    {
        context.getForceImpls().swap(others);
    }
    ~ForceImplGuard()
    {
        context.getForceImpls().swap(others);
    }

private:
    ContextImpl& context;
    vector<ForceImpl*>& others;
};

/**
 * Get whether an environment variable, for tests, has a value. CHAINTREE_FOREIGN=copies means that no platform lets
 * ForceImpls evaluate, and CHAINTREE_FOREIGN=groups that there are no copies either.
 */
static bool isSet(const string& value)
{
    const char* setting = getenv("CHAINTREE_FOREIGN");
    return setting != NULL && setting == value;
}

ForeignForces::ForeignForces(ContextImpl& context) :
    context(context), implsEvaluate(dynamic_cast<const ReferencePlatform*>(&context.getPlatform()) != NULL &&
                                    !isSet("copies") && !isSet("groups")),
    allowCopies(!isSet("groups")), impls(context.getForceImpls()), groups(0), mixed(false), reciprocalGroup(0)
{
}

void ForeignForces::setForces(const EnergyPlan& plan, int groups, bool allowNative, bool haveChanged)
{
    this->groups = groups;
    setReciprocal(plan, haveChanged);
    arrange(plan, allowNative, haveChanged);
    if (reciprocal && !mixed)
        parts.push_back({{plan.findEwaldForce()}, 0, -1, true});
}

void ForeignForces::setReciprocal(const EnergyPlan& plan, bool haveChanged)
{
    const int force = plan.findEwaldForce();
    if (force == -1) {
        reciprocal.reset();
        return;
    }
    reciprocalGroup = plan.getEntries()[force].reciprocalGroup;
    const vector<double>& charges = plan.getTerms().nonbonded[0].charges;
    if (!reciprocal || haveChanged || charges != reciprocal->getCharges())
        reciprocal.reset(
            new ReciprocalSpace(context, dynamic_cast<const NonbondedForce&>(plan.getCopy(force)), charges));
}

/**
 * Find the parts of foreign Forces.
 */
void ForeignForces::arrange(const EnergyPlan& plan, bool allowNative, bool haveChanged)
{
    parts.clear();
    forceGroups.clear();
    mixed = false;
    vector<int> foreign;
    for (size_t i = 0; i < plan.getEntries().size(); i++) {
        forceGroups.push_back(plan.getEntries()[i].groups & groups);
        if (plan.getEntries()[i].kind == EnergyPlan::Foreign)
            foreign.push_back(i);
    }
    if (allowNative && implsEvaluate)
        for (int force : foreign)
            parts.push_back({{force}, 0, -1});
    if (foreign.empty() || !parts.empty())
        return;
    if (!allowNative) {
        parts.push_back({foreign, plan.getGroups(EnergyPlan::Foreign) & groups, -1});
        return;
    }

    // Groups that cannot be evaluated as a whole: groups of native Forces, and of foreign Forces that are copied
    // because they share one of these.

    const int native = plan.getGroups(EnergyPlan::Native) & groups;
    int avoided = native;
    vector<int> shared, alone;
    size_t former;
    do {
        former = shared.size();
        shared.clear();
        alone.clear();
        for (int force : foreign)
            ((forceGroups[force] & avoided) != 0 ? shared : alone).push_back(force);
        for (int force : shared)
            avoided |= forceGroups[force];
    } while (shared.size() != former);
    mixed = !shared.empty() && !makeCopies(plan, shared, haveChanged);
    if (mixed) {
        parts.push_back({foreign, (plan.getGroups(EnergyPlan::Foreign) & groups) | native, -1});
        return;
    }
    for (int force : alone)
        addToParts(force, forceGroups[force]);
    for (size_t i = 0; i < shared.size(); i++)
        parts.push_back({{shared[i]}, 0, (int)i});
}

/**
 * Make a part of a Force and of all parts that share a group with it.
 */
void ForeignForces::addToParts(int force, int itsGroups)
{
    Part part = {{force}, itsGroups, -1};
    for (int i = parts.size() - 1; i >= 0; i--)
        if ((parts[i].groups & part.groups) != 0) {
            part.forces.insert(part.forces.begin(), parts[i].forces.begin(), parts[i].forces.end());
            part.groups |= parts[i].groups;
            parts.erase(parts.begin() + i);
        }
    parts.push_back(part);
}

/**
 * Make copies of Forces, unless they exist. Returns false if one of them cannot be copied.
 */
bool ForeignForces::makeCopies(const EnergyPlan& plan, const vector<int>& forces, bool haveChanged)
{
    if (!allowCopies || forces.size() > ForeignCopies::MOST_FORCES)
        return false;
    vector<const Force*> originals;
    for (int force : forces) {
        const bool isWhole = (plan.getEntries()[force].groups & ~groups) == 0; // no group of the Force is left out
        const Force* original = isWhole ? plan.findForce(force) : NULL;
        if (original == NULL || !ForeignCopies::canCopy(*original))
            return false;
        originals.push_back(original);
    }
    if (!copies || haveChanged || copied != forces)
        copies.reset(new ForeignCopies(context, originals));
    copied = forces;
    return true;
}

int ForeignForces::getWholeGroups() const
{
    int whole = 0;
    for (const Part& part : parts)
        whole |= part.groups;
    return whole;
}

double ForeignForces::computeAlone(TrialSession& trials, const vector<int>& forces) const
{
    // The StericExclusionForce adds no energy, but comes first and refuses other threads that use these ForceImpls
    // meanwhile. The list must outlive this call for their sake.

    vector<ForceImpl*>& chosen = chosenImpls[forces];
    if (chosen.empty()) {
        for (ForceImpl* impl : impls)
            if (dynamic_cast<StericExclusionForceImpl*>(impl) != NULL)
                chosen.push_back(impl);
        for (int force : forces)
            chosen.push_back(impls[force]);
    }
    ForceImplGuard guard(context, chosen);
    return trials.computeOtherEnergy(groups);
}

double ForeignForces::computeEnergy(TrialSession& trials, const vector<int>& chosen) const
{
    int chosenGroups = 0;
    bool hasReciprocal = false;
    vector<int> forces, chosenCopies;
    for (int index : chosen) {
        const Part& part = parts[index];
        chosenGroups |= part.groups;
        if (part.isReciprocal)
            hasReciprocal = true;
        else if (part.copy != -1)
            chosenCopies.push_back(part.copy);
        else if (part.groups == 0)
            forces.insert(forces.end(), part.forces.begin(), part.forces.end());
    }
    double energy = 0;
    if (chosenGroups != 0)
        energy += trials.computeOtherEnergy(chosenGroups);
    if (!forces.empty())
        energy += computeAlone(trials, forces);
    if (!chosenCopies.empty())
        energy += copies->computeEnergy(chosenCopies);
    if (hasReciprocal)
        energy += reciprocal->computeEnergy();
    return energy;
}

double ForeignForces::computeReciprocal(int groups) const
{
    return reciprocal && (groups & reciprocalGroup) != 0 ? reciprocal->computeEnergy() : 0;
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
    for (size_t i = 0; i < parts.size(); i++)
        for (int force : parts[i].forces) {
            const int itsGroups = parts[i].groups & forceGroups[force];
            all.push_back(force);
            const double energy =
                itsGroups != 0 ? trials.computeOtherEnergy(itsGroups) : computeEnergy(trials, {(int)i});
            if (!NativeEnergy::isPossible(energy))
                impossible.push_back(force);
        }
    return impossible.empty() ? all : impossible; // infinite energies of different signs
}
