#ifndef OPENMM_CHAINTREE_BONDEXPRESSION_H_
#define OPENMM_CHAINTREE_BONDEXPRESSION_H_

#include "openmmchaintree/internal/ExpressionTranslator.h"
#include "openmmchaintree/internal/ForceTranslation.h"
#include "openmmchaintree/internal/TabulatedFunctions.h"
#include <string>
#include <vector>

namespace ChainTreePlugin {

/**
 * Copy a CustomCompoundBondForce or CustomCentroidBondForce without its bonds and groups. Steps copy Forces, so this
 * does not use OpenMM's XML, which shares memory among threads.
 */
template <class Force>
void copyBondExpression(const Force& from, Force& to)
{
    copyGlobals(from, to);
    to.setUsesPeriodicBoundaryConditions(from.usesPeriodicBoundaryConditions());
    for (int i = 0; i < from.getNumPerBondParameters(); i++)
        to.addPerBondParameter(from.getPerBondParameterName(i));
}

template <class Force>
void copyBonds(const Force& from, Force& to)
{
    std::vector<int> members;
    std::vector<double> values;
    for (int i = 0; i < from.getNumBonds(); i++) {
        from.getBondParameters(i, members, values);
        to.addBond(members, values);
    }
}

/**
 * Translate the energy function of such a Force. Returns an empty text, or else why OpenMM has to evaluate it.
 *
 * @param letter     begins the names of points: "p" for particles, "g" for groups
 * @param numPoints  the number of points of a bond
 */
template <class Force>
std::string translateBondExpression(const Force& force, const NativeForceKind::Parameters& parameters,
                                    const std::string& letter, int numPoints, EnergyTerms::TermSet& set)
{
    ExpressionTranslator translator(set);
    for (int i = 0; i < numPoints; i++) {
        const std::string number = std::to_string(i + 1);
        translator.addParticle(letter + number, {"x" + number, "y" + number, "z" + number}, i);
    }
    for (int i = 0; i < force.getNumTabulatedFunctions(); i++) {
        const std::string& name = force.getTabulatedFunctionName(i);
        translator.addForeignFunction(name, countArguments(force.getTabulatedFunction(i)),
                                      "the tabulated function " + name);
    }
    return translator.translateTerms(force, &Force::getPerBondParameterName, force.getNumPerBondParameters(),
                                     parameters);
}

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_BONDEXPRESSION_H_*/
