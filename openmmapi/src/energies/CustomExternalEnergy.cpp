#include "openmm/CustomExternalForce.h"
#include "openmmchaintree/internal/ExpressionTranslator.h"
#include "openmmchaintree/internal/ForceTranslation.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static string translateCustomExternalTerms(const CustomExternalForce& force, const NativeForceKind::Setting& setting,
                                           EnergyTerms& terms)
{
    EnergyTerms::TermSet set = createTermSet(setting.index, ctExpressionTerm, 1, force.getNumPerParticleParameters());
    ExpressionTranslator translator(set);
    translator.addInput("x", {ctMeasureX, {0}});
    translator.addInput("y", {ctMeasureY, {0}});
    translator.addInput("z", {ctMeasureZ, {0}});
    translator.addDistanceFunction("periodicdistance");
    const string reason = translator.translateTerms(force, &CustomExternalForce::getPerParticleParameterName,
                                                    set.parametersPerTerm, setting.parameters);
    if (!reason.empty())
        return reason;
    for (int i = 0; i < force.getNumParticles(); i++) {
        vector<int> p(1);
        vector<double> values;
        force.getParticleParameters(i, p[0], values);
        addTerm(set, p, values);
    }
    terms.termSets.push_back(set);
    return "";
}

static const NativeForceKind CUSTOM_EXTERNAL_TERMS(translateCustomExternalTerms);
