#ifndef OPENMM_CHAINTREE_SYSTEMCHECKS_H_
#define OPENMM_CHAINTREE_SYSTEMCHECKS_H_

#include "openmm/Integrator.h"
#include "openmm/internal/ContextImpl.h"
#include "openmm/System.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/internal/StericExclusionForceImpl.h"

namespace ChainTreePlugin {

/**
 * Get the one StericExclusionForce in a Context. It is an error if there is none, or more than one.
 */
StericExclusionForceImpl& findStericExclusionForce(OpenMM::ContextImpl& context);

/**
 * Throw an OpenMMException if a TorsionMonteCarloIntegrator cannot sample a System: it has a barostat, or a constraint
 * that a move could break.
 */
void checkSystem(const OpenMM::System& system, const LinkStructure& structure);

/**
 * Get whether an Integrator, or one of those in a CompoundIntegrator, begins its steps without a word to the Forces.
 */
bool hasSilentSteps(const OpenMM::Integrator& integrator);

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_SYSTEMCHECKS_H_*/
