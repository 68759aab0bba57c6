#ifndef OPENMM_CHAINTREE_VALUETRANSLATION_H_
#define OPENMM_CHAINTREE_VALUETRANSLATION_H_

#include "openmm/CustomGBForce.h"
#include "openmmchaintree/internal/EnergyTerms.h"
#include "openmmchaintree/internal/ForceTranslation.h"
#include <string>

namespace ChainTreePlugin {

/**
 * Translate a CustomGBForce without periodic cutoff and with any expressions. Returns an empty text, or else one clause
 * that says why it cannot be translated.
 */
std::string translateValues(const OpenMM::CustomGBForce& force, const NativeForceKind::Parameters& parameters,
                            EnergyTerms::ValueEnergy& energy);

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_VALUETRANSLATION_H_*/
