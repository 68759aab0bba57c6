#ifndef OPENMM_CHAINTREE_ARGUMENTCHECKS_H_
#define OPENMM_CHAINTREE_ARGUMENTCHECKS_H_

#include <string>
#include <vector>

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

/**
 * Throw an OpenMMException if a number appears twice in a list.
 *
 * @param values   the list
 * @param message  what the message says before the number
 */
void checkUnique(std::vector<int> values, const std::string& message);

/**
 * Throw an OpenMMException unless something that was saved can be read: its version is one of 1 ... newest.
 *
 * @param version  the version that was found
 * @param newest   the newest version that can be read
 * @param what     what was saved, as "the XML of a StericExclusionForce"
 */
void checkVersion(int version, int newest, const std::string& what);

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_ARGUMENTCHECKS_H_*/
