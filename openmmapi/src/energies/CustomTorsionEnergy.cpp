#include "openmm/CustomTorsionForce.h"
#include "openmmchaintree/internal/ExpressionTranslator.h"
#include "openmmchaintree/internal/ForceTranslation.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static string translateCustomTorsions(const CustomTorsionForce& force, const NativeForceKind::Setting& setting,
                                      EnergyTerms& terms)
{
    EnergyTerms::TermSet set = createTermSet(setting.index, ctExpressionTerm, 4, force.getNumPerTorsionParameters());
    ExpressionTranslator translator(set);
    translator.addInput("theta", {ctMeasureDihedral, {0, 1, 2, 3}});
    const string reason = translator.translateTerms(force, &CustomTorsionForce::getPerTorsionParameterName,
                                                    set.parametersPerTerm, setting.parameters);
    if (!reason.empty())
        return reason;
    for (int i = 0; i < force.getNumTorsions(); i++) {
        vector<int> p(4);
        vector<double> values;
        force.getTorsionParameters(i, p[0], p[1], p[2], p[3], values);
        addTerm(set, p, values);
    }
    terms.termSets.push_back(set);
    return "";
}

static const NativeForceKind CUSTOM_TORSIONS(translateCustomTorsions);
