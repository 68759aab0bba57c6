#ifndef OPENMM_CHAINTREE_STATESEAL_H_
#define OPENMM_CHAINTREE_STATESEAL_H_

#include "openmm/internal/ContextImpl.h"
#include "openmm/serialization/SerializationNode.h"
#include <string>

namespace ChainTreePlugin {

/**
 * Write a checksum of a node and its children into it.
 */
void seal(OpenMM::SerializationNode& node);

/**
 * Throw an exception if a node has changed since seal().
 */
void checkSeal(const OpenMM::SerializationNode& node);

/**
 * Write checksums of the positions and velocities of a Context, and its box, parameters and time. OpenMM keeps these in
 * the same State, without a checksum.
 */
void writeTraits(OpenMM::SerializationNode& node, OpenMM::ContextImpl& context);

/**
 * Throw an exception if a comparison with the result of writeTraits() shows damage: the box or time differs, which
 * every State sets, or a single coordinate or velocity does.
 *
 * @param others  becomes a list of other differences, as "velocities"; the State may not have held these
 */
void checkTraits(const OpenMM::SerializationNode& node, OpenMM::ContextImpl& context, std::string& others);

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_STATESEAL_H_*/
