#ifndef OPENMM_CHAINTREE_STATENUMBER_H_
#define OPENMM_CHAINTREE_STATENUMBER_H_

#include "openmm/serialization/SerializationNode.h"
#include <string>

namespace ChainTreePlugin {

/**
 * Write a number with the fewest digits from which it can be read exactly.
 */
std::string writeNumber(double value);

/**
 * Set a property of a State to a number, as SerializationNode::setDoubleProperty() does. That method shares memory
 * among all threads, and OpenMM gets States while other Python threads run.
 */
OpenMM::SerializationNode& setNumber(OpenMM::SerializationNode& node, const std::string& name, double value);

/**
 * Get such a property, as SerializationNode::getDoubleProperty() does.
 */
double getNumber(const OpenMM::SerializationNode& node, const std::string& name);

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_STATENUMBER_H_*/
