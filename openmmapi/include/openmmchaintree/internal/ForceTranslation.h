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
    typedef std::string Translator(const OpenMM::Force& force, int index, const Parameters& parameters,
                                   EnergyTerms& terms);
    NativeForceKind(const std::type_info& type, Translator& translate);
};

/**
 * Append the energy of a Force to the terms.
 *
 * @param system      the System of a Context
 * @param index       the index of the Force in it
 * @param parameters  the values of the Context's parameters
 * @param terms       what to append to
 * @return an empty text, or else one clause that says why OpenMM has to evaluate this Force; then the terms are as they
 *         were. This is no error, whatever the Force may be
 */
OPENMM_EXPORT_CHAINTREE std::string translateForce(const OpenMM::System& system, int index,
                                                   const NativeForceKind::Parameters& parameters, EnergyTerms& terms);

// What translators share.

/**
 * Make a set of terms without any.
 */
OPENMM_EXPORT_CHAINTREE EnergyTerms::TermSet createTermSet(int force, EnergyTerms::TermKind kind, int particlesPerTerm,
                                                           int parametersPerTerm);

/**
 * Append a term to a set.
 */
OPENMM_EXPORT_CHAINTREE void addTerm(EnergyTerms::TermSet& set, const std::vector<int>& particles,
                                     const std::vector<double>& parameters);

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_FORCETRANSLATION_H_*/
