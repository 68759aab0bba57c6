#ifndef OPENMM_CHAINTREE_WARNINGS_H_
#define OPENMM_CHAINTREE_WARNINGS_H_

#include "windowsExportChainTree.h"
#include <string>

namespace ChainTreePlugin {

/**
 * Warn the user. OpenMM has no function for this. Warnings go to the standard error stream unless setWarningHandler()
 * sets another function.
 */
void warn(const std::string& message);

/**
 * Set the function that shows warnings. The Python module passes them to Python's warnings.
 *
 * @param handler  called with the message of each warning. It may throw an OpenMMException.
 */
OPENMM_EXPORT_CHAINTREE void setWarningHandler(void (*handler)(const std::string& message));

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_WARNINGS_H_*/
