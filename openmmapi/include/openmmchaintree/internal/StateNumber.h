#ifndef OPENMM_CHAINTREE_STATENUMBER_H_
#define OPENMM_CHAINTREE_STATENUMBER_H_

#include "openmm/serialization/SerializationNode.h"
#include <string>

namespace ChainTreePlugin {

/**
 * Write a number so that it is read as the same one, in as few digits as this takes.
 */
std::string writeNumber(double value);

/**
 * Set a property of a State to a number, as SerializationNode::setDoubleProperty() does. That shares memory among all
 * threads, and OpenMM gets States while other threads of Python go on.
 */
OpenMM::SerializationNode& setNumber(OpenMM::SerializationNode& node, const std::string& name, double value);

/**
 * Get such a property, as SerializationNode::getDoubleProperty() does.
 */
double getNumber(const OpenMM::SerializationNode& node, const std::string& name);

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_STATENUMBER_H_*/
