#ifndef OPENMM_CHAINTREE_SYSTEMCHECKS_H_
#define OPENMM_CHAINTREE_SYSTEMCHECKS_H_

#include "openmm/Integrator.h"
#include "openmm/internal/ContextImpl.h"
#include "openmm/System.h"
#include "openmm/Vec3.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/internal/StericExclusionForceImpl.h"
#include <utility>
#include <vector>

namespace ChainTreePlugin {

/**
 * Get the one StericExclusionForce in a Context. It is an error if there is none, or more than one.
 */
StericExclusionForceImpl& findStericExclusionForce(OpenMM::ContextImpl& context);

/**
 * Get the pairs of particles of constraints that are in different links and might move relative to each other.
 */
std::vector<std::pair<int, int>> findConstraintsBetweenLinks(const OpenMM::System& system,
                                                             const LinkStructure& structure);

/**
 * Throw an OpenMMException if a move could break a constraint.
 */
void checkConstraints(const OpenMM::System& system, const LinkStructure& structure);

bool isBarostat(const OpenMM::Force& force);

/**
 * Throw an OpenMMException if hard spheres cannot be sampled: a barostat ignores limits.
 */
void checkHardSpheres(const OpenMM::System& system);

/**
 * Throw an OpenMMException if volume moves are impossible: a barostat changes the volume, too, or the temperature is 0.
 */
void checkVolumeMoves(const OpenMM::System& system, double temperature);

/**
 * Get the largest cutoff of all Forces with periodic boundary conditions, as far as this library knows their classes;
 * 0 if there is none.
 */
double findLargestCutoff(const OpenMM::System& system);

/**
 * Warn if positions violate constraints by more than the rounding of a file in ångström with three decimals.
 */
void warnOfViolatedConstraints(const OpenMM::System& system, const std::vector<OpenMM::Vec3>& positions);

/**
 * Get an Integrator, or all Integrators of a CompoundIntegrator.
 */
std::vector<const OpenMM::Integrator*> findIntegrators(const OpenMM::Integrator& integrator);

/**
 * Get whether an Integrator, which is no CompoundIntegrator, is not a TorsionMonteCarloIntegrator.
 */
bool isOfDynamics(const OpenMM::Integrator& integrator);

/**
 * Get whether an Integrator, or one in a CompoundIntegrator, is not a TorsionMonteCarloIntegrator.
 */
bool hasDynamics(const OpenMM::Integrator& integrator);

/**
 * Get whether an Integrator, or one in a CompoundIntegrator, begins its steps without calling updateContextState().
 */
bool hasSilentSteps(const OpenMM::Integrator& integrator);

/**
 * Get whether a TorsionMonteCarloIntegrator, or one in a CompoundIntegrator, has a move that displaces particles within
 * their links.
 */
bool displacesParticles(const OpenMM::Integrator& integrator);

/**
 * Get whether a TorsionMonteCarloIntegrator, or one in a CompoundIntegrator, has the steric mode Off in its Context.
 */
bool hasSpheresOff(const OpenMM::Integrator& integrator);

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_SYSTEMCHECKS_H_*/
