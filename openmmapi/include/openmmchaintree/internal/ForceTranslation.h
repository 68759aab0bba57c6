#ifndef OPENMM_CHAINTREE_FORCETRANSLATION_H_
#define OPENMM_CHAINTREE_FORCETRANSLATION_H_

#include "openmm/Force.h"
#include "openmm/System.h"
#include "openmmchaintree/internal/EnergyTerms.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <functional>
#include <map>
#include <string>
#include <typeinfo>
#include <vector>

namespace ChainTreePlugin {

/**
 * Copy a Force by the copy constructor of its class, which must hold no pointers.
 */
template <class T>
OpenMM::Force* copyForce(const T& force)
{
    return new T(force);
}

/**
 * A kind of Force that EnergyTerms can express. The constructor registers it: each kind is a constant in its own file
 * in src/energies.
 *
 * It does not include derived classes, which may compute something else.
 */
class OPENMM_EXPORT_CHAINTREE NativeForceKind {
public:
    /** The values of the Context's parameters, by name. */
    typedef std::map<std::string, double> Parameters;
    /** The index of a Force in its System, the System, the Context's parameters, and whether the scene is periodic. */
    class Setting {
    public:
        const int index;
        const OpenMM::System& system;
        const Parameters& parameters;
        const bool isPeriodic;
    };
    /** Some energies need a NonbondedForce, which is translated before them. */
    enum Need { NeedsNothing, NeedsPairs };
    /**
     * @param translate  appends the energy of a Force to the terms. It returns an empty text, or else one clause that
     *                   says why it cannot; then the terms may be incomplete.
     * @param copy       copies a Force
     */
    template <class T>
    explicit NativeForceKind(std::string translate(const T&, const Setting&, EnergyTerms&),
                             OpenMM::Force* copy(const T&) = copyForce<T>, Need need = NeedsNothing) :
        translate([=](const OpenMM::Force& force, const Setting& setting, EnergyTerms& terms) {
            return translate(dynamic_cast<const T&>(force), setting, terms);
        }),
        copy([=](const OpenMM::Force& force) {
            return copy(dynamic_cast<const T&>(force));
        }),
        needsPairs(need == NeedsPairs)
    {
        add(typeid(T));
    }
    /**
     * Get the kind of a Force, or NULL if there is none.
     */
    static const NativeForceKind* find(const OpenMM::Force& force);
    const std::function<std::string(const OpenMM::Force&, const Setting&, EnergyTerms&)> translate;
    const std::function<OpenMM::Force*(const OpenMM::Force&)> copy;
    const bool needsPairs;

private:
    void add(const std::type_info& type);
};

/**
 * Get the name of a Force's class, without its namespace.
 */
OPENMM_EXPORT_CHAINTREE std::string getClassName(const OpenMM::Force& force);

/**
 * Append the energy of a Force to the terms.
 *
 * @param force         a Force of a System
 * @param index         its index there
 * @param system        the System
 * @param parameters    the values of the Context's parameters
 * @param terms         the energy is appended to these
 * @param isPeriodic    whether the scene that evaluates them is periodic
 * @return an empty text, or else one clause that says why OpenMM has to evaluate this Force; then the terms do not
 *         change. This is no error for any Force
 */
OPENMM_EXPORT_CHAINTREE std::string translateForce(const OpenMM::Force& force, int index, const OpenMM::System& system,
                                                   const NativeForceKind::Parameters& parameters, EnergyTerms& terms,
                                                   bool isPeriodic = false);

// Shared by translators.

/**
 * Make an empty set of terms.
 */
OPENMM_EXPORT_CHAINTREE EnergyTerms::TermSet createTermSet(int force, ctTermKind kind, int particlesPerTerm,
                                                           int parametersPerTerm);

/**
 * Append a term to a set.
 */
OPENMM_EXPORT_CHAINTREE void addTerm(EnergyTerms::TermSet& set, const std::vector<int>& particles,
                                     const std::vector<double>& parameters);

/**
 * Check that generalized Born can be added to the terms. Returns an empty text, or else why it cannot.
 */
OPENMM_EXPORT_CHAINTREE std::string checkBornPartners(const EnergyTerms& terms);

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_FORCETRANSLATION_H_*/
