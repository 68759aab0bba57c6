#include "openmm/CustomAngleForce.h"
#include "openmmchaintree/internal/ExpressionTranslator.h"
#include "openmmchaintree/internal/ForceTranslation.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static string translateCustomAngles(const Force& owner, int index, const System&,
                                    const NativeForceKind::Parameters& parameters, EnergyTerms& terms)
{
    const CustomAngleForce& force = dynamic_cast<const CustomAngleForce&>(owner);
    EnergyTerms::TermSet set = createTermSet(index, ctExpressionTerm, 3, force.getNumPerAngleParameters());
    ExpressionTranslator translator(set);
    translator.addInput("theta", {ctMeasureAngle, {0, 1, 2}});
    for (int i = 0; i < force.getNumPerAngleParameters(); i++)
        translator.addParameter(force.getPerAngleParameterName(i));
    for (int i = 0; i < force.getNumGlobalParameters(); i++)
        translator.addConstant(force.getGlobalParameterName(i), parameters.at(force.getGlobalParameterName(i)));
    const string reason = translator.translate(force.getEnergyFunction());
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

static const NativeForceKind KIND(typeid(CustomAngleForce), translateCustomAngles, copyForce<CustomAngleForce>);
