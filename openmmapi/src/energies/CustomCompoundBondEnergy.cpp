#include "openmm/CustomCompoundBondForce.h"
#include "openmmchaintree/internal/BondExpression.h"
#include <memory>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static Force* copyCustomCompoundBonds(const Force& force)
{
    const CustomCompoundBondForce& original = dynamic_cast<const CustomCompoundBondForce&>(force);
    unique_ptr<CustomCompoundBondForce> copy(
        new CustomCompoundBondForce(original.getNumParticlesPerBond(), original.getEnergyFunction()));
    copyBondExpression(original, *copy);
    copyBonds(original, *copy);
    return copy.release();
}

static string translateCustomCompoundBonds(const Force& owner, int index, const System&,
                                           const NativeForceKind::Parameters& parameters, EnergyTerms& terms)
{
    const CustomCompoundBondForce& force = dynamic_cast<const CustomCompoundBondForce&>(owner);
    EnergyTerms::TermSet set =
        createTermSet(index, ctExpressionTerm, force.getNumParticlesPerBond(), force.getNumPerBondParameters());
    const string reason = translateBondExpression(force, parameters, "p", force.getNumParticlesPerBond(), set);
    if (!reason.empty())
        return reason;
    for (int i = 0; i < force.getNumBonds(); i++) {
        vector<int> p(force.getNumParticlesPerBond());
        vector<double> values;
        force.getBondParameters(i, p, values);
        addTerm(set, p, values);
    }
    terms.termSets.push_back(set);
    return "";
}

static const NativeForceKind KIND(typeid(CustomCompoundBondForce), translateCustomCompoundBonds,
                                  copyCustomCompoundBonds);
