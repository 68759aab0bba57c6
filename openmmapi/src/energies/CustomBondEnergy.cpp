#include "openmm/CustomBondForce.h"
#include "openmmchaintree/internal/ExpressionTranslator.h"
#include "openmmchaintree/internal/ForceTranslation.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static string translateCustomBonds(const CustomBondForce& force, const NativeForceKind::Setting& setting,
                                   EnergyTerms& terms)
{
    EnergyTerms::TermSet set = createTermSet(setting.index, ctExpressionTerm, 2, force.getNumPerBondParameters());
    ExpressionTranslator translator(set);
    translator.addInput("r", {ctMeasureDistance, {0, 1}});
    const string reason = translator.translateTerms(force, &CustomBondForce::getPerBondParameterName,
                                                    set.parametersPerTerm, setting.parameters);
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

static const NativeForceKind CUSTOM_BONDS(translateCustomBonds);
