#ifndef OPENMM_CHAINTREE_TABULATEDFUNCTIONS_H_
#define OPENMM_CHAINTREE_TABULATEDFUNCTIONS_H_

#include "lepton/CustomFunction.h"
#include "openmm/TabulatedFunction.h"
#include "openmmchaintree/internal/EnergyTerms.h"
#include <map>
#include <memory>
#include <string>

namespace ChainTreePlugin {

/**
 * Get how many arguments a tabulated function has.
 */
int countArguments(const OpenMM::TabulatedFunction& function);

/**
 * Make a copy periodic if the original is. Copy() does not copy this property.
 */
void restorePeriod(const OpenMM::TabulatedFunction& original, OpenMM::TabulatedFunction& copy);

/**
 * Copy the properties of all kinds of Forces, global parameters, derivatives and tables to a new Force. After the copy
 * constructor both Forces would own the same tables.
 */
template <class Force>
void copyGlobals(const Force& from, Force& to)
{
    to.setForceGroup(from.getForceGroup());
    to.setName(from.getName());
    for (int i = 0; i < from.getNumGlobalParameters(); i++)
        to.addGlobalParameter(from.getGlobalParameterName(i), from.getGlobalParameterDefaultValue(i));
    for (int i = 0; i < from.getNumEnergyParameterDerivatives(); i++)
        to.addEnergyParameterDerivative(from.getEnergyParameterDerivativeName(i));
    for (int i = 0; i < from.getNumTabulatedFunctions(); i++) {
        const OpenMM::TabulatedFunction& original = from.getTabulatedFunction(i);
        std::unique_ptr<OpenMM::TabulatedFunction> table(original.Copy());
        restorePeriod(original, *table);
        to.addTabulatedFunction(from.getTabulatedFunctionName(i), table.release());
    }
}

/**
 * Translate a tabulated function. Returns false if the library has no such tables.
 */
bool translateTable(const OpenMM::TabulatedFunction& function, EnergyTerms::TableFunction& table);

/**
 * Make the function that OpenMM's Reference platform evaluates.
 */
std::unique_ptr<Lepton::CustomFunction> createFunction(const OpenMM::TabulatedFunction& function);

/**
 * The tabulated functions of a Force in the form that the parser takes.
 */
class TabulatedFunctions {
public:
    template <class Force>
    explicit TabulatedFunctions(const Force& force)
    {
        for (int i = 0; i < force.getNumTabulatedFunctions(); i++)
            add(force.getTabulatedFunctionName(i), force.getTabulatedFunction(i));
    }
    const std::map<std::string, Lepton::CustomFunction*>& get() const
    {
        return pointers;
    }

private:
    void add(const std::string& name, const OpenMM::TabulatedFunction& function)
    {
        functions[name] = createFunction(function);
        pointers[name] = functions[name].get();
    }
    std::map<std::string, std::unique_ptr<Lepton::CustomFunction>> functions;
    std::map<std::string, Lepton::CustomFunction*> pointers;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_TABULATEDFUNCTIONS_H_*/
