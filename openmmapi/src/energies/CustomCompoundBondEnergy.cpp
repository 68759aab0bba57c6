#include "openmm/CustomCompoundBondForce.h"
#include "openmmchaintree/internal/ExpressionTranslator.h"
#include "openmmchaintree/internal/ForceTranslation.h"
#include "openmmchaintree/internal/TabulatedFunctions.h"
#include <memory>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Not by OpenMM's XML: its numbers share memory among all threads, and steps copy Forces.
 */
static Force* copyCustomCompoundBonds(const Force& force)
{
    const CustomCompoundBondForce& original = dynamic_cast<const CustomCompoundBondForce&>(force);
    unique_ptr<CustomCompoundBondForce> copy(
        new CustomCompoundBondForce(original.getNumParticlesPerBond(), original.getEnergyFunction()));
    copyGlobals(original, *copy);
    copy->setUsesPeriodicBoundaryConditions(original.usesPeriodicBoundaryConditions());
    for (int i = 0; i < original.getNumPerBondParameters(); i++)
        copy->addPerBondParameter(original.getPerBondParameterName(i));
    vector<int> particles;
    vector<double> parameters;
    for (int i = 0; i < original.getNumBonds(); i++) {
        original.getBondParameters(i, particles, parameters);
        copy->addBond(particles, parameters);
    }
    return copy.release();
}

static string translateCustomCompoundBonds(const Force& owner, int index, const System&,
                                           const NativeForceKind::Parameters& parameters, EnergyTerms& terms)
{
    const CustomCompoundBondForce& force = dynamic_cast<const CustomCompoundBondForce&>(owner);
    EnergyTerms::TermSet set =
        createTermSet(index, ctExpressionTerm, force.getNumParticlesPerBond(), force.getNumPerBondParameters());
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
