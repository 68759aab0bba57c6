#ifndef OPENMM_CHAINTREE_ARGUMENTCHECKS_H_
#define OPENMM_CHAINTREE_ARGUMENTCHECKS_H_

#include <string>
#include <vector>

namespace ChainTreePlugin {

/**
 * Throw an OpenMMException unless a value is a finite number and at least 0.
 *
 * @param value  the value to check
 * @param name   its name in the message, with its class
 */
void checkNotNegative(double value, const std::string& name);

/**
 * Throw an OpenMMException unless an index is one of 0 ... count-1.
 *
 * @param index  the index to check
 * @param count  the number of indices
 * @param what   the kind of thing that it numbers, as "particle"
 * @param whose  who named it, with the class
 */
void checkIndex(int index, int count, const std::string& what, const std::string& whose);

/**
 * Throw an OpenMMException if a number appears twice in a list.
 *
 * @param values   the list
 * @param message  the text of the message before the number
 */
void checkUnique(std::vector<int> values, const std::string& message);

/**
 * Throw an OpenMMException unless the version of saved data is one of oldest ... newest.
 *
 * @param version  the version that was found
 * @param newest   the newest version that can be read
 * @param what     the name of the data, as "the XML of a StericExclusionForce"
 */
void checkVersion(int version, int newest, const std::string& what, int oldest = 1);

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_ARGUMENTCHECKS_H_*/
