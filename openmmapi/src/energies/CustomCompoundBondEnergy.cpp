#include "openmm/CustomCompoundBondForce.h"
#include "openmmchaintree/internal/BondExpression.h"
#include <memory>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static Force* copyCustomCompoundBonds(const CustomCompoundBondForce& original)
{
    unique_ptr<CustomCompoundBondForce> copy(
        new CustomCompoundBondForce(original.getNumParticlesPerBond(), original.getEnergyFunction()));
    copyBondExpression(original, *copy);
    copyBonds(original, *copy);
    return copy.release();
}

static string translateCustomCompoundBonds(const CustomCompoundBondForce& force,
                                           const NativeForceKind::Setting& setting, EnergyTerms& terms)
{
    EnergyTerms::TermSet set =
        createTermSet(setting.index, ctExpressionTerm, force.getNumParticlesPerBond(), force.getNumPerBondParameters());
    const string reason = translateBondExpression(force, setting.parameters, "p", force.getNumParticlesPerBond(), set);
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

static const NativeForceKind CUSTOM_COMPOUND_BONDS(translateCustomCompoundBonds, copyCustomCompoundBonds);
