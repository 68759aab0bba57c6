#ifndef OPENMM_CHAINTREE_ARGUMENTCHECKS_H_
#define OPENMM_CHAINTREE_ARGUMENTCHECKS_H_

#include <string>

namespace ChainTreePlugin {

/**
 * Throw an OpenMMException unless a value is a finite number and at least 0.
 *
 * @param value  the value to check
 * @param name   what the message calls it, the class it belongs to included
 */
void checkNotNegative(double value, const std::string& name);

/**
 * Throw an OpenMMException unless an index is one of 0 ... count-1.
 *
 * @param index  the index to check
 * @param count  how many things there are
 * @param what   what the index is one of, as "particle"
 * @param whose  who named it, the class it belongs to included
 */
void checkIndex(int index, int count, const std::string& what, const std::string& whose);

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_ARGUMENTCHECKS_H_*/
