#ifndef OPENMM_CHAINTREE_STATESEAL_H_
#define OPENMM_CHAINTREE_STATESEAL_H_

#include "openmm/internal/ContextImpl.h"
#include "openmm/serialization/SerializationNode.h"
#include <string>

namespace ChainTreePlugin {

/**
 * Write into a node by what one knows that nothing in or below it has changed.
 */
void seal(OpenMM::SerializationNode& node);

/**
 * Throw an exception if a node is not as it was when it was sealed.
 */
void checkSeal(const OpenMM::SerializationNode& node);

/**
 * Write what tells the positions, velocities, box, parameters and time of a Context from others. OpenMM keeps these in
 * the same State, without a checksum.
 */
void writeTraits(OpenMM::SerializationNode& node, OpenMM::ContextImpl& context);

/**
 * Throw an exception if what writeTraits() wrote shows that a Context was given damaged values: its box or time are
 * others, which every State sets, or one coordinate or velocity alone is, which is no State without positions.
 *
 * @param others  becomes what else differs, as "velocities and parameters"; the State may not have held these
 */
void checkTraits(const OpenMM::SerializationNode& node, OpenMM::ContextImpl& context, std::string& others);

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_STATESEAL_H_*/
