#include "openmm/CustomExternalForce.h"
#include "openmmchaintree/internal/ExpressionTranslator.h"
#include "openmmchaintree/internal/ForceTranslation.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static string translateCustomExternalTerms(const Force& owner, int index, const System&,
                                           const NativeForceKind::Parameters& parameters, EnergyTerms& terms)
{
    const CustomExternalForce& force = dynamic_cast<const CustomExternalForce&>(owner);
    EnergyTerms::TermSet set = createTermSet(index, ctExpressionTerm, 1, force.getNumPerParticleParameters());
    ExpressionTranslator translator(set);
    translator.addInput("x", {ctMeasureX, {0}});
    translator.addInput("y", {ctMeasureY, {0}});
    translator.addInput("z", {ctMeasureZ, {0}});
    translator.addForeignFunction("periodicdistance", 6, "periodicdistance, and periodic boundary conditions with it");
    for (int i = 0; i < force.getNumPerParticleParameters(); i++)
        translator.addParameter(force.getPerParticleParameterName(i));
    for (int i = 0; i < force.getNumGlobalParameters(); i++)
        translator.addConstant(force.getGlobalParameterName(i), parameters.at(force.getGlobalParameterName(i)));
    const string reason = translator.translate(force.getEnergyFunction());
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

static const NativeForceKind KIND(typeid(CustomExternalForce), translateCustomExternalTerms,
                                  copyForce<CustomExternalForce>);
