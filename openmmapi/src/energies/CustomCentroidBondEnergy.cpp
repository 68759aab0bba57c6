#include "openmm/CustomCentroidBondForce.h"
#include "openmm/internal/CustomCentroidBondForceImpl.h"
#include "openmmchaintree/internal/BondExpression.h"
#include <algorithm>
#include <memory>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static Force* copyCustomCentroidBonds(const CustomCentroidBondForce& original)
{
    unique_ptr<CustomCentroidBondForce> copy(
        new CustomCentroidBondForce(original.getNumGroupsPerBond(), original.getEnergyFunction()));
    copyBondExpression(original, *copy);
    vector<int> members;
    vector<double> weights;
    for (int i = 0; i < original.getNumGroups(); i++) {
        original.getGroupParameters(i, members, weights);
        copy->addGroup(members, weights);
    }
    copyBonds(original, *copy);
    return copy.release();
}

// Each trial that changes a bond reads all its particles. With more, this would take longer than the rest of a trial.

static const size_t MOST_PARTICLES_OF_GROUP = 1000;

/**
 * All groups are filled up to the size of the largest one by their first particle with weight 0.
 */
static string translateCustomCentroidBonds(const CustomCentroidBondForce& force,
                                           const NativeForceKind::Setting& setting, EnergyTerms& terms)
{
    const int numGroups = force.getNumGroupsPerBond();
    vector<vector<int>> groups(force.getNumGroups());
    vector<vector<double>> weights, unused(force.getNumGroups());
    CustomCentroidBondForceImpl::computeNormalizedWeights(force, setting.system, weights);
    size_t size = 1;
    for (int i = 0; i < force.getNumGroups(); i++) {
        force.getGroupParameters(i, groups[i], unused[i]);
        size = max(size, groups[i].size());
    }
    if (size > MOST_PARTICLES_OF_GROUP)
        return "one of its groups has more than " + to_string(MOST_PARTICLES_OF_GROUP) + " particles";
    for (int i = 0; i < force.getNumGroups(); i++) {
        groups[i].resize(size, groups[i].at(0));
        weights[i].resize(size, 0);
    }
    EnergyTerms::TermSet set = createTermSet(setting.index, ctCentroidTerm, numGroups * size,
                                             force.getNumPerBondParameters() + numGroups * size);
    set.groupsPerTerm = numGroups;
    const string reason = translateBondExpression(force, setting.parameters, "g", numGroups, set);
    if (!reason.empty())
        return reason;
    for (int i = 0; i < force.getNumBonds(); i++) {
        vector<int> groupsOfBond, particles;
        vector<double> values;
        force.getBondParameters(i, groupsOfBond, values);
        for (int group : groupsOfBond) {
            particles.insert(particles.end(), groups.at(group).begin(), groups[group].end());
            values.insert(values.end(), weights[group].begin(), weights[group].end());
        }
        addTerm(set, particles, values);
    }
    terms.termSets.push_back(set);
    return "";
}

static const NativeForceKind CUSTOM_CENTROID_BONDS(translateCustomCentroidBonds, copyCustomCentroidBonds);
