#ifndef OPENMM_CHAINTREE_H_
#define OPENMM_CHAINTREE_H_

/**
 * Everything that a program needs to use openmm-chaintree.
 */

#include "openmmchaintree/LoopGrowth.h"
#include "openmmchaintree/StericExclusionForce.h"
#include "openmmchaintree/TorsionDensity.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"

#endif /*OPENMM_CHAINTREE_H_*/
