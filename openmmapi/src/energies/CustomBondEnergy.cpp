#include "openmm/CustomBondForce.h"
#include "openmmchaintree/internal/ExpressionTranslator.h"
#include "openmmchaintree/internal/ForceTranslation.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static string translateCustomBonds(const Force& owner, int index, const System&,
                                   const NativeForceKind::Parameters& parameters, EnergyTerms& terms)
{
    const CustomBondForce& force = dynamic_cast<const CustomBondForce&>(owner);
    EnergyTerms::TermSet set = createTermSet(index, ctExpressionTerm, 2, force.getNumPerBondParameters());
    ExpressionTranslator translator(set);
    translator.addInput("r", {ctMeasureDistance, {0, 1}});
    for (int i = 0; i < force.getNumPerBondParameters(); i++)
        translator.addParameter(force.getPerBondParameterName(i));
    for (int i = 0; i < force.getNumGlobalParameters(); i++)
        translator.addConstant(force.getGlobalParameterName(i), parameters.at(force.getGlobalParameterName(i)));
    const string reason = translator.translate(force.getEnergyFunction());
    if (!reason.empty())
        return reason;
    for (int i = 0; i < force.getNumBonds(); i++) {
        vector<int> p(2);
        vector<double> values;
        force.getBondParameters(i, p[0], p[1], values);
        addTerm(set, p, values);
    }
    terms.termSets.push_back(set);
    return "";
}

static const NativeForceKind KIND(typeid(CustomBondForce), translateCustomBonds, copyForce<CustomBondForce>);
