#include "openmm/CustomCompoundBondForce.h"
#include "openmm/serialization/XmlSerializer.h"
#include "openmmchaintree/internal/ExpressionTranslator.h"
#include "openmmchaintree/internal/ForceTranslation.h"
#include "openmmchaintree/internal/SerializationLock.h"
#include "openmmchaintree/internal/TabulatedFunctions.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Copies share their tables with the original, whose destructor deletes them; not so if they are read from XML.
 */
static Force* copyCustomCompoundBonds(const Force& force)
{
    SerializationLock lock;
    return XmlSerializer::clone<Force>(force);
}

static string translateCustomCompoundBonds(const Force& owner, int index, const NativeForceKind::Parameters& parameters,
                                           EnergyTerms& terms)
{
    const CustomCompoundBondForce& force = dynamic_cast<const CustomCompoundBondForce&>(owner);
    EnergyTerms::TermSet set =
        createTermSet(index, EnergyTerms::Expression, force.getNumParticlesPerBond(), force.getNumPerBondParameters());
    ExpressionTranslator translator(set);
    for (int i = 0; i < force.getNumParticlesPerBond(); i++) {
        const string number = to_string(i + 1);
        translator.addParticle("p" + number, {"x" + number, "y" + number, "z" + number}, i);
    }
    for (int i = 0; i < force.getNumTabulatedFunctions(); i++) {
        const string& name = force.getTabulatedFunctionName(i);
        translator.addForeignFunction(name, countArguments(force.getTabulatedFunction(i)),
                                      "the tabulated function " + name);
    }
    for (int i = 0; i < force.getNumPerBondParameters(); i++)
        translator.addParameter(force.getPerBondParameterName(i));
    for (int i = 0; i < force.getNumGlobalParameters(); i++)
        translator.addConstant(force.getGlobalParameterName(i), parameters.at(force.getGlobalParameterName(i)));
    const string reason = translator.translate(force.getEnergyFunction());
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
