#ifndef OPENMM_CHAINTREE_FORCETRANSLATION_H_
#define OPENMM_CHAINTREE_FORCETRANSLATION_H_

#include "openmm/Force.h"
#include "openmm/System.h"
#include "openmmchaintree/internal/EnergyTerms.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <map>
#include <string>
#include <typeinfo>
#include <vector>

namespace ChainTreePlugin {

/**
 * A kind of Force that EnergyTerms can express. To create a NativeForceKind is to make it known, so each kind is a
 * constant in a file of its own, in src/energies.
 *
 * Only the very class counts: one that is derived from it may compute something else.
 */
class OPENMM_EXPORT_CHAINTREE NativeForceKind {
public:
    /** The values of the Context's parameters, by name. */
    typedef std::map<std::string, double> Parameters;
    /**
     * Appends the energy of a Force to the terms. Returns an empty text, or else one clause that says why it cannot; it
     * may have appended something then.
     */
    typedef std::string Translator(const OpenMM::Force& force, int index, const OpenMM::System& system,
                                   const Parameters& parameters, EnergyTerms& terms);
    /**
     * Copies a Force.
     */
    typedef OpenMM::Force* Copier(const OpenMM::Force& force);
    /** Some energies need a NonbondedForce that is translated before them. */
    enum Need { NeedsNothing, NeedsPairs };
    NativeForceKind(const std::type_info& type, Translator& translate, Copier& copy, Need need = NeedsNothing);
    /**
     * Get the kind of a Force, or NULL if there is none.
     */
    static const NativeForceKind* find(const OpenMM::Force& force);
    Translator& translate;
    Copier& copy;
    const bool needsPairs;
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
 * @param terms         what to append to
 * @return an empty text, or else one clause that says why OpenMM has to evaluate this Force; then the terms are as they
 *         were. This is no error, whatever the Force may be
 */
OPENMM_EXPORT_CHAINTREE std::string translateForce(const OpenMM::Force& force, int index, const OpenMM::System& system,
                                                   const NativeForceKind::Parameters& parameters, EnergyTerms& terms);

// What translators share.

/**
 * Copy a Force by the constructor of its class, which has to hold no pointers.
 */
template <class T>
OpenMM::Force* copyForce(const OpenMM::Force& force)
{
    return new T(dynamic_cast<const T&>(force));
}

/**
 * Make a set of terms without any.
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
