#include "openmm/CustomTorsionForce.h"
#include "openmmchaintree/internal/ExpressionTranslator.h"
#include "openmmchaintree/internal/ForceTranslation.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static string translateCustomTorsions(const Force& owner, int index, const System&,
                                      const NativeForceKind::Parameters& parameters, EnergyTerms& terms)
{
    const CustomTorsionForce& force = dynamic_cast<const CustomTorsionForce&>(owner);
    EnergyTerms::TermSet set = createTermSet(index, ctExpressionTerm, 4, force.getNumPerTorsionParameters());
    ExpressionTranslator translator(set);
    translator.addInput("theta", {ctMeasureDihedral, {0, 1, 2, 3}});
    for (int i = 0; i < force.getNumPerTorsionParameters(); i++)
        translator.addParameter(force.getPerTorsionParameterName(i));
    for (int i = 0; i < force.getNumGlobalParameters(); i++)
        translator.addConstant(force.getGlobalParameterName(i), parameters.at(force.getGlobalParameterName(i)));
    const string reason = translator.translate(force.getEnergyFunction());
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

static const NativeForceKind KIND(typeid(CustomTorsionForce), translateCustomTorsions, copyForce<CustomTorsionForce>);
