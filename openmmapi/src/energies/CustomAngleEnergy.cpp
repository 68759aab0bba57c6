#include "openmm/CustomAngleForce.h"
#include "openmmchaintree/internal/ExpressionTranslator.h"
#include "openmmchaintree/internal/ForceTranslation.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static string translateCustomAngles(const CustomAngleForce& force, const NativeForceKind::Setting& setting,
                                    EnergyTerms& terms)
{
    EnergyTerms::TermSet set = createTermSet(setting.index, ctExpressionTerm, 3, force.getNumPerAngleParameters());
    ExpressionTranslator translator(set);
    translator.addInput("theta", {ctMeasureAngle, {0, 1, 2}});
    const string reason = translator.translateTerms(force, &CustomAngleForce::getPerAngleParameterName,
                                                    set.parametersPerTerm, setting.parameters);
    if (!reason.empty())
        return reason;
    for (int i = 0; i < force.getNumAngles(); i++) {
        vector<int> p(3);
        vector<double> values;
        force.getAngleParameters(i, p[0], p[1], p[2], values);
        addTerm(set, p, values);
    }
    terms.termSets.push_back(set);
    return "";
}

static const NativeForceKind CUSTOM_ANGLES(translateCustomAngles);
